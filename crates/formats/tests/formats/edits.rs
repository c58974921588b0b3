//! Files of edits: what their text means, that they survive being written, and what every mistake in one is
//! called.

use rhytid_core::Error;
use rhytid_formats::edits::{
    Added, Correction, Curve, Ease, Edits, Gain, Hold, Offset, Region, parse, read, write,
};
use std::collections::BTreeMap;

/// Every key.
const FULL: &str = r#"
[region.left]
markers = ["mp5*", "chin"]
[region.brow]
weights = "brow.ply"
property = "brow"
[region.nose]
groups = ["Nose"]
of = "neutral.obj"
[[gain]]
region = "left"
by = [[10, 1], [20.5, 1.5]]
ease = "linear"
[[offset]]
region = "brow"
millimetres = [0, 2.5, -1]
amount = [[0, 0], [4, 1]]
[[offset]]
markers = { chin = [0, -3, 0], "mp 5" = [1, 2, 3] }
amount = 0.5
[[add]]
take = "jaw.csv"
frame = 100
region = "nose"
amount = 2
ease = "step"
[[hold]]
region = "lids"
frames = "100..110"
at = 99
ease = 3
[[correction]]
mesh = "smile.obj"
frame = 120
region = "left"
amount = 0.8
reach = 0.15
[[detail]]
by = 0
"#;

fn region(markers: &[&str]) -> Region {
    Region { markers: markers.iter().map(|&label| label.into()).collect(), ..Region::default() }
}

fn full() -> Edits {
    let (smooth, step) = (Ease::Smooth, Ease::Step);
    let curve = |keys: &[(f64, f64)], ease| Curve { keys: keys.to_vec(), ease };
    let some = |name: &str| Some(name.to_owned());
    Edits {
        regions: BTreeMap::from([
            ("left".into(), region(&["mp5*", "chin"])),
            (
                "brow".into(),
                Region { weights: Some("brow.ply".into()), property: some("brow"), ..Region::default() },
            ),
            (
                "nose".into(),
                Region { groups: vec!["Nose".into()], of: Some("neutral.obj".into()), ..Region::default() },
            ),
        ]),
        gains: vec![Gain {
            region: some("left"),
            by: curve(&[(10.0, 1.0), (20.5, 1.5)], Ease::Linear),
            ease: Ease::Linear,
        }],
        offsets: vec![
            Offset {
                region: some("brow"),
                millimetres: Some([0.0, 2.5, -1.0]),
                markers: BTreeMap::new(),
                amount: curve(&[(0.0, 0.0), (4.0, 1.0)], smooth),
                ease: smooth,
            },
            Offset {
                region: None,
                millimetres: None,
                markers: BTreeMap::from([
                    ("chin".into(), [0.0, -3.0, 0.0]),
                    ("mp 5".into(), [1.0, 2.0, 3.0]),
                ]),
                amount: Curve::constant(0.5),
                ease: smooth,
            },
        ],
        added: vec![Added {
            take: "jaw.csv".into(),
            frame: 100.0,
            region: some("nose"),
            amount: curve(&[(0.0, 2.0)], step),
            ease: step,
        }],
        holds: vec![Hold { region: some("lids"), frames: 100..110, at: Some(99), ease: 3 }],
        corrections: vec![Correction {
            mesh: "smile.obj".into(),
            frame: 120,
            region: some("left"),
            amount: Curve::constant(0.8),
            ease: smooth,
            reach: Some(0.15),
        }],
        details: vec![Gain { region: None, by: Curve::constant(0.0), ease: smooth }],
    }
}

#[test]
fn every_key_is_read_and_survives_being_written() {
    assert_eq!(parse(FULL, "EDIT.toml").unwrap(), full());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("EDIT.toml");
    write(&path, &full()).unwrap();
    let (again, text) = read(&path).unwrap();
    assert_eq!(again, full());
    assert_eq!(parse(&text, "again").unwrap(), full());
    assert_eq!(parse("", "nothing").unwrap(), Edits::default());
}

#[test]
fn every_mistake_is_a_sentence_with_its_line() {
    for (text, expected) in [
        ("[[gian]]\nby = 1\n", "line 1: unknown key \"gian\" (did you mean \"gain\"?)"),
        ("[gain]\nby = 1\n", "line 1: gain is a section, expected [[gain]] in double brackets"),
        (
            "[[gain]]\nregion = \"a\"\n",
            "line 1: [[gain]] lacks the key by, expected a number from 0 to 10, or keys",
        ),
        ("[[gain]]\nby = -1\n", "line 2: [[gain]] by is -1, expected a number from 0 to 10"),
        ("[[gain]]\nby = inf\n", "line 2: [[gain]] by is inf"),
        ("[[gain]]\nby = []\n", "line 2: [[gain]] by is an empty list"),
        ("[[gain]]\nby = [[1, 2], [3]]\n", "a list whose entry 2 is not [frame, number]"),
        ("[[gain]]\nby = [[1, 2], [1, 3]]\n", "a list in which frame 1 comes behind frame 1"),
        ("[[gain]]\nby = 1\nease = \"bounce\"\n", "line 3: [[gain]] ease is \"bounce\", expected \"smooth\""),
        ("[[detail]]\nby = 3\n", "[[detail]] by is 3, expected a number from 0 to 2"),
        ("[region.a]\n", "line 1: [region.a] has none of markers, groups and weights"),
        ("[region.a]\nmarkers = [\"x\"]\nweights = \"a.ply\"\n", "[region.a] has several of markers"),
        (
            "[region.a]\nweights = \"a.ply\"\n",
            "[region.a] lacks the key property, expected one beside weights",
        ),
        ("[region.a]\nmarkers = [\"x\"]\nof = \"a.obj\"\n", "[region.a] has of without groups; leave it out"),
        ("[region.a]\nmarkers = [3]\n", "[region.a] markers is a list with 3, expected a list of labels"),
        ("[region]\na = 3\n", "line 2: [region] a is 3, expected a section [region.a]"),
        ("[[offset]]\namount = 1\n", "[[offset]] needs one of two: millimetres"),
        ("[[offset]]\nmillimetres = [1, 2]\n", "[[offset]] millimetres is an array, expected [x, y, z]"),
        ("[[offset]]\nmillimetres = [1, 2, 3000]\n", "at most 1000 mm"),
        ("[[offset]]\nmarkers = { chin = 3 }\n", "[[offset]] markers is 3 for \"chin\""),
        ("[[offset]]\nregion = \"a\"\nmarkers = { chin = [0, 0, 1] }\n", "leave the region out"),
        ("[[add]]\nframe = 3\n", "[[add]] lacks the key take"),
        ("[[hold]]\nframes = \"9..9\"\n", "[[hold]] frames is \"9..9\", expected \"A..B\""),
        ("[[hold]]\nframes = \"1..9\"\nease = 1.5\n", "[[hold]] ease is 1.5, expected a whole number"),
        ("[[correction]]\nmesh = \"a.obj\"\n", "[[correction]] lacks the key frame"),
        (
            "[[correction]]\nmesh = \"a.obj\"\nframe = 1\nreach = 0\n",
            "[[correction]] reach is 0, expected a number above 0",
        ),
        ("[[gain]]\nby = 1 1\n", "line 2: not TOML"),
    ] {
        match parse(text, "EDIT.toml") {
            Err(Error::Input(sentence)) => {
                assert!(sentence.sentence().starts_with("EDIT.toml, line "), "{sentence}");
                assert!(sentence.sentence().contains(expected), "{text}: {sentence}");
            }
            other => panic!("{text}: expected an input error, found {other:?}"),
        }
    }
}
