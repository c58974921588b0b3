use super::support::{corner_uvs, decode_with_warnings, polygons, refused};
use proptest::prelude::*;
use rhytid_core::Mesh;
use rhytid_formats::mesh::{Format, decode};

fn read(bytes: &[u8]) -> Mesh {
    decode(bytes, Format::Ply, "face").unwrap()
}

fn error(text: &str) -> String {
    refused(text.as_bytes(), Format::Ply)
}

const HEADER: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
                      property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";
const BODY: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 0 2 3\n";

#[test]
fn reads_ascii() {
    let mesh = read(format!("{HEADER}{BODY}").as_bytes());
    assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(polygons(&mesh), [vec![0, 1, 2, 3], vec![0, 2, 3]]);
    assert_eq!(mesh.uvs, None);
    // Line ends, blanks, odd numbers and what follows the last element do not matter.
    let loose = format!("{HEADER}{}", BODY.replace("1 1 0\n", " 1.  +1.0e0\t.0 \n\n")).replace('\n', "\r\n");
    assert_eq!(read(format!("{loose}more").as_bytes()), mesh);
}

#[test]
fn spellings_of_old_exporters_are_read() {
    let mesh = read(format!("{HEADER}{BODY}").as_bytes());
    let upper = HEADER.replacen("ply", "PLY", 1);
    assert_eq!(read(format!("{upper}{BODY}").as_bytes()), mesh);
    let remark = HEADER.replacen("1.0\n", "1.0\nCreated by Blender3D 247, source file:\n", 1);
    let text = format!("{remark}{BODY}");
    let (found, warnings) = decode_with_warnings(text.as_bytes(), Format::Ply, "face");
    assert_eq!(found, mesh);
    assert_eq!(warnings.len(), 1);
    assert!(
        warnings[0].contains("face, line 3: this line")
            && warnings[0].contains("write \"comment\" before it")
    );
    // Behind the first element, such a line may be a damaged property.
    let late = HEADER.replacen("property float y", "propert float y", 1);
    assert!(error(&format!("{late}{BODY}")).contains("face, line 5: found \"propert float y\""));
}

#[test]
fn reads_what_plyfile_wrote() {
    for (name, bytes) in [
        ("ascii", &include_bytes!("data/plyfile-ascii.ply")[..]),
        ("big endian", include_bytes!("data/plyfile-big-endian.ply")),
        ("little endian", include_bytes!("data/plyfile-little-endian.ply")),
    ] {
        let mesh = read(bytes);
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [1.0, 1.0, 0.0], [0.0, 1.0, 0.3], [2.0, 2.0, 2.0]];
        assert_eq!(mesh.positions, positions, "{name}");
        assert_eq!(polygons(&mesh), [vec![0, 1, 2, 3], vec![3, 2, 4]], "{name}");
        // Those of the corners are preferred to those of the vertices.
        let uvs: Vec<[f32; 2]> = [0.0, 0.25, 0.5, 0.75].iter().map(|&u| [u, u + 0.125]).collect();
        let uvs = [uvs, vec![[0.0, 0.25], [0.5, 0.75], [1.0, 1.25]]].concat();
        assert_eq!(corner_uvs(&mesh), uvs, "{name}");
        assert_eq!(mesh.uvs.unwrap().corners, Some((0..7).collect()), "{name}");
    }
}

#[test]
fn reads_what_trimesh_wrote() {
    let mesh = read(include_bytes!("data/trimesh.ply"));
    assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.25], [1.0, 1.0, 0.0], [0.0, 1.0, -0.5]]);
    assert_eq!(polygons(&mesh), [vec![0, 1, 2], vec![0, 2, 3]]);
    let uvs = mesh.uvs.unwrap();
    assert_eq!(uvs.values, [[0.0, 0.0], [1.0, 0.0], [1.0, 0.75], [0.0, 1.0]]);
    assert_eq!(uvs.corners, None);
}

