//! Faults of a capture system beyond gaps and ghosts: labels that slide, and a handle in the wrong place.
//! Also repairs by hand, and a filter that takes noise but leaves blinks and plosives.
use crate::real_take::{distances, rms, target, truth};
use glam::{DMat3, DVec3};
use rhytid_capture::{Cleaned, Edit, Kind, Settings, Step, Target, clean};
use rhytid_core::{NoProgress, RawTake, Take};
use rhytid_formats::raw_take;
use rhytid_test_support::shared;
use std::f64::consts::PI;
use std::io::Write;
use std::ops::Range;

fn raw() -> Option<RawTake> {
    Some(raw_take::read(&shared("data/takes/rom_3_raw.c3d")?, None).unwrap())
}

fn cleaned(raw: RawTake, target: &Target, settings: &Settings) -> Cleaned {
    clean(raw, target, settings, &NoProgress).unwrap()
}

/// The place of a label in the real take. The label slides to the other label's place and snaps back from
/// there.
fn slide(raw: &mut RawTake, label: &str, to: &str, frames: Range<usize>) -> usize {
    let column = |name: &str| raw.tracks.labels.iter().position(|l| l == name).unwrap();
    let (a, b, markers) = (column(label), column(to), raw.tracks.labels.len());
    for f in frames.clone() {
        let at = |j: usize| DVec3::from_array(raw.tracks.positions[f * markers + j]);
        let s = (f + 1 - frames.start) as f64 / frames.len() as f64;
        raw.tracks.positions[f * markers + a] = at(a).lerp(at(b), s).to_array();
    }
    a
}

#[test]
fn labels_that_slide_are_cut_out_of_a_real_take_and_nothing_else() {
    let (Some(target), Some(whole)) = (target(), raw()) else { return };
    let without = cleaned(whole.clone(), &target, &Settings::default());
    let slides = |cleaned: &Cleaned| {
        let of = cleaned.report.events.iter().filter(|e| e.kind == Kind::Slide);
        of.map(|e| (e.marker.unwrap(), e.first..e.first + e.frames)).collect::<Vec<_>>()
    };
    assert_eq!(slides(&without), []);
    for (label, to, first) in [("mp53", "mp51", 1500), ("mp20", "mp27", 700), ("jaw08", "mp57", 1900)] {
        let mut raw = whole.clone();
        let marker = slide(&mut raw, label, to, first..first + 48);
        let found = cleaned(raw.clone(), &target, &Settings::default());
        let cut = slides(&found);
        let _ = writeln!(std::io::stderr(), "{label} to {to}: {cut:?}");
        assert!(!cut.is_empty() && cut.iter().all(|(j, _)| *j == marker), "{label}: {cut:?}");
        let (start, end) = (cut[0].1.start, cut.last().unwrap().1.end);
        assert!(start.abs_diff(first) < 15 && end.abs_diff(first + 48) < 30, "{label}: {cut:?}");
        let off = distances(&found.take, &truth());
        let there = |off: &[f64]| (first..first + 48).map(|f| off[f * 89 + marker]).fold(0.0, f64::max);
        assert!(there(&off) < 2.0 && rms(off.iter().copied()) < 0.13, "{label}: {}", there(&off));
        let kept = Settings { skip: [Step::Slides].into(), ..Settings::default() };
        let off = distances(&cleaned(raw, &target, &kept).take, &truth());
        assert!(there(&off) > 8.0, "{label}: {}", there(&off));
    }
}

#[test]
fn a_misplaced_handle_is_named_and_harms_no_other() {
    let (Some(target), Some(raw)) = (target(), raw()) else { return };
    let right = cleaned(raw.clone(), &target, &Settings::default());
    for (handle, by) in [(8, DVec3::Y * 7.0), (30, DVec3::new(5.0, 0.0, -6.0)), (60, DVec3::splat(4.0))] {
        let mut wrong = target.clone();
        wrong.rest[handle] += by;
        let found = cleaned(raw.clone(), &wrong, &Settings::default());
        assert_eq!(found.report.setup.neutral, right.report.setup.neutral);
        let named = format!("the marker of {} is", target.labels[handle]);
        assert!(
            found.report.warnings.iter().any(|w| w.sentence().contains(&named)),
            "{:?}",
            found.report.warnings
        );
        let off = found.take.positions.iter().zip(&right.take.positions).enumerate();
        let others = off.filter(|(i, _)| i % 89 != handle);
        let worst = others.map(|(_, (a, b))| 10.0 * DVec3::from_array(*a).distance(DVec3::from_array(*b)));
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < 0.1, "{handle}: {worst} mm");
    }
}

