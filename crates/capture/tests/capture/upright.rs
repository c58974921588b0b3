//! Which way is up: handles of the shared capture under other axes, names, subsets and bodies. They are
//! compared with the vertices that the capture was made at.
use crate::handles::face;
use glam::{DMat3, DVec3};
use rhytid_capture::{HandleSettings, PlacedHandles, place_handles};
use rhytid_core::numbers::median;
use rhytid_core::{Face, NoProgress, RawTake, Take};
use rhytid_formats::{raw_take, tables};
use rhytid_test_support::shared;
use std::collections::BTreeMap;

/// The shared capture: each eighth frame of it, without its cap.
fn capture(shared: &std::path::Path) -> RawTake {
    let mut raw = raw_take::read(&shared.join("data/takes/rom_3_raw.c3d"), None).unwrap();
    let count = raw.tracks.labels.len();
    let frames = raw.tracks.positions.chunks(count).step_by(8);
    let tracks = Take {
        positions: frames.flat_map(|frame| frame[..89].to_vec()).collect(),
        times: raw.tracks.times.iter().copied().step_by(8).collect(),
        labels: raw.tracks.labels[..89].to_vec(),
        ..Take::default()
    };
    raw.tracks = tracks;
    raw
}

/// Some of the markers, all under names that say nothing. Their old names stand behind.
fn anonymous(raw: &RawTake, is_kept: &dyn Fn(&str) -> bool) -> (RawTake, BTreeMap<String, String>) {
    let count = raw.tracks.labels.len();
    let kept: Vec<usize> = (0..count).filter(|&m| is_kept(&raw.tracks.labels[m])).collect();
    let mut other = raw.clone();
    let frames = raw.tracks.positions.chunks(count);
    other.tracks.positions = frames.flat_map(|frame| kept.iter().map(|&m| frame[m])).collect();
    other.tracks.labels = (0..kept.len()).map(|i| format!("q{i:02}")).collect();
    let names = other.tracks.labels.iter().cloned();
    let names = names.zip(kept.iter().map(|&m| raw.tracks.labels[m].clone())).collect();
    (other, names)
}

fn moved(raw: &RawTake, motion: &dyn Fn(DVec3) -> DVec3) -> RawTake {
    let mut other = raw.clone();
    for x in &mut other.tracks.positions {
        *x = motion(DVec3::from_array(*x)).to_array();
    }
    other
}

/// Where each handle is, in millimetres, by the markers' old names.
fn places(face: &Face, found: &PlacedHandles, names: &BTreeMap<String, String>) -> BTreeMap<String, DVec3> {
    let at = found.handles.at(&face.neutral.positions);
    let name = |label: &String| names.get(label).unwrap_or(label).clone();
    let places = at.iter().map(|x| DVec3::from_array(*x) * face.metres_per_unit * 1e3);
    found.handles.labels.iter().map(name).zip(places).collect()
}

/// The median distance between places of the same names.
fn apart(a: &BTreeMap<String, DVec3>, b: &BTreeMap<String, DVec3>) -> f64 {
    median(&mut a.iter().filter_map(|(name, x)| Some(x.distance(*b.get(name)?))).collect::<Vec<_>>())
}

fn placed(face: &Face, raw: &RawTake) -> PlacedHandles {
    place_handles(face, raw, &HandleSettings::default(), &NoProgress).unwrap()
}

