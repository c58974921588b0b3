//! Takes for a rig: the take's own CSV as it is, what capture systems write through the whole clean-up.

use crate::args::MissingChoice;
use crate::progress::Ui;
use rhytid_capture::{Cleaned, Settings, Target, clean};
use rhytid_core::{Error, Result, Rig, Take};
use rhytid_formats::{raw_take, take};
use std::path::Path;

/// The take in a file, with all of the rig's handles. A raw one is cleaned with the default settings; `missing` is for the take's CSV alone.
///
/// # Errors
/// As reading, and as [`clean`].
pub fn load(path: &Path, rig: &Rig, missing: MissingChoice, ui: &Ui) -> Result<Take> {
    if raw_take::is_take_csv(path) {
        return ui.timed("read the take", || take::read(path, Some(&rig.labels), missing.into())).0;
    }
    let cleaned = prepare(path, rig, None, &Settings::default(), ui)?;
    log::info!("{}: is a raw take; it was cleaned as `rhytid prepare` does it", path.display());
    Ok(cleaned.take)
}

/// The take in any file that can be read, cleaned. What is to be looked at is warned of.
///
/// # Errors
/// As reading, and as [`clean`].
pub fn prepare(path: &Path, rig: &Rig, rate: Option<f64>, settings: &Settings, ui: &Ui) -> Result<Cleaned> {
    let raw = ui.timed("read the take", || raw_take::read(path, rate)).0?;
    let cleaned = clean(raw, &Target::of(rig), settings, ui).map_err(|error| match error {
        Error::Input(message) => Error::Input(format!("{}: {message}", path.display())),
        other => other,
    })?;
    cleaned.report.warnings.iter().for_each(|warning| log::warn!("{}: {warning}", path.display()));
    Ok(cleaned)
}
