//! A real take at the rate of film: between two frames, a lip goes far, and is not taken for another marker.
use crate::real_take::{distances, rms, target, truth};
use glam::DVec3;
use rhytid_capture::{Kind, Settings, clean};
use rhytid_core::{NoProgress, RawTake};
use rhytid_formats::raw_take;
use rhytid_test_support::shared;
use std::io::Write;

/// Every frame of `step`.
fn thinned(raw: &RawTake, step: usize) -> RawTake {
    let m = raw.tracks.labels.len();
    let mut thin = raw.clone();
    thin.tracks.times = raw.tracks.times.iter().copied().step_by(step).collect();
    thin.tracks.positions = raw.tracks.positions.chunks(m).step_by(step).flatten().copied().collect();
    thin.tracks.confidence =
        raw.tracks.confidence.as_ref().map(|c| c.chunks(m).step_by(step).flatten().copied().collect());
    thin
}

#[test]
fn no_label_is_exchanged_at_a_low_rate() {
    let (Some(path), Some(target)) = (shared("data/takes/rom_3_raw.c3d"), target()) else { return };
    let raw = raw_take::read(&path, None).unwrap();
    let step = 5;
    let found = clean(thinned(&raw, step), &target, &Settings::default(), &NoProgress).unwrap();
    let truth: Vec<DVec3> = truth().chunks(89).step_by(step).flatten().copied().collect();
    let off = rms(distances(&found.take, &truth).into_iter());
    let of = |kind: Kind| found.report.events.iter().filter(|e| e.kind == kind).count();
    let _ = writeln!(std::io::stderr(), "every fifth frame: {off:.3} mm, {:?}", found.report.warnings);
    // The take has one swap.
    assert_eq!((of(Kind::Shuffled), of(Kind::Slide), of(Kind::Swap)), (0, 0, 1));
    assert!(off < 0.28 && found.report.warnings.is_empty(), "{off} {:?}", found.report.warnings);
}
