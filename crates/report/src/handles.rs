//! A picture of handles on a mesh.

use crate::behind::behind;
use crate::names::{Name, place_names};
use crate::painter::{Canvas, LIFT, Painter, camera};
use rhytid_core::{AtomicFile, Face, Result};
use rhytid_render::{Mark, Picture, Sphere};
use std::io::Write;
use std::path::Path;

const SIZE: [u32; 2] = [860, 1060];

/// The views from the face's right, the front and its left, in degrees.
const VIEWS: [f32; 3] = [-50.0, 0.0, 50.0];

/// The colours of good handles, of doubtful handles, and of places of markers: linear red, green and blue.
const COLOURS: [[f32; 3]; 3] = [[0.01, 0.16, 0.72], [0.72, 0.02, 0.01], [0.96, 0.51, 0.01]];

/// The colours of names and of their rims, in 8 bits of sRGB.
const NAME: [u8; 3] = [10, 10, 10];
const RIM: [u8; 3] = [255, 255, 255];

/// Writes a PNG of the neutral from three sides, with its handles as dots and their names beside them.
///
/// Handles are red where `doubtful` says so, and blue elsewhere. The places of markers, if there are any, are
/// yellow. Dots that the face hides are not shown, and neither are names without room.
///
/// # Errors
/// [`rhytid_core::Error::Io`]; [`rhytid_core::Error::Device`]; [`rhytid_core::Error::Input`] if the mesh is
/// too large for the device.
pub fn write_handles(
    path: &Path,
    face: &Face,
    doubtful: &[bool],
    markers: &[[f64; 3]],
    painter: &Painter,
) -> Result<()> {
    let single = |p: &[f64; 3]| p.map(|x| x as f32);
    let rest: Vec<[f32; 3]> = face.neutral.positions.iter().map(single).collect();
    let triangles = rhytid_geometry::triangulate(&face.neutral);
    let handles: Vec<[f32; 3]> = face.handles.points.iter().map(|point| point.at(&rest)).collect();
    let lift = LIFT * Sphere::around(&handles).radius;
    let of_handles = handles.iter().enumerate().map(|(i, &at)| {
        let is_doubtful = doubtful.get(i).is_some_and(|doubtful| *doubtful);
        (at, COLOURS[usize::from(is_doubtful)], 9.0)
    });
    let of_markers = markers.iter().map(|marker| (single(marker), COLOURS[2], 6.0));
    // A dark rim makes dots visible on light and on dark skin.
    let dot = |(at, colour, width): ([f32; 3], [f32; 3], f32)| {
        [Mark::dot(at, colour.map(|x| 0.1 * x), width), Mark::dot(at, colour, width - 2.5)]
    };
    let marks: Vec<Mark> = of_markers.chain(of_handles).flat_map(dot).collect();

    let mut canvas = Canvas::new(painter, &face.neutral.faces, &triangles, rest.len(), SIZE)?;
    let [width, height] = SIZE;
    let mut picture = Picture::filled([VIEWS.len() as u32 * width, height], [0; 4]);
    for (i, turn) in (0..).zip(VIEWS) {
        let camera = camera(&handles, &rest, face.up_axis, turn, SIZE);
        let mut drawn = canvas.draw(&camera, &rest, None, lift, &marks)?;
        let is_behind = behind(&camera, SIZE, &rest, &triangles, lift, &handles);
        let shown: Vec<usize> = (0..handles.len()).filter(|&h| !is_behind[h]).collect();
        let dots: Vec<[f32; 2]> =
            shown.iter().map(|&h| camera.project(SIZE, handles[h])).map(|[x, y, _]| [x, y]).collect();
        let words: Vec<&str> = shown.iter().map(|&h| face.handles.labels[h].as_str()).collect();
        for Name { words, at } in place_names(&dots, &words, SIZE) {
            drawn.write_small(words, at, NAME, RIM);
        }
        picture.put(&drawn, [i * width, 0]);
    }
    let mut file = AtomicFile::create(path)?;
    file.write_all(&picture.png()?).map_err(file.error())?;
    file.finish()
}
