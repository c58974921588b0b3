//! Rig files that cannot be trusted, changed byte by byte.

use crate::common::{Fixture, garbage};
use serde_json::{Value, json};

const ANIMATE: &str = "animate face.safetensors take.csv -o out/face.usda";

fn solved() -> Fixture {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    f
}

/// The header of a safetensors file (its length as 8 bytes, then JSON), and the data behind it.
fn split(rig: &[u8]) -> (Value, Vec<u8>) {
    let len = u64::from_le_bytes(rig[..8].try_into().unwrap()) as usize;
    (serde_json::from_slice(&rig[8..8 + len]).unwrap(), rig[8 + len..].to_vec())
}

fn join(header: &Value, data: &[u8]) -> Vec<u8> {
    let mut header = serde_json::to_vec(header).unwrap();
    header.resize(header.len().next_multiple_of(8), b' ');
    [&(header.len() as u64).to_le_bytes(), header.as_slice(), data].concat()
}

/// Animates a rig whose header and data were changed; it must be refused.
fn refused_after(change: impl Fn(&mut Value, &mut Vec<u8>), words: &[&str]) {
    let f = solved();
    let (mut header, mut data) = split(&f.read("face.safetensors"));
    change(&mut header, &mut data);
    f.write("face.safetensors", join(&header, &data));
    f.refused(ANIMATE, &[&["face.safetensors"], words].concat());
    f.refused("info face.safetensors", &["face.safetensors"]);
}

/// Where the data of a tensor begins.
fn offset(header: &Value, tensor: &str) -> usize {
    header[tensor]["data_offsets"][0].as_u64().unwrap_or_else(|| panic!("no tensor {tensor}")) as usize
}

#[test]
fn taken_apart_and_put_together_it_is_accepted() {
    let f = solved();
    let (header, data) = split(&f.read("face.safetensors"));
    f.write("face.safetensors", join(&header, &data));
    f.done(ANIMATE);
}

#[test]
fn cut_short() {
    let f = solved();
    let rig = f.read("face.safetensors");
    for len in [rig.len() - 1, rig.len() / 2, 1000, 100, 8, 7, 0] {
        f.write("face.safetensors", &rig[..len]);
        f.refused(ANIMATE, &["face.safetensors"]);
    }
}

#[test]
fn garbage_instead() {
    let f = solved();
    f.write("face.safetensors", garbage(5000));
    f.refused(ANIMATE, &["face.safetensors"]);
}

#[test]
fn a_wrong_version() {
    refused_after(
        |header, _| {
            let mut metadata: Value =
                serde_json::from_str(header["__metadata__"]["rhytid"].as_str().unwrap()).unwrap();
            assert_eq!(metadata["version"], 5);
            metadata["version"] = json!(999);
            header["__metadata__"]["rhytid"] = json!(metadata.to_string());
        },
        &["999", "version"],
    );
}

#[test]
fn indices_out_of_range() {
    for tensor in ["handles", "triangles", "strain_edges", "influence_edges", "frame_neighbors", "anchors"] {
        refused_after(
            |header, data| {
                let at = offset(header, tensor);
                data[at..at + 4].copy_from_slice(&123_456_789u32.to_le_bytes());
            },
            &[tensor],
        );
    }
}

#[test]
fn numbers_that_are_not_finite() {
    for tensor in ["rest", "basis", "influence_weights", "pose_features", "rbf_weights"] {
        refused_after(
            |header, data| {
                let at = offset(header, tensor);
                data[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
            },
            &[tensor],
        );
    }
}

/// Frames of such weights take seconds, and their numbers mean nothing.
#[test]
fn weights_beyond_any_face() {
    for tensor in ["basis", "rbf_weights", "example_weights"] {
        refused_after(
            |header, data| {
                let at = offset(header, tensor);
                data[at..at + 4].copy_from_slice(&1e12_f32.to_le_bytes());
            },
            &[tensor, "expected a smaller number"],
        );
    }
}

#[test]
fn a_tensor_that_is_not_there() {
    refused_after(
        |header, _| {
            let tensor = header.as_object_mut().unwrap().remove("basis").unwrap();
            header["bsais"] = tensor;
        },
        &["basis"],
    );
}
