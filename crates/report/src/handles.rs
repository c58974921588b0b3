//! A picture of handles on a mesh.

use crate::camera::Camera;
use crate::raster::Raster;
use rhytid_core::{AtomicFile, Face, Result};
use std::io::Write;
use std::path::Path;

const SIZE: [usize; 2] = [520, 640];

/// From the face's right, the front and its left.
const VIEWS: [f64; 3] = [-50.0, 0.0, 50.0];

/// Handles that are fine, those to look at, and where markers were laid.
const COLOURS: [[u8; 3]; 3] = [[20, 110, 220], [220, 40, 30], [250, 190, 30]];

/// Writes a PNG of the neutral from three sides with its handles as dots: red where `doubtful` says so, blue elsewhere; and where the markers
/// were laid, if there are any, in yellow.
///
/// # Errors
/// [`rhytid_core::Error::Io`].
pub fn write_handles(path: &Path, face: &Face, doubtful: &[bool], markers: &[[f64; 3]]) -> Result<()> {
    let rest: Vec<[f32; 3]> = face.neutral.positions.iter().map(|x| x.map(|c| c as f32)).collect();
    let triangles = rhytid_solve::triangulate(&face.neutral);
    let at: Vec<[f64; 3]> =
        face.handles.vertices.iter().map(|&v| face.neutral.positions[v as usize]).collect();
    let mut rasters = Vec::new();
    for degrees in VIEWS {
        let camera = Camera::new(face.up_axis, degrees, SIZE, at.iter().copied());
        let mut raster = Raster::new(&camera, &rest, &triangles);
        let slack = 0.02 * SIZE[0] as f64;
        let mut dots: Vec<([f64; 3], f64, [u8; 3])> = Vec::new();
        for marker in markers {
            dots.push((camera.project(*marker), 3.0, COLOURS[2]));
        }
        for (i, x) in at.iter().enumerate() {
            let is_doubtful = doubtful.get(i).is_some_and(|doubtful| *doubtful);
            dots.push((camera.project(*x), 4.5, COLOURS[usize::from(is_doubtful)]));
        }
        dots.retain(|(place, _, _)| raster.shows(*place, slack));
        for (place, radius, colour) in dots {
            raster.dot(place, radius, colour);
        }
        rasters.push(raster);
    }
    let picture = Raster::side_by_side(&rasters);
    let mut file = AtomicFile::create(path)?;
    file.write_all(&picture.png()?).map_err(file.error())?;
    file.finish()
}
