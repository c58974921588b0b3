//! A take as so many shapes with curves, as USD's own skeleton library plays it, and read back.
use super::common::{EXTENSIONS, input_error, python, python_usd_24_3, root, run};
use crate::animation::{Animation, UvKind, with_everything};
use rhytid_core::{RigidMotion, channel};
use rhytid_formats::animation;
use rhytid_formats::export::Options;
use rhytid_formats::usd;
use serde_json::json;
use std::path::Path;
use std::process::Command;

const SHAPES: usize = 4;

fn made(with_normals: bool) -> Animation {
    let all = with_everything(UvKind::PerCorner, 12, 61);
    Animation { with_normals, others: Vec::new(), first_time_code: 101.0, ..all }
}

fn options() -> Options {
    Options { shapes: Some(SHAPES), ..Options::default() }
}

fn check(python: &Path) {
    for with_normals in [true, false] {
        let folder = tempfile::tempdir().unwrap();
        let made = made(with_normals);
        let mut worst = 0.0;
        for extension in ["usd", "usdc", "usda", "usdz"] {
            let path = folder.path().join(format!("baked.{extension}"));
            let written = made.export_with(&path, &options()).unwrap();
            assert_eq!(written.bytes, std::fs::metadata(&path).unwrap().len());
            assert_eq!(written.targets, Some(SHAPES));
            worst = written.errors[0].worst;
            read(&path, &made, worst);
        }
        let expected = json!({
            "worst": worst,
            "shapes": SHAPES,
            "rate": made.rate,
            "frames": made.frames.iter().map(|[positions, _]| positions).collect::<Vec<_>>(),
            "head": made.head.as_ref().unwrap().iter().map(RigidMotion::matrix).collect::<Vec<_>>(),
        });
        std::fs::write(folder.path().join("expected.json"), expected.to_string()).unwrap();
        let script = root().join("crates/formats/tests/formats/export/usd_baked_check.py");
        let printed = run(Command::new(python).arg(script).arg(folder.path()));
        assert_eq!(printed.matches("4 shapes within").count(), 4, "{printed}");
    }
}

/// Our own reader gives the frames within the error, in any order.
fn read(path: &Path, made: &Animation, worst: f64) {
    let mut reader = animation::open(path).unwrap();
    let summary = reader.summary().clone();
    assert_eq!((summary.vertices, summary.frames), (made.rest.len(), made.frames.len()));
    assert_eq!(
        (summary.has(&channel::NORMALS), summary.head, summary.extents),
        (made.with_normals, true, true)
    );
    assert!(summary.fitted);
    assert_eq!((summary.first_time_code, summary.rate), (made.first_time_code, made.rate));
    assert_eq!(summary.recipe.as_ref(), Some(&made.recipe));
    assert!((summary.stated_error.unwrap().worst / worst - 1.0).abs() < 1e-9);
    let mut out = Vec::new();
    for frame in (0..summary.frames).rev() {
        reader.positions(frame, &mut out).unwrap();
        for (found, given) in out.as_chunks::<3>().0.iter().zip(made.frames[frame][0].as_chunks::<3>().0) {
            let off: f64 = found.iter().zip(given).map(|(a, b)| f64::from(a - b).powi(2)).sum();
            assert!(off.sqrt() <= worst, "{}, stated {worst}", off.sqrt());
        }
        // The box is around the points, and not much larger.
        let [low, high] = reader.extent(frame).unwrap().unwrap();
        let bounds = |end: fn(f32, f32) -> f32, begin: f32| {
            let points = out.as_chunks::<3>().0.iter();
            points.fold([begin; 3], |all, x| std::array::from_fn(|c| end(all[c], x[c])))
        };
        for (inside, outside) in bounds(f32::min, f32::MAX).into_iter().zip(low) {
            assert!((0.0..2e-5).contains(&(inside - outside)), "{inside} {outside}");
        }
        for (inside, outside) in bounds(f32::max, f32::MIN).into_iter().zip(high) {
            assert!((0.0..2e-5).contains(&(outside - inside)), "{inside} {outside}");
        }
        reader.channel(&channel::NORMALS, frame, &mut out).unwrap();
        assert_eq!(out.len(), if made.with_normals { 3 * made.rest.len() } else { 0 });
        assert_eq!(reader.head(frame).unwrap(), made.head.as_ref().map(|head| head[frame].matrix()));
    }
}

#[test]
fn usd_plays_the_shapes_within_the_stated_error() {
    check(&python());
}

#[test]
fn the_oldest_usd_plays_the_shapes_too() {
    check(&python_usd_24_3());
}

#[test]
fn what_has_no_place_beside_shapes_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for extension in EXTENSIONS.iter().filter(|extension| extension.starts_with("usd")) {
        let path = folder.path().join(format!("baked.{extension}"));
        let all = with_everything(UvKind::None, 2, 5);
        let message = input_error(all.export_with(&path, &options()));
        assert!(message.contains("no place for velocities, sigma, strain, strainDirection1"), "{message}");
    }
    let path = folder.path().join("part.usd");
    made(true).export_with(&path, &options()).unwrap();
    let message = input_error(usd::stitch(&[path], &folder.path().join("whole.usd")));
    assert!(message.contains("part.usd: holds shapes with curves"), "{message}");
}

/// The text with other numbers, which fit each other no longer.
#[test]
fn shapes_that_do_not_fit_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("baked.usda");
    made(true).export_with(&path, &options()).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    for (from, to, expected) in [
        (r#"def BlendShape "shape_02""#, r#"def BlendShape "shape_20""#, "not those that are animated"),
        (
            "uniform vector3f[] offsets = [(",
            "uniform vector3f[] offsets = [(0, 0, 0), (",
            "an offset for each vertex",
        ),
        ("normal3f[] normals = [(", "normal3f[] normals = [(0, 0, 1), (", "another number of normals"),
    ] {
        assert!(text.contains(from), "{from}");
        std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let message = input_error(animation::open(&path).map(|_| ()));
        assert!(message.contains(expected), "{message}");
    }
    let samples = text.find("blendShapeWeights.timeSamples").unwrap();
    let first = samples + text[samples..].find(": [").unwrap() + 3;
    std::fs::write(&path, format!("{}0, {}", &text[..first], &text[first..])).unwrap();
    let message = input_error(animation::open(&path).unwrap().positions(0, &mut Vec::new()));
    assert!(
        message.contains("weights at time code 101 have not one from 0 to 1 for each shape"),
        "{message}"
    );
}
