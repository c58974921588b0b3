//! Pins stay for all movements of the handles. Vertices that no example moves are pinned where the examples
//! show that they stay.
use rhytid_core::{Example, Face, Method, NoProgress, Pins, Rig, Settings, VertexId};
use rhytid_solve::{Solved, solve_in_full};
use rhytid_test_support::sheet::{add_sheet, face};

/// A sheet of 24 × 6 vertices. An example moves the handles at its left; the rest stays.
fn wide() -> Face {
    let mut face = Face { neutral: <_>::default(), ..face() };
    add_sheet(&mut face.neutral, 24, 6, [0.0; 3]);
    face.handles.points = [0, 3, 49, 120, 123].map(|v| VertexId(v).into()).to_vec();
    let mut lifted = face.neutral.positions.clone();
    for (v, x) in lifted.iter_mut().enumerate() {
        x[2] += 2.0 * (1.0 - (v % 24) as f64 / 5.0).max(0.0);
    }
    face.examples = vec![Example { name: "lift".into(), positions: lifted, mirror: false, noise: None }];
    face
}

fn solved(face: &Face) -> Solved {
    solve_in_full(face, false, &NoProgress).unwrap()
}

/// The vertices that no handle moves.
fn still(rig: &Rig<f64>) -> Vec<usize> {
    (0..rig.vertices()).filter(|&v| rig.basis().row(v).iter().all(|b| *b == 0.0)).collect()
}

#[test]
fn what_no_example_moves_is_pinned_away_from_the_handles() {
    let face = wide();
    let Solved { rig, report, .. } = solved(&face);
    let still_now = still(&rig);
    assert_eq!(report.pins, still_now.len());
    // From the sixth column on nothing moves. Vertices within a strain edge's length of a handle are left to
    // the handles.
    assert!(still_now.len() > 60 && still_now.iter().all(|v| v % 24 >= 5), "{still_now:?}");
    assert!((0..6).all(|row| still_now.contains(&(24 * row + 23))), "{still_now:?}");
    // Without pins the far edge swings with the handles.
    let free = Face {
        settings: Settings { pins: Pins { auto: Some(false), ..<_>::default() }, ..<_>::default() },
        ..face.clone()
    };
    assert!(still(&solved(&free).rig).is_empty());
    let chapter = Face { settings: Settings { method: Method::Chapter, ..<_>::default() }, ..face.clone() };
    assert_eq!(
        solved(&chapter).report.pins,
        0,
        "by the chapter's method nothing is pinned unless it is asked for"
    );
    // An example in which a handle does not move says nothing about the surroundings of that handle.
    let mut other = face;
    other.examples[0].positions = other.neutral.positions.clone();
    other.examples[0].positions[3][2] += 3.0;
    let around = still(&solved(&other).rig);
    let upper = around.iter().all(|v| v / 24 < 4);
    assert!(!around.is_empty() && upper, "only the cell of the handle that moves: {around:?}");
}

#[test]
fn named_pins_stay_in_examples_too_and_handles_go_on() {
    let mut face = wide();
    face.settings.pins = Pins { auto: Some(false), vertices: [3, 40, 41, 42].map(VertexId).to_vec() };
    for method in [face.settings.method, Method::Chapter] {
        face.settings.method = method;
        let Solved { rig, report, .. } = solved(&face);
        assert_eq!((report.pins, still(&rig)), (3, vec![40, 41, 42]), "vertex 3 is a handle");
        // Nothing is learned there either.
        for v in [40, 41, 42] {
            let wrinkles = rig.fine_scale().rbf_weights.row(v);
            let band = rig.learned().into_iter().flat_map(|learned| learned.example_weights.row(v));
            let most = wrinkles.iter().chain(band).flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
            assert!(most < 1e-12, "{method:?}: vertex {v} learns {most}");
        }
        let learns = rig.fine_scale().rbf_weights.as_slice().iter().flatten().any(|x| x.abs() > 1e-6);
        assert!(learns, "what is beside the pins does");
    }
}
