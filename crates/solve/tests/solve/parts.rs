//! Parts without a handle learn from the examples how much they move with the skin, and with what else.
use rhytid_core::{Bind, Example, Face, LearnedSettings, Method, NoProgress, Rig, VertexId};
use rhytid_solve::{FreeMotion, FreePart, Solved, solve, solve_in_full};
use rhytid_test_support::sheet::{add_sheet, face};

const SKIN: usize = 12 * 6;
const PART: usize = 5 * 4;
const HANDLES: [u32; 6] = [0, 5, 11, 60, 65, 71];

/// A sheet with six handles, and a smaller one behind its left half. It has no examples yet.
fn sheets() -> Face {
    let mut face = Face { neutral: <_>::default(), examples: Vec::new(), ..face() };
    add_sheet(&mut face.neutral, 12, 6, [0.0; 3]);
    add_sheet(&mut face.neutral, 5, 4, [0.5, 3.0, -2.0]);
    face.handles.points = HANDLES.map(|v| VertexId(v).into()).to_vec();
    face.handles.labels = (0..HANDLES.len()).map(|h| format!("h{h}")).collect();
    // Without a share of single axes, all that is linear is in the basis.
    let settings = LearnedSettings { share: Some(0.0), ..LearnedSettings::default() };
    face.settings.method = Method::Learned(settings);
    face.settings.pins.auto = Some(false);
    face
}

/// Displacements of the handles in an example, without a pattern.
fn displacements(p: usize) -> [[f64; 3]; 6] {
    let number = |i: usize| ((i as f64 * 12.9898).sin() * 43758.5453).fract();
    std::array::from_fn(|h| std::array::from_fn(|c| 3.0 * number(1 + 100 * p + 10 * h + c)))
}

fn moved(rig: &Rig<f64>, v: usize, u: &[[f64; 3]; 6]) -> [f64; 3] {
    [0, 1, 2].map(|c| rig.basis().row(v).iter().zip(u).map(|(b, u)| b * u[c]).sum())
}

/// Examples whose skin moves as the shell. `part` says how vertex i of the small sheet moves, given its
/// motion with the skin and the displacements of the handles.
fn examples(
    count: usize,
    part: impl Fn(usize, [f64; 3], &[[f64; 3]; 6]) -> [f64; 3],
) -> (Rig<f64>, Vec<Example>) {
    let mut nearest = sheets();
    nearest.settings.bind = Bind::Nearest;
    let rig = solve(&nearest, &NoProgress).unwrap();
    let example = |p: usize| {
        let u = displacements(p);
        let mut positions = nearest.neutral.positions.clone();
        for (v, x) in positions.iter_mut().enumerate() {
            let with_skin = moved(&rig, v, &u);
            let by = if v < SKIN { with_skin } else { part(v - SKIN, with_skin, &u) };
            x.iter_mut().zip(by).for_each(|(x, by)| *x += by);
        }
        Example { name: format!("p{p}"), positions, mirror: false, noise: Some(0.0) }
    };
    let examples = (0..count).map(example).collect();
    (rig, examples)
}

#[test]
fn a_part_of_the_skins_motion_is_found() {
    let skin = |i: usize| i as f64 / (PART - 1) as f64;
    let (nearest, examples) = examples(5, |i, with_skin, _| with_skin.map(|x| skin(i) * x));
    let Solved { rig, report, .. } =
        solve_in_full(&Face { examples, ..sheets() }, false, &NoProgress).unwrap();
    let &[FreePart { first_vertex, vertices, motion: FreeMotion::Blend { skin: mean } }] = &*report.parts
    else {
        panic!("{:?}", report.parts)
    };
    assert_eq!((first_vertex.index(), vertices), (SKIN, PART));
    assert!((mean - 0.5).abs() < 0.02, "{mean}");
    for i in 0..PART {
        let (of_skin, found) = (nearest.basis().row(SKIN + i), rig.basis().row(SKIN + i));
        for (b, found) in of_skin.iter().zip(found) {
            assert!((skin(i) * b - found).abs() < 0.02, "vertex {i}: {} and {found}", skin(i) * b);
        }
    }
}

#[test]
fn what_moves_with_other_handles_than_the_closest_does_not_hang_on_the_skin() {
    // As the gums: rows of the sheet move with handle 2 more and more, and the skin nearby does not.
    let jaw = |i: usize, _: [f64; 3], u: &[[f64; 3]; 6]| u[2].map(|x| (i / 5) as f64 / 3.0 * x);
    let (_, all) = examples(12, jaw);
    let error = |bind: Bind| {
        let mut square = 0.0;
        for p in 0..all.len() {
            let mut face = Face { examples: all.clone(), ..sheets() };
            face.settings.bind = bind;
            let left_out = face.examples.remove(p);
            let rig = solve(&face, &NoProgress).unwrap();
            for v in SKIN..SKIN + PART {
                let (rest, found) = (face.neutral.positions[v], moved(&rig, v, &displacements(p)));
                square +=
                    (0..3).map(|c| (left_out.positions[v][c] - rest[c] - found[c]).powi(2)).sum::<f64>();
            }
        }
        square.sqrt()
    };
    let (learned, nearest) = (error(Bind::Auto), error(Bind::Nearest));
    assert!(learned < 0.5 * nearest, "{learned} and {nearest}");
}

#[test]
fn one_example_says_how_much_of_the_skin_it_is_and_none_says_nothing() {
    for skin in [0.0, 0.4, 1.0] {
        let part = |i: usize, with_skin: [f64; 3], _: &[[f64; 3]; 6]| {
            // Not rigid.
            let bend = if i == 0 { 1.5 } else { 1.0 };
            with_skin.map(|x| bend * skin * x + if i == 1 { 1.5 } else { 0.0 })
        };
        let (_, examples) = examples(1, part);
        let report = solve_in_full(&Face { examples, ..sheets() }, false, &NoProgress).unwrap().report;
        let found = match report.parts[0].motion {
            FreeMotion::Blend { skin } => skin,
            FreeMotion::Skin => 1.0,
            other => panic!("{other:?}"),
        };
        assert!((found - skin).abs() < 0.06, "{found}, not {skin}");
        assert_eq!(skin == 1.0, report.parts[0].motion == FreeMotion::Skin);
    }
    let report = solve_in_full(&sheets(), false, &NoProgress).unwrap().report;
    assert_eq!(report.parts[0].motion, FreeMotion::Solid);
    for (bind, motion) in [(Bind::Nearest, FreeMotion::Skin), (Bind::Rigid, FreeMotion::Still)] {
        let mut face = sheets();
        face.settings.bind = bind;
        assert_eq!(solve_in_full(&face, false, &NoProgress).unwrap().report.parts[0].motion, motion);
    }
}
