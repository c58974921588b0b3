//! Dense meshes over time, groups of vertices and lists of frames: what is read, and what every mistake is
//! called.
use npyz::WriterBuilder;
use rhytid_core::{Error, Faces, Mesh, NoProgress, Result};
use rhytid_formats::animation;
use rhytid_formats::export::{Frame, Scene, StatedRecipe};
use rhytid_formats::mesh::{read_groups, write_obj};
use rhytid_formats::sequence::Sequence;
use rhytid_formats::tables::read_frames;
use std::path::Path;
use tempfile::TempDir;

/// Two triangles in a square.
fn square() -> Mesh {
    let mut faces = Faces::default();
    faces.push(&[0, 1, 2]);
    faces.push(&[0, 2, 3]);
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    Mesh { positions, faces, ..Mesh::default() }
}

/// Frame `i` is the square, `i` higher.
fn positions(i: usize) -> Vec<[f64; 3]> {
    square().positions.iter().map(|[x, y, z]| [*x, *y, z + i as f64]).collect()
}

fn open(path: &Path) -> Result<Sequence> {
    Sequence::open(path, &square(), Path::new("neutral.obj"), 0.01)
}

fn refused(path: &Path, words: &[&str]) {
    let error = open(path).and_then(|mut sequence| {
        let mut out = Vec::new();
        (0..sequence.frames()).try_for_each(|frame| sequence.positions(frame, &mut out))
    });
    let Err(Error::Input(sentence)) = error else { panic!("{error:?}") };
    assert!(words.iter().all(|word| sentence.sentence().contains(word)), "{words:?}: {sentence}");
}

fn frames_are(path: &Path, frames: usize) {
    let mut sequence = open(path).unwrap();
    assert_eq!(sequence.frames(), frames, "{}", path.display());
    let mut out = Vec::new();
    for frame in (0..frames).rev() {
        sequence.positions(frame, &mut out).unwrap();
        let expected: Vec<f32> = positions(frame).as_flattened().iter().map(|&x| x as f32).collect();
        assert_eq!(out, expected, "{}, frame {frame}", path.display());
    }
}

fn npy<T: npyz::Serialize + npyz::AutoSerialize + Copy>(path: &Path, shape: &[u64], numbers: &[T]) {
    let mut out = Vec::new();
    let mut writer =
        npyz::WriteOptions::new().default_dtype().shape(shape).writer(&mut out).begin_nd().unwrap();
    writer.extend(numbers.iter().copied()).unwrap();
    writer.finish().unwrap();
    std::fs::write(path, out).unwrap();
}

#[test]
fn frames_are_the_same_whatever_they_are_kept_in() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let all: Vec<f64> = (0..3).flat_map(|i| positions(i).concat()).collect();
    npy(&at("double.npy"), &[3, 4, 3], &all);
    npy(&at("single.npy"), &[3, 4, 3], &all.iter().map(|&x| x as f32).collect::<Vec<f32>>());
    frames_are(&at("double.npy"), 3);
    frames_are(&at("single.npy"), 3);

    // By name; what is no mesh does not matter.
    std::fs::create_dir(at("meshes")).unwrap();
    for i in [2, 0, 1] {
        let mesh = Mesh { positions: positions(i), ..square() };
        write_obj(&at(&format!("meshes/scan_{i}.obj")), &mesh).unwrap();
    }
    std::fs::write(at("meshes/notes.txt"), "three scans").unwrap();
    frames_are(&at("meshes"), 3);

    let mesh = square();
    let rest: Vec<[f32; 3]> = mesh.positions.iter().map(|x| x.map(|x| x as f32)).collect();
    let recipe = StatedRecipe::default();
    for name in ["face.usd", "face.glb"] {
        let corners = [[0, 1, 2], [3, 4, 5]];
        let scene = Scene {
            name: "square",
            rest: &rest,
            rest_normals: None,
            channels: &[],
            faces: &mesh.faces,
            triangle_corners: &corners,
            uvs: None,
            materials: None,
            head: None,
            metres_per_unit: 0.01,
            up_axis: rhytid_core::UpAxis::Y,
            frames: 3,
            rate: 24.0,
            first_time_code: 0.0,
            recipe: &recipe,
            further: &[],
        };
        let mut exporter = animation::create(&at(name), &scene, &Default::default()).unwrap();
        for i in 0..3 {
            let positions: Vec<f32> = positions(i).as_flattened().iter().map(|&x| x as f32).collect();
            exporter.frame(&Frame::new(&positions)).unwrap();
        }
        exporter.finish(&NoProgress).unwrap();
        frames_are(&at(name), 3);
        let other = Sequence::open(&at(name), &square(), Path::new("neutral.obj"), 0.001);
        let said = other.err().unwrap().to_string();
        assert!(said.contains("its unit is 0.01 m, but the face's is 0.001 m"), "{said}");
    }
}

