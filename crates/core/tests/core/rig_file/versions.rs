//! What a rig's file has, and its version, by what the rig has.

use super::{RIG, assemble, inside_a_triangle, parse, refused, with_element_of, with_metadata};
use rhytid_core::{
    NoProgress, Prior, StatedLook, Table, Texture, Tissue, Transparency, VertexId, WrinkleStrains, rig_file,
};
use rhytid_kernels::vec3;
use rhytid_solve::solve;
use rhytid_test_support::changed;
use serde_json::{Value, json};

#[test]
fn a_rig_with_a_prior_has_lengths_and_a_version() {
    let mut face = rhytid_test_support::sheet::face();
    let expressions = face.examples.clone();
    face.prior = Some(Prior { expressions, weight: Some(0.5) });
    let rig = solve(&face, &NoProgress).unwrap().rounded().unwrap();
    let bytes = rig_file::encode(&rig).unwrap();
    let (header, _) = parse(&bytes);
    let features = rig.handles().features();
    assert_eq!(header["prior_lengths"]["shape"], json!([features]));
    assert!(header["__metadata__"]["rhytid"].as_str().unwrap().starts_with("{\"version\":8,"));
    assert_eq!(rig_file::decode(&bytes, "rig").unwrap(), rig);
    // A vector strain is followed as far as the prior's expressions go.
    let lengths = &rig.learned().unwrap().prior_lengths;
    let longest = rig.example_vectors().row(0).iter().map(|d| vec3::dot(*d, *d).sqrt()).collect::<Vec<f32>>();
    assert!(lengths.iter().zip(&longest).all(|(a, b)| (a - b).abs() < 1e-6), "{lengths:?} {longest:?}");
    let damaged = |length: f32| with_element_of(&bytes, "prior_lengths", 1, length.to_le_bytes());
    refused(&damaged(f32::NAN), &["prior_lengths"]);
    assert!(rig_file::decode(&damaged(0.5), "rig").unwrap().feature_limits()[1] >= 0.5);
}

#[test]
fn a_rig_with_eyeballs_has_lids_and_a_version() {
    let rig = solve(&rhytid_test_support::eye::face(), &NoProgress).unwrap().rounded().unwrap();
    let bytes = rig_file::encode(&rig).unwrap();
    let (header, _) = parse(&bytes);
    let lids = rig.learned().unwrap().contact.lids.len();
    assert!(lids > 20);
    assert_eq!(header["eyeball_corners"]["shape"], json!([1, 4]));
    assert_eq!(header["eyeball_weights"]["shape"], json!([1, 4]));
    assert_eq!(header["lid_vertices"]["shape"], json!([lids, 3]));
    assert_eq!(header["lid_distances"]["shape"], json!([lids, 2]));
    assert!(header["__metadata__"]["rhytid"].as_str().unwrap().starts_with("{\"version\":9,"));
    assert_eq!(rig_file::decode(&bytes, "rig").unwrap(), rig);
    let damaged = |array: &str, element: usize, value: u32| {
        with_element_of(&bytes, array, element, value.to_le_bytes())
    };
    refused(&damaged("eyeball_corners", 2, u32::MAX), &["eyeball_corners[2]", "index below"]);
    refused(&damaged("eyeball_weights", 1, f32::NAN.to_bits()), &["eyeball_weights[1]"]);
    refused(&damaged("lid_vertices", 3, u32::MAX), &["lid_vertices[1]", "index below"]);
    refused(&damaged("lid_vertices", 4, 1), &["lid_vertices[1]", "eyeball"]);
    refused(&damaged("lid_vertices", 5, lids as u32), &["lid_vertices[1]"]);
    refused(&damaged("lid_distances", 4, 0.0_f32.to_bits()), &["lid_distances[2]", "above 0"]);
    refused(&damaged("lid_distances", 5, 1e-3_f32.to_bits()), &["lid_distances[2]", "smaller one first"]);
    // A part of the vertices has no whole eyeball.
    let part = rig.part(&[VertexId(3), VertexId(70)]);
    assert!(part.learned().unwrap().contact.eyeballs.is_empty());
}

