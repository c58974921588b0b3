//! Several takes as clips of one mesh with one set of shapes: as three.js and USD's own library play them,
//! and read back.

use crate::animation::{Animation, UvKind, animation, export_clips};
use crate::export::common::{input_error, python, root, run};
use crate::gltf::{assert_valid, node};
use rhytid_core::{Reach, RigidMotion, UpAxis, channel};
use rhytid_formats::animation as files;
use rhytid_formats::export::Options;
use rhytid_formats::export::{Shape, ShapeSet};
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;

const SHAPES: usize = 6;

/// Three takes of one mesh, of other lengths and at other times. Two of them have the same name.
fn takes(rates: [f64; 3]) -> Vec<Animation> {
    let all = animation(UvKind::PerCorner, 21, 61);
    let take = |range: std::ops::Range<usize>, rate: f64, first_time_code: f64| {
        let mut take = Animation { head: None, rate, first_time_code, ..all.clone() };
        take.frames = all.frames[range.clone()].to_vec();
        take.state("first_frame", range.start);
        take
    };
    vec![take(0..5, rates[0], 101.0), take(5..13, rates[1], 7.0), take(13..21, rates[2], 0.0)]
}

fn options() -> Options {
    let clips = ["walk", "talk", "walk"].map(str::to_owned).to_vec();
    Options { shapes: Some(SHAPES), clips, ..Options::default() }
}

const NAMES: [&str; 3] = ["walk", "talk", "walk 2"];

/// The largest distance of vertices from where a take has them, in mesh units.
fn farthest(shown: &[Vec<[f64; 3]>], take: &Animation) -> f64 {
    assert_eq!(shown.len(), take.frames.len());
    let mut worst = 0.0_f64;
    for (shown, [given, _]) in shown.iter().zip(&take.frames) {
        for (shown, given) in shown.iter().zip(given.as_chunks::<3>().0) {
            let off: f64 = shown.iter().zip(given).map(|(a, b)| (a - f64::from(*b)).powi(2)).sum();
            worst = worst.max(off.sqrt());
        }
    }
    worst
}

/// What our own reader gives of a clip, which differs in nothing else from what an export writes.
fn read(path: &Path, name: &str, take: &Animation) -> Vec<Vec<[f64; 3]>> {
    let mut reader = files::open_clip(path, Reach::Below, Some(name)).unwrap();
    let summary = reader.summary().clone();
    assert_eq!(summary.clips, NAMES);
    assert_eq!((summary.frames, summary.first_time_code), (take.frames.len(), take.first_time_code));
    assert!((summary.rate / take.rate - 1.0).abs() < 1e-6 && summary.fitted);
    assert_eq!(summary.recipe.as_ref().unwrap().difference(&take.recipe, &[]), None);
    assert_eq!(reader.compare(&take.scene()).unwrap(), [""; 0], "{name}");
    let mut out = Vec::new();
    let frame = |frame: usize| {
        reader.positions(frame, &mut out).unwrap();
        out.as_chunks::<3>().0.iter().map(|x| x.map(f64::from)).collect()
    };
    (0..take.frames.len()).map(frame).collect()
}

