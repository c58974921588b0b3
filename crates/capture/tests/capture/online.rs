//! Frames as they come, compared with the clean-up of the whole take and with the truth.
use crate::real_take::{rms, target, truth};
use glam::DVec3;
use rhytid_capture::{Kind, Online, Settings, Step, clean};
use rhytid_core::{NoProgress, RawTake, Take};
use rhytid_formats::raw_take;
use rhytid_test_support::shared;
use std::io::Write;

/// The neutral frames, at the start of the take.
const NEUTRAL: usize = 60;
/// Frames per second.
const RATE: f64 = 120.0;

fn neutral(raw: &RawTake) -> RawTake {
    RawTake { tracks: raw.tracks.slice(0..NEUTRAL), ..raw.clone() }
}

/// The real take's head turns, and its markers have noise, gaps and ghosts.
#[test]
fn a_turning_head_is_taken_out_as_from_the_whole_take() {
    let (Some(target), Some(path)) = (target(), shared("data/takes/rom_3_raw.c3d")) else { return };
    let raw = raw_take::read(&path, None).unwrap();
    let settings = Settings { neutral: Some(0..NEUTRAL), ..Settings::default() };
    let whole = clean(raw.clone(), &target, &settings, &NoProgress).unwrap();
    let (mut online, warnings) = Online::calibrate(neutral(&raw), &target, &settings).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    let (h, m) = (target.labels.len(), raw.tracks.labels.len());
    let mut repaired = vec![false; h * raw.tracks.frames()];
    for event in &whole.report.events {
        if let (Some(marker), false) = (event.marker, matches!(event.kind, Kind::Strain | Kind::Step)) {
            // On line, labels that are exchanged are seen as jumps, for a moment after they are right again,
            // too.
            let after = if event.kind == Kind::Swap { (0.2 * RATE) as usize } else { 0 };
            for frame in event.first..(event.first + event.frames + after).min(raw.tracks.frames()) {
                for marker in [Some(marker), event.other].into_iter().flatten() {
                    repaired[frame * h + marker] = true;
                }
            }
        }
    }
    let truth = truth();
    let (mut measured, mut guessed, mut from_truth) = (Vec::new(), Vec::new(), Vec::new());
    let mut turned = 0.0_f64;
    for (f, markers) in raw.tracks.positions.chunks(m).enumerate() {
        let frame = online.frame(raw.tracks.times[f], markers);
        for (j, position) in frame.positions.iter().enumerate() {
            let position = DVec3::from_array(position.map(f64::from));
            let at = f * h + j;
            let off = 10.0 * position.distance(DVec3::from_array(whole.take.positions[at]));
            if repaired[at] {
                guessed.push(off);
            } else {
                measured.push(off);
            }
            from_truth.push(10.0 * position.distance(truth[at]));
        }
        let offline = &whole.take.head.as_ref().unwrap()[f];
        let [a, b] = [&frame.head, offline].map(|motion| glam::DQuat::from_array(motion.rotation));
        turned = turned.max(a.angle_between(b).to_degrees());
    }
    let [a, b, c] = [&measured, &guessed, &from_truth].map(|off| rms(off.iter().copied()));
    let worst = measured.iter().copied().fold(0.0, f64::max);
    let _ = writeln!(
        std::io::stderr(),
        "on line: RMS {a:.4} mm from the clean-up ({worst:.2} mm at worst), {b:.3} mm where that repaired, \
         {c:.4} mm from the truth; the head turned {turned:.3}° otherwise at most"
    );
    assert!(a < 0.3 && worst < 1.5 && b < 4.5 && c < 0.7 && turned < 0.4, "{a} {b} {c} {turned}");
}

