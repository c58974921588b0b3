use super::support::{decode_with_warnings, polygons, refused};
use rhytid_core::{Mesh, Uvs};
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

#[test]
fn partial_uvs_are_dropped_and_said_once() {
    let text = format!("{SQUARE}vt 0 0\nf 1/1 2/1 3/1\nf 1 2 3\nf 1/1 2/1 4\n");
    let (mesh, warnings) = decode_with_warnings(text.as_bytes(), Format::Obj, "partial.obj");
    assert_eq!(mesh.uvs, None);
    assert_eq!(mesh.faces.len(), 3);
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("4 of 9 face corners have no texture coordinates"), "{}", warnings[0]);
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
    assert_eq!(
        error(&format!("{SQUARE}vt 0 0\nf 1/1 2/2 3/1\n")),
        "face, line 6: texture index 2 is past the last texture coordinate (1), expected 1 to 1; the file may be \
         cut short"
    );
    for (text, expected) in [
        ("f 1 2 3\n", "line 1: vertex index 3, but the file has no vertex at all"),
        (
            "v 1 2 3\nf 1/1 1/1 1/1\n",
            "line 2: texture index 1, but the file has no texture coordinate at all",
        ),
        ("v 1 2\n", "line 1: a vertex has 2 numbers, expected 3"),
        ("v 1 2 nan\n", "line 1: a vertex has the coordinate \"nan\", expected a finite number"),
        ("v 1 2 -inf\n", "line 1: a vertex has the coordinate \"-inf\", expected a finite number"),
        ("v 1 2 1e400\n", "line 1: a vertex has the coordinate \"1e400\", expected a finite number"),
        ("v 1 2 1e39\n", "line 1: a vertex has the coordinate \"1e39\", expected a finite number"),
        ("v 1,5 2 3\n", "line 1: found \"1,5\", expected a number"),
        ("\nvt\n", "line 2: a texture coordinate has no numbers, expected 2"),
        ("vt 0 nan\n", "line 1: a texture coordinate is \"nan\", expected a finite number"),
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
        ("v 0 0 0\nf 1 1/1/1/1 1\n", "line 2: a face corner is \"1/1/1/1\", expected at most"),
        ("v 0 0 0\nf 1 1\n", "line 2: a face has 2 corners, expected at least 3"),
        ("v 0 0 0\nf\n", "line 2: a face has 0 corners, expected at least 3"),
        ("v 0 0 0\n", "face: has 1 vertices but no faces"),
        ("", "face: has 0 vertices but no faces"),
    ] {
        let message = error(text);
        assert!(message.contains(expected), "{text:?} gave {message:?}");
    }
}
