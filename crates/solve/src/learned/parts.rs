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
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FreePart {
    /// Its lowest vertex.
    pub first_vertex: VertexId,
    /// The number of its vertices.
    pub vertices: usize,
    /// Whether it moves as one solid; otherwise it follows the closest point of the driven surface.
    pub rigid: bool,
}

/// The source of each vertex's influences, and the parts without a handle.
///
/// With [`Bind::Auto`], a part is rigid if it is rigid in all of `examples`, and follows the driven surface
/// otherwise. The other values of `bind` decide for all parts.
pub(crate) fn sources(
    rest: &[[f64; 3]],
    parts: &DrivenComponents,
    examples: &[Example],
    bind: Bind,
) -> (Vec<InfluenceSource>, Vec<FreePart>) {
    let count = parts.component.iter().max().map_or(0, |last| *last as usize + 1);
    let mut members = vec![Vec::new(); count];
    let without_handle = (0..rest.len() as u32).filter(|&v| !parts.driven[v as usize]);
    without_handle.for_each(|v| members[parts.component[v as usize] as usize].push(v));
    let is_rigid: Vec<bool> = members
        .par_iter()
        .map(|part| match bind {
            Bind::Auto => examples.iter().all(|example| is_rigid(rest, &example.positions, part)),
            Bind::Rigid => true,
            Bind::Nearest => false,
        })
        .collect();
    let centroids: Vec<[f64; 3]> = members.iter().map(|part| centroid(rest, part).to_array()).collect();
    // Most faces have no part that follows.
    let some_follow = members.iter().zip(&is_rigid).any(|(part, rigid)| !part.is_empty() && !rigid);
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
            part if is_rigid[part] => InfluenceSource::At(centroids[part]),
            part => closest(&rest[v])
                .map_or(InfluenceSource::At(centroids[part]), |w| InfluenceSource::As(VertexId(w))),
        })
        .collect();
    let free = members.iter().zip(is_rigid).filter_map(|(part, rigid)| {
        Some(FreePart { first_vertex: VertexId(*part.first()?), vertices: part.len(), rigid })
    });
    (sources, free.collect())
}

fn centroid(positions: &[[f64; 3]], part: &[u32]) -> DVec3 {
    let sum: DVec3 = part.iter().map(|&v| DVec3::from_array(positions[v as usize])).sum();
    sum / part.len() as f64
}

/// Whether a part moves rigidly in an example.
///
/// The largest eigenvalue λ of [`horn`]'s matrix gives the sum of the squared distances to the best rigid
/// motion: `Σ|a|² + Σ|b|² − 2λ`, about the two centroids.
fn is_rigid(rest: &[[f64; 3]], example: &[[f64; 3]], part: &[u32]) -> bool {
    let (a0, b0) = (centroid(rest, part), centroid(example, part));
    let mut m = [[0.0; 3]; 3];
    let mut spread = [0.0; 2];
    for &v in part {
        let a = (DVec3::from_array(rest[v as usize]) - a0).to_array();
        let b = (DVec3::from_array(example[v as usize]) - b0).to_array();
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
        let rigid = |example: &[[f64; 3]; 4]| is_rigid(&rest, example, &[0, 1, 2, 3]);
        assert!(rigid(&turned));
        assert!(!rigid(&stretched));
        assert!(!rigid(&mirrored));
    }
}
