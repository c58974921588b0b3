//! The readers of capture files: against files that the tests write, against ezc3d, and against each other on
//! a real take.
mod c3d;
mod c3d_torture;
mod c3d_writer;
mod c3dio;
mod ezc3d;
mod motive;
mod qualisys;
mod shared;
mod take_csv;
mod trc;

use rhytid_core::{Error, InputErrorKind, RawTake, Remedy};
use rhytid_formats::raw_take::decode;

/// Reads a file that must be sound.
#[track_caller]
fn read(bytes: &[u8], name: &str) -> RawTake {
    let take = decode(bytes, name, None).unwrap();
    check(&take);
    take
}

/// The sentence of a file that cannot be read.
#[track_caller]
fn refused(bytes: &[u8], name: &str) -> String {
    match decode(bytes, name, None) {
        Err(Error::Input(message)) => {
            assert!(message.sentence().starts_with(name), "{message}");
            message.to_string()
        }
        other => panic!("expected an input error, found {other:?}"),
    }
}

/// A file that cannot be read as it gives no frame rate.
#[track_caller]
fn has_no_rate(bytes: &[u8], name: &str) {
    let Err(Error::Input(error)) = decode(bytes, name, None) else { panic!("expected an input error") };
    assert!(error.sentence().starts_with(name), "{error}");
    assert_eq!(error.kind(), &InputErrorKind::NoFrameRate, "{error}");
    assert_eq!(error.remedies(), [Remedy::GiveRate], "{error}");
}

/// What every raw take promises.
#[track_caller]
fn check(take: &RawTake) {
    let tracks = &take.tracks;
    assert!(tracks.frames() > 0 && !tracks.labels.is_empty());
    assert_eq!(tracks.positions.len(), tracks.frames() * tracks.labels.len());
    assert!(tracks.confidence.as_ref().is_none_or(|c| c.len() == tracks.positions.len()));
    assert!(tracks.times.windows(2).all(|pair| pair[0] < pair[1]));
    let sound =
        |p: &[f64; 3]| p.iter().all(|x| x.is_nan()) || p.iter().all(|x| x.abs() <= f64::from(f32::MAX));
    assert!(tracks.positions.iter().all(sound));
}

/// Whether a warning has these words.
fn warns(take: &RawTake, words: &str) -> bool {
    take.warnings.iter().any(|warning| warning.contains(words))
}

fn is_missing(position: &[f64; 3]) -> bool {
    position.iter().all(|x| x.is_nan())
}
