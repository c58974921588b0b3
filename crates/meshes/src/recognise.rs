//! What a file is by its first bytes or its extension, where that is not what the reader expects.

use super::read::Format;
use rhytid_core::{Error, Result};

/// What to do with a scene or mesh of another program.
const WAY_OUT: &str = "export the mesh as .glb, .obj, .ply or .usd: in Blender with File > Export > glTF 2.0, in \
                       Maya with File > Export Selection as OBJexport or USD Export, in Houdini with a ROP Geometry \
                       Output to .obj or a USD ROP";

/// The same for a format without an order of vertices.
const NO_ORDER: &str = "it has each triangle by itself and no order of vertices, which examples need, so export \
                        the original mesh as .glb, .obj, .ply or .usd: in Blender with File > Export > Wavefront, \
                        in Maya with File > Export Selection as OBJexport, in Houdini with a ROP Geometry Output \
                        to .obj";

/// The same for a scene of Blender.
const FROM_BLENDER: &str = "open it in Blender and export the mesh with File > Export > glTF 2.0 (.glb)";

/// The same for a scene of Maya.
const FROM_MAYA: &str =
    "open it in Maya and export the mesh with File > Export Selection as OBJexport or USD Export";

/// The same for a file of Houdini.
const FROM_HOUDINI: &str =
    "open it in Houdini and export the mesh with a ROP Geometry Output to .obj or a USD ROP to .usd";

const UNPACK: &str = "unpack it first and give the mesh inside";
const IMAGE: &str = "give the mesh, not its image";
const OTHER: &str = "give the mesh itself";

/// Extensions of files that are not read, with what they are and what to do.
const EXTENSIONS: [(&[&str], &str, &str); 14] = [
    (&["fbx"], "FBX, which is not read", WAY_OUT),
    (&["abc"], "Alembic, which is not read", WAY_OUT),
    (&["dae"], "Collada, which is not read", WAY_OUT),
    (&["stl"], "STL, which is not read", NO_ORDER),
    (&["blend", "blend1"], "a scene of Blender, which is not read", FROM_BLENDER),
    (&["ma", "mb"], "a scene of Maya, which is not read", FROM_MAYA),
    (&["hip", "hiplc", "hipnc", "bgeo", "geo"], "a file of Houdini, which is not read", FROM_HOUDINI),
    (
        &["3ds", "max", "c4d", "lwo", "lws", "ztl", "zpr", "zbr"],
        "a file of another program, which is not read",
        WAY_OUT,
    ),
    (
        &["off", "vtk", "vtp", "x3d", "wrl", "3mf", "dxf", "x", "3dm", "drc"],
        "a mesh in a format that is not read",
        WAY_OUT,
    ),
    (&["zip", "7z", "rar", "tar", "tgz"], "an archive", UNPACK),
    (&["gz", "bz2", "xz", "zst"], "a compressed file", UNPACK),
    (&["mtl"], "a list of materials", "give the .obj beside it"),
    (&["png", "jpg", "jpeg", "tif", "tiff", "exr", "tga", "bmp", "psd"], "an image", IMAGE),
    (&["html", "htm", "txt", "pdf", "md"], "a text or page", OTHER),
];

/// What a file with this extension is and what to do, if it is known and not read. The extension is in lower
/// case.
pub(super) fn of_extension(extension: &str) -> Option<String> {
    let (_, what, cure) = EXTENSIONS.iter().find(|(known, ..)| known.contains(&extension))?;
    Some(format!("is {what}; {cure}"))
}

/// Fails if the first bytes show that a file is something else than `format`.
///
/// # Errors
/// [`Error::Input`] says what the file is, and what to do.
pub(super) fn expect(format: Format, bytes: &[u8], name: &str) -> Result<()> {
    if bytes.is_empty() {
        return Err(Error::empty(format!("{name}: is empty; export or copy the file again")));
    }
    let (expected, own): (&str, &[What]) = match format {
        Format::Obj => ("OBJ", &[What::Obj]),
        Format::Ply => ("PLY", &[What::Ply]),
        Format::Gltf => ("glTF", &[What::Gltf]),
        Format::Usd => ("USD", &[What::Usd, What::Usdz]),
    };
    match what(bytes) {
        None => Ok(()),
        Some(found) if own.contains(&found) => Ok(()),
        Some(found) => Err(Error::unsupported_format(match found.own_extension() {
            Some((is, extension)) => {
                format!("{name}: is {is} by its first bytes, not {expected}; rename it to {extension}")
            }
            None => format!("{name}: {}", found.sentence()),
        })),
    }
}

