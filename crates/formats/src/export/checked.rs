use super::scene::first_not_finite;
use super::{Exporter, Scene};
use rhytid_core::{Error, Result};
use std::path::{Path, PathBuf};

/// Checks the frames on their way to any exporter, so that none has to.
pub(super) struct Checked {
    exporter: Box<dyn Exporter>,
    path: PathBuf,
    vertices: usize,
    frames: usize,
    /// Frames passed on.
    done: usize,
}

impl Checked {
    pub(super) fn new(exporter: Box<dyn Exporter>, path: &Path, scene: &Scene<'_>) -> Self {
        Self { exporter, path: path.to_owned(), vertices: scene.rest.len(), frames: scene.frames, done: 0 }
    }

    fn fault(&self, positions: &[f32], normals: &[f32]) -> Option<String> {
        if self.done == self.frames {
            return Some(format!("one frame more than the {} announced", self.frames));
        }
        for (what, numbers) in [("positions", positions), ("normals", normals)] {
            if numbers.len() != self.vertices * 3 {
                return Some(format!(
                    "frame {} (from 0) has {} numbers as {what}, expected {} vertices × 3",
                    self.done,
                    numbers.len(),
                    self.vertices
                ));
            }
            if let Some(vertex) = first_not_finite(numbers) {
                return Some(format!(
                    "frame {} (from 0) has {what} that are not finite, first at vertex {vertex}",
                    self.done
                ));
            }
        }
        None
    }
}

impl Exporter for Checked {
    fn frame(&mut self, positions: &[f32], normals: &[f32]) -> Result<()> {
        if let Some(fault) = self.fault(positions, normals) {
            return Err(Error::input(format!("{}: {fault}", self.path.display())));
        }
        self.exporter.frame(positions, normals)?;
        self.done += 1;
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        if self.done < self.frames {
            return Err(Error::input(format!(
                "{}: finished after {} frames of {} announced",
                self.path.display(),
                self.done,
                self.frames
            )));
        }
        self.exporter.finish()
    }
}
