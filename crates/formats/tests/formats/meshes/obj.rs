use super::support::{corner_uvs, decode_with_warnings, polygons, refused};
use rhytid_core::{Materials, Mesh, Uvs};
use rhytid_formats::mesh::{Format, decode};

fn read(text: &str) -> Mesh {
    decode(text.as_bytes(), Format::Obj, "face").unwrap()
}

fn error(text: &str) -> String {
    refused(text.as_bytes(), Format::Obj)
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn keeps_polygons_and_positions() {
    let mesh = read(
        "# a comment\r\nmtllib x.mtl\r\no face\r\nv 0 -1.5 +2e-3 # here too\r\nv 1 0 0 1.0\r\n\
         v .5 1. 0 0.2 0.3 0.4\r\nv 0 1 0\r\n\r\nvn 0 0 1\r\ng skin\r\ns off\r\nusemtl skin\r\nf 1 2 3 4\r\n\
         \tf  4//1 2//1 \t 1//1\r\nl 1 2\r\np 1\r\n",
    );
    assert_eq!(mesh.positions, [[0.0, -1.5, 0.002], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(polygons(&mesh), [vec![0, 1, 2, 3], vec![3, 1, 0]]);
    assert_eq!(mesh.uvs, None);
}

#[test]
fn reads_without_a_last_line_end_and_with_a_byte_order_mark() {
    let mesh = read(&format!("\u{feff}{SQUARE}f 1 2 3"));
    assert_eq!((mesh.positions.len(), polygons(&mesh)), (4, vec![vec![0, 1, 2]]));
}

#[test]
fn negative_indices_count_back_from_their_line() {
    let mesh = read(&format!("{SQUARE}f -4 -3 -2\nv 9 9 9\nf -1 1 2\n"));
    assert_eq!(polygons(&mesh), [vec![0, 1, 2], vec![4, 0, 1]]);
}

#[test]
fn faces_may_stand_before_their_vertices() {
    assert_eq!(polygons(&read(&format!("f 1 2 3 4\n{SQUARE}"))), [vec![0, 1, 2, 3]]);
}

#[test]
fn backslashes_join_lines_and_numbers_stay_right() {
    let mesh = read(&format!("# C:\\faces\\\n{SQUARE}f 1 2 \\\n 3 \\\r\n 4\n"));
    assert_eq!((mesh.positions.len(), polygons(&mesh)), (4, vec![vec![0, 1, 2, 3]]));
    let message = error(&format!("{SQUARE}f 1 2 \\\n 3 \\\n 4\nv 1 x 3\nf 1 2 3\n"));
    assert_eq!(message, "face, line 8: found \"x\", expected a number; the file may be damaged");
    // At the end of a file there is nothing to join.
    assert_eq!(read(&format!("{SQUARE}f 1 2 3\\")).faces.len(), 1);
}

#[test]
fn uvs_per_corner() {
    let mesh = read(&format!("{SQUARE}vt 0 0\nvt 1 0 0\nvt .5\nf 1/1 2/2 3/-1\nf 1/2/7 3/3/7 4/1/7\n"));
    let uvs = Uvs { values: vec![[0.0, 0.0], [1.0, 0.0], [0.5, 0.0]], corners: Some(vec![0, 1, 2, 1, 2, 0]) };
    assert_eq!(mesh.uvs, Some(uvs));
}

#[test]
fn uvs_that_follow_the_vertices_are_per_vertex() {
    let uvs = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    let values = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mesh = read(&format!("{SQUARE}{uvs}f 1/1 2/2 3/3 4/4\n"));
    assert_eq!(mesh.uvs, Some(Uvs { values: values.clone(), corners: None }));
    // The same number of them, but another assignment.
    let mesh = read(&format!("{SQUARE}{uvs}f 1/2 2/1 3/3 4/4\n"));
    assert_eq!(mesh.uvs, Some(Uvs { values, corners: Some(vec![1, 0, 2, 3]) }));
}

/// Reads a file and gives its one warning.
fn warned(text: &[u8]) -> (Mesh, String) {
    let (mesh, warnings) = decode_with_warnings(text, Format::Obj, "face");
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    (mesh, warnings[0].clone())
}

#[test]
fn uvs_survive_where_some_corners_have_none() {
    let (mesh, warning) =
        warned(format!("{SQUARE}vt .5 .25\nf 1/1 2/1 3/1\nf 1 2 3\nf 1/1 2/1 4\n").as_bytes());
    assert_eq!(mesh.faces.len(), 3);
    // As Blender reads it.
    let (some, none) = ([0.5, 0.25], [0.0, 0.0]);
    assert_eq!(corner_uvs(&mesh), [some, some, some, none, none, none, some, some, none]);
    assert!(
        warning.contains("4 of 9 face corners have no usable texture coordinates (4 without any)"),
        "{warning}"
    );
}

#[test]
fn uvs_that_are_not_there_or_no_numbers_do_not_cost_the_positions() {
    let uvs = "vt 0 0\nvt 1 0\nvt 1 1\n";
    for nan in ["nan 0", "0 -nan(ind)", "1.#QNAN 0", "-1.#IND 0", "inf 0", "0 1e39", ""] {
        let text = format!("{SQUARE}{uvs}vt {nan}\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
        let (mesh, warning) = warned(text.as_bytes());
        let expected = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0], [1.0, 1.0], [0.0, 0.0]];
        assert_eq!((mesh.faces.len(), corner_uvs(&mesh)), (2, expected.to_vec()), "{nan}");
        assert!(
            warning.contains("1 of 6") && warning.contains("1 with one that is not a number"),
            "{warning}"
        );
    }
    for past in ["4", "-4", "0", "99999999999"] {
        let text = format!("{SQUARE}{uvs}f 1/1 2/2 3/3\nf 1/1 3/3 4/{past}\n");
        let (mesh, warning) = warned(text.as_bytes());
        assert_eq!(corner_uvs(&mesh)[4..], [[1.0, 1.0], [0.0, 0.0]], "{past}");
        assert!(
            warning.contains("1 of 6") && warning.contains("1 with one past the last of the file"),
            "{warning}"
        );
    }
    // Without any `vt`.
    let (mesh, warning) = warned(format!("{SQUARE}f 1/1 2/2 3/3\n").as_bytes());
    assert_eq!((mesh.positions.len(), mesh.faces.len(), mesh.uvs), (4, 1, None));
    assert!(warning.contains("so the mesh has no texture coordinates"), "{warning}");
}

#[test]
fn slashes_without_an_index_are_read() {
    let uvs = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    let expected = read(&format!("{SQUARE}{uvs}f 1/1 2/2 3/3 4/4\n"));
    assert_eq!(read(&format!("{SQUARE}{uvs}f 1/1/ 2/2/ 3/3/ 4/4/\n")), expected);
    for corners in ["1// 2// 3// 4//", "1/ 2/ 3/ 4/", "1//1 2//1 3//1 4//1"] {
        let mesh = read(&format!("{SQUARE}{uvs}f {corners}\n"));
        assert_eq!((polygons(&mesh), mesh.uvs), (vec![vec![0, 1, 2, 3]], None), "{corners}");
    }
    let (mesh, warning) = warned(format!("{SQUARE}{uvs}f 1/1/1/1 2/2/2/2 3/3/3/3\n").as_bytes());
    assert_eq!(polygons(&mesh), [vec![0, 1, 2]]);
    assert!(warning.contains("3 face corners") && warning.contains("line 9: \"1/1/1/1\""), "{warning}");
}

#[test]
fn faces_of_two_corners_are_left_out() {
    let (mesh, warning) =
        warned(format!("{SQUARE}usemtl a\nf 1 2 3 4\nusemtl b\nf 1 2\nf 3\nf\nf 1 2 3\n").as_bytes());
    assert_eq!(polygons(&mesh), [vec![0, 1, 2, 3], vec![0, 1, 2]]);
    assert_eq!(mesh.materials.unwrap().of_face, [0, 1]);
    assert!(warning.contains("3 faces have fewer than 3 corners and were left out"), "{warning}");
    assert!(warning.contains("line 8: \"f 1 2\""), "{warning}");
}

#[test]
fn lines_end_as_on_any_system() {
    let text = format!("{SQUARE}# a comment\nusemtl skin\nf 1 2 \\\n3 4\n");
    let expected = read(&text);
    assert_eq!(polygons(&expected), [vec![0, 1, 2, 3]]);
    for end in ["\r", "\r\n", "\r\r\n"] {
        // A backslash before two ends joins an empty line.
        let text = if end.len() == 3 { text.replace(" \\\n", " ") } else { text.clone() };
        assert_eq!(read(&text.replace('\n', end)), expected, "{end:?}");
    }
    assert_eq!(read(&text.replacen('\n', "\r", 2).replacen('\n', "\r\n", 1)), expected);
    // Lines are counted in each of them.
    let message = error("v 0 0 0\rv 1 0 0\r\nv 1 x 0\n");
    assert!(message.contains("line 3: found \"x\""), "{message}");
    // All blanks are blanks.
    assert_eq!(read(&text.replace("f 1 2", "\x0bf\x0b1\x0c2\t")), expected);
}

#[test]
fn blanks_may_follow_a_backslash_and_comments_never_continue() {
    let mesh = read(&format!("{SQUARE}f 1 2 \\ \t\n 3 \\  \r\n 4\nf 1 2 3 # C:\\faces\\\nf 1 3 4\n"));
    assert_eq!(polygons(&mesh), [vec![0, 1, 2, 3], vec![0, 1, 2], vec![0, 2, 3]]);
}

/// As Blender 5.0 and trimesh 5.2 read it.
#[test]
fn a_name_that_ends_in_a_backslash_takes_the_next_line() {
    for keyword in ["o", "g", "mtllib"] {
        let (mesh, warning) =
            warned(format!("{keyword} C:\\scans\\anna\\\nv 9 9 9\n{SQUARE}f 1 2 3\n").as_bytes());
        assert_eq!((mesh.positions.len(), mesh.positions[0]), (4, [0.0; 3]), "{keyword}");
        assert!(warning.contains("line 1, which takes \"v 9 9 9\""), "{warning}");
    }
    let (mesh, warning) = warned(format!("{SQUARE}usemtl D:\\\nf 1 2 3\nf 1 3 4\n").as_bytes());
    assert_eq!(polygons(&mesh), [vec![0, 2, 3]]);
    assert!(warning.contains("1 lines end with a backslash") && warning.contains("\"f 1 2 3\""), "{warning}");
    // So does any statement.
    let (mesh, warning) = warned(format!("v 9 9 9 \\\n{SQUARE}f 1 2 3\n").as_bytes());
    assert_eq!((mesh.positions[0], mesh.positions.len()), ([9.0; 3], 4));
    assert!(warning.contains("line 1, which takes \"v 0 0 0\""), "{warning}");
}

#[test]
fn names_that_are_not_utf_8_stay_apart() {
    let mut text = SQUARE.as_bytes().to_vec();
    text.extend(b"usemtl \xba\xc3\nf 1 2 3\nusemtl \xc4\xe3\nf 1 3 4\nusemtl \xba\xc3 # again\nf 1 2 4\n");
    let materials = decode(&text, Format::Obj, "face").unwrap().materials.unwrap();
    assert_eq!(materials, Materials::named(["%BA%C3", "%C4%E3"], vec![0, 1, 0]));
}

#[test]
fn unknown_statements_are_skipped_and_said_once() {
    let text = format!("{SQUARE}xyz 1 2\nf 1 2 3\nq\n");
    let (mesh, warnings) = decode_with_warnings(text.as_bytes(), Format::Obj, "unknown.obj");
    assert_eq!(mesh.faces.len(), 1);
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("2 lines") && warnings[0].contains("line 5: \"xyz\""), "{}", warnings[0]);
}

#[test]
fn a_vertex_twice_in_a_face_is_for_the_doctor() {
    assert_eq!(polygons(&read(&format!("{SQUARE}f 1 2 2\n"))), [vec![0, 1, 1]]);
}

#[test]
fn errors_name_line_value_and_expectation() {
    let eight = SQUARE.repeat(2);
    assert_eq!(
        error(&format!("{eight}f 1 2 3\nf 4 9999 1\n")),
        "face, line 10: vertex index 9999 is past the last vertex (8), expected 1 to 8; the file may be cut short"
    );
    for (text, expected) in [
        ("f 1 2 3\n", "line 1: vertex index 3, but the file has no vertex at all"),
        ("v 1 2\n", "line 1: a vertex has 2 numbers, expected 3"),
        ("v 1 2 nan\n", "line 1: a vertex has the coordinate \"nan\", expected a finite number"),
        ("v 1 2 -inf\n", "line 1: a vertex has the coordinate \"-inf\", expected a finite number"),
        ("v 1 2 1e400\n", "line 1: a vertex has the coordinate \"1e400\", expected a finite number"),
        ("v 1 2 1e39\n", "line 1: a vertex has the coordinate \"1e39\", expected a finite number"),
        (
            "v 1,5 2 3\n",
            "line 1: found \"1,5\", expected a number with a decimal point; the file has decimal commas",
        ),
        (
            "vt 0 0,5\n",
            "line 1: found \"0,5\", expected a number with a decimal point; the file has decimal commas",
        ),
        ("v 1,2,3\n", "line 1: found \"1,2,3\", expected numbers with blanks between them, not commas"),
        ("v 1, 2, 3\n", "line 1: found \"1,\", expected numbers with blanks between them, not commas"),
        ("vt 0 x\n", "line 1: found \"x\", expected a number"),
        ("v 1.0D+00 2 3\n", "line 1: found \"1.0D+00\", expected a number"),
        ("V 1 2 3\nF 1 1 1\n", "line 1: found \"V\", expected statements of OBJ such as"),
        ("v 0 0 0\nf 1 0 1\n", "line 2: vertex index 0, expected 1 or above, or -1 to -1"),
        ("v 0 0 0\nf 1 -2 1\n", "line 2: vertex index -2, expected 1 or above, or -1 to -1"),
        ("v 0 0 0\nf 1 99999999999 1\n", "line 2: vertex index 99999999999 is past the last vertex (1)"),
        ("v 0 0 0\nf 1 99999999999999999999 1\n", "line 2: a face corner has the vertex index \"9999"),
        ("v 0 0 0\nf 1 -9223372036854775808 1\n", "line 2: vertex index -9223372036854775808, expected 1"),
        (
            "v 0 0 0\nf 1 1.0 1\n",
            "line 2: a face corner has the vertex index \"1.0\", expected a whole number",
        ),
        ("v 0 0 0\nf 1 /1 1\n", "line 2: a face corner has the vertex index \"\", expected a whole number"),
        (
            "v 0 0 0\nf 1 1/x 1\n",
            "line 2: a face corner has the texture index \"x\", expected a whole number",
        ),
        ("v 0 0 0\nf 1 1\n", "face: has 1 vertices but no faces"),
        ("v 0 0 0\n", "face: has 1 vertices but no faces"),
        ("", "face: is empty"),
        ("#\n", "face: has 0 vertices but no faces"),
    ] {
        let message = error(text);
        assert!(message.contains(expected), "{text:?} gave {message:?}");
    }
}

#[test]
fn a_file_that_ends_within_a_face_is_cut_short() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nf 1 2";
    let said = refused(text.as_bytes(), Format::Obj);
    assert!(
        said.contains("line 5: the file ends in a face with 2 corners") && said.contains("cut short"),
        "{said}"
    );
    // The same face before a line end is one of two corners, which is left out.
    let (mesh, warnings) = decode_with_warnings(format!("{text}\n").as_bytes(), Format::Obj, "face");
    assert_eq!(polygons(&mesh), [[0, 1, 2]]);
    assert!(warnings.iter().any(|line| line.contains("1 faces have fewer than 3 corners")), "{warnings:?}");
}
