//! Shared parts of the targets for the mesh readers.
use rhytid_core::Error;
use rhytid_formats::mesh::{self, Format};

/// Decodes. A mesh must keep the promises of its type, and an error must name the file.
pub fn decode(bytes: &[u8], format: Format) {
    let mesh = match mesh::decode(bytes, format, "fuzz") {
        Ok(mesh) => mesh,
        Err(Error::Input(sentence)) => return assert!(sentence.sentence().starts_with("fuzz"), "{sentence}"),
        Err(other) => panic!("expected an input error, found {other:?}"),
    };
    let (vertices, corners) = (mesh.positions.len(), mesh.faces.indices.len());
    assert!(mesh.positions.as_flattened().iter().all(|x| (*x as f32).is_finite()));
    assert!(!mesh.faces.counts.is_empty() && mesh.faces.counts.iter().all(|&n| n >= 3));
    assert_eq!(mesh.faces.counts.iter().map(|&n| n as usize).sum::<usize>(), corners);
    assert!(mesh.faces.indices.iter().all(|&v| (v as usize) < vertices));
    let Some(uvs) = mesh.uvs else { return };
    assert!(uvs.values.as_flattened().iter().all(|x| x.is_finite()));
    match uvs.corners {
        Some(indices) => {
            assert_eq!(indices.len(), corners);
            assert!(indices.iter().all(|&i| (i as usize) < uvs.values.len()));
        }
        None => assert_eq!(uvs.values.len(), vertices),
    }
}
