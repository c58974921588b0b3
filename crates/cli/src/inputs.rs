//! Inputs of several commands: a device, and a take with its setup.

use crate::args::{FineDetail, Setup, TakeReading, UnitChoice};
use crate::guard::guard;
use crate::progress::Ui;
use rhytid::capture::{Axes, TakeSpace};
use rhytid::core::{DeviceInfo, human};
use rhytid::devices::{choose_devices, find_device};
use rhytid::formats::edits;
use rhytid::formats::export::Gains;
use rhytid::formats::raw_take::Contents;
use rhytid::formats::{FileKind, Reach, raw_take};
use rhytid::playback::{self, EditedTake, Layers, ReadTake};
use rhytid::{Error, Face, Result, Rig, Take};
use std::path::{Path, PathBuf};

/// The device that `--device` names; `None` for `auto`. It is looked up before the long work, so that a wrong
/// id is reported at once.
///
/// # Errors
/// As [`find_device`].
pub(crate) fn named_device(wanted: &str) -> Result<Option<DeviceInfo>> {
    if wanted == "auto" { Ok(None) } else { find_device(wanted, guard()).map(Some) }
}

/// The face of a project file. A prior that is a rig is carried over to it.
///
/// # Errors
/// As [`rhytid::transfer::read_face`].
pub(crate) fn face(path: &Path, reach: Reach, ui: &Ui) -> Result<Face> {
    rhytid::transfer::read_face(path, reach, &[processor()?], ui)
}

/// The processor, for short work.
///
/// # Errors
/// As [`find_device`].
pub(crate) fn processor() -> Result<DeviceInfo> {
    find_device("cpu:0", guard())
}

/// The named device; else those that conform, the fastest first, with a message.
///
/// # Errors
/// As [`choose_devices`].
pub(crate) fn devices(named: Option<DeviceInfo>, ui: &Ui) -> Result<Vec<DeviceInfo>> {
    if let Some(device) = named {
        return Ok(vec![device]);
    }
    let chosen = choose_devices("auto", guard(), ui)?;
    ui.clear();
    if let Some(reason) = chosen.reason.filter(|_| !ui.is_quiet()) {
        ui.line(&format!("device: {}", reason.device));
        log::info!("{}", reason.details);
    }
    Ok(chosen.devices)
}

/// Refuses a file that is plainly of another kind than those `expected`. `usage` says what the command takes.
///
/// # Errors
/// [`Error::Input`].
pub(crate) fn expect(path: &Path, expected: &[FileKind], usage: &str) -> Result<()> {
    FileKind::expect(path, expected)
        .map_err(|error| error.reworded(|said| format!("{said}; the command is {usage}")))
}

/// A rig and a take, each in its place.
///
/// # Errors
/// As [`expect`].
pub(crate) fn rig_and_take(rig: &Path, take: &Path, usage: &str) -> Result<()> {
    expect(rig, &[FileKind::Rig], usage)?;
    expect(take, &[FileKind::Take, FileKind::RawTake, FileKind::Curves], usage)
}

/// A rig and, where there is one, a take. Without a take, no option may say how it is read.
///
/// # Errors
/// As [`expect`]; [`Error::Input`] for such an option.
pub(crate) fn rig_and_any_take(
    rig: &Path,
    take: Option<&Path>,
    reading: &TakeReading,
    usage: &str,
) -> Result<()> {
    match take {
        Some(take) => rig_and_take(rig, take, usage),
        None if *reading != TakeReading::default() => Err(Error::conflict(format!(
            "the options say how a take is read, and no take is given; the command is {usage}"
        ))),
        None => expect(rig, &[FileKind::Rig], usage),
    }
}

/// A project file.
///
/// # Errors
/// As [`expect`].
pub(crate) fn project(path: &Path, usage: &str) -> Result<()> {
    expect(path, &[FileKind::Project], usage)
}

/// The gains by region: those of the command line, and those of TAKE.toml for other regions.
///
/// # Errors
/// The setup's.
pub(crate) fn gains(fine_detail: &FineDetail, reading: &TakeReading) -> Result<Gains> {
    let setup = setup(reading.setup.as_deref(), reading.elsewhere.reach())?;
    let is_given = |region: &String| fine_detail.gains.iter().any(|(other, _)| other == region);
    let others = setup.detail.into_iter().filter(|(region, _)| !is_given(region));
    let mut gains: Vec<(String, f64)> = fine_detail.gains.iter().cloned().chain(others).collect();
    gains.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(Gains(gains))
}

/// The take in a file, as [`read_take`] reads it.
///
/// # Errors
/// As [`read_take`].
pub(crate) fn take(path: &Path, rig: &Rig, reading: &TakeReading, ui: &Ui) -> Result<Take> {
    Ok(read_take(path, rig, reading, ui)?.take)
}

