//! Animations as USD, as USD's own library reads them.
use super::common::{python, python_usd_24_3, root, run};
use crate::animation::{Animation, ROUNDED_TWICE, Random, UvKind, animation, with_everything};
use rhytid_core::channel::Quantity;
use rhytid_core::{Faces, Materials, UpAxis};
use serde_json::json;
use std::path::Path;
use std::process::Command;

/// Numbers at the limits of `f32`, and numbers whose shortest text is long.
const EXTREMES: [f32; 22] = [
    0.0,
    -0.0,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    1e-45,
    -1e-45,
    1.175_494_2e-38,
    f32::MAX,
    f32::MIN,
    1e30,
    -1e30,
    16_777_216.0,
    16_777_218.0,
    -16_777_215.0,
    0.1,
    1.0 / 3.0,
    1e-7,
    9.999_999e9,
    1e16,
    123_456.79,
    // Read by way of `f64`, the shortest text of these is another number.
    ROUNDED_TWICE,
    -ROUNDED_TWICE,
];

/// Every number of `animation` becomes an extreme or random bits. (The normals have no length of 1 then,
/// which USD does not mind.)
fn with_extreme_numbers(mut animation: Animation, seed: u64) -> Animation {
    let mut random = Random(seed);
    let mut extremes = EXTREMES.iter().cycle();
    let mut next = || if random.below(2) == 0 { *extremes.next().unwrap() } else { random.finite() };
    animation.rest.as_flattened_mut().fill_with(&mut next);
    animation.rest_normals.as_flattened_mut().fill_with(&mut next);
    for numbers in animation.frames.iter_mut().flatten() {
        numbers.fill_with(&mut next);
    }
    for numbers in animation.others.iter_mut().flat_map(|other| &mut other.frames) {
        numbers.fill_with(&mut next);
    }
    if let Some(uvs) = &mut animation.uvs {
        uvs.values.as_flattened_mut().fill_with(&mut next);
    }
    animation
}

fn cases() -> Vec<(Animation, &'static str)> {
    let base = animation(UvKind::None, 5, 10);
    let mut triangle = animation(UvKind::None, 1, 11);
    triangle.faces = Faces { counts: vec![3], indices: vec![4, 2, 0] };
    triangle.triangle_corners = vec![[0, 1, 2]];
    let everything = with_everything(UvKind::PerCorner, 4, 21);
    let mut partly = everything.clone();
    partly.materials = Some(Materials::named(
        ["skin"],
        (0..partly.faces.len()).map(|f| if f % 3 == 0 { 0 } else { Materials::NONE }).collect(),
    ));
    let mut still = with_everything(UvKind::None, 6, 22);
    still.frames = vec![still.frames[0].clone(); 6];
    vec![
        (base.clone(), "face"),
        (triangle, "face"),
        (animation(UvKind::PerVertex, 3, 12), "face"),
        (Animation { up_axis: UpAxis::Z, ..animation(UvKind::PerCorner, 3, 13) }, "face"),
        (Animation { name: "1st scan \"Zoë\"\n\\ 100 %".into(), ..base.clone() }, "_1st_scan__Zo_____100__"),
        (Animation { name: String::new(), metres_per_unit: 1.0, ..base.clone() }, "_"),
        (Animation { rate: 30.0 / 1.001, first_time_code: 1001.0, ..base.clone() }, "face"),
        (Animation { rate: 120.0, first_time_code: -2.5, metres_per_unit: 0.0254, ..base }, "face"),
        (with_extreme_numbers(animation(UvKind::PerVertex, 200, 14), 15), "face"),
        (with_extreme_numbers(animation(UvKind::PerCorner, 200, 16), 17), "face"),
        (everything.clone(), "face"),
        (Animation { with_normals: false, ..everything }, "face"),
        (partly, "face"),
        (still, "face"),
        (with_extreme_numbers(with_everything(UvKind::PerVertex, 50, 23), 24), "face"),
    ]
}

