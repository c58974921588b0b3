//! Handles from a frame of a take: on the head of the take, where the vertices are known, and on another
//! head.
use glam::{DQuat, DVec3};
use rhytid_capture::{HandleSettings, Match, PlacedHandles, match_by_position, place_handles};
use rhytid_core::{
    Error, Example, Face, Handles, NoProgress, Progress, RawTake, Rig, Settings, SurfacePoint, Take, UpAxis,
    VertexId,
};
use rhytid_formats::{mesh, raw_take, tables};
use rhytid_test_support::points::beside;
use rhytid_test_support::shared;
use std::collections::BTreeMap;
use std::path::Path;

/// A mesh of the shared data with its poses, and no handles.
pub(super) fn face(shared: &Path, name: &str, metres_per_unit: f64) -> Face {
    let folder = shared.join("data").join(name);
    let path = folder.join("neutral.obj");
    let neutral = mesh::read(&path).unwrap();
    let mut poses: Vec<_> =
        std::fs::read_dir(folder.join("poses")).unwrap().map(|e| e.unwrap().path()).collect();
    poses.sort();
    let example = |pose: &std::path::PathBuf| Example {
        name: pose.file_stem().unwrap().to_string_lossy().into_owned(),
        positions: mesh::read_like(&neutral, &path, pose).unwrap(),
        mirror: false,
        noise: None,
    };
    Face {
        name: name.into(),
        examples: poses.iter().map(example).collect(),
        neutral,
        metres_per_unit,
        up_axis: UpAxis::Y,
        handles: Handles::default(),
        prior: None,
        settings: Settings::default(),
    }
}

/// Where each handle is, in millimetres.
fn places(face: &Face, handles: &Handles) -> BTreeMap<String, DVec3> {
    let at = |point: &SurfacePoint| {
        DVec3::from_array(point.at(&face.neutral.positions)) * face.metres_per_unit * 1e3
    };
    handles.labels.iter().cloned().zip(handles.points.iter().map(at)).collect()
}

fn placed(face: &Face, raw: &RawTake) -> PlacedHandles {
    place_handles(face, raw, &HandleSettings::default(), &NoProgress).unwrap()
}

#[test]
fn markers_find_their_vertices_on_the_head_that_they_are_from() {
    let Some(shared) = shared("") else { return };
    let head = face(&shared, "head", 0.01);
    let known = places(&head, &tables::read_handles(&shared.join("data/markers.csv")).unwrap());
    let raw = raw_take::read(&shared.join("data/takes/rom_3_raw.c3d"), None).unwrap();
    let off = |found: &PlacedHandles| {
        let mut off: Vec<f64> =
            places(&head, &found.handles).iter().map(|(label, x)| x.distance(known[label])).collect();
        off.sort_by(f64::total_cmp);
        off
    };
    let found = placed(&head, &raw);
    assert_eq!(found.rigid, ["head0", "head1", "head2", "head3"]);
    let as_it_is = off(&found);
    println!(
        "{} handles, frame {}: half within {:.2} mm, 95 % within {:.2}, the worst {:.2}",
        as_it_is.len(),
        found.frame,
        as_it_is[as_it_is.len() / 2],
        as_it_is[as_it_is.len() * 95 / 100],
        as_it_is[as_it_is.len() - 1]
    );
    // Two of them are in the nostrils, where no marker is glued: they are placed outside.
    assert!(as_it_is.len() >= 85 && as_it_is[as_it_is.len() - 3] < 1.0 && as_it_is[as_it_is.len() / 2] < 0.6);
    // The actor holds the neutral face in the first half second.
    assert!(found.frame < 60, "frame {}", found.frame);

    // Another unit without a statement, other axes, no head band, another head pose: the same vertices.
    let mut other = raw.clone();
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 2.5);
    for x in &mut other.tracks.positions {
        *x = (turn * (DVec3::from_array(*x) / 25.4) + DVec3::new(40.0, -7.0, 3.0)).to_array();
    }
    other.metres_per_unit = None;
    struct Stop;
    impl Progress for Stop {
        fn report(&self, _step: &'static str, _done: u64, _total: u64) {}
        fn cancelled(&self) -> bool {
            true
        }
    }
    let settings = HandleSettings { frame: Some(found.frame), ..HandleSettings::default() };
    let stopped = place_handles(&head, &other, &settings, &Stop);
    assert!(matches!(stopped, Err(Error::Cancelled)), "it stops when asked to");
    let again = place_handles(&head, &other, &settings, &NoProgress).unwrap();
    assert_eq!(again.handles.labels, found.handles.labels);
    let (before, after) = (places(&head, &found.handles), places(&head, &again.handles));
    for (label, x) in &before {
        assert!(x.distance(after[label]) < 5.0, "{label}: a vertex farther than its neighbours");
    }

    // Known vertices are kept, and unknown ones are reported.
    let known = HandleSettings { known: vec![("mp30".into(), VertexId(3).into())], ..settings };
    let kept = place_handles(&head, &other, &known, &NoProgress).unwrap().handles;
    assert_eq!(
        kept.points[kept.labels.iter().position(|label| label == "mp30").unwrap()],
        VertexId(3).into()
    );
    let wrong = |settings| place_handles(&head, &raw, &settings, &NoProgress).unwrap_err().to_string();
    let no_marker =
        HandleSettings { known: vec![("mp99".into(), VertexId(3).into())], ..HandleSettings::default() };
    assert!(wrong(no_marker).starts_with("no marker of the take is called “mp99”"));
    let no_frame = HandleSettings { frame: Some(9999), ..HandleSettings::default() };
    assert_eq!(wrong(no_frame), "the frame 9999 is not in the take, expected 0 to 2399");
}

