//! Packed rigs: as near to the whole rig as they say, for every command, and refused where they cannot be.

use crate::common::{Fixture, assert_documented};
use rhytid::core::rig_file;
use rhytid::formats::animation;

fn solved() -> Fixture {
    let f = Fixture::with_side(41);
    f.done("solve face.toml -o face.safetensors");
    f
}

fn json(f: &Fixture, args: &str) -> serde_json::Value {
    serde_json::from_str(&f.done(args)).unwrap()
}

/// The largest distance of a vertex between two animations, in the mesh's unit.
fn apart(f: &Fixture, names: [&str; 2]) -> f64 {
    let [mut a, mut b] = names.map(|name| animation::open(&f.path(name)).unwrap());
    assert_eq!(a.summary().frames, b.summary().frames);
    let (mut x, mut y) = (Vec::new(), Vec::new());
    let mut worst = 0.0_f64;
    for frame in 0..a.summary().frames {
        a.positions(frame, &mut x).unwrap();
        b.positions(frame, &mut y).unwrap();
        for (a, b) in x.as_chunks::<3>().0.iter().zip(y.as_chunks::<3>().0) {
            let square: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
            worst = worst.max(square.sqrt());
        }
    }
    worst
}

#[test]
fn animations_of_a_packed_rig_are_as_near_as_it_says() {
    let f = solved();
    let said = json(&f, "pack face.safetensors take.csv -o small.safetensors --max-error 0.1 --json");
    assert_documented(&said, "pack");
    assert_eq!(said["bytes"], f.read("small.safetensors").len());
    assert_eq!(said["bytes_before"], f.read("face.safetensors").len());
    assert!(2 * said["bytes"].as_u64().unwrap() < said["bytes_before"].as_u64().unwrap(), "{said}");
    let frames = f.read_text("take.csv").lines().count() - 1;
    assert_eq!(said["poses"], 2 * f.read_text("face.toml").matches("[[example]]").count() + frames);
    assert!(said["worst_mm"].as_f64().unwrap() <= 0.1, "{said}");
    for rig in ["face", "small"] {
        f.done(&format!("animate {rig}.safetensors take.csv --device cpu:0 -o {rig}.usd"));
    }
    let metres_per_unit = rig_file::read(&f.path("face.safetensors")).unwrap().surface().metres_per_unit;
    let worst = 1e3 * metres_per_unit * apart(&f, ["face.usd", "small.usd"]);
    assert!(worst <= said["finished_worst_mm"].as_f64().unwrap() * 1.001 + 1e-4, "{worst} mm, {said}");
    assert!(worst > 0.01, "{worst} mm: nothing was rounded");
    f.done("verify small.usd --rig small.safetensors --take take.csv --device cpu:0");

    let info = json(&f, "info small.safetensors --json");
    for key in ["poses", "worst_mm", "rms_mm", "normals_rms_degrees", "finished_worst_mm", "finished_beyond"]
    {
        assert_eq!(info["packed"][key], said[key], "{key}");
    }
    let whole = rig_file::hash(&f.path("face.safetensors")).unwrap();
    assert_eq!(info["packed"]["whole_rig"], whole);
    assert!(f.done("info small.safetensors").contains("packed"));
    assert!(!f.done("info face.safetensors").contains("packed"));
}

#[test]
fn solve_packs_as_pack_does() {
    let f = solved();
    let solved =
        json(&f, "solve face.toml -o again.safetensors --pack out/small.safetensors --max-error 0.2 --json");
    let mut said = json(&f, "pack again.safetensors -o small.safetensors --max-error 0.2 --json");
    assert_eq!(f.read("out/small.safetensors"), f.read("small.safetensors"));
    said["file"] = "out/small.safetensors".into();
    assert_eq!(solved["packed"], said);
    let finer = json(&f, "pack face.safetensors -o finer.safetensors --max-error 0.002 --json");
    assert!(finer["worst_mm"].as_f64().unwrap() <= 0.002);
    assert!(finer["bytes"].as_u64() > said["bytes"].as_u64());
}

#[test]
fn what_cannot_be_packed_is_refused() {
    let f = solved();
    f.done("pack face.safetensors -o small.safetensors");
    f.refused("pack small.safetensors -o out/b.safetensors", &["small.safetensors", "packed already"]);
    f.refused("pack face.safetensors -o out/b.usd", &["out/b.usd", ".safetensors"]);
    f.refused("pack face.safetensors -o out/b.safetensors --soft-markers", &["no take is given"]);
    f.refused("pack take.csv -o out/b.safetensors", &["take.csv", "is a take", "a rig"]);
    f.refused("pack face.safetensors face.toml -o out/b.safetensors", &["face.toml", "is a project"]);
    f.refused(
        "pack face.safetensors -o out/b.safetensors --max-error 0.000001",
        &["no rounding", "allow a larger one"],
    );
    f.refused(
        "solve face.toml -o out/b.safetensors --pack out/../out/b.safetensors",
        &["out/b.safetensors", "two outputs"],
    );
    f.refused("solve face.toml -o out/b.safetensors --max-error 1", &["required arguments"]);
}
