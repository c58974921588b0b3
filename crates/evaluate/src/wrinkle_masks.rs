//! Masks of wrinkles: the activation of the wrinkles of each example, as pictures over a mesh's texture
//! coordinates and as curves over time.

use rayon::prelude::*;
use rhytid_core::channel::Channel;
use rhytid_core::{AtomicFile, ChannelKind, Error, Result, Rig};
use rhytid_formats::export::Frame;
use rhytid_formats::tables;
use rhytid_geometry::StrainGauge;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

/// So many texels around a mesh's charts repeat the closest texel of the chart. Filtering and mipmaps then
/// take nothing from outside.
const GUTTER: usize = 8;

/// If a wrinkle is never activated beyond this, its mask is black.
const NOTHING: f32 = 0.01;

/// Masks and curves of the channels of [`ChannelKind::Wrinkles`], collected frame after frame.
///
/// A picture has a cell for each channel, `⌈√n⌉` to a row, in their order from the top left. In a cell, u
/// goes to the right and v upwards, as in a texture. A mesh whose texture is in several UDIM tiles has a
/// picture for each tile.
///
/// The *curve* of a channel is its mean over the face, and 1 where the frame is the example. A vertex is
/// weighted by its area and by the size of the wrinkles that the channel's examples have there.
///
/// The *mask* is the largest activation of each place in any frame, divided by the largest value of the
/// curve, and at most 1. Mask times curve is about the activation. At the largest value of the curve, it is
/// the largest activation of each place, unless the mask was cut to 1.
pub struct WrinkleMasks {
    channels: Vec<Channel>,
    /// A picture for each UDIM tile, by its number.
    pictures: Vec<(u32, Texels)>,
    /// Channels × V: the weight of a vertex in the curve, with the sum 1.
    weights: Vec<Vec<f64>>,
    /// Channels × V: the largest activation so far.
    most: Vec<Vec<f32>>,
    /// Frames × channels.
    curves: Vec<f32>,
}

impl WrinkleMasks {
    /// Pictures of `size` × `size` texels for each channel. `wrinkles` are the sizes of the wrinkles of the
    /// channel's examples, channels × V.
    ///
    /// # Errors
    /// [`Error::Input`] if the rig's mesh has no texture coordinates, or some that are in no UDIM tile.
    pub fn new(rig: &Rig, channels: Vec<Channel>, wrinkles: &[Vec<f32>], size: usize) -> Result<Self> {
        let gauge = StrainGauge::of_surface(rig.surface());
        let areas: Vec<f64> = gauge.areas().collect();
        let weights = wrinkles.iter().map(|wrinkles| {
            let weights: Vec<f64> =
                wrinkles.iter().zip(&areas).map(|(wrinkle, area)| f64::from(*wrinkle) * area).collect();
            let sum: f64 = weights.iter().sum();
            if sum > 0.0 { weights.iter().map(|weight| weight / sum).collect() } else { weights }
        });
        Ok(Self {
            pictures: Texels::of_tiles(rig, wrinkles, size)?,
            weights: weights.collect(),
            most: vec![vec![0.0; rig.vertices()]; channels.len()],
            curves: Vec::new(),
            channels,
        })
    }

    /// Adds a frame, which has the channels.
    pub fn frame(&mut self, frame: &Frame<'_>) {
        for ((channel, weights), most) in self.channels.iter().zip(&self.weights).zip(&mut self.most) {
            let activations = frame.get(channel).unwrap_or_default();
            let mean = activations.iter().zip(weights).map(|(a, weight)| f64::from(*a) * weight).sum::<f64>();
            self.curves.push(mean as f32);
            most.iter_mut().zip(activations).for_each(|(most, a)| *most = most.max(*a));
        }
    }

