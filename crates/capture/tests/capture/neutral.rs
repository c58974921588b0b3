//! The neutral frames of a real take: at its start, its end or in its middle, after an expression, or
//! nowhere.
use crate::real_take::{target, truth};
use glam::DVec3;
use rhytid_capture::{Cleaned, Settings, Step, Target, clean};
use rhytid_core::{NoProgress, RawTake, Take, Warning};
use rhytid_formats::{mesh, raw_take, tables};
use rhytid_test_support::shared;
use std::io::Write;

/// The raw take. Where a marker was not seen, it stays where it was: then nothing must be filled, which takes
/// long.
fn raw() -> Option<RawTake> {
    let mut raw = raw_take::read(&shared("data/takes/rom_3_raw.c3d")?, None).unwrap();
    let (markers, positions) = (raw.tracks.labels.len(), &mut raw.tracks.positions);
    for i in markers..positions.len() {
        if positions[i][0].is_nan() {
            positions[i] = positions[i - markers];
        }
    }
    Some(raw)
}

/// Only what the neutral frames depend on.
fn settings() -> Settings {
    let skip = [Step::Swaps, Step::Outliers, Step::Slides, Step::LowPass].into();
    Settings { skip, ..Settings::default() }
}

/// The same take with these of its frames, in this order.
fn reordered(raw: &RawTake, frames: impl Iterator<Item = usize>) -> RawTake {
    let markers = raw.tracks.labels.len();
    let positions: Vec<[f64; 3]> =
        frames.flat_map(|f| raw.tracks.positions[f * markers..][..markers].to_vec()).collect();
    let times = (0..positions.len() / markers).map(|f| f as f64 / 120.0).collect();
    let tracks = Take { labels: raw.tracks.labels.clone(), times, positions, ..Take::default() };
    RawTake { tracks, ..raw.clone() }
}

/// The actor's own face with its examples.
fn own() -> Option<Target> {
    let mut target = target()?;
    let handles = tables::read_handles(&shared("data/markers.csv")?).unwrap();
    let neutral = mesh::read(&shared("data/face/neutral.obj")?).unwrap();
    for name in ["rom3_1460", "rom3_1680", "rom3_2020", "rom3_2770"] {
        let pose = mesh::read(&shared(&format!("data/face/poses/{name}.obj"))?).unwrap();
        let moved = handles.at(&pose.positions).into_iter().zip(handles.at(&neutral.positions));
        let moved = moved.map(|(p, q)| DVec3::from_array(p) - DVec3::from_array(q)).collect();
        target.examples.push((name.to_owned(), moved));
    }
    Some(target)
}

/// A face of other proportions, whose handles were placed with a frame of half-closed lids.
fn another() -> Option<Target> {
    let mut target = own()?;
    let half_closed = &truth()[804 * 89..805 * 89];
    for (rest, p) in target.rest.iter_mut().zip(half_closed) {
        let wide = DVec3::new(0.06 * p.x, 0.03 * p.y, 0.1 * (0.7 * p.y).sin());
        *rest = *p + wide + 0.15 * DVec3::new((5.0 * p.y).sin(), (4.0 * p.x).sin(), (3.0 * p.x).cos());
    }
    Some(target)
}

fn cleaned(name: &str, raw: RawTake, target: &Target) -> Cleaned {
    let found = clean(raw, target, &settings(), &NoProgress).unwrap();
    let setup = &found.report.setup;
    let _ = writeln!(
        std::io::stderr(),
        "{name}: {:?}, rival {:?}, {:?}",
        setup.neutral,
        setup.neutral_rival,
        found.report.warnings
    );
    found
}

#[test]
fn the_neutral_is_found_where_it_is() {
    let (Some(raw), Some(own), Some(another)) = (raw(), own(), another()) else { return };
    for (name, target) in [("own", &own), ("another", &another)] {
        for (order, frames, expected) in [
            ("as it is", (0..2400).collect::<Vec<_>>(), 0..60),
            ("reversed", (0..2400).rev().collect(), 2340..2400),
            ("turned", (1100..2400).chain(0..1100).collect(), 1300..1360),
        ] {
            let name = format!("{name}, {order}");
            let setup = cleaned(&name, reordered(&raw, frames.into_iter()), target).report.setup;
            let is_near = setup.neutral.start.abs_diff(expected.start) <= 12;
            assert!(is_near || setup.neutral_rival.is_some(), "{name}: {setup:?}");
            if target == &own || order != "turned" {
                assert!(is_near, "{name}: {:?}", setup.neutral);
            }
        }
    }
    assert!(cleaned("own", raw, &own).report.setup.neutral_rival.is_none());
}

#[test]
fn a_held_expression_is_not_neutral() {
    let (Some(raw), Some(own), Some(another)) = (raw(), own(), another()) else { return };
    // Frame 1240 holds an expression; it is held for a second and a half, and then the take begins.
    for target in [&own, &another] {
        let frames = (0..180).map(|f| 1240 + f % 20).chain(0..2400);
        let setup = cleaned("held first", reordered(&raw, frames), target).report.setup;
        assert!(setup.neutral.start.abs_diff(180) <= 12 || setup.neutral_rival.is_some(), "{setup:?}");
        assert!(setup.neutral.start >= 168, "{:?}", setup.neutral);
    }
}

#[test]
fn a_take_without_a_neutral_face_says_so() {
    let (Some(raw), Some(own), Some(another)) = (raw(), own(), another()) else { return };
    for target in [&own, &another] {
        let speech = cleaned("speech", reordered(&raw, 900..1500), target);
        let says = |w: &Warning| {
            w.sentence().contains("no half second of the take is surely the neutral face")
                && !w.remedies().is_empty()
        };
        assert!(speech.report.warnings.iter().any(says), "{:?}", speech.report.warnings);
        let whole = cleaned("whole", raw.clone(), target);
        assert!(!whole.report.warnings.iter().any(says), "{:?}", whole.report.warnings);
        // Frames that are given are not doubted.
        let settings = Settings { neutral: Some(0..60), ..settings() };
        let given = clean(reordered(&raw, 900..1500), target, &settings, &NoProgress).unwrap();
        assert!(!given.report.warnings.iter().any(says), "{:?}", given.report.warnings);
    }
}

#[test]
fn a_take_that_is_too_short_says_so() {
    let (Some(raw), Some(own)) = (raw(), own()) else { return };
    for (frames, expected) in [(2, Some("2 frames, 0.017 s")), (5, Some("5 frames, 0.042 s")), (60, None)] {
        let found = cleaned("short", reordered(&raw, 0..frames), &own);
        let said: Vec<&str> = found.report.warnings.iter().map(Warning::sentence).collect();
        let said = said.iter().find(|said| said.contains("half a second is needed"));
        match expected {
            Some(expected) => assert!(said.is_some_and(|said| said.contains(expected)), "{said:?}"),
            None => assert_eq!(said, None),
        }
    }
}
