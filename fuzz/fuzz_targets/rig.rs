//! Any bytes as a rig file give a sound rig, or an error.
#![no_main]
use libfuzzer_sys::fuzz_target;
use rhytid_core::{Error, Rig, rig_file};

fuzz_target!(|bytes: &[u8]| match rig_file::decode(bytes, "fuzz") {
    Ok(rig) => drop(Rig::new(rig.into_parts()).expect("a rig that was read is sound")),
    Err(Error::Input(sentence)) => assert!(sentence.sentence().starts_with("fuzz"), "{sentence}"),
    Err(other) => panic!("expected an input error, found {other:?}"),
});
