//! Transfer to a head that shares nothing with the first: other vertices, another unit, and handles that come
//! from a capture's markers.
use crate::support::{face, minus, played, processor, rig, rms};
use rhytid_capture::{HandleSettings, place_handles};
use rhytid_core::{Face, Handles, NoProgress, Settings as SolveSettings, UpAxis};
use rhytid_formats::export::OutputStage;
use rhytid_formats::{mesh, raw_take};
use rhytid_geometry::triangulate;
use rhytid_test_support::shared;
use rhytid_transfer::{Missing, Settings, transfer};
use std::path::Path;

fn makehuman(shared: &Path) -> Face {
    let mut face = Face {
        name: "makehuman".into(),
        neutral: mesh::read(&shared.join("data/makehuman/neutral.obj")).unwrap(),
        metres_per_unit: 0.1,
        up_axis: UpAxis::Y,
        handles: Handles::default(),
        examples: Vec::new(),
        prior: None,
        settings: SolveSettings::default(),
    };
    let raw = raw_take::read(&shared.join("data/takes/rom_3_raw.c3d"), None).unwrap();
    face.handles = place_handles(&face, &raw, &HandleSettings::default(), &NoProgress).unwrap().handles;
    face
}

/// The part of the edges whose ends move apart by more than twice their length in any of the expressions.
fn torn(face: &Face, expressions: &[Vec<[f64; 3]>]) -> f64 {
    let rest = &face.neutral.positions;
    let length = |v: [f64; 3]| rms(std::iter::once(v))[0];
    let edges = triangulate(&face.neutral).into_iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
    let (mut all, mut torn) = (0, 0);
    for [v, w] in edges.map(|edge| edge.map(|v| v as usize)) {
        let edge = length(minus(&rest[v], &rest[w]));
        let apart = |x: &Vec<[f64; 3]>| length(minus(&minus(&x[v], &rest[v]), &minus(&x[w], &rest[w])));
        all += 1;
        torn += usize::from(expressions.iter().any(|x| apart(x) > 2.0 * edge));
    }
    torn as f64 / f64::from(all)
}

#[test]
fn a_head_on_another_head() {
    let Some(shared) = shared("") else { return };
    let from = rig(&face(&shared, "head"));
    let second = makehuman(&shared);
    let full = played(&from, from.examples().handles.as_slice().as_flattened(), OutputStage::Full);
    for linear_band in [false, true] {
        let settings = Settings { linear_band, landmarks: None };
        let made = transfer(&from, &second, &settings, &processor(), &NoProgress).unwrap();
        let found = &made.report;
        println!("{} {:?} {:?} {:?}", found.covered, found.bare, found.distance_mm, found.stretch);
        assert!(found.turned_over == 0 && found.landmarks.len() > 80 && !found.same_topology, "{found:?}");
        assert!(
            found.covered > 0.9 && found.distance_mm.median < 1.0 && found.distance_mm.p95 < 3.0,
            "{found:?}"
        );
        assert!((0.85..1.0).contains(&found.scale), "{found:?}");
        // Its eyes are parts of their own: 72 vertices each.
        assert!(
            found.bare.iter().any(|bare| bare.why == Missing::OtherPart && bare.vertices == 144),
            "{found:?}"
        );
        let rest_of_second = &second.neutral.positions;
        let made_positions: Vec<_> = made.face.examples.iter().map(|e| e.positions.clone()).collect();
        for (example, full) in made.face.examples.iter().zip(&full) {
            let moved = |rest: &[[f64; 3]], x: &[[f64; 3]]| rms(x.iter().zip(rest).map(|(x, y)| minus(x, y)));
            let rest: Vec<[f64; 3]> = from.surface().rest.iter().map(|x| x.map(f64::from)).collect();
            // In millimetres, with the teeth.
            let [_, first] = moved(&rest, full).map(|x| 10.0 * x);
            let [_, second] = moved(rest_of_second, &example.positions).map(|x| 100.0 * x);
            assert!(second < 1.2 * found.scale * first, "{}: {second:.1} mm of {first:.1}", example.name);
            // The back of the head stays.
            let behind = (0..rest_of_second.len()).filter(|&v| rest_of_second[v][2] < -0.5);
            for v in behind {
                let far = minus(&example.positions[v], &rest_of_second[v]);
                assert!(far.iter().all(|x| x.abs() < 1e-3), "{}: vertex {v} moves by {far:?}", example.name);
            }
        }
        // MakeHuman's own expressions tear 2 % of the edges, at lids and lips.
        let torn = torn(&made.face, &made_positions);
        println!("{:.2} % of the edges are torn", 100.0 * torn);
        assert!(torn < 0.015, "{torn}");
        // Markers are met.
        let to = rig(&made.face);
        let full = played(&to, to.examples().handles.as_slice().as_flattened(), OutputStage::Full);
        for (full, handles) in full.iter().zip(to.examples().handles.rows()) {
            for (point, x) in to.handles().points.iter().zip(handles) {
                let far = minus(&point.at(full), &x.map(f64::from));
                assert!(far.iter().all(|x| x.abs() < 1e-5), "{point}: {far:?}");
            }
        }
    }
}

/// Handles of the capture's face and of the made one that are at the same place.
const PAIRS: [(&str, &str); 23] = [
    ("mp17", "brow_R4"),
    ("mp18", "brow_R3"),
    ("mp20", "brow_R2"),
    ("mp21", "brow_R1"),
    ("mp22", "brow_L1"),
    ("mp23", "brow_L2"),
    ("mp25", "brow_L3"),
    ("mp26", "brow_L4"),
    ("mp27", "nasion"),
    ("mp29", "nose_bridge"),
    ("mp30", "nose_tip"),
    ("mp33", "subnasale"),
    ("mp32", "nostril_base_R"),
    ("mp34", "nostril_base_L"),
    ("mp48", "mouth_corner_R"),
    ("mp54", "mouth_corner_L"),
    ("mp51", "lip_up"),
    ("mp57", "lip_low"),
    ("mp50", "lip_up_R1"),
    ("mp52", "lip_up_L1"),
    ("mp56", "lip_low_L1"),
    ("mp58", "lip_low_R1"),
    ("jaw08", "chin"),
];

#[test]
fn a_real_face_on_a_made_one_by_a_table_of_landmarks() {
    let Some(shared) = shared("") else { return };
    let from = rig(&face(&shared, "face"));
    let mut second = rhytid_demo::face(8_000);
    second.examples.clear();
    let landmarks = Some(PAIRS.map(|(a, b)| (a.to_owned(), b.to_owned())).to_vec());
    let settings = Settings { linear_band: false, landmarks };
    let made = transfer(&from, &second, &settings, &processor(), &NoProgress).unwrap();
    let found = &made.report;
    println!("{} {:?} {:?} {:?}", found.covered, found.bare, found.distance_mm, found.stretch);
    assert!(found.turned_over < 20 && found.landmarks.len() == PAIRS.len(), "{found:?}");
    assert!(
        found.covered > 0.95 && found.distance_mm.median < 0.5 && found.distance_mm.p95 < 2.5,
        "{found:?}"
    );
    let made_positions: Vec<_> = made.face.examples.iter().map(|e| e.positions.clone()).collect();
    let torn = torn(&second, &made_positions);
    println!("{:.2} % of the edges are torn", 100.0 * torn);
    assert!(torn < 0.005, "{torn}");
}
