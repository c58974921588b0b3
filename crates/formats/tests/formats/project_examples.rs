//! The examples that a project's sections stand for: shapes of one file, the files of a pattern, poses of a
//! USD file.
use rhytid_core::{Error, Face, Result};
use rhytid_formats::Reach;
use rhytid_formats::project::read;
use rhytid_test_support::Logged;
use std::fs;
use std::path::Path;

const SQUARE: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

/// A square whose vertex 2 is moved by `by`, as OBJ.
fn obj(by: [f64; 3]) -> String {
    let mut text = String::new();
    for (v, point) in SQUARE.iter().enumerate() {
        let [x, y, z] = if v == 2 { [0, 1, 2].map(|c| point[c] + by[c]) } else { *point };
        text += &format!("v {x} {y} {z}\n");
    }
    text + "f 1 2 3 4\n"
}

/// The same square with three blend shapes, which move vertex 2. Its unit and axis are in the metadata.
fn usd(metadata: &str, scale: f64) -> String {
    let points: Vec<String> =
        SQUARE.iter().map(|p| format!("({}, {}, {})", p[0] * scale, p[1] * scale, p[2] * scale)).collect();
    let later: Vec<String> =
        SQUARE.iter().map(|p| format!("({}, {}, 8)", p[0] * scale, p[1] * scale)).collect();
    let shape = |name: &str, by: [f64; 3]| {
        let by = by.map(|x| x * scale);
        format!(
            "def BlendShape \"{name}\" {{ vector3f[] offsets = [({}, {}, {})] int[] pointIndices = [2] }}\n",
            by[0], by[1], by[2]
        )
    };
    format!(
        "#usda 1.0\n(\n{metadata}\n)\ndef Xform \"head\" {{ def Mesh \"face\" {{\npoint3f[] points = [{}]\n\
         point3f[] points.timeSamples = {{ 1: [{0}], 3: [{1}] }}\n\
         int[] faceVertexCounts = [4]\nint[] faceVertexIndices = [0, 1, 2, 3]\n{2}{3}{4}\
         def BlendShape \"rest\" {{ vector3f[] offsets = [] int[] pointIndices = [] }}\n}} }}\n",
        points.join(", "),
        later.join(", "),
        shape("blinkLeft", [0.5, 0.0, 0.0]),
        shape("blinkRight", [0.0, 0.25, 0.0]),
        shape("smile", [0.0, 0.0, 1.0]),
    )
}

/// A folder with a project that has these sections, and with these files.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, String)]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("markers.csv"), "label,vertex\na,0\nb,2\n").unwrap();
        fs::write(folder.path().join("neutral.obj"), obj([0.0; 3])).unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        Self(folder)
    }

    fn read(&self, mesh: &str, sections: &str) -> Result<Face> {
        let path = self.0.path().join("face.toml");
        fs::write(&path, format!("[mesh]\n{mesh}\n[handles]\nvertices = 'markers.csv'\n{sections}")).unwrap();
        read(&path, Reach::Below)
    }

    /// The names of the examples, and where each has vertex 2.
    fn examples(&self, sections: &str) -> Vec<(String, [f64; 3])> {
        let face = self.read("neutral = 'neutral.obj'\nunits = 'cm'", sections).unwrap();
        face.examples.into_iter().map(|example| (example.name, example.positions[2])).collect()
    }

    fn refused(&self, sections: &str) -> String {
        match self.read("neutral = 'neutral.obj'\nunits = 'cm'", sections) {
            Err(Error::Input(sentence)) => sentence.to_string(),
            other => panic!("expected an input error, found {other:?}"),
        }
    }
}

fn named(name: &str, at: [f64; 3]) -> (String, [f64; 3]) {
    (name.to_owned(), at)
}