/// What other programs write: a header of the second version, big-endian numbers, no blank, Python 2's long
/// numbers.
#[test]
fn arrays_of_other_writers_are_read() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let write = |name: &str, version: u8, header: &str, numbers: Vec<u8>| {
        let mut bytes = [b"\x93NUMPY", &[version, 0][..]].concat();
        let length = header.len() as u32;
        bytes.extend_from_slice(&length.to_le_bytes()[..if version == 1 { 2 } else { 4 }]);
        bytes.extend_from_slice(header.as_bytes());
        bytes.extend(numbers);
        std::fs::write(at(name), bytes).unwrap();
    };
    let all: Vec<f64> = (0..2).flat_map(|i| positions(i).concat()).collect();
    let big: Vec<u8> = all.iter().flat_map(|&x| (x as f32).to_be_bytes()).collect();
    let little: Vec<u8> = all.iter().flat_map(|x| x.to_le_bytes()).collect();
    let mut written = 0;
    for version in [1, 2, 3] {
        for header in [
            "{'descr':'>f4','shape':(2,4,3),'fortran_order':False}",
            "{\"shape\": (2L, 4L, 3L,), \"fortran_order\": False, \"descr\": \"<f8\", }  \n",
        ] {
            let name = format!("{written}.npy");
            let numbers = if header.contains(">f4") { big.clone() } else { little.clone() };
            write(&name, version, header, numbers);
            frames_are(&at(&name), 2);
            written += 1;
        }
    }
    write("f.npy", 1, "{'descr':'<f8','shape':(2,4,3),'fortran_order':True}", little.clone());
    refused(&at("f.npy"), &["f.npy", "shape [2, 4, 3] in Fortran's order, expected C order"]);
    write("huge.npy", 1, "{'descr':'<f8','shape':(18446744073709551615,4,3),'fortran_order':False}", little);
    refused(&at("huge.npy"), &["huge.npy", "is cut off"]);
    write("bare.npy", 1, "{'descr':'<f8','fortran_order':False}", Vec::new());
    refused(&at("bare.npy"), &["bare.npy", "its header has no shape"]);
}

#[test]
fn mistakes_in_sequences_are_named() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    npy(&at("flat.npy"), &[3, 12], &[0.0_f32; 36]);
    refused(&at("flat.npy"), &["flat.npy", "shape [3, 12]", "frames × 4 × 3"]);
    npy(&at("more.npy"), &[1, 5, 3], &[0.0_f32; 15]);
    refused(&at("more.npy"), &["shape [1, 5, 3]", "frames × 4 × 3"]);
    npy(&at("none.npy"), &[0, 4, 3], &[0.0_f32; 0]);
    refused(&at("none.npy"), &["shape [0, 4, 3]"]);
    npy(&at("whole.npy"), &[1, 4, 3], &[0_i32; 12]);
    refused(&at("whole.npy"), &["whole.npy", "expected float32 or float64"]);
    let mut bad = [0.0_f32; 24];
    bad[12 + 7] = f32::NAN;
    npy(&at("bad.npy"), &[2, 4, 3], &bad);
    refused(&at("bad.npy"), &["frame 1 at vertex 2"]);
    std::fs::write(at("cut.npy"), &std::fs::read(at("bad.npy")).unwrap()[..150]).unwrap();
    refused(&at("cut.npy"), &["cut.npy", "is cut off: 22 bytes follow its header"]);
    std::fs::write(at("head.npy"), &std::fs::read(at("bad.npy")).unwrap()[..100]).unwrap();
    refused(&at("head.npy"), &["head.npy", "no NumPy array that can be read"]);
    std::fs::write(at("text.npy"), "0 1 2").unwrap();
    refused(&at("text.npy"), &["text.npy", "no NumPy array that can be read"]);
    std::fs::create_dir(at("empty")).unwrap();
    refused(&at("empty"), &["empty", "has no mesh"]);
    std::fs::create_dir(at("other")).unwrap();
    let mut other = square();
    other.positions.push([0.0; 3]);
    write_obj(&at("other/a.obj"), &other).unwrap();
    refused(&at("other"), &["a.obj", "has 5 vertices, but neutral.obj has 4"]);
    std::fs::write(at("take.csv"), "time\n").unwrap();
    refused(&at("take.csv"), &["take.csv", "“csv”", ".npy, or from a folder of meshes"]);
    assert!(matches!(open(&at("missing.npy")), Err(Error::Io { .. })));
}

