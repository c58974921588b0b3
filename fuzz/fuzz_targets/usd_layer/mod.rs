//! Shared parts of the targets for the USD reader.
use rhytid_core::Error;
use rhytid_formats::usd::layer::{Prim, Property};
use rhytid_formats::usd::read::{self, Opened, decode_animation};

/// Decodes. Everything in the layer can be read, or gives an error.
pub fn decode(bytes: &[u8]) {
    match read::decode(bytes.to_vec(), "fuzz") {
        Ok(Opened { layer, mut samples, .. }) => {
            let mut numbers = Vec::new();
            layer.prims.iter().for_each(|prim| sampled(prim, &mut numbers));
            for n in numbers {
                let times = samples.times(n);
                assert!(times.is_sorted());
                for i in 0..times.len().min(20) {
                    check(samples.read(n, i).err());
                }
            }
        }
        error => check(error.err()),
    }
    match decode_animation(bytes.to_vec(), "fuzz") {
        Ok(mut reader) => {
            let summary = reader.summary().clone();
            assert!(summary.frames > 0 && summary.faces.fault(summary.vertices).is_none());
            let mut out = Vec::new();
            match reader.positions(summary.frames - 1, &mut out) {
                Ok(()) => assert_eq!(out.len(), summary.vertices * 3),
                error => check(error.err()),
            }
        }
        error => check(error.err()),
    }
}

fn sampled(prim: &Prim, numbers: &mut Vec<usize>) {
    for property in &prim.properties {
        if let Property::Attribute(attribute) = property {
            numbers.extend(attribute.samples);
        }
    }
    prim.children.iter().for_each(|child| sampled(child, numbers));
}

/// Only faults of the input are allowed as errors.
fn check(error: Option<Error>) {
    assert!(matches!(error, None | Some(Error::Input(_))), "{error:?}");
}
