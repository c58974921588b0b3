//! The properties of the method, on random faces with holes, boundaries, obtuse triangles and several
//! components.

use crate::support::random_face::{faces, faces_for_both_methods};
use crate::support::told_apart;
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use rhytid_conformance::{Numbers, evaluate, worst_difference};
use rhytid_core::{Bind, Example, Face, NoProgress, Rig, VertexId};
use rhytid_solve::solve;

fn solved(face: &Face) -> Rig<f64> {
    solve(face, &NoProgress).unwrap()
}

fn at_handles(face: &Face, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    face.handles.points.iter().map(|point| point.at(positions)).collect()
}

/// Handle positions at some distance from rest.
fn some_pose(face: &Face, seed: u64) -> Vec<[f64; 3]> {
    let mut numbers = Numbers::new(seed);
    at_handles(face, &face.neutral.positions)
        .into_iter()
        .map(|p| p.map(|c| c + 0.4 * numbers.signed()))
        .collect()
}

/// The diagonal of the neutral's bounding box, to which errors are related.
fn size(face: &Face) -> f64 {
    let [low, high] = face.neutral.bounds().unwrap().map(DVec3::from_array);
    high.distance(low)
}

fn worst(found: &[[f64; 3]], expected: &[[f64; 3]]) -> f64 {
    worst_difference(found.as_flattened(), expected.as_flattened()).size
}