#[test]
fn a_rig_with_lips_has_openings_and_a_version() {
    let rig = solve(&rhytid_test_support::lips::face(), &NoProgress).unwrap().rounded().unwrap();
    let bytes = rig_file::encode(&rig).unwrap();
    let (header, _) = parse(&bytes);
    let openings = &rig.learned().unwrap().contact.openings;
    let (rims, followers) = (openings.rims.len(), openings.followers.len());
    assert!(rims > 50 && followers > rims);
    assert_eq!(header["rim_vertices"]["shape"], json!([rims]));
    assert_eq!(header["rim_across"]["shape"], json!([rims, 12]));
    assert_eq!(header["rim_gaps"]["shape"], json!([rims, 2]));
    assert_eq!(header["rim_followers"]["shape"], json!([followers]));
    assert_eq!(header["rim_leaders"]["shape"], json!([followers, 8]));
    assert_eq!(header["rim_leader_weights"]["shape"], json!([followers, 8]));
    assert!(header["__metadata__"]["rhytid"].as_str().unwrap().starts_with("{\"version\":9,"));
    assert_eq!(rig_file::decode(&bytes, "rig").unwrap(), rig);
    let damaged = |array: &str, element: usize, value: u32| {
        with_element_of(&bytes, array, element, value.to_le_bytes())
    };
    refused(&damaged("rim_vertices", 1, u32::MAX), &["rim_vertices[1]", "index below"]);
    refused(&damaged("rim_across", 5, rims as u32), &["rim_across[5]", "index below"]);
    refused(&damaged("rim_gaps", 2, 0.0_f32.to_bits()), &["rim_gaps[1]", "length above 0"]);
    refused(&damaged("rim_gaps", 3, f32::NAN.to_bits()), &["rim_gaps[3]", "finite"]);
    refused(&damaged("rim_followers", 0, u32::MAX), &["rim_followers[0]", "index below"]);
    refused(&damaged("rim_leaders", 9, rims as u32), &["rim_leaders[9]", "index below"]);
    refused(&damaged("rim_leader_weights", 4, 1.5_f32.to_bits()), &["rim_leader_weights[4]", "-1 to 1"]);
    let part = rig.part(&[VertexId(3), VertexId(70)]);
    assert!(part.learned().unwrap().contact.is_empty());
}

#[test]
fn handles_inside_triangles_have_weights_and_a_version() {
    let rig = inside_a_triangle();
    let bytes = rig_file::encode(&rig).unwrap();
    let (header, _) = parse(&bytes);
    assert_eq!(header["handles"]["shape"], json!([5, 3]));
    assert_eq!(header["handle_weights"]["shape"], json!([5, 3]));
    assert!(header["__metadata__"]["rhytid"].as_str().unwrap().starts_with("{\"version\":7,"));
    // The weights of the third handle are those of the face, and the others are at vertices.
    let third = rig.handles().points[2];
    assert_eq!(third.triangle(), [6, 7, 12].map(VertexId));
    assert!((third.weights()[2] - 0.4).abs() < 1e-7);
    assert_eq!(rig.handles().points[1], VertexId(4).into());
    let damaged = |weight: f32| with_element_of(&bytes, "handle_weights", 6, weight.to_le_bytes());
    refused(&damaged(0.7), &["handle_weights[2]", "sum is 1"]);
    refused(&damaged(-0.3), &["handle_weights[2]"]);
    refused(&damaged(f32::NAN), &["handle_weights[2]"]);
    refused(&with_element_of(&bytes, "handles", 6, 25u32.to_le_bytes()), &["handles[2] is 25"]);
}

/// Files that older programs wrote, and new files that older programs read.
#[test]
fn materials_have_looks_and_textures_and_a_version() {
    let png: &[u8] = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x02\0\0\0\x03";
    let jpeg: &[u8] = b"\xff\xd8\xff\xe0\0\x04ab\xff\xc0\0\x0b\x08\0\x05\0\x07\x03";
    let rig = changed(&RIG, |r| {
        let materials = r.surface.materials.as_mut().unwrap();
        materials.textures = vec![
            Texture { name: "skin.png".into(), path: Some("maps/skin.png".into()), bytes: png.into() },
            Texture { name: "lips.jpg".into(), path: None, bytes: jpeg.into() },
        ];
        materials.list[0].stated = StatedLook {
            base_color: Some([0.1, 0.2, 1.0]),
            texture: Some(0),
            opacity: Some(0.3),
            transparency: Some(Transparency::Mask(0.7)),
            roughness: Some(0.6),
            metallic: Some(0.0),
        };
        materials.list[1].stated.texture = Some(1);
        materials.list[1].tissue = Tissue::Mouth;
    })
    .unwrap();
    assert_eq!(rig.surface().materials.as_ref().unwrap().textures[0].size(), Some([2, 3]));
    assert_eq!(rig.surface().materials.as_ref().unwrap().textures[1].size(), Some([7, 5]));
    let bytes = rig_file::encode(&rig).unwrap();
    assert_eq!(rig_file::decode(&bytes, "rig").unwrap(), rig);
    let (header, arrays) = parse(&bytes);
    let metadata: Value = serde_json::from_str(header["__metadata__"]["rhytid"].as_str().unwrap()).unwrap();
    assert_eq!(metadata["version"], 11);
    let stated = json!({"base_color": [0.1, 0.2, 1.0], "texture": 0, "opacity": 0.3, "transparency": {"mask": 0.7},
        "roughness": 0.6, "metallic": 0.0});
    assert_eq!(metadata["looks"][0], json!({"tissue": "skin", "stated": stated}));
    assert_eq!(metadata["looks"][1], json!({"tissue": "mouth", "stated": {"texture": 1}}));
    let textures = json!([{"name": "skin.png", "path": "maps/skin.png", "bytes": png.len()},
        {"name": "lips.jpg", "bytes": jpeg.len()}]);
    assert_eq!(metadata["textures"], textures);
    let [first, end] = [0, 1].map(|i| header["texture_bytes"]["data_offsets"][i].as_u64().unwrap() as usize);
    assert_eq!(arrays[first..end], [png, jpeg].concat());

    let damaged = |change: &dyn Fn(&mut Value), words: &str| {
        let mut header = header.clone();
        let mut metadata = metadata.clone();
        change(&mut metadata);
        header["__metadata__"]["rhytid"] = metadata.to_string().into();
        refused(&assemble(&header, arrays), &[words]);
    };
    damaged(&|m| m["looks"] = json!([{"tissue": "skin", "stated": {}}]), "1 looks for 2 materials");
    damaged(&|m| m["looks"][1]["tissue"] = "wood".into(), "metadata cannot be read");
    damaged(&|m| m["looks"][1]["stated"]["texture"] = 2.into(), "texture 2, expected one of its 2");
    damaged(&|m| m["looks"][1]["stated"]["opacity"] = 2.into(), "opacity 2, expected 0 to 1");
    damaged(&|m| m["textures"][1]["bytes"] = 1000.into(), "ends within the texture lips.jpg");
    damaged(&|m| m["textures"][1]["bytes"] = 4.into(), "bytes more than its textures");
    damaged(&|m| m["textures"][0]["name"] = "../skin.png".into(), "a file name without folders");
    damaged(&|m| m["textures"][0]["name"] = "skin.exe".into(), "that ends in .png");
    let shifted =
        json!([{"name": "skin.png", "bytes": png.len() - 4}, {"name": "lips.jpg", "bytes": jpeg.len() + 4}]);
    damaged(&|m| m["textures"] = shifted.clone(), "a texture “lips.jpg” that is neither PNG nor JPEG");
}

