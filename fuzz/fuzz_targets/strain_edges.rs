//! Any bytes as a table of strain edges give distinct pairs of handles, or an error.
#![no_main]
use libfuzzer_sys::fuzz_target;
use rhytid_core::Error;
use rhytid_formats::tables::decode_strain_edges;
use std::collections::HashSet;

fuzz_target!(|bytes: &[u8]| {
    let labels = ["brow_left", "brow_right", "nose", "chin"].map(str::to_owned);
    match decode_strain_edges(bytes, "fuzz", &labels) {
        Ok(edges) => {
            assert!(
                !edges.is_empty() && edges.iter().all(|&[a, b]| a != b && a.index() < 4 && b.index() < 4)
            );
            let pairs: HashSet<_> = edges.iter().map(|&[a, b]| (a.min(b), a.max(b))).collect();
            assert_eq!(pairs.len(), edges.len());
        }
        Err(Error::Input(sentence)) => assert!(sentence.sentence().starts_with("fuzz"), "{sentence}"),
        Err(other) => panic!("expected an input error, found {other:?}"),
    }
});
