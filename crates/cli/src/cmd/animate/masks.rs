//! `rhytid animate --masks`: wrinkles as pictures and curves beside the animation.

use crate::args;
use crate::output::{FRAME, numbered};
use crate::progress::Ui;
use rhytid::evaluate::WrinkleMasks;
use rhytid::formats::export::{Frame, Recipe};
use rhytid::playback::{Performance, Playback, channels_of};
use rhytid::{Error, Result, Rig};
use std::path::{Path, PathBuf};

/// Masks on their way to their files.
pub(super) struct Masks {
    masks: WrinkleMasks,
    to: PathBuf,
    /// The number of the next frame.
    next: usize,
}

/// The pictures' path, with `{frame}` in its name if each frame has one; `None` without `--masks`.
fn pictures(args: &args::Animate) -> Option<PathBuf> {
    args.masks?;
    Some(args.masks_to.clone().unwrap_or_else(|| args.output.with_extension("masks.png")))
}

/// Where the curves go.
fn curves(pictures: &Path) -> PathBuf {
    let stem = pictures.file_stem().unwrap_or_default().to_string_lossy().replace(FRAME, "");
    let stem = stem.trim_matches(['.', '_', '-', ' ']);
    pictures.with_file_name(format!("{}.csv", if stem.is_empty() { "masks" } else { stem }))
}

/// The files to write, except those of single frames.
pub(super) fn outputs(args: &args::Animate) -> Vec<PathBuf> {
    let Some(pictures) = pictures(args) else { return Vec::new() };
    let curves = curves(&pictures);
    if is_sequence(&pictures) { vec![curves] } else { vec![pictures, curves] }
}

fn is_sequence(pictures: &Path) -> bool {
    pictures.to_string_lossy().contains(FRAME)
}

/// Checks that the requested masks are possible.
///
/// # Errors
/// [`Error::Input`] if the name is not that of a picture, or as [`WrinkleMasks::new`].
pub(super) fn check(args: &args::Animate, rig: &Rig, recipe: &Recipe) -> Result<()> {
    let (Some(size), Some(pictures)) = (args.masks, pictures(args)) else { return Ok(()) };
    if pictures.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("png")) {
        return Err(Error::unsupported_format(format!(
            "--masks-to {}: expected a name that ends in .png",
            pictures.display()
        )));
    }
    let channels = WrinkleMasks::channels_of(&channels_of(rig, recipe)?);
    WrinkleMasks::new(rig, channels, &[], size as usize)
        .map(|_| ())
        .map_err(|error| error.in_file(args.rig.display()))
}

impl Masks {
    /// `None` if no masks are requested.
    ///
    /// # Errors
    /// As [`check`], and [`Playback::example_wrinkles`].
    pub(super) fn new(
        args: &args::Animate,
        performance: &Performance,
        playback: &mut Playback<'_>,
        ui: &Ui,
    ) -> Result<Option<Self>> {
        let (Some(size), Some(to)) = (args.masks, pictures(args)) else { return Ok(None) };
        let (rig, recipe) = (&performance.rig, &performance.recipe);
        let channels = WrinkleMasks::channels_of(&channels_of(rig, recipe)?);
        let of_examples = playback.example_wrinkles(ui)?;
        let examples_of = |channel: usize| match recipe.wrinkle_groups.0.get(channel) {
            Some(group) => rig.examples().names.iter().map(|name| group.examples.contains(name)).collect(),
            None => (0..of_examples.len()).map(|example| example == channel).collect::<Vec<bool>>(),
        };
        let wrinkles = (0..channels.len()).map(|channel| {
            let mut sum = vec![0.0; rig.vertices()];
            let examples = of_examples.iter().zip(examples_of(channel)).filter(|(_, is_in)| *is_in);
            examples.for_each(|(wrinkles, _)| {
                sum.iter_mut().zip(wrinkles).for_each(|(sum, wrinkle)| *sum += wrinkle);
            });
            sum
        });
        let wrinkles: Vec<Vec<f32>> = wrinkles.collect();
        let masks = WrinkleMasks::new(rig, channels, &wrinkles, size as usize)?;
        Ok(Some(Self { masks, to, next: performance.first_time_code }))
    }

    /// Adds a frame, and writes its picture if each frame has one.
    ///
    /// # Errors
    /// As [`WrinkleMasks::write_frame`].
    pub(super) fn frame(&mut self, frame: &Frame<'_>) -> Result<()> {
        self.masks.frame(frame);
        if is_sequence(&self.to) {
            self.masks.write_frame(&numbered(&self.to.to_string_lossy(), self.next), frame)?;
        }
        self.next += 1;
        Ok(())
    }

    /// Writes the files that need all frames. Returns a line about them.
    ///
    /// # Errors
    /// As [`WrinkleMasks::write_masks`] and [`WrinkleMasks::write_curves`].
    pub(super) fn finish(self, performance: &Performance) -> Result<String> {
        let curves = curves(&self.to);
        self.masks.write_curves(&curves, performance.first_time_code, performance.selection.rate)?;
        let pictures = self.masks.files(&self.to);
        let names: Vec<String> = pictures.iter().map(|file| file.display().to_string()).collect();
        let each = if is_sequence(&self.to) { " for each frame" } else { "" };
        if each.is_empty() {
            self.masks.write_masks(&self.to)?;
        }
        Ok(format!("masks of wrinkles{each}: {}; their curves: {}", names.join(", "), curves.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_beside_their_pictures() {
        for (pictures, expected) in [
            ("out/a.masks.png", "out/a.masks.csv"),
            ("out/wrinkles.{frame}.png", "out/wrinkles.csv"),
            ("{frame}.png", "masks.csv"),
        ] {
            assert_eq!(curves(Path::new(pictures)), Path::new(expected));
        }
    }
}