    /// Writes the activations of a frame as a picture, PNG of 8 bits.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn write_frame(&self, path: &Path, frame: &Frame<'_>) -> Result<()> {
        let activations: Vec<&[f32]> =
            self.channels.iter().map(|channel| frame.get(channel).unwrap_or_default()).collect();
        self.write(path, &activations)
    }

    /// The files for a picture at `path`: the path itself, or a file for each UDIM tile, with the tile's
    /// number before the extension.
    pub fn files(&self, path: &Path) -> Vec<PathBuf> {
        match &self.pictures[..] {
            [(Texels::FIRST_TILE, _)] => vec![path.to_owned()],
            pictures => pictures.iter().map(|(tile, _)| of_tile(path, *tile)).collect(),
        }
    }

    fn write(&self, path: &Path, cells: &[&[f32]]) -> Result<()> {
        let files = self.files(path);
        self.pictures.iter().zip(files).try_for_each(|((_, texels), file)| texels.write(&file, cells))
    }

    /// Writes the masks as a picture, PNG of 8 bits.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn write_masks(&self, path: &Path) -> Result<()> {
        let count = self.channels.len();
        let masks: Vec<Vec<f32>> = (0..count)
            .map(|channel| {
                let highest = self.curves.iter().skip(channel).step_by(count).copied().fold(0.0, f32::max);
                let mask = |most: &f32| if highest > NOTHING { (most / highest).min(1.0) } else { 0.0 };
                self.most[channel].iter().map(mask).collect()
            })
            .collect();
        self.write(path, &masks.iter().map(Vec::as_slice).collect::<Vec<_>>())
    }

    /// Writes the curves as CSV, the first frame having the number `first`: columns `frame`, `time`, and the
    /// name of each channel.
    ///
    /// # Errors
    /// As [`tables::write_curves`].
    pub fn write_curves(&self, path: &Path, first: usize, rate: f64) -> Result<()> {
        let names: Vec<String> =
            self.channels.iter().map(|channel| channel.name.clone().into_owned()).collect();
        tables::write_curves(path, &names, first, rate, &self.curves)
    }

    /// The channels of these that wrinkles have.
    pub fn channels_of(channels: &[Channel]) -> Vec<Channel> {
        channels.iter().filter(|channel| channel.kind == Some(ChannelKind::Wrinkles)).cloned().collect()
    }
}

/// The name of a UDIM tile's file.
fn of_tile(path: &Path, tile: u32) -> PathBuf {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_extension(format!("{tile}.{ending}"))
}

/// Where each texel of a square picture is on a mesh.
struct Texels {
    size: usize,
    /// The triangle and the weights of its second and third corner; [`Texels::NONE`] where there is none.
    places: Vec<(u32, [f32; 2])>,
    triangles: Vec<[u32; 3]>,
}

impl Texels {
    const NONE: u32 = u32::MAX;

    /// The UDIM tile from 0 to 1.
    const FIRST_TILE: u32 = 1001;

    /// The texels of each UDIM tile that has any of the mesh, by its number. If parts overlap in the texture,
    /// such as an eye over the skin, those with wrinkles are on top.
    fn of_tiles(rig: &Rig, wrinkles: &[Vec<f32>], size: usize) -> Result<Vec<(u32, Self)>> {
        let lacks = || {
            Error::rig_lacks(
                "the rig's mesh has no texture coordinates, which masks need: solve it again from a neutral \
                 that has them",
            )
        };
        let uvs = rig.surface().uvs.as_ref().ok_or_else(lacks)?;
        let corners = rig.surface().triangle_corners()?;
        let at = |corner: u32| match &uvs.corners {
            Some(entries) => uvs.values[entries[corner as usize] as usize],
            None => uvs.values[rig.surface().faces.indices[corner as usize] as usize],
        };
        let has_wrinkles = |triangle: &usize| {
            let corners = rig.surface().triangles[*triangle];
            wrinkles.iter().any(|wrinkles| corners.iter().any(|v| wrinkles[*v as usize] > 0.0))
        };
        let (with, without): (Vec<usize>, Vec<usize>) = (0..corners.len()).partition(has_wrinkles);
        let mut tiles: BTreeMap<u32, Self> = BTreeMap::new();
        for triangle in without.into_iter().chain(with) {
            let uvs = corners[triangle].map(at);
            // Parts without texture coordinates have their corners in one place, and no tile.
            if uvs.iter().all(|uv| *uv == uvs[0]) {
                continue;
            }
            // A triangle is assigned by its middle, because corners may be on borders.
            let [u, v] = [0, 1].map(|c| (uvs.iter().map(|uv| uv[c]).sum::<f32>() / 3.0).floor());
            if !((0.0..10.0).contains(&u) && (0.0..100.0).contains(&v)) {
                return Err(Error::out_of_range(format!(
                    "the rig's mesh has texture coordinates about {u}, {v}, which are in no UDIM tile, expected 0 to 10 along u and 0 or more along v"
                )));
            }
            let tile = Self::FIRST_TILE + u as u32 + 10 * v as u32;
            let empty = || Self {
                size,
                places: vec![(Self::NONE, [0.0; 2]); size * size],
                triangles: rig.surface().triangles.clone(),
            };
            tiles
                .entry(tile)
                .or_insert_with(empty)
                .paint(triangle as u32, uvs.map(|uv| [uv[0] - u, uv[1] - v]));
        }
        tiles.values_mut().for_each(Self::grow);
        Ok(tiles.into_iter().collect())
    }

