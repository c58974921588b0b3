//! Names of places of a face, compared with the labels of markers that people named after them.
use crate::real_data::bare;
use rhytid_core::{Face, NoProgress, Rig, UpAxis};
use rhytid_formats::tables;
use rhytid_solve::{FacePart, FacePlaces, face_parts, solve};
use rhytid_test_support::shared;

fn rig(face: &Face) -> Rig<f64> {
    solve(face, &NoProgress).unwrap()
}

/// The place of each handle, from its position alone.
fn places(rig: &Rig<f64>) -> Vec<(String, String)> {
    let places = FacePlaces::of_rig(rig).expect("it looks like a face");
    let handles = rig.handles();
    handles.labels.iter().cloned().zip(handles.rest.iter().map(|x| places.name(*x, None))).collect()
}

/// The numbers of landmarks of Multi-PIE, and the places that they may be at. Right is the person's own.
const LANDMARKS: [(std::ops::Range<u32>, &[&str]); 13] = [
    (17..22, &["right brow", "right temple"]),
    (22..27, &["left brow", "left temple"]),
    (27..36, &["nose", "between the brows"]),
    (36..37, &["right upper lid", "right lower lid"]),
    (37..39, &["right upper lid"]),
    (40..42, &["right lower lid"]),
    (43..45, &["left upper lid"]),
    (46..48, &["left lower lid"]),
    (48..49, &["right corner of the mouth"]),
    (50..53, &["upper lip"]),
    (54..55, &["left corner of the mouth"]),
    (56..59, &["lower lip"]),
    (66..67, &["lower lip"]),
];

#[test]
fn landmarks_are_at_the_places_that_they_are_named_after() {
    let Some(shared) = shared("") else { return };
    let handles = tables::read_handles(&shared.join("data/markers.csv")).unwrap();
    for folder in ["face", "head"] {
        let found = places(&rig(&bare(&shared.join("data").join(folder), handles.clone(), 0.01)));
        let mut checked = 0;
        for (label, place) in &found {
            let Some(number) = label.strip_prefix("mp").and_then(|n| n.parse::<u32>().ok()) else { continue };
            let Some((_, expected)) = LANDMARKS.iter().find(|(range, _)| range.contains(&number)) else {
                continue;
            };
            assert!(expected.contains(&place.as_str()), "{folder}: {label} is at the {place}");
            checked += 1;
        }
        assert!(checked >= 27, "{folder}: {checked}");
    }
}

/// ICT-FaceKit documents the vertices of each part of its head.
#[test]
fn skin_is_told_from_mouth_sockets_teeth_and_eyes() {
    let Some(shared) = shared("") else { return };
    let handles = tables::read_handles(&shared.join("data/markers.csv")).unwrap();
    let parts = face_parts(&rig(&bare(&shared.join("data/head"), handles, 0.01)));
    let check = |what: &str, range: std::ops::Range<usize>, least: f64, of: &[FacePart]| {
        let count = range.len() as f64;
        let share = parts[range].iter().filter(|part| of.contains(part)).count() as f64 / count;
        println!("{what}: {share:.3}");
        assert!(share > least, "{what}: {share}");
    };
    // The face has the inner sides of lips and lids, and nostrils.
    check("face", 0..9_409, 0.8, &[FacePart::Skin]);
    check("eyeballs", 21_451..24_591, 0.9, &[FacePart::Eyes]);
    check("teeth", 17_039..21_451, 0.9, &[FacePart::Teeth]);
    check("socket of the mouth", 11_248..13_294, 0.9, &[FacePart::Mouth, FacePart::Inside]);
    check("back of the head and neck", 9_409..11_248, 0.9, &[FacePart::Skin]);
    check("sockets of the eyes", 13_294..14_062, 0.9, &[FacePart::Inside, FacePart::Eyes, FacePart::Other]);
}

#[test]
fn both_sides_are_the_persons_own_and_other_axes_change_nothing() {
    let face = rhytid_demo::face(2_000);
    let found = places(&rig(&face));
    for (label, place) in &found {
        let is_left = label.rsplit('_').next().unwrap().starts_with('L');
        let is_right = label.rsplit('_').next().unwrap().starts_with('R');
        assert!(!place.starts_with("right ") || !is_left, "{label} is at the {place}");
        assert!(!place.starts_with("left ") || !is_right, "{label} is at the {place}");
        let words = [
            ("brow_", "brow"),
            ("lid_up", "upper lid"),
            ("lid_low", "lower lid"),
            ("forehead", "forehead"),
            ("cheek_", "cheek"),
            ("nose_", "nose"),
            ("lip_up", "upper lip"),
            ("lip_low", "lower lip"),
            ("mouth_corner", "corner of the mouth"),
            ("chin_L", "chin"),
            ("chin_R", "chin"),
        ];
        // The outermost markers of the forehead are at the temples.
        let words = words.into_iter().filter(|(word, _)| *word != "forehead" || !label.ends_with('3'));
        for (_, of_place) in words.filter(|(word, _)| label.starts_with(word)) {
            assert!(place.contains(of_place), "{label} is at the {place}, expected the {of_place}");
        }
    }
    // Z up, in metres, and elsewhere. Examples show more of the openings, so both have none.
    let mut face = face;
    face.examples.clear();
    let mut other = face.clone();
    let to_z = |[x, y, z]: [f64; 3]| [x / 100.0 + 3.0, -z / 100.0 - 7.0, y / 100.0 + 1.5];
    other.up_axis = UpAxis::Z;
    other.metres_per_unit = 1.0;
    other.neutral.positions.iter_mut().for_each(|x| *x = to_z(*x));
    assert_eq!(places(&rig(&other)), places(&rig(&face)));
    // A face that looks back has no places.
    let mut back = face;
    back.neutral.positions.iter_mut().for_each(|x| *x = [-x[0], x[1], -x[2]]);
    assert!(FacePlaces::of_rig(&rig(&back)).is_none());
}