#[test]
fn markers_between_vertices_are_placed_there() {
    let Some(shared) = shared("") else { return };
    let mut head = face(&shared, "face", 0.01);
    let known = tables::read_handles(&shared.join("data/markers.csv")).unwrap();
    let points = beside(&head.neutral, &known.points, [0.5, 0.3, 0.2]);
    let beside = Handles { labels: known.labels, points };
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, -1.0, 0.5).normalize(), 1.1);
    let shown = |x: [f64; 3]| (turn * (10.0 * DVec3::from_array(x)) + DVec3::splat(70.0)).to_array();
    let raw = RawTake {
        tracks: Take {
            labels: beside.labels.clone(),
            times: vec![0.0],
            positions: beside.at(&head.neutral.positions).into_iter().map(shown).collect(),
            ..Take::default()
        },
        metres_per_unit: Some(0.001),
        ..RawTake::default()
    };
    let settings = HandleSettings { rigid: Some(Vec::new()), ..HandleSettings::default() };
    let found = place_handles(&head, &raw, &settings, &NoProgress).unwrap().handles;
    let (expected, at) = (places(&head, &beside), places(&head, &found));
    let mut off: Vec<f64> = at.iter().map(|(label, x)| x.distance(expected[label])).collect();
    off.sort_by(f64::total_cmp);
    println!("{:.3} mm off at the median, {:.3} at 90 %", off[off.len() / 2], off[off.len() * 9 / 10]);
    // The next vertex is 1 mm away and more.
    assert!(off[off.len() / 2] < 0.2 && off[off.len() * 9 / 10] < 0.5, "{off:?}");
    assert!(found.points.iter().filter(|point| point.vertex().is_none()).count() > 80);

    // Handles that turn are at vertices.
    head.settings.rotations = true;
    let found = place_handles(&head, &raw, &settings, &NoProgress).unwrap().handles;
    assert!(found.points.iter().all(|point| point.vertex().is_some()));
}

#[test]
fn markers_of_another_actor_come_to_lie_where_they_belong() {
    let Some(shared) = shared("") else { return };
    let head = face(&shared, "makehuman", 0.1);
    let raw = raw_take::read(&shared.join("data/takes/rom_3_raw.c3d"), None).unwrap();
    let found = placed(&head, &raw);
    assert_eq!(found.rigid, ["head0", "head1", "head2", "head3"]);
    // Landmarks of this head, read off it.
    let landmarks = [
        ("mp30", [0.0, 6.909, 1.681]),
        ("jaw08", [0.0, 6.227, 1.455]),
        ("mp48", [-0.253, 6.609, 1.420]),
        ("mp54", [0.253, 6.609, 1.420]),
        ("mp51", [0.0, 6.696, 1.597]),
        ("mp57", [0.0, 6.527, 1.562]),
        ("mp27", [0.0, 7.351, 1.507]),
        ("mp33", [0.0, 6.789, 1.563]),
        ("mp18", [-0.483, 7.452, 1.326]),
        ("mp25", [0.483, 7.452, 1.326]),
    ];
    // In this frame, markers of the outer lids lie nearest to this head's corners of the eyes, which do not
    // blink.
    let settings = HandleSettings { frame: Some(714), ..HandleSettings::default() };
    let found = place_handles(&head, &raw, &settings, &NoProgress).unwrap();
    let blink = head.examples.iter().find(|example| example.name == "blink").unwrap();
    for label in ["fps35", "fps36"] {
        let i = found.handles.labels.iter().position(|known| known == label).unwrap();
        let moved = found.handles.points[i].at(&blink.positions)[1]
            - found.handles.points[i].at(&head.neutral.positions)[1];
        assert!(100.0 * moved < -2.0, "{label} goes {} mm with a blink", 100.0 * moved);
    }
    let said = found.warnings.iter().find(|warning| warning.contains("as no example moves")).unwrap();
    assert!(said.contains("fps35, fps36"), "{said}");
    let places = places(&head, &found.handles);
    for (label, x) in landmarks {
        let off = places[label].distance(100.0 * DVec3::from_array(x));
        println!("{label}: {off:.1} mm from where it belongs");
        assert!(off < 16.0, "{label}: {off} mm");
    }
    // A mirror image fits as well. Labels that name sides decide.
    let mut mirrored = raw;
    mirrored.tracks.positions.iter_mut().for_each(|x| x[0] = -x[0]);
    for (label, other) in [("mp18", "brow_r"), ("mp25", "brow_l"), ("mp48", "lip_r"), ("mp54", "lip_l")] {
        *mirrored.tracks.labels.iter_mut().find(|l| *l == label).unwrap() = other.into();
    }
    let warnings = placed(&head, &mirrored).warnings;
    assert!(warnings.iter().any(|warning| warning.contains("are a mirror image")), "{warnings:?}");
}

