//! A shaded picture of a mesh: a depth buffer, since that is right for folded surfaces at any number of triangles, where a plotting
//! library's polygons are drawn in whole pixels, one over the other.

use crate::camera::Camera;
use rhytid_core::{Error, Result};

/// Each pixel is the mean of this many by this many.
const FINE: usize = 2;

/// The mesh, lit, what is not covered transparent.
pub(crate) struct Raster {
    size: [usize; 2],
    /// Red, green, blue and opacity of each pixel.
    pixels: Vec<[u8; 4]>,
    /// How near the surface is to the viewer at each fine pixel, in pixels.
    depth: Vec<f32>,
}

impl Raster {
    /// Draws `triangles` over `points` as `camera` sees them, in white.
    pub(crate) fn new(camera: &Camera, points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        Self::coloured(camera, points, triangles, &vec![[1.0; 3]; points.len()])
    }

    /// The same with a colour for each point, red, green and blue from 0 to 1.
    pub(crate) fn coloured(
        camera: &Camera,
        points: &[[f32; 3]],
        triangles: &[[u32; 3]],
        colours: &[[f32; 3]],
    ) -> Self {
        let seen: Vec<[f32; 3]> = (points.iter())
            .map(|p| camera.project(p.map(f64::from)).map(|x| (x * FINE as f64) as f32))
            .collect();
        let normals = normals(camera, points, triangles);
        let [width, height] = camera.size.map(|n| n * FINE);
        let mut fine = Fine {
            width,
            height,
            depth: vec![f32::NEG_INFINITY; width * height],
            light: vec![[0.0; 3]; width * height],
        };
        for triangle in triangles {
            let corners = triangle.map(|v| seen[v as usize]);
            let of_corners = triangle.map(|v| (normals[v as usize], colours[v as usize]));
            fine.triangle(corners, of_corners);
        }
        let depth = fine.depth.iter().map(|d| d / FINE as f32).collect();
        Self { size: camera.size, pixels: fine.mean(camera.size), depth }
    }

    /// Whether a projected point is on the surface or before it, allowing for `slack` pixels.
    pub(crate) fn shows(&self, [x, y, toward]: [f64; 3], slack: f64) -> bool {
        let [column, row] = [x, y].map(|c| (c * FINE as f64).floor());
        let inside = |at: f64, n: usize| at >= 0.0 && at < (n * FINE) as f64;
        if !inside(column, self.size[0]) || !inside(row, self.size[1]) {
            return true;
        }
        let depth = self.depth[row as usize * self.size[0] * FINE + column as usize];
        toward + slack >= f64::from(depth)
    }

    /// Draws a dot over the picture, of `radius` pixels.
    pub(crate) fn dot(&mut self, [x, y, _]: [f64; 3], radius: f64, colour: [u8; 3]) {
        let [width, height] = self.size;
        for row in 0..height {
            for column in 0..width {
                let off = (column as f64 + 0.5 - x).hypot(row as f64 + 0.5 - y);
                if off <= radius {
                    // A dark rim tells dots on light and on dark skin.
                    let shade = if off > radius - 1.2 { 3 } else { 1 };
                    self.pixels[row * width + column] =
                        [colour[0] / shade, colour[1] / shade, colour[2] / shade, 255];
                }
            }
        }
    }

    /// Pictures of one height beside each other.
    pub(crate) fn side_by_side(rasters: &[Self]) -> Self {
        let height = rasters.first().map_or(0, |raster| raster.size[1]);
        let rows = (0..height).flat_map(|row| {
            rasters.iter().flat_map(move |raster| &raster.pixels[row * raster.size[0]..][..raster.size[0]])
        });
        let pixels = rows.copied().collect();
        let width = rasters.iter().map(|raster| raster.size[0]).sum();
        Self { size: [width, height], pixels, depth: Vec::new() }
    }

    /// The picture as a PNG file.
    ///
    /// # Errors
    /// [`Error::Internal`] if the encoder refuses.
    pub(crate) fn png(&self) -> Result<Vec<u8>> {
        let failed = |e: png::EncodingError| Error::Internal(format!("the picture of the mesh: {e}"));
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.size[0] as u32, self.size[1] as u32);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().map_err(failed)?;
        writer.write_image_data(self.pixels.as_flattened()).map_err(failed)?;
        writer.finish().map_err(failed)?;
        Ok(bytes)
    }
}

/// The vertices' normals as the camera turns them; of length 1 but for those that no triangle has.
fn normals(camera: &Camera, points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let turned: Vec<[f32; 3]> =
        points.iter().map(|p| camera.turn(p.map(f64::from)).map(|x| x as f32)).collect();
    let mut normals = vec![[0.0_f32; 3]; points.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| turned[v as usize]);
        let [u, v] = [b, c].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        for &vertex in triangle {
            let sum = &mut normals[vertex as usize];
            *sum = [sum[0] + n[0], sum[1] + n[1], sum[2] + n[2]];
        }
    }
    for n in &mut normals {
        let length = n.iter().map(|x| x * x).sum::<f32>().sqrt();
        if length > 0.0 {
            *n = n.map(|x| x / length);
        }
    }
    normals
}

