//! Memory does not grow with the frames. (This is a process of its own, because the test measures the peak of
//! its memory.)
#![cfg(target_os = "linux")]

use rhytid_core::{Faces, NoProgress, UpAxis, channel};
use rhytid_formats::animation;
use rhytid_formats::export::{Frame, Options, Scene, StatedRecipe};
use rhytid_test_support::peak;
use std::path::Path;

const VERTICES: usize = 50_000;

fn export(path: &Path, frames: usize, options: &Options) {
    let rest = vec![[0.5; 3]; VERTICES];
    let mut faces = Faces::default();
    faces.push(&[0, 1, 2]);
    let scene = Scene {
        name: "face",
        rest: &rest,
        rest_normals: Some(&rest),
        channels: std::slice::from_ref(&channel::NORMALS),
        faces: &faces,
        triangle_corners: &[[0, 1, 2]],
        uvs: None,
        materials: None,
        head: None,
        metres_per_unit: 0.001,
        up_axis: UpAxis::Y,
        frames,
        rate: 30.0,
        first_time_code: 0.0,
        recipe: &StatedRecipe::default(),
        further: &[],
    };
    let mut exporter = animation::create(path, &scene, options).unwrap();
    let mut positions = vec![0.0; 3 * VERTICES];
    let normals = vec![0.5; 3 * VERTICES];
    for k in 0..frames {
        positions.iter_mut().enumerate().for_each(|(i, x)| *x = ((i * (k + 1)) as f32 * 0.1).sin());
        exporter.frame(&Frame::new(&positions).with(&channel::NORMALS, &normals)).unwrap();
    }
    exporter.finish(&NoProgress).unwrap();
}

#[test]
fn memory_does_not_grow_with_the_frames() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.glb");
    for (quantize, meshopt) in [(false, false), (false, true), (true, true)] {
        let options = Options { quantize, meshopt, ..Options::default() };
        export(&path, 4, &options);
        let before = peak();
        export(&path, 60, &options);
        // 56 more frames: 67 MB of numbers as they come in.
        let more = peak() - before;
        assert!(more < 8 << 20, "{options:?}: {more} bytes more for 56 more frames");
        // And what is read.
        let mut reader = animation::open(&path).unwrap();
        let mut out = Vec::new();
        (0..60).for_each(|k| reader.positions(k, &mut out).unwrap());
    }
}
