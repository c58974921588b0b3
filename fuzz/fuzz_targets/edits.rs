//! Any text as a file of edits gives edits with sound values, or an error.
#![no_main]
use libfuzzer_sys::fuzz_target;
use rhytid_core::Error;
use rhytid_formats::edits::{Curve, parse};

fn is_sound(curve: &Curve) -> bool {
    let rise = curve.keys.windows(2).all(|keys| keys[0].0 < keys[1].0);
    !curve.keys.is_empty() && rise && [-1e9, 0.0, 7.5, 1e9].iter().all(|frame| curve.at(*frame).is_finite())
}

fuzz_target!(|text: &str| match parse(text, "fuzz") {
    Ok(edits) => {
        assert!(edits.gains.iter().chain(&edits.details).all(|gain| is_sound(&gain.by)));
        assert!(edits.offsets.iter().all(|offset| is_sound(&offset.amount)));
        assert!(edits.added.iter().all(|added| is_sound(&added.amount) && added.frame.is_finite()));
        assert!(edits.holds.iter().all(|hold| hold.frames.start < hold.frames.end));
        assert!(edits.corrections.iter().all(|c| is_sound(&c.amount) && c.reach.is_none_or(|r| r > 0.0)));
    }
    Err(Error::Input(sentence)) => assert!(sentence.sentence().starts_with("fuzz"), "{sentence}"),
    Err(other) => panic!("expected an input error, found {other:?}"),
});