#[test]
fn three_js_plays_each_clip_within_its_stated_error() {
    let folder = tempfile::tempdir().unwrap();
    let mut made = takes([24.0, 60.0, 23.976]);
    let move_head = |take: &mut Animation, by: f64| {
        let motion =
            |i: usize| RigidMotion { translation: [by * i as f64, 0.5, 0.0], ..RigidMotion::IDENTITY };
        take.head = Some((0..take.frames.len()).map(motion).collect());
    };
    for (label, options, with_head) in [
        ("shapes.glb", options(), false),
        ("heads.gltf", Options { quantize: true, ..options() }, true),
        ("small.glb", Options { shapes: None, max_error: Some(0.4), meshopt: true, ..options() }, true),
    ] {
        if with_head {
            move_head(&mut made[0], 0.25);
            move_head(&mut made[2], -0.5);
        }
        let path = folder.path().join(label);
        let written = export_clips(&made, &path, &options).unwrap();
        assert_eq!(written.errors.len(), 3);
        assert_valid(std::slice::from_ref(&path));
        let shown = &node("clips.mjs", std::slice::from_ref(&path))[0]["clips"];
        for (i, (take, name)) in made.iter().zip(NAMES).enumerate() {
            let clip = &shown[i];
            assert_eq!(clip["name"], name);
            let stated = written.errors[i].worst;
            let unit = take.metres_per_unit;
            let frames: Vec<Vec<[f64; 3]>> = serde_json::from_value(clip["frames"].clone()).unwrap();
            let heads: Vec<[f64; 3]> = serde_json::from_value(clip["heads"].clone()).unwrap();
            let in_mesh = |[x, y, z]: [f64; 3]| match take.up_axis {
                UpAxis::Y => [x, y, z].map(|x| x / unit),
                UpAxis::Z => [x, -z, y].map(|x| x / unit),
            };
            let frames: Vec<Vec<[f64; 3]>> =
                frames.into_iter().map(|frame| frame.into_iter().map(in_mesh).collect()).collect();
            let worst = farthest(&frames, take);
            assert!(worst <= 1.02 * stated && worst > 0.5 * stated, "{label}, {name}: {worst}, {stated}");
            for (frame, head) in heads.into_iter().enumerate() {
                let expected = take.head.as_ref().map_or([0.0; 3], |head| head[frame].translation);
                let off = (0..3).map(|c| (in_mesh(head)[c] - expected[c]).abs()).fold(0.0, f64::max);
                assert!(!with_head || off < 1e-4, "{label}, {name}, frame {frame}: {off}");
            }
            let ours = farthest(&read(&path, name, &verified(take, with_head)), take);
            assert!(ours <= stated, "{label}, {name}: {ours}, stated {stated}");
        }
        let message = input_error(files::open_clip(&path, Reach::Below, Some("run")).map(|_| ()));
        let expected = "has no clip \"run\", expected one of \"walk\", \"talk\", \"walk 2\"";
        assert!(message.contains(expected), "{message}");
    }
}

/// The take as `verify` compares it: a head that never moves need not be known.
fn verified(take: &Animation, with_head: bool) -> Animation {
    let still = || vec![RigidMotion::IDENTITY; take.frames.len()];
    let head = if with_head { Some(take.head.clone().unwrap_or_else(still)) } else { None };
    Animation { head, ..take.clone() }
}

#[test]
fn usd_plays_each_clip_once_it_is_bound() {
    let folder = tempfile::tempdir().unwrap();
    let made = takes([30.0; 3]);
    let mut stated = Vec::new();
    for extension in ["usd", "usda", "usdz"] {
        let path = folder.path().join(format!("clips.{extension}"));
        stated = export_clips(&made, &path, &options()).unwrap().errors;
        for ((take, name), error) in made.iter().zip(NAMES).zip(&stated) {
            let worst = farthest(&read(&path, name, take), take);
            assert!(worst <= error.worst && worst > 0.5 * error.worst, "{extension}, {name}: {worst}");
        }
    }
    let clips = made.iter().zip(NAMES).zip(&stated).map(|((take, name), error)| {
        json!({
            "name": name,
            "first": take.first_time_code,
            "worst": error.worst,
            "frames": take.frames.iter().map(|[positions, _]| positions).collect::<Vec<_>>(),
        })
    });
    let expected = json!({ "rate": 30.0, "shapes": SHAPES, "clips": clips.collect::<Vec<Value>>() });
    std::fs::write(folder.path().join("expected.json"), expected.to_string()).unwrap();
    let script = root().join("crates/formats/tests/formats/export/usd_clips_check.py");
    let printed = run(Command::new(python()).arg(script).arg(folder.path()));
    assert_eq!(printed.matches("within").count(), 9, "{printed}");
}

