//! Keeps lips and lids from going into each other.

use rhytid_core::openings::{BEHIND, smooth_step};
use rhytid_core::{Openings, Rig, RimVertex, VertexId};
use rhytid_kernels::normals::{VertexTriangles, vertex_normal};
use rhytid_kernels::vec3;
use std::sync::Arc;

/// How many times the skin on both sides of an opening moves by half of what is left.
const ROUNDS: usize = 4;

/// The openings of a rig that has any (`docs/method.md`, keep lips and lids from crossing).
///
/// A rim vertex whose gap is below [`RimVertex::least_gap`] goes half of the way back, and what is across
/// goes the other half. Steps grow from 0 as limits are passed, so a take's frames stay continuous. They fade
/// to 0 again where skin is a reach beyond its limit. Handles do not move.
pub(super) struct OpeningContact<'a> {
    openings: &'a Openings,
    rig: &'a Rig,
    vertex_triangles: Arc<VertexTriangles>,
    /// The vertices that move with each rim vertex, with their weights.
    followers: Vec<Vec<(VertexId, f64)>>,
}

impl<'a> OpeningContact<'a> {
    /// `None` for a rig without openings.
    pub(super) fn new(rig: &'a Rig, vertex_triangles: Arc<VertexTriangles>) -> Option<Self> {
        let openings = &rig.learned()?.contact.openings;
        let mut followers = vec![Vec::new(); openings.rims.len()];
        for follower in &openings.followers {
            for (leader, weight) in follower.leaders.iter().zip(follower.weights) {
                if weight != 0.0 {
                    followers[*leader as usize].push((follower.vertex, f64::from(weight)));
                }
            }
        }
        (!openings.rims.is_empty()).then_some(Self { openings, rig, vertex_triangles, followers })
    }

    /// Moves a frame's V positions, and marks the vertices that it moves in `moved`, V.
    pub(super) fn frame(&self, positions: &mut [[f32; 3]], moved: &mut [bool]) {
        let mut steps = Vec::new();
        for _ in 0..ROUNDS {
            steps = self.steps(positions, &steps);
            if steps.iter().all(|step| *step == [0.0; 3]) {
                break;
            }
            for (step, followers) in steps.iter().zip(&self.followers).filter(|(step, _)| **step != [0.0; 3])
            {
                for (vertex, weight) in followers {
                    let x = &mut positions[vertex.index()];
                    *x = [0, 1, 2].map(|c| (f64::from(x[c]) + weight * step[c]) as f32);
                    moved[vertex.index()] = true;
                }
            }
        }
    }

    /// Half of the way back of each rim vertex. Those whose step was 0 in the round before have none.
    fn steps(&self, positions: &[[f32; 3]], before: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let rims = &self.openings.rims;
        let triangles = &self.rig.surface().triangles;
        let at: Vec<[f64; 3]> = rims.iter().map(|rim| positions[rim.vertex.index()].map(f64::from)).collect();
        // Only vertices with others near them can be behind these.
        let is_near = |number: usize| {
            let farthest = f64::from(rims[number].reach).powi(2) * (1.0 + BEHIND * BEHIND);
            let is_near = |other: &u32| {
                let apart = vec3::sub(at[number], at[*other as usize]);
                vec3::dot(apart, apart) < farthest
            };
            rims[number].across.iter().any(|other| *other as usize != number && is_near(other))
        };
        let may_step = |number: &usize| before.get(*number) != Some(&[0.0; 3]) && is_near(*number);
        let near: Vec<usize> = (0..rims.len()).filter(may_step).collect();
        let mut normals = vec![[0.0; 3]; rims.len()];
        let mut has_normal = vec![false; rims.len()];
        let mut wants_normal = |other: usize| {
            if !std::mem::replace(&mut has_normal[other], true) {
                let incident = self.vertex_triangles.at(rims[other].vertex.index());
                normals[other] = vertex_normal(positions, triangles, incident).map(f64::from);
            }
        };
        for &number in &near {
            wants_normal(number);
            rims[number].across.iter().for_each(|other| wants_normal(*other as usize));
        }
        let mut steps = vec![[0.0; 3]; rims.len()];
        for number in near {
            let gap = self.openings.gap(number, &at, &normals);
            let RimVertex { reach, least_gap, .. } = rims[number];
            let missing = (f64::from(least_gap) - gap.width).max(0.0);
            // Markers that press skin so deep into skin mean it, or are wrong.
            let share = 1.0 - smooth_step(missing / f64::from(reach));
            steps[number] = gap.normal.map(|n| 0.5 * gap.certainty * share * missing * n);
        }
        steps
    }
}

