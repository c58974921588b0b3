//! The right head and the right actor: takes in which another rigid thing, or another face, could be taken
//! for the actor's own. It needs `../shared/data` beside the repository.
use crate::real_take::{distances, rms, target, truth};
use glam::{DQuat, DVec3};
use rhytid_capture::{Cleaned, Kind, Settings, clean};
use rhytid_core::{Error, NoProgress, RawTake, Remedy};
use rhytid_formats::raw_take;
use rhytid_geometry::registration::fit;
use rhytid_test_support::shared;
use std::f64::consts::TAU;
use std::io::Write;

const FRAMES: usize = 600;

/// What the unchanged take comes to, with room for a little more noise of the head's motion.
const GOOD: f64 = 0.13;

/// The first five seconds of the raw take, in millimetres with Z up.
fn raw() -> Option<RawTake> {
    let raw = raw_take::read(&shared("data/takes/rom_3_raw.c3d")?, None).unwrap();
    Some(RawTake { tracks: raw.tracks.slice(0..FRAMES), ..raw })
}

fn cleaned(raw: RawTake, settings: &Settings) -> rhytid_core::Result<Cleaned> {
    clean(raw, &target().unwrap(), settings, &NoProgress)
}

/// RMS distance from the truth in millimetres.
fn off(cleaned: &Cleaned) -> f64 {
    rms(distances(&cleaned.take, &truth()[..FRAMES * 89]).into_iter())
}

/// The same without the rigid motion of each frame, which a face without a cap does not show exactly.
fn off_but_for_the_head(cleaned: &Cleaned) -> f64 {
    let truth = truth();
    let of_frame = |f: usize| {
        let found: Vec<DVec3> =
            cleaned.take.positions[f * 89..][..89].iter().map(|p| DVec3::from_array(*p)).collect();
        let truth = &truth[f * 89..][..89];
        let motion = fit(&found, truth, &[1.0; 89], false).unwrap();
        found.iter().zip(truth).map(|(p, q)| 10.0 * motion.apply(*p).distance(*q)).collect::<Vec<_>>()
    };
    rms((0..FRAMES).flat_map(of_frame))
}

/// Numbers from -1 to 1 that follow no pattern.
fn noise(i: usize) -> f64 {
    2.0 * ((i as f64 * 12.9898).sin() * 43_758.545_3).rem_euclid(1.0) - 1.0
}

/// The take with more markers: where each one is in each frame, with noise as the others have it.
fn with(raw: &RawTake, labels: &[&str], at: &dyn Fn(usize, usize) -> DVec3) -> RawTake {
    let (mut raw, n) = (raw.clone(), raw.tracks.labels.len());
    let mut positions = Vec::new();
    for (f, frame) in raw.tracks.positions.chunks_exact(n).enumerate() {
        positions.extend_from_slice(frame);
        for i in 0..labels.len() {
            let seed = 3 * (f * labels.len() + i);
            let shake = DVec3::new(noise(seed), noise(seed + 1), noise(seed + 2)) * 0.14;
            positions.push((at(i, f) + shake).to_array());
        }
    }
    raw.tracks.labels.extend(labels.iter().map(|label| (*label).to_owned()));
    raw.tracks.positions = positions;
    raw.tracks.confidence = None;
    raw
}

/// The take without these markers.
fn without(raw: &RawTake, is_gone: &dyn Fn(&str) -> bool) -> RawTake {
    let mut raw = raw.clone();
    let keep: Vec<bool> = raw.tracks.labels.iter().map(|label| !is_gone(label)).collect();
    let n = keep.len();
    let positions = raw.tracks.positions.iter().enumerate().filter(|(i, _)| keep[i % n]).map(|(_, p)| *p);
    raw.tracks.positions = positions.collect();
    raw.tracks.labels =
        raw.tracks.labels.into_iter().zip(&keep).filter(|(_, keep)| **keep).map(|(l, _)| l).collect();
    raw.tracks.confidence = None;
    raw
}

/// The true motion of the head in the file's space: a point of the face's space in centimetres becomes a
/// place in the file.
fn head() -> Vec<(DQuat, DVec3)> {
    let text = std::fs::read_to_string(shared("data/takes/rom_3_raw_head.csv").unwrap()).unwrap();
    let of_line = |line: &str| {
        let n: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        (DQuat::from_xyzw(n[2], n[3], n[4], n[1]).normalize(), DVec3::new(n[5], n[6], n[7]))
    };
    text.lines().skip(1).map(of_line).collect()
}

