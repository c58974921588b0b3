//! Sound C3D files, of every kind.
use super::c3d_writer::{C3d, PROCESSORS, Value, trial};
use super::{is_missing, read};
use rhytid_core::RawTake;

/// Compares with what [`trial`] wrote.
fn assert_is_trial(take: &RawTake, written: &C3d, tolerance: f64, what: &str) {
    let tracks = &take.tracks;
    let points = written.frames[0].len();
    assert_eq!(tracks.frames(), written.frames.len(), "{what}");
    assert_eq!(tracks.labels, (0..points).map(|j| format!("a{j}")).collect::<Vec<_>>(), "{what}");
    assert_eq!(take.metres_per_unit, Some(0.001), "{what}");
    let confidence = tracks.confidence.as_ref().expect("a point was filled");
    for (i, frame) in written.frames.iter().enumerate() {
        assert_eq!(tracks.times[i], i as f64 / 120.0);
        for (j, (position, fourth)) in frame.iter().enumerate() {
            let found = tracks.positions[i * points + j];
            assert_eq!(is_missing(&found), *fourth < 0, "{what}: {i}, {j}");
            let near = |(a, b): (f64, &f32)| (a - f64::from(*b)).abs() <= tolerance;
            assert!(
                *fourth < 0 || found.into_iter().zip(position).all(near),
                "{what}: {found:?} {position:?}"
            );
            let expected = if *fourth == 0 { RawTake::FILLED } else { 1.0 };
            assert_eq!(confidence[i * points + j], expected, "{what}: {i}, {j}");
        }
    }
}

#[test]
fn six_encodings_of_one_trial_are_one_take() {
    const STEP: f32 = 0.0625;
    let mut written = trial(7, 40);
    written.analog = 5;
    let expected = read(&written.bytes(), "trial.c3d");
    for (name, processor) in PROCESSORS {
        let float = C3d { processor, ..written.clone() };
        let take = read(&float.bytes(), "trial.c3d");
        assert_is_trial(&take, &float, 0.0, name);
        assert_eq!(take.warnings, [""; 0], "{name}");
        // The whole steps hold the trial exactly; a step that does not is off by half of it at most.
        for step in [STEP, 0.1] {
            let integer = float.clone().integer(step);
            let take = read(&integer.bytes(), "trial.c3d");
            let tolerance = if step == STEP { 0.0 } else { f64::from(step) / 2.0 + 1e-4 };
            assert_is_trial(&take, &integer, tolerance, name);
            assert_eq!(take.tracks.times, expected.tracks.times);
        }
    }
}

#[test]
fn entries_without_descriptions_are_found_by_their_offsets() {
    let written = C3d { descriptions: false, ..trial(4, 10) };
    let take = read(&written.bytes(), "trial.c3d");
    assert_is_trial(&take, &written, 0.0, "no descriptions");
    assert_eq!(take.warnings, [""; 0]);
}

#[test]
fn labels_go_on_in_labels_2_and_3() {
    let mut written = trial(520, 6);
    let labels: Vec<String> = (0..520).map(|j| format!("a{j}")).collect();
    for (name, range) in [("LABELS", 0..255), ("LABELS2", 255..510), ("LABELS3", 510..520)] {
        written.set("POINT", name, Value::Texts(labels[range].to_vec()));
    }
    let take = read(&written.bytes(), "trial.c3d");
    assert_eq!(take.tracks.labels, labels);
    assert_eq!(take.warnings, [""; 0]);
}

#[test]
fn the_clock_begins_at_the_first_frame() {
    let mut written = trial(2, 8);
    written.header.frames = Some((241, 248));
    let take = read(&written.bytes(), "trial.c3d");
    assert_eq!(take.tracks.times[..2], [240.0 / 120.0, 241.0 / 120.0]);
    assert_eq!(take.warnings, [""; 0]);
}

#[test]
fn more_frames_than_a_word_counts() {
    const FRAMES: usize = 70_000;
    let words = |n: usize| Value::Words(vec![(n & 0xFFFF) as u16, (n >> 16) as u16]);
    let start = 66_001;
    let by_trial = {
        let mut written = trial(2, FRAMES);
        written.header.frames = Some((65535, 65535));
        written.set("POINT", "FRAMES", Value::Words(vec![65535]));
        written.set("TRIAL", "ACTUAL_START_FIELD", words(start));
        written.set("TRIAL", "ACTUAL_END_FIELD", words(start + FRAMES - 1));
        written
    };
    let take = read(&by_trial.bytes(), "trial.c3d");
    assert_eq!(take.tracks.frames(), FRAMES);
    assert_eq!(take.tracks.times[0], 66_000.0 / 120.0);
    assert_eq!(take.warnings, [""; 0]);
    assert_eq!(take.tracks.positions[2 * (FRAMES - 1)][0], -700.0 + 69_999.0 / 16.0);

    // Wrapped words in the header, and a cut: the long count stands.
    let mut cut = by_trial.bytes();
    cut.truncate(cut.len() - 30_000 * 32);
    let take = read(&cut, "trial.c3d");
    assert_eq!(take.tracks.frames(), 40_000);
    assert!(super::warns(&take, "40000 of its 70000 frames"), "{:?}", take.warnings);

    let mut by_long = trial(2, FRAMES);
    by_long.header.frames = Some((1, 65535));
    by_long.set("POINT", "FRAMES", Value::Words(vec![65535]));
    by_long.set("POINT", "LONG_FRAMES", Value::Floats(vec![FRAMES as f32]));
    assert_eq!(read(&by_long.bytes(), "trial.c3d").tracks.frames(), FRAMES);

    let mut by_float = by_long.clone();
    by_float.remove("POINT", "LONG_FRAMES");
    by_float.set("POINT", "FRAMES", Value::Floats(vec![FRAMES as f32]));
    assert_eq!(read(&by_float.bytes(), "trial.c3d").tracks.frames(), FRAMES);

    // Nothing but full counters.
    let mut full = by_long.clone();
    full.remove("POINT", "LONG_FRAMES");
    let take = read(&full.bytes(), "trial.c3d");
    assert_eq!(take.tracks.frames(), FRAMES);
    assert!(super::warns(&take, "given as 65535"), "{:?}", take.warnings);
}

#[test]
fn a_writer_that_knows_no_residuals_filled_nothing() {
    let mut written = trial(3, 6);
    for (_, fourth) in written.frames.iter_mut().flatten() {
        *fourth = (*fourth).min(0);
    }
    let take = read(&written.bytes(), "trial.c3d");
    assert_eq!(take.tracks.confidence, None);
    assert!(is_missing(&take.tracks.positions[3 * 3 + 1]));
}

#[test]
fn coordinates_that_are_no_numbers_are_missing_points() {
    let mut written = trial(3, 6);
    written.frames[2][0].0[1] = f32::NAN;
    written.frames[2][2].0 = [f32::INFINITY, 0.0, 0.0];
    let take = read(&written.bytes(), "trial.c3d");
    let missing: Vec<usize> = (0..18).filter(|&i| is_missing(&take.tracks.positions[i])).collect();
    assert_eq!(missing, [6, 8, 10]);
}
