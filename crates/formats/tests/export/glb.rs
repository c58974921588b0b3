//! GLB, as the `gltf` crate and Khronos' validator read it.
use crate::animation::{Animation, ROUNDED_TWICE, Random, UvKind, animation};
use crate::common::{input_error, root, run};
use gltf::animation::util::ReadOutputs;
use gltf::animation::{Interpolation, Property};
use rhytid_core::UpAxis;
use rhytid_formats::export;
use serde_json::Value;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::process::Command;

fn cases() -> Vec<Animation> {
    let base = animation(UvKind::None, 5, 20);
    let mut random = Random(21);
    // Small and large numbers, and numbers with many digits; sums stay finite.
    let mut wide = animation(UvKind::PerCorner, 40, 22);
    let mut next = || loop {
        let x = random.finite();
        if x.abs() < 1e37 {
            return x;
        }
    };
    wide.rest.as_flattened_mut().fill_with(&mut next);
    wide.frames.iter_mut().for_each(|[positions, _]| positions.fill_with(&mut next));
    // A bound that must not be told as its neighbour.
    let mut shifted = animation(UvKind::None, 2, 32);
    shifted.rest.iter_mut().for_each(|p| p[2] = 0.0);
    shifted.frames[1][0].chunks_mut(3).for_each(|p| p[2] = ROUNDED_TWICE);
    vec![
        animation(UvKind::PerVertex, 7, 23),
        Animation { up_axis: UpAxis::Z, ..animation(UvKind::PerCorner, 3, 24) },
        animation(UvKind::PerCorner, 1, 25),
        Animation { name: "1st scan \"Zoë\"\n\\ 100 %".into(), metres_per_unit: 1.0, ..base.clone() },
        Animation { rate: 30.0 / 1.001, first_time_code: 1001.0, ..base.clone() },
        Animation { rate: 120.0, first_time_code: -2.5, name: String::new(), ..base },
        wide,
        shifted,
    ]
}

/// What a viewer holds of a file.
struct Read {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Option<Vec<[f32; 2]>>,
    indices: Vec<u32>,
    targets: Vec<[Vec<[f32; 3]>; 2]>,
    times: Vec<f32>,
    /// frames × targets.
    weights: Vec<f32>,
}

fn read(path: &Path) -> (Read, gltf::Document) {
    let bytes = std::fs::read(path).unwrap();
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&bytes).unwrap();
    let blob = blob.unwrap();
    let mesh = document.meshes().next().unwrap();
    let primitive = mesh.primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(&blob));
    let animation = document.animations().next().unwrap();
    let channel = animation.channels().next().unwrap();
    assert_eq!(channel.target().property(), Property::MorphTargetWeights);
    assert_eq!(channel.sampler().interpolation(), Interpolation::Linear);
    let animated = channel.reader(|_| Some(&blob));
    let Some(ReadOutputs::MorphTargetWeights(weights)) = animated.read_outputs() else {
        panic!("the animation has no weights")
    };
    let read = Read {
        positions: reader.read_positions().unwrap().collect(),
        normals: reader.read_normals().unwrap().collect(),
        uvs: reader.read_tex_coords(0).map(|uvs| uvs.into_f32().collect()),
        indices: reader.read_indices().unwrap().into_u32().collect(),
        targets: reader
            .read_morph_targets()
            .map(|(positions, normals, tangents)| {
                assert!(tangents.is_none());
                [positions.unwrap().collect(), normals.unwrap().collect()]
            })
            .collect(),
        times: animated.read_inputs().unwrap().collect(),
        weights: weights.into_f32().collect(),
    };
    (read, document)
}

/// Sums of two `f32` and a difference before: a few roundings of the largest number involved.
fn assert_close(sum: f32, expected: f32, base: f32) {
    let tolerance = 2.0 * f32::EPSILON * expected.abs().max(base.abs());
    assert!((sum - expected).abs() <= tolerance, "{sum}, expected {expected}");
}