/// Fails if the first bytes of a text file, as an MTL, show that it is no plain text.
///
/// # Errors
/// [`Error::Input`] says what the file is, and what to do.
pub(super) fn expect_text(bytes: &[u8], name: &str) -> Result<()> {
    match what(bytes) {
        None | Some(What::Obj | What::Materials) => Ok(()),
        Some(found) => Err(Error::unsupported_format(match found.own_extension() {
            Some((is, _)) => {
                format!("{name}: is {is} by its first bytes, not MTL; give the list of materials")
            }
            None => format!("{name}: {}", found.sentence()),
        })),
    }
}

/// What a file is by its first bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum What {
    Obj,
    Ply,
    Gltf,
    Usd,
    Usdz,
    Materials,
    /// What the file is, and what to do.
    Other(&'static str, &'static str),
}

impl What {
    /// The words for a format that is read, and its extension.
    fn own_extension(self) -> Option<(&'static str, &'static str)> {
        Some(match self {
            Self::Obj => ("an OBJ file", ".obj"),
            Self::Ply => ("a PLY file", ".ply"),
            Self::Gltf => ("a glTF file", ".glb"),
            Self::Usd => ("a USD file", ".usd"),
            Self::Usdz => ("a USD package", ".usdz"),
            Self::Materials | Self::Other(..) => return None,
        })
    }

    fn sentence(self) -> String {
        let (is, cure) = match self {
            Self::Other(is, cure) => (is, cure),
            _ => ("is a list of materials (MTL)", "give the .obj beside it"),
        };
        format!("{is}; {cure}")
    }
}

const DOWNLOAD: &str = "download the file itself again";
const UTF_8: &str = "save it as UTF-8";

/// First bytes of binary files and of texts with a fixed beginning.
const MAGIC: [(&[u8], What); 39] = [
    (b"glTF", What::Gltf),
    (b"PXR-USDC", What::Usd),
    (b"#usda", What::Usd),
    (b"\xff\xfe\0\0", What::Other("is UTF-32 text", UTF_8)),
    (b"\xff\xfe", What::Other("is UTF-16 text", UTF_8)),
    (b"\xfe\xff", What::Other("is UTF-16 text", UTF_8)),
    (b"\x1f\x8b", What::Other("is compressed with gzip", UNPACK)),
    (b"BZh", What::Other("is compressed with bzip2", UNPACK)),
    (b"\xfd7zXZ\0", What::Other("is compressed with xz", UNPACK)),
    (
        b"\x28\xb5\x2f\xfd",
        What::Other("is compressed with Zstandard, as scenes of Blender are", FROM_BLENDER),
    ),
    (b"PK\x03\x04", What::Other("is a zip archive", UNPACK)),
    (b"PK\x05\x06", What::Other("is an empty zip archive", DOWNLOAD)),
    (b"7z\xbc\xaf\x27\x1c", What::Other("is a 7z archive", UNPACK)),
    (b"Rar!\x1a", What::Other("is a RAR archive", UNPACK)),
    (
        b"version https://git-lfs",
        What::Other("is a Git LFS pointer, not the mesh itself", "run `git lfs pull`"),
    ),
    (
        b"version https://hawser",
        What::Other("is a Git LFS pointer, not the mesh itself", "run `git lfs pull`"),
    ),
    (b"/annex/objects/", What::Other("is a git-annex pointer, not the mesh itself", "run `git annex get`")),
    (b"Kaydara FBX Binary", What::Other("is an FBX file", WAY_OUT)),
    (b"; FBX", What::Other("is an FBX file", WAY_OUT)),
    (b"Ogawa", What::Other("is an Alembic file", WAY_OUT)),
    (b"\x89HDF\r\n\x1a\n", What::Other("is an HDF5 file, as old Alembic files are", WAY_OUT)),
    (b"BLENDER", What::Other("is a scene of Blender", FROM_BLENDER)),
    (b"//Maya", What::Other("is a scene of Maya", FROM_MAYA)),
    (b"FOR4", What::Other("is a scene of Maya", FROM_MAYA)),
    (b"FOR8", What::Other("is a scene of Maya", FROM_MAYA)),
    (b"\x7fNSJ", What::Other("is a file of Houdini", FROM_HOUDINI)),
    (b"PGEOMETRY", What::Other("is a file of Houdini", FROM_HOUDINI)),
    (b"xof ", What::Other("is a DirectX mesh", WAY_OUT)),
    (b"QC4DC4D6", What::Other("is a scene of Cinema 4D", WAY_OUT)),
    (b"DRACO", What::Other("is a Draco file", WAY_OUT)),
    (b"# vtk DataFile", What::Other("is a VTK file", WAY_OUT)),
    (b"\xd0\xcf\x11\xe0", What::Other("is a file of 3ds Max or Office", WAY_OUT)),
    (b"\x89PNG", What::Other("is a PNG image", IMAGE)),
    (b"\xff\xd8\xff", What::Other("is a JPEG image", IMAGE)),
    (b"II*\0", What::Other("is a TIFF image", IMAGE)),
    (b"MM\0*", What::Other("is a TIFF image", IMAGE)),
    (b"v/1\x01", What::Other("is an OpenEXR image", IMAGE)),
    (b"%PDF", What::Other("is a PDF document", OTHER)),
    (b"OFF", What::Other("is an OFF mesh", WAY_OUT)),
];

