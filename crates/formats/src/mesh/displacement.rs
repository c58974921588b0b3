//! Displacement maps: an artist's wrinkles as an image, put onto a mesh.

use glam::{DVec2, DVec3};
use rhytid_core::{Error, Mesh, Result, input_file};
use std::io::Cursor;
use std::path::Path;

/// A displacement map: rows of pixels from the top, where the middle grey moves nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplacementMap {
    width: usize,
    height: usize,
    /// Numbers of each pixel: 1, along the normal; or 3, along the tangent (towards larger u), the bitangent (towards larger v) and the normal.
    channels: usize,
    /// −1 for black to 1 for white.
    values: Vec<f32>,
}

impl DisplacementMap {
    /// Reads a PNG of 8 or 16 bits: grey ones are heights, coloured ones tangent-space vectors. Opacity is ignored.
    ///
    /// # Errors
    /// [`Error::Input`] if it is no such image; [`Error::Io`].
    pub fn read(path: &Path) -> Result<Self> {
        let fault = |what: String| Error::Input(format!("{}: {what}", path.display()));
        let no_png = |e: png::DecodingError| {
            fault(format!("is no PNG that can be read ({e}); save the map as PNG, grey or RGB, of 16 bits"))
        };
        let bytes = input_file::read(path, input_file::LARGEST_MESH_OR_TAKE)?;
        let mut decoder = png::Decoder::new(Cursor::new(bytes));
        // Palettes and fewer bits become whole bytes.
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().map_err(no_png)?;
        let size = reader.output_buffer_size().ok_or_else(|| fault("is too large".into()))?;
        let mut pixels = vec![0; size];
        let info = reader.next_frame(&mut pixels).map_err(no_png)?;
        let (all, channels) = match info.color_type {
            png::ColorType::Grayscale => (1, 1),
            png::ColorType::GrayscaleAlpha => (2, 1),
            png::ColorType::Rgba => (4, 3),
            _ => (3, 3),
        };
        let numbers: Vec<f32> = match info.bit_depth {
            png::BitDepth::Sixteen => pixels
                .as_chunks::<2>()
                .0
                .iter()
                .map(|b| signed(u16::from_be_bytes(*b).into(), 65_535))
                .collect(),
            _ => pixels.iter().map(|&b| signed(b.into(), 255)).collect(),
        };
        let values = numbers.chunks_exact(all).flat_map(|pixel| pixel[..channels].iter().copied());
        let (width, height) = (info.width as usize, info.height as usize);
        Ok(Self { width, height, channels, values: values.collect() })
    }

    /// Moves a mesh's vertices: by `full` mesh units where the map is white. A vertex with several texture coordinates takes the mean of the map there. Between
    /// pixels, whose centres have the values, it is linear; beyond the image its border goes on.
    ///
    /// # Errors
    /// [`Error::Input`] if the mesh has no texture coordinates.
    pub fn displace(&self, mesh: &mut Mesh, full: f64) -> Result<()> {
        let Some(uvs) = &mesh.uvs else {
            return Err(Error::input("has no texture coordinates, which a displacement map needs"));
        };
        let vertices = mesh.positions.len();
        let corner_uv = |corner: usize, vertex: u32| {
            let at = uvs.corners.as_ref().map_or(vertex, |corners| corners[corner]);
            DVec2::from_array(uvs.values[at as usize].map(f64::from))
        };
        let mut values = vec![(DVec3::ZERO, 0.0_f64); vertices];
        // The surface's normal about each vertex, and where u and v grow, each triangle by its area.
        let mut frames = vec![[DVec3::ZERO; 3]; vertices];
        let mut first = 0;
        for (face, count) in mesh.faces.iter().zip(&mesh.faces.counts) {
            let corner = |i: usize| {
                (DVec3::from_array(mesh.positions[face[i] as usize]), corner_uv(first + i, face[i]))
            };
            for (i, &vertex) in face.iter().enumerate() {
                let (sum, count) = &mut values[vertex as usize];
                *sum += self.at(corner(i).1);
                *count += 1.0;
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

    /// The map at texture coordinates, of which v points up: along tangent, bitangent and normal.
    fn at(&self, uv: DVec2) -> DVec3 {
        let place = |x: f64, size: usize| {
            let x = (x * size as f64 - 0.5).clamp(0.0, (size - 1) as f64);
            let low = x.floor() as usize;
            (low, (low + 1).min(size - 1), x - x.floor())
        };
        let ((x0, x1, s), (y0, y1, t)) = (place(uv.x, self.width), place(1.0 - uv.y, self.height));
        let pixel = |x: usize, y: usize, channel: usize| {
            f64::from(self.values[(y * self.width + x) * self.channels + channel])
        };
        let between = |channel: usize| {
            let row = |y: usize| (1.0 - s) * pixel(x0, y, channel) + s * pixel(x1, y, channel);
            (1.0 - t) * row(y0) + t * row(y1)
        };
        match self.channels {
            1 => DVec3::new(0.0, 0.0, between(0)),
            _ => DVec3::new(between(0), between(1), between(2)),
        }
    }
}

/// −1 to 1 from 0 to `most`; both numbers in its middle are 0, so that a flat map moves nothing.
fn signed(value: u32, most: u32) -> f32 {
    let middle = most / 2;
    match value {
        v if v <= middle => -((middle - v) as f32) / middle as f32,
        v => (v - middle - 1) as f32 / middle as f32,
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
