//! Keeps lids on their eyeballs.

use rhytid_core::{LidVertex, Rig};
use rhytid_kernels::vec3;

/// The lids of a rig that has any (`docs/method.md`, keep lids on their eyeballs).
///
/// A vertex that is nearer to the centre of its eyeball than [`LidVertex::nearest`] moves straight away from
/// the centre, and one beyond [`LidVertex::farthest`] moves towards it. A step grows from 0 as a vertex
/// passes its limit, so a take's frames stay continuous. A lash moves with its lid. Handles do not move.
pub(super) struct EyeContact<'a> {
    rig: &'a Rig,
}

impl<'a> EyeContact<'a> {
    /// `None` for a rig without eyeballs.
    pub(super) fn new(rig: &'a Rig) -> Option<Self> {
        let has_eyes = !rig.learned()?.contact.eyeballs.is_empty();
        has_eyes.then_some(Self { rig })
    }

    fn lids(&self) -> &[LidVertex] {
        self.rig.learned().map_or(&[], |learned| &learned.contact.lids)
    }

    /// Moves a frame's V positions, and marks the vertices that it moves in `moved`, V.
    pub(super) fn frame(&self, positions: &mut [[f32; 3]], moved: &mut [bool]) {
        let Some(learned) = self.rig.learned() else { return };
        let centers: Vec<[f64; 3]> =
            learned.contact.eyeballs.iter().map(|eyeball| eyeball.center(positions)).collect();
        let step = |lid: &LidVertex| {
            let at = positions[lid.vertex.index()].map(f64::from);
            let from_center = vec3::sub(at, centers[lid.eyeball as usize]);
            let distance = vec3::length(from_center);
            let [nearest, farthest] = [lid.nearest, lid.farthest].map(f64::from);
            if (nearest..=farthest).contains(&distance) || distance == 0.0 {
                return [0.0; 3];
            }
            from_center.map(|x| x * (distance.clamp(nearest, farthest) / distance - 1.0))
        };
        let steps: Vec<[f64; 3]> = self.lids().iter().map(step).collect();
        for lid in self.lids() {
            let step = steps[lid.leader as usize];
            if step != [0.0; 3] {
                let x = &mut positions[lid.vertex.index()];
                *x = [0, 1, 2].map(|c| (f64::from(x[c]) + step[c]) as f32);
                moved[lid.vertex.index()] = true;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Playback;
    use crate::contact::test_rig::{assert_normals, assert_scans_stay, contact, largest_step, rig};
    use rhytid_conformance::evaluate;
    use rhytid_core::NoProgress;
    use rhytid_devices::{Guard, choose_devices};
    use rhytid_formats::export::OutputStage;
    use rhytid_test_support::eye::{self, EYEBALL, LASH};

    /// The handles at rest, with the middle one moved by `by` away from the eyeball.
    fn handles(rig: &Rig, by: f32) -> Vec<[f32; 3]> {
        let mut handles = rig.handles().rest.clone();
        handles[4][2] += by;
        handles
    }

    fn distances(rig: &Rig, positions: &[[f32; 3]]) -> Vec<f64> {
        let contact = &rig.learned().unwrap().contact;
        let center = contact.eyeballs[0].center(positions);
        let at = |lid: &LidVertex| positions[lid.vertex.index()].map(f64::from);
        contact.lids.iter().map(|lid| vec3::length(vec3::sub(at(lid), center))).collect()
    }

    #[test]
    fn lids_stay_on_their_eyeball() {
        let rig = rig(&eye::face());
        let lids = &rig.learned().unwrap().contact.lids;
        let skin = || lids.iter().enumerate().filter(|(i, lid)| lid.leader as usize == *i);
        let contact = contact(&rig);
        for by in [-0.6, 2.5] {
            let results = evaluate(&rig, &handles(&rig, by));
            let (before, mut after) = (results.positions, Vec::new());
            after.clone_from(&before);
            let mut normals = results.normals;
            contact.frame(&mut after, &mut normals);
            let [was, is] = [&before, &after].map(|positions| distances(&rig, positions));
            let off = |distances: &[f64]| {
                let off = skin().map(|(i, lid)| {
                    let [nearest, farthest] = [lid.nearest, lid.farthest].map(f64::from);
                    (nearest - distances[i]).max(distances[i] - farthest)
                });
                off.fold(0.0, f64::max)
            };
            assert!(off(&was) > 0.1 && off(&is) < 1e-6, "{by}: {} to {}", off(&was), off(&is));
            for (i, lid) in skin() {
                // It goes straight away from the centre or towards it.
                let [x, y] = [&before, &after].map(|at| at[lid.vertex.index()].map(f64::from));
                let turned = vec3::length(vec3::cross(x, y)) / (was[i] * is[i]);
                assert!(turned < 1e-5, "{lid:?}: {turned}");
            }
            for v in (0..rig.vertices()).filter(|v| lids.iter().all(|lid| lid.vertex.index() != *v)) {
                assert_eq!(before[v], after[v], "vertex {v} is no lid");
            }
            // Lashes move with their lids.
            for lid in lids.iter().filter(|lid| LASH.contains(&lid.vertex.index())) {
                let step = |v: usize| vec3::sub(after[v].map(f64::from), before[v].map(f64::from));
                let leader = lids[lid.leader as usize].vertex;
                let apart = vec3::length(vec3::sub(step(lid.vertex.index()), step(leader.index())));
                assert!(apart < 1e-6, "{lid:?}");
            }
            assert_normals(&rig, &after, &normals);
        }
    }

    #[test]
    fn what_the_scans_show_stays_bit_for_bit() {
        assert_scans_stay(&rig(&eye::face()));
    }

    #[test]
    fn frames_are_continuous_and_a_playback_has_the_contact() {
        let rig = rig(&eye::face());
        let contact = contact(&rig);
        let frames: Vec<[f32; 3]> = (0..100).flat_map(|i| handles(&rig, -0.006 * i as f32)).collect();
        let devices = choose_devices("cpu:0", Guard::NONE, &NoProgress).unwrap().devices;
        let mut playback = Playback::new(&rig, &devices, 100).unwrap();
        let mut last: Option<[Vec<[f32; 3]>; 2]> = None;
        let mut number = 0;
        let each = |positions: &[f32], _: &[f32]| {
            let found: Vec<[f32; 3]> = positions.as_chunks().0.to_vec();
            let count = rig.handles().len();
            let before = evaluate(&rig, &frames[number * count..][..count]).positions;
            let mut expected = before.clone();
            contact.frame(&mut expected, &mut []);
            assert!(largest_step(&found, &expected) < 1e-5, "frame {number}");
            if let Some([last_before, last]) = &last {
                assert!(
                    largest_step(&found, last) < 2.0 * largest_step(&before, last_before) + 1e-5,
                    "frame {number}"
                );
            }
            last = Some([before, found]);
            number += 1;
            Ok(())
        };
        playback.evaluate(frames.as_flattened(), OutputStage::Full, false, &NoProgress, each).unwrap();
        assert_eq!(number, 100);
        let [before, after] = last.unwrap();
        assert_ne!(before, after, "the last frame presses lids into the eyeball");
        assert!(EYEBALL.chain(0..1).all(|v| before[v] == after[v]));
    }
}
