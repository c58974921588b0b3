//! Tangent-space normal maps: an artist's wrinkles as the directions of a surface. The surface itself is
//! found from them.

use super::map_image::{MapImage, corner_uvs};
use glam::{DVec2, DVec3};
use rhytid_core::{Error, Mesh, Result};
use rhytid_geometry::laplacian::{Laplacian, is_degenerate, laplacian};
use serde::Serialize;
use std::path::Path;

/// Slopes above this, which are steeper than 84°, do not occur on skin.
const STEEPEST: f64 = 10.0;

/// Heights are held near 0 over this part of the mesh's diagonal, because a map of slopes does not tell how
/// far out a whole face is.
const WIDE: f64 = 0.5;

/// A triangle's slope is the mean of as many rows of samples as it has pixels, but of at most so many.
const ROWS: usize = 16;

/// Conjugate gradients end when the residual is this part of the first one, or after so many steps.
const LEFT: f64 = 1e-8;
const STEPS: usize = 4000;

/// A tangent-space normal map. Red is the part of the normal along the tangent (towards larger u), and green
/// the part along the bitangent. Blue follows from them and is ignored.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalMap(MapImage);

/// Which way green points in a tangent-space normal map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum NormalMapConvention {
    /// Towards larger v, as in OpenGL.
    #[default]
    Up,
    /// Away from larger v, as in DirectX.
    Down,
}

impl NormalMapConvention {
    /// The other one.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Up => Self::Down,
            Self::Down => Self::Up,
        }
    }
}

/// What [`NormalMap::displace`] found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Integrated {
    /// The largest height, inwards or outwards, in mesh units.
    pub highest: f64,
    /// The RMS of the slopes that no surface can have, as a part of the RMS of the map's slopes. It is near 0
    /// for a map that was made of a surface and is coarse beside the mesh. It is larger if green points the
    /// other way.
    pub left: f64,
}

impl NormalMap {
    /// Reads a coloured PNG of 8 or 16 bits. Opacity is ignored.
    ///
    /// # Errors
    /// [`Error::Input`] if it is no such image; [`Error::Io`].
    pub fn read(path: &Path) -> Result<Self> {
        let image = MapImage::read(path)?;
        if image.channels < 3 {
            return Err(Error::unsupported_format(format!(
                "{}: is grey, expected a tangent-space normal map, which is coloured; a map of heights is a displacement",
                path.display()
            )));
        }
        Ok(Self(image))
    }

    /// Moves a mesh's vertices along their normals, so that its slopes are as near as possible to the map's
    /// slopes times `strength`, a ratio.
    ///
    /// The heights h minimise `∫ |∇h − g|² + h² / w²` over the surface. g are the slopes of the map, the mean
    /// over each triangle, and w is half of the mesh's diagonal. That is `(−C + M / w²) h = b` with the
    /// Laplacian of section 1 and `b_v = ∫ ∇φ_v · g` (a screened Poisson equation). Seams of the texture
    /// coordinates do not matter.
    ///
    /// # Errors
    /// [`Error::Input`] if the mesh has no texture coordinates.
    pub fn displace(&self, mesh: &mut Mesh, green: NormalMapConvention, strength: f64) -> Result<Integrated> {
        let corner_uv = corner_uvs(mesh.uvs.as_ref())?;
        let at = |v: u32| DVec3::from_array(mesh.positions[v as usize]);
        let mut triangles = Vec::new();
        let mut slopes = Vec::new();
        let mut normals = vec![DVec3::ZERO; mesh.positions.len()];
        let mut first = 0;
        for (face, count) in mesh.faces.iter().zip(&mesh.faces.counts) {
            for i in 1..face.len().saturating_sub(1) {
                let corners = [0, i, i + 1];
                let triangle = corners.map(|i| face[i]);
                let points = triangle.map(at);
                if is_degenerate(points) {
                    continue;
                }
                let [a, b, c] = points;
                triangle.iter().for_each(|&v| normals[v as usize] += (b - a).cross(c - a));
                triangles.push(triangle);
                slopes.push(self.slope(points, corners.map(|i| corner_uv(first + i, face[i])), green));
            }
            first += *count as usize;
        }
        let mut divergence = vec![0.0; mesh.positions.len()];
        for (triangle, slope) in triangles.iter().zip(&slopes) {
            for (v, gradient) in triangle.iter().zip(gradients(triangle.map(at))) {
                divergence[*v as usize] += gradient.dot(*slope);
            }
        }
        let low = mesh.positions.iter().fold(DVec3::INFINITY, |low, p| low.min(DVec3::from_array(*p)));
        let high = mesh.positions.iter().fold(DVec3::NEG_INFINITY, |high, p| high.max(DVec3::from_array(*p)));
        let wide = WIDE * high.distance(low);
        let heights = solve(&laplacian(&mesh.positions, &triangles), wide, &divergence);
        let (mut all, mut left) = (0.0, 0.0);
        for (triangle, slope) in triangles.iter().zip(&slopes) {
            let [a, b, c] = triangle.map(at);
            let area = 0.5 * (b - a).cross(c - a).length();
            let found = triangle.iter().zip(gradients([a, b, c]));
            let found: DVec3 = found.map(|(&v, gradient)| gradient * (heights[v as usize] / area)).sum();
            all += area * slope.length_squared();
            left += area * (found - *slope).length_squared();
        }
        for ((x, normal), height) in mesh.positions.iter_mut().zip(normals).zip(&heights) {
            *x = (DVec3::from_array(*x) + strength * height * normal.normalize_or_zero()).to_array();
        }
        Ok(Integrated {
            highest: strength.abs() * heights.iter().map(|h| h.abs()).fold(0.0, f64::max),
            left: if all > 0.0 { (left / all).sqrt() } else { 0.0 },
        })
    }

