//! A vertex animation as a base mesh and few morph targets.
//!
//! [`Frames`] takes the frames one at a time and keeps them in a file.
//!
//! [`Frames::compress`] looks for the fewest targets with which no vertex of any frame is off by more than a
//! bound. The result holds all numbers as a glTF file holds them:
//!
//! `position(frame, v) = translation + scale · (base[v] + Σ_k weights[frame, k] · targets[k].positions[v])`
//!
//! where integers stand for their normalised values (`i8 / 127`, `i16 / 32767`).
//!
//! Principal components make the mean error small. But the bound is on the worst vertex, and a few percent of
//! the vertices decide it. So the components are only the start.
//!
//! - `fit` looks for a matrix of low rank that keeps every vertex of every frame within the bound. It
//!   projects in turn onto the matrices within the bound and onto those of low rank (ADMM).
//! - `active` does most of the work, on the vertices and frames near the bound.
//! - `search` finds the least rank for which `fit` succeeds.
//! - `long` lets `search` look at some frames of a long take, chosen by their `sketches`. The other frames
//!   get their `weights` one by one, by `steps` that look at the vertices near the bound.
//! - `basis` turns the result so that rounding does the least harm.
//! - `rounding` makes the numbers of the file.
//! - `measure` gives their distance from the frames that came in, in `parts`.
//!
//! [`Frames::onto`] looks for weights alone: `onto` fits the frames to shapes that are given, with the
//! `bounded` least squares.

mod active;
mod basis;
mod bounded;
mod factors;
mod fit;
mod fitted;
mod frames;
mod linear;
mod long;
mod measure;
mod normals;
mod onto;
mod parts;
mod rounding;
mod search;
mod settings;
mod sketches;
mod span;
mod steps;
#[cfg(test)]
mod tests;
mod values;
mod weights;

pub use frames::Frames;
pub use settings::Settings;
pub use values::{ClipErrors, Morphs, Off, Target, Values};

use rhytid_core::{Error, Progress, Remedy, Result};

/// The part of the bound that the truncation to few targets may use if integers need the rest.
const SHARE_OF_TRUNCATION: f64 = 0.7;
/// The same part if only the rounding to float32 needs the rest.
const SHARE_OF_FLOATS: f64 = 0.98;

/// How many bounds the truncation tries. Each is tighter than the last, because the rounding used more than
/// what was left.
const TRIES: usize = 4;

impl Frames {
    /// The fewest targets found that meet `settings.max_error`.
    ///
    /// # Errors
    /// [`Error::Input`] if there is no frame or no vertex, if more than `settings.most_targets` are needed,
    /// or if the bound is finer than float32 allows; [`Error::Io`]; [`Error::Cancelled`].
    pub fn compress(mut self, settings: &Settings, progress: &dyn Progress) -> Result<Morphs> {
        let path = self.path().display().to_string();
        if self.vertices() == 0 || self.frames() == 0 {
            return Err(Error::empty(format!("{path}: there is nothing to write: no frame or no vertex")));
        }
        if !(settings.max_error.is_finite() && settings.max_error > 0.0) {
            return Err(Error::out_of_range(format!(
                "{path}: the largest error is {}, expected a positive number",
                settings.max_error
            )));
        }
        let share = if settings.quantize { SHARE_OF_TRUNCATION } else { SHARE_OF_FLOATS };
        let mut bound = settings.max_error * share;
        for _ in 0..TRIES {
            let Some(found) = long::fewest(&mut self, bound, settings.most_targets, progress)? else {
                if settings.most_targets < self.frames() - 1 {
                    return Err(too_many(&path, settings));
                }
                break;
            };
            let basis = basis::turn(found.fit, &found.weights)?;
            let morphs =
                rounding::round(&mut self, &found.center, &found.chosen, &basis, settings, progress)?;
            if morphs.worst() <= settings.max_error {
                return Ok(morphs);
            }
            bound -= 1.2 * (morphs.worst() - settings.max_error);
            if bound < 0.25 * share * settings.max_error {
                break;
            }
        }
        // With all columns, the only error is that of rounding. The hardest frames have it too.
        let chosen = long::first(&self);
        let all: Vec<usize> = (0..chosen.len()).collect();
        self.choose(chosen);
        let gram = self.gram(progress)?;
        let q = linear::principal(&gram.matrix)?.vectors;
        let basis = basis::turn(factors::Fit::on(&mut self, &gram, q.clone())?, &q)?;
        let finest = rounding::round(&mut self, &gram.center, &all, &basis, settings, progress)?.worst();
        Err(too_fine(&path, settings, 2.0 * finest))
    }
}

impl Frames {
    /// Finds `shapes` targets (or as few as all frames need) with the least bound found that they meet.
    /// [`Morphs::worst`] has the error.
    ///
    /// # Errors
    /// [`Error::Input`] if there is no frame or no vertex, or `shapes` is 0; [`Error::Io`];
    /// [`Error::Cancelled`].
    pub fn bake(mut self, shapes: usize, quantize: bool, progress: &dyn Progress) -> Result<Morphs> {
        let path = self.path().display().to_string();
        if self.vertices() == 0 || self.frames() == 0 {
            return Err(Error::empty(format!("{path}: there is nothing to write: no frame or no vertex")));
        }
        if shapes == 0 {
            return Err(Error::out_of_range(format!("{path}: 0 shapes were asked for, expected at least 1")));
        }
        let (found, bound) = long::nearest(&mut self, shapes, progress)?;
        let basis = basis::turn(found.fit, &found.weights)?;
        // The rounding to integers may add a part of the error of the shapes.
        let max_error = (bound / SHARE_OF_TRUNCATION).max(f64::MIN_POSITIVE);
        let settings = Settings { max_error, most_targets: shapes, quantize };
        rounding::round(&mut self, &found.center, &found.chosen, &basis, &settings, progress)
    }
}

fn too_many(path: &str, settings: &Settings) -> Error {
    let most = settings.most_targets;
    Error::too_large(format!(
        "{path}: more than {most} morph targets are needed to keep every vertex within {:.3e} mesh units, and \
         {most} is the most allowed: raise the largest error, export fewer frames, write USD, or lift the limit",
        settings.max_error
    )).with_remedies(&[Remedy::LargerError, Remedy::MostTargets, Remedy::Force])
}

fn too_fine(path: &str, settings: &Settings, expected: f64) -> Error {
    Error::out_of_range(format!(
        "{path}: an error of at most {:.3e} mesh units is finer than the float32 numbers of a morphed mesh of this \
         size allow; expected {expected:.3e} or more: raise the largest error, or write USD, which is \
         exact",
        settings.max_error
    )).with_remedies(&[Remedy::LargerError])
}
