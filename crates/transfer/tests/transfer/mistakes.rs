//! Mistakes are reported, with their remedies.
use crate::support::{bare, processor, rig};
use rhytid_core::{Examples, Face, NoProgress, Progress, Rig, Table};
use rhytid_test_support::changed;
use rhytid_transfer::{Settings, Transferred, transfer};

fn made(from: &Rig, to: &Face, landmarks: Option<&[(&str, &str)]>) -> rhytid_core::Result<Transferred> {
    let owned = landmarks.map(|l| l.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect());
    let settings = Settings { landmarks: owned, linear_band: false };
    transfer(from, to, &settings, &processor(), &NoProgress)
}

fn faces() -> (Rig, Face) {
    let (first, second) = (rhytid_demo::face(2_500), rhytid_demo::face(2_000));
    let second = bare(&second, second.neutral.clone(), second.handles.points.clone());
    (rig(&first), second)
}

#[test]
fn landmarks_that_say_too_little_are_refused() {
    let (from, mut to) = faces();
    let refused = |to: &Face, landmarks: Option<&[(&str, &str)]>, expected: &str| {
        let message = made(&from, to, landmarks).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    };
    let three: Vec<(&str, &str)> = ["chin", "nasion", "neck"].map(|label| (label, label)).to_vec();
    refused(&to, Some(&three), "demo and second share 3 landmarks, expected at least 4");
    refused(&to, Some(&[("chinn", "chin")]), "demo has no handle called “chinn”");
    refused(&to, Some(&[("chin", "chinn")]), "second has no handle called “chinn”");
    let without = changed(&from, |r| {
        let (v, handles) = (r.surface.rest.len(), r.handles.len());
        r.examples = Examples { names: Vec::new(), handles: Table::filled(0, handles, [0.0; 3]) };
        r.fine_scale.pose_features = Table::filled(1, r.handles.strain_edges.len(), 0.0);
        r.fine_scale.rbf_weights = Table::filled(v, 1, [0.0; 3]);
        r.learned = None;
    })
    .unwrap();
    let message = made(&without, &to, None).unwrap_err().to_string();
    assert!(message.contains("has no examples"), "{message}");
    to.handles.labels.iter_mut().for_each(|label| label.insert(0, 'x'));
    refused(&to, None, "share 0 landmarks");
    to.handles.points[1] = to.handles.points[0];
    refused(&to, None, "vertex");
}

#[test]
fn doubtful_landmarks_are_warned_of() {
    let (from, to) = faces();
    let warned = |to: &Face, landmarks: Option<&[(&str, &str)]>, expected: &str| {
        let found = made(&from, to, landmarks).unwrap().report.warnings;
        assert!(found.iter().any(|warning| warning.contains(expected)), "{expected}: {found:?}");
    };
    assert_eq!(made(&from, &to, None).unwrap().report.warnings, [""; 0]);
    // Left and right are exchanged in all labels.
    let mut mirrored = to.clone();
    for label in &mut mirrored.handles.labels {
        *label = label.replace("_L", "_?").replace("_R", "_L").replace("_?", "_R");
    }
    warned(&mirrored, None, "left and right are exchanged");
    // One landmark is at another place.
    let mut astray = to.clone();
    let at = |label: &str| to.handles.labels.iter().position(|l| l == label).unwrap();
    astray.handles.labels.swap(at("cheek_L2"), at("cheekbone_L2"));
    warned(&astray, None, "do not fit their surroundings: cheek");
    let few: Vec<(&str, &str)> =
        ["chin", "nasion", "mouth_corner_L", "mouth_corner_R", "forehead"].map(|l| (l, l)).to_vec();
    warned(&to, Some(&few), "only 5 landmarks are shared");
    // The mesh is in metres, but the unit says centimetres.
    let mut small = to.clone();
    small.neutral.positions.iter_mut().flatten().for_each(|x| *x *= 0.01);
    warned(&small, None, "the second face is 0.01 times as large as the first");
}

#[test]
fn what_is_of_its_own_is_kept_and_work_can_be_stopped() {
    let (from, mut to) = faces();
    let own = rhytid_demo::face(2_000).examples.swap_remove(2);
    to.examples.push(own.clone());
    let found = made(&from, &to, None).unwrap();
    assert_eq!(found.report.own, std::slice::from_ref(&own.name));
    assert_eq!(found.face.examples.len(), from.examples().names.len());
    assert_eq!(found.face.examples[0], own);

    struct Stopped;
    impl Progress for Stopped {
        fn report(&self, _: &'static str, _: u64, _: u64) {}
        fn cancelled(&self) -> bool {
            true
        }
    }
    let stopped = transfer(&from, &to, &Settings::default(), &processor(), &Stopped);
    assert!(matches!(stopped, Err(rhytid_core::Error::Cancelled)), "{stopped:?}");
}