/// A place in the mesh's axes in centimetres, in the file's axes in millimetres.
fn in_file(p: DVec3) -> DVec3 {
    DVec3::new(p.x, -p.z, p.y) * 10.0
}

/// Five points of a thing about 20 cm large.
fn thing(i: usize) -> DVec3 {
    [(0.0, 0.0, 0.0), (19.0, 2.0, 1.0), (3.0, 14.0, -2.0), (-5.0, 6.0, 9.0), (8.0, -7.0, 5.0)]
        .map(|(x, y, z)| DVec3::new(x, y, z))[i]
}

/// A thing's motion: its points from 0 to 4 in each frame, in the mesh's axes in centimetres.
type Motion = Box<dyn Fn(usize, usize) -> DVec3>;

/// Rigid things in the room that are not on the head: what they are, and where their points are.
fn things() -> Vec<(&'static str, Motion)> {
    let (on_chest, near) = (head(), head());
    vec![
        ("still points of the room", Box::new(|i, _| DVec3::new(-80.0, 20.0, -150.0) + 8.0 * thing(i))),
        (
            "a chair that is moved once",
            Box::new(|i, f| {
                let s = ((f as f64 - 200.0) / 100.0).clamp(0.0, 1.0);
                DVec3::new(60.0 * s, 45.0, -30.0) + DQuat::from_rotation_y(s) * (3.0 * thing(i))
            }),
        ),
        (
            "a slate",
            Box::new(|i, f| {
                let t = f as f64 / 120.0;
                DVec3::new(40.0 - 9.0 * t, 150.0, 60.0) + DQuat::from_rotation_z(2.0 * t) * thing(i)
            }),
        ),
        // The chest goes where the head goes, but turns a fifth as far.
        (
            "the actor's chest",
            Box::new(move |i, f| {
                let (turn, place) = on_chest[f];
                place - DVec3::Y * 30.0 + DQuat::IDENTITY.slerp(turn, 0.2) * thing(i)
            }),
        ),
        // A hand that holds something beside the cheek, and shakes it a little.
        (
            "a hand near the face",
            Box::new(move |i, f| {
                let (turn, place) = near[f];
                let t = f as f64 / 120.0;
                let shaken = DQuat::from_euler(glam::EulerRot::XYZ, 0.2 * (TAU * t).sin(), 0.1 * t, 0.0);
                place
                    + turn * DVec3::new(14.0, 0.0, 8.0)
                    + shaken * (DVec3::new(4.0, 6.0, 5.0) + 0.4 * thing(i))
            }),
        ),
        // Another actor nods differently.
        (
            "another actor's cap",
            Box::new(|i, f| {
                let t = f as f64 / 120.0;
                let turn =
                    DQuat::from_euler(glam::EulerRot::XYZ, 0.3 * (1.7 * t).sin(), 0.4 * (0.9 * t).cos(), 0.0);
                DVec3::new(90.0 + 3.0 * t.sin(), 160.0, 0.0) + turn * (DVec3::Y * 10.0 + 0.6 * thing(i))
            }),
        ),
    ]
}

#[test]
fn other_rigid_things_are_not_the_head() {
    let Some(raw) = raw() else { return };
    let bare = without(&raw, &|label| label.starts_with("head"));
    for (what, motion) in things() {
        // More points than the cap has.
        let labels = ["thing1", "thing2", "thing3", "thing4", "thing5"];
        let at = |i: usize, f: usize| in_file(motion(i, f));
        let found = cleaned(with(&raw, &labels, &at), &Settings::default()).unwrap();
        let _ = writeln!(std::io::stderr(), "{what}: {:.4} mm", off(&found));
        assert_eq!(found.report.setup.rigid, ["head0", "head1", "head2", "head3"], "{what}");
        assert!(off(&found) < GOOD, "{what}: {}", off(&found));

        let found = cleaned(with(&bare, &labels, &at), &Settings::default()).unwrap();
        let said = found.report.warnings.iter().any(|w| w.sentence().contains("do not travel with the face"));
        let (whole, face) = (off(&found), off_but_for_the_head(&found));
        let _ = writeln!(std::io::stderr(), "{what}, no cap: {whole:.4} mm, but for the head {face:.4} mm");
        assert!(found.report.setup.rigid.is_empty() && said, "{what}: {:?}", found.report.setup.rigid);
        assert!(face < GOOD && whole < 0.4, "{what}: {face} {whole}");
    }
}

