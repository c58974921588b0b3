//! The images that a mesh's materials name.

use super::{Format, gltf, obj, recognise, text};
use rhytid_core::{Error, Reach, Result, folder_of, input_file, named_file};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The base colours of materials in `path`: of the materials of an OBJ or its MTL (`map_Kd`), or of a glTF.
/// Each is a material's name and its image as the file has it, a PNG or JPEG for the most part; materials
/// without one are left out. Files that are named have to be within `reach`. A file that is named many times
/// is read and kept once. Of several images of one material, the first counts.
///
/// # Errors
/// [`Error::Input`] if the file is none of these or names none; [`Error::Io`].
pub fn read_textures(path: &Path, reach: Reach) -> Result<Vec<(String, Arc<[u8]>)>> {
    let name = path.display().to_string();
    let bytes = || input_file::read(path, input_file::LARGEST_MESH_OR_TAKE);
    let found = match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("mtl") => of_mtl(path, &bytes()?, reach)?,
        _ => match Format::from_extension(path)? {
            Format::Obj => of_obj(path, &bytes()?, reach)?,
            Format::Gltf => {
                let folder = folder_of(path);
                gltf::textures(&bytes()?, &name, &|uri| gltf::read_beside(folder, uri, &name))?
            }
            Format::Ply | Format::Usd => Vec::new(),
        },
    };
    match found.is_empty() {
        true => Err(Error::empty(format!(
            "{name}: names no image for a material, expected map_Kd in the MTL of an OBJ, or a base colour texture in glTF; name the \
             image itself"
        ))),
        false => Ok(found),
    }
}

fn of_obj(path: &Path, bytes: &[u8], reach: Reach) -> Result<Vec<(String, Arc<[u8]>)>> {
    let mut images = OfMaterials::default();
    let mut read = HashSet::new();
    for (keyword, file) in statements(bytes) {
        if keyword == "mtllib" {
            let mtl = named_file(path, Path::new(&file), "mtllib", reach)?;
            if read.insert(mtl.clone()) {
                images.add_mtl(&mtl, &input_file::read(&mtl, input_file::LARGEST_MESH_OR_TAKE)?, reach)?;
            }
        }
    }
    Ok(images.found)
}

fn of_mtl(path: &Path, bytes: &[u8], reach: Reach) -> Result<Vec<(String, Arc<[u8]>)>> {
    let mut images = OfMaterials::default();
    images.add_mtl(path, bytes, reach)?;
    Ok(images.found)
}

/// The images of materials; each file is read once.
#[derive(Default)]
struct OfMaterials {
    found: Vec<(String, Arc<[u8]>)>,
    files: HashMap<PathBuf, Arc<[u8]>>,
    /// The materials that have an image.
    known: HashSet<String>,
}

