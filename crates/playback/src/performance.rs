//! A performance: a recipe with its rig, its take and its edits, ready to be played.

use crate::{EditedTake, FrameRange, Layers, Playback, Selection, channels, check_gains, scale_wrinkles};
use rhytid_core::{ChannelKind, DeviceInfo, Error, Progress, Remedy, Result, Rig, Take, human};
use rhytid_formats::export::{OutputStage, Recipe};

/// All that decides the frames of an animation.
///
/// An export and its later comparison make their performance in this same way.
#[derive(Debug, Clone, PartialEq)]
pub struct Performance {
    /// The rig as it is played: at the recipe's stage, with the recipe's gains.
    pub rig: Rig,
    /// The recipe.
    pub recipe: Recipe,
    /// The whole take, with its edits.
    pub take: EditedTake,
    /// The frames that are played.
    pub selection: Selection,
    /// The time code of the first frame that is played.
    pub first_time_code: usize,
    layers: Option<Layers>,
}

impl Performance {
    /// Applies the recipe to `rig` and `take`. `layers` are the edits, read for this rig.
    ///
    /// # Errors
    /// [`Error::Input`] if the take lacks handles, or frames that the recipe names. Otherwise the errors of
    /// [`scale_wrinkles`], [`Layers::edit`] and [`Selection::new`].
    pub fn new(mut recipe: Recipe, mut rig: Rig, take: Take, layers: Option<Layers>) -> Result<Self> {
        if recipe.end_frame == 0 {
            recipe.end_frame = take.frames() as u64;
        }
        Self::check(&recipe, &rig)?;
        if recipe.stage == OutputStage::Shell {
            rig = rig.shell()?;
        }
        rig = scale_wrinkles(rig.scale_wrinkles(|_| recipe.detail)?, &recipe.detail_of.0)?;
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
        let start = recipe.start_frame.unwrap_or_else(|| place_in_session(&take.take, selection.rate));
        let first_time_code = usize::try_from(start).unwrap_or(usize::MAX).saturating_add(selection.first);
        warn_of_late_frames(first_time_code.saturating_add(selection.inner.len()));
        Ok(Self { rig, recipe, take, selection, first_time_code, layers })
    }

    /// Checks that the rig can do what the recipe says. Call it before a take is recorded, which would be
    /// lost otherwise.
    ///
    /// # Errors
    /// [`Error::Input`] if the recipe refines a rig with examples, or if the rig has no data for a channel.
    /// Also if a gain or a wrinkle group names something that the rig lacks.
    pub fn check(recipe: &Recipe, rig: &Rig) -> Result<()> {
        if recipe.refine && !rig.examples().names.is_empty() {
            return Err(Error::conflict(format!(
                "refinement is for rigs without examples, found {}, whose learned detail is better; leave \
                 the refinement out",
                human::counted(rig.examples().len(), "example")
            ))
            .with_remedies(&[Remedy::NoRefinement]));
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

/// The number of the take's first frame in its session, whose frame 0 is at time 0. It is 0 if the take's
/// clock is no session's: if it begins before 0, or more than a day after.
fn place_in_session(take: &Take, rate: f64) -> u64 {
    const DAY: f64 = 86_400.0;
    match take.times.first() {
        Some(&start) if (0.0..=DAY).contains(&start) => (start * rate).round() as u64,
        _ => 0,
    }
}

/// Blender's timeline has no frame behind this one.
const LAST_FRAME_OF_BLENDER: usize = 1_048_574;

/// Warns if the last of the time codes is one that programs cannot show.
fn warn_of_late_frames(last: usize) {
    if last > LAST_FRAME_OF_BLENDER {
        log::warn!(
            "the time codes go up to {last}, because the take keeps its place in the session; Blender's timeline \
             ends at {LAST_FRAME_OF_BLENDER}; give a start frame, such as 1001"
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_take_keeps_its_place_in_the_session_if_its_clock_is_a_sessions() {
        let at =
            |start: f64, rate: f64| place_in_session(&Take { times: vec![start], ..Take::default() }, rate);
        assert_eq!(at(0.0, 120.0), 0);
        assert_eq!(at(499.0 / 120.0, 120.0), 499);
        // 01:00:00:10 at 24 frames a second, by hand: 3600 · 24 + 10.
        assert_eq!(at(3600.0 + 10.0 / 24.0, 24.0), 86_410);
        assert_eq!(at(-2.0, 24.0), 0);
        // Seconds since 1970 are no place in a session.
        assert_eq!(at(1.7e9, 24.0), 0);
        assert_eq!(at(f64::NAN, 24.0), 0);
        assert_eq!(place_in_session(&Take::default(), 24.0), 0);
    }
}