/// A face of 20 markers and a cap of 4 that turn, in metres.
fn made(frames: usize) -> (rhytid_capture::Target, RawTake) {
    let rest: Vec<DVec3> = (0..20)
        .map(|i| {
            let (x, y) = (f64::from(i % 5) * 2.5 - 5.0, f64::from(i / 5) * 3.0 - 4.5);
            DVec3::new(x, y, 6.0 - 0.08 * x * x)
        })
        .collect();
    let cap =
        [[0.0, 14.0, 5.0], [7.0, 10.0, -1.0], [-7.0, 10.0, -1.0], [0.0, 16.0, -4.0]].map(DVec3::from_array);
    let labels = (0..20).map(|i| format!("m{i}")).collect::<Vec<_>>();
    let mut positions = Vec::new();
    for f in 0..frames {
        let t = f as f64 / 100.0;
        let turn = glam::DQuat::from_euler(glam::EulerRot::YXZ, 0.4 * t.sin(), 0.2 * (2.0 * t).sin(), 0.0);
        let smile = DVec3::Y * (0.3 * (t - 0.6).max(0.0).sin());
        let face = rest.iter().map(|p| *p + smile * (p.x / 5.0).abs());
        positions.extend(face.chain(cap).map(|p| (turn * p * 0.01 + DVec3::new(0.0, 1.5, 0.2)).to_array()));
    }
    let tracks = Take {
        labels: labels.iter().cloned().chain((0..4).map(|i| format!("cap{i}"))).collect(),
        times: (0..frames).map(|f| f as f64 / 100.0).collect(),
        positions,
        ..Take::default()
    };
    let target =
        rhytid_capture::Target { labels, rest, metres_per_unit: 0.01, strains: vec![], examples: vec![] };
    (target, RawTake { tracks, metres_per_unit: Some(1.0), ..RawTake::default() })
}

#[test]
fn a_marker_that_is_lost_or_jumps_goes_with_its_neighbours_and_fades() {
    let (target, raw) = made(300);
    let settings = Settings { neutral: Some(0..NEUTRAL), ..Settings::default() };
    let (mut online, _) = Online::calibrate(neutral(&raw), &target, &settings).unwrap();
    let with_ghosts = Settings { skip: [Step::Outliers].into(), ..settings };
    let (mut trusting, _) = Online::calibrate(neutral(&raw), &target, &with_ghosts).unwrap();
    for (f, markers) in raw.tracks.positions.chunks(24).enumerate() {
        let mut markers = markers.to_vec();
        let whole = online.clone().frame(raw.tracks.times[f], &markers);
        assert!(whole.confidence.iter().all(|sure| *sure == 1.0) || f > 200);
        if (200..225).contains(&f) {
            markers[7] = [f64::NAN; 3];
        }
        if (250..253).contains(&f) {
            markers[3][0] += 0.03;
        }
        // The whole cap is lost: the face stands in for it.
        if f == 280 {
            markers.truncate(20);
        }
        let frame = online.frame(raw.tracks.times[f], &markers);
        let trusted = trusting.frame(raw.tracks.times[f], &markers);
        for j in 0..20 {
            let [a, b] = [&frame, &whole].map(|frame| DVec3::from_array(frame.positions[j].map(f64::from)));
            let most = if f == 280 {
                2.0
            } else if frame.confidence[j] < 1.0 {
                0.5
            } else {
                1e-3
            };
            assert!(10.0 * a.distance(b) < most, "frame {f}, marker {j}: {} mm", 10.0 * a.distance(b));
        }
        match f {
            224 => assert!((frame.confidence[7] - 0.5).abs() < 1e-6, "{}", frame.confidence[7]),
            250..253 => {
                assert!(frame.confidence[3] < 1.0 && trusted.confidence[3] == 1.0);
                let off = (trusted.positions[3][0] - frame.positions[3][0]).abs();
                assert!(off > 2.0, "{off}");
            }
            _ => assert!((200..225).contains(&f) || frame.confidence.iter().all(|sure| *sure == 1.0), "{f}"),
        }
    }
}

