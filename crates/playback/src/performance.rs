//! A performance: a recipe with its rig, its take and its edits, ready to be played.

use crate::{EditedTake, FrameRange, Layers, Playback, Selection, channels, check_gains, scale_folds};
use rhytid_core::{ChannelKind, DeviceInfo, Error, Progress, Remedy, Result, Rig, Take, human};
use rhytid_formats::export::{OutputStage, Recipe};

/// All that decides the frames of an animation. Whoever makes one, and whoever makes it again to compare it, goes this one way.
#[derive(Debug, Clone, PartialEq)]
pub struct Performance {
    /// The rig as it is played: of the recipe's stage, with its gains.
    pub rig: Rig,
    /// The recipe.
    pub recipe: Recipe,
    /// The whole take, with its edits.
    pub take: EditedTake,
    /// The frames that are played.
    pub selection: Selection,
    layers: Option<Layers>,
}

impl Performance {
    /// Does to `rig` and `take` what the recipe says. `layers` are the edits, read for this rig.
    ///
    /// # Errors
    /// [`Error::Input`] if the take lacks frames that the recipe names, or handles; as [`scale_folds`], [`Layers::edit`] and [`Selection::new`].
    pub fn new(mut recipe: Recipe, mut rig: Rig, take: Take, layers: Option<Layers>) -> Result<Self> {
        if recipe.end_frame == 0 {
            recipe.end_frame = take.frames() as u64;
        }
        Self::check(&recipe, &rig)?;
        if recipe.stage == OutputStage::Shell {
            rig = rig.shell()?;
        }
        rig = scale_folds(rig.scale_folds(|_| recipe.detail)?, &recipe.detail_of.0)?;
        let mut layers = layers;
        let take = match &mut layers {
            Some(layers) => {
                let take = layers.edit(take, &rig)?;
                rig = layers.settle(rig)?;
                take
            }
            None => take.into(),
        };
        let index = |frame: u64| Some(usize::try_from(frame).unwrap_or(usize::MAX));
        let range = FrameRange { start: index(recipe.first_frame), end: index(recipe.end_frame) };
        let range = range.within(take.frames())?;
        let selection = Selection::new(take.clone(), range, recipe.fps, recipe.has(ChannelKind::Velocities))?;
        Ok(Self { rig, recipe, take, selection, layers })
    }

    /// Whether the rig can do what the recipe says: asked before a take is recorded, which would be lost.
    ///
    /// # Errors
    /// [`Error::Input`] if it is to be refined and has examples, a gain or a group of wrinkles names what it does not have, or it does not know
    /// what a channel says.
    pub fn check(recipe: &Recipe, rig: &Rig) -> Result<()> {
        if recipe.refine && !rig.examples().names.is_empty() {
            return Err(Error::conflict(format!(
                "refinement is for rigs without examples, found {}, which show better what becomes of the face; leave it out",
                human::counted(rig.examples().len(), "example")
            )).with_remedies(&[Remedy::NoRefinement]));
        }
        check_gains(&rig.handles().labels, &recipe.detail_of.0)?;
        channels::of_recipe(rig, recipe).map(|_| ())
    }

    /// The performance on the first of `devices` that has room for its rig.
    ///
    /// # Errors
    /// As [`Playback::new`] and [`Playback::with_layers`].
    pub fn playback(&self, devices: &[DeviceInfo], progress: &dyn Progress) -> Result<Playback<'_>> {
        let playback = Playback::new(&self.rig, devices, self.selection.take.frames())?;
        match &self.layers {
            Some(layers) => playback.with_layers(layers, &self.take, progress),
            None => Ok(playback),
        }
    }
}