#[test]
fn shapes_of_one_file_are_examples() {
    let folder = Folder::new(&[("head.usda", usd("", 1.0))]);
    let smile = named("smile", [1.0, 1.0, 1.0]);
    assert_eq!(
        folder.examples("[[example]]\nmesh = 'head.usda'\nshape = 'smile'\n"),
        std::slice::from_ref(&smile)
    );
    assert_eq!(
        folder.examples("[[example]]\nname = 'half'\nmesh = 'head.usda'\nshape = 'smile'\nweight = 0.5\n"),
        [named("half", [1.0, 1.0, 0.5])]
    );
    assert_eq!(
        folder.examples("[[example]]\nmesh = 'head.usda'\nshape = ['blinkLeft', 'blinkRight']\n"),
        [named("blinkLeft+blinkRight", [1.5, 1.25, 0.0])]
    );
    // The one that moves nothing is left out, which is said.
    let logged = Logged::start();
    assert_eq!(
        folder.examples("[[example]]\nmesh = 'head.usda'\nshapes = '*'\n"),
        [named("blinkLeft", [1.5, 1.0, 0.0]), named("blinkRight", [1.0, 1.25, 0.0]), smile.clone()]
    );
    assert!(logged.lines().iter().any(|line| line.contains("the shape \"rest\" moves nothing")));
    assert_eq!(
        folder.examples("[[example]]\nmesh = 'head.usda'\nshapes = ['sm*', 'blinkL*']\nweight = 2\n"),
        [named("blinkLeft", [2.0, 1.0, 0.0]), named("smile", [1.0, 1.0, 2.0])]
    );
}

#[test]
fn a_pattern_of_files_is_an_example_for_each() {
    let files = [
        ("poses/scan.0002.obj", obj([0.0, 0.0, 2.0])),
        ("poses/scan.0001.obj", obj([0.0, 0.0, 1.0])),
        ("poses/scan.txt", String::new()),
        ("poses/other.obj", obj([3.0, 0.0, 0.0])),
    ];
    let folder = Folder::new(&files);
    let scans = [named("scan.0001", [1.0, 1.0, 1.0]), named("scan.0002", [1.0, 1.0, 2.0])];
    assert_eq!(folder.examples("[[example]]\nmesh = 'poses/scan.####.obj'\n"), scans);
    assert_eq!(folder.examples("[[example]]\nmesh = 'poses/*.obj'\nmirror = true\n").len(), 3);
    // The neutral is not an example of itself.
    let folder = Folder::new(&[("smile.obj", obj([0.0, 0.0, 1.0]))]);
    assert_eq!(folder.examples("[[example]]\nmesh = '*.obj'\n"), [named("smile", [1.0, 1.0, 1.0])]);
    let said = folder.refused("[[example]]\nmesh = 'poses/scan.####.obj'\n");
    assert!(said.contains("[[example]] mesh is \"poses/scan.####.obj\", which fits no file"), "{said}");
}

#[test]
fn a_name_with_signs_of_a_pattern_may_be_a_file() {
    let folder = Folder::new(&[("take #3.obj", obj([0.0, 0.0, 1.0]))]);
    let sections = "[[example]]\nname = 'smile'\nmesh = 'take #3.obj'\n";
    assert_eq!(folder.examples(sections), [named("smile", [1.0, 1.0, 1.0])]);
}

#[test]
fn a_file_that_states_its_space_is_taken_into_that_of_the_neutral() {
    let inches = Folder::new(&[("head.usda", usd("metersPerUnit = 0.0254\nupAxis = \"Z\"", 1.0))]);
    let smile = "[[example]]\nmesh = 'head.usda'\nshape = 'smile'\n";
    // z up becomes y up: (1, 1, 1) in inches is (1, 1, -1) · 2.54 cm.
    assert_close(inches.examples(smile)[0].1, [2.54, 2.54, -2.54]);
    // A key of the example says otherwise.
    let said = format!("{smile}unit = 'cm'\naxes = '+x+y+z'\n");
    assert_close(inches.examples(&said)[0].1, [1.0, 1.0, 1.0]);

    // A neutral that states its space needs neither units nor up.
    let face = inches.read("neutral = 'head.usda'", smile).unwrap();
    assert_eq!((face.metres_per_unit, face.up_axis), (0.0254, rhytid_core::UpAxis::Z));
    assert_close(face.examples[0].positions[2], [1.0, 1.0, 1.0]);
    // The same file in another unit than it states.
    let face = inches.read("neutral = 'head.usda'\nunits = 'cm'\nup = 'y'", smile).unwrap();
    assert_eq!((face.metres_per_unit, face.up_axis), (0.01, rhytid_core::UpAxis::Y));
    assert_close(face.examples[0].positions[2], [1.0, 1.0, 1.0]);

    let silent = Folder::new(&[("head.usda", usd("", 1.0))]);
    assert_close(silent.examples(smile)[0].1, [1.0, 1.0, 1.0]);
    match silent.read("neutral = 'head.usda'", smile) {
        Err(Error::Input(sentence)) => {
            assert!(
                sentence.to_string().contains("head.usda does not state its unit; add units"),
                "{sentence}"
            );
        }
        other => panic!("{other:?}"),
    }
}

