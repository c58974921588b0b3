//! Surfaces of a face that are opposite each other across an opening: lips, lids, nostrils.
use crate::rig::number;
use crate::rig_check::{below, fail, finite};
use crate::{Result, VertexId};
use rhytid_kernels::{Real, vec3};

/// The most vertices across an opening that a vertex is compared with.
pub const ACROSS: usize = 12;

/// The most rim vertices that a vertex moves with.
pub const LEADERS: usize = 8;

/// The skin at openings (`docs/method.md`, keep lips and lids from crossing). Empty where no surfaces are
/// opposite each other.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Openings<T: Real = f32> {
    /// R vertices that have others across an opening, ascending.
    pub rims: Vec<RimVertex<T>>,
    /// The vertices that move with rim vertices, and the rim vertices themselves.
    pub followers: Vec<RimFollower<T>>,
}

/// A vertex that has others across an opening.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RimVertex<T: Real = f32> {
    /// The vertex.
    pub vertex: VertexId,
    /// The numbers in [`Openings::rims`] of the vertices across. Where there are fewer, it is the vertex's
    /// own number.
    pub across: [u32; ACROSS],
    /// How far beside the vertex those across count, above 0, in mesh units.
    pub reach: T,
    /// The least gap, in mesh units. It is below 0 if an example goes into what is across.
    pub least_gap: T,
}

/// A vertex that moves as rim vertices do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RimFollower<T: Real = f32> {
    /// The vertex.
    pub vertex: VertexId,
    /// Numbers in [`Openings::rims`].
    pub leaders: [u32; LEADERS],
    /// How much of each leader's step it takes, -1 to 1. Weights below 0 are those of vertices that handles
    /// hold: what these would have to move, nothing moves.
    pub weights: [T; LEADERS],
}

/// What is across an opening from a vertex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// How far the vertex is in front of the surface across, in mesh units; below 0 behind it.
    pub width: f64,
    /// 1 where there is a surface across, 0 where there is none.
    pub certainty: f64,
    /// The normal of the surface across.
    pub normal: [f64; 3],
}

/// The sum of weights at which a gap begins to count, and that at which it counts fully.
const CERTAIN: [f64; 2] = [0.05, 0.5];

/// How far a vertex may be behind the surface across, in its reaches.
pub const BEHIND: f64 = 3.0;