const RATE: f64 = 120.0;
const FRAMES: usize = 1200;

/// Uniform numbers from -1 to 1.
fn random(i: usize) -> f64 {
    let x = (i as f64 * 12.9898).sin() * 43_758.545_3;
    2.0 * (x - x.floor()) - 1.0
}

/// How far marker `j` of a face is out in frame `f`, in millimetres. Every second a blink of 0.15 s moves the
/// lids (0 to 3) by 9 mm. A plosive of 0.08 s moves the lips (4 to 7) by 4 mm.
fn height(j: usize, f: usize) -> f64 {
    let (width, height, phase) = match j {
        0..4 => (0.15, 9.0, 0.3),
        4..8 => (0.08, 4.0, 0.7),
        _ => return 0.0,
    };
    let t = (f as f64 / RATE).fract() - phase;
    if t.abs() < 0.5 * width { 0.5 * height * (1.0 + (2.0 * PI * t / width).cos()) } else { 0.0 }
}

/// Twenty markers in head space with 0.14 mm RMS of noise, and their target.
fn noisy() -> (RawTake, Target) {
    let rest: Vec<DVec3> =
        (0..20).map(|j| DVec3::new(f64::from(j % 5) * 3.0, f64::from(j / 5) * 3.0, 0.0)).collect();
    let labels: Vec<String> = (0..20).map(|j| format!("m{j}")).collect();
    let positions = (0..FRAMES).flat_map(|f| {
        let rest = &rest;
        (0..20).map(move |j| {
            let noise = DVec3::from_array([0, 1, 2].map(|c| random(3 * (f * 20 + j) + c))) * 0.014;
            (rest[j] - DVec3::Y * 0.1 * height(j, f) + noise).to_array()
        })
    });
    let times = (0..FRAMES).map(|f| f as f64 / RATE).collect();
    let tracks = Take { labels: labels.clone(), times, positions: positions.collect(), ..Take::default() };
    let raw = RawTake { tracks, in_head_space: true, ..RawTake::default() };
    (raw, Target { labels, rest, metres_per_unit: 0.01, strains: Vec::new(), examples: Vec::new() })
}

#[test]
fn the_filter_takes_noise_and_leaves_blinks_and_plosives() {
    let (raw, target) = noisy();
    let at = |cleaned: &Cleaned, j: usize, f: usize| {
        10.0 * (target.rest[j] - DVec3::from_array(cleaned.take.positions[f * 20 + j]))
    };
    let filtered = cleaned(raw.clone(), &target, &Settings::default());
    assert_eq!(filtered.report.low_pass_hz, Some(12.0));
    for (marker, top) in [(0, 9.0), (4, 4.0)] {
        // The mean over all peaks, in which the noise of single peaks averages out.
        let peaks: Vec<usize> = (1..FRAMES - 1)
            .filter(|&f| {
                height(marker, f) > 0.9 * top
                    && height(marker, f) >= height(marker, f - 1).max(height(marker, f + 1))
            })
            .collect();
        let samples = || peaks.iter().flat_map(|&f| (marker..marker + 4).map(move |j| (j, f)));
        let kept: f64 = samples().map(|(j, f)| at(&filtered, j, f).y / height(j, f)).sum();
        let kept = kept / samples().count() as f64;
        let _ = writeln!(std::io::stderr(), "{top} mm: {kept:.4} of the height");
        assert!(peaks.len() >= 9 && (0.95..1.01).contains(&kept), "{top} mm: {kept}");
    }
    let noise = |cleaned: &Cleaned| {
        rms((0..FRAMES).flat_map(|f| (8..20).map(move |j| (j, f))).map(|(j, f)| at(cleaned, j, f).length()))
    };
    let as_it_is = cleaned(raw, &target, &Settings { skip: [Step::LowPass].into(), ..Settings::default() });
    assert!(noise(&filtered) < 0.55 * noise(&as_it_is), "{} {}", noise(&filtered), noise(&as_it_is));
}

