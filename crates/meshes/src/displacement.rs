//! Displacement maps: an artist's wrinkles as an image, put onto a mesh.

use super::map_image::{MapImage, corner_uvs};
use glam::{DVec2, DVec3};
use rhytid_core::{Mesh, Result};
use std::path::Path;

/// A displacement map: of one number, along the normal; or of three, along the tangent (towards larger u),
/// the bitangent (towards larger v) and the normal. The middle grey moves nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplacementMap(MapImage);

impl DisplacementMap {
    /// Reads a PNG of 8 or 16 bits: grey ones are heights, coloured ones tangent-space vectors. Opacity is
    /// ignored.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Input`] if it is no such image; [`rhytid_core::Error::Io`].
    pub fn read(path: &Path) -> Result<Self> {
        MapImage::read(path).map(Self)
    }

    /// Moves a mesh's vertices, by `full` mesh units where the map is white. A vertex with several texture
    /// coordinates takes the mean of the map at them. Pixel centres have the values, and between them the map
    /// is linear. Vertices beyond the image stay, because other tiles (UDIM) move them. So do faces whose
    /// corners have one texture coordinate, as parts without any.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Input`] if the mesh has no texture coordinates.
    pub fn displace(&self, mesh: &mut Mesh, full: f64) -> Result<()> {
        let corner_uv = corner_uvs(mesh.uvs.as_ref())?;
        let vertices = mesh.positions.len();
        let mut values = vec![(DVec3::ZERO, 0.0_f64); vertices];
        // The surface's normal about each vertex, and where u and v grow, each triangle by its area.
        let mut frames = vec![[DVec3::ZERO; 3]; vertices];
        let mut first = 0;
        for (face, count) in mesh.faces.iter().zip(&mesh.faces.counts) {
            let corner = |i: usize| {
                (DVec3::from_array(mesh.positions[face[i] as usize]), corner_uv(first + i, face[i]))
            };
            // Parts without texture coordinates have their corners in one place.
            let is_placed = (1..face.len()).any(|i| corner(i).1 != corner(0).1);
            for (i, &vertex) in face.iter().enumerate() {
                let (sum, count) = &mut values[vertex as usize];
                if is_placed {
                    *sum += self.at(corner(i).1);
                    *count += 1.0;
                }
            }
            for i in 1..face.len().saturating_sub(1) {
                let [(a, p), (b, q), (c, r)] = [0, i, i + 1].map(corner);
                let (e, f, s, t) = (b - a, c - a, q - p, r - p);
                // Signed, so that a mirrored island's directions are right too.
                let sign = s.perp_dot(t).signum();
                let directions = [sign * (t.y * e - s.y * f), sign * (s.x * f - t.x * e), e.cross(f)];
                for vertex in [0, i, i + 1].map(|i| face[i] as usize) {
                    frames[vertex].iter_mut().zip(directions).for_each(|(sum, x)| *sum += x);
                }
            }
            first += *count as usize;
        }
        for (x, (frame, (sum, count))) in mesh.positions.iter_mut().zip(frames.iter().zip(values)) {
            let [u, v, n] = *frame;
            let n = n.normalize_or_zero();
            let [t, b] = [u, v].map(|along| (along - along.dot(n) * n).normalize_or_zero());
            let value = sum * (full / count.max(1.0));
            *x = (DVec3::from_array(*x) + value.x * t + value.y * b + value.z * n).to_array();
        }
        Ok(())
    }

