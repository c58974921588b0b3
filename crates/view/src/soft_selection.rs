//! The soft selection: the markers that follow a dragged one.

use glam::Vec3;
use rhytid_core::Rig;
use rhytid_geometry::dijkstra::shortest_ways;
use rhytid_render::Sphere;

/// How handles follow dragged ones: along the strain edges, and mirrored.
#[derive(Debug, Clone, PartialEq)]
pub struct SoftSelection {
    /// For each handle, the handles that share a strain edge with it, and their distances at rest.
    neighbours: Vec<Vec<(usize, f32)>>,
    /// For each handle, the handle at its mirror image. A handle in the middle has itself. `None` where there
    /// is none.
    mirrored: Vec<Option<usize>>,
}

/// A drag of handles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drag<'a> {
    /// The dragged handles.
    pub grabbed: &'a [usize],
    /// The offset, in mesh units.
    pub by: [f32; 3],
    /// The reach of the soft selection along strain edges, in mesh units. The weight is 0.56 at half of the
    /// reach, and 0 beyond the reach. With 0 no other handle follows.
    pub reach: f32,
    /// Whether the other side of the face moves too, mirrored.
    pub mirrored: bool,
    /// H: the handles that stay where they are.
    pub pinned: &'a [bool],
}

impl SoftSelection {
    /// For the handles of `rig`. A face is mirrored at a plane x = c. Candidates are x = 0 and the middle of
    /// the handles: the one that fits the handles better is chosen.
    pub fn new(rig: &Rig) -> Self {
        let rest = &rig.handles().rest;
        let mut neighbours = vec![Vec::new(); rest.len()];
        for &[a, b] in &rig.handles().strain_edges {
            let (a, b) = (a.index(), b.index());
            let length = Vec3::from(rest[a]).distance(rest[b].into());
            neighbours[a].push((b, length));
            neighbours[b].push((a, length));
        }
        let mirrored = mirrored(rest, &neighbours);
        Self { neighbours, mirrored }
    }

    /// The handle at the mirror image of `handle`.
    pub fn mirror_of(&self, handle: usize) -> Option<usize> {
        self.mirrored[handle]
    }

    /// The handles at the mirror images of these.
    pub fn mirror_of_all(&self, handles: &[usize]) -> Vec<usize> {
        handles.iter().filter_map(|&handle| self.mirrored[handle]).collect()
    }

    /// H vectors: the move of each handle, in mesh units. Grabbed handles make the whole move.
    pub fn drag(&self, drag: Drag<'_>) -> Vec<[f32; 3]> {
        let mut weights = self.weights(drag.grabbed, drag.reach);
        let mut others = vec![0.0; weights.len()];
        if drag.mirrored {
            others = self.weights(&self.mirror_of_all(drag.grabbed), drag.reach);
        }
        for (handle, &pinned) in drag.pinned.iter().enumerate() {
            // A grabbed handle moves even if it is pinned.
            if pinned && !drag.grabbed.contains(&handle) {
                (weights[handle], others[handle]) = (0.0, 0.0);
            }
        }
        let [x, y, z] = drag.by;
        let moved = |(w, m): (f32, f32)| {
            // In the middle both sides meet. Their weights together are at most 1.
            let sum = (w + m).max(1.0);
            [x * (w - m) / sum, y * (w + m) / sum, z * (w + m) / sum]
        };
        weights.into_iter().zip(others).map(moved).collect()
    }

    /// H weights from 0 to 1: (1 − d²/r²)² at the distance d along strain edges.
    fn weights(&self, from: &[usize], reach: f32) -> Vec<f32> {
        let mut distances = vec![0.0; self.neighbours.len()];
        let edges = |handle: u32| {
            self.neighbours[handle as usize].iter().map(|&(next, length)| (next as u32, f64::from(length)))
        };
        let sources = from.iter().map(|&handle| (handle as u32, 0.0));
        shortest_ways(sources, edges, |_| f64::from(reach), &mut distances);
        let weight = |d: f32| match d {
            0.0 => 1.0,
            d if d < reach => (1.0 - (d / reach).powi(2)).powi(2),
            _ => 0.0,
        };
        distances.into_iter().map(|d| weight(d as f32)).collect()
    }
}

