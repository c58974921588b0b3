//! Export: a take played into a file.

use crate::{Playback, PlaybackOptions, Selection};
use rhytid_core::{Progress, Result};
use rhytid_formats::animation;
use rhytid_formats::export::{Frame, HeadMotion, Options, Provenance, Scene, Written};
use std::path::Path;

impl Playback<'_> {
    /// Plays the selection's inner frames into the file `path`, in the format of its extension. `provenance` stands in the file;
    /// [`Provenance::default`] where nobody will ask. Nothing is left behind if it fails.
    ///
    /// # Errors
    /// As [`animation::create`] and [`Playback::play`].
    pub fn export(
        &mut self,
        selection: &Selection,
        options: PlaybackOptions,
        path: &Path,
        format_options: &Options,
        provenance: &Provenance,
        progress: &dyn Progress,
    ) -> Result<Written> {
        self.export_seen(selection, options, path, format_options, provenance, progress, |_| {})
    }

    /// As [`Playback::export`], with every frame also shown to `seen`, which makes something else of it.
    ///
    /// # Errors
    /// As [`Playback::export`].
    #[expect(clippy::too_many_arguments, reason = "the export's own, and who looks on")]
    pub fn export_seen(
        &mut self,
        selection: &Selection,
        options: PlaybackOptions,
        path: &Path,
        format_options: &Options,
        provenance: &Provenance,
        progress: &dyn Progress,
        mut seen: impl FnMut(&Frame<'_>),
    ) -> Result<Written> {
        let rig = self.rig();
        let rest_normals = options.normals.then(|| self.rest_normals()).transpose()?;
        let corners = rig.triangle_corners()?;
        let frames = selection.inner.len();
        let scene = Scene {
            rest_normals: rest_normals.as_deref(),
            velocities: options.velocities,
            sigma: options.sigma,
            strain: options.strain,
            head: selection.head().filter(|_| options.head == HeadMotion::Keep),
            frames,
            rate: selection.rate,
            first_time_code: selection.first as f64,
            ..Scene::of(rig, &corners, provenance)
        };
        let mut exporter = animation::create(path, &scene, format_options)?;
        let mut done = 0;
        progress.report("animate", 0, frames as u64);
        self.play(selection, options, progress, |frame| {
            seen(&frame);
            exporter.frame(frame)?;
            done += 1;
            progress.report("animate", done, frames as u64);
            Ok(())
        })?;
        exporter.finish(progress)
    }
}
