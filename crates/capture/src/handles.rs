//! The handles of a face from a take: which point of the skin each marker is at, in the frame and the unit
//! that fit best.
use crate::handles_in_frame::place;
use glam::DVec3;
use rhytid_core::numbers::median;
use rhytid_core::{Error, Face, Handles, LengthUnit, Progress, RawTake, Result, SurfacePoint, Take};
use rhytid_solve::Skin;
use rhytid_solve::head::Region;
use std::collections::HashMap;
use std::ops::Range;

/// Actors hold the neutral face so long at the start and at the end of a take, in seconds.
const HELD: f64 = 0.5;

/// In another frame the face lies at the same place of the mesh, up to so many metres. Otherwise it slid
/// along the skin in one of the two, and nothing tells in which.
const SAME: f64 = 0.005;

/// What is known about the take. Everything else is found.
#[derive(Debug, Clone, Default)]
pub struct HandleSettings {
    /// The frame to use, counted from 0. Else the markers are laid in the most typical frame, in one at the
    /// start and in one at the end of the take, and the frame that fits best counts.
    pub frame: Option<usize>,
    /// Metres in one unit of the file; else the file's statement, or what fits the mesh's size. A clean take
    /// has the mesh's unit if that fits.
    pub metres_per_unit: Option<f64>,
    /// Markers that are not on skin; else found.
    pub rigid: Option<Vec<String>>,
    /// Points of markers that are known. Three or more decide where the face is.
    pub known: Vec<(String, SurfacePoint)>,
    /// The actor whose markers count: what stands before the colon of their labels. Else all count.
    pub subject: Option<String>,
    /// The head, if the mesh has more and it is found already.
    pub head: Option<Region>,
}

/// Where a frame's markers are on a mesh.
#[derive(Debug, Clone)]
pub struct PlacedHandles {
    /// A handle for each marker on skin, in the file's order.
    pub handles: Handles,
    /// How far each point is from where its marker was laid, in mesh units.
    pub distances: Vec<f64>,
    /// Where each marker was laid, in mesh units.
    pub markers: Vec<[f64; 3]>,
    /// Markers that were left out: on a cap or a head band.
    pub rigid: Vec<String>,
    /// Markers that were left out: on the body, on another actor or on a thing, not on the face.
    pub elsewhere: Vec<String>,
    /// Points that were left out: those without a label, and those that hardly any frame shows.
    pub unlabelled: Vec<String>,
    /// Markers that the frame does not show.
    pub unseen: Vec<String>,
    /// The frame.
    pub frame: usize,
    /// How badly the markers fit, from 0 to 1.
    pub cost: f64,
    /// Why the handles are probably wrong: a sentence each. Empty if three or more points were known.
    pub faults: Vec<String>,
    /// What else a person should look at: a sentence each.
    pub warnings: Vec<String>,
}

impl PlacedHandles {
    /// Whether nothing is wrong, no marker is without a handle that has one in `other`, and the markers fit
    /// the mesh better.
    fn is_better(&self, other: &Self) -> bool {
        self.faults.is_empty()
            && self.handles.labels.len() >= other.handles.labels.len()
            && self.cost <= other.cost
    }

    /// The median distance of the handles from those of `other`, in mesh units.
    fn from(&self, other: &Self, skin: &Skin) -> f64 {
        let there: HashMap<&String, DVec3> = other
            .handles
            .labels
            .iter()
            .zip(&other.handles.points)
            .map(|(label, x)| (label, skin.at(x)))
            .collect();
        let here = self.handles.labels.iter().zip(&self.handles.points);
        let distance = |(label, x): (&String, &SurfacePoint)| Some(skin.at(x).distance(*there.get(label)?));
        median(&mut here.filter_map(distance).collect::<Vec<_>>())
    }
}

/// Places a handle for each marker on skin, from one frame of `raw`. The handles of `face` are ignored.
///
/// # Errors
/// [`Error::Cancelled`], within some seconds.
/// [`Error::Input`]: a frame, a label or an actor that the take does not have, fewer than four markers, a
/// mesh that is not whole or looks elsewhere.
pub fn place_handles(
    face: &Face,
    raw: &RawTake,
    settings: &HandleSettings,
    progress: &dyn Progress,
) -> Result<PlacedHandles> {
    let skin = match &settings.head {
        Some(head) => Skin::from_region(face, head)?,
        None => Skin::from_face(face)?,
    };
    let found = place_in_best_frame(face, raw, settings, &skin, progress);
    let is_right = found.as_ref().is_ok_and(|placed| placed.faults.is_empty());
    let is_known = !raw.in_head_space || settings.metres_per_unit.or(raw.metres_per_unit).is_some();
    if is_right || is_known || progress.cancelled() {
        return found;
    }
    // A clean take has the mesh's unit, unless it was cleaned for another mesh.
    let mut best: Option<(LengthUnit, PlacedHandles)> = None;
    for unit in LengthUnit::ALL {
        let settings = HandleSettings { metres_per_unit: Some(unit.metres), ..settings.clone() };
        match place_in_best_frame(face, raw, &settings, &skin, progress) {
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Ok(placed)
                if placed.faults.is_empty()
                    && best.as_ref().is_none_or(|(_, best)| placed.cost < best.cost) =>
            {
                best = Some((unit, placed));
            }
            _ => {}
        }
    }
    let Some((unit, mut placed)) = best else { return found };
    placed.warnings.push(format!(
        "the markers fit the mesh in {0}, so the take is taken to be in {0}; give the take's unit if it is another",
        unit.name
    ));
    Ok(placed)
}

/// Places the handles in the frame that fits best.
fn place_in_best_frame(
    face: &Face,
    raw: &RawTake,
    settings: &HandleSettings,
    skin: &Skin,
    progress: &dyn Progress,
) -> Result<PlacedHandles> {
    let mut placed = place(face, raw, settings, skin, progress)?;
    if settings.frame.is_some() || !placed.faults.is_empty() {
        return Ok(placed);
    }
    // Actors begin and end a take with the neutral face. If such a frame fits better, it is the neutral one.
    let length = ((HELD * raw.tracks.rate()).round() as usize).clamp(1, raw.tracks.frames());
    for held in [0..length, raw.tracks.frames() - length..raw.tracks.frames()] {
        let frame = Some(fullest_frame(&raw.tracks, &placed.handles.labels, held));
        let there = place(face, raw, &HandleSettings { frame, ..settings.clone() }, skin, progress);
        if progress.cancelled() {
            return Err(Error::Cancelled);
        }
        let is_better = |there: &PlacedHandles| {
            there.is_better(&placed) && there.from(&placed, skin) * face.metres_per_unit < SAME
        };
        placed = there.ok().filter(is_better).unwrap_or(placed);
    }
    Ok(placed)
}

/// Of some frames, the one that shows most of the markers; of several, the one nearest to the middle.
fn fullest_frame(take: &Take, labels: &[String], frames: Range<usize>) -> usize {
    let count = take.labels.len();
    let columns: Vec<usize> = (0..count).filter(|&m| labels.contains(&take.labels[m])).collect();
    let shows = |f: usize| columns.iter().filter(|&&m| !take.positions[f * count + m][0].is_nan()).count();
    let (start, middle) = (frames.start, usize::midpoint(frames.start, frames.end));
    frames.max_by_key(|&f| (shows(f), std::cmp::Reverse(f.abs_diff(middle)))).unwrap_or(start)
}