/// The rest pose with these handles, as far as matching by position looks at it.
fn rig_of(face: &Face, handles: Handles) -> Rig {
    let face = Face { handles, examples: Vec::new(), ..face.clone() };
    rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap()
}

#[test]
fn markers_of_other_names_are_matched_by_where_they_are() {
    let Some(shared) = shared("") else { return };
    let raw = raw_take::read(&shared.join("data/takes/rom_3_raw.c3d"), None).unwrap();
    let names = raw.tracks.labels.clone();
    for (name, unit, handles, least) in [("face", 0.01, "", 0.97), ("makehuman", 0.1, "placed", 0.95)] {
        let face = face(&shared, name, unit);
        let handles = match handles {
            "" => tables::read_handles(&shared.join("data/markers.csv")).unwrap(),
            _ => placed(&face, &raw).handles,
        };
        let rig = rig_of(&face, handles);
        // All markers under other names; half of them; and all with ten names kept.
        for (every, kept) in [(1, 0), (2, 0), (1, 10)] {
            let columns: Vec<usize> = (0..names.len()).filter(|m| m % every == 0 || *m >= 89).collect();
            let mut other = raw.clone();
            let positions = raw.tracks.positions.chunks(names.len());
            other.tracks.positions = positions.flat_map(|frame| columns.iter().map(|&m| frame[m])).collect();
            let label = |m: usize| if m < kept { names[m].clone() } else { format!("M{m:03}") };
            other.tracks.labels = columns.iter().map(|&m| label(m)).collect();
            let found = match_by_position(&rig, &other, &BTreeMap::new(), None, &NoProgress).unwrap();
            let there: Vec<&str> = columns
                .iter()
                .map(|&m| &names[m][..])
                .filter(|name| rig.handles().labels.iter().any(|l| l == name))
                .collect();
            let is_right = |m: &&Match| {
                let marker = m.marker.as_deref().unwrap_or_default();
                marker == m.handle
                    || marker
                        .strip_prefix('M')
                        .is_some_and(|m_| names[m_.parse::<usize>().unwrap()] == m.handle)
            };
            let right = found.iter().filter(is_right).count();
            let wrong: Vec<(&str, &str, f64)> = found
                .iter()
                .filter(|m| m.marker.is_some() && !is_right(m))
                .map(|m| (&m.handle[..], m.marker.as_deref().unwrap(), m.sure))
                .collect();
            println!(
                "{name}, {} markers, {kept} named: {right} of {} right, wrong {wrong:?}",
                columns.len(),
                there.len()
            );
            assert!(right as f64 >= least * there.len() as f64, "{right} of {}: {wrong:?}", there.len());
            let unsure = wrong.iter().filter(|(_, _, sure)| *sure < 0.55).count();
            assert!(2 * unsure >= wrong.len(), "{wrong:?}");
        }
    }
}

#[test]
fn a_marker_under_two_labels_is_named_with_the_other() {
    let Some(shared) = shared("") else { return };
    let mut raw = raw_take::read(&shared.join("data/takes/rom_3_raw.c3d"), None).unwrap();
    let head = face(&shared, "makehuman", 0.1);
    let before = placed(&head, &raw);
    assert!(!before.warnings.iter().any(|warning| warning.contains("mp30")), "{:?}", before.warnings);
    // The tip of the nose a second time, under another label.
    let (tracks, settings) =
        (&mut raw.tracks, HandleSettings { frame: Some(before.frame), ..Default::default() });
    let tip = tracks.labels.iter().position(|label| label == "mp30").unwrap();
    let count = tracks.labels.len();
    tracks.labels.push("twin".into());
    tracks.positions =
        tracks.positions.chunks(count).flat_map(|frame| [frame, &frame[tip..=tip]].concat()).collect();
    let found = place_handles(&head, &raw, &settings, &NoProgress).unwrap();
    let at = places(&head, &found.handles);
    assert!(at["mp30"].distance(at["twin"]) > 0.5, "two handles at one place");
    let said = found.warnings.iter().find(|warning| warning.contains("next free vertex")).unwrap();
    assert!(said.contains("twin (at the place of mp30)"), "{said}");
}
