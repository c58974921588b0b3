//! Export of a take into a file.

use crate::{Performance, Playback, channels};
use rhytid_core::{ChannelKind, Progress, Result};
use rhytid_formats::animation;
use rhytid_formats::export::{Frame, HeadMotion, Options, Scene, StatedRecipe, Written};
use std::path::Path;

impl Playback<'_> {
    /// Plays a performance of this rig into the file `path`, in the format of its extension. The file
    /// contains the recipe. If the export fails, no file remains.
    ///
    /// # Errors
    /// As [`animation::create`] and [`Playback::play`].
    pub fn export(
        &mut self,
        performance: &Performance,
        path: &Path,
        options: &Options,
        progress: &dyn Progress,
    ) -> Result<Written> {
        self.export_seen(performance, path, options, progress, |_| Ok(()))
    }

    /// As [`Playback::export`], and also hands every frame to `seen`, for another use of it.
    ///
    /// # Errors
    /// As [`Playback::export`] and `seen`.
    pub fn export_seen(
        &mut self,
        performance: &Performance,
        path: &Path,
        options: &Options,
        progress: &dyn Progress,
        mut seen: impl FnMut(&Frame<'_>) -> Result<()>,
    ) -> Result<Written> {
        let (rig, Performance { selection, recipe, .. }) = (self.rig(), performance);
        let rest_normals = recipe.has(ChannelKind::Normals).then(|| self.rest_normals()).transpose()?;
        let (corners, channels) = (rig.surface().triangle_corners()?, channels::of_recipe(rig, recipe)?);
        let frames = selection.inner.len();
        let stated = StatedRecipe::from(recipe);
        let scene = Scene {
            rest_normals: rest_normals.as_deref(),
            channels: &channels,
            head: selection.head().filter(|_| recipe.head == HeadMotion::Keep),
            frames,
            rate: selection.rate,
            first_time_code: selection.first as f64,
            ..Scene::new(rig, &corners, &stated)
        };
        let mut exporter = animation::create(path, &scene, options)?;
        let mut done = 0;
        progress.report("animate", 0, frames as u64);
        self.play(selection, recipe, progress, |frame| {
            seen(frame)?;
            exporter.frame(frame)?;
            done += 1;
            progress.report("animate", done, frames as u64);
            Ok(())
        })?;
        exporter.finish(progress)
    }
}
