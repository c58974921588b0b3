//! Takes for a rig: the take's own CSV as it is, what capture systems write through the whole clean-up.

use crate::args::{MissingChoice, Setup};
use crate::progress::Ui;
use rhytid_capture::{Cleaned, Settings, Target, clean};
use rhytid_core::{Error, Result, Rig, Take};
use rhytid_formats::{raw_take, take};
use std::path::Path;

/// The take in a file, with all of the rig's handles in every frame. `setup` is for raw takes, which are cleaned, and `missing` for the take's
/// CSV.
///
/// # Errors
/// As reading, and as [`clean`]; [`Error::Input`] if there is a setup for what is no raw take, or one that leaves gaps.
pub fn load(path: &Path, rig: &Rig, missing: MissingChoice, setup: Option<&Path>, ui: &Ui) -> Result<Take> {
    if raw_take::is_take_csv(path) {
        if let Some(setup) = setup {
            return Err(Error::input(format!(
                "{}: is a clean take, so that --setup {} changes nothing; leave it out, or give the raw take",
                path.display(),
                setup.display()
            )));
        }
        return ui.timed("read the take", || take::read(path, Some(&rig.labels), missing.into())).0;
    }
    let Cleaned { take, .. } = prepare(path, rig, &self::setup(setup)?, None, ui)?;
    if take.positions.iter().flatten().any(|x| x.is_nan()) {
        return Err(Error::input(format!(
            "{}: has gaps, and {} leaves them: take “gaps” out of its skip",
            path.display(),
            setup.unwrap_or(path).display()
        )));
    }
    log::info!("{}: is a raw take; it was cleaned as `rhytid prepare` does it", path.display());
    Ok(take)
}

/// What TAKE.toml says, if there is one.
///
/// # Errors
/// As [`Setup::read`].
pub fn setup(path: Option<&Path>) -> Result<Setup> {
    path.map_or_else(|| Ok(Setup::default()), Setup::read)
}

/// The take in any file that can be read, cleaned and, with `fps`, resampled. What is to be looked at is warned of.
///
/// # Errors
/// As reading, and as [`clean`].
pub fn prepare(path: &Path, rig: &Rig, setup: &Setup, fps: Option<f64>, ui: &Ui) -> Result<Cleaned> {
    let settings = Settings { fps, ..setup.settings()? };
    let raw = ui.timed("read the take", || raw_take::read(path, setup.rate)).0?;
    let cleaned = clean(raw, &Target::of(rig), &settings, ui).map_err(|error| match error {
        Error::Input(message) => Error::Input(format!("{}: {message}", path.display())),
        other => other,
    })?;
    cleaned.report.warnings.iter().for_each(|warning| log::warn!("{}: {warning}", path.display()));
    Ok(cleaned)
}