/// How bright skin of this normal is, 0 to 1: a lamp at the upper left, a weak one at the right, and a sky.
fn brightness(n: [f32; 3]) -> f32 {
    let lamp = |from: [f32; 3]| (n[0] * from[0] + n[1] * from[1] + n[2] * from[2]).max(0.0);
    let (key, fill) = (lamp([-0.45, 0.55, 0.7]), lamp([0.8, 0.0, 0.6]));
    (0.26 + 0.08 * n[1] + 0.58 * key + 0.2 * fill).clamp(0.0, 1.0)
}

struct Fine {
    width: usize,
    height: usize,
    depth: Vec<f32>,
    light: Vec<[f32; 3]>,
}

impl Fine {
    /// Draws a triangle, of the corners' places and their normals and colours.
    fn triangle(&mut self, [a, b, c]: [[f32; 3]; 3], corners: [([f32; 3], [f32; 3]); 3]) {
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if !(area.is_finite() && area != 0.0) {
            return;
        }
        // Rows count downwards, so a triangle that faces the viewer has a negative area; its inside is darker.
        let (side, dim) = if area < 0.0 { (1.0, 1.0) } else { (-1.0, 0.55) };
        let lit = corners.map(|(n, colour)| colour.map(|part| part * dim * brightness(n.map(|x| side * x))));
        let range = |axis: usize, n: usize| {
            let least = a[axis].min(b[axis]).min(c[axis]).floor().max(0.0);
            let greatest = a[axis].max(b[axis]).max(c[axis]).ceil().min(n as f32);
            least as usize..greatest.max(0.0) as usize
        };
        for row in range(1, self.height) {
            for column in range(0, self.width) {
                let (x, y) = (column as f32 + 0.5, row as f32 + 0.5);
                let u = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area;
                let v = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area;
                if u < 0.0 || v < 0.0 || u + v > 1.0 {
                    continue;
                }
                let mix = |p: f32, q: f32, r: f32| p + u * (q - p) + v * (r - p);
                let depth = mix(a[2], b[2], c[2]);
                let at = row * self.width + column;
                if depth > self.depth[at] {
                    self.depth[at] = depth;
                    self.light[at] = [0, 1, 2].map(|part| mix(lit[0][part], lit[1][part], lit[2][part]));
                }
            }
        }
    }

    /// The means of blocks of fine pixels.
    fn mean(&self, [width, height]: [usize; 2]) -> Vec<[u8; 4]> {
        let pixel = |at: usize| {
            let (row, column) = (at / width * FINE, at % width * FINE);
            let (mut covered, mut light) = (0.0, [0.0; 3]);
            for y in row..row + FINE {
                for x in column..column + FINE {
                    if self.depth[y * self.width + x] > f32::NEG_INFINITY {
                        covered += 1.0;
                        let fine = self.light[y * self.width + x];
                        light = [0, 1, 2].map(|part| light[part] + fine[part]);
                    }
                }
            }
            let opacity = covered / (FINE * FINE) as f32;
            let [red, green, blue] = light.map(|part| (255.0 * part / covered.max(1.0)) as u8);
            [red, green, blue, (255.0 * opacity) as u8]
        };
        (0..width * height).map(pixel).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::UpAxis;

    /// A large square at z = 0 and a small one before it at z = 1, both facing +Z.
    fn squares() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let square = |r: f32, z: f32| [[-r, -r, z], [r, -r, z], [r, r, z], [-r, r, z]];
        let points = [square(2.0, 0.0), square(0.5, 1.0)].concat();
        // The nearer first: with the painter's order it would be lost.
        (points, vec![[4, 5, 6], [4, 6, 7], [0, 1, 2], [0, 2, 3]])
    }

    #[test]
    fn what_is_nearer_hides_what_is_behind() {
        let (points, triangles) = squares();
        let world = |p: &[f32; 3]| p.map(f64::from);
        let camera = Camera::new(UpAxis::Y, 0.0, [70, 70], points.iter().map(world));
        let raster = Raster::new(&camera, &points, &triangles);
        let at = |x: f64, y: f64, z: f64| raster.shows(camera.project([x, y, z]), 0.1);
        assert!(at(0.0, 0.0, 1.0) && !at(0.0, 0.0, 0.0), "behind the small square");
        assert!(at(1.0, 1.0, 0.0) && !at(1.0, 1.0, -0.5), "behind the large square");
        assert!(at(5.0, 0.0, -9.0), "beside the picture nothing hides it");
        // 4 units wide in 70 pixels with the margin: the square's 50 pixels are opaque, the corners are empty.
        let opaque = raster.pixels.iter().filter(|p| p[3] == 255).count();
        assert_eq!((opaque, raster.pixels[0]), (2500, [0; 4]));
    }

    #[test]
    fn the_inside_is_darker() {
        let (points, mut triangles) = squares();
        let camera = Camera::new(UpAxis::Y, 0.0, [70, 70], points.iter().map(|p| p.map(f64::from)));
        let grey = |triangles: &[[u32; 3]]| Raster::new(&camera, &points, triangles).pixels[20 * 70 + 20][0];
        let front = grey(&triangles);
        for triangle in &mut triangles {
            triangle.swap(1, 2);
        }
        assert!(f32::from(grey(&triangles)) < 0.6 * f32::from(front), "{front}");
    }
}