    /// The map at texture coordinates: along tangent, bitangent and normal.
    fn at(&self, uv: DVec2) -> DVec3 {
        match (self.0.channels, self.0.at(uv)) {
            (1, [height, ..]) => DVec3::new(0.0, 0.0, height),
            (_, vector) => DVec3::from_array(vector),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::{Faces, Uvs};

    /// A unit square in the plane z = 0 of two quads, u along x and v along y.
    fn square() -> Mesh {
        let positions: Vec<[f64; 3]> =
            [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 1.0], [1.0, 1.0]]
                .map(|[x, y]| [x, y, 0.0])
                .into();
        let values = positions.iter().map(|x| [x[0] as f32, x[1] as f32]).collect();
        let faces = Faces { counts: vec![4, 4], indices: vec![0, 1, 4, 3, 1, 2, 5, 4] };
        Mesh { positions, faces, uvs: Some(Uvs { values, corners: None }), ..Mesh::default() }
    }

    fn png(colour: png::ColorType, depth: png::BitDepth, size: [u32; 2], bytes: &[u8]) -> tempfile::TempPath {
        let file = tempfile::Builder::new().suffix(".png").tempfile().unwrap();
        let mut encoder = png::Encoder::new(file.as_file(), size[0], size[1]);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        encoder.write_header().unwrap().write_image_data(bytes).unwrap();
        file.into_temp_path()
    }

    #[test]
    fn heights_go_along_the_normal_and_are_linear_between_pixels() {
        // 2 × 2 of 16 bits: black and white above, mid grey twice below.
        let pixels: Vec<u8> = [0u16, 65_535, 32_767, 32_768].iter().flat_map(|x| x.to_be_bytes()).collect();
        let path = png(png::ColorType::Grayscale, png::BitDepth::Sixteen, [2, 2], &pixels);
        let mut mesh = square();
        DisplacementMap::read(&path).unwrap().displace(&mut mesh, 0.2).unwrap();
        let heights: Vec<f64> = mesh.positions.iter().map(|x| x[2]).collect();
        for (found, expected) in heights.iter().zip([0.0, 0.0, 0.0, -0.2, 0.0, 0.2]) {
            assert!((found - expected).abs() < 1e-6, "{heights:?}");
        }
        assert!(mesh.positions.iter().zip(square().positions).all(|(a, b)| a[..2] == b[..2]));
    }

    #[test]
    fn vectors_go_along_tangent_bitangent_and_normal() {
        let path = png(png::ColorType::Rgb, png::BitDepth::Eight, [1, 1], &[255, 0, 191]);
        let mut mesh = square();
        DisplacementMap::read(&path).unwrap().displace(&mut mesh, 2.0).unwrap();
        for (found, before) in mesh.positions.iter().zip(square().positions) {
            let expected = [before[0] + 2.0, before[1] - 2.0, 2.0 * 63.0 / 127.0];
            assert!((0..3).all(|c| (found[c] - expected[c]).abs() < 1e-6), "{found:?}, {expected:?}");
        }
    }

    #[test]
    fn other_tiles_stay() {
        let path = png(png::ColorType::Grayscale, png::BitDepth::Eight, [1, 1], &[255]);
        let mut mesh = square();
        mesh.uvs.as_mut().unwrap().values.iter_mut().for_each(|uv| uv[0] += 0.75);
        DisplacementMap::read(&path).unwrap().displace(&mut mesh, 1.0).unwrap();
        let heights: Vec<f64> = mesh.positions.iter().map(|x| x[2]).collect();
        assert_eq!(heights, [1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    }

    #[test]
    fn parts_without_texture_coordinates_stay() {
        let path = png(png::ColorType::Grayscale, png::BitDepth::Eight, [1, 1], &[255]);
        let mut mesh = square();
        // The second quad has none. The two vertices between take the map of the first.
        let uvs = mesh.uvs.as_mut().unwrap();
        uvs.values.push([0.0, 0.0]);
        uvs.corners = Some(vec![0, 1, 4, 3, 6, 6, 6, 6]);
        DisplacementMap::read(&path).unwrap().displace(&mut mesh, 1.0).unwrap();
        let heights: Vec<f64> = mesh.positions.iter().map(|x| x[2]).collect();
        assert_eq!(heights, [1.0, 1.0, 0.0, 1.0, 1.0, 0.0]);
    }

    #[test]
    fn what_is_no_map_is_said() {
        let file = tempfile::Builder::new().suffix(".png").tempfile().unwrap();
        std::fs::write(file.path(), "no image").unwrap();
        let error = DisplacementMap::read(file.path()).unwrap_err().to_string();
        assert!(error.contains("is no PNG that can be read"), "{error}");
        let path = png(png::ColorType::Grayscale, png::BitDepth::Eight, [1, 1], &[7]);
        let mut mesh = square();
        mesh.uvs = None;
        let error = DisplacementMap::read(&path).unwrap().displace(&mut mesh, 1.0).unwrap_err();
        assert!(error.to_string().contains("no texture coordinates"), "{error}");
    }
}
