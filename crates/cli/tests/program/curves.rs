//! Curves: weights of shapes, played on a rig.

use crate::common::{Fixture, stderr};
use rhytid::formats::animation;

/// Three frames as Live Link Face writes them: the weights 0, 0.5 and 1 of the fixture's shape.
const CURVES: &str = "Timecode,BlendshapeCount,Pinch,TongueOut,HeadYaw\n\
                      10:00:01:00.000,61,0,0,0.1\n\
                      10:00:02:00.000,61,0.5,0.25,0.2\n\
                      10:00:03:00.000,61,1,0,0.1\n";

/// A sheet with its rig, `face.safetensors`, and curves for it.
fn solved(project: impl Fn(&str) -> String) -> Fixture {
    let fixture = Fixture::new();
    fixture.write("face.toml", project(crate::common::PROJECT));
    fixture.write("curves.csv", CURVES);
    fixture.done("solve face.toml -o face.safetensors");
    fixture
}

fn with_example(project: &str) -> String {
    project.to_owned()
}

fn without_example(project: &str) -> String {
    project.replace("[[example]]\nname = \"pinch\"\nmesh = \"poses/pinch.obj\"\n", "")
}

#[test]
fn info_says_which_curves_move() {
    let fixture = Fixture::new();
    fixture.write("curves.csv", CURVES);
    let output = fixture.rhytid("info curves.csv --json").output().unwrap();
    let info: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&info["kind"], &info["frames"], &info["rate"]), (&"curves".into(), &3.into(), &1.0.into()));
    let expected =
        serde_json::json!([{"name": "Pinch", "largest": 1.0}, {"name": "TongueOut", "largest": 0.25}]);
    assert_eq!(info["curves"], expected);
    let text = String::from_utf8(fixture.rhytid("info curves.csv").output().unwrap().stdout).unwrap();
    assert!(text.contains("curves.csv: curves, ") && text.contains("Pinch, TongueOut"), "{text}");
    assert!(text.contains("the head keeps still: \"HeadYaw\""), "{text}");
}

/// The positions of an OBJ file, read without the program.
fn obj(text: &str) -> Vec<[f64; 3]> {
    let of_line = |line: &str| {
        let numbers: Vec<f64> = line[2..].split(' ').map(|x| x.parse().unwrap()).collect();
        [numbers[0], numbers[1], numbers[2]]
    };
    text.lines().filter(|line| line.starts_with("v ")).map(of_line).collect()
}

fn frames(fixture: &Fixture, name: &str) -> Vec<Vec<[f64; 3]>> {
    let mut reader = animation::open(&fixture.path(name)).unwrap();
    let mut positions = Vec::new();
    let frame = |frame| {
        reader.positions(frame, &mut positions).unwrap();
        positions.as_chunks::<3>().0.iter().map(|x| x.map(f64::from)).collect()
    };
    (0..3).map(frame).collect()
}

fn farthest(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn the_rigs_own_example_comes_back_with_its_folds() {
    let fixture = solved(with_example);
    let output = fixture.rhytid("animate face.safetensors curves.csv -o a.usda").output().unwrap();
    let said = stderr(&output);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("\"TongueOut\" with the weight 0.25"), "{said}");
    assert!(said.contains("the head keeps still: \"HeadYaw\""), "{said}");
    let (neutral, pinch) = (obj(&fixture.obj(0.0)), obj(&fixture.obj(0.3)));
    let found = frames(&fixture, "a.usda");
    assert!(farthest(&found[0], &neutral) < 1e-3, "{}", farthest(&found[0], &neutral));
    // The folds are 3 mm high, and are not in the handles. The unit is the centimetre.
    assert!(farthest(&found[2], &pinch) < 0.03, "{}", farthest(&found[2], &pinch));
    for h in 0..5 {
        let v = fixture.handle(h);
        for c in 0..3 {
            let half = (neutral[v][c] + pinch[v][c]) / 2.0;
            assert!((found[1][v][c] - half).abs() < 1e-4, "handle {h}: {:?} {half}", found[1][v]);
        }
    }
    fixture.done("verify a.usda --rig face.safetensors --take curves.csv");
}

#[test]
fn shapes_of_every_kind_of_file_move_the_handles_alike() {
    let fixture = solved(with_example);
    // In metres, and split as glTF splits vertices.
    fixture.done("export-shapes face.safetensors -o shapes.glb");
    fixture.done("export-shapes face.safetensors -o shapes.usda");
    fixture.write("with.toml", crate::common::PROJECT);
    std::fs::copy(fixture.path("face.safetensors"), fixture.path("with.safetensors")).unwrap();
    fixture.write("face.toml", without_example(crate::common::PROJECT));
    fixture.done("solve face.toml -o face.safetensors");
    let (neutral, pinch) = (obj(&fixture.obj(0.0)), obj(&fixture.obj(0.3)));
    for shapes in ["poses", "poses/*.obj", "shapes.glb", "shapes.usda", "with.toml", "with.safetensors"] {
        let animate = format!("animate face.safetensors curves.csv --shapes {shapes} -o a.usda");
        fixture.done(&animate);
        let found = frames(&fixture, "a.usda");
        for h in 0..5 {
            let v = fixture.handle(h);
            for (frame, weight) in [0.0, 0.5, 1.0].into_iter().enumerate() {
                for c in 0..3 {
                    let wanted = neutral[v][c] + weight * (pinch[v][c] - neutral[v][c]);
                    let off = (found[frame][v][c] - wanted).abs();
                    // What a rig exports of its example is off by its residual at most.
                    assert!(off < 2e-3, "{shapes}, handle {h}, frame {frame}: {off}");
                }
            }
        }
        let verify = "verify a.usda --rig face.safetensors --take curves.csv";
        fixture.done(&format!("{verify} --shapes {shapes}"));
        fixture
            .refused(verify, &["was made with shapes that curves weigh; give the same with --shapes SHAPES"]);
    }
}

#[test]
fn what_cannot_be_played_is_one_sentence() {
    let fixture = solved(without_example);
    fixture.refused(
        "animate face.safetensors curves.csv -o out/a.usda",
        &["curves.csv: holds curves, which are weights of shapes and no places", "see --shapes SHAPES"],
    );
    fixture.write("other.csv", "time,smile\n0,1\n");
    fixture.refused(
        "animate face.safetensors other.csv --shapes poses -o out/a.usda",
        &["no curve has the name of a shape: the curves are \"smile\", and poses has \"pinch\""],
    );
    fixture.refused(
        "animate face.safetensors take.csv --shapes poses -o out/a.usda",
        &["take.csv: is a take of places, so that --shapes poses changes nothing"],
    );
    fixture
        .refused("animate face.safetensors curves.csv --shapes nothing.glb -o out/a.usda", &["nothing.glb"]);
    fixture.refused(
        "animate face.safetensors curves.csv --shapes out -o out/a.usda",
        &["out: has no shapes, expected a file with blend shapes"],
    );
    fixture.refused(
        "animate face.safetensors curves.csv --shapes poses --take-unit mm -o out/a.usda",
        &["curves.csv: holds curves, which have no unit"],
    );
    fixture.refused(
        "prepare curves.csv --rig face.safetensors -o out/a.csv",
        &["curves.csv: is a table of curves, expected a raw take"],
    );
    // A mesh of another face.
    let other = Fixture::with_side(15);
    fixture.write("others/pinch.obj", other.obj(0.3));
    fixture.refused(
        "animate face.safetensors curves.csv --shapes others -o out/a.usda",
        &["others/pinch.obj: has 225 vertices, but the rig's mesh has 441"],
    );
}