fn assert_close(found: [f64; 3], expected: [f64; 3]) {
    assert!((0..3).all(|c| (found[c] - expected[c]).abs() < 1e-6), "found {found:?}, expected {expected:?}");
}

#[test]
fn poses_of_a_usd_file_are_at_its_times() {
    let folder = Folder::new(&[("head.usda", usd("", 1.0))]);
    // From time 1 to 3, z goes from 0 to 8.
    let at = |time: &str| {
        folder.examples(&format!(
            "[[example]]\nname = 'pose'\nmesh = 'head.usda'\nprim = '/head'\ntime = {time}\n"
        ))
    };
    assert_eq!(at("1"), [named("pose", [1.0, 1.0, 0.0])]);
    assert_eq!(at("2.5"), [named("pose", [1.0, 1.0, 6.0])]);
}

#[test]
fn what_is_not_there_is_named() {
    let folder = Folder::new(&[("head.usda", usd("", 1.0)), ("smile.obj", obj([0.0, 0.0, 1.0]))]);
    for (sections, words) in [
        (
            "[[example]]\nmesh = 'head.usda'\nshape = 'smil'\n",
            "[[example]] shape has \"smil\" (did you mean \"smile\"?), but",
        ),
        (
            "[[example]]\nname = 'a'\nmesh = 'head.usda'\nshape = ['smile', 'frown']\n",
            "[[example]] \"a\": shape has \"frown\", but",
        ),
        ("[[example]]\nmesh = 'head.usda'\nshapes = 'brow*'\n", "has blinkLeft, blinkRight, smile, rest"),
        ("[[example]]\nmesh = 'smile.obj'\nshapes = '*'\n", "a file without shapes; name a glTF or USD file"),
        (
            "[[example]]\nmesh = 'head.usda'\nshapes = '*'\n[[example]]\nname = 'smile'\nmesh = 'smile.obj'\n",
            "two examples are called \"smile\", of [[example]] 1 and 2",
        ),
        (
            "[[example]]\nname = 'a'\nmesh = 'head.usda'\nprim = '/tail'\n",
            "no mesh at the prim /tail or below it",
        ),
        ("[[example]]\nmesh = 'smile.obj'\n", "[[example]] lacks the key name"),
        (
            "[[example]]\nname = 'a'\nmesh = 'head.usda'\nshapes = '*'\n",
            "has name, which is of one example, and shapes",
        ),
        (
            "[[example]]\nmesh = '*.obj'\ntake = 'a.csv'\nframe = 1\n",
            "has take, which is of one example, and a pattern",
        ),
        ("[[example]]\nname = 'a'\nmesh = 'smile.obj'\nweight = 2\n", "has weight without shape"),
        ("[[example]]\nname = 'a'\nmesh = 'smile.obj'\nprim = '/a'\n", "has prim, which only USD files have"),
        ("[[example]]\nname = 'a'\nmesh = 'smile.obj'\ntime = 1\n", "has time, which only USD files have"),
        (
            "[[example]]\nname = 'a'\nmesh = 'head.usda'\nprim = 'face'\n",
            "prim is \"face\", expected the path of a prim",
        ),
        ("[[example]]\nmesh = 'head.usda'\nshapes = []\n", "shapes is an empty list, expected \"*\" for all"),
        (
            "[[example]]\nmesh = 'head.usda'\nshape = 'smile'\nweight = 0\n",
            "weight is 0, expected what shapes are",
        ),
    ] {
        let said = folder.refused(sections);
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn all_files_are_known_before_they_are_read() {
    let folder = Folder::new(&[("poses/a.obj", obj([1.0, 0.0, 0.0])), ("poses/b.obj", obj([2.0, 0.0, 0.0]))]);
    folder.examples("[[example]]\nmesh = 'poses/*.obj'\n");
    let path = folder.0.path().join("face.toml");
    let project = rhytid_formats::project::read_project(&path).unwrap();
    let files = rhytid_formats::project::files(&project, &path);
    let is_there = |name: &str| files.contains(&folder.0.path().join(Path::new(name)));
    assert!(is_there("poses/a.obj") && is_there("poses/b.obj") && is_there("neutral.obj"), "{files:?}");
}