#[test]
fn every_name_of_uvs_is_known() {
    for [u, v] in [
        ["u", "v"],
        ["s", "t"],
        ["texture_u", "texture_v"],
        ["texture_s", "texture_t"],
        ["tu", "tv"],
        ["texcoord_u", "texcoord_v"],
        ["texcoord_s", "texcoord_t"],
        ["tex_u", "tex_v"],
        ["U", "V"],
    ] {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float {v}\nproperty int x\nproperty char y\n\
             property double z\nproperty float {u}\nelement face 1\nproperty list int uint vertex_index\n\
             end_header\n.5 1 2 3 .25\n1 4 5 6 0\n0 7 8 9 1\n3 0 1 2\n"
        );
        let mesh = read(text.as_bytes());
        assert_eq!(mesh.positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]);
        assert_eq!(mesh.uvs.unwrap().values, [[0.25, 0.5], [0.0, 1.0], [1.0, 0.0]]);
    }
}

/// [`HEADER`] with a list of faces.
fn with_list(name: &str) -> String {
    HEADER.replace("end_header", &format!("property list uchar float {name}\nend_header"))
}

/// Reads a file and gives its one warning.
fn warned(text: &str) -> (Mesh, String) {
    let (mesh, warnings) = decode_with_warnings(text.as_bytes(), Format::Ply, "face");
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    (mesh, warnings[0].clone())
}

const WITH_UVS: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 8 0 0 1 0 1 1 0 1\n3 0 2 3 6 0 0 1 1 .5 1\n";

#[test]
fn every_list_of_uvs_is_known() {
    for name in ["texcoord", "texcoords", "t", "uv", "st"] {
        let mesh = read(format!("{}{WITH_UVS}", with_list(name)).as_bytes());
        let expected = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [1.0, 1.0], [0.5, 1.0]];
        assert_eq!(corner_uvs(&mesh), expected, "{name}");
    }
    let (mesh, warning) = warned(&format!("{}{WITH_UVS}", with_list("uvset0")));
    assert_eq!(mesh.uvs, None);
    assert!(warning.contains("\"uvset0\"") && warning.contains("rename them"), "{warning}");
}

#[test]
fn corner_uvs_survive_where_some_faces_have_none() {
    let none = [0.0, 0.0];
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let text = format!("{}{}", with_list("texcoord"), WITH_UVS.replace("6 0 0 1 1 .5 1", "0"));
    let (mesh, warning) = warned(&text);
    assert_eq!(corner_uvs(&mesh), [&square[..], &[none; 3]].concat());
    assert!(warning.contains("3 of 7 face corners have no usable texture coordinates"), "{warning}");
    // One that is no number.
    let text = format!("{}{}", with_list("texcoord"), WITH_UVS.replace("1 .5 1", "1 nan 1"));
    let (mesh, warning) = warned(&text);
    assert_eq!(corner_uvs(&mesh), [&square[..], &[none, [1.0, 1.0], none]].concat());
    assert!(warning.contains("1 of 7") && warning.contains("not a number"), "{warning}");
    // Of a vertex.
    let text = HEADER.replace("element face", "property float s\nproperty float t\nelement face");
    let body = "0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 -nan 1\n4 0 1 2 3\n3 0 2 3\n";
    let (mesh, warning) = warned(&format!("{text}{body}"));
    assert_eq!(mesh.uvs.unwrap().values, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], none]);
    assert!(warning.contains("2 of 7"), "{warning}");
}

#[test]
fn lines_of_a_header_end_as_on_any_system() {
    let text = format!("{HEADER}{BODY}");
    let expected = read(text.as_bytes());
    for end in ["\r", "\r\n", "\r\r\n"] {
        assert_eq!(read(text.replace('\n', end).as_bytes()), expected, "{end:?}");
    }
    let mixed = text.replace("end_header\n", "end_header\r").replace("1.0\n", "1.0\r\n");
    assert_eq!(read(mixed.as_bytes()), expected);
    let loose = text.replace("property float", " property\t float ").replace("vertex 4", " vertex  4");
    assert_eq!(read(format!("\u{feff}{loose}").as_bytes()), expected);
    let told = text.replace("element face", "comment element face 7\nobj_info a b\ncomment\nelement face");
    assert_eq!(read(told.as_bytes()), expected);
    // A binary file whose first byte is that of LF.
    for end in ["\n", "\r", "\r\n"] {
        let header =
            HEADER.replace("ascii", "binary_little_endian").replace("face 2", "face 1").replace('\n', end);
        let mut bytes = header.into_bytes();
        bytes.extend(*b"\x0a\0\0\0");
        bytes.extend([0; 44]);
        bytes.extend(*b"\x03\0\0\0\0\x01\0\0\0\x02\0\0\0");
        let mesh = read(&bytes);
        assert_eq!(mesh.positions[0][0], f64::from(f32::from_bits(10)), "{end:?}");
        assert_eq!(polygons(&mesh), [vec![0, 1, 2]]);
    }
}