#[test]
fn repairs_by_hand() {
    let (raw, target) = noisy();
    let none = Settings {
        skip: [Step::Swaps, Step::Slides, Step::Outliers, Step::LowPass].into(),
        ..Settings::default()
    };
    let mut wrong = raw.clone();
    for f in 300..340 {
        wrong.tracks.positions.swap(f * 20 + 9, f * 20 + 10);
        wrong.tracks.positions[f * 20 + 12][2] += 5.0;
    }
    let edits = vec![
        Edit::Swap(["m9".into(), "m10".into()], 300..340),
        Edit::Drop("m12".into(), 300..340),
        Edit::Hold("m0".into(), 30..45),
    ];
    let found = cleaned(wrong.clone(), &target, &Settings { edits, ..none.clone() });
    let (plain, before) = (cleaned(raw, &target, &none), cleaned(wrong, &target, &none));
    let apart = |a: &Cleaned, b: &Cleaned, j: usize, frames: Range<usize>| {
        let of = |c: &Cleaned, f: usize| DVec3::from_array(c.take.positions[f * 20 + j]);
        frames.map(|f| 10.0 * of(a, f).distance(of(b, f))).fold(0.0, f64::max)
    };
    assert!(apart(&before, &plain, 9, 300..340) > 20.0 && apart(&before, &plain, 12, 300..340) > 40.0);
    assert_eq!(apart(&found, &plain, 9, 300..340), 0.0);
    assert!(apart(&found, &plain, 12, 300..340) < 1.0);
    // The blink at 36 is held away: the lid stays where it is in frame 29.
    let lid = |f: usize| DVec3::from_array(found.take.positions[f * 20]);
    assert!((30..40).all(|f| lid(f).distance(lid(29)) < 0.1) && apart(&found, &plain, 0, 50..FRAMES) == 0.0);
    let kinds: Vec<_> =
        found.report.events.iter().filter(|e| e.first < 345).map(|e| (e.kind, e.marker)).collect();
    for expected in [(Kind::Swap, Some(9)), (Kind::Dropped, Some(12)), (Kind::Held, Some(0))] {
        assert!(kinds.contains(&expected), "{expected:?} {kinds:?}");
    }
}

#[test]
fn strains_and_steps_that_no_skin_has_are_events() {
    let (mut raw, mut target) = noisy();
    target.strains = vec![rhytid_capture::StrainLimit { handles: [12, 13], most: 1.0 }];
    for f in 600..FRAMES {
        raw.tracks.positions[f * 20 + 12][0] -= 4.0;
    }
    let settings = Settings { skip: [Step::Slides].into(), ..Settings::default() };
    let found = cleaned(raw, &target, &settings).report;
    let of = |kind: Kind| found.events.iter().filter(move |e| e.kind == kind).collect::<Vec<_>>();
    let (strains, steps) = (of(Kind::Strain), of(Kind::Step));
    assert!(strains.len() == 1 && steps.len() == 1, "{:?}", found.events);
    assert_eq!((strains[0].marker, strains[0].other), (Some(12), Some(13)));
    assert!(strains[0].first.abs_diff(600) < 5 && strains[0].first + strains[0].frames == FRAMES);
    assert!((strains[0].strain.unwrap() - 4.0 / 3.0).abs() < 0.05, "{:?}", strains[0]);
    assert!(
        steps[0].marker == Some(12)
            && steps[0].first == 600
            && (steps[0].distance_mm.unwrap() - 40.0).abs() < 1.0
    );
    assert!(
        found
            .warnings
            .iter()
            .any(|w| w.sentence().contains("between m12 and m13 the skin is stretched by 13")),
        "{:?}",
        found.warnings
    );
}

/// The true motion of an actor whose face is larger than the rig's about the mouth, in a capture's space. The
/// face is larger by `much` in the middle. Everything there moves as much farther as it is larger.
fn other_proportions(target: &Target, truth: &[DVec3], much: f64) -> RawTake {
    let mouth = target.rest[target.labels.iter().position(|l| l == "mp51").unwrap()] - DVec3::Y * 0.8;
    let at =
        |p: DVec3| p + much * (-(p - mouth).length_squared() / (2.0 * 5.0_f64.powi(2))).exp() * (p - mouth);
    // The cube root of the volume that a small cube becomes.
    let larger = |p: DVec3| {
        let along = |axis: DVec3| (at(p + 1e-4 * axis) - at(p - 1e-4 * axis)) / 2e-4;
        DMat3::from_cols(along(DVec3::X), along(DVec3::Y), along(DVec3::Z)).determinant().cbrt()
    };
    let actor: Vec<(DVec3, f64)> = target.rest.iter().map(|p| (at(*p), larger(*p))).collect();
    let cap =
        [[0.0, 14.0, 4.0], [6.0, 11.0, -2.0], [-6.0, 11.5, -1.0], [1.0, 16.0, -5.0]].map(DVec3::from_array);
    let frames = truth.chunks(89);
    let positions = frames.clone().flat_map(|frame| {
        let face = frame
            .iter()
            .zip(&target.rest)
            .zip(&actor)
            .map(|((p, rest), (at, larger))| *at + *larger * (*p - *rest));
        face.chain(cap).map(|p| (10.0 * p).to_array()).collect::<Vec<_>>()
    });
    let labels = target.labels.iter().cloned().chain((0..4).map(|i| format!("head{i}"))).collect();
    let times = (0..frames.len()).map(|f| f as f64 / RATE).collect();
    let tracks = Take { labels, times, positions: positions.collect(), ..Take::default() };
    RawTake { tracks, metres_per_unit: Some(1e-3), ..RawTake::default() }
}

