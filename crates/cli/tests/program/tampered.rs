//! Files that were changed after their export: `verify` finds the change, and `stitch` refuses them.

use crate::common::{Fixture, stderr};

/// A text in a `.usda` file and its replacement. Then the words of `verify` and its exit code.
const CHANGES: [(&str, &str, &str, i32); 10] = [
    ("metersPerUnit = 0.01", "metersPerUnit = 1", "metres per unit: 1, expected 0.01", 1),
    ("upAxis = \"Y\"", "upAxis = \"Z\"", "up axis: Z, expected Y", 1),
    ("framesPerSecond = ", "framesPerSecond = 9", "framesPerSecond: 9", 1),
    ("startTimeCode = 0", "startTimeCode = 1", "startTimeCode 1, expected 0", 2),
    ("endTimeCode = 8", "endTimeCode = 7", "endTimeCode 7, expected 8", 2),
    (
        "faceVertexIndices = [0, 1, 22, 21",
        "faceVertexIndices = [21, 22, 1, 0",
        "faces: others, expected the rig's",
        1,
    ),
    (
        "int[] faceVertexCounts",
        "uniform token orientation = \"leftHanded\"\n        int[] faceVertexCounts",
        "left-handed faces",
        2,
    ),
    ("normal3f[] normals", "normal3f[] othernormals", "normals: lacks, expected has", 1),
    ("float3[] extent", "float3[] otherextent", "extents: lacks, expected has", 1),
    (
        "normals.timeSamples = {\n            0: [(",
        "normals.timeSamples = {\n            0: [(0, 0, 9), (",
        "",
        2,
    ),
];

fn exported() -> Fixture {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    for (frames, part) in [("0..9", "a"), ("9..17", "b")] {
        f.done(&format!(
            "animate face.safetensors take.csv --device cpu:0 --frames {frames} -o part-{part}.usda"
        ));
    }
    f
}

fn verify(f: &Fixture, name: &str) -> (i32, String) {
    let command = format!("verify {name} --rig face.safetensors --take take.csv --device cpu:0");
    let output = f.rhytid(&command).output().unwrap();
    let said = format!("{}{}", String::from_utf8_lossy(&output.stdout), stderr(&output));
    (output.status.code().unwrap(), said)
}

#[test]
fn what_was_changed_is_found() {
    let f = exported();
    assert_eq!(verify(&f, "part-a.usda").0, 0);
    let text = f.read_text("part-a.usda");
    for (from, to, says, code) in CHANGES {
        assert!(text.contains(from), "{from}: {}", &text[..3000]);
        f.write("changed.usda", text.replace(from, to));
        let (found, said) = verify(&f, "changed.usda");
        assert!(found == code && said.contains(says), "{to}: {found} {said}");
    }
}

/// Changed numbers of one sample.
#[test]
fn a_wrong_extent_and_a_wrong_normal_are_found() {
    let f = exported();
    let text = f.read_text("part-a.usda");
    let change = |what: &str, says: &str| {
        let samples = text.find(&format!("{what}.timeSamples")).unwrap();
        let first = samples + text[samples..].find("[(").unwrap() + 2;
        let end = first + text[first..].find(')').unwrap();
        f.write("changed.usda", format!("{}9, 9, 9{}", &text[..first], &text[end..]));
        let (code, said) = verify(&f, "changed.usda");
        assert!(code == 1 && said.contains(says) && said.contains("FAILS"), "{what}: {said}");
    };
    change("extent", "extents: wrong in 1 of 9 frames");
    change("normals", "of their length at worst");
    change("points", "frame 0, vertex 0");
}

#[test]
fn parts_that_differ_are_not_stitched() {
    let f = exported();
    f.done("stitch part-a.usda part-b.usda -o whole.usd");
    let text = f.read_text("part-b.usda");
    for (from, to, says) in [
        ("metersPerUnit = 0.01", "metersPerUnit = 1", "metres per unit: 1 and 0.01"),
        ("upAxis = \"Y\"", "upAxis = \"Z\"", "the up axis: Z and Y"),
        ("framesPerSecond = ", "framesPerSecond = 9", "framesPerSecond: 9"),
        ("startTimeCode = 9", "startTimeCode = 8", "startTimeCode 8"),
        (
            "faceVertexIndices = [0, 1, 22, 21",
            "faceVertexIndices = [21, 22, 1, 0",
            "their faces are different",
        ),
        ("normal3f[] normals", "normal3f[] othernormals", "with normals: no and yes"),
        ("float3[] extent", "float3[] otherextent", "with extents: no and yes"),
    ] {
        assert!(text.contains(from), "{from}: {}", &text[..3000]);
        f.write("changed.usda", text.replace(from, to));
        f.refused("stitch part-a.usda changed.usda -o out/whole.usd", &["changed.usda", says]);
    }
}