    /// Paints the texels whose middle is in a triangle.
    fn paint(&mut self, triangle: u32, uvs: [[f32; 2]; 3]) {
        let size = self.size as f64;
        // Rows go downwards, v upwards.
        let [a, b, c] = uvs.map(|[u, v]| [f64::from(u) * size - 0.5, (1.0 - f64::from(v)) * size - 0.5]);
        let cross = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
            (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        };
        let area = cross(a, b, c);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let range = |axis: usize| {
            let all = [a[axis], b[axis], c[axis]];
            let low = all.into_iter().fold(f64::INFINITY, f64::min).ceil().max(0.0);
            let high = all.into_iter().fold(f64::NEG_INFINITY, f64::max).floor().min(size - 1.0);
            low as usize..if high < low { low as usize } else { high as usize + 1 }
        };
        for y in range(1) {
            for x in range(0) {
                let p = [x as f64, y as f64];
                let (second, third) = (cross(p, c, a) / area, cross(p, a, b) / area);
                if second >= 0.0 && third >= 0.0 && second + third <= 1.0 {
                    self.places[y * self.size + x] = (triangle, [second as f32, third as f32]);
                }
            }
        }
    }

    /// Fills empty texels from a neighbour, ring by ring.
    fn grow(&mut self) {
        let size = self.size as isize;
        for _ in 0..GUTTER {
            let before = self.places.clone();
            let neighbour = |i: usize| {
                let (x, y) = ((i as isize) % size, (i as isize) / size);
                let beside = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];
                beside.into_iter().find_map(|(dx, dy)| {
                    let (x, y) = (x + dx, y + dy);
                    let inside = (0..size).contains(&x) && (0..size).contains(&y);
                    inside
                        .then(|| before[(y * size + x) as usize])
                        .filter(|(triangle, _)| *triangle != Self::NONE)
                })
            };
            self.places.par_iter_mut().enumerate().filter(|(_, place)| place.0 == Self::NONE).for_each(
                |(i, place)| {
                    if let Some(found) = neighbour(i) {
                        *place = found;
                    }
                },
            );
        }
    }

    /// A picture with a cell for each of these arrays of V numbers from 0 to 1.
    fn write(&self, path: &Path, cells: &[&[f32]]) -> Result<()> {
        let columns = (1..).find(|columns| columns * columns >= cells.len()).unwrap_or(1);
        let rows = cells.len().div_ceil(columns);
        let width = columns * self.size;
        let mut pixels = vec![0_u8; width * rows * self.size];
        let lines: Vec<_> = self.places.chunks_exact(self.size).collect();
        pixels.par_chunks_exact_mut(width).enumerate().for_each(|(y, row)| {
            for (column, row) in row.chunks_exact_mut(self.size).enumerate() {
                let Some(numbers) = cells.get(y / self.size * columns + column) else { continue };
                for (pixel, (triangle, [second, third])) in row.iter_mut().zip(lines[y % self.size]) {
                    if *triangle != Self::NONE {
                        let [a, b, c] = self.triangles[*triangle as usize].map(|v| numbers[v as usize]);
                        let number = a + second * (b - a) + third * (c - a);
                        *pixel = (number.clamp(0.0, 1.0) * 255.0).round() as u8;
                    }
                }
            }
        });
        let mut file = AtomicFile::create(path)?;
        let internal = |error: png::EncodingError| Error::Internal(format!("a picture of masks: {error}"));
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width as u32, (rows * self.size) as u32);
        encoder.set_color(png::ColorType::Grayscale);
        let mut writer = encoder.write_header().map_err(internal)?;
        writer.write_image_data(&pixels).and_then(|()| writer.finish()).map_err(internal)?;
        file.write_all(&bytes).map_err(file.error())?;
        file.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::{NoProgress, Uvs};
    use rhytid_test_support::changed;
    use std::fs::File;
    use std::io::BufReader;

    fn read(path: &Path) -> (usize, Vec<u8>) {
        let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Grayscale, png::BitDepth::Eight));
        (info.width as usize, pixels)
    }

    /// The demo's face with its x and y as texture coordinates, shrunk into the middle, and three channels.
    fn masks(size: usize) -> (Rig, WrinkleMasks) {
        let face = rhytid_demo::face(1_000);
        let rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let bound =
            |of: fn(f32, f32) -> f32, c: usize| rig.surface().rest.iter().map(|x| x[c]).reduce(of).unwrap();
        let (low, high) =
            ([bound(f32::min, 0), bound(f32::min, 1)], [bound(f32::max, 0), bound(f32::max, 1)]);
        let uv = |x: &[f32; 3]| [0, 1].map(|c| 0.25 + 0.5 * (x[c] - low[c]) / (high[c] - low[c]));
        let uvs = Uvs { values: rig.surface().rest.iter().map(uv).collect(), corners: None };
        let rig = changed(&rig, |r| r.surface.uvs = Some(uvs)).unwrap();
        let channels = ChannelKind::Wrinkles.channels(&["a", "b", "c"].map(String::from));
        let wrinkles = vec![vec![1.0; rig.vertices()]; 3];
        let masks = WrinkleMasks::new(&rig, channels, &wrinkles, size).unwrap();
        (rig, masks)
    }

    #[test]
    fn a_picture_has_each_place_where_its_texture_coordinates_are() {
        let (rig, masks) = masks(128);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("masks.png");
        let uvs = &rig.surface().uvs.as_ref().unwrap().values;
        // u, v and their product, none of them the same upside down.
        let numbers: [Vec<f32>; 3] = [0, 1, 2].map(|i| uvs.iter().map(|[u, v]| [*u, *v, u * v][i]).collect());
        let frame = masks
            .channels
            .iter()
            .zip(&numbers)
            .fold(Frame::new(rig.surface().rest.as_flattened()), |frame, (channel, numbers)| {
                frame.with(channel, numbers)
            });
        masks.write_frame(&path, &frame).unwrap();
        let (width, pixels) = read(&path);
        assert_eq!((width, pixels.len()), (256, 256 * 256), "three tiles are two rows of two");
        for (tile, expected) in
            [|u: f64, _: f64| u, |_: f64, v: f64| v, |u: f64, v: f64| u * v].into_iter().enumerate()
        {
            for (x, y) in [(64, 64), (40, 64), (64, 90), (80, 50)] {
                let (u, v) = ((x as f64 + 0.5) / 128.0, 1.0 - (y as f64 + 0.5) / 128.0);
                let found = pixels[(tile / 2 * 128 + y) * width + tile % 2 * 128 + x];
                assert!(
                    (f64::from(found) - 255.0 * expected(u, v)).abs() < 2.5,
                    "{tile} {x} {y}: {found}, {}",
                    255.0 * expected(u, v)
                );
            }
        }
        // The gutter, and beyond it.
        assert!(pixels[64 * width + 27] > 0 && pixels[64 * width + 10] == 0);
        assert!(pixels[(128 + 64) * width + 128 + 64] == 0, "the fourth tile is empty");
    }

    #[test]
    fn a_texture_in_tiles_has_a_picture_for_each() {
        let (rig, masks) = masks(32);
        let left: Vec<bool> = rig.surface().rest.iter().map(|x| x[0] < 0.0).collect();
        // Triangles across the border are stretched over both tiles; an artist's mesh has none.
        let across =
            |corners: &[u32; 3]| corners.iter().any(|v| left[*v as usize] != left[corners[0] as usize]);
        let rig = changed(&rig, |r| {
            let values = &mut r.surface.uvs.as_mut().unwrap().values;
            values.iter_mut().zip(&left).filter(|(_, left)| **left).for_each(|(uv, _)| uv[0] += 1.0);
            values.iter_mut().zip(&left).filter(|(_, left)| !**left).for_each(|(uv, _)| uv[1] += 2.0);
            r.surface.triangles.retain(|corners| !across(corners));
            r.surface.faces = rhytid_core::Faces::default();
            r.surface.triangles.iter().for_each(|corners| r.surface.faces.push(corners));
        })
        .unwrap();
        let wrinkles = vec![vec![1.0; rig.vertices()]; 3];
        let tiled = WrinkleMasks::new(&rig, masks.channels.clone(), &wrinkles, 32).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let files = tiled.files(&folder.path().join("a.masks.png"));
        let names: Vec<_> = files.iter().map(|file| file.file_name().unwrap().to_str().unwrap()).collect();
        assert_eq!(names, ["a.masks.1002.png", "a.masks.1021.png"]);
        // A part without texture coordinates, here the first triangle, is in no tile.
        let partly = changed(&rig, |r| {
            let mut corners = r.surface.faces.indices.clone();
            let uvs = r.surface.uvs.as_mut().unwrap();
            corners[..3].fill(uvs.values.len() as u32);
            uvs.values.push([0.0, 0.0]);
            uvs.corners = Some(corners);
        })
        .unwrap();
        let partly = WrinkleMasks::new(&partly, masks.channels.clone(), &wrinkles, 32).unwrap();
        assert_eq!(partly.files(&folder.path().join("a.masks.png")), files);
        let ones = vec![1.0; rig.vertices()];
        let frame = tiled
            .channels
            .iter()
            .fold(Frame::new(rig.surface().rest.as_flattened()), |frame, channel| frame.with(channel, &ones));
        tiled.write_frame(&folder.path().join("a.masks.png"), &frame).unwrap();
        let lit = |file: &PathBuf| read(file).1.iter().filter(|pixel| **pixel == 255).count();
        assert!(files.iter().all(|file| lit(file) > 100));
        let rig = changed(&rig, |r| r.surface.uvs.as_mut().unwrap().values[3] = [-5.0, 0.5]).unwrap();
        let error = WrinkleMasks::new(&rig, masks.channels, &wrinkles, 32).err().unwrap().to_string();
        assert!(error.contains("in no UDIM tile"), "{error}");
    }

    #[test]
    fn masks_times_curves_are_the_activations_where_these_are_highest() {
        let (rig, mut masks) = masks(64);
        let folder = tempfile::tempdir().unwrap();
        let [pictures, curves] = ["masks.png", "curves.csv"].map(|name| folder.path().join(name));
        let n = rig.vertices();
        for amount in [0.2_f32, 0.6, 0.4] {
            let [a, b, c] = [vec![amount; n], vec![0.5 * amount; n], vec![0.001; n]];
            let channels = masks.channels.clone();
            let frame = Frame::new(rig.surface().rest.as_flattened())
                .with(&channels[0], &a)
                .with(&channels[1], &b)
                .with(&channels[2], &c);
            masks.frame(&frame);
        }
        masks.write_masks(&pictures).unwrap();
        masks.write_curves(&curves, 3, 10.0).unwrap();
        let text = std::fs::read_to_string(&curves).unwrap();
        let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        assert_eq!(rows[0], ["frame", "time", "wrinkle_a", "wrinkle_b", "wrinkle_c"]);
        for (row, (frame, amount)) in rows[1..].iter().zip([(3, 0.2), (4, 0.6), (5, 0.4)]) {
            assert_eq!(row[0], frame.to_string());
            let numbers: Vec<f64> = row[1..].iter().map(|cell| cell.parse().unwrap()).collect();
            for (found, expected) in
                numbers.iter().zip([f64::from(frame) / 10.0, amount, 0.5 * amount, 0.001])
            {
                assert!((found - expected).abs() < 1e-5, "{row:?}");
            }
        }
        let (width, pixels) = read(&pictures);
        let middle = |tile: usize| pixels[(tile / 2 * 64 + 32) * width + tile % 2 * 64 + 32];
        assert_eq!([middle(0), middle(1), middle(2)], [255, 255, 0], "what is never on is black");
    }
}
