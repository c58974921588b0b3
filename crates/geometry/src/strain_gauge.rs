//! Principal strains: how much skin is stretched and squeezed at each vertex, and which way.
//!
//! A triangle has the edges E₀ at rest, as 2×2 in its own plane, and E in a frame, as 3×2. It is deformed by
//! F = E E₀⁻¹. A vertex has the mean of the metrics FᵀF of the triangles around it, weighted by their areas
//! at rest. Each metric is first turned from its triangle's plane into the vertex's by the smallest rotation
//! that does so.
//!
//! The eigenvalues of the mean are the squares of the principal stretches λ₁ ≥ λ₂. The strains are λ − 1: the
//! singular values of the deformation gradient less one. So 0.1 means skin a tenth longer than at rest, and
//! −0.1 skin a tenth shorter. A rigid motion of the whole mesh changes nothing.

use crate::laplacian::is_degenerate;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use rhytid_kernels::normals::VertexTriangles;
use rhytid_kernels::vec3;

/// Vertices that a thread takes at once.
const CHUNK: usize = 1024;

/// A mesh at rest, prepared to measure the strains of its frames.
#[derive(Debug, Clone, PartialEq)]
pub struct StrainGauge {
    triangles: Vec<[u32; 3]>,
    planes: Vec<Plane>,
    /// Where each vertex's part of `corners` begins, and where the last part ends: V + 1 entries.
    begins: Vec<u32>,
    corners: Vec<Corner>,
}

/// The rest shape of a triangle: E₀⁻¹, with the first axis along the first edge.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Plane {
    /// One by the length of the first edge.
    along: f64,
    /// How far the second edge goes along the first, as a part of its length.
    slant: f64,
    /// One by how far the second edge goes across the first.
    across: f64,
}

/// A triangle as seen from one of its vertices.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Corner {
    triangle: u32,
    /// The area at rest.
    area: f64,
    /// The first axis of the triangle's plane, in the vertex's.
    axis: DVec2,
}

/// The principal strains at V vertices.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PrincipalStrains {
    /// V × 2: λ₁ − 1 and λ₂ − 1, the larger first. 0 at a vertex without a triangle that has an area. The
    /// least value is −1, for skin that has shrunk to no length.
    pub strains: Vec<[f32; 2]>,
    /// V × 3, the direction of each first strain on the surface of the frame: of length 1, or 0 if there is
    /// none. The direction is a line rather than an arrow, so its sign means nothing. If both strains are
    /// equal, the direction means nothing.
    pub first: Vec<[f32; 3]>,
    /// V × 3, the direction of each second strain, at right angles to the first and in the surface.
    pub second: Vec<[f32; 3]>,
}

impl StrainGauge {
    /// For a mesh of `triangles` whose V vertices are at `rest`. Triangles without area do not count. At a
    /// vertex, neither does a triangle whose normal is opposite to the normal of the vertex.
    ///
    /// # Panics
    /// If a triangle's vertex is not below V.
    pub fn new(rest: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        Self::with(rest, triangles, &VertexTriangles::new(rest.len(), triangles))
    }

    /// The same for the surface of a rig. All vertices of a point have the strains of the surface around it.
    pub fn of_surface(surface: &rhytid_core::Surface) -> Self {
        Self::with(&surface.rest, &surface.triangles, &surface.vertex_triangles())
    }

    fn with(rest: &[[f32; 3]], triangles: &[[u32; 3]], at: &VertexTriangles) -> Self {
        let points = |t: &[u32; 3]| t.map(|v| wide(rest[v as usize]));
        let sides = |t: &[u32; 3]| {
            let [a, b, c] = points(t);
            [b - a, c - a]
        };
        let normals: Vec<DVec3> = triangles
            .par_iter()
            .map(|t| match is_degenerate(points(t)) {
                true => DVec3::ZERO,
                false => sides(t)[0].cross(sides(t)[1]),
            })
            .collect();
        let plane = |(t, normal): (&[u32; 3], &DVec3)| {
            let [ab, ac] = sides(t);
            let (square, twice_area) = (ab.length_squared(), normal.length());
            Plane {
                along: 1.0 / square.sqrt(),
                slant: ab.dot(ac) / square,
                across: square.sqrt() / twice_area,
            }
        };
        let planes = triangles.par_iter().zip(&normals).map(plane).collect();
        let (mut begins, mut corners) = (vec![0], Vec::with_capacity(3 * triangles.len()));
        for v in 0..rest.len() {
            let sum = at.at(v).iter().fold(DVec3::ZERO, |sum, &t| sum + normals[t as usize]);
            let normal = normalize(sum);
            let axes = tangents(normal);
            for &triangle in at.at(v) {
                let own = normals[triangle as usize];
                let twice_area = own.length();
                let own = normalize(own);
                let cosine = own.dot(normal);
                if twice_area == 0.0 || normal == DVec3::ZERO || cosine < -1.0 + 1e-9 {
                    continue;
                }
                let [ab, _] = sides(&triangles[triangle as usize]);
                let turned = turn(normalize(ab), own, normal, cosine);
                let axis = DVec2::from_array(axes.map(|axis| axis.dot(turned)));
                corners.push(Corner { triangle, area: 0.5 * twice_area, axis });
            }
            begins.push(corners.len() as u32);
        }
        Self { triangles: triangles.to_vec(), planes, begins, corners }
    }