/// Writes what the checker compares with: JSON for the small things, little endian `f32` for arrays.
fn write_expectation(folder: &Path, animation: &Animation, identifier: &str) {
    let dump = |name: &str, numbers: &[f32]| {
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        std::fs::write(folder.join(name), bytes).unwrap();
    };
    let stage = |i: usize| animation.frames.iter().flat_map(|frame| frame[i].clone()).collect::<Vec<f32>>();
    dump("rest.bin", animation.rest.as_flattened());
    dump("rest_normals.bin", animation.rest_normals.as_flattened());
    dump("points.bin", &stage(0));
    dump("normals.bin", &stage(1));
    for other in &animation.others {
        dump(&format!("{}.bin", other.channel.name), &other.frames.concat());
    }
    if let Some(uvs) = &animation.uvs {
        dump("uvs.bin", uvs.values.as_flattened());
    }
    let expectation = json!({
        "identifier": identifier,
        "name": animation.name,
        "frames": animation.frames.len(),
        "vertices": animation.rest.len(),
        "counts": animation.faces.counts,
        "indices": animation.faces.indices,
        "uv_corners": animation.uvs.as_ref().map(|uvs| &uvs.corners),
        "metres_per_unit": animation.metres_per_unit,
        "up_axis": animation.up_axis,
        "rate": animation.rate,
        "first_time_code": animation.first_time_code,
        "with_normals": animation.with_normals,
        "materials": animation.materials.as_ref().map(|m| json!({ "names": m.names().collect::<Vec<_>>(), "of_face": m.of_face })),
        "head": animation.head.as_ref().map(|head| {
            head.iter().map(|motion| json!([motion.rotation, motion.translation])).collect::<Vec<_>>()
        }),
        "channels": animation.others.iter().map(|other| {
            json!({ "name": other.channel.name, "width": other.channel.width, "is_direction": other.channel.quantity == Quantity::Direction })
        }).collect::<Vec<_>>(),
        "recipe": animation.recipe,
    });
    std::fs::write(folder.join("expected.json"), expectation.to_string()).unwrap();
}

/// Every case as every kind of USD file, checked by one version of USD.
fn check(python: &Path, cases: &[(Animation, &'static str)]) {
    let folder = tempfile::tempdir().unwrap();
    for (i, (animation, identifier)) in cases.iter().enumerate() {
        let case = folder.path().join(format!("case{i}"));
        std::fs::create_dir(&case).unwrap();
        for extension in ["usd", "usdc", "usda", "usdz"] {
            let path = case.join(format!("face.{extension}"));
            let written = animation.export(&path).unwrap();
            assert_eq!(written.bytes, std::fs::metadata(&path).unwrap().len(), "{extension}");
        }
        write_expectation(&case, animation, identifier);
    }
    let script = root().join("crates/formats/tests/formats/export/usd_check.py");
    let printed = run(Command::new(python).arg(script).arg(folder.path()));
    assert!(printed.contains(&format!("{} files hold what was expected", 4 * cases.len())), "{printed}");
}

#[test]
fn usd_reads_back_every_bit_and_its_validators_report_nothing() {
    check(&python(), &cases());
}

#[test]
fn the_oldest_usd_reads_back_every_bit_too() {
    check(&python_usd_24_3(), &cases());
}

#[test]
fn what_is_there_already_is_not_written_again() {
    let folder = tempfile::tempdir().unwrap();
    let size = |frames: usize, different: bool| {
        let mut animation = animation(UvKind::None, frames, 30);
        if !different {
            animation.frames = vec![animation.frames[0].clone(); frames];
        }
        animation.export(&folder.path().join("face.usd")).unwrap().bytes
    };
    let (one, same, different) = (size(1, false), size(101, false), size(101, true));
    // A time and three representations for each frame, against two arrays of 34 vertices.
    assert!(same - one < 100 * 40, "{one} {same}");
    assert!(different - one > 100 * 2 * 34 * 12, "{one} {different}");
}

#[test]
fn the_same_animation_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    for extension in ["usd", "usda", "usdz"] {
        let write = |name: &str| {
            let subfolder = folder.path().join(name);
            std::fs::create_dir_all(&subfolder).unwrap();
            let path = subfolder.join(format!("face.{extension}"));
            with_everything(UvKind::PerCorner, 5, 31).export(&path).unwrap();
            std::fs::read(path).unwrap()
        };
        assert!(write("a") == write("b"), "{extension}");
    }
}