    /// The mean slope over a triangle, in its plane: how far the surface rises by length, and which way.
    fn slope(&self, [a, b, c]: [DVec3; 3], [p, q, r]: [DVec2; 3], green: NormalMapConvention) -> DVec3 {
        let upwards = if green == NormalMapConvention::Up { 1.0 } else { -1.0 };
        let (e, f, s, t) = (b - a, c - a, q - p, r - p);
        let size = DVec2::new(self.0.width as f64, self.0.height as f64);
        let longest = [s, t, t - s].map(|edge| (edge * size).length()).into_iter().fold(0.0, f64::max);
        let rows = (longest.ceil() as usize).clamp(1, ROWS);
        let (mut sum, mut count) = (DVec2::ZERO, 0.0);
        for i in 0..rows {
            for j in 0..rows - i {
                let place = |k: usize| (k as f64 + 1.0 / 3.0) / rows as f64;
                let [x, y, _] = self.0.at(p + place(i) * s + place(j) * t);
                let y = upwards * y;
                let z = (1.0 - x * x - y * y).max(0.0).sqrt();
                sum += DVec2::new(-x, -y) / z.max(x.hypot(y) / STEEPEST).max(1e-9);
                count += 1.0;
            }
        }
        let mean = sum / count;
        let area = s.perp_dot(t);
        if area == 0.0 {
            return DVec3::ZERO;
        }
        let n = e.cross(f).normalize_or_zero();
        let tangent = (area.signum() * (t.y * e - s.y * f)).normalize_or_zero();
        // Where an island is mirrored, v grows to the tangent's other side.
        let bitangent = area.signum() * n.cross(tangent);
        mean.x * tangent + mean.y * bitangent
    }
}

/// The gradients of a triangle's three hat functions, times its area.
fn gradients([a, b, c]: [DVec3; 3]) -> [DVec3; 3] {
    let n = (b - a).cross(c - a).normalize_or_zero();
    [c - b, a - c, b - a].map(|opposite| 0.5 * n.cross(opposite))
}