impl OfMaterials {
    fn add_mtl(&mut self, path: &Path, bytes: &[u8], reach: Reach) -> Result<()> {
        recognise::expect_text(bytes, &path.display().to_string())?;
        let mut material = None;
        for (keyword, rest) in statements(bytes) {
            match (keyword.as_str(), &material) {
                ("newmtl", _) => material = Some(rest),
                ("map_Kd", Some(material)) if self.known.insert(String::clone(material)) => {
                    let file = without_options(&rest).replace('\\', "/");
                    let file = named_file(path, Path::new(&file), "map_Kd", reach)?;
                    let image = match self.files.get(&file) {
                        Some(image) => image.clone(),
                        None => {
                            let bytes = input_file::read(&file, input_file::LARGEST_MESH_OR_TAKE)?;
                            self.files.entry(file).or_insert(bytes.into()).clone()
                        }
                    };
                    self.found.push((String::clone(material), image));
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// The keyword of each statement and what is behind it: names may have blanks in them.
fn statements(bytes: &[u8]) -> impl Iterator<Item = (String, String)> {
    obj::statements(bytes).filter_map(|statement| {
        let keyword = text::name(obj::words(&statement.text).next()?);
        let rest = text::name(obj::rest_of_line(&statement.text));
        (!rest.is_empty()).then_some((keyword, rest))
    })
}

/// A map's file name: what is behind options such as `-s 1 1 1` and `-clamp on`.
fn without_options(text: &str) -> &str {
    let mut rest = text.trim_start();
    while rest.starts_with('-') {
        let (option, mut after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
        let is_vector = matches!(option, "-o" | "-s" | "-t");
        // Vectors may be shorter than three numbers.
        for i in 0..if is_vector {
            3
        } else if option == "-mm" {
            2
        } else {
            1
        } {
            after = after.trim_start();
            let (word, behind) = after.split_once(char::is_whitespace).unwrap_or((after, ""));
            if is_vector && i > 0 && word.parse::<f64>().is_err() {
                break;
            }
            after = behind;
        }
        rest = after.trim_start();
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_mtl_names_images_after_options_and_with_blanks() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("maps")).unwrap();
        std::fs::write(at("maps/the skin.png"), "skin").unwrap();
        std::fs::write(at("eye.jpg"), "eye").unwrap();
        std::fs::write(at("face.obj"), "mtllib the face.mtl\nv 0 0 0\n").unwrap();
        std::fs::write(
            at("the face.mtl"),
            "# made by hand\r\nnewmtl skin of a face\r\nKd 1 1 1\r\nmap_Kd -s 1 1 1 -clamp on maps\\the skin.png\r\n\
             newmtl grey\nKd 0.5 0.5 0.5\nnewmtl eye\nmap_Bump -bm 2 eye.jpg\nmap_Kd -o 0.5 eye.jpg # the iris\n",
        )
        .unwrap();
        let expected =
            [("skin of a face".to_owned(), b"skin"[..].into()), ("eye".to_owned(), b"eye"[..].into())];
        for file in ["face.obj", "the face.mtl"] {
            assert_eq!(read_textures(&at(file), Reach::Below).unwrap(), expected, "{file}");
        }
        // Named many times, it is read and kept once; the first image of a material counts.
        std::fs::write(
            at("many.mtl"),
            "newmtl a\nmap_Kd eye.jpg\nmap_Kd not-there.png\nnewmtl b\nmap_Kd ./eye.jpg\nnewmtl c\nmap_Kd eye.jpg\n",
        )
        .unwrap();
        let many = read_textures(&at("many.mtl"), Reach::Below).unwrap();
        assert_eq!(many.iter().map(|(name, _)| &**name).collect::<Vec<_>>(), ["a", "b", "c"]);
        assert!(Arc::ptr_eq(&many[0].1, &many[2].1));
        // Names in an old encoding stay apart, and lines may end with CR.
        std::fs::write(
            at("gbk.mtl"),
            b"newmtl \xba\xc3\rmap_Kd eye.jpg\rnewmtl \xc4\xe3\rmap_Kd \\ \r eye.jpg\r",
        )
        .unwrap();
        let found = read_textures(&at("gbk.mtl"), Reach::Below).unwrap();
        assert_eq!(found.iter().map(|(name, _)| &**name).collect::<Vec<_>>(), ["%BA%C3", "%C4%E3"]);
        std::fs::write(at("wide.mtl"), b"\xff\xfen\0e\0w\0").unwrap();
        let refused = read_textures(&at("wide.mtl"), Reach::Below).unwrap_err().to_string();
        assert!(refused.ends_with("wide.mtl: is UTF-16 text; save it as UTF-8"), "{refused}");
        std::fs::write(at("out.mtl"), "newmtl a\nmap_Kd ../secret.png\n").unwrap();
        let refused = read_textures(&at("out.mtl"), Reach::Below).unwrap_err().to_string();
        assert!(refused.contains("map_Kd names ../secret.png"), "{refused}");
        std::fs::write(at("none.mtl"), "newmtl a\nKd 1 1 1\n").unwrap();
        let refused = read_textures(&at("none.mtl"), Reach::Below).unwrap_err().to_string();
        assert!(refused.contains("names no image for a material"), "{refused}");
    }

    #[test]
    fn a_gltf_has_images_in_its_buffers_or_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("an eye.png"), "eye").unwrap();
        let document = r#"{"asset": {"version": "2.0"},
            "buffers": [{"byteLength": 4, "uri": "data:application/octet-stream;base64,c2tpbg=="}],
            "bufferViews": [{"buffer": 0, "byteLength": 4}],
            "images": [{"bufferView": 0, "mimeType": "image/png"}, {"uri": "an%20eye.png"}],
            "textures": [{"source": 1}, {"source": 0}],
            "materials": [{"name": "skin", "pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}},
                {"name": "grey"},
                {"name": "eye", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}},
                {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]}"#;
        std::fs::write(at("face.gltf"), document).unwrap();
        let expected = [("skin".to_owned(), b"skin"[..].into()), ("eye".to_owned(), b"eye"[..].into())];
        assert_eq!(read_textures(&at("face.gltf"), Reach::Below).unwrap(), expected);
        std::fs::write(at("face.gltf"), document.replace(r#""source": 0"#, r#""source": 7"#)).unwrap();
        let refused = read_textures(&at("face.gltf"), Reach::Below).unwrap_err().to_string();
        assert!(refused.contains("material skin"), "{refused}");
    }
}