/// As trimesh and Blender do.
#[test]
fn numbers_that_the_header_does_not_announce_are_skipped() {
    let text = format!("{HEADER}{}", BODY.replace("0 2 3\n", "0 2 3 9 1 1 1\n"));
    let (mesh, warning) = warned(&text);
    assert_eq!(mesh, read(format!("{HEADER}{BODY}").as_bytes()));
    assert!(
        warning.contains("1 lines have more numbers") && warning.contains("line 15 (face 2 of 2)"),
        "{warning}"
    );
    // All in one line.
    let message = error(&format!("{HEADER}{}", BODY.replace('\n', " ")));
    assert!(message.contains("ends after 1 of 4 vertices, but line 10 has more numbers"), "{message}");
}

#[test]
fn faces_of_two_corners_are_left_out() {
    for short in ["2 0 2", "1 0", "0"] {
        let (mesh, warning) = warned(&format!("{HEADER}{}", BODY.replace("3 0 2 3", short)));
        assert_eq!(polygons(&mesh), [vec![0, 1, 2, 3]]);
        assert!(
            warning.contains("1 faces have fewer than 3 corners") && warning.contains("face 2 of 2"),
            "{warning}"
        );
    }
}

#[test]
fn truncation_says_how_much_was_found() {
    let ascii = format!("{HEADER}{BODY}");
    let cut = |at: &str| error(&ascii[..ascii.find(at).unwrap()]);
    assert_eq!(cut("1 1 0"), "face: ends after 2 of 4 vertices; the file is cut short");
    assert_eq!(
        cut("4 0 1"),
        "face: ends after 4 of 4 vertices; the file is cut short".replace("4 of 4 vertices", "0 of 2 faces")
    );
    assert_eq!(cut("3 0 2 3"), "face: ends after 1 of 2 faces; the file is cut short");
    assert!(cut("\nend_header").contains("ends within its header, after line 7"), "{}", cut("\nend_header"));
    let whole = include_bytes!("data/plyfile-big-endian.ply");
    let message = refused(&whole[..whole.len() - 1], Format::Ply);
    assert_eq!(message, "face: ends after 1 of 2 faces; the file is cut short");
    let message = refused(&whole[..whole.len() - 100], Format::Ply);
    assert_eq!(message, "face: ends after 4 of 5 vertices; the file is cut short");
}

