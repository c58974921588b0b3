//! Any bytes as curves give whole and finite weights, no more than the file allows, or an error.
#![no_main]
use libfuzzer_sys::fuzz_target;
use rhytid_core::Error;
use rhytid_formats::curves::{decode, meant};

fuzz_target!(|bytes: &[u8]| {
    for rate in [None, Some(30.0)] {
        match decode(bytes, "fuzz", rate) {
            Ok(curves) => {
                assert!(curves.frames() > 0 && !curves.names.is_empty());
                assert_eq!(curves.weights.len(), curves.frames() * curves.names.len());
                assert!(curves.weights.len() <= 4 * bytes.len() + curves.names.len());
                assert!(curves.weights.iter().all(|weight| weight.is_finite()));
                assert!(curves.times.windows(2).all(|pair| pair[0] < pair[1]));
                assert_eq!(meant(&curves.names, &curves.names).shapes.len(), curves.names.len());
            }
            Err(Error::Input(sentence)) => {
                assert!(sentence.sentence().starts_with("fuzz"), "{sentence}");
            }
            Err(other) => panic!("expected an input error, found {other:?}"),
        }
    }
});
