//! The check of every frame, for all formats.

use rhytid_core::channel::{self, Channel, Interpolation, Timing};
use rhytid_core::numbers::first_not_finite;
use rhytid_core::{Error, Progress, Result};
use rhytid_export::{Exporter, Frame, Scene, Written};
use std::path::{Path, PathBuf};

/// Checks the frames on their way to any exporter, so that no exporter has to.
pub(super) struct Checked {
    exporter: Box<dyn Exporter>,
    path: PathBuf,
    /// The channels of the frames, each with its number of values in a frame.
    channels: Vec<(Channel, usize)>,
    frames: usize,
    /// Frames passed on.
    done: usize,
}

impl Checked {
    pub(super) fn new(exporter: Box<dyn Exporter>, path: &Path, scene: &Scene<'_>) -> Self {
        let channels = std::iter::once(&channel::POSITIONS).chain(scene.channels);
        let channels = channels.map(|channel| (channel.clone(), scene.numbers(channel))).collect();
        Self { exporter, path: path.to_owned(), channels, frames: scene.all_frames(), done: 0 }
    }

    fn fault(&self, frame: &Frame<'_>) -> Option<String> {
        if self.done == self.frames {
            return Some(format!("one frame more than the {} announced", self.frames));
        }
        let here = format!("frame {} (from 0) has", self.done);
        let is_wanted =
            |(channel, _): &&(Channel, usize)| channel.timing == Timing::PerFrame || self.done == 0;
        for (channel, expected) in self.channels.iter().filter(is_wanted) {
            let (what, width) = (&channel.words, channel.width);
            let Some(numbers) = frame.get(channel) else {
                return Some(format!("{here} no {what}, expected some"));
            };
            if numbers.len() != *expected {
                let values = expected / width;
                let of = if channel.interpolation == Interpolation::Vertex { "vertices" } else { "faces" };
                return Some(format!(
                    "{here} {} numbers as {what}, expected {values} {of} × {width}",
                    numbers.len()
                ));
            }
            if let Some(vertex) = first_not_finite(numbers).map(|i| i / width) {
                return Some(format!("{here} {what} that are not finite, first at vertex {vertex}"));
            }
        }
        let is_unknown = |(found, _): &(&Channel, _)| {
            !self.channels.iter().filter(is_wanted).any(|(known, _)| known.name == found.name)
        };
        let unknown = frame.channels().find(is_unknown);
        unknown.map(|(channel, _)| format!("{here} {}, expected none", channel.words))
    }
}

impl Exporter for Checked {
    fn frame(&mut self, frame: &Frame<'_>) -> Result<()> {
        if let Some(fault) = self.fault(frame) {
            return Err(Error::mismatch(format!("{}: {fault}", self.path.display())));
        }
        self.exporter.frame(frame)?;
        self.done += 1;
        Ok(())
    }

    fn finish(self: Box<Self>, progress: &dyn Progress) -> Result<Written> {
        if self.done < self.frames {
            return Err(Error::mismatch(format!(
                "{}: finished after {} frames of {} announced",
                self.path.display(),
                self.done,
                self.frames
            )));
        }
        self.exporter.finish(progress)
    }
}
