//! Layers on a take: edits, resolved on a rig and applied. Rig and take stay as they are.

mod handles;
mod on_frames;
mod region;

pub use on_frames::FrameEdits;

use crate::fade::VertexGain;
use handles::{AddedTake, Held};
use region::Regions;
use rhytid_core::{Error, Mesh, Result, Rig, Take, rig_file};
use rhytid_formats::edits::{self, Curve, Edits};
use rhytid_formats::take::{self, Missing};
use rhytid_formats::{Reach, mesh, named_file};
use std::path::{Path, PathBuf};

/// What a file of edits does to takes of a rig ([`Edits`] has the formula).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Layers {
    /// The file's text.
    text: String,
    /// Of the text and of the files that it names.
    hash: String,
    /// Displacements from rest are multiplied: H weights, from 0 to 1, and the gain.
    gains: Vec<(Vec<f64>, Curve)>,
    /// Handles are moved: H vectors in mesh units, and what they are multiplied by.
    offsets: Vec<(Vec<[f64; 3]>, Curve)>,
    added: Vec<AddedTake>,
    holds: Vec<Held>,
    corrections: Vec<Sculpt>,
    /// Folds are multiplied: V weights, from 0 to 1, and the gain.
    details: Vec<(Vec<f32>, Curve)>,
}

impl Layers {
    /// Reads a file of edits and all that it names within `reach`.
    ///
    /// # Errors
    /// As [`edits::read`]; [`Error::Input`] for a region or a marker that the rig does not have, and as of reading takes and meshes.
    pub fn read(path: &Path, rig: &Rig, reach: Reach) -> Result<Self> {
        let (edits, text) = edits::read(path)?;
        let in_file = |error| match error {
            Error::Input(message) => Error::Input(format!("{}: {message}", path.display())),
            other => other,
        };
        let mut hash = blake3::Hasher::new();
        hash.update(text.as_bytes());
        for file in files(&edits) {
            let file = named_file(path, file, "an edit", reach)?;
            hash.update(rig_file::hash(&file)?.as_bytes());
        }
        let rest = Mesh {
            positions: rig.rest.iter().map(|x| x.map(f64::from)).collect(),
            faces: rig.faces.clone(),
            ..Mesh::default()
        };
        let mut regions = Regions::new((path, &edits), (rig, &rest), reach);
        let mut layers = Self {
            text,
            hash: hash.finalize().to_hex().to_string(),
            ..Self::new(&edits, rig, &mut regions)?
        };
        for added in &edits.added {
            let file = named_file(path, &added.take, "[[add]] take", reach)?;
            let other = take::read(&file, None, Missing::Hold)?;
            let weights = regions.handles(added.region.as_deref()).map_err(in_file)?;
            let other = AddedTake::new(other, rig, weights, added).map_err(|error| match error {
                Error::Input(message) => Error::Input(format!("{}: {message}", file.display())),
                other => other,
            })?;
            layers.added.push(other);
        }
        for correction in &edits.corrections {
            let file = named_file(path, &correction.mesh, "[[correction]] mesh", reach)?;
            let positions = mesh::read_like(&rest, Path::new("the rig"), &file)?;
            let weights = regions.vertices(correction.region.as_deref()).map_err(in_file)?;
            layers.corrections.push(Sculpt { positions, weights, correction: correction.clone() });
        }
        Ok(layers)
    }

    /// Those that name no files: poses that were pulled, for one.
    ///
    /// # Errors
    /// [`Error::Input`] for a region or a marker that the rig does not have.
    fn new(edits: &Edits, rig: &Rig, regions: &mut Regions<'_>) -> Result<Self> {
        let in_mesh_units = |x: [f64; 3]| x.map(|x| x * 1e-3 / rig.metres_per_unit);
        let mut layers = Self::default();
        for gain in &edits.gains {
            layers.gains.push((regions.handles(gain.region.as_deref())?, gain.by.clone()));
        }
        for offset in &edits.offsets {
            let by = match offset.millimetres {
                Some(by) => {
                    let weights = regions.handles(offset.region.as_deref())?;
                    weights.iter().map(|w| in_mesh_units(by.map(|x| w * x))).collect()
                }
                None => regions.each(&offset.markers)?.into_iter().map(in_mesh_units).collect(),
            };
            layers.offsets.push((by, offset.amount.clone()));
        }
        for hold in &edits.holds {
            layers.holds.push(Held { weights: regions.handles(hold.region.as_deref())?, hold: hold.clone() });
        }
        for detail in &edits.details {
            layers.details.push((regions.vertices(detail.region.as_deref())?, detail.by.clone()));
        }
        Ok(layers)
    }

    /// The file's text, as exports carry it.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// What tells these edits from others: of the text, and of all that is in the files that it names.
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// The take with its handles edited. Frames and markers that no edit is about keep every bit. Those that are edited in any frame have a second column, by which
    /// [`crate::Playback`] knows what they would do without, and how far the edits reach.
    ///
    /// # Errors
    /// [`Error::Input`] if the take lacks handles, or a frame that is held.
    pub fn edit(&self, take: Take, rig: &Rig) -> Result<Take> {
        handles::edit(self, take, rig)
    }

    /// Whether they do anything to frames, beside editing the take; edits of markers are bounded there.
    pub fn are_on_frames(&self) -> bool {
        *self != Self { text: self.text.clone(), hash: self.hash.clone(), ..Self::default() }
    }

    /// What was sculpted.
    pub(crate) fn sculpted(&self) -> &[Sculpt] {
        &self.corrections
    }

    /// By how much folds are multiplied, for [`crate::Playback::with_vertex_gains`], of the take that is edited.
    pub fn vertex_gains(&self, take: &Take) -> Vec<VertexGain> {
        let timed = |(weights, by): &(Vec<f32>, Curve)| VertexGain::new(weights, timed(take, by));
        self.details.iter().map(timed).collect()
    }
}

/// A frame that was sculpted.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sculpt {
    /// V, in mesh units.
    pub positions: Vec<[f64; 3]>,
    /// V, from 0 to 1.
    pub weights: Vec<f32>,
    pub correction: edits::Correction,
}

/// The files that edits name.
fn files(edits: &Edits) -> impl Iterator<Item = &PathBuf> {
    let regions = edits.regions.values().flat_map(|region| region.of.iter().chain(&region.weights));
    let sculpted = edits.corrections.iter().map(|correction| &correction.mesh);
    edits.added.iter().map(|added| &added.take).chain(regions).chain(sculpted)
}

/// A curve over a take's frames as one over its time.
pub(crate) fn timed(take: &Take, curve: &Curve) -> Curve {
    let keys = curve.keys.iter().map(|&(frame, value)| (time_of(take, frame), value)).collect();
    Curve { keys, ease: curve.ease }
}

/// The time of a frame, which may be between two, or beyond the take's ends.
fn time_of(take: &Take, frame: f64) -> f64 {
    let last = take.frames().saturating_sub(1);
    let whole = frame.clamp(0.0, last as f64);
    let i = whole.floor() as usize;
    let (Some(&time), next) = (take.times.get(i), take.times.get(i + 1)) else { return frame / take.rate() };
    let inside = next.map_or(0.0, |next| (whole - i as f64) * (next - time));
    time + inside + (frame - whole) / take.rate()
}

#[cfg(test)]
mod tests;