#[test]
fn base_plus_target_gives_each_frame_back() {
    let folder = tempfile::tempdir().unwrap();
    for (i, animation) in cases().iter().enumerate() {
        let path = folder.path().join(format!("{i}.glb"));
        animation.export(&path).unwrap();
        let (read, _) = read(&path);
        let vertices = animation.rest.len();
        assert_eq!(read.positions[..vertices], animation.rest);
        let frames = animation.frames.len();
        assert_eq!((read.targets.len(), read.times.len()), (frames, frames));

        // At its own time a frame has the weight 1 and every other 0.
        for (k, weight) in read.weights.iter().enumerate() {
            assert_eq!(*weight, if k / frames == k % frames { 1.0 } else { 0.0 });
        }
        assert_eq!(read.weights.len(), frames * frames);
        for (k, &time) in read.times.iter().enumerate() {
            assert_eq!(time, (k as f64 / animation.rate) as f32);
        }

        for ([positions, normals], [position_offsets, normal_offsets]) in
            animation.frames.iter().zip(&read.targets)
        {
            for v in 0..vertices {
                for axis in 0..3 {
                    let (rest, n) = (read.positions[v][axis], read.normals[v][axis]);
                    assert_close(rest + position_offsets[v][axis], positions[3 * v + axis], rest);
                    // The last vertex has no area: its normal is glTF's to choose, and stays.
                    let expected = if v == vertices - 1 { n } else { normals[3 * v + axis] };
                    assert_close(n + normal_offsets[v][axis], expected, n);
                }
            }
        }
    }
}

#[test]
fn triangles_keep_their_vertices_and_texture_coordinates() {
    let folder = tempfile::tempdir().unwrap();
    for (i, animation) in cases().iter().enumerate() {
        let path = folder.path().join(format!("{i}.glb"));
        animation.export(&path).unwrap();
        let (read, _) = read(&path);
        let corners = animation.triangle_corners.as_flattened();
        assert_eq!(read.indices.len(), corners.len());
        assert_eq!(read.uvs.is_some(), animation.uvs.is_some());

        let mut distinct = HashSet::new();
        for (&index, &corner) in read.indices.iter().zip(corners) {
            let (index, corner) = (index as usize, corner as usize);
            let vertex = animation.faces.indices[corner] as usize;
            assert_eq!(read.positions[index], animation.rest[vertex]);
            // A copy moves with its vertex; the rest positions of two vertices differ.
            for [position_offsets, normal_offsets] in &read.targets {
                assert_eq!(position_offsets[index], position_offsets[vertex]);
                assert_eq!(normal_offsets[index], normal_offsets[vertex]);
            }
            let Some(uvs) = &animation.uvs else {
                assert_eq!(index, vertex);
                continue;
            };
            let number = uvs.corners.as_ref().map_or(vertex, |corners| corners[corner] as usize);
            let [u, v] = uvs.values[number];
            assert_eq!(read.uvs.as_ref().unwrap()[index], [u, 1.0 - v]);
            distinct.insert((vertex, u.to_bits(), v.to_bits()));
        }
        // No copy more than the texture coordinates ask for; 33 vertices have faces and one has none.
        if animation.uvs.is_some() {
            assert_eq!(read.positions.len(), distinct.len() + 1);
        } else {
            assert_eq!(read.positions.len(), 34);
        }
        assert!(i != 1 || read.positions.len() > 60, "the case per corner has too few copies to show much");
    }
}

#[test]
fn it_opens_upright_and_at_true_size() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.glb");
    let base = animation(UvKind::None, 2, 26);
    let name = "1st scan \"Zoë\"";
    Animation { up_axis: UpAxis::Z, name: name.into(), ..base.clone() }.export(&path).unwrap();
    let (_, document) = read(&path);
    let node = document.default_scene().unwrap().nodes().next().unwrap();
    assert_eq!(node.name(), Some(name));
    let columns = node.transform().matrix();
    // The mesh's up (z) becomes glTF's (y), in metres, and its x stays.
    for (axis, expected) in [(0, [0.01, 0.0, 0.0]), (2, [0.0, 0.01, 0.0])] {
        for (found, expected) in columns[axis].iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "{columns:?}");
        }
    }

    Animation { metres_per_unit: 1.0, ..base }.export(&path).unwrap();
    let (_, document) = read(&path);
    let node = document.default_scene().unwrap().nodes().next().unwrap();
    let identity = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
    assert_eq!(node.transform().matrix(), identity);
}