#[test]
fn a_slate_without_a_cap() {
    let Some(path) = shared("data/other-people/takes/prop_no_headband.c3d") else { return };
    let found = cleaned(raw_take::read(&path, None).unwrap(), &Settings::default()).unwrap();
    let (whole, face) = (off(&found), off_but_for_the_head(&found));
    let _ = writeln!(std::io::stderr(), "{whole:.4} mm, but for the head {face:.4} mm");
    assert!(found.report.setup.rigid.is_empty() && face < GOOD && whole < 0.4, "{face} {whole}");
    let said = found.report.warnings.iter().find(|w| w.sentence().contains("do not travel with the face"));
    assert!(said.unwrap().sentence().contains("\"slate1\", \"slate2\", \"slate3\""));
}

#[test]
fn two_actors_with_the_same_labels() {
    let Some(path) = shared("data/other-people/takes/two_actors.c3d") else { return };
    let raw = raw_take::read(&path, None).unwrap();
    let Error::Input(error) = cleaned(raw.clone(), &Settings::default()).unwrap_err() else { panic!() };
    assert!(error.sentence().contains("\"Anna\", \"Ben\""), "{error}");
    assert_eq!(error.remedies(), [Remedy::ChooseSubject]);
    let anna = Settings { subject: Some("Anna".into()), ..Settings::default() };
    let found = cleaned(raw.clone(), &anna).unwrap();
    let _ = writeln!(std::io::stderr(), "{:.4} mm", off(&found));
    assert!(off(&found) < GOOD, "{}", off(&found));
    assert_eq!(found.report.setup.rigid, ["Anna:head0", "Anna:head1", "Anna:head2", "Anna:head3"]);
    assert_eq!(found.report.setup.subject.as_deref(), Some("Anna"));

    // The rig has the labels of one of them alone.
    for to in ["other_", "#2"] {
        let mut raw = raw.clone();
        for label in &mut raw.tracks.labels {
            let (subject, name) = label.split_once(':').unwrap();
            *label = match (subject, to) {
                ("Anna", "#2") => name.to_owned(),
                ("Ben", "#2") => format!("{name}#2"),
                ("Ben", _) => format!("Ben:{to}{name}"),
                _ => label.clone(),
            };
        }
        let found = cleaned(raw, &Settings::default()).unwrap();
        assert!(off(&found) < GOOD, "{to}: {}", off(&found));
        let said = found.report.warnings.iter().any(|w| w.sentence().contains("more than one subject"));
        assert_eq!(said, to == "#2", "{:?}", found.report.warnings);
    }
}

#[test]
fn a_soft_head_band_without_a_telling_name_is_used_and_said() {
    let Some(raw) = raw() else { return };
    let bare = without(&raw, &|label| label.starts_with("head"));
    let labels = ["root-1", "root-2", "root-3", "root-4", "root-5", "root-6"];
    let head = head();
    let points = [
        (0.0, 14.0, 5.0),
        (7.0, 11.0, -1.0),
        (-7.0, 11.0, -1.0),
        (4.0, 14.0, -6.0),
        (-4.0, 14.0, -6.0),
        (0.0, 9.0, -9.0),
    ];
    // Each marker sways slowly by up to this many millimetres.
    for (sway, is_said, good) in [(0.15, false, 0.5), (0.9, true, 0.6)] {
        let at = |i: usize, f: usize| {
            let (turn, place) = head[f];
            let t = f as f64 / 120.0;
            let wave = |c: f64| (t * (1.1 + 0.3 * c) + i as f64 * (2.0 + c)).sin();
            let sways = DVec3::new(wave(0.0), wave(1.0), wave(2.0)) * (0.1 * sway);
            in_file(0.93 * (turn * (DVec3::from(points[i]) + sways)) + place)
        };
        let found = cleaned(with(&bare, &labels, &at), &Settings::default()).unwrap();
        let _ = writeln!(std::io::stderr(), "sways by {sway} mm: {:.4} mm", off(&found));
        assert_eq!(found.report.setup.rigid, labels, "{:?}", found.report.warnings);
        let said = found.report.warnings.iter().any(|w| w.sentence().contains("not quite rigid"));
        assert_eq!(said, is_said, "{:?}", found.report.warnings);
        assert!(off(&found) < good, "{}", off(&found));
    }
}

