//! Lids on eyeballs, from the project file to the vertices.

use crate::common::{rhytid, stderr};
use rhytid_test_support::shared;
use serde_json::Value;
use std::path::Path;

fn done(command: &str, folder: &Path) -> String {
    let output = rhytid(command).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{command}: {}", stderr(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// The frames of a point cache: a header of 32 bytes, then the positions.
fn frames(path: &Path, vertices: usize) -> Vec<Vec<[f32; 3]>> {
    let bytes = std::fs::read(path).unwrap();
    let numbers: Vec<f32> = bytes[32..].as_chunks().0.iter().map(|x| f32::from_le_bytes(*x)).collect();
    numbers.as_chunks::<3>().0.chunks_exact(vertices).map(<[_]>::to_vec).collect()
}

fn vertices_of(obj: &Path) -> Vec<[f32; 3]> {
    let text = std::fs::read_to_string(obj).unwrap();
    let numbers = |line: &str| line[2..].split_whitespace().map(|x| x.parse().unwrap()).collect::<Vec<f32>>();
    text.lines()
        .filter(|line| line.starts_with("v "))
        .map(|line| numbers(line)[..3].try_into().unwrap())
        .collect()
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt()
}

#[test]
fn a_capture_on_another_head_does_not_press_lids_into_eyes() {
    let Some(shared) = shared("data") else { return };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::create_dir(folder.join("poses")).unwrap();
    let head = shared.join("makehuman");
    std::fs::copy(head.join("neutral.obj"), folder.join("neutral.obj")).unwrap();
    // The examples show no closed eyes, so that only contact keeps the lids out of them.
    let poses: Vec<_> = std::fs::read_dir(head.join("poses"))
        .unwrap()
        .map(|pose| pose.unwrap().file_name())
        .filter(|pose| pose != "blink.obj")
        .collect();
    for pose in &poses {
        std::fs::copy(head.join("poses").join(pose), folder.join("poses").join(pose)).unwrap();
    }
    let take = shared.join("takes/rom_3_raw.c3d");
    std::fs::copy(take, folder.join("take.c3d")).unwrap();
    done("new neutral.obj --take take.c3d -o .", folder);
    let told: Value =
        serde_json::from_str(&done("solve face.toml -o with.safetensors --json", folder)).unwrap();
    let radius = |i: usize| told["eyeballs"][i]["radius_mm"].as_f64().unwrap();
    assert!((radius(0) - 14.95).abs() < 0.1 && (radius(1) - 14.95).abs() < 0.1, "{told}");
    // Lips, lids and nostrils.
    assert!((200..600).contains(&told["rim_vertices"].as_u64().unwrap()), "{told}");
    let first = |i: usize| told["eyeballs"][i]["first_vertex"].as_u64().unwrap() as usize;

    let project = std::fs::read_to_string(folder.join("face.toml")).unwrap();
    std::fs::write(
        folder.join("off.toml"),
        format!("{project}\n[contact]\neyes = false\nopenings = false\n"),
    )
    .unwrap();
    let told: Value =
        serde_json::from_str(&done("solve off.toml -o without.safetensors --json", folder)).unwrap();
    assert_eq!((&told["eyeballs"], &told["rim_vertices"]), (&serde_json::json!([]), &serde_json::json!(0)));

    // An eyeball has 72 vertices, and does not move.
    let rest = vertices_of(&folder.join("neutral.obj"));
    let scans: Vec<Vec<[f32; 3]>> =
        poses.iter().map(|pose| vertices_of(&folder.join("poses").join(pose))).collect();
    let centers = [first(0), first(1)].map(|first| {
        let sum = |c: usize| rest[first..first + 72].iter().map(|x| x[c]).sum::<f32>();
        [0, 1, 2].map(|c| sum(c) / 72.0)
    });
    let eyeballs = first(0)..first(1) + 72;
    // How deep vertices are in an eyeball, beyond the deepest scan, in decimetres.
    let depth = |frame: &[[f32; 3]]| {
        let of_eye = |center: [f32; 3]| {
            let radius = distance(rest[first(0)], centers[0]);
            let near = (0..rest.len()).filter(|v| !eyeballs.contains(v));
            let near = near.filter(|v| distance(rest[*v], center) < 1.5 * radius);
            let deep = near.map(|v| {
                let of_scans = scans.iter().chain([&rest]).map(|scan| distance(scan[v], center));
                of_scans.fold(radius, f32::min) - distance(frame[v], center)
            });
            deep.fold(0.0, f32::max)
        };
        centers.map(of_eye).into_iter().fold(0.0, f32::max)
    };
    let share = |rig: &str| {
        done(&format!("animate {rig}.safetensors take.c3d --fps 5 -o {rig}.pc2 --device cpu"), folder);
        let frames = frames(&folder.join(rig).with_extension("pc2"), rest.len());
        let depths: Vec<f32> = frames.iter().map(|frame| depth(frame)).collect();
        let deepest = depths.iter().fold(0.0_f32, |most, x| most.max(*x));
        println!("{rig}: {} frames, {} mm at most", frames.len(), 100.0 * deepest);
        (depths.iter().filter(|depth| **depth > 0.01).count() as f32 / depths.len() as f32, deepest)
    };
    let ((without, deepest), (with, left)) = (share("without"), share("with"));
    assert!(without > 0.2 && deepest > 0.03, "{without} {deepest}");
    assert!(with == 0.0 && left < 1e-3, "{with} {left}");
}
