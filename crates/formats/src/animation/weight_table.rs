//! A take as a table of the weights of given shapes.

use rhytid_core::{AtomicFile, Error, Progress, Result};
use rhytid_export::morphs::{ClipErrors, Frames};
use rhytid_export::{Exporter, Frame, Options, Scene, ShapeSet, Written};
use rhytid_takes::curves;
use std::path::{Path, PathBuf};

/// Frames on their way to weights.
pub(super) struct WeightTable {
    path: PathBuf,
    frames: Frames,
    set: ShapeSet,
    first_time_code: usize,
    rate: f64,
}

impl WeightTable {
    /// # Errors
    /// [`Error::Input`] if `options` give no shapes, or the folder does not exist; [`Error::Io`].
    pub(super) fn create(path: &Path, scene: &Scene<'_>, options: &Options) -> Result<Self> {
        let Some(set) = options.onto.clone() else {
            return Err(Error::conflict(format!(
                "{}: a table holds weights of given shapes; give the shapes, or write .usd or .glb",
                path.display()
            )));
        };
        let spool = AtomicFile::create(path)?.spool()?;
        Ok(Self {
            path: path.to_owned(),
            frames: Frames::new(spool, path, scene.rest.len(), false, Vec::new()),
            set,
            first_time_code: scene.first_time_code.max(0.0) as usize,
            rate: scene.rate,
        })
    }
}

impl Exporter for WeightTable {
    fn frame(&mut self, frame: &Frame<'_>) -> Result<()> {
        self.frames.push(frame.positions(), None, &[])
    }

    fn finish(self: Box<Self>, progress: &dyn Progress) -> Result<Written> {
        let Self { path, frames, set, first_time_code, rate } = *self;
        let morphs = frames.onto(&set, progress)?;
        let names: Vec<String> = set.shapes.into_iter().map(|shape| shape.name).collect();
        curves::write_weights(&path, &names, first_time_code, rate, &morphs.weights)?;
        let bytes = std::fs::metadata(&path).map_err(Error::io(&path))?.len();
        let errors = morphs.clips.iter().map(ClipErrors::deviation).collect();
        Ok(Written { bytes, targets: Some(names.len()), errors })
    }
}