#[test]
fn errors_name_line_value_and_expectation() {
    let body = |from: &str, to: &str| format!("{HEADER}{}", BODY.replace(from, to));
    let header = |from: &str, to: &str| format!("{}{BODY}", HEADER.replace(from, to));
    for (text, expected) in [
        (String::new(), "face: is empty"),
        ("plain\n".into(), "face: does not begin with a line \"ply\""),
        (body("1 1 0", "1 nan 0"), "face: vertex 2 (counted from 0) is at [1.0, NaN, 0.0], expected finite"),
        (
            body("1 1 0", "1 1e39 0"),
            "face: vertex 2 (counted from 0) is at [1.0, 1e39, 0.0], expected finite",
        ),
        (body("1 1 0", "1 one 0"), "face, line 12: vertex 3 of 4 has \"one\", expected a number"),
        (body("1 1 0", "1 1"), "face, line 12: vertex 3 of 4 has fewer numbers than the header announces"),
        (
            body("1 1 0", "1,5 1 0"),
            "face, line 12: vertex 3 of 4 has \"1,5\", expected a number with a decimal point; the file has decimal",
        ),
        (
            body("3 0 2 3", "3 0 2 4"),
            "face, line 15: face 2 of 2 has the vertex index 4, expected a whole number from 0 to 3",
        ),
        (body("3 0 2 3", "3 0 -1 3"), "face, line 15: face 2 of 2 has the vertex index -1, expected"),
        (body("3 0 2 3", "3 0 .5 3"), "face, line 15: face 2 of 2 has the vertex index 0.5, expected"),
        (body("3 0 2 3", "3 0 nan 3"), "face, line 15: face 2 of 2 has the vertex index NaN, expected"),
        (body("3 0 2 3", "-3 0 2"), "face, line 15: face 2 of 2 has a list of -3 numbers"),
        (body("3 0 2 3", "4294967295 0 2"), "face, line 15: face 2 of 2 has fewer numbers"),
        (header("ascii", "text"), "face, line 2: found \"format text 1.0\", expected ascii,"),
        (header("1.0", "2.0"), "face, line 2: found \"format ascii 2.0\", expected a format of version 1.0"),
        (header("format ascii 1.0\n", ""), "face: its header has no line \"format\""),
        (header("float x", "real x"), "face, line 4: found \"property real x\", expected known types"),
        (
            header("list uchar", "list float"),
            "face, line 8: found \"property list float int vertex_indices\", expected a whole",
        ),
        (
            header("element vertex 4\n", ""),
            "face, line 3: found \"property float x\", expected an element before",
        ),
        (
            header("vertex 4", "vertex many"),
            "face, line 3: found \"element vertex many\", expected a whole number",
        ),
        (
            header("face 2", "vertex 2"),
            "face, line 7: found \"element vertex 2\", but there is such an element",
        ),
        (
            header("element face", "elephant face"),
            "face, line 7: found \"elephant face 2\", expected a PLY header",
        ),
        (header("float z", "float w"), "the element vertex lacks a property x, y or z"),
        (header("vertex_indices", "corners"), "the element face lacks the list vertex_indices"),
        (header("element vertex", "element point"), "face: has no element vertex"),
        (header("element face", "element polygon"), "face: has points but no element face"),
        (header("element face", "element tristrips"), "face: stores its surface as triangle strips"),
        (
            header("vertex 4", "vertex 18446744073709551615"),
            "face: announces 18446744073709551615 vertices, expected at most",
        ),
        (header("face 2", "face 18446744073709551615"), "face: ends after 2 of 18446744073709551615 faces"),
        (header("face 2", "face 0"), "face: has 4 vertices but no faces"),
    ] {
        let message = error(&text);
        assert!(message.contains(expected), "{text:?} gave {message:?}");
    }
    // An element of nothing takes no time, however many there are.
    let text = header("element face", "element nothing 18446744073709551615\nelement face");
    assert_eq!(read(text.as_bytes()).faces.len(), 2);
}

#[test]
fn corner_uvs_that_are_no_pairs_are_left_out() {
    let text = format!("{}{}", with_list("texcoord"), WITH_UVS.replace("8 0 0 1 0 1 1 0 1", "6 0 0 1 0 1 1"));
    let (mesh, warnings) = decode_with_warnings(text.as_bytes(), Format::Ply, "face");
    assert_eq!(corner_uvs(&mesh)[3..], [[0.0, 0.0], [0.0, 0.0], [1.0, 1.0], [0.5, 1.0]]);
    assert!(
        warnings[0].contains("1 faces have texture coordinates that are not two numbers"),
        "{warnings:?}"
    );
    assert!(warnings[1].contains("4 of 7"), "{warnings:?}");
}

/// Types under both of their names, with the largest whole number that each holds.
const TYPES: [(&str, &str, f64); 8] = [
    ("char", "int8", 127.0),
    ("uchar", "uint8", 255.0),
    ("short", "int16", 32_767.0),
    ("ushort", "uint16", 65_535.0),
    ("int", "int32", 2_147_483_647.0),
    ("uint", "uint32", 4_294_967_295.0),
    ("float", "float32", 16_777_216.0),
    ("double", "float64", 9e15),
];

