//! Export of a take into a file.

use crate::{Performance, Playback, channels};
use rhytid_core::{Channel, ChannelKind, Progress, Result, Rig};
use rhytid_formats::animation;
use rhytid_formats::export::{Frame, HeadMotion, Options, Recipe, Scene, StatedRecipe, Written};
use std::path::Path;

/// Checks that a file of so many frames can be written, before there are any: what must be refused has to be
/// refused before a recording.
///
/// # Errors
/// [`rhytid_core::Error::Input`] as from [`Playback::export`], as far as it does not depend on the frames.
pub fn check_export(rig: &Rig, recipe: &Recipe, frames: usize, path: &Path, options: &Options) -> Result<()> {
    let (corners, channels) = (rig.surface().triangle_corners()?, channels::of_recipe(rig, recipe)?);
    let normals = recipe.has(ChannelKind::Normals).then(|| vec![[0.0; 3]; rig.vertices()]);
    let stated = StatedRecipe::from(recipe);
    let scene = Scene {
        rest_normals: normals.as_deref(),
        channels: &channels,
        frames,
        rate: 60.0,
        ..Scene::new(rig, &corners, &stated)
    };
    animation::create(path, &scene, options).map(drop)
}

/// What the scene of a performance is made of, beside the rig and the take.
pub(crate) struct SceneParts {
    rest_normals: Option<Vec<[f32; 3]>>,
    corners: Vec<[u32; 3]>,
    channels: Vec<Channel>,
    stated: StatedRecipe,
}

impl SceneParts {
    pub(crate) fn new(playback: &mut Playback<'_>, performance: &Performance) -> Result<Self> {
        let recipe = &performance.recipe;
        let rest_normals = recipe.has(ChannelKind::Normals).then(|| playback.rest_normals()).transpose()?;
        Ok(Self {
            rest_normals,
            corners: playback.rig().surface().triangle_corners()?,
            channels: channels::of_recipe(playback.rig(), recipe)?,
            stated: StatedRecipe::from(recipe),
        })
    }

    pub(crate) fn scene<'a>(&'a self, rig: &'a Rig, performance: &'a Performance) -> Scene<'a> {
        let Performance { selection, recipe, first_time_code, .. } = performance;
        Scene {
            rest_normals: self.rest_normals.as_deref(),
            channels: &self.channels,
            head: selection.head().filter(|_| recipe.head == HeadMotion::Keep),
            frames: selection.inner.len(),
            rate: selection.rate,
            first_time_code: *first_time_code as f64,
            ..Scene::new(rig, &self.corners, &self.stated)
        }
    }
}

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
        let (selection, recipe) = (&performance.selection, &performance.recipe);
        let parts = SceneParts::new(self, performance)?;
        let scene = parts.scene(self.rig(), performance);
        let frames = scene.frames;
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
