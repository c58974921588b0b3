//! Any bytes as a table of handles give distinct labels, or an error.
#![no_main]
use libfuzzer_sys::fuzz_target;
use rhytid_core::Error;
use rhytid_formats::tables::decode_handles;
use std::collections::HashSet;

fuzz_target!(|bytes: &[u8]| match decode_handles(bytes, "fuzz") {
    Ok(handles) => {
        assert!(!handles.labels.is_empty());
        assert_eq!(handles.labels.len(), handles.len());
        assert_eq!(handles.labels.iter().collect::<HashSet<_>>().len(), handles.labels.len());
        assert!(handles.labels.iter().all(|label| !label.is_empty()));
    }
    Err(Error::Input(sentence)) => assert!(sentence.sentence().starts_with("fuzz"), "{sentence}"),
    Err(other) => panic!("expected an input error, found {other:?}"),
});