fn put(out: &mut Vec<u8>, encoding: usize, kind: usize, x: f64) {
    if encoding == 0 {
        return out.extend_from_slice(format!("{x} ").as_bytes());
    }
    let mut bytes = match kind {
        0 => (x as i8).to_le_bytes().to_vec(),
        1 => (x as u8).to_le_bytes().to_vec(),
        2 => (x as i16).to_le_bytes().to_vec(),
        3 => (x as u16).to_le_bytes().to_vec(),
        4 => (x as i32).to_le_bytes().to_vec(),
        5 => (x as u32).to_le_bytes().to_vec(),
        6 => (x as f32).to_le_bytes().to_vec(),
        _ => x.to_le_bytes().to_vec(),
    };
    if encoding == 2 {
        bytes.reverse();
    }
    out.append(&mut bytes);
}

/// A PLY with an unknown list and an unknown scalar among the properties of the vertices. The encoding is 0
/// (ASCII), 1 (little endian) or 2 (big endian). `kinds` are the types of coordinates, list lengths and
/// indices.
fn write(
    encoding: usize,
    long_names: bool,
    kinds: [usize; 3],
    positions: &[[f64; 3]],
    faces: &[Vec<u32>],
) -> Vec<u8> {
    let kind = |k: usize| if long_names { TYPES[k].1 } else { TYPES[k].0 };
    let [xyz, length, index] = kinds;
    let format = ["ascii", "binary_little_endian", "binary_big_endian"][encoding];
    let mut out = format!(
        "ply\nformat {format} 1.0\ncomment \u{e9}\nelement vertex {}\nproperty {} x\nproperty list {} short junk\n\
         property {} z\nproperty double more\nproperty {} y\nelement face {}\nproperty list {} {} vertex_indices\n\
         end_header\n",
        positions.len(),
        kind(xyz),
        kind(1),
        kind(xyz),
        kind(xyz),
        faces.len(),
        kind(length),
        kind(index)
    )
    .into_bytes();
    for (i, p) in positions.iter().enumerate() {
        put(&mut out, encoding, xyz, p[0]);
        put(&mut out, encoding, 1, (i % 3) as f64);
        for j in 0..i % 3 {
            put(&mut out, encoding, 2, j as f64 - 7.0);
        }
        put(&mut out, encoding, xyz, p[2]);
        put(&mut out, encoding, 7, 0.1);
        put(&mut out, encoding, xyz, p[1]);
        if encoding == 0 {
            out.push(b'\n');
        }
    }
    for face in faces {
        put(&mut out, encoding, length, face.len() as f64);
        for &i in face {
            put(&mut out, encoding, index, f64::from(i));
        }
        if encoding == 0 {
            out.push(b'\n');
        }
    }
    out
}

proptest! {
    #[test]
    fn encodings_and_types_agree(
        long_names: bool,
        xyz in 0..8_usize,
        length in 0..6_usize,
        index in 0..8_usize,
        unit in prop::collection::vec(any::<[i8; 3]>(), 3..100),
        polygons in prop::collection::vec(prop::collection::vec(0..100_u32, 3..9), 1..20),
    ) {
        // Whole numbers over the type's whole range, or fractions where it has them.
        let largest = TYPES[xyz].2;
        let signed = !matches!(xyz, 1 | 3 | 5);
        let positions: Vec<[f64; 3]> = unit.iter().map(|p| p.map(|x| {
            let x = f64::from(if signed { x } else { x.saturating_abs() }) / 127.0;
            match xyz {
                6 => f64::from(x as f32),
                7 => x,
                _ => (x * largest).round().clamp(-largest, largest),
            }
        })).collect();
        let n = positions.len() as u32;
        let faces: Vec<Vec<u32>> = polygons.into_iter().map(|f| f.into_iter().map(|i| i % n).collect()).collect();
        for encoding in 0..3 {
            let mesh = read(&write(encoding, long_names, [xyz, length, index], &positions, &faces));
            prop_assert_eq!(&mesh.positions, &positions);
            prop_assert_eq!(self::polygons(&mesh), faces.clone());
        }
    }
}
