//! The check of every frame, whatever the format.

use crate::export::{Exporter, Frame, Scene, Written, first_not_finite};
use rhytid_core::{Error, Progress, Result};
use std::path::{Path, PathBuf};

/// Checks the frames on their way to any exporter, so that none has to.
pub(super) struct Checked {
    exporter: Box<dyn Exporter>,
    path: PathBuf,
    vertices: usize,
    normals: bool,
    velocities: bool,
    sigma: bool,
    strain: bool,
    frames: usize,
    /// Frames passed on.
    done: usize,
}

impl Checked {
    pub(super) fn new(exporter: Box<dyn Exporter>, path: &Path, scene: &Scene<'_>) -> Self {
        Self {
            exporter,
            path: path.to_owned(),
            vertices: scene.rest.len(),
            normals: scene.rest_normals.is_some(),
            velocities: scene.velocities,
            sigma: scene.sigma,
            strain: scene.strain,
            frames: scene.frames,
            done: 0,
        }
    }

    fn fault(&self, frame: Frame<'_>) -> Option<String> {
        if self.done == self.frames {
            return Some(format!("one frame more than the {} announced", self.frames));
        }
        for (what, numbers, wanted, per_vertex) in [
            ("positions", Some(frame.positions), true, 3),
            ("normals", frame.normals, self.normals, 3),
            ("velocities", frame.velocities, self.velocities, 3),
            ("standard deviations", frame.sigma, self.sigma, 1),
            ("strains", frame.strain.map(|of| of.strains.as_flattened()), self.strain, 2),
            ("first strain directions", frame.strain.map(|of| of.first.as_flattened()), self.strain, 3),
            ("second strain directions", frame.strain.map(|of| of.second.as_flattened()), self.strain, 3),
        ] {
            let Some(numbers) = numbers.filter(|_| wanted) else {
                if wanted == numbers.is_some() {
                    continue;
                }
                let (found, expected) = if wanted { ("no ", "some") } else { ("", "none") };
                return Some(format!("frame {} (from 0) has {found}{what}, expected {expected}", self.done));
            };
            if numbers.len() != self.vertices * per_vertex {
                return Some(format!(
                    "frame {} (from 0) has {} numbers as {what}, expected {} vertices × {per_vertex}",
                    self.done,
                    numbers.len(),
                    self.vertices
                ));
            }
            // The number's own place, where that of the vertex is another.
            let place = || numbers.iter().position(|x| !x.is_finite());
            if let Some(vertex) = first_not_finite(numbers).and_then(|_| Some(place()? / per_vertex)) {
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
    fn frame(&mut self, frame: Frame<'_>) -> Result<()> {
        if let Some(fault) = self.fault(frame) {
            return Err(Error::input(format!("{}: {fault}", self.path.display())));
        }
        self.exporter.frame(frame)?;
        self.done += 1;
        Ok(())
    }

    fn finish(self: Box<Self>, progress: &dyn Progress) -> Result<Written> {
        if self.done < self.frames {
            return Err(Error::input(format!(
                "{}: finished after {} frames of {} announced",
                self.path.display(),
                self.done,
                self.frames
            )));
        }
        self.exporter.finish(progress)
    }
}
