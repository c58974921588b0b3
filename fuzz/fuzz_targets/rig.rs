//! Any bytes as a rig file give a rig that passes its own check, or an error.
#![no_main]
use libfuzzer_sys::fuzz_target;
use rhytid_core::{Error, rig_file};

fuzz_target!(|bytes: &[u8]| match rig_file::decode(bytes, "fuzz") {
    Ok(rig) => rig.check().expect("a rig that was read is sound"),
    Err(Error::Input(sentence)) => assert!(sentence.sentence().starts_with("fuzz"), "{sentence}"),
    Err(other) => panic!("expected an input error, found {other:?}"),
});
