//! Meshes of USD files, as USD's own library reads them. The library comes from `cargo xtask setup`.

use super::support::{corner_uvs, message, polygons};
use rhytid_core::{Mesh, UpAxis};
use rhytid_formats::mesh::{Selection, Shapes, read, read_file, read_shapes};
use rhytid_test_support::{Logged, python, root, shared};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// The files that `usd_make.py` writes.
fn made() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let script = root().join("crates/formats/tests/formats/meshes/usd_make.py");
    let output = Command::new(python()).arg(script).arg(folder.path()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    folder
}

fn expected(path: &Path) -> Value {
    let text = std::fs::read_to_string(format!("{}.json", path.display())).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// Positions within a rounding of a million.
fn assert_close(found: &[[f64; 3]], expected: &Value) {
    let expected: Vec<[f64; 3]> = serde_json::from_value(expected.clone()).unwrap();
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert!((found - expected).abs() < 1e-6, "found {found}, expected {expected}");
    }
}

fn check(mesh: &Mesh, expected: &Value) {
    assert_close(&mesh.positions, &expected["positions"]);
    assert_eq!(serde_json::to_value(polygons(mesh)).unwrap(), expected["faces"]);
}

fn at(time: f64) -> Selection {
    Selection { time: Some(time), ..Selection::default() }
}

fn prim(path: &str) -> Selection {
    Selection { prim: Some(path.to_owned()), ..Selection::default() }
}

#[test]
fn meshes_are_as_usd_reads_them() {
    let folder = made();
    for extension in ["usda", "usdc"] {
        let file = |name: &str| folder.path().join(format!("{name}.{extension}"));
        for name in ["placed", "hidden"] {
            check(&read(&file(name)).unwrap(), &expected(&file(name)));
        }
        let space = read_file(&file("placed"), &Selection::default(), false).unwrap().space;
        assert_eq!((space.metres_per_unit, space.up), (Some(1.0), Some(UpAxis::Z)));

        // At rest, then between two samples.
        let rest = read(&file("moving")).unwrap();
        assert_eq!(rest.positions[1], [1.0, 0.0, 0.25 + 1.0]);
        let moved = read_file(&file("moving"), &at(4.0), false).unwrap().neutral;
        check(&moved, &expected(&file("moving")));
        let said = message(read_file(&file("hidden"), &at(4.0), false).map(|_| ()));
        assert!(said.contains("nothing in it has time samples"), "{said}");

        let face = read_file(&file("looks"), &prim("/root/face"), false).unwrap().neutral;
        check(&face, &expected(&file("looks")));
        assert_eq!(
            corner_uvs(&face),
            [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [1.0, 1.0]]
        );
        let materials = face.materials.unwrap();
        assert_eq!(materials.names().collect::<Vec<_>>(), ["skin", "lip"]);
        assert_eq!(materials.of_face, [0, 1]);
        let said = message(read_file(&file("looks"), &prim("/root/fac"), false).map(|_| ()));
        assert!(
            said.contains("no mesh at the prim /root/fac or below it, found /root/face, /root/wide"),
            "{said}"
        );
    }
}

#[test]
fn blend_shapes_are_as_usd_reads_them() {
    let folder = made();
    for extension in ["usda", "usdc"] {
        let path = folder.path().join(format!("shaped.{extension}"));
        let expected = expected(&path);
        let Shapes { neutral, shapes, .. } = read_shapes(&path).unwrap();
        check(&neutral, &expected);
        let names: Vec<&str> = shapes.iter().map(|shape| shape.name.as_str()).collect();
        assert_eq!(names, ["smile", "blink"]);
        for shape in &shapes {
            assert_close(&shape.on(&neutral.positions), &expected["shapes"][&shape.name]);
        }
    }
}

