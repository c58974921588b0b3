//! Components without a handle that follow the driven surface (`bind = "nearest"`).
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::Table;
use rhytid_geometry::laplacian::is_degenerate;
use rhytid_geometry::{Closest, Surface};

/// Gives every vertex for which `binds` is true the basis row of the closest point of the driven surface.
///
/// These vertices are not driven. The row is the barycentric mean of the three corners' rows. The vertex
/// keeps its offset from the closest point. Of equally close triangles, the first counts.
///
/// `rest` is V×3, `basis` V×H. Without a driven triangle nothing is bound.
pub(crate) fn bind_nearest(
    rest: &[[f64; 3]],
    triangles: &[[u32; 3]],
    driven: &[bool],
    binds: impl Fn(usize) -> bool,
    basis: &mut Table<f64>,
) {
    let bound: Vec<usize> = (0..rest.len()).filter(|&v| binds(v)).collect();
    if bound.is_empty() {
        return;
    }
    let place = |v: u32| DVec3::from_array(rest[v as usize]);
    let corners = triangles.iter().map(|t| t.map(place)).enumerate();
    let has =
        |(t, corners): &(usize, [DVec3; 3])| driven[triangles[*t][0] as usize] && !is_degenerate(*corners);
    let surface = Surface::new(corners.filter(has));
    let row_of = |&v: &usize| {
        let Closest { triangle, weights, .. } = surface.closest(DVec3::from_array(rest[v]))?;
        let corners = triangles[triangle];
        let rows = corners.map(|corner| basis.row(corner as usize));
        let of_handle = |h: usize| (0..3).map(|i| weights[i] * rows[i][h]).sum();
        Some((0..basis.columns()).map(of_handle).collect())
    };
    // All vertices have a row, or none has one because the surface has no triangle.
    let Some(rows) = bound.par_iter().map(row_of).collect::<Option<Vec<Vec<f64>>>>() else { return };
    for (v, row) in bound.into_iter().zip(rows) {
        basis.row_mut(v).copy_from_slice(&row);
    }
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
        let mut basis = Table::filled(6, 3, 0.0);
        for i in 0..3 {
            basis.row_mut(i)[i] = 1.0;
        }
        bind_nearest(&rest, &[[0, 1, 2], [3, 4, 5]], &driven, |v| !driven[v], &mut basis);
        let expected = [[0.5, 0.25, 0.25], [0.5, 0.5, 0.0], [1.0, 0.0, 0.0]];
        for (got, expected) in basis.of_rows(3..6).iter().zip(expected.as_flattened()) {
            assert!((got - expected).abs() < 1e-12, "{basis:?}");
        }
    }
}
