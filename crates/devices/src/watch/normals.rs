//! Checks of normals against the positions from the same device. If both do not agree, one of them is wrong.
//! A few normals are computed again each time, and the length of all is checked.

use rayon::prelude::*;
use rhytid_conformance::reference;
use rhytid_core::Rig;
use rhytid_kernels::normals::VertexTriangles;

/// A normal may be off by this many times the bound of conformance for rounding, since a requested device
/// need not conform. For triangles that are no slivers, this is a ten-thousandth.
const ROUNDINGS: f64 = 64.0;
/// If rounding alone may turn a normal by more than this, only its length is checked.
const UNDETERMINED: f64 = 0.5;
/// The tolerance of the square of a normal's length, which is 1.
const LENGTH: f32 = 1e-3;

/// The triangles at each vertex of a rig.
pub(super) struct Normals<'a> {
    triangles: &'a [[u32; 3]],
    at: VertexTriangles,
}

/// A normal that no device should give.
pub(super) struct Wrong {
    pub(super) vertex: usize,
    pub(super) found: [f32; 3],
    pub(super) expected: [f32; 3],
}

impl<'a> Normals<'a> {
    pub(super) fn new(rig: &'a Rig) -> Self {
        Self { triangles: &rig.surface().triangles, at: rig.surface().vertex_triangles() }
    }

    /// The first of `vertices` whose normal is wrong in a frame, given its V positions.
    pub(super) fn first_wrong(
        &self,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
        vertices: impl IntoIterator<Item = usize>,
    ) -> Option<Wrong> {
        vertices.into_iter().find_map(|v| self.wrong(positions, normals, v))
    }

    /// The normal of one vertex if it is wrong.
    fn wrong(&self, positions: &[[f32; 3]], normals: &[[f32; 3]], vertex: usize) -> Option<Wrong> {
        let found = normals[vertex];
        let incident = self.at.at(vertex).iter().map(|&t| self.triangles[t as usize]);
        let corners = incident.map(|triangle| triangle.map(|v| positions[v as usize].map(f64::from)));
        let expected = reference::vertex_normal(corners);
        let off = ROUNDINGS * expected.iter().map(|n| n.bound).fold(0.0, f64::max);
        let mut components = found.iter().zip(&expected);
        let is_right = (is_unit(&found) || found == [0.0; 3])
            && (off > UNDETERMINED || components.all(|(&n, e)| (f64::from(n) - e.value).abs() <= off));
        (!is_right).then(|| Wrong { vertex, found, expected: expected.map(|n| n.value as f32) })
    }
}

/// Whether all normals of a batch are of length 1.
pub(super) fn are_units(normals: &[[f32; 3]]) -> bool {
    // In blocks without an exit, which a processor compares many at a time.
    normals.par_chunks(1 << 14).all(|block| block.iter().fold(true, |all, n| all & is_unit(n)))
}

/// The vertices whose normals are not of length 1.
pub(super) fn no_units(normals: &[[f32; 3]]) -> impl Iterator<Item = usize> {
    (0..normals.len()).filter(|&v| !is_unit(&normals[v]))
}

fn is_unit([x, y, z]: &[f32; 3]) -> bool {
    (x * x + y * y + z * z - 1.0).abs() <= LENGTH
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_kernels::normals::vertex_normal;

    /// Fans of triangles of every shape around vertex 0. Some triangles are slivers without a direction. Each
    /// fan comes with its normal in float32, computed with triangles and corners in another order.
    fn fans() -> impl Iterator<Item = (Vec<[f32; 3]>, Vec<[u32; 3]>, [f32; 3])> {
        let mut state = 1u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1 << 24) as f32 - 0.5
        };
        (0..4000).map(move |i| {
            let thin = 0.1f32.powi(i % 9);
            let centre = [0; 3].map(|_| 300.0 * random());
            let mut positions = vec![centre];
            let spokes = 3 + i as u32 % 5;
            for spoke in 0..spokes {
                let angle = (spoke as f32 + 0.8 * random()) * std::f32::consts::TAU / spokes as f32;
                let around = [angle.cos(), thin * angle.sin(), 0.3 * thin * random()];
                positions.push([0, 1, 2].map(|c| centre[c] + around[c]));
            }
            let triangles: Vec<[u32; 3]> = (1..=spokes).map(|s| [0, s, s % spokes + 1]).collect();
            let turned: Vec<[u32; 3]> = triangles.iter().rev().map(|&[a, b, c]| [c, a, b]).collect();
            let incident: Vec<u32> = (0..spokes).collect();
            let normal = vertex_normal(&positions, &turned, &incident);
            (positions, triangles, normal)
        })
    }

    #[test]
    fn rounding_is_no_fault_and_a_turn_is_one_where_the_triangles_have_a_direction() {
        let (mut found_out, mut undetermined) = (0, 0);
        for (positions, triangles, normal) in fans() {
            let normals =
                Normals { triangles: &triangles, at: VertexTriangles::new(positions.len(), &triangles) };
            let wrong = |normal: [f32; 3]| normals.wrong(&positions, &[normal], 0);
            if let Some(Wrong { found, expected, .. }) = wrong(normal) {
                panic!("{found:?} instead of {expected:?} of {positions:?}");
            }
            assert!(normal == [0.0; 3] || wrong(normal.map(|x| 0.9 * x)).is_some());
            assert!(wrong([f32::NAN; 3]).is_some());
            match wrong(normal.map(|x| -x)).is_some() {
                true => found_out += 1,
                false => undetermined += 1,
            }
        }
        assert!(found_out > 2000 && undetermined > 200, "{found_out} and {undetermined}");
    }

    #[test]
    fn a_vertex_without_triangles_has_no_normal() {
        let triangles = [[0, 1, 2]];
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [5.0, 5.0, 5.0]];
        let up = [0.0, 0.0, 1.0];
        let normals = Normals { triangles: &triangles, at: VertexTriangles::new(4, &triangles) };
        let wrong = |of_the_last| {
            let found = normals.first_wrong(&positions, &[up, up, up, of_the_last], 0..4);
            found.map(|wrong| wrong.vertex)
        };
        assert_eq!(wrong([0.0; 3]), None);
        assert_eq!(wrong(up), Some(3));
        assert!(are_units(&[up; 3]) && !are_units(&[up, up, [0.0; 3]]) && !are_units(&[[f32::NAN; 3]]));
        let two_are_zero = [up, [0.0; 3], up, [0.0; 3]];
        let found = normals.first_wrong(&positions, &two_are_zero, no_units(&two_are_zero));
        assert_eq!(found.unwrap().vertex, 1);
    }
}
