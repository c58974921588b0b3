//! Layers on a take: edits that are resolved on a rig and applied. The rig and the take themselves stay as
//! they are.

mod handles;
mod on_frames;
mod region;

pub use on_frames::FrameEdits;

use crate::EditedTake;
use crate::fade::VertexGain;
use handles::{AddedTake, Held};
use region::Regions;
use rhytid_core::{Mesh, Result, Rig, Take, rig_file};
use rhytid_formats::edits::{self, Curve};
use rhytid_formats::take::{self, Missing};
use rhytid_formats::{Reach, mesh, named_file};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The effects of a file of edits on takes of a rig ([`edits::Edits`] has the formula).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Layers {
    /// The file, for messages.
    path: PathBuf,
    /// Its text.
    text: String,
    /// The hash of the text and of the files that it names.
    hash: String,
    /// Gains of the displacements from rest: H weights, from 0 to 1, and the gain over time.
    gains: Vec<(Vec<f64>, Curve)>,
    /// Offsets of handles: H vectors in mesh units, and the factor over time.
    offsets: Vec<(Vec<[f64; 3]>, Curve)>,
    added: Vec<AddedTake>,
    holds: Vec<Held>,
    corrections: Vec<Sculpt>,
    /// Gains of the wrinkles: V weights, from 0 to 1, and the gain over time.
    details: Vec<(Vec<f32>, Curve)>,
}

impl Layers {
    /// Reads a file of edits and all that it names within `reach`.
    ///
    /// # Errors
    /// As [`edits::read`], and as reading takes and meshes. [`rhytid_core::Error::Input`] for a region or a
    /// marker that the rig does not have.
    pub fn read(path: &Path, rig: &Rig, reach: Reach) -> Result<Self> {
        let (_, text) = edits::read(path)?;
        Self::of_text(text, path, rig, reach)
    }

    /// The same of a `text` that is not in a file yet. The files that it names are relative to `path`.
    ///
    /// # Errors
    /// As [`Layers::read`].
    pub fn of_text(text: String, path: &Path, rig: &Rig, reach: Reach) -> Result<Self> {
        let edits = edits::parse(&text, &path.display().to_string())?;
        let mut hash = blake3::Hasher::new();
        hash.update(text.as_bytes());
        // A file that is named many times is read and kept once.
        let mut hashes: HashMap<PathBuf, String> = HashMap::new();
        let mut takes: HashMap<&Path, Arc<Take>> = HashMap::new();
        let mut meshes: HashMap<&Path, Arc<[[f64; 3]]>> = HashMap::new();
        for (key, file) in edits.named_files() {
            let file = named_file(path, file, &key, reach)?;
            let found = match hashes.get(&file) {
                Some(found) => found,
                None => {
                    let found = rig_file::hash(&file)?;
                    hashes.entry(file).or_insert(found)
                }
            };
            hash.update(found.as_bytes());
        }
        let rest = Mesh {
            positions: rig.surface().rest.iter().map(|x| x.map(f64::from)).collect(),
            faces: rig.surface().faces.clone(),
            ..Mesh::default()
        };
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut regions = Regions::new(path, &edits, rig, &rest);
        let in_mesh_units = |x: [f64; 3]| x.map(|x| x * 1e-3 / rig.surface().metres_per_unit);
        let hash = hash.finalize().to_hex().to_string();
        let mut layers = Self { path: path.to_owned(), text, hash, ..Self::default() };
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
        for added in &edits.added {
            let file = folder.join(&added.take);
            let other = match takes.get(&*added.take) {
                Some(other) => other.clone(),
                None => {
                    let other = take::read(&file, None, Missing::Hold)?;
                    takes.entry(&added.take).or_insert(Arc::new(other)).clone()
                }
            };
            let weights = regions.handles(added.region.as_deref())?;
            let other = AddedTake::new(other, rig, weights, added);
            layers.added.push(other.map_err(|error| error.in_file(file.display()))?);
        }
        for hold in &edits.holds {
            layers.holds.push(Held { weights: regions.handles(hold.region.as_deref())?, hold: hold.clone() });
        }
        for correction in &edits.corrections {
            let file = folder.join(&correction.mesh);
            let positions = match meshes.get(&*correction.mesh) {
                Some(positions) => positions.clone(),
                None => {
                    let positions = mesh::read_like(&rest, Path::new("the rig"), &file)?;
                    meshes.entry(&correction.mesh).or_insert(positions.into()).clone()
                }
            };
            let weights = regions.vertices(correction.region.as_deref())?;
            layers.corrections.push(Sculpt { positions, weights, correction: correction.clone() });
        }
        // A gain moves no handle.
        let alike = rig.handles().alike();
        for detail in &edits.details {
            let mut weights = regions.vertices(detail.region.as_deref())?;
            alike.iter().for_each(|(corner, as_of)| weights[corner.index()] = weights[as_of.index()]);
            layers.details.push((weights, detail.by.clone()));
        }
        Ok(layers)
    }

    /// The file's text, which exports contain.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The file of the edits.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A hash of the edits: of the text, and of the contents of all files that it names.
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// The take with its handles edited, together with the take before the edits. Frames and markers without
    /// edits keep every bit.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Input`] if the take lacks handles, or a frame that is held.
    pub fn edit(&self, take: Take, rig: &Rig) -> Result<EditedTake> {
        handles::edit(self, take, rig)
    }

    /// What is left of moves that are added to the handles of a take, once the holds have been applied.
    ///
    /// `moved` gives H vectors for each frame of the take. The result is for `frame`, in the same unit. The
    /// edited take with these vectors added to it is the same as a take that is edited with them as offsets.
    pub fn let_through(&self, frame: usize, moved: &dyn Fn(usize) -> Vec<[f64; 3]>) -> Vec<[f64; 3]> {
        handles::let_through(&self.holds, frame, moved)
    }

    /// The rig with its own wrinkles multiplied by those gains that are the same in all frames.
    ///
    /// `rig` is the rig that the layers were read for. The layers lose these gains, which cost nothing in the
    /// rig.
    ///
    /// # Errors
    /// As [`Rig::scale_wrinkles`].
    pub fn settle(&mut self, rig: Rig) -> Result<Rig> {
        let mut factors = vec![1.0; rig.vertices()];
        self.details.retain(|(weights, by)| {
            let gain = VertexGain::new(weights, by.clone());
            let Some(by) = gain.constant() else { return true };
            gain.factors(by).for_each(|(v, factor)| factors[v] *= factor);
            false
        });
        rig.scale_wrinkles(|v| factors[v])
    }

    /// The sculpted frames.
    pub(crate) fn sculpted(&self) -> &[Sculpt] {
        &self.corrections
    }

    /// The gains of wrinkles, over the time of the take that is edited.
    pub(crate) fn vertex_gains(&self, take: &Take) -> Vec<VertexGain> {
        let timed = |(weights, by): &(Vec<f32>, Curve)| VertexGain::new(weights, timed(take, by));
        self.details.iter().map(timed).collect()
    }
}

/// A frame that was sculpted.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sculpt {
    /// V, in mesh units.
    pub positions: Arc<[[f64; 3]]>,
    /// V, from 0 to 1.
    pub weights: Vec<f32>,
    pub correction: edits::Correction,
}

/// A curve over a take's frames, as a curve over the take's time.
pub(crate) fn timed(take: &Take, curve: &Curve) -> Curve {
    let keys = curve.keys.iter().map(|&(frame, value)| (time_of(take, frame), value)).collect();
    Curve { keys, ease: curve.ease }
}

/// The time of a frame number, which may lie between two frames or beyond the take's ends.
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