#[test]
fn a_rig_of_the_chapters_method_is_a_file_of_version_2() {
    let chapter = changed(&RIG, |r| r.learned = None).unwrap();
    let bytes = rig_file::encode(&chapter).unwrap();
    assert_eq!(rig_file::decode(&bytes, "x").unwrap(), chapter);
    let (header, _) = parse(&bytes);
    let metadata: Value = serde_json::from_str(header["__metadata__"]["rhytid"].as_str().unwrap()).unwrap();
    assert_eq!((&metadata["version"], &metadata["method"]), (&json!(2), &json!("chapter")));
    assert!(metadata.get("learned").is_none() && header.get("anchors").is_none());

    // Older programs would not turn the handles.
    for still in [&chapter, &*RIG] {
        let turning = changed(still, |r| r.handles.rotations = true).unwrap();
        let bytes = rig_file::encode(&turning).unwrap();
        assert_eq!(rig_file::decode(&bytes, "x").unwrap(), turning);
        let (header, _) = parse(&bytes);
        let metadata: Value =
            serde_json::from_str(header["__metadata__"]["rhytid"].as_str().unwrap()).unwrap();
        assert_eq!((&metadata["version"], &metadata["rotations"]), (&json!(6), &json!(true)));
    }

    // Without a share there are no weights of examples.
    let linear = changed(&RIG, |r| {
        let learned = r.learned.as_mut().unwrap();
        learned.share = 0.0;
        learned.example_weights = Table::without_columns(25);
    })
    .unwrap();
    let bytes = rig_file::encode(&linear).unwrap();
    assert!(parse(&bytes).0.get("example_weights").is_none());
    assert_eq!(rig_file::decode(&bytes, "x").unwrap(), linear);
}

/// A missing key has a meaning: JSON cannot hold infinity, and older files have strain lengths.
#[test]
fn what_is_not_said_of_the_learned_method() {
    let bytes = with_metadata(|m| {
        let learned = m["learned"].as_object_mut().unwrap();
        learned.remove("reach");
        learned.remove("wrinkle_strains");
    });
    let rig = rig_file::decode(&bytes, "x").unwrap();
    let learned = rig.learned().unwrap();
    assert_eq!((learned.reach, learned.wrinkle_strains), (f64::INFINITY, WrinkleStrains::Lengths));
    let written = rig_file::encode(&rig).unwrap();
    assert_eq!(rig_file::decode(&written, "x").unwrap(), rig);
}

/// Files from before the keys were renamed mean the same.
#[test]
fn the_former_names_of_keys_are_read() {
    let bytes = with_metadata(|m| {
        let learned = m["learned"].as_object_mut().unwrap();
        for (former, key) in [("fold_ridge", "wrinkle_ridge"), ("fold_strains", "wrinkle_strains")] {
            let value = learned.remove(key).unwrap();
            learned.insert(former.into(), value);
        }
    });
    assert_ne!(bytes, with_metadata(|_| ()));
    let now = rig_file::decode(&with_metadata(|_| ()), "x").unwrap();
    assert_eq!(now.learned().unwrap().wrinkle_strains, WrinkleStrains::Vectors);
    assert_eq!(rig_file::decode(&bytes, "x").unwrap(), now);
}
