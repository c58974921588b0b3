//! USD text, as USD's own library reads it.
use crate::animation::{Animation, ROUNDED_TWICE, Random, UvKind, animation};
use crate::common::{python, root, run};
use rhytid_core::{Faces, UpAxis};
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

/// Every number of `animation` becomes an extreme or random bits. (The normals have no length of 1 then, which
/// USD does not mind.)
fn with_extreme_numbers(mut animation: Animation, seed: u64) -> Animation {
    let mut random = Random(seed);
    let mut extremes = EXTREMES.iter().cycle();
    let mut next = || if random.below(2) == 0 { *extremes.next().unwrap() } else { random.finite() };
    animation.rest.as_flattened_mut().fill_with(&mut next);
    animation.rest_normals.as_flattened_mut().fill_with(&mut next);
    for numbers in animation.frames.iter_mut().flatten() {
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
    if let Some(uvs) = &animation.uvs {
        dump("uvs.bin", uvs.values.as_flattened());
    }
    let expectation = json!({
        "identifier": identifier,
        "frames": animation.frames.len(),
        "vertices": animation.rest.len(),
        "counts": animation.faces.counts,
        "indices": animation.faces.indices,
        "uv_corners": animation.uvs.as_ref().map(|uvs| &uvs.corners),
        "metres_per_unit": animation.metres_per_unit,
        "up_axis": animation.up_axis,
        "rate": animation.rate,
        "first_time_code": animation.first_time_code,
    });
    std::fs::write(folder.join("expected.json"), expectation.to_string()).unwrap();
}

#[test]
fn usd_reads_back_every_bit_and_its_validators_report_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let cases = cases();
    for (i, (animation, identifier)) in cases.iter().enumerate() {
        let case = folder.path().join(format!("case{i}"));
        std::fs::create_dir(&case).unwrap();
        animation.export(&case.join("face.usda")).unwrap();
        write_expectation(&case, animation, identifier);
    }
    let script = root().join("crates/formats/tests/export/usd_check.py");
    let printed = run(Command::new(python()).arg(script).arg(folder.path()));
    assert!(printed.contains(&format!("{} files hold what was expected", cases.len())), "{printed}");
}

#[test]
fn lines_stay_short_enough_for_an_editor() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.usda");
    with_extreme_numbers(animation(UvKind::PerCorner, 3, 18), 19).export(&path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let longest = text.lines().map(str::len).max().unwrap();
    assert!(longest < 600, "{longest}");
}