#[test]
fn what_is_not_read_is_said() {
    let folder = made();
    let said = |name: &str| {
        let logged = Logged::start();
        read(&folder.path().join(name)).unwrap();
        logged.lines().iter().filter(|line| line.starts_with("WARN ")).cloned().collect::<Vec<_>>()
    };
    for (name, words) in [
        ("hidden.usda", "invisible, guides or proxies are left out: /a/invisible, /a/proxy"),
        ("shaped.usdc", "shows the shape blink with the weight 0.5; the mesh is read without it"),
        ("looks.usda", "/root/face is the cage of a subdivision surface (catmullClark)"),
        ("eyes.usda", "shapes that are no meshes are left out: /root/eye (Sphere); convert them"),
        ("eyes.usdc", "shapes that are no meshes are left out: /root/eye (Sphere); convert them"),
        ("variants.usda", "the variant set kind is not read"),
        ("variants.usdc", "the variant set kind is not read"),
        ("inherited.usda", "refers to other files or prims, which are not followed"),
        ("inherited.usdc", "refers to other files or prims, which are not followed"),
    ] {
        let lines = said(name);
        assert!(lines.iter().any(|line| line.contains(words)), "{lines:?}");
    }
    assert_eq!(said("placed.usda"), Vec::<String>::new());
}

/// A layer in text.
fn refused(body: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.usda");
    std::fs::write(&path, format!("#usda 1.0\n{body}")).unwrap();
    message(read(&path).map(|_| ()))
}

#[test]
fn a_file_without_a_mesh_of_its_own_is_one_sentence() {
    for (body, words) in [
        ("def Xform \"a\" {}\n", "has no mesh, expected a scan"),
        (
            "def Sphere \"a\" {}\ndef Cube \"b\" {}\ndef Cube \"c\" { token visibility = \"invisible\" }\n",
            "has no mesh, but shapes of other kinds: /a (Sphere), /b (Cube); convert them to meshes",
        ),
        (
            "def \"a\" (references = @head.usd@) {}\n",
            "has no mesh of its own, but refers to other files or prims",
        ),
        (
            "def \"a\" (payload = @head.usd@) {}\n",
            "refers to other files or prims; flatten it into one file, as with usdcat",
        ),
        ("class \"c\" {}\ndef \"a\" (inherits = </c>) {}\n", "has no mesh of its own, but refers to other"),
        ("(\nsubLayers = [@head.usd@]\n)\n", "has no mesh of its own"),
        ("def Mesh \"a\" {}\n", "the prim /a has no points"),
        // USD's library takes a path to a file in quotes, too.
        ("def Mesh \"a\" { asset image = \"\" ( doc = \"\"\"none\"\"\" ) }\n", "the prim /a has no points"),
        (
            "def Mesh \"a\" { point3f[] points = [(0,0,0)] int[] faceVertexCounts = [3] int[] faceVertexIndices = [0,0] }\n",
            "/a has 2 corners, expected the 3 of its faces",
        ),
        (
            "def Mesh \"a\" { point3f[] points = [(0,0,0)] int[] faceVertexCounts = [3] int[] faceVertexIndices = [0,0,1] }\n",
            "/a names the point 1, expected 0 to 0",
        ),
        (
            "def Mesh \"a\" { point3f[] points = [(0,0,0)] int[] faceVertexCounts = [3] int[] faceVertexIndices = [0,0,-1] }\n",
            "/a has a negative number in faceVertexIndices",
        ),
        (
            "def Mesh \"a\" { uniform token[] xformOpOrder = [\"xformOp:turn\"] }\n",
            "the transform xformOp:turn without",
        ),
    ] {
        let said = refused(body);
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn a_scan_in_usd_is_the_scan_in_obj() {
    let Some(data) = shared("data") else { return };
    let mesh = read(&data.join("other-people/meshes/static_mesh.usda")).unwrap();
    let face = read(&data.join("face/neutral.obj")).unwrap();
    assert_eq!(polygons(&mesh), polygons(&face));
    for (a, b) in mesh.positions.iter().flatten().zip(face.positions.iter().flatten()) {
        assert!((a - b).abs() < 1e-5);
    }
}
