//! Any bytes as a take give whole and finite tracks, or an error, in each way of reading.
#![no_main]
use libfuzzer_sys::fuzz_target;
use rhytid_core::{Error, Take};
use rhytid_formats::take::{Missing, decode};

fuzz_target!(|bytes: &[u8]| {
    let wanted = ["brow".to_owned(), "lip_up".to_owned()];
    let read = [None, Some(&wanted[..])].map(|wanted| {
        let strict = sound(decode(bytes, "fuzz", wanted, Missing::Error));
        let held = sound(decode(bytes, "fuzz", wanted, Missing::Hold));
        // Without gaps there is nothing to hold.
        assert!(strict.is_none() || strict == held);
        strict
    });
    // If all labels can be read, the wanted ones can, unless they are missing.
    if let [Some(all), some] = &read {
        assert_eq!(some.is_some(), wanted.iter().all(|label| all.labels.contains(label)));
    }
});

fn sound(result: rhytid_core::Result<Take>) -> Option<Take> {
    match result {
        Ok(take) => {
            assert!(take.frames() > 0 && !take.labels.is_empty());
            assert_eq!(take.positions.len(), take.frames() * take.labels.len());
            assert!(take.positions.as_flattened().iter().all(|x| (*x as f32).is_finite()));
            assert!(take.times.windows(2).all(|pair| pair[0] < pair[1]));
            Some(take)
        }
        Err(Error::Input(sentence)) => {
            assert!(sentence.sentence().starts_with("fuzz"), "{sentence}");
            None
        }
        Err(other) => panic!("expected an input error, found {other:?}"),
    }
}
