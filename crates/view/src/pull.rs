//! What a marker that is dragged takes with it.

use glam::Vec3;
use rhytid_core::Rig;
use rhytid_geometry::dijkstra::shortest_ways;
use rhytid_render::Sphere;

/// How handles follow those that are dragged: along the strain edges, and mirrored.
#[derive(Debug, Clone, PartialEq)]
pub struct Pull {
    /// For each handle those that it shares a strain edge with, and how far they are at rest.
    neighbours: Vec<Vec<(usize, f32)>>,
    /// For each handle the one that stands where its mirror image does, itself in the middle; `None` where there is none.
    mirrored: Vec<Option<usize>>,
}

/// How it is dragged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drag<'a> {
    /// Which handles.
    pub grabbed: &'a [usize],
    /// By how much, in mesh units.
    pub by: [f32; 3],
    /// How far along strain edges others follow, in mesh units: half at somewhat less than half of it, nothing beyond. 0 for none.
    pub reach: f32,
    /// Whether the other side of the face does the same in the mirror.
    pub mirrored: bool,
    /// H: which stay where they are.
    pub pinned: &'a [bool],
}

impl Pull {
    /// For the handles of `rig`. A face is mirrored at a plane x = c: the one of x = 0 and the handles' middle that fits them better.
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

    /// The handle that stands where the mirror image of `handle` does.
    pub fn mirror_of(&self, handle: usize) -> Option<usize> {
        self.mirrored[handle]
    }

    /// Which handles are in the mirror of these.
    pub fn mirror_of_all(&self, handles: &[usize]) -> Vec<usize> {
        handles.iter().filter_map(|&handle| self.mirrored[handle]).collect()
    }

    /// H vectors: by how much each handle moves, in mesh units. Those that are grabbed move by all of it.
    pub fn drag(&self, drag: Drag<'_>) -> Vec<[f32; 3]> {
        let mut weights = self.weights(drag.grabbed, drag.reach);
        let mut others = vec![0.0; weights.len()];
        if drag.mirrored {
            others = self.weights(&self.mirror_of_all(drag.grabbed), drag.reach);
        }
        for (handle, &pinned) in drag.pinned.iter().enumerate() {
            // What is grabbed by hand is moved, pinned or not.
            if pinned && !drag.grabbed.contains(&handle) {
                (weights[handle], others[handle]) = (0.0, 0.0);
            }
        }
        let [x, y, z] = drag.by;
        let moved = |(w, m): (f32, f32)| {
            // In the middle both sides meet: together they are no more than one.
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
            // Farther away than half the way to its neighbours it is another place of the face.
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
    fn line() -> Pull {
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
        Pull { mirrored: mirrored(&rest, &neighbours), neighbours }
    }

    const DRAG: Drag<'static> =
        Drag { grabbed: &[1], by: [1.0, 2.0, 0.0], reach: 0.0, mirrored: false, pinned: &[false; 6] };

    #[test]
    fn neighbours_follow_along_strain_edges() {
        let pull = line();
        assert_eq!(pull.drag(DRAG)[1], DRAG.by);
        assert_eq!(pull.drag(DRAG).iter().filter(|moved| **moved != [0.0; 3]).count(), 1);
        let moved = pull.drag(Drag { reach: 4.0, ..DRAG });
        // At half the reach (1 − 1/4)², and the one above is 3 away: (1 − 9/16)².
        let expected = [0.5625, 1.0, 0.5625, 0.0, 0.0, 0.191_406_25];
        for (moved, weight) in moved.iter().zip(expected) {
            assert!((moved[1] - 2.0 * weight).abs() < 1e-6 && (moved[0] - weight).abs() < 1e-6, "{moved:?}");
        }
        let pinned = [true, false, true, false, false, false];
        let held = pull.drag(Drag { reach: 4.0, pinned: &pinned, ..DRAG });
        assert_eq!((held[0], held[2]), ([0.0; 3], [0.0; 3]));
        assert_eq!(held[1], DRAG.by);
    }

    #[test]
    fn the_other_side_does_the_same_in_the_mirror() {
        let pull = line();
        assert_eq!(pull.mirrored, [Some(4), Some(3), Some(2), Some(1), Some(0), Some(5)]);
        let moved = pull.drag(Drag { mirrored: true, ..DRAG });
        assert_eq!(moved[1], [1.0, 2.0, 0.0]);
        assert_eq!(moved[3], [-1.0, 2.0, 0.0]);
        // The middle goes up, and not twice as far, and not sideways.
        let moved = pull.drag(Drag { grabbed: &[2], mirrored: true, ..DRAG });
        assert_eq!(moved[2], [0.0, 2.0, 0.0]);
    }

    #[test]
    fn a_face_knows_its_other_side() {
        let rig: Rig =
            rhytid_solve::solve(&rhytid_demo::face(2_000), &NoProgress).unwrap().rounded().unwrap();
        let pull = Pull::new(&rig);
        let found =
            (0..rig.handles().vertices.len()).filter(|&handle| pull.mirror_of(handle).is_some()).count();
        assert!(10 * found > 9 * rig.handles().vertices.len(), "{found} of {}", rig.handles().vertices.len());
        for handle in 0..rig.handles().vertices.len() {
            if let Some(other) = pull.mirror_of(handle) {
                assert_eq!(pull.mirror_of(other), Some(handle));
            }
        }
    }
}
