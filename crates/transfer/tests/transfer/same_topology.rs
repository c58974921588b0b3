//! With the same faces, no counterpart is searched: each vertex gets the movement of the same vertex of the
//! first face.
use crate::support::{bare, minus, played, processor, rig, rms, wrinkles};
use rhytid_core::{Face, Handles, NoProgress};
use rhytid_formats::export::OutputStage;
use rhytid_test_support::points::beside;
use rhytid_transfer::{Settings, Transferred, transfer};

#[test]
fn the_same_rest_gets_the_same_examples() {
    let first = rhytid_demo::face(3_000);
    gets_the_same_examples(&first);
    // With handles inside triangles too.
    let points = beside(&first.neutral, &first.handles.points, [0.5, 0.3, 0.2]);
    gets_the_same_examples(&Face { handles: Handles { points, ..first.handles.clone() }, ..first });
}

fn gets_the_same_examples(first: &Face) {
    let from = rig(first);
    let second = bare(first, first.neutral.clone(), first.handles.points.clone());
    let full = played(&from, from.examples().handles.as_slice().as_flattened(), OutputStage::Full);
    let settings = Settings { linear_band: true, landmarks: None };
    let Transferred { face, report, maps } =
        transfer(&from, &second, &settings, &processor(), &NoProgress).unwrap();
    assert!(report.same_topology && report.covered == 1.0 && report.warnings.is_empty(), "{report:?}");
    assert!(maps.distance_mm.iter().chain(&maps.stretch).all(|x| x.abs() < 1e-5));
    assert_eq!(report.examples, from.examples().names);
    for (made, full) in face.examples.iter().zip(&full) {
        let [_, worst] = rms(made.positions.iter().zip(full).map(|(x, y)| minus(x, y)));
        // The rounding of float32 for a head of 20 cm.
        assert!(worst < 1e-5, "{}: {worst}", made.name);
    }
}

#[test]
fn a_larger_one_that_is_turned_gets_them_larger_and_turned() {
    let first = rhytid_demo::face(3_000);
    let from = rig(&first);
    // Twice as large, x to y, y to −x, and moved: but the same mesh.
    let turn = |[x, y, z]: [f64; 3]| [-2.0 * y + 5.0, 2.0 * x, 2.0 * z - 1.0];
    let mut neutral = first.neutral.clone();
    neutral.positions.iter_mut().for_each(|p| *p = turn(*p));
    let mut second = bare(&first, neutral, first.handles.points.clone());
    second.metres_per_unit = 0.005;
    let full = played(&from, from.examples().handles.as_slice().as_flattened(), OutputStage::Full);
    let wrinkles = wrinkles(&from, &full);
    let of = |linear_band| {
        let settings = Settings { linear_band, landmarks: None };
        transfer(&from, &second, &settings, &processor(), &NoProgress).unwrap()
    };
    let (all, alone) = (of(true), of(false));
    assert!((all.report.scale - 1.0).abs() < 1e-6 && all.report.warnings.is_empty(), "{:?}", all.report);
    for (p, made) in all.face.examples.iter().enumerate() {
        let expected = full[p].iter().map(|x| turn(*x));
        let [_, worst] = rms(made.positions.iter().zip(expected).map(|(x, y)| minus(x, &y)));
        assert!(worst < 2e-5, "{}: {worst}", made.name);
    }
    // The wrinkles alone, on the first face's shell: its rig without learned detail.
    let shell = played(
        &from.clone().shell().unwrap(),
        from.examples().handles.as_slice().as_flattened(),
        OutputStage::Shell,
    );
    let mut whole = 0.0_f64;
    for (p, made) in alone.face.examples.iter().enumerate() {
        // The surfaces below the wrinkles differ by the wide part, so their rotations differ a little too.
        let expected = (0..shell[p].len()).map(|v| {
            let wrinkle = wrinkles[p][v];
            (turn([0, 1, 2].map(|c| shell[p][v][c] + wrinkle[c])), wrinkle)
        });
        let expected: Vec<_> = expected.collect();
        let [off, _] = rms(made.positions.iter().zip(&expected).map(|(x, (y, _))| minus(x, y)));
        let [size, _] = rms(expected.iter().map(|(_, wrinkle)| wrinkle.map(|x| 2.0 * x)));
        assert!(off < 0.25 * size + 1e-4, "{}: {off} of {size}", made.name);
        whole = whole.max(size);
    }
    assert!(whole > 0.01, "{whole}");
}