#[test]
fn a_cap_that_slips_is_named() {
    let Some(mut raw) = raw() else { return };
    let n = raw.tracks.labels.len();
    let head = head();
    // In the middle of the take the cap slips a centimetre down the forehead.
    for (f, motion) in head.iter().enumerate().take(FRAMES).skip(300) {
        let slip = in_file(motion.0 * DVec3::new(0.0, -0.7, 0.7));
        for (label, p) in raw.tracks.labels.iter().zip(&mut raw.tracks.positions[f * n..][..n]) {
            if label.starts_with("head") {
                *p = (DVec3::from_array(*p) + slip).to_array();
            }
        }
    }
    let found = cleaned(raw.clone(), &Settings::default()).unwrap();
    let words =
        "markers \"head0\", \"head1\", \"head2\", \"head3\" are named like those of a cap, but do not travel";
    assert!(
        found.report.warnings.iter().any(|w| w.sentence().contains(words)),
        "{:?}",
        found.report.warnings
    );
    assert!(off(&found) < 0.4, "{}", off(&found));
    // Those that a person names are believed.
    let given =
        Settings { rigid: Some(["head0", "head1", "head2"].map(String::from).into()), ..Settings::default() };
    let found = cleaned(raw, &given).unwrap();
    assert_eq!(found.report.setup.rigid, ["head0", "head1", "head2"]);
    let words = "the given rigid markers do not travel with the face";
    assert!(
        found.report.warnings.iter().any(|w| w.sentence().contains(words)),
        "{:?}",
        found.report.warnings
    );
}

#[test]
fn points_without_a_name_change_nothing() {
    let Some(raw) = raw() else { return };
    let plain = cleaned(raw.clone(), &Settings::default()).unwrap();
    let labels: Vec<String> = (0..40).map(|i| format!("*{i}")).collect();
    let labels: Vec<&str> = labels.iter().map(String::as_str).collect();
    // Pieces of half a second, some of which are near the face.
    let at = |i: usize, f: usize| {
        if (f / 15) % 40 == i { DVec3::new(i as f64 * 5.0, 60.0, 1600.0) } else { DVec3::NAN }
    };
    let found = cleaned(with(&raw, &labels, &at), &Settings::default()).unwrap();
    assert_eq!(found.take.positions, plain.take.positions);
    assert_eq!(found.report.events, plain.report.events);
    assert_eq!(found.report.setup.unused.len(), 40);
}

#[test]
fn a_marker_that_is_hardly_ever_seen_is_not_used() {
    let Some(mut raw) = raw() else { return };
    let n = raw.tracks.labels.len();
    let column = raw.tracks.labels.iter().position(|label| label == "mp30").unwrap();
    for f in 25..FRAMES {
        raw.tracks.positions[f * n + column] = RawTake::MISSING;
    }
    let found = cleaned(raw, &Settings::default()).unwrap();
    let marker = found.report.labels.iter().position(|label| label == "mp30");
    let never: Vec<_> = found.report.events.iter().filter(|e| e.kind == Kind::NeverSeen).collect();
    assert!(never.len() == 1 && never[0].marker == marker, "{never:?}");
    let words = "1 of the handles' markers are seen in less than a twentieth of the frames";
    assert!(
        found.report.warnings.iter().any(|w| w.sentence().contains(words)),
        "{:?}",
        found.report.warnings
    );
    assert_eq!(found.report.setup.unused, ["mp30"]);
}

#[test]
fn what_cannot_be_a_face_is_an_error_that_names_its_markers() {
    let Some(mut raw) = raw() else { return };
    let n = raw.tracks.labels.len();
    for label in ["jaw08", "mp57"] {
        let column = raw.tracks.labels.iter().position(|known| known == label).unwrap();
        // A number that stands for missing, for longer than an outlier lasts.
        for f in 200..280 {
            raw.tracks.positions[f * n + column] = [9999.0; 3];
        }
    }
    let kept = Settings { skip: [rhytid_capture::Step::Slides].into(), ..Settings::default() };
    let Error::Input(error) = cleaned(raw.clone(), &kept).unwrap_err() else { panic!() };
    assert!(
        error.sentence().contains("cannot be a face's") && error.sentence().contains("jaw08 is "),
        "{error}"
    );
    assert!(error.sentence().contains("mp57 is ") && error.sentence().contains("9999"), "{error}");
    assert_eq!(error.remedies(), [Remedy::KeepImplausible]);
    let found = cleaned(raw, &Settings { force: true, ..kept }).unwrap();
    let said = found.report.warnings.iter().find(|w| w.sentence().contains("cannot be a face's"));
    assert!(said.is_some(), "{:?}", found.report.warnings);
}