/// The rig's jaw is narrower than the actor's, and its forehead wider.
#[test]
fn markers_move_more_where_the_rig_is_larger_as_in_the_whole_take() {
    let (mut target, raw) = made(300);
    target.rest.iter_mut().for_each(|p| p.x *= 1.0 + 0.05 * p.y);
    let settings = Settings {
        neutral: Some(0..NEUTRAL),
        rigid: Some((0..4).map(|i| format!("cap{i}")).collect()),
        skip: [Step::HeadLowPass, Step::LowPass].into(),
        ..Settings::default()
    };
    let whole = clean(raw.clone(), &target, &settings, &NoProgress).unwrap();
    let smallest = whole.report.setup.scales.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(smallest < 0.9, "{smallest}");
    let (mut online, _) = Online::calibrate(neutral(&raw), &target, &settings).unwrap();
    let mut moved = 0.0_f64;
    for (f, markers) in raw.tracks.positions.chunks(24).enumerate() {
        let frame = online.frame(raw.tracks.times[f], markers);
        for (j, position) in frame.positions.iter().enumerate() {
            let position = DVec3::from_array(position.map(f64::from));
            let off = 10.0 * position.distance(DVec3::from_array(whole.take.positions[f * 20 + j]));
            assert!(off < 1e-3, "frame {f}, marker {j}: {off} mm");
            moved = moved.max(position.distance(target.rest[j]));
        }
    }
    assert!(moved > 0.2, "{moved}");
}

/// While the actor holds still, a thing in the room keeps its distances from the face as a cap does.
#[test]
fn a_thing_beside_a_still_head_is_not_its_cap() {
    let (target, mut raw) = made(300);
    let first = raw.tracks.positions[..24].to_vec();
    for (f, frame) in raw.tracks.positions.chunks_mut(24).enumerate() {
        if f < NEUTRAL {
            frame.copy_from_slice(&first);
        }
        frame[20..].copy_from_slice(&first[20..]);
    }
    raw.tracks.labels[20..].iter_mut().enumerate().for_each(|(i, label)| *label = format!("thing{i}"));
    let (mut online, warnings) = Online::calibrate(neutral(&raw), &target, &Settings::default()).unwrap();
    assert!(warnings.iter().any(|w| w.sentence().contains("\"thing0\"")), "{warnings:?}");
    for (f, markers) in raw.tracks.positions.chunks(24).enumerate().skip(NEUTRAL) {
        let frame = online.frame(raw.tracks.times[f], markers);
        let off = frame.positions.iter().zip(&target.rest).map(|(p, rest)| {
            let moved = DVec3::from_array(p.map(f64::from)) - *rest;
            10.0 * (moved - DVec3::Y * (0.3 * (f as f64 / 100.0 - 0.6).sin() * (rest.x / 5.0).abs())).length()
        });
        let worst = off.fold(0.0, f64::max);
        assert!(worst < 3.0, "frame {f}: {worst} mm");
    }
}

#[test]
fn a_cap_that_is_not_seen_is_said() {
    let (target, mut raw) = made(NEUTRAL);
    raw.tracks.positions.chunks_mut(24).for_each(|frame| frame[20..].fill(RawTake::MISSING));
    let (_, warnings) = Online::calibrate(raw, &target, &Settings::default()).unwrap();
    let words = "named like those of a cap, but are hardly ever seen together";
    assert!(warnings.iter().any(|w| w.sentence().contains(words)), "{warnings:?}");
}

#[test]
fn an_infinite_position_is_not_seen() {
    let (target, mut raw) = made(NEUTRAL + 1);
    let (mut online, _) = Online::calibrate(neutral(&raw), &target, &Settings::default()).unwrap();
    let markers = &mut raw.tracks.positions[NEUTRAL * 24..];
    markers[7][1] = f64::INFINITY;
    let frame = online.frame(0.6, markers);
    assert!(frame.positions.as_flattened().iter().all(|x| x.is_finite()), "{frame:?}");
    assert!(frame.confidence[7] == 0.0 && frame.confidence[8] == 1.0);
}

#[test]
fn what_cannot_be_calibrated_is_one_sentence() {
    let (target, raw) = made(NEUTRAL);
    let said = |raw: RawTake, settings: &Settings| {
        Online::calibrate(raw, &target, settings).unwrap_err().to_string()
    };
    let axes = |axes: &str| Settings { axes: Some(axes.parse().unwrap()), ..Settings::default() };
    assert!(said(raw.clone(), &axes("-x+y+z")).contains("mirror image"));
    let mut unseen = raw.clone();
    unseen.tracks.positions.fill(RawTake::MISSING);
    assert!(said(unseen, &Settings::default()).contains("no marker of a handle is seen"));
    let rigid =
        Settings { rigid: Some(vec!["hat".into(), "cap1".into(), "cap2".into()]), ..Settings::default() };
    assert!(said(raw, &rigid).contains("“hat” is not in the file"));
}