#[test]
fn what_has_one_place_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let export = |name: &str, takes: &[Animation], options: &Options| {
        let path = folder.path().join(name);
        let message = input_error(export_clips(takes, &path, options));
        assert!(!path.exists(), "{name}");
        message
    };
    let exact = Options::default();
    for (name, expected) in [
        ("a.usd", "holds one take where each frame is exact"),
        ("a.glb", "holds one take where each frame is exact"),
    ] {
        let message = export(name, &takes([30.0; 3]), &exact);
        assert!(message.contains(expected), "{message}");
    }
    let plain = |take: Animation| Animation { with_normals: false, others: Vec::new(), ..take };
    let bare: Vec<Animation> = takes([30.0; 3]).into_iter().map(plain).collect();
    assert!(export("a.pc2", &bare, &options()).contains("a point cache holds one take"));
    let message = export("a.usd", &takes([30.0, 24.0, 30.0]), &options());
    assert!(message.contains("the takes have 30 and 24 and 30 frames per second"), "{message}");
    let mut heads = takes([30.0; 3]);
    heads[1].head = Some(vec![RigidMotion::IDENTITY; 8]);
    let message = export("a.usda", &heads, &options());
    assert!(message.contains("the takes say how the head moves"), "{message}");
}

/// A set with the take's mesh at rest and two shapes.
fn set(take: &Animation) -> ShapeSet {
    let shape = |k: usize| {
        let wave = |v: usize, c: usize| (1.7 * (k + 1) as f32 * (3 * v + c) as f32).sin();
        let offsets = (0..take.rest.len()).map(|v| [wave(v, 0), wave(v, 1), wave(v, 2)]).collect();
        Shape { name: format!("wave{k}"), offsets, normal_offsets: None }
    };
    ShapeSet { base: take.rest.clone(), base_normals: None, shapes: vec![shape(0), shape(1)] }
}

#[test]
fn given_shapes_come_along_with_the_weights_that_made_the_frames() {
    let folder = tempfile::tempdir().unwrap();
    let all = animation(UvKind::PerCorner, 4, 9);
    let mut take = Animation { with_normals: false, others: Vec::new(), head: None, ..all };
    let set = set(&take);
    let weights = [[0.0, 0.0], [0.25, 1.0], [1.0, 0.5], [0.125, 0.75]];
    for ([positions, _], weights) in take.frames.iter_mut().zip(weights) {
        for (i, x) in positions.iter_mut().enumerate() {
            *x = set.base.as_flattened()[i];
            for (shape, w) in set.shapes.iter().zip(weights) {
                *x += w * shape.offsets.as_flattened()[i];
            }
        }
    }
    let options = Options { onto: Some(set.clone()), ..Options::default() };
    for name in ["onto.glb", "onto.usda"] {
        let path = folder.path().join(name);
        let written = take.export_with(&path, &options).unwrap();
        assert_eq!(written.targets, Some(2));
        assert!(written.errors[0].worst < 1e-4, "{:?}", written.errors);
        let read = rhytid_formats::mesh::read_shapes(&path).unwrap();
        let names: Vec<&str> = read.shapes.iter().map(|shape| &*shape.name).collect();
        assert_eq!(names, ["wave0", "wave1"], "{name}");
        let mut reader = files::open(&path).unwrap();
        assert!(reader.compare(&take.scene()).unwrap().is_empty(), "{name}");
        let mut out = Vec::new();
        reader.channel(&channel::POSITIONS, 2, &mut out).unwrap();
        let off = out.iter().zip(&take.frames[2][0]).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 1e-4, "{name}: {off}");
    }
    let shown = &node("clips.mjs", &[folder.path().join("onto.glb")])[0]["clips"][0];
    let found: Vec<[f64; 2]> = serde_json::from_value(shown["weights"].clone()).unwrap();
    for (found, expected) in found.iter().flatten().zip(weights.as_flattened()) {
        assert!((found - f64::from(*expected)).abs() < 1e-4, "{found} {expected}");
    }
    let table = folder.path().join("onto.csv");
    take.export_with(&table, &options).unwrap();
    let curves = rhytid_formats::curves::read(&table, None).unwrap();
    assert_eq!(curves.names, ["wave0", "wave1"]);
    for (found, expected) in curves.weights.iter().zip(weights.as_flattened()) {
        assert!((found - expected).abs() < 1e-4, "{found} {expected}");
    }
    let takes = [take.clone(), take.clone()];
    let message = input_error(export_clips(&takes, &table, &options));
    assert!(message.contains("a table of weights holds one take"), "{message}");
    let strained = animation(UvKind::None, 2, 9);
    if !strained.others.is_empty() {
        let message = input_error(strained.export_with(&folder.path().join("a.glb"), &options));
        assert!(message.contains("shapes that are given say nothing of"), "{message}");
    }
}
