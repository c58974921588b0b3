//! Sculpted examples: a frame of a take whose handles are known, or a displacement map on a mesh.

use glam::DVec3;
use rhytid_core::{Error, Handles, Mesh, Result, SurfacePoint};
use rhytid_meshes::{DisplacementMap, NormalMap, NormalMapConvention};
use rhytid_takes::take::{self, Missing};
use std::path::Path;

/// A marker that was moved by more than this, in millimetres, was moved on purpose.
const MOVED_MM: f64 = 0.05;

/// Puts an example's handles to their places in a frame of a take. So the markers are met even if the
/// sculptor moved them.
///
/// # Errors
/// As [`take::read`]; [`Error::Input`] if the take has no such frame.
pub(super) fn place_handles(
    positions: &mut [[f64; 3]],
    handles: &Handles,
    metres_per_unit: f64,
    path: &Path,
    frame: usize,
    example: &str,
) -> Result<()> {
    let take = take::read(path, Some(&handles.labels), Missing::Error)?;
    if frame >= take.frames() {
        let frames = take.frames();
        return Err(Error::out_of_range(format!(
            "{}: has {frames} frames, counted from 0, but [[example]] {example:?} is its frame {frame}",
            path.display()
        )));
    }
    let at = take.slice(frame..frame + 1);
    let at = |label: &String| at.labels.iter().position(|l| l == label).map(|column| at.positions[column]);
    let (mut moved, mut farthest) = (0, (0.0, ""));
    let mut drawn = Vec::new();
    for (label, point) in handles.labels.iter().zip(&handles.points) {
        let Some(place) = at(label) else { continue };
        let millimetres =
            DVec3::from(point.at(positions)).distance(DVec3::from(place)) * metres_per_unit * 1e3;
        if millimetres > MOVED_MM {
            moved += 1;
            if millimetres > farthest.0 {
                farthest = (millimetres, label);
            }
        }
        drawn.push((point, place));
    }
    SurfacePoint::draw(&drawn, positions);
    if moved > 0 {
        log::warn!(
            "[[example]] {example:?}: {moved} of the handles are elsewhere in the mesh than in frame {frame} \
             of {}, the farthest {} by {:.2} mm, and are moved to their places in the take; if the mesh is \
             of another frame, correct `frame`; to move markers, use [[offset]] in a file of edits",
            path.display(),
            farthest.1,
            farthest.0
        );
    }
    Ok(())
}

/// An example's positions with a displacement map, which moves by `full` mesh units where it is white.
///
/// # Errors
/// As of [`DisplacementMap`].
pub(super) fn displaced(
    neutral: &Mesh,
    neutral_path: &Path,
    positions: Vec<[f64; 3]>,
    map: &Path,
    full: f64,
) -> Result<Vec<[f64; 3]>> {
    let mut mesh = Mesh { positions, ..neutral.clone() };
    DisplacementMap::read(map)?
        .displace(&mut mesh, full)
        .map_err(|error| error.in_file(neutral_path.display()))?;
    Ok(mesh.positions)
}

/// Green seems to point the other way if fewer slopes are then impossible for a surface. Their part has to be
/// below this times the part with the stated direction.
const BETTER: f64 = 0.9;

/// An example's positions with the surface of a normal map, whose heights are multiplied by `strength`.
///
/// # Errors
/// As of [`NormalMap`].
pub(super) fn with_normal_map(
    neutral: &Mesh,
    neutral_path: &Path,
    positions: Vec<[f64; 3]>,
    path: &Path,
    green: Option<NormalMapConvention>,
    strength: f64,
) -> Result<Vec<[f64; 3]>> {
    let (map, green) = (NormalMap::read(path)?, green.unwrap_or_default());
    let displaced = |green: NormalMapConvention| {
        let mut mesh = Mesh { positions: positions.clone(), ..neutral.clone() };
        let found = map.displace(&mut mesh, green, strength);
        Ok((mesh, found.map_err(|error| error.in_file(neutral_path.display()))?))
    };
    let (mesh, found) = displaced(green)?;
    if displaced(green.other())?.1.left < BETTER * found.left {
        let other = match green {
            NormalMapConvention::Up => {
                "down, as in DirectX, because its slopes then fit a surface better; say green = \"down\""
            }
            NormalMapConvention::Down => {
                "up, as in OpenGL, because its slopes then fit a surface better; say green = \"up\""
            }
        };
        log::warn!("{}: its green seems to point {other}", path.display());
    }
    Ok(mesh.positions)
}