/// Grows from 0 to 1 as `x` does, with slopes of 0 at both ends.
pub fn smooth_step(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

impl<T: Real> Openings<T> {
    /// The gap of the rim vertex with this number, given the R positions and normals of all rim vertices.
    ///
    /// It is the distance from the planes of the vertices across, averaged with weights. A weight is 1 where
    /// a vertex is straight across, and fades to 0 at the reach and where normals are not opposite. So a gap
    /// is continuous while lips slide on each other.
    pub fn gap(&self, rim: usize, positions: &[[f64; 3]], normals: &[[f64; 3]]) -> Gap {
        let RimVertex { across, reach, .. } = &self.rims[rim];
        let (own, reach) = (normals[rim], reach.widen());
        let (mut sum, mut width, mut normal) = (0.0, 0.0, [0.0; 3]);
        for &other in across {
            let opposite = 0.2 - vec3::dot(own, normals[other as usize]);
            if opposite <= 0.0 {
                continue;
            }
            let apart = vec3::sub(positions[rim], positions[other as usize]);
            let in_front = vec3::dot(apart, normals[other as usize]);
            let beside = (vec3::dot(apart, apart) - in_front * in_front) / (reach * reach);
            let behind = in_front.min(0.0) / (BEHIND * reach);
            let near = (1.0 - beside).max(0.0).powi(2) * (1.0 - behind * behind).max(0.0);
            let weight = near * opposite.min(1.0);
            sum += weight;
            width += weight * in_front;
            normal = [0, 1, 2].map(|c| normal[c] + weight * normals[other as usize][c]);
        }
        let length = vec3::length(normal);
        if sum <= CERTAIN[0] || length == 0.0 {
            return Gap { width: 0.0, certainty: 0.0, normal: [0.0; 3] };
        }
        let certainty = ((sum - CERTAIN[0]) / (CERTAIN[1] - CERTAIN[0])).min(1.0);
        Gap { width: width / sum, certainty, normal: normal.map(|n| n / length) }
    }

    /// The same in another precision.
    pub(crate) fn cast<U: Real>(&self) -> Openings<U> {
        let rim = |rim: &RimVertex<T>| RimVertex {
            vertex: rim.vertex,
            across: rim.across,
            reach: number(rim.reach),
            least_gap: number(rim.least_gap),
        };
        let follower = |follower: &RimFollower<T>| RimFollower {
            vertex: follower.vertex,
            leaders: follower.leaders,
            weights: follower.weights.map(number),
        };
        Openings {
            rims: self.rims.iter().map(rim).collect(),
            followers: self.followers.iter().map(follower).collect(),
        }
    }

    /// Checks all numbers, for a face of so many vertices.
    pub(crate) fn check(&self, vertices: usize) -> Result<()> {
        let Self { rims, followers } = self;
        let of_rims: Vec<VertexId> = rims.iter().map(|rim| rim.vertex).collect();
        below("rim_vertices", VertexId::numbers(&of_rims), vertices)?;
        let across: Vec<u32> = rims.iter().flat_map(|rim| rim.across).collect();
        below("rim_across", &across, rims.len())?;
        let gaps: Vec<T> = rims.iter().flat_map(|rim| [rim.reach, rim.least_gap]).collect();
        finite("rim_gaps", &gaps)?;
        if let Some(i) = rims.iter().position(|rim| rim.reach.widen() <= 0.0) {
            return fail(format!("rim_gaps[{i}] has the reach {}, expected a length above 0", rims[i].reach));
        }
        let of_followers: Vec<VertexId> = followers.iter().map(|follower| follower.vertex).collect();
        below("rim_followers", VertexId::numbers(&of_followers), vertices)?;
        let leaders: Vec<u32> = followers.iter().flat_map(|follower| follower.leaders).collect();
        below("rim_leaders", &leaders, rims.len())?;
        let weights: Vec<T> = followers.iter().flat_map(|follower| follower.weights).collect();
        finite("rim_leader_weights", &weights)?;
        match weights.iter().position(|weight| !(-1.0..=1.0).contains(&weight.widen())) {
            Some(i) => fail(format!("rim_leader_weights[{i}] is {}, expected -1 to 1", weights[i])),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vertices with these numbers across from the first one, which is at the origin and looks up.
    fn openings(across: &[u32]) -> Openings<f64> {
        let mut rim = RimVertex { vertex: VertexId(0), across: [0; ACROSS], reach: 1.0, least_gap: 0.0 };
        rim.across[..across.len()].copy_from_slice(across);
        Openings { rims: vec![rim; 4], followers: Vec::new() }
    }

    const POSITIONS: [[f64; 3]; 4] = [[0.0; 3], [0.3, 0.5, 0.0], [0.0, -0.6, 0.0], [0.0, 0.1, 0.99]];
    const NORMALS: [[f64; 3]; 4] = [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.6, -0.8, 0.0], [0.0, -1.0, 0.0]];

    fn gap(across: &[u32]) -> Gap {
        openings(across).gap(0, &POSITIONS, &NORMALS)
    }

    #[test]
    fn a_gap_is_the_mean_distance_from_the_planes_across() {
        // Straight ahead it is the distance, and behind it is below 0.
        let [ahead, behind] = [gap(&[1]), gap(&[2])];
        assert_eq!((ahead.certainty, ahead.normal), (1.0, NORMALS[1]));
        assert!((ahead.width - 0.5).abs() < 1e-12 && (behind.width + 0.48).abs() < 1e-12);
        // The weights are 0.91² and (1 − 0.36²)² (1 − 0.16²).
        let both = gap(&[1, 2]);
        assert!((both.width - 0.038124).abs() < 1e-6, "{both:?}");
        assert!(vec3::length(vec3::sub(both.normal, [0.298_023, -0.954_559, 0.0])) < 1e-5, "{both:?}");
    }

    #[test]
    fn what_is_far_beside_or_does_not_face_the_vertex_hardly_counts() {
        // The weight is (1 − 0.99²)² = 0.0004.
        assert_eq!(gap(&[3]), Gap { width: 0.0, certainty: 0.0, normal: [0.0; 3] });
        assert_eq!(gap(&[]).certainty, 0.0);
        let beside = |x: f64| {
            let positions = [[0.0; 3], [x, 0.5, 0.0], [0.0; 3], [0.0; 3]];
            openings(&[1]).gap(0, &positions, &NORMALS).certainty
        };
        // (1 − 0.64)² = 0.1296 is between 0.05 and 0.5.
        assert!((beside(0.8) - 0.0796 / 0.45).abs() < 1e-12);
        assert_eq!([beside(0.0), beside(0.99)], [1.0, 0.0]);
    }
}