/// The take in a file, with all of the rig's handles in every frame, and what was found in it. A setup
/// applies to raw takes, which are cleaned. The options for missing markers and space apply to the take's
/// CSV.
///
/// # Errors
/// As [`playback::read_take`]. [`Error::Input`] if an option does not apply to the kind of the take.
pub(crate) fn read_take(path: &Path, rig: &Rig, reading: &TakeReading, ui: &Ui) -> Result<ReadTake> {
    let TakeReading { missing, setup, elsewhere, space, force, soft_markers, .. } = reading;
    let known = self::setup(setup.as_deref(), elsewhere.reach())?;
    let has_space = space.take_unit.is_some() || space.take_axes.is_some();
    // A setup without gains says only how a raw take is cleaned.
    let unused = setup.as_ref().filter(|_| known.detail.is_empty()).map(|setup| setup.display().to_string());
    let refused = |what: String| Err(Error::conflict(format!("{}: {what}", path.display())));
    let contents = raw_take::contents(path);
    match (contents, &unused, reading.shapes_of_curves()) {
        (Contents::Curves, ..) if has_space => {
            return refused(
                "holds curves, which have no unit and no axes; leave --take-unit and --take-axes out"
                    .to_owned(),
            );
        }
        (Contents::Curves, Some(setup), _) => {
            return refused(format!(
                "holds curves, so that --setup {setup} changes nothing; leave it out, and give a rate with \
                 --take-rate"
            ));
        }
        (Contents::Take | Contents::Raw, _, Some(shapes)) => {
            return refused(format!(
                "is a take of places, so that --shapes {} changes nothing; leave it out, or give curves",
                shapes.display()
            ));
        }
        (Contents::Take, Some(setup), None) => {
            return refused(format!(
                "is a clean take, so that --setup {setup} changes nothing; leave it out, or give the raw take"
            ));
        }
        (Contents::Raw, _, None) if has_space || space.take_rate.is_some() => {
            return refused(
                "is a raw take, which is cleaned: say its unit, axes and rate in --setup TAKE.toml"
                    .to_owned(),
            );
        }
        _ => {}
    }
    // What a setup says about a clean take is the gains of its wrinkles alone.
    let mut clean_up =
        if contents == Contents::Raw { known.clean_up()? } else { playback::CleanUp::default() };
    clean_up.settings.force |= force;
    clean_up.soft_markers = *soft_markers;
    if contents != Contents::Raw {
        clean_up.rate = space.take_rate;
        clean_up.shapes = reading.shapes_of_curves().map(Path::to_owned);
        clean_up.space = has_space.then(|| TakeSpace {
            metres_per_unit: space.take_unit.map_or(rig.surface().metres_per_unit, UnitChoice::metres),
            axes: space.take_axes.unwrap_or(Axes::SAME),
        });
    }
    playback::read_take(path, rig, (*missing).into(), &clean_up, ui)
}

/// A take with the edits of a file, if there is one.
pub(crate) struct Edited {
    /// The rig with the edits of its wrinkles that apply to all frames.
    pub rig: Rig,
    /// The take.
    pub take: EditedTake,
    /// The remaining edits.
    pub layers: Option<Layers>,
}

/// Applies the edits of a file, if there is one, to a take and its rig.
///
/// # Errors
/// As [`Layers::read`], [`Layers::edit`] and [`Layers::settle`].
pub(crate) fn edited(take: Take, rig: Rig, edit: Option<&Path>, reading: &TakeReading) -> Result<Edited> {
    let Some(mut layers) = layers(edit, &rig, reading)? else {
        return Ok(Edited { rig, take: take.into(), layers: None });
    };
    let take = layers.edit(take, &rig)?;
    Ok(Edited { rig: layers.settle(rig)?, take, layers: Some(layers) })
}

/// The edits in a file, if there is one.
///
/// # Errors
/// As [`Layers::read`].
pub(crate) fn layers(edit: Option<&Path>, rig: &Rig, reading: &TakeReading) -> Result<Option<Layers>> {
    edit.map(|path| Layers::read(path, rig, reading.elsewhere.reach())).transpose()
}

/// A file of edits, if there is one, and all files that it names. No output may be one of them.
///
/// # Errors
/// As [`edits::read`].
pub(crate) fn edit_files(edit: Option<&Path>) -> Result<Vec<PathBuf>> {
    let Some(path) = edit else { return Ok(Vec::new()) };
    let (edits, _) = edits::read(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let named = edits.named_files().map(|(_, file)| folder.join(file));
    Ok(std::iter::once(path.to_owned()).chain(named).collect())
}

/// One frame of a take that was read from `path`.
///
/// # Errors
/// [`Error::Input`] if the take does not have it.
pub(crate) fn frame(take: &Take, frame: usize, path: &Path) -> Result<Take> {
    if frame >= take.frames() {
        let frames = human::counted(take.frames(), "frame");
        return Err(Error::out_of_range(format!(
            "--frame {frame}: {} has {frames}, counted from 0",
            path.display()
        )));
    }
    Ok(take.slice(frame..frame + 1))
}

/// What TAKE.toml says, if there is one.
///
/// # Errors
/// As [`Setup::read`].
pub(crate) fn setup(path: Option<&Path>, reach: Reach) -> Result<Setup> {
    path.map_or_else(|| Ok(Setup::default()), |path| Setup::read(path, reach))
}
