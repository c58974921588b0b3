//! Levels of detail: rigs that play as the whole one does, at the distance that the command states.

use crate::common::{Fixture, assert_documented};
use rhytid::core::rig_file;
use rhytid::formats::animation;
use std::collections::BTreeMap;

fn solved() -> Fixture {
    let f = Fixture::with_side(41);
    f.done("solve face.toml -o face.safetensors");
    f
}

fn json(f: &Fixture, args: &str) -> serde_json::Value {
    serde_json::from_str(&f.done(args)).unwrap()
}

/// The arrays of a safetensors file as numbers, read without the library that wrote it.
fn arrays(bytes: &[u8]) -> BTreeMap<String, Vec<f64>> {
    let (length, rest) = bytes.split_first_chunk::<8>().unwrap();
    let (header, data) = rest.split_at(u64::from_le_bytes(*length) as usize);
    let header: serde_json::Value = serde_json::from_slice(header).unwrap();
    let number = |dtype: &str, word: [u8; 4]| match dtype {
        "F32" => f64::from(f32::from_le_bytes(word)),
        "U32" => f64::from(u32::from_le_bytes(word)),
        other => panic!("{other}"),
    };
    let array = |about: &serde_json::Value| {
        let [from, to] = [0, 1].map(|i| about["data_offsets"][i].as_u64().unwrap() as usize);
        let words = data[from..to].as_chunks::<4>().0;
        words.iter().map(|&word| number(about["dtype"].as_str().unwrap(), word)).collect()
    };
    let named = header.as_object().unwrap().iter().filter(|(name, _)| *name != "__metadata__");
    named.map(|(name, about)| (name.clone(), array(about))).collect()
}

/// All frames of an animation, V×3 each.
fn frames(f: &Fixture, name: &str) -> Vec<Vec<[f64; 3]>> {
    let mut file = animation::open(&f.path(name)).unwrap();
    let mut positions = Vec::new();
    (0..file.summary().frames)
        .map(|frame| {
            file.positions(frame, &mut positions).unwrap();
            positions.as_chunks::<3>().0.iter().map(|x| x.map(f64::from)).collect()
        })
        .collect()
}

#[test]
fn levels_play_as_near_to_the_whole_rig_as_is_said() {
    let f = solved();
    let said = json(&f, "lod face.safetensors take.csv --levels 2 -o levels --json");
    assert_documented(&said, "lod");
    let whole_rig = rig_file::read(&f.path("face.safetensors")).unwrap();
    let millimetres = 1e3 * whole_rig.surface().metres_per_unit;
    assert_eq!(said["vertices"], whole_rig.vertices());
    f.done("animate face.safetensors take.csv --device cpu:0 -o whole.usd");
    let whole = frames(&f, "whole.usd");
    let levels = said["levels"].as_array().unwrap();
    assert_eq!(levels.len(), 2);
    for (i, level) in levels.iter().enumerate() {
        let name = format!("levels/face.{}", i + 1);
        assert_eq!(level["file"], format!("{name}.safetensors"));
        assert_eq!(level["bytes"], f.read(&format!("{name}.safetensors")).len());
        let triangles = level["triangles"].as_u64().unwrap() as f64;
        let part = triangles / said["triangles"].as_f64().unwrap();
        assert!((part * f64::from(1 << (i + 1)) - 1.0).abs() < 0.05, "{part} of the triangles");

        f.done(&format!("animate {name}.safetensors take.csv --device cpu:0 -o level.usd"));
        f.done(&format!("verify level.usd --rig {name}.safetensors --take take.csv --device cpu:0"));
        let own = frames(&f, "level.usd");
        assert_eq!(own[0].len(), level["vertices"].as_u64().unwrap() as usize);
        let points = arrays(&f.read(&format!("{name}.points.safetensors")));
        let (vertices, weights) = (&points["vertices"], &points["weights"]);
        assert_eq!((vertices.len(), weights.len()), (3 * whole_rig.vertices(), 3 * whole_rig.vertices()));
        let (mut worst, mut kept) = (0.0_f64, 0);
        for (whole, own) in whole.iter().zip(&own) {
            for (v, x) in whole.iter().enumerate() {
                let mut at = [0.0; 3];
                for k in 3 * v..3 * v + 3 {
                    (0..3).for_each(|c| at[c] += weights[k] * own[vertices[k] as usize][c]);
                }
                let square: f64 = at.iter().zip(x).map(|(a, x)| (a - x).powi(2)).sum();
                kept += usize::from(square < 1e-12);
                worst = worst.max(square.sqrt());
            }
        }
        let stated = level["worst_mm"].as_f64().unwrap();
        assert!(millimetres * worst <= 1.001 * stated + 1e-3, "{} mm, {stated} stated", millimetres * worst);
        assert!(stated > level["rms_mm"].as_f64().unwrap() && level["rms_mm"].as_f64().unwrap() > 0.0);
        // What stays is where it was, in nearly every frame. Triangles are turned back on each mesh by
        // itself.
        assert!(kept as f64 > 0.95 * (own[0].len() * own.len()) as f64, "{kept}");
    }
    assert!(levels[1]["rms_mm"].as_f64() > levels[0]["rms_mm"].as_f64());
    let together = json(&f, "stitch --levels whole.usd level.usd -o levels/face.usda --json");
    assert_documented(&together, "stitch --levels");
    assert_eq!(together["variants"], serde_json::json!(["LOD0", "LOD1"]));
    let text = String::from_utf8(f.read("levels/face.usda")).unwrap();
    assert!(text.contains("@../whole.usd@") && text.contains("@../level.usd@"), "{text}");
    f.refused("info levels/face.usda", &["face.usda", "variant set LOD", "open a file"]);
    let said = f.done("stitch --levels whole.usd level.usd -o levels/face.usda");
    assert!(said.contains("variants LOD0, LOD1, 20 frames"), "{said}");
    let text = f.done("lod face.safetensors -o again");
    assert!(text.contains("again/face.3.safetensors") && text.contains("RMS"), "{text}");
}

#[test]
fn what_has_no_levels_is_refused() {
    let f = solved();
    f.refused("lod face.safetensors -o out/levels --soft-markers", &["no take is given"]);
    f.refused("lod take.csv -o out/levels", &["take.csv", "is a take", "a rig"]);
    f.replace("face.toml", "[mesh]", "method = \"chapter\"\n\n[mesh]");
    f.done("solve face.toml -o chapter.safetensors");
    f.refused(
        "lod chapter.safetensors -o out/levels",
        &["tangent frames", "method = \"learned\"", "wrinkle_strains"],
    );
    f.assert_nothing_written();
}