#[test]
fn targets_are_named_by_time_code() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.glb");
    Animation { first_time_code: 9.0, ..animation(UvKind::None, 2, 27) }.export(&path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let json: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    assert_eq!(json["meshes"][0]["extras"]["targetNames"], serde_json::json!(["frame 0009", "frame 0010"]));
}

/// The validator's issues: errors, warnings and infos of each file.
fn validate(files: &[PathBuf]) -> Vec<[Vec<String>; 3]> {
    let folder = root().join("target/node");
    assert!(folder.join("installed.json").exists(), "no glTF validator; run `cargo xtask setup` first");
    let script = root().join("crates/formats/tests/export/gltf_check.mjs");
    let printed = run(Command::new("node").arg(script).arg(folder).args(files));
    let reports: Vec<Value> = printed.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(reports.len(), files.len(), "{printed}");
    reports
        .iter()
        .map(|report| {
            ["errors", "warnings", "infos"].map(|kind| serde_json::from_value(report[kind].clone()).unwrap())
        })
        .collect()
}

#[test]
fn khronos_validator_finds_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut files = Vec::new();
    for (i, animation) in cases().iter().enumerate() {
        files.push(folder.path().join(format!("{i}.glb")));
        animation.export(&files[i]).unwrap();
    }
    // Texture coordinates without a texture are meant for one that is given later; one of the sheet's vertices
    // has no face.
    let harmless = ["UNUSED_OBJECT /meshes/0/primitives/0/attributes/TEXCOORD_0"];
    for (file, [errors, warnings, infos]) in files.iter().zip(validate(&files)) {
        assert_eq!((&errors, &warnings), (&vec![], &vec![]), "{}", file.display());
        let infos: Vec<&String> =
            infos.iter().filter(|info| !harmless.iter().any(|known| info.starts_with(known))).collect();
        assert!(infos.is_empty(), "{}: {infos:?}", file.display());
    }
}

#[test]
fn khronos_validator_would_find_something() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.glb");
    animation(UvKind::None, 2, 28).export(&path).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    // The last number: the z of the last target's last normal. And one of its positions, whose bounds are told.
    let end = bytes.len();
    bytes[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
    bytes[end - 34 * 12 - 4..end - 34 * 12].copy_from_slice(&1e3_f32.to_le_bytes());
    std::fs::write(&path, bytes).unwrap();
    let [errors, ..] = &validate(&[path])[0];
    for expected in ["ACCESSOR_INVALID_FLOAT", "ACCESSOR_MAX_MISMATCH"] {
        assert!(errors.iter().any(|error| error.starts_with(expected)), "{expected}: {errors:?}");
    }
}

#[test]
fn more_frames_than_a_glb_holds_are_refused_with_the_number_that_fit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.glb");
    let mut big = animation(UvKind::None, 1, 29);
    big.rest.resize(100_000, [0.0; 3]);
    big.rest_normals.resize(100_000, [0.0; 3]);
    for (animation, frames) in [(&big, 2000), (&animation(UvKind::None, 1, 30), 70_000)] {
        let scene = export::Scene { frames, ..animation.scene() };
        let message = input_error(export::create(&path, &scene));
        let fit = message.split("; ").last().unwrap().split(' ').next().unwrap().parse::<usize>();
        let fit = fit.unwrap_or_else(|_| panic!("{message}"));
        assert!(fit > 1000 && fit < frames, "{message}");
        let with = |frames| export::create(&path, &export::Scene { frames, ..scene });
        drop(with(fit).unwrap());
        input_error(with(fit + 1));
    }
}

#[test]
fn offsets_that_overflow_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut animation = animation(UvKind::None, 2, 31);
    animation.rest[5][1] = -3e38;
    animation.frames[1][0][16] = 3e38;
    let message = input_error(animation.export(&folder.path().join("face.glb")));
    assert!(message.contains("frame 1 (from 0), vertex 5"), "{message}");
}