#[test]
fn an_actor_of_other_proportions_moves_the_rig_as_far_as_its_face_goes() {
    let Some(target) = target() else { return };
    let truth = truth();
    for much in [0.25, -0.15] {
        let raw = other_proportions(&target, &truth, much);
        let settings = Settings { neutral: Some(0..60), ..Settings::default() };
        let found = cleaned(raw.clone(), &target, &settings);
        let skipped = cleaned(raw, &target, &Settings { skip: [Step::Proportions].into(), ..settings });
        let off = |cleaned: &Cleaned| rms(distances(&cleaned.take, &truth).into_iter());
        let _ = writeln!(
            std::io::stderr(),
            "mouth {much:+}: {:.3} mm, without proportions {:.3}",
            off(&found),
            off(&skipped)
        );
        assert!(off(&found) < 0.4 * off(&skipped));
    }
}

#[test]
fn poses_teach_how_an_actor_does_what_the_examples_show() {
    let Some(mut target) = target() else { return };
    let truth = truth();
    let rest = target.rest.clone();
    let displaced = |f: usize| -> Vec<DVec3> { (0..89).map(|j| truth[f * 89 + j] - rest[j]).collect() };
    // The actor opens the mouth less, smiles wider and raises the brows more than the rig does.
    let (low, high) = (
        rest.iter().map(|p| p.y).fold(f64::INFINITY, f64::min),
        rest.iter().map(|p| p.y).fold(f64::MIN, f64::max),
    );
    let actors = |p: DVec3, d: DVec3| {
        let s = (p.y - low) / (high - low);
        d * DVec3::new(1.3, 0.7, 0.8).lerp(DVec3::new(1.0, 1.4, 1.1), s)
    };
    let positions =
        truth.iter().enumerate().map(|(i, p)| rest[i % 89] + actors(rest[i % 89], *p - rest[i % 89]));
    let times = (0..truth.len() / 89).map(|f| f as f64 / RATE).collect();
    let positions: Vec<[f64; 3]> = positions.map(|p| p.to_array()).collect();
    let tracks = Take { labels: target.labels.clone(), times, positions, ..Take::default() };
    let raw = RawTake { tracks, in_head_space: true, ..RawTake::default() };
    let frames = [240, 500, 1112, 1400, 1760, 2200];
    target.examples = frames.iter().map(|f| (format!("pose{f}"), displaced(*f))).collect();
    let poses = frames.iter().map(|f| (format!("pose{f}"), *f)).collect();
    let skip = [Step::Slides, Step::Swaps, Step::Outliers, Step::LowPass].into();
    let without = Settings { skip, ..Settings::default() };
    let taught = cleaned(raw.clone(), &target, &Settings { poses, ..without.clone() });
    let off = |cleaned: &Cleaned| rms(distances(&cleaned.take, &truth).into_iter());
    let (before, after) = (off(&cleaned(raw.clone(), &target, &without)), off(&taught));
    let _ = writeln!(std::io::stderr(), "another way of moving: {before:.3} mm, with six poses {after:.3}");
    assert!(after < 0.35 * before, "{before} {after}");
    assert!(
        taught.report.setup.poses.len() == 6
            && taught.report.setup.poses.iter().all(|pose| pose.likeness > 0.8)
    );
    // A frame that shows something else causes a warning.
    let wrong = Settings { poses: [("pose1112".to_owned(), 1760)].into(), ..without };
    let warnings = cleaned(raw, &target, &wrong).report.warnings;
    assert!(
        warnings.iter().any(|w| w.sentence().contains("differs from the example “pose1112”")),
        "{warnings:?}"
    );
}