#[cfg(test)]
mod tests {
    use crate::Playback;
    use crate::contact::test_rig::{assert_normals, assert_scans_stay, contact, largest_step, rig};
    use rhytid_conformance::evaluate;
    use rhytid_core::{NoProgress, Rig};
    use rhytid_devices::{Guard, choose_devices};
    use rhytid_formats::export::OutputStage;
    use rhytid_test_support::lips::{self, COLUMNS, UPPER, at, opposite};

    /// The handles at rest, with those of the lower lip moved up.
    fn handles(rig: &Rig, up: f32) -> Vec<[f32; 3]> {
        let mut handles = rig.handles().rest.clone();
        handles[5..].iter_mut().for_each(|x| x[1] += up);
        handles
    }

    /// How far the upper lip is above the lower one, where it is least.
    fn gap(positions: &[[f32; 3]]) -> f32 {
        let columns = UPPER.flat_map(|row| (0..COLUMNS).map(move |column| (row, column)));
        let gaps = columns
            .map(|(row, column)| positions[at(row, column)][1] - positions[at(opposite(row), column)][1]);
        gaps.fold(f32::INFINITY, f32::min)
    }

    #[test]
    fn lips_meet_and_do_not_cross() {
        let rig = rig(&lips::face());
        let contact = contact(&rig);
        for up in [0.08, 0.14] {
            let results = evaluate(&rig, &handles(&rig, up));
            let (before, mut normals) = (results.positions, results.normals);
            let mut after = before.clone();
            let moved = contact.frame(&mut after, &mut normals);
            let [was, is] = [&before, &after].map(|positions| gap(positions));
            assert!(was < -0.02 && is > 0.4 * was && is < 0.02, "{up}: {was} to {is}");
            // Both lips give way.
            let steps =
                [UPPER.start, opposite(UPPER.start)].map(|row| after[at(row, 5)][1] - before[at(row, 5)][1]);
            assert!(steps[0] > 0.005 && steps[1] < -0.005, "{steps:?}");
            for (v, moved) in moved.iter().enumerate() {
                assert!(*moved || before[v] == after[v], "vertex {v}");
            }
            for point in &rig.handles().points {
                assert!(point.corners().all(|(v, _)| !moved[v.index()]));
            }
            assert_normals(&rig, &after, &normals);
        }
    }

    #[test]
    fn what_the_scans_show_stays_bit_for_bit() {
        assert_scans_stay(&rig(&lips::face()));
    }

    #[test]
    fn frames_are_continuous_and_a_playback_has_the_contact() {
        let rig = rig(&lips::face());
        let contact = contact(&rig);
        let count = rig.handles().len();
        let frames: Vec<[f32; 3]> = (0..100).flat_map(|i| handles(&rig, 0.008 * i as f32)).collect();
        let devices = choose_devices("cpu:0", Guard::NONE, &NoProgress).unwrap().devices;
        let mut playback = Playback::new(&rig, &devices, 100).unwrap();
        let mut last: Option<[Vec<[f32; 3]>; 2]> = None;
        let (mut number, mut most) = (0, 0.0_f32);
        let each = |positions: &[f32], _: &[f32]| {
            let found: Vec<[f32; 3]> = positions.as_chunks().0.to_vec();
            let before = evaluate(&rig, &frames[number * count..][..count]).positions;
            let mut expected = before.clone();
            contact.frame(&mut expected, &mut []);
            assert!(largest_step(&found, &expected) < 1e-5, "frame {number}");
            if let Some([last_before, last]) = &last {
                let allowed = 5.0 * largest_step(&before, last_before) + 1e-5;
                assert!(largest_step(&found, last) < allowed, "frame {number}");
            }
            most = most.max(largest_step(&before, &found));
            last = Some([before, found]);
            number += 1;
            Ok(())
        };
        playback.evaluate(frames.as_flattened(), OutputStage::Full, false, &NoProgress, each).unwrap();
        assert_eq!(number, 100);
        assert!(most > 0.02, "{most}");
    }
}