    /// V.
    pub fn vertices(&self) -> usize {
        self.begins.len() - 1
    }

    /// The area of each vertex, V in mesh units squared: a third of its own triangles at rest. It weights
    /// means over parts of a face.
    pub fn areas(&self) -> impl Iterator<Item = f64> + '_ {
        let of_vertex = |v: usize| {
            let is_own = |corner: &&Corner| self.triangles[corner.triangle as usize].contains(&(v as u32));
            self.corners_of(v).iter().filter(is_own).map(|corner| corner.area).sum::<f64>() / 3.0
        };
        (0..self.vertices()).map(of_vertex)
    }

    /// Replaces `strains` by those of a frame whose V vertices are at `positions`, computed in f64 and
    /// rounded once.
    ///
    /// # Panics
    /// If there are fewer positions.
    pub fn measure(&self, positions: &[[f32; 3]], strains: &mut PrincipalStrains) {
        let vertices = self.vertices();
        let PrincipalStrains { strains, first, second } = strains;
        strains.resize(vertices, [0.0; 2]);
        first.resize(vertices, [0.0; 3]);
        second.resize(vertices, [0.0; 3]);
        let chunks =
            strains.par_chunks_mut(CHUNK).zip(first.par_chunks_mut(CHUNK)).zip(second.par_chunks_mut(CHUNK));
        chunks.enumerate().for_each(|(chunk, ((strains, first), second))| {
            for i in 0..strains.len() {
                let of_vertex = self.vertex(chunk * CHUNK + i, positions);
                strains[i] = of_vertex.strains.as_vec2().to_array();
                first[i] = of_vertex.first.as_vec3().to_array();
                second[i] = of_vertex.second.as_vec3().to_array();
            }
        });
    }

    fn corners_of(&self, v: usize) -> &[Corner] {
        &self.corners[self.begins[v] as usize..self.begins[v + 1] as usize]
    }

    fn vertex(&self, v: usize, positions: &[[f32; 3]]) -> VertexStrain {
        // The metric's xx, xy and yy, and the deformation of the vertex's axes.
        let (mut metric, mut pushed, mut area) = ([0.0; 3], [DVec3::ZERO; 2], 0.0);
        for corner in self.corners_of(v) {
            let [x, y] = self.deformation(corner, positions);
            for (sum, part) in metric.iter_mut().zip([x.dot(x), x.dot(y), y.dot(y)]) {
                *sum += corner.area * part;
            }
            for (sum, part) in pushed.iter_mut().zip([x, y]) {
                *sum += part * corner.area;
            }
            area += corner.area;
        }
        if area == 0.0 {
            return VertexStrain::default();
        }
        let ([most, least], [c, s]) = eigen(metric.map(|sum| sum / area));
        let push = |[c, s]: [f64; 2]| pushed[0] * c + pushed[1] * s;
        let first = normalize(push([c, s]));
        let across = push([-s, c]);
        let second = normalize(across - first * across.dot(first));
        VertexStrain { strains: DVec2::new(most.sqrt() - 1.0, least.max(0.0).sqrt() - 1.0), first, second }
    }

    /// Where a triangle's F takes the two axes of the vertex's plane.
    fn deformation(&self, corner: &Corner, positions: &[[f32; 3]]) -> [DVec3; 2] {
        let [a, b, c] = self.triangles[corner.triangle as usize].map(|v| wide(positions[v as usize]));
        let Plane { along, slant, across } = self.planes[corner.triangle as usize];
        let (ab, ac) = (b - a, c - a);
        let x = ab * along;
        let y = (ac - ab * slant) * across;
        let DVec2 { x: cosine, y: sine } = corner.axis;
        let mix = |p: f64, q: f64| x * p + y * q;
        [mix(cosine, -sine), mix(sine, cosine)]
    }
}

/// What is measured at one vertex.
#[derive(Default)]
struct VertexStrain {
    /// The larger first.
    strains: DVec2,
    /// The direction of the first strain.
    first: DVec3,
    /// The direction of the second strain.
    second: DVec3,
}

fn wide(x: [f32; 3]) -> DVec3 {
    DVec3::from_array(x.map(f64::from))
}