/// What the first bytes show. `None` where they show nothing.
fn what(bytes: &[u8]) -> Option<What> {
    if let Some((_, what)) = MAGIC.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        let is_package = bytes.starts_with(b"PK") && names_usd(bytes);
        return Some(if is_package { What::Usdz } else { *what });
    }
    if !bytes.is_empty() && bytes.iter().all(|&byte| byte == 0) {
        return Some(What::Other("has nothing but zeros, as of a copy that failed", "copy the file again"));
    }
    if is_utf_16(bytes) {
        return Some(What::Other("is UTF-16 text", UTF_8));
    }
    of_text(bytes).or_else(|| is_binary_stl(bytes).then_some(STL))
}

const STL: What = What::Other("is an STL file", NO_ORDER);

/// Whether the first file of a zip archive is USD, as in a USDZ package.
fn names_usd(zip: &[u8]) -> bool {
    let length = zip.get(26..28).map_or(0, |l| usize::from(u16::from_le_bytes([l[0], l[1]])));
    let name = zip.get(30..30 + length).unwrap_or_default();
    [&b".usd"[..], b".usda", b".usdc"].iter().any(|ending| name.ends_with(ending))
}

/// Whether every other byte at the beginning is zero, as in English text without a byte order mark.
fn is_utf_16(bytes: &[u8]) -> bool {
    let begin = &bytes[..bytes.len().min(64)];
    let is_text = |pair: &[u8], text: usize| pair[text].is_ascii() && pair[text] != 0 && pair[1 - text] == 0;
    let pairs = || begin.chunks_exact(2);
    begin.len() >= 8 && (pairs().all(|pair| is_text(pair, 0)) || pairs().all(|pair| is_text(pair, 1)))
}

/// What a text is by its first line that is no comment of OBJ.
fn of_text(bytes: &[u8]) -> Option<What> {
    let begin = &bytes[..bytes.len().min(4096)];
    let begin = begin.strip_prefix(b"\xef\xbb\xbf").unwrap_or(begin).trim_ascii_start();
    let lower = begin.to_ascii_lowercase();
    let has = |part: &[u8]| lower.windows(part.len()).any(|window| window == part);
    match lower.first()? {
        b'{' => {
            let keys: [&[u8]; 5] =
                [b"\"asset\"", b"\"accessors\"", b"\"buffers\"", b"\"meshes\"", b"\"nodes\""];
            return keys.iter().any(|key| has(key)).then_some(What::Gltf);
        }
        b'<' if has(b"<collada") => return Some(What::Other("is a Collada file", WAY_OUT)),
        b'<' if has(b"<html") || has(b"<!doctype html") => {
            return Some(What::Other("is an HTML page, as of a download that failed", DOWNLOAD));
        }
        b'<' => return Some(What::Other("is XML text", OTHER)),
        _ => {}
    }
    let mut lines = lower.split(|byte| matches!(byte, b'\n' | b'\r')).map(<[u8]>::trim_ascii);
    let first = lines.find(|line| !line.is_empty() && line[0] != b'#')?;
    let mut words = first.split(u8::is_ascii_whitespace);
    match words.next()? {
        b"ply" if first.len() == 3 => Some(What::Ply),
        b"solid" if has(b"facet") => Some(STL),
        b"newmtl" => Some(What::Materials),
        b"v" | b"vn" | b"vt" | b"f" | b"o" | b"g" | b"s" | b"mtllib" | b"usemtl"
            if words.next().is_some() =>
        {
            Some(What::Obj)
        }
        _ => None,
    }
}

