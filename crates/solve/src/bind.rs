//! Components without a handle that follow the driven surface (`bind = "nearest"`).
use crate::triangulate::is_degenerate;
use glam::DVec3;
use parry3d_f64::math::Vector;
use parry3d_f64::shape::TriMesh;
use rayon::prelude::*;
use rhytid_core::{Error, Result};

/// Gives every vertex that is not driven the basis row of the closest point of the driven surface: the
/// barycentric mean of the three rows there. The vertex keeps its offset from that point.
///
/// `rest` is V×3, `basis` V×H. Without a driven triangle nothing is bound.
///
/// # Errors
/// [`Error::Internal`] if the surface cannot be searched.
pub fn bind_nearest(
    rest: &[[f64; 3]],
    triangles: &[[u32; 3]],
    driven: &[bool],
    handles: usize,
    basis: &mut [f64],
) -> Result<()> {
    let surface: Vec<[u32; 3]> = triangles
        .iter()
        .filter(|t| driven[t[0] as usize] && !is_degenerate(t.map(|v| DVec3::from_array(rest[v as usize]))))
        .copied()
        .collect();
    if surface.is_empty() {
        return Ok(());
    }
    let mesh = TriMesh::new(rest.iter().map(|p| Vector::from(*p)).collect(), surface.clone())
        .map_err(|e| Error::Internal(format!("the driven surface cannot be searched: {e}")))?;
    let bound: Vec<usize> = (0..rest.len()).filter(|&v| !driven[v]).collect();
    let rows: Vec<Vec<f64>> = bound
        .par_iter()
        .map(|&v| {
            let (triangle, weights) = closest_point(&mesh, rest[v]);
            (0..handles)
                .map(|h| {
                    (0..3).map(|i| weights[i] * basis[surface[triangle][i] as usize * handles + h]).sum()
                })
                .collect()
        })
        .collect();
    for (v, row) in bound.into_iter().zip(rows) {
        basis[v * handles..][..handles].copy_from_slice(&row);
    }
    Ok(())
}

/// The triangle that holds the closest point to `p`, and its barycentric coordinates there.
fn closest_point(mesh: &TriMesh, p: [f64; 3]) -> (usize, [f64; 3]) {
    use parry3d_f64::query::PointQueryWithLocation;
    let (_, (triangle, location)) = mesh.project_local_point_and_get_location(Vector::from(p), false);
    (triangle as usize, location.barycentric_coordinates().unwrap_or([1.0, 0.0, 0.0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_the_closest_point() {
        // A driven triangle in the plane z = 0 and three vertices over its face, an edge and a corner.
        let rest = [
            [0.0, 0.0, 0.0],
            [4.0, 0.0, 0.0],
            [0.0, 4.0, 0.0],
            [1.0, 1.0, 3.0],
            [2.0, -1.0, 1.0],
            [-1.0, -1.0, 0.0],
        ];
        let driven = [true, true, true, false, false, false];
        let mut basis = vec![0.0; 18];
        for i in 0..3 {
            basis[i * 3 + i] = 1.0;
        }
        bind_nearest(&rest, &[[0, 1, 2], [3, 4, 5]], &driven, 3, &mut basis).unwrap();
        let expected = [[0.5, 0.25, 0.25], [0.5, 0.5, 0.0], [1.0, 0.0, 0.0]];
        for (got, expected) in basis[9..].iter().zip(expected.as_flattened()) {
            assert!((got - expected).abs() < 1e-12, "{basis:?}");
        }
    }
}
