//! Inputs of several commands: a device, and a take with its setup.

use crate::args::{MissingChoice, Setup};
use crate::progress::Ui;
use rhytid::formats::raw_take;
use rhytid::playback::{self, choose_devices, find_device};
use rhytid::{DeviceInfo, Error, Result, Rig, Take};
use std::path::Path;

/// The device that `--device` names; `None` for `auto`. Asked before the long work, so that a wrong id is told at once.
///
/// # Errors
/// As [`find_device`].
pub(crate) fn named_device(wanted: &str) -> Result<Option<DeviceInfo>> {
    if wanted == "auto" { Ok(None) } else { find_device(wanted).map(Some) }
}

/// The processor, for what is soon done.
///
/// # Errors
/// As [`find_device`].
pub(crate) fn processor() -> Result<DeviceInfo> {
    find_device("cpu:0")
}

/// The device that was named; else those that conform, the fastest first, which is said.
///
/// # Errors
/// As [`choose_devices`].
pub(crate) fn devices(named: Option<DeviceInfo>, ui: &Ui) -> Result<Vec<DeviceInfo>> {
    if let Some(device) = named {
        return Ok(vec![device]);
    }
    let chosen = choose_devices("auto", ui)?;
    ui.clear();
    if let Some(reason) = chosen.reason.filter(|_| !ui.is_quiet()) {
        ui.line(&format!("auto takes {reason}"));
    }
    Ok(chosen.devices)
}

/// The take in a file, with all of the rig's handles in every frame. `setup` is for raw takes, which are cleaned, and `missing` for
/// the take's CSV.
///
/// # Errors
/// As [`playback::read_take`]; [`Error::Input`] if there is a setup for what is no raw take.
pub(crate) fn take(
    path: &Path,
    rig: &Rig,
    missing: MissingChoice,
    setup: Option<&Path>,
    ui: &Ui,
) -> Result<Take> {
    if let Some(setup) = setup.filter(|_| raw_take::is_take_csv(path)) {
        return Err(Error::input(format!(
            "{}: is a clean take, so that --setup {} changes nothing; leave it out, or give the raw take",
            path.display(),
            setup.display()
        )));
    }
    let clean_up = self::setup(setup)?.clean_up()?;
    playback::read_take(path, rig, missing.into(), &clean_up, ui)
}

/// What TAKE.toml says, if there is one.
///
/// # Errors
/// As [`Setup::read`].
pub(crate) fn setup(path: Option<&Path>) -> Result<Setup> {
    path.map_or_else(|| Ok(Setup::default()), Setup::read)
}