/// Solves `(−C + M / w²) h = b` by conjugate gradients with Jacobi preconditioning; 0 at a vertex without a
/// triangle.
fn solve(laplacian: &Laplacian, wide: f64, b: &[f64]) -> Vec<f64> {
    let screen: Vec<f64> = laplacian.mass.iter().map(|mass| mass / (wide * wide)).collect();
    let diagonal: Vec<f64> = laplacian.diagonal.iter().zip(&screen).map(|(c, m)| m - c).collect();
    let apply = |x: &[f64]| {
        let mut out: Vec<f64> = diagonal.iter().zip(x).map(|(d, x)| d * x).collect();
        for &(i, j, w) in &laplacian.edges {
            out[i as usize] -= w * x[j as usize];
            out[j as usize] -= w * x[i as usize];
        }
        out
    };
    let scaled = |r: &[f64]| -> Vec<f64> {
        r.iter().zip(&diagonal).map(|(r, d)| if *d > 0.0 { r / d } else { 0.0 }).collect()
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let add = |x: &mut [f64], by: f64, y: &[f64]| x.iter_mut().zip(y).for_each(|(x, y)| *x += by * y);
    let (mut h, mut r) = (vec![0.0; b.len()], b.to_vec());
    let mut z = scaled(&r);
    let mut direction = z.clone();
    let mut now = dot(&r, &z);
    let enough = LEFT * LEFT * now;
    for _ in 0..STEPS {
        if now <= enough {
            break;
        }
        let applied = apply(&direction);
        let step = now / dot(&direction, &applied);
        add(&mut h, step, &direction);
        add(&mut r, -step, &applied);
        z = scaled(&r);
        let next = dot(&r, &z);
        let share = next / now;
        direction.iter_mut().zip(&z).for_each(|(d, z)| *d = z + share * *d);
        now = next;
    }
    h
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::{Faces, Uvs};
    use std::f64::consts::TAU;

    const N: usize = 48;
    const PIXELS: usize = 256;

    /// A bump in the middle of texture coordinates from 0 to 1. Returns its height in units of the sheet's
    /// width, and its slopes by u and v.
    fn bump(u: f64, v: f64) -> [f64; 3] {
        let part = |x: f64| {
            let t = ((x - 0.2) / 0.6).clamp(0.0, 1.0);
            (
                0.5 - 0.5 * (TAU * t).cos(),
                if t > 0.0 && t < 1.0 { 0.5 * TAU * (TAU * t).sin() / 0.6 } else { 0.0 },
            )
        };
        let ((f, df), (g, dg)) = (part(u), part(v));
        [0.03 * f * g, 0.03 * df * g, 0.03 * f * dg]
    }

    /// The bump's normals as an image, of 16 bits, for a sheet that is `long` units in u.
    fn image(green: NormalMapConvention, long: f64) -> tempfile::TempPath {
        let upwards = if green == NormalMapConvention::Up { 1.0 } else { -1.0 };
        let mut bytes = Vec::new();
        for y in 0..PIXELS {
            for x in 0..PIXELS {
                let at = |i: usize| (i as f64 + 0.5) / PIXELS as f64;
                let [_, du, dv] = bump(at(x), 1.0 - at(y));
                let n = DVec3::new(-du / long, -upwards * dv, 1.0).normalize();
                for c in n.to_array() {
                    bytes.extend((((c + 1.0) * 0.5 * 65_535.0).round() as u16).to_be_bytes());
                }
            }
        }
        let file = tempfile::Builder::new().suffix(".png").tempfile().unwrap();
        let mut encoder = png::Encoder::new(file.as_file(), PIXELS as u32, PIXELS as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Sixteen);
        encoder.write_header().unwrap().write_image_data(&bytes).unwrap();
        file.into_temp_path()
    }

    /// A sheet with u along it and v across, as `place` has it; its vertices' texture coordinates. In
    /// `mirrored` the triangles and u go the other way.
    fn sheet(place: impl Fn(f64, f64) -> [f64; 3], mirrored: bool) -> (Mesh, Vec<[f64; 2]>) {
        let uvs: Vec<[f64; 2]> = (0..(N + 1) * (N + 1))
            .map(|i| [(i % (N + 1)) as f64 / N as f64, (i / (N + 1)) as f64 / N as f64])
            .collect();
        let mut faces = Faces::default();
        for j in 0..N {
            for i in 0..N {
                let a = (j * (N + 1) + i) as u32;
                let mut quad = [a, a + 1, a + N as u32 + 2, a + N as u32 + 1];
                if mirrored {
                    quad.reverse();
                }
                faces.push(&quad);
            }
        }
        let values = uvs.iter().map(|uv| uv.map(|x| x as f32)).collect();
        let positions = uvs.iter().map(|[u, v]| place(*u, *v)).collect();
        (Mesh { positions, faces, uvs: Some(Uvs { values, corners: None }), ..Mesh::default() }, uvs)
    }

    /// How far heights are from the bump's, as a part of its own; but for a height of all of the sheet.
    fn off(heights: &[f64], uvs: &[[f64; 2]]) -> f64 {
        let expected: Vec<f64> = uvs.iter().map(|[u, v]| bump(*u, *v)[0]).collect();
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let by = mean(heights) - mean(&expected);
        let off = heights.iter().zip(&expected).map(|(h, e)| (h - by - e).abs()).fold(0.0, f64::max);
        off / 0.03
    }

    #[test]
    fn the_surface_that_has_the_slopes_is_found() {
        let radius = 0.5;
        let flat = |u: f64, v: f64| [u, v, 0.0];
        // A cylinder's outside, two radians of it, as long as the sheet is wide.
        let bent = |u: f64, v: f64| {
            let turn = u / radius;
            [radius * turn.sin(), v, radius * turn.cos()]
        };
        for (name, place, mirrored) in [
            ("flat", &flat as &dyn Fn(f64, f64) -> [f64; 3], false),
            ("bent", &bent, false),
            ("mirrored", &flat, true),
        ] {
            let (before, uvs) = sheet(place, mirrored);
            for green in [NormalMapConvention::Up, NormalMapConvention::Down] {
                let map = NormalMap::read(&image(green, 1.0)).unwrap();
                let mut mesh = before.clone();
                let found = map.displace(&mut mesh, green, 1.0).unwrap();
                let outwards = |i: usize| match name {
                    "bent" => DVec3::new(before.positions[i][0], 0.0, before.positions[i][2]).normalize(),
                    "mirrored" => -DVec3::Z,
                    _ => DVec3::Z,
                };
                let height = |i: usize| {
                    let [a, b] = [&mesh, &before].map(|mesh| DVec3::from_array(mesh.positions[i]));
                    (a - b).dot(outwards(i))
                };
                let heights: Vec<f64> = (0..uvs.len()).map(height).collect();
                assert!(off(&heights, &uvs) < 0.04, "{name}, {green:?}: {}", off(&heights, &uvs));
                assert!(found.left < 0.1, "{name}, {green:?}: {}", found.left);
                // Twice the strength gives twice the height.
                let mut twice = before.clone();
                let doubled = map.displace(&mut twice, green, 2.0).unwrap();
                assert!((doubled.highest - 2.0 * found.highest).abs() < 1e-9);
                // Read with the other direction of green, the map is no surface.
                let left = map.displace(&mut before.clone(), green.other(), 1.0).unwrap().left;
                assert!(left > 0.5, "{name}, {green:?}, read the other way: {left}");
            }
        }
    }

    /// A sheet that is twice as long has half of the slopes for the same heights. Slopes are by length on the
    /// mesh, not by texture coordinates.
    #[test]
    fn lengths_are_the_meshs() {
        let (mut mesh, uvs) = sheet(|u, v| [2.0 * u, v, 0.0], false);
        NormalMap::read(&image(NormalMapConvention::Up, 2.0))
            .unwrap()
            .displace(&mut mesh, NormalMapConvention::Up, 1.0)
            .unwrap();
        let heights: Vec<f64> = mesh.positions.iter().map(|x| x[2]).collect();
        assert!(off(&heights, &uvs) < 0.04, "{}", off(&heights, &uvs));
    }

    #[test]
    fn a_flat_map_moves_nothing() {
        let file = tempfile::Builder::new().suffix(".png").tempfile().unwrap();
        let mut encoder = png::Encoder::new(file.as_file(), 1, 1);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header().unwrap().write_image_data(&[128, 128, 255]).unwrap();
        let (mut mesh, _) = sheet(|u, v| [u, v, 0.0], false);
        let before = mesh.clone();
        let found =
            NormalMap::read(file.path()).unwrap().displace(&mut mesh, NormalMapConvention::Up, 1.0).unwrap();
        assert_eq!((mesh, found), (before, Integrated { highest: 0.0, left: 0.0 }));
    }
}