#[test]
fn groups_are_those_of_the_faces() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    write_obj(&at("plain.obj"), &square()).unwrap();
    let text = std::fs::read_to_string(at("plain.obj")).unwrap();
    let (vertices, faces) = text.split_at(text.find('f').unwrap());
    let [first, second] = faces.lines().collect::<Vec<_>>()[..] else { panic!("{faces}") };
    let read = |faces: String| {
        std::fs::write(at("groups.obj"), format!("{vertices}{faces}")).unwrap();
        read_groups(&square(), Path::new("neutral.obj"), &at("groups.obj"))
    };
    let found = read(format!("g lips\n{first}\ng brow_l brows\n{second}\n")).unwrap();
    let named = |name: &str, vertices: &[u32]| (name.to_owned(), vertices.to_vec());
    assert_eq!(found, [named("brow_l", &[0, 2, 3]), named("brows", &[0, 2, 3]), named("lips", &[0, 1, 2])]);
    // A group that comes again is continued. Faces before the first group are in none.
    let found = read(format!("{first}\ng a\n{second}\ng default\ng b\ng a\n")).unwrap();
    assert_eq!(found, [named("a", &[0, 2, 3])]);
    let said = read(format!("{first}\n{second}\n")).unwrap_err().to_string();
    assert!(said.contains("has no group"), "{said}");
    // The order of the faces does not matter.
    let found = read(format!("g a\n{second}\ng b\n{first}\n")).unwrap();
    assert_eq!(found, [named("a", &[0, 2, 3]), named("b", &[0, 1, 2])]);
    // Faces of two corners are left out, and groups stay with their faces.
    let found = read(format!("g a\nf 1 2\n{first}\ng b # c\nf 3\n{second}\n")).unwrap();
    assert_eq!(found, [named("a", &[0, 1, 2]), named("b", &[0, 2, 3])]);
    // Names in an old encoding stay apart.
    let text = [
        format!("{vertices}g ").as_bytes(),
        b"\xba\xc3",
        format!("\r{first}\rg ").as_bytes(),
        b"\xc4\xe3",
        format!("\r{second}").as_bytes(),
    ]
    .concat();
    std::fs::write(at("gbk.obj"), text).unwrap();
    let found = read_groups(&square(), Path::new("neutral.obj"), &at("gbk.obj")).unwrap();
    assert_eq!(found, [named("%BA%C3", &[0, 1, 2]), named("%C4%E3", &[0, 2, 3])]);
    let said = read(format!("g a\nf 1 2 4\n{second}\n")).unwrap_err().to_string();
    assert!(said.contains("face 1 joins the vertices 0 1 3"), "{said}");
    let said = read_groups(&square(), Path::new("neutral.obj"), &at("groups.ply")).unwrap_err().to_string();
    assert!(said.contains("groups are read from .obj"), "{said}");
}

#[test]
fn frames_are_listed_by_their_column() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("frames.csv");
    let read = |text: &str| {
        std::fs::write(&path, text).unwrap();
        read_frames(&path, 100)
    };
    assert_eq!(read("frame,seconds\n0,0.0\n99,3.3\n7,0.2\n").unwrap(), [0, 99, 7]);
    assert_eq!(read("name, frame\nsmile,5\n").unwrap(), [5]);
    for (text, words) in [
        ("seconds\n1\n", "line 1: the header is \"seconds\", expected a column “frame”"),
        ("frame\n3\n100\n", "line 3: the frame is \"100\", expected a whole number from 0 to 99"),
        ("frame\n-1\n", "the frame is \"-1\""),
        ("frame\nx\n", "the frame is \"x\""),
        ("frame\n", "has no frame"),
    ] {
        let said = read(text).unwrap_err().to_string();
        assert!(said.contains(words), "{text:?}: {said}");
    }
}
