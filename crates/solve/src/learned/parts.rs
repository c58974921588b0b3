//! Parts without a handle (step 1 of the learned method). Some are rigid, others follow the driven surface.
use super::neighborhoods::InfluenceSource;
use crate::driven::DrivenComponents;
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{Bind, Example, VertexId, horn};
use rstar::RTree;
use rstar::primitives::GeomWithData;

/// A part is rigid if in every example its RMS distance to its best rigid motion is below this part of its
/// RMS radius.
const RIGID_WITHIN: f64 = 0.03;

/// A part of the mesh that has no handle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreePart {
    /// Its lowest vertex.
    pub first_vertex: VertexId,
    /// The number of its vertices.
    pub vertices: usize,
    /// How it moves.
    pub motion: FreeMotion,
}

/// How a part without a handle moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FreeMotion {
    /// It stays.
    Still,
    /// It is rigid in all examples, and moves as one solid.
    Solid,
    /// It follows the closest points of the driven surface.
    Skin,
    /// Each vertex has a part of the motion of the closest point of the driven surface. The rest is learned
    /// from the handles around the part.
    Blend {
        /// The mean of these parts, 0 to 1.
        skin: f64,
    },
}

impl FreeMotion {
    /// Whether the part has any of the skin's motion.
    pub(crate) fn follows_skin(self) -> bool {
        matches!(self, FreeMotion::Skin | FreeMotion::Blend { .. })
    }
}

/// The source of each vertex's influences, and the parts without a handle.
///
/// With [`Bind::Auto`], a part is a solid if it is rigid in all of `examples`. Otherwise it may be a blend,
/// and is here as if all of its motion were the skin's. The other values of `bind` decide for all parts.
pub(crate) fn sources(
    rest: &[[f64; 3]],
    parts: &DrivenComponents,
    examples: &[Example],
    bind: Bind,
) -> (Vec<InfluenceSource>, Vec<FreePart>) {
    let members = parts.without_handle();
    let motions: Vec<FreeMotion> = members
        .par_iter()
        .map(|part| match bind {
            Bind::Auto if examples.iter().all(|example| is_rigid(rest, &example.positions, part)) => {
                FreeMotion::Solid
            }
            Bind::Auto => FreeMotion::Blend { skin: 1.0 },
            Bind::Rigid => FreeMotion::Still,
            Bind::Nearest => FreeMotion::Skin,
        })
        .collect();
    let centroids: Vec<[f64; 3]> = members.iter().map(|part| centroid(rest, part).to_array()).collect();
    // Most faces have no part that follows.
    let some_follow =
        members.iter().zip(&motions).any(|(part, motion)| !part.is_empty() && motion.follows_skin());
    let driven = (0..rest.len() as u32).filter(|&v| some_follow && parts.driven[v as usize]);
    let surface: Vec<_> = driven.map(|v| GeomWithData::new(rest[v as usize], v)).collect();
    let surface = RTree::bulk_load(surface);
    // Of equally near vertices, the lowest counts.
    let closest = |x: &[f64; 3]| surface.nearest_neighbors(x).into_iter().map(|found| found.data).min();
    let sources = (0..rest.len())
        .into_par_iter()
        .map(|v| match parts.component[v] as usize {
            _ if parts.driven[v] => InfluenceSource::Itself,
            _ if bind == Bind::Rigid => InfluenceSource::Nothing,
            part if motions[part] == FreeMotion::Solid => InfluenceSource::At(centroids[part]),
            part => closest(&rest[v])
                .map_or(InfluenceSource::At(centroids[part]), |w| InfluenceSource::As(VertexId(w))),
        })
        .collect();
    let free = members.iter().zip(motions).filter_map(|(part, motion)| {
        Some(FreePart { first_vertex: *part.first()?, vertices: part.len(), motion })
    });
    (sources, free.collect())
}

pub(crate) fn centroid(positions: &[[f64; 3]], part: &[VertexId]) -> DVec3 {
    let sum: DVec3 = part.iter().map(|v| DVec3::from_array(positions[v.index()])).sum();
    sum / part.len() as f64
}

/// Whether a part moves rigidly in an example.
///
/// The largest eigenvalue λ of [`horn`]'s matrix gives the sum of the squared distances to the best rigid
/// motion: `Σ|a|² + Σ|b|² − 2λ`, about the two centroids.
fn is_rigid(rest: &[[f64; 3]], example: &[[f64; 3]], part: &[VertexId]) -> bool {
    let (a0, b0) = (centroid(rest, part), centroid(example, part));
    let mut m = [[0.0; 3]; 3];
    let mut spread = [0.0; 2];
    for v in part {
        let a = (DVec3::from_array(rest[v.index()]) - a0).to_array();
        let b = (DVec3::from_array(example[v.index()]) - b0).to_array();
        for i in 0..3 {
            spread[0] += a[i] * a[i];
            spread[1] += b[i] * b[i];
            for j in 0..3 {
                m[i][j] += b[i] * a[j];
            }
        }
    }
    let largest = horn(&m).largest;
    let squared = (spread[0] + spread[1] - 2.0 * largest).max(0.0);
    squared <= RIGID_WITHIN.powi(2) * spread[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_part_is_rigid_and_a_stretched_one_is_not() {
        let rest = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
        let turned = rest.map(|[x, y, z]| [5.0 - y, x, z]);
        let mirrored = rest.map(|[x, y, z]| [-x, y, z]);
        let stretched = rest.map(|[x, y, z]| [x, y, 1.1 * z]);
        let all = [0, 1, 2, 3].map(VertexId);
        let rigid = |example: &[[f64; 3]; 4]| is_rigid(&rest, example, &all);
        assert!(rigid(&turned));
        assert!(!rigid(&stretched));
        assert!(!rigid(&mirrored));
    }
}
