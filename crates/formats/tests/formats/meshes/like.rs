use super::support::message;
use rhytid_core::Error;
use rhytid_formats::mesh::{read, read_like};
use std::path::Path;

const NEUTRAL: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";

fn like(example: &str) -> rhytid_core::Result<Vec<[f64; 3]>> {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("neutral.obj"), folder.path().join("smile.obj"));
    std::fs::write(&a, NEUTRAL).unwrap();
    std::fs::write(&b, example).unwrap();
    read_like(&read(&a).unwrap(), &a, &b)
}

fn refused(example: &str) -> String {
    let message = message(like(example).map(|_| ()));
    // Both files, and what to do.
    assert!(message.contains("smile.obj: ") && message.contains("neutral.obj"), "{message}");
    assert!(message.contains("export both from the same mesh"), "{message}");
    message
}

#[test]
fn gives_the_positions() {
    // Texture coordinates do not matter.
    let moved = "v 0 0 9\nv 1 0 9\nv 1 1 9\nv 0 1 9\nvt 0 0\nf 1/1 2/1 3/1\nf 1/1 3/1 4/1\n";
    assert_eq!(like(moved).unwrap(), [[0.0, 0.0, 9.0], [1.0, 0.0, 9.0], [1.0, 1.0, 9.0], [0.0, 1.0, 9.0]]);
}

#[test]
fn says_what_differs() {
    let more = format!("v 5 5 5\n{NEUTRAL}");
    assert!(refused(&more).contains("has 5 vertices, but "), "{}", refused(&more));
    let other = NEUTRAL.replace("f 1 2 3", "f 1 2 4");
    let message = refused(&other);
    assert!(message.contains("face 1 joins the vertices 0 1 3, which no face of "), "{message}");
    assert!(message.contains(", face 1 joins 0 1 2 (vertices counted from 0)"), "{message}");
}

#[test]
fn faces_in_another_order_turned_or_cut_in_another_way_are_the_same_surface() {
    let (first, second) = ("f 1 2 3\n", "f 1 3 4\n");
    let vertices = NEUTRAL.replace(first, "").replace(second, "");
    for faces in [
        format!("{second}{first}"),
        "f 2 3 1\nf 4 3 1\n".to_owned(),
        "f 1 2 3 4\n".to_owned(),
        // A missing face moves no vertex.
        first.to_owned(),
    ] {
        assert_eq!(like(&format!("{vertices}{faces}")).unwrap().len(), 4, "{faces}");
    }
    // And a triangulated example of a neutral of quads, cut along the other diagonal.
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("neutral.obj"), folder.path().join("smile.obj"));
    std::fs::write(&a, format!("{vertices}f 1 2 3 4\n")).unwrap();
    std::fs::write(&b, format!("{vertices}f 4 1 2\nf 2 3 4\n")).unwrap();
    assert_eq!(read_like(&read(&a).unwrap(), &a, &b).unwrap().len(), 4);
}

#[test]
fn files_are_told_apart_by_their_extension() {
    let message = message(read(Path::new("face.dat")).map(|_| ()));
    assert_eq!(
        message,
        "face.dat: a mesh's file name must end in .obj, .ply, .glb, .gltf or .usd, found .dat; export the mesh in one of \
         these formats"
    );
    let error = read(Path::new("no-such-folder/face.obj")).unwrap_err();
    assert!(matches!(error, Error::Io { .. }) && error.to_string().contains("face.obj"), "{error}");
}