/// The rotations that take axes to axes.
fn axes() -> Vec<DMat3> {
    let units = [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
    let pairs = units.iter().flat_map(|a| units.iter().map(move |b| (*a, *b)));
    pairs.filter(|(a, b)| a.dot(*b) == 0.0).map(|(a, b)| DMat3::from_cols(a, b, a.cross(b))).collect()
}

#[test]
fn the_handles_are_the_same_in_any_axes_and_without_names() {
    let Some(shared) = shared("") else { return };
    let head = face(&shared, "face", 0.01);
    let known = tables::read_handles(&shared.join("data/markers.csv")).unwrap();
    let known: BTreeMap<String, DVec3> = known
        .labels
        .iter()
        .cloned()
        .zip(known.at(&head.neutral.positions).into_iter().map(|x| 10.0 * DVec3::from_array(x)))
        .collect();
    // Sixteen markers fit in several ways.
    let (raw, names) = anonymous(&capture(&shared), &|label| {
        let few = [
            "jaw00", "jaw04", "jaw08", "jaw12", "jaw16", "mp17", "mp21", "mp22", "mp26", "mp30", "mp48",
            "mp51",
        ];
        few.contains(&label) || ["mp54", "mp57", "fps05", "fps11"].contains(&label)
    });
    let all = axes();
    assert_eq!(all.len(), 24);
    for turn in all {
        let found = placed(&head, &moved(&raw, &|x| turn * x));
        let off = apart(&places(&head, &found, &names), &known);
        assert!(off < 2.5 && found.faults.is_empty(), "{turn:?}: {off:.1} mm, {:?}", found.faults);
        assert_eq!(found.handles.labels.len(), 16);
    }
}

#[test]
fn half_a_face_lies_the_right_way_up() {
    let Some(shared) = shared("") else { return };
    let raw = capture(&shared);
    // On the head of another person, a part of a face slides along the skin. Upside down, it would be farther
    // off than 40 mm.
    for (mesh, unit, largest) in [("face", 0.01, 5.0), ("makehuman", 0.1, 25.0)] {
        let head = face(&shared, mesh, unit);
        let whole = placed(&head, &raw);
        assert!(whole.faults.is_empty(), "{mesh}: {:?}", whole.faults);
        assert!(!whole.warnings.iter().any(|warning| warning.contains("slid")), "{:?}", whole.warnings);
        let whole = places(&head, &whole, &BTreeMap::new());
        let height = median(&mut whole.values().map(|x| x.y).collect::<Vec<_>>());
        let middle = median(&mut whole.values().map(|x| x.x).collect::<Vec<_>>());
        type IsIn<'a> = &'a dyn Fn(&DVec3) -> bool;
        let left: IsIn<'_> = &|x| x.x > middle;
        let lower: IsIn<'_> = &|x| x.y < height;
        let upper: IsIn<'_> = &|x| x.y > height;
        let both: IsIn<'_> = &|x| x.x > middle || x.y < height - 20.0;
        for (half, is_in) in [("left", left), ("lower", lower), ("upper", upper), ("left and below", both)] {
            let (some, names) = anonymous(&raw, &|label| whole.get(label).is_some_and(is_in));
            let found = placed(&head, &some);
            let off = apart(&places(&head, &found, &names), &whole);
            println!("{mesh}, {half}: {} markers, {off:.1} mm, {:?}", names.len(), found.faults);
            let is_warned = found.warnings.iter().any(|warning| warning.contains("slid along the skin"));
            assert!(off < 5.0 || is_warned, "{mesh}, {half}: {off:.1} mm, {:?}", found.warnings);
            assert!(off < largest || !found.faults.is_empty(), "{mesh}, {half}: {off:.1} mm");
        }
    }
}

#[test]
fn a_body_gets_no_handles() {
    let Some(shared) = shared("") else { return };
    let head = face(&shared, "face", 0.01);
    let raw = capture(&shared);
    let alone = placed(&head, &raw);
    // Collar bones, shoulders, chest, elbows, hips, knees and ankles of a walking actor, and two hands.
    let mut body = raw.clone();
    let places = [
        (60.0, 1370.0),
        (180.0, 1390.0),
        (90.0, 1250.0),
        (260.0, 1130.0),
        (130.0, 980.0),
        (110.0, 520.0),
        (110.0, 90.0),
    ];
    let of_frame = |t: f64| -> Vec<DVec3> {
        let mut points = Vec::new();
        for side in [-1.0, 1.0] {
            for (i, (x, z)) in places.iter().enumerate() {
                let swing = (1370.0_f64 - z).max(20.0) * 0.1 * (5.0 * t + i as f64 + side).sin();
                points.push(DVec3::new(side * x, swing, *z));
            }
            for i in 0..12_u32 {
                let (x, y) = (f64::from(i % 4), f64::from(i / 4));
                let curl = 8.0 * (3.0 * t + f64::from(i)).sin();
                points.push(DVec3::new(side * (280.0 + 14.0 * x), curl - 100.0 + 20.0 * y, 800.0 + curl));
            }
        }
        points
    };
    let count = of_frame(0.0).len();
    body.tracks.labels.extend((0..count).map(|i| format!("body{i:02}")));
    let mut positions = Vec::new();
    for (frame, t) in raw.tracks.positions.chunks(89).zip(&raw.tracks.times) {
        let walk = DVec3::new(0.0, -900.0 * t, 12.0 * (10.0 * t).sin());
        let all = frame.iter().map(|x| DVec3::from_array(*x)).chain(of_frame(*t));
        positions.extend(all.map(|x| (x + walk).to_array()));
    }
    body.tracks.positions = positions;
    let found = placed(&head, &body);
    assert_eq!(found.elsewhere.len(), count, "{:?}", found.elsewhere);
    assert!(found.elsewhere.iter().all(|label| label.starts_with("body")) && found.faults.is_empty());
    let none = BTreeMap::new();
    let (before, after) = (self::places(&head, &alone, &none), self::places(&head, &found, &none));
    assert!(apart(&before, &after) < 0.5);
    // A file whose up axis is the other way round: the body is still below the face.
    let turned = placed(&head, &moved(&body, &|x| DVec3::new(x.x, -x.y, -x.z)));
    assert!(apart(&before, &self::places(&head, &turned, &none)) < 0.5);
}

#[test]
fn two_faces_are_told_apart_by_their_actor() {
    let Some(shared) = shared("") else { return };
    let head = face(&shared, "face", 0.01);
    let raw = raw_take::read(&shared.join("data/other-people/takes/two_actors.c3d"), None).unwrap();
    let found = placed(&head, &raw);
    assert!(found.faults.iter().any(|fault| fault.contains("more than one face")), "{:?}", found.faults);
    let settings = HandleSettings { subject: Some("Ben".into()), ..HandleSettings::default() };
    let found = place_handles(&head, &raw, &settings, &NoProgress).unwrap();
    assert!(found.faults.is_empty() && found.handles.labels.iter().all(|label| label.starts_with("Ben:")));
    assert!(found.handles.labels.len() > 80);
    let settings = HandleSettings { subject: Some("Carl".into()), ..HandleSettings::default() };
    let error = place_handles(&head, &raw, &settings, &NoProgress).unwrap_err().to_string();
    assert!(error.contains("is called \"Carl\"; it has \"Anna\", \"Ben\""), "{error}");
}

#[test]
fn a_still_take_of_few_markers_does_not_say_which_way_is_up() {
    let Some(shared) = shared("") else { return };
    let head = face(&shared, "makehuman", 0.1);
    let few = ["jaw04", "jaw12", "mp17", "mp26", "mp30", "mp48", "mp54"];
    let (mut raw, _) = anonymous(&capture(&shared), &|label| few.contains(&label));
    // One frame, about the middle of the face, in axes that say nothing.
    let first: Vec<DVec3> = raw.tracks.positions[..few.len()].iter().map(|x| DVec3::from_array(*x)).collect();
    let middle = first.iter().sum::<DVec3>() / first.len() as f64;
    let turn = DMat3::from_rotation_y(0.8) * DMat3::from_rotation_x(0.7);
    raw.tracks.positions = first.iter().map(|x| (turn * (*x - middle)).to_array()).collect();
    raw.tracks.times = vec![0.0];
    let found = placed(&head, &raw);
    assert!(
        found.faults.iter().any(|fault| fault.contains("nearly as well when they are turned")),
        "{found:?}"
    );
    // Three known points say where it is.
    let at = found.handles.points.iter().take(3).copied();
    let known = found.handles.labels.iter().cloned().zip(at).collect();
    let found =
        place_handles(&head, &raw, &HandleSettings { known, ..HandleSettings::default() }, &NoProgress)
            .unwrap();
    assert!(found.faults.is_empty(), "{:?}", found.faults);
}
