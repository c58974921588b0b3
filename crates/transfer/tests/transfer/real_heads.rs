//! A whole head on another one that shares nothing with it: other vertices, another unit, handles that were found by a capture's markers.
use crate::support::{face, minus, played, processor, rig, rms};
use rhytid_capture::{HandleSettings, place_handles};
use rhytid_core::{Face, Handles, NoProgress, Settings as SolveSettings, UpAxis};
use rhytid_formats::export::OutputStage;
use rhytid_formats::{mesh, raw_take};
use rhytid_solve::triangulate;
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
        settings: SolveSettings::default(),
    };
    let raw = raw_take::read(&shared.join("data/takes/rom_3_raw.c3d"), None).unwrap();
    face.handles = place_handles(&face, &raw, &HandleSettings::default()).unwrap().handles;
    face
}

/// The part of the edges whose ends come apart by more than twice their length in any of some expressions.
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
    let full = played(&from, from.example_handles.as_flattened(), OutputStage::Full);
    for smooth_band in [false, true] {
        let settings = Settings { smooth_band, landmarks: None };
        let made = transfer(&from, &second, &settings, &processor(), &NoProgress).unwrap();
        let found = &made.account;
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
            let rest: Vec<[f64; 3]> = from.rest.iter().map(|x| x.map(f64::from)).collect();
            // In millimetres, teeth and all.
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
        let full = played(&to, to.example_handles.as_flattened(), OutputStage::Full);
        for (full, handles) in full.iter().zip(to.example_handles.chunks(to.handles.len())) {
            for (&v, x) in to.handles.iter().zip(handles) {
                let far = minus(&full[v as usize], &x.map(f64::from));
                assert!(far.iter().all(|x| x.abs() < 1e-5), "vertex {v}: {far:?}");
            }
        }
    }
}
