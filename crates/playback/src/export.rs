//! Export of a take into a file.

use crate::{Performance, Playback, channels};
use rhytid_core::{Channel, ChannelKind, DeviceInfo, Error, Progress, Result, Rig, RigidMotion};
use rhytid_formats::animation;
use rhytid_formats::export::{Clip, Frame, HeadMotion, Options, Recipe, Scene, StatedRecipe, Written};
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
        let Performance { selection, first_time_code, .. } = performance;
        Scene {
            rest_normals: self.rest_normals.as_deref(),
            channels: &self.channels,
            head: performance.head_of_file(),
            frames: selection.inner.len(),
            rate: selection.rate,
            first_time_code: *first_time_code as f64,
            ..Scene::new(rig, &self.corners, &self.stated)
        }
    }
}

/// Plays performances of one rig into the file `path`, one after the other: each is a clip of its own. All
/// share the shapes that `options` ask for. Each performance is played on the first of `devices` that has
/// room for its rig. Returns what was written, and the device of the last performance.
///
/// # Errors
/// As [`Playback::export`]. [`rhytid_core::Error::Input`] if the format has no place for so many clips, or if
/// the clips differ in their channels; [`rhytid_core::Error::Internal`] without performances.
pub fn export_clips(
    performances: &[Performance],
    devices: &[DeviceInfo],
    path: &Path,
    options: &Options,
    progress: &dyn Progress,
) -> Result<(Written, DeviceInfo)> {
    let [first, further @ ..] = performances else {
        return Err(Error::Internal("there are no takes to export".into()));
    };
    let mut playback = first.playback(devices, progress)?;
    let parts = SceneParts::new(&mut playback, first)?;
    let stated: Vec<StatedRecipe> =
        further.iter().map(|performance| StatedRecipe::from(&performance.recipe)).collect();
    let clips = further.iter().zip(&stated).map(|(performance, recipe)| Clip {
        head: performance.head_of_file(),
        frames: performance.selection.inner.len(),
        rate: performance.selection.rate,
        first_time_code: performance.first_time_code as f64,
        recipe,
    });
    let clips: Vec<Clip<'_>> = clips.collect();
    let scene = Scene { further: &clips, ..parts.scene(&first.rig, first) };
    let frames = scene.all_frames() as u64;
    let mut exporter = animation::create(path, &scene, options)?;
    let mut done = 0;
    progress.report("animate", 0, frames);
    for performance in performances {
        if done > 0 {
            playback = performance.playback(devices, progress)?;
        }
        playback.play(&performance.selection, &performance.recipe, progress, |frame| {
            exporter.frame(frame)?;
            done += 1;
            progress.report("animate", done, frames);
            Ok(())
        })?;
    }
    let device = playback.device().clone();
    drop(playback);
    Ok((exporter.finish(progress)?, device))
}

impl Performance {
    /// The head pose in each frame, if a file has it beside the positions.
    fn head_of_file(&self) -> Option<&[RigidMotion]> {
        self.selection.head().filter(|_| self.recipe.head == HeadMotion::Keep)
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
