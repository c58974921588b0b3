//! Shared parts of the targets for the readers of capture files.
use rhytid_core::{Error, RawTake};
use rhytid_formats::raw_take::decode;
use std::collections::HashSet;

/// Any bytes as the file `name` give a sound take or a sentence, with the file's rate and with a given one.
pub fn check(bytes: &[u8], name: &str) {
    for rate in [None, Some(120.0)] {
        match decode(bytes, name, rate) {
            Ok(take) => sound(&take, bytes.len()),
            Err(Error::Input(sentence)) => assert!(sentence.sentence().starts_with(name), "{sentence}"),
            Err(other) => panic!("expected an input error, found {other:?}"),
        }
    }
}

fn sound(take: &RawTake, bytes: usize) {
    let tracks = &take.tracks;
    let samples = tracks.frames() * tracks.labels.len();
    assert!(samples > 0 && tracks.positions.len() == samples);
    assert!(samples <= bytes, "{samples} positions from {bytes} bytes");
    assert!(tracks.confidence.as_ref().is_none_or(|confidence| confidence.len() == samples));
    let labels: HashSet<&String> = tracks.labels.iter().collect();
    assert!(labels.len() == tracks.labels.len() && !labels.contains(&String::new()));
    assert!(tracks.times.iter().all(|time| time.is_finite()));
    assert!(tracks.times.windows(2).all(|pair| pair[0] < pair[1]));
    let fits = |x: f64| (x as f32).is_finite();
    assert!(tracks.positions.iter().all(|p| p.iter().all(|x| x.is_nan()) || p.iter().all(|&x| fits(x))));
    assert!(take.metres_per_unit.is_none_or(|metres| metres > 0.0));
}
