//! The rig file: what the tests of its parts share.

mod damaged;
mod packed;
mod refused;
mod versions;
mod written;

use rhytid_core::{Error, InputErrorKind, Materials, NoProgress, Rig, SurfacePoint, Uvs, VertexId, rig_file};
use rhytid_solve::solve;
use rhytid_test_support::changed;
use serde_json::Value;
use std::sync::LazyLock;

/// A rig of 25 vertices. It has texture coordinates at the corners and materials, and so every array.
static RIG: LazyLock<Rig> = LazyLock::new(|| {
    let rig = solve(&rhytid_test_support::sheet::face(), &NoProgress).unwrap().rounded().unwrap();
    let values = (0..9u8).map(|i| [f32::from(i) / 8.0, 0.1]).collect();
    let of_face = (0..16).map(|f| if f == 5 { Materials::NONE } else { f % 2 }).collect();
    changed(&rig, |r| {
        r.surface.uvs = Some(Uvs { values, corners: Some((0..64).map(|c| c % 9).collect()) });
        r.surface.materials = Some(Materials::named(["skin", "lips"], of_face));
    })
    .unwrap()
});

static BYTES: LazyLock<Vec<u8>> = LazyLock::new(|| rig_file::encode(&RIG).unwrap());

/// Reads a safetensors file by its specification: eight bytes with the length of the header, the header as
/// JSON, and the arrays.
fn parse(bytes: &[u8]) -> (Value, &[u8]) {
    let (length, rest) = bytes.split_first_chunk::<8>().unwrap();
    let (header, arrays) = rest.split_at(u64::from_le_bytes(*length) as usize);
    (serde_json::from_slice(header).unwrap(), arrays)
}

/// The opposite of [`parse`].
fn assemble(header: &Value, arrays: &[u8]) -> Vec<u8> {
    let header = header.to_string();
    [&(header.len() as u64).to_le_bytes(), header.as_bytes(), arrays].concat()
}

/// The file with its header changed.
fn with_header(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let (mut header, arrays) = parse(&BYTES);
    change(&mut header);
    assemble(&header, arrays)
}

/// The file with its own metadata changed.
fn with_metadata(change: impl FnOnce(&mut Value)) -> Vec<u8> {
    with_header(|header| {
        let text = &mut header["__metadata__"]["rhytid"];
        let mut metadata: Value = serde_json::from_str(text.as_str().unwrap()).unwrap();
        change(&mut metadata);
        *text = metadata.to_string().into();
    })
}

/// The file with four bytes of `array` replaced, at `element`.
fn with_element(array: &str, element: usize, bytes: [u8; 4]) -> Vec<u8> {
    with_element_of(&BYTES, array, element, bytes)
}

fn with_element_of(file: &[u8], array: &str, element: usize, bytes: [u8; 4]) -> Vec<u8> {
    let (header, arrays) = parse(file);
    let start = header[array]["data_offsets"][0].as_u64().unwrap() as usize;
    let mut arrays = arrays.to_vec();
    arrays[start + 4 * element..][..4].copy_from_slice(&bytes);
    assemble(&header, &arrays)
}

/// Asserts that the file is refused in one sentence which begins with its name and has `words`.
#[track_caller]
fn refused(bytes: &[u8], words: &[&str]) -> InputErrorKind {
    match rig_file::decode(bytes, "face.safetensors") {
        Err(Error::Input(message)) => {
            assert!(message.sentence().starts_with("face.safetensors: "), "{message}");
            assert!(!message.sentence().contains('\n'), "{message}");
            for word in words {
                assert!(message.sentence().contains(word), "{word}: {message}");
            }
            message.kind().clone()
        }
        other => panic!("{words:?}: {:?}", other.map(|rig| rig.vertices())),
    }
}

/// A rig with a handle inside a triangle.
fn inside_a_triangle() -> Rig {
    let mut face = rhytid_test_support::sheet::face();
    face.handles.points[2] = SurfacePoint::new([6, 7, 12].map(VertexId), [0.3, 0.3, 0.4]).unwrap();
    solve(&face, &NoProgress).unwrap().rounded().unwrap()
}