/// The vector of length 1, or zero where `x` is zero. As the kernels do it, very small vectors keep their
/// direction.
fn normalize(x: DVec3) -> DVec3 {
    DVec3::from_array(vec3::normalize(x.to_array()))
}

/// Two axes at right angles to a normal; the first as near to the mesh's x as can be, so that neighbours have
/// similar ones.
fn tangents(normal: DVec3) -> [DVec3; 2] {
    let axis = if normal.x.abs() < 0.99 { DVec3::X } else { DVec3::Y };
    let first = normalize(axis - normal * axis.dot(normal));
    [first, normal.cross(first)]
}

/// Turns `x`, which is at right angles to the unit vector `from`, by the smallest rotation from `from` to the
/// unit vector `to`.
fn turn(x: DVec3, from: DVec3, to: DVec3, cosine: f64) -> DVec3 {
    let part = to.dot(x) / (1.0 + cosine);
    x - (from + to) * part
}

/// The eigenvalues of a symmetric matrix, the larger first, and the unit eigenvector of the larger one. The
/// matrix is given as xx, xy and yy.
fn eigen([xx, xy, yy]: [f64; 3]) -> ([f64; 2], [f64; 2]) {
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let radius = (half * half + xy * xy).sqrt();
    let vector = match half {
        _ if radius == 0.0 => [1.0, 0.0],
        // Two columns hold the eigenvector. This takes the one without a difference of nearly equal numbers.
        0.0.. => [half + radius, xy],
        _ => [xy.abs(), (radius - half).copysign(xy)],
    };
    let size = (vector[0] * vector[0] + vector[1] * vector[1]).sqrt();
    ([mean + radius, mean - radius], vector.map(|x| x / size))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_kernels::vec3::{add, cross, dot, length, normalize};

    /// A grid of n × n squares, each cut into two triangles, from 0 to 1 along x and y.
    fn grid(n: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let at = |i: u32| i as f32 / n as f32;
        let points = (0..=n).flat_map(|j| (0..=n).map(move |i| [at(i), at(j), 0.0])).collect();
        let cell = |i: u32, j: u32| {
            let a = j * (n + 1) + i;
            [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
        };
        let triangles = (0..n).flat_map(|j| (0..n).flat_map(move |i| cell(i, j))).collect();
        (points, triangles)
    }

    fn measured(rest: &[[f32; 3]], triangles: &[[u32; 3]], moved: &[[f32; 3]]) -> PrincipalStrains {
        let mut strains = PrincipalStrains::default();
        StrainGauge::new(rest, triangles).measure(moved, &mut strains);
        strains
    }

    fn map(points: &[[f32; 3]], to: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<[f32; 3]> {
        points.iter().map(|p| to(p.map(f64::from)).map(|x| x as f32)).collect()
    }

    /// Asserts that every vertex has these strains, along this line where it is given.
    fn assert_all(found: &PrincipalStrains, strains: [f64; 2], first: Option<[f64; 3]>, within: f64) {
        for (v, strain) in found.strains.iter().enumerate() {
            for (found, expected) in strain.iter().zip(strains) {
                assert!(
                    (f64::from(*found) - expected).abs() < within,
                    "vertex {v}: {strain:?}, expected {strains:?}"
                );
            }
            let [along, across] = [found.first[v], found.second[v]].map(|d| d.map(f64::from));
            assert!((length(along) - 1.0).abs() < 1e-6 && (length(across) - 1.0).abs() < 1e-6, "vertex {v}");
            assert!(dot(along, across).abs() < 1e-6, "vertex {v}: {along:?} {across:?}");
            if let Some(first) = first {
                assert!(
                    (dot(along, first).abs() - 1.0).abs() < 1e-5,
                    "vertex {v}: {along:?}, expected {first:?}"
                );
            }
        }
    }

    #[test]
    fn a_stretch_is_what_it_is_along_its_axes_in_any_pose() {
        let (rest, triangles) = grid(5);
        let stretched = map(&rest, |[x, y, z]| [0.8 * x, 1.3 * y, z]);
        assert_all(&measured(&rest, &triangles, &stretched), [0.3, -0.2], Some([0.0, 1.0, 0.0]), 1e-6);
        // Turned by 50° about an axis along none of the mesh's, and moved.
        let (sine, cosine) = 50.0_f64.to_radians().sin_cos();
        let axis = [2.0, 3.0, 6.0].map(|x| x / 7.0);
        let turned = |x: [f64; 3]| {
            let (aside, part) = (cross(axis, x), (1.0 - cosine) * dot(axis, x));
            [0, 1, 2].map(|c| cosine * x[c] + sine * aside[c] + part * axis[c])
        };
        let moved = map(&stretched, |x| add(turned(x), [0.3, -0.2, 1.0]));
        assert_all(&measured(&rest, &triangles, &moved), [0.3, -0.2], Some(turned([0.0, 1.0, 0.0])), 2e-6);
        assert_all(&measured(&rest, &triangles, &map(&rest, turned)), [0.0; 2], None, 2e-6);
    }

    /// Of a simple shear by γ the stretches are √(1 + γ²/4) ± γ/2, the larger along (λ₁, 1) after it.
    #[test]
    fn a_shear_has_its_closed_form() {
        let (rest, triangles) = grid(5);
        let gamma = 0.4;
        let sheared = map(&rest, |[x, y, z]| [x + gamma * y, y, z]);
        let [most, least] = [0.5, -0.5].map(|half| (1.0_f64 + gamma * gamma / 4.0).sqrt() + half * gamma);
        let first = normalize([most, 1.0, 0.0]);
        assert_all(&measured(&rest, &triangles, &sheared), [most - 1.0, least - 1.0], Some(first), 1e-6);
    }

    /// A ball of eight triangles, cut finer and finer.
    fn ball(cuts: usize) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let mut points: Vec<[f64; 3]> = vec![
            [1.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
        ];
        let mut triangles: Vec<[u32; 3]> =
            vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
        for _ in 0..cuts {
            let mut middles = std::collections::HashMap::new();
            let mut middle = |a: u32, b: u32| {
                *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                    points.push(normalize(add(points[a as usize], points[b as usize])));
                    points.len() as u32 - 1
                })
            };
            let cut = |[a, b, c]: [u32; 3]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            };
            triangles = triangles.into_iter().flat_map(cut).collect();
        }
        (points.iter().map(|p| p.map(|x| x as f32)).collect(), triangles)
    }

    #[test]
    fn an_inflated_ball_is_stretched_alike_in_all_directions() {
        let (rest, triangles) = ball(4);
        let inflated = map(&rest, |p| p.map(|x| 1.25 * x));
        assert_all(&measured(&rest, &triangles, &inflated), [0.25; 2], None, 1e-5);
        let areas: f64 = StrainGauge::new(&rest, &triangles).areas().sum();
        assert!((areas / (4.0 * std::f64::consts::PI) - 1.0).abs() < 0.01, "{areas}");
    }

    /// A ball is made k times as long along z. At the angle θ from the pole, the meridian is stretched by
    /// √(cos² θ + k² sin² θ), and the circle of latitude by 1.
    #[test]
    fn a_ball_made_longer_has_the_strains_of_its_meridians() {
        let (rest, triangles) = ball(5);
        let k = 1.4;
        let found = measured(&rest, &triangles, &map(&rest, |[x, y, z]| [x, y, k * z]));
        for (v, p) in rest.iter().enumerate() {
            let [x, y, z] = p.map(f64::from);
            let expected = [(z * z + k * k * (1.0 - z * z)).sqrt() - 1.0, 0.0];
            for (found, expected) in found.strains[v].iter().zip(expected) {
                assert!((f64::from(*found) - expected).abs() < 5e-3, "{p:?}: {found:?}, {expected}");
            }
            if expected[0] > 0.05 {
                let circle = normalize([-y, x, 0.0]);
                assert!(dot(found.second[v].map(f64::from), circle).abs() > 0.999, "{p:?}");
            }
        }
    }

    /// A surface that is bent without being stretched has no strain, except for the difference between its
    /// triangles and the surface.
    #[test]
    fn a_sheet_rolled_up_has_no_strain() {
        let (rest, triangles) = grid(40);
        let rolled = map(&rest, |[x, y, _]| [x.sin(), y, x.cos()]);
        assert_all(&measured(&rest, &triangles, &rolled), [0.0; 2], None, 2e-4);
        // Straightening it strains nothing either.
        assert_all(&measured(&rolled, &triangles, &rest), [0.0; 2], None, 2e-4);
    }

    #[test]
    fn what_has_no_area_has_no_strain() {
        let rest = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0], [9.0, 9.0, 9.0]];
        // The second triangle has no area. Vertex 3 is in no other triangle, and vertex 4 in none.
        let triangles = [[0, 1, 2], [0, 1, 3]];
        let moved = rest.map(|[x, y, z]| [2.0 * x, y, z]);
        let found = measured(&rest, &triangles, &moved);
        assert_eq!(found.strains, [[1.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0; 2], [0.0; 2]]);
        assert_eq!((found.first[0], found.first[3], found.second[4]), ([1.0, 0.0, 0.0], [0.0; 3], [0.0; 3]));
        // Crushed to a line, and to a point.
        let line = measured(&rest, &triangles, &rest.map(|[x, _, _]| [x, 0.0, 0.0]));
        assert_eq!((line.strains[2], line.second[2]), ([0.0, -1.0], [0.0; 3]));
        let point = measured(&rest, &triangles, &[[1.0; 3]; 5]);
        assert_eq!((point.strains[2], point.first[2]), ([-1.0; 2], [0.0; 3]));
    }
}