fn driven(rig: &Rig<f64>, v: usize) -> bool {
    rig.basis().row(v).iter().any(|&b| b != 0.0)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn rows_at_handles_are_the_identity_and_driven_rows_sum_to_one(face in faces()) {
        let rig = solved(&face);
        for (i, point) in rig.handles().points.iter().enumerate() {
            for j in 0..rig.handles().len() {
                let expected = if i == j { 1.0 } else { 0.0 };
                let found: f64 = point.corners().map(|(v, weight)| weight * rig.basis().row(v.index())[j]).sum();
                match point.vertex() {
                    Some(_) => prop_assert_eq!(found, expected),
                    None => prop_assert!((found - expected).abs() < 1e-10, "{found} instead of {expected}"),
                }
            }
        }
        let mut seen = 0;
        for v in 0..rig.vertices() {
            let sum: f64 = rig.basis().row(v).iter().sum();
            if driven(&rig, v) {
                seen += 1;
                prop_assert!((sum - 1.0).abs() < 1e-9, "row {v} sums to {sum}");
            }
        }
        // Everything except the sheet of 16 without handles and the isolated vertex.
        prop_assert_eq!(seen, rig.vertices() - 17);
    }

    #[test]
    fn markers_are_met_exactly_by_both_stages(face in faces_for_both_methods(), seed: u64) {
        let rig = solved(&face);
        let pose = some_pose(&face, seed);
        let results = evaluate(&rig, &pose);
        let all_at_vertices = face.handles.points.iter().all(|point| point.vertex().is_some());
        let [of_shell, of_all] = if all_at_vertices { [1e-13, 1e-12] } else { [1e-11, 1e-11] };
        prop_assert!(worst(&at_handles(&face, &results.large_scale), &pose) < of_shell * size(&face));
        prop_assert!(worst(&at_handles(&face, &results.positions), &pose) < of_all * size(&face));
    }

    #[test]
    fn an_examples_own_handles_give_it_back(face in faces()) {
        let rig = solved(&face);
        for example in &face.examples {
            let results = evaluate(&rig, &at_handles(&face, &example.positions));
            let mut seen = 0;
            // The chapter's method learns nothing at the corners of a handle's triangle.
            let is_corner = |v: usize| {
                let mut inside = rig.handles().points.iter().filter(|point| point.vertex().is_none());
                inside.any(|point| point.has(VertexId::from_index(v)))
            };
            let is_told = |v: usize| driven(&rig, v) && told_apart(&rig, v, 1e-3);
            for v in (0..rig.vertices()).filter(|&v| is_told(v) && !is_corner(v)) {
                seen += 1;
                let error = worst(&[results.positions[v]], &[example.positions[v]]);
                prop_assert!(error < 1e-8 * size(&face), "{} is off by {error} at {v}", example.name);
            }
            prop_assert!(seen > rig.vertices() / 3, "only {seen} vertices tell the poses apart");
        }
    }

    #[test]
    fn rest_handles_give_the_rest_pose(face in faces_for_both_methods()) {
        let rig = solved(&face);
        let results = evaluate(&rig, &at_handles(&face, &rig.surface().rest));
        prop_assert!(worst(&results.large_scale, &rig.surface().rest) < 1e-10 * size(&face));
        prop_assert!(worst(&results.positions, &rig.surface().rest) < 1e-10 * size(&face));
    }

    #[test]
    fn what_has_no_handle_does_not_move(face in faces(), seed: u64) {
        let rig = solved(&face);
        let results = evaluate(&rig, &some_pose(&face, seed));
        let last = rig.vertices() - 17;
        prop_assert_eq!(&results.positions[last..], &rig.surface().rest[last..]);
    }

    #[test]
    fn what_is_bound_follows_the_driven_surface(mut face in faces()) {
        face.settings.bind = Bind::Nearest;
        let rig = solved(&face);
        let shift = [0.3, -0.2, 0.1];
        let moved: Vec<[f64; 3]> =
            at_handles(&face, &rig.surface().rest).iter().map(|p| std::array::from_fn(|c| p[c] + shift[c])).collect();
        let expected: Vec<[f64; 3]> = rig.surface().rest.iter().map(|p| std::array::from_fn(|c| p[c] + shift[c])).collect();
        prop_assert!(worst(&evaluate(&rig, &moved).large_scale, &expected) < 1e-8);
    }

    #[test]
    fn scaling_the_input_scales_the_output(face in faces_for_both_methods(), seed: u64, exponent in -3.0f64..3.0) {
        let s = 10f64.powf(exponent);
        let scale = |ps: &[[f64; 3]]| -> Vec<[f64; 3]> { ps.iter().map(|p| p.map(|c| s * c)).collect() };
        let mut scaled = face.clone();
        scaled.neutral.positions = scale(&face.neutral.positions);
        for example in &mut scaled.examples {
            example.positions = scale(&example.positions);
        }
        let pose = some_pose(&face, seed);
        let expected = evaluate(&solved(&face), &pose);
        let found = evaluate(&solved(&scaled), &scale(&pose));
        let tolerance = 1e-7 * s * size(&face);
        prop_assert!(worst(&found.large_scale, &scale(&expected.large_scale)) < tolerance);
        prop_assert!(worst(&found.positions, &scale(&expected.positions)) < tolerance);
    }

    #[test]
    fn renumbering_the_vertices_renumbers_the_output(face in faces_for_both_methods(), seed: u64) {
        let vertices = face.neutral.positions.len();
        let mut numbers = Numbers::new(seed);
        // to[v] is the new number of vertex v.
        let mut to: Vec<usize> = (0..vertices).collect();
        for v in (1..vertices).rev() {
            to.swap(v, numbers.below(v + 1));
        }
        let renumber = |ps: &[[f64; 3]]| -> Vec<[f64; 3]> {
            let mut out = vec![[0.0; 3]; vertices];
            ps.iter().zip(&to).for_each(|(p, &v)| out[v] = *p);
            out
        };
        let mut other = face.clone();
        other.neutral.positions = renumber(&face.neutral.positions);
        other.neutral.faces.indices.iter_mut().for_each(|v| *v = to[*v as usize] as u32);
        let number = |v: VertexId| VertexId::from_index(to[v.index()]);
        other.handles.points.iter_mut().for_each(|point| *point = point.renamed(number));
        other.examples.iter_mut().for_each(|e: &mut Example| e.positions = renumber(&e.positions));
        let pose = some_pose(&face, seed);
        let expected = evaluate(&solved(&face), &pose);
        let found = evaluate(&solved(&other), &pose);
        let tolerance = 1e-7 * size(&face);
        prop_assert!(worst(&found.large_scale, &renumber(&expected.large_scale)) < tolerance);
        prop_assert!(worst(&found.positions, &renumber(&expected.positions)) < tolerance);
        prop_assert!(worst(&found.normals, &renumber(&expected.normals)) < 1e-5);
    }

    #[test]
    fn a_rigid_motion_taken_out_and_put_back_changes_nothing(face in faces_for_both_methods(), seed: u64) {
        let mut numbers = Numbers::new(seed);
        let axis = DVec3::new(numbers.signed(), numbers.signed(), 1.0 + numbers.unit()).normalize();
        let rotation = DQuat::from_axis_angle(axis, 3.0 * numbers.signed());
        let shift = 10.0 * DVec3::new(numbers.signed(), numbers.signed(), numbers.signed());
        let rig = solved(&face);
        let pose = some_pose(&face, seed);
        let expected = evaluate(&rig, &pose);
        let seen = pose.iter().map(|p| rotation * DVec3::from_array(*p) + shift);
        let taken_out: Vec<[f64; 3]> = seen.map(|p| (rotation.inverse() * (p - shift)).to_array()).collect();
        let put_back = |ps: &[[f64; 3]]| -> Vec<[f64; 3]> {
            ps.iter().map(|p| (rotation * DVec3::from_array(*p) + shift).to_array()).collect()
        };
        let found = put_back(&evaluate(&rig, &taken_out).positions);
        prop_assert!(worst(&found, &put_back(&expected.positions)) < 1e-8 * size(&face));
    }
}