/// Whether a file has exactly the size of a binary STL with the number of triangles that it announces.
fn is_binary_stl(bytes: &[u8]) -> bool {
    let count = bytes.get(80..84).map(|n| u64::from(u32::from_le_bytes([n[0], n[1], n[2], n[3]])));
    count.is_some_and(|count| count > 0 && bytes.len() as u64 == 84 + 50 * count)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(format: Format, bytes: &[u8]) -> String {
        expect(format, bytes, "face").map_or_else(|error| error.to_string(), |()| String::new())
    }

    #[test]
    fn every_beginning_is_found_by_itself() {
        for (magic, what) in MAGIC {
            assert_eq!(super::what(magic), Some(what), "{}", String::from_utf8_lossy(magic));
        }
    }

    #[test]
    fn own_files_pass() {
        for (format, bytes) in [
            (Format::Obj, &b"# Blender\nmtllib a.mtl\no face\n"[..]),
            (Format::Obj, b"\xef\xbb\xbfv 0 0 0\n"),
            (Format::Obj, b"# only a comment"),
            (Format::Obj, b"\r\n\r\n   vertex"),
            (Format::Ply, b"ply\r\nformat ascii 1.0\r\n"),
            (Format::Ply, b"ply\rformat ascii 1.0\r"),
            (Format::Gltf, b"glTF\x02\0\0\0"),
            (Format::Gltf, b" \n{\"asset\": {}}"),
        ] {
            assert_eq!(said(format, bytes), "", "{}", String::from_utf8_lossy(bytes));
        }
    }

    #[test]
    fn what_is_read_under_another_name_is_to_be_renamed() {
        for (format, bytes, words) in [
            (
                Format::Obj,
                &b"ply\nformat"[..],
                "is a PLY file by its first bytes, not OBJ; rename it to .ply",
            ),
            (Format::Ply, b"# a\nv 0 0 0\n", "is an OBJ file by its first bytes, not PLY; rename it to .obj"),
            (Format::Ply, b"glTF\x02", "is a glTF file by its first bytes, not PLY; rename it to .glb"),
            (Format::Obj, b"#usda 1.0\n", "is a USD file by its first bytes, not OBJ; rename it to .usd"),
            (Format::Gltf, b"PXR-USDC", "rename it to .usd"),
        ] {
            assert!(said(format, bytes).contains(words), "{}", said(format, bytes));
        }
        let mut package = b"PK\x03\x04".to_vec();
        package.resize(26, 0);
        package.extend(b"\x09\0\0\0face.usdcPXR");
        assert!(
            said(Format::Obj, &package).contains("rename it to .usdz"),
            "{}",
            said(Format::Obj, &package)
        );
    }

    #[test]
    fn what_is_no_mesh_is_named_with_the_cure() {
        let utf_16: Vec<u8> = "v 0 0 0\nv 1 0 0\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = "v 0 0 0\nv 1 0 0\n".encode_utf16().flat_map(u16::to_be_bytes).collect();
        let mut stl = vec![b'x'; 80];
        stl.extend(2_u32.to_le_bytes());
        stl.resize(184, 7);
        for (bytes, words) in [
            (&b""[..], ["is empty", "again"]),
            (&[0; 500], ["nothing but zeros", "copy the file again"]),
            (&utf_16, ["UTF-16", "save it as UTF-8"]),
            (&big, ["UTF-16", "save it as UTF-8"]),
            (b"\x1f\x8b\x08\0", ["gzip", "unpack it first"]),
            (b"version https://git-lfs.github.com/spec/v1\n", ["Git LFS pointer", "git lfs pull"]),
            (b"\n <!DOCTYPE HTML>\n<html>", ["HTML page", "download the file itself again"]),
            (b"<?xml version=\"1.0\"?>\n<COLLADA xmlns", ["Collada", "Blender"]),
            (b"solid cube\n facet normal 0 0 1\n", ["STL", "no order of vertices"]),
            (&stl, ["STL", "no order of vertices"]),
            (b"Kaydara FBX Binary  \0\x1a\0", ["FBX", "Maya"]),
            (b"; FBX 7.3.0 project file\n", ["FBX", "Houdini"]),
            (b"newmtl skin\nKd 1 1 1\n", ["MTL", ".obj beside it"]),
            (b"\x89PNG\r\n\x1a\n", ["PNG", "not its image"]),
        ] {
            let said = said(Format::Obj, bytes);
            assert!(words.iter().all(|word| said.contains(word)), "{said}");
            assert!(said.len() < 400 && !said.contains('\n'), "{said}");
        }
    }

    #[test]
    fn extensions_have_their_way_out() {
        for (extensions, _, _) in EXTENSIONS {
            for extension in extensions {
                let path = format!("face.{}", extension.to_uppercase());
                let error = Format::from_extension(path.as_ref()).unwrap_err().to_string();
                assert!(error.starts_with(&format!("{path}: is ")), "{error}");
            }
        }
        let said = of_extension("fbx").unwrap();
        assert!(["FBX", "Blender", "Maya", "Houdini"].iter().all(|word| said.contains(word)), "{said}");
        assert_eq!(of_extension("face"), None);
    }
}