fn mirrored(rest: &[[f32; 3]], neighbours: &[Vec<(usize, f32)>]) -> Vec<Option<usize>> {
    let nearest = |center: f32, handle: usize| {
        let [x, y, z] = rest[handle];
        let image = Vec3::new(2.0 * center - x, y, z);
        let distances = rest.iter().map(|&other| image.distance(other.into()));
        distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let apart = |center: f32| -> f32 {
        (0..rest.len()).filter_map(|handle| nearest(center, handle)).map(|(_, distance)| distance).sum()
    };
    let middle = Sphere::around(rest).center[0];
    let center = if apart(middle) < apart(0.0) { middle } else { 0.0 };
    (0..rest.len())
        .map(|handle| {
            let (other, distance) = nearest(center, handle)?;
            // A handle farther away than half the distance to its neighbours is at another place of the face.
            let near = neighbours[handle].iter().map(|(_, length)| *length).fold(f32::INFINITY, f32::min);
            let is_mutual = nearest(center, other).is_some_and(|(back, _)| back == handle);
            (is_mutual && distance < 0.5 * near).then_some(other)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::NoProgress;

    /// Five handles on a line 2 apart, shifted off the origin, and one above the middle.
    fn line() -> SoftSelection {
        let rest: Vec<[f32; 3]> = [-4.0, -2.0, 0.0, 2.0, 4.0]
            .map(|x| [x + 10.0, 0.0, 0.0])
            .into_iter()
            .chain([[10.0, 1.0, 0.0]])
            .collect();
        let mut neighbours = vec![Vec::new(); 6];
        for (a, b) in [(0, 1), (1, 2), (2, 3), (3, 4), (2, 5)] {
            let length = Vec3::from(rest[a]).distance(rest[b].into());
            neighbours[a].push((b, length));
            neighbours[b].push((a, length));
        }
        SoftSelection { mirrored: mirrored(&rest, &neighbours), neighbours }
    }

    const DRAG: Drag<'static> =
        Drag { grabbed: &[1], by: [1.0, 2.0, 0.0], reach: 0.0, mirrored: false, pinned: &[false; 6] };

    #[test]
    fn neighbours_follow_along_strain_edges() {
        let soft_selection = line();
        assert_eq!(soft_selection.drag(DRAG)[1], DRAG.by);
        assert_eq!(soft_selection.drag(DRAG).iter().filter(|moved| **moved != [0.0; 3]).count(), 1);
        let moved = soft_selection.drag(Drag { reach: 4.0, ..DRAG });
        // At half the reach (1 − 1/4)², and the one above is 3 away: (1 − 9/16)².
        let expected = [0.5625, 1.0, 0.5625, 0.0, 0.0, 0.191_406_25];
        for (moved, weight) in moved.iter().zip(expected) {
            assert!((moved[1] - 2.0 * weight).abs() < 1e-6 && (moved[0] - weight).abs() < 1e-6, "{moved:?}");
        }
        let pinned = [true, false, true, false, false, false];
        let held = soft_selection.drag(Drag { reach: 4.0, pinned: &pinned, ..DRAG });
        assert_eq!((held[0], held[2]), ([0.0; 3], [0.0; 3]));
        assert_eq!(held[1], DRAG.by);
    }

    #[test]
    fn the_other_side_does_the_same_in_the_mirror() {
        let soft_selection = line();
        assert_eq!(soft_selection.mirrored, [Some(4), Some(3), Some(2), Some(1), Some(0), Some(5)]);
        let moved = soft_selection.drag(Drag { mirrored: true, ..DRAG });
        assert_eq!(moved[1], [1.0, 2.0, 0.0]);
        assert_eq!(moved[3], [-1.0, 2.0, 0.0]);
        // The middle goes up, but not twice as far, and not sideways.
        let moved = soft_selection.drag(Drag { grabbed: &[2], mirrored: true, ..DRAG });
        assert_eq!(moved[2], [0.0, 2.0, 0.0]);
    }

    #[test]
    fn a_face_knows_its_other_side() {
        let rig: Rig =
            rhytid_solve::solve(&rhytid_demo::face(2_000), &NoProgress).unwrap().rounded().unwrap();
        let soft_selection = SoftSelection::new(&rig);
        let found =
            (0..rig.handles().len()).filter(|&handle| soft_selection.mirror_of(handle).is_some()).count();
        assert!(10 * found > 9 * rig.handles().len(), "{found} of {}", rig.handles().len());
        for handle in 0..rig.handles().len() {
            if let Some(other) = soft_selection.mirror_of(handle) {
                assert_eq!(soft_selection.mirror_of(other), Some(handle));
            }
        }
    }
}
