//! Inputs of several commands: a device, and a take with its setup.

use crate::args::{FineDetail, Setup, TakeReading, UnitChoice};
use crate::guard::guard;
use crate::progress::Ui;
use rhytid::capture::{self, Axes, Misfit, Step, Target};
use rhytid::core::{DeviceInfo, human};
use rhytid::devices::{choose_devices, find_device};
use rhytid::formats::edits;
use rhytid::formats::export::Gains;
use rhytid::formats::raw_take::Contents;
use rhytid::formats::take::{self, Missing};
use rhytid::formats::{FileKind, Reach, raw_take};
use rhytid::playback::{self, CleanUp, EditedTake, Layers};
use rhytid::{Error, Face, Result, Rig, Take};
use std::path::{Path, PathBuf};

/// Markers with less noise than this, in millimetres, are as good as most, whatever the rig was solved for.
const NOISY: f64 = 0.15;

/// Markers are much noisier than the rig was solved for from this ratio on.
const MUCH_NOISIER: f64 = 2.0;

/// Fewer steps between frames do not show the unit of times.
const FEW_STEPS: usize = 10;

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

/// The take in a file, with all of the rig's handles in every frame. A setup applies to raw takes, which are
/// cleaned. The options for missing markers and space apply to the take's CSV.
///
/// # Errors
/// As [`playback::read_take`]. [`Error::Input`] if a setup is given for a clean take or a space for a raw
/// one, or if the take is recognisably in another space.
pub(crate) fn take(path: &Path, rig: &Rig, reading: &TakeReading, ui: &Ui) -> Result<Take> {
    let mut take = take_as_it_is(path, rig, reading, ui)?;
    if reading.soft_markers {
        capture::soften(&mut take)?;
    } else {
        warn_noise(&take, rig, path, ui);
    }
    Ok(take)
}

/// Says if the markers are much noisier than the rig was solved for.
fn warn_noise(take: &Take, rig: &Rig, path: &Path, ui: &Ui) {
    let millimetres = 1e3 * rig.surface().metres_per_unit;
    let noise = millimetres * capture::marker_noise(take);
    let known = rig.learned().map_or(0.0, |learned| millimetres * learned.marker_noise);
    if noise > NOISY && noise > MUCH_NOISIER * known {
        let noise = human::number((noise * 100.0).round() / 100.0);
        ui.line(&format!(
            "warning: {}: its markers have {noise} mm of noise per axis, which the skin between them would follow; \
             --soft-markers takes it out",
            path.display()
        ));
    }
}

/// The same with the noise of its markers.
fn take_as_it_is(path: &Path, rig: &Rig, reading: &TakeReading, ui: &Ui) -> Result<Take> {
    let TakeReading { missing, setup, elsewhere, space, force, .. } = reading;
    let contents = raw_take::contents(path);
    if contents == Contents::Curves {
        return curves(path, rig, reading, ui);
    }
    let is_clean = contents == Contents::Take;
    let refused = |what: &str| Err(Error::conflict(format!("{}: {what}", path.display())));
    if let Some(shapes) = reading.shapes_of_curves() {
        let shapes = shapes.display();
        return refused(&format!(
            "is a take of places, so that --shapes {shapes} changes nothing; leave it out, or give curves"
        ));
    }
    let known = self::setup(setup.as_deref(), elsewhere.reach())?;
    if let Some(setup) = setup.as_ref().filter(|_| is_clean && known.detail.is_empty()) {
        return refused(&format!(
            "is a clean take, so that --setup {} changes nothing; leave it out, or give the raw take",
            setup.display()
        ));
    }
    let is_known = space.take_unit.is_some() || space.take_axes.is_some();
    if !is_clean && (is_known || space.take_rate.is_some()) {
        return refused("is a raw take, which is cleaned: say its unit, axes and rate in --setup TAKE.toml");
    }
    let mut clean_up = known.clean_up()?;
    clean_up.settings.force |= force;
    let mut take = match playback::read_take(path, rig, (*missing).into(), &clean_up, ui) {
        // A pipe cannot be read again.
        Err(error) if is_clean && path.is_file() => filled(path, rig, ui)?.ok_or(error)?,
        result => result?,
    };
    if !is_clean {
        return Ok(take);
    }
    times(&mut take, space.take_rate, path, ui);
    if is_known {
        let metres_per_unit = space.take_unit.map_or(rig.surface().metres_per_unit, UnitChoice::metres);
        let axes = space.take_axes.unwrap_or(Axes::SAME);
        capture::TakeSpace { metres_per_unit, axes }.bring(&mut take, rig.surface().metres_per_unit);
    }
    let misfit = capture::misfit(&take, &Target::from_rig(rig));
    let remedy = match misfit {
        None => {
            warn_strain(&take, rig, path, ui);
            return Ok(take);
        }
        Some(Misfit::Space(space)) => {
            let unit = space.unit().filter(|_| space.metres_per_unit != rig.surface().metres_per_unit);
            let unit = unit.map_or(String::new(), |unit| format!(" --take-unit {unit}"));
            let axes = match space.axes {
                Axes::SAME => String::new(),
                axes => format!(" --take-axes {axes}"),
            };
            // A space that was given explicitly is accepted.
            if !is_known {
                return Err(Error::mismatch(format!(
                    "{}: {}; give{unit}{axes}",
                    path.display(),
                    Misfit::Space(space)
                )));
            }
            format!("give{unit}{axes}")
        }
        Some(Misfit::HeadMotion(_)) => format!(
            "`rhytid prepare {} --rig RIG --world -o clean.csv` takes the head's motion out",
            path.display()
        ),
        Some(_) => "check that rig and take belong together, and that labels name the same places".to_owned(),
    };
    if let Some(misfit) = misfit {
        ui.line(&format!("warning: {}: {misfit}; {remedy}", path.display()));
    }
    Ok(take)
}

/// The take that curves make of shapes.
fn curves(path: &Path, rig: &Rig, reading: &TakeReading, ui: &Ui) -> Result<Take> {
    let TakeReading { missing, setup, elsewhere, space, .. } = reading;
    let refused = |what: &str| Err(Error::conflict(format!("{}: holds curves, {what}", path.display())));
    if space.take_unit.is_some() || space.take_axes.is_some() {
        return refused("which have no unit and no axes; leave --take-unit and --take-axes out");
    }
    if let Some(setup) = setup.as_ref()
        && self::setup(Some(setup), elsewhere.reach())?.detail.is_empty()
    {
        return refused(&format!(
            "so that --setup {} changes nothing; leave it out, and give a rate with --take-rate",
            setup.display()
        ));
    }
    let shapes = reading.shapes_of_curves().map(Path::to_owned);
    let clean_up = CleanUp { rate: space.take_rate, shapes, ..CleanUp::default() };
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

/// A clean take that lacks some of the rig's handles, with these filled in.
///
/// The clean-up fills them as markers that are never seen, and warns about them. `None` if the take lacks no
/// handle or most of them, or has labels that the rig does not know.
fn filled(path: &Path, rig: &Rig, ui: &Ui) -> Result<Option<Take>> {
    // Other errors were reported already.
    let Ok(found) = take::read(path, None, Missing::Leave) else { return Ok(None) };
    let lacking = rig.handles().labels.iter().filter(|label| !found.labels.contains(label)).count();
    // Unknown labels are probably other names of the missing ones.
    let is_part = found.labels.iter().all(|label| rig.handles().labels.contains(label));
    if lacking == 0 || 2 * lacking > rig.handles().labels.len() || !is_part {
        return Ok(None);
    }
    let skip = [Step::Head, Step::HeadLowPass, Step::Align, Step::Swaps, Step::Outliers, Step::LowPass];
    // Whoever reads the take says more of a wrong space than the clean-up does.
    let skip = skip.into_iter().collect();
    let settings = capture::Settings { skip, force: true, ..capture::Settings::default() };
    let clean_up = CleanUp { settings, ..CleanUp::default() };
    Ok(Some(playback::read_raw_take(path, rig, &clean_up, ui)?.0.take))
}

/// Warns of strains that no skin has.
fn warn_strain(take: &Take, rig: &Rig, path: &Path, ui: &Ui) {
    if let Some(strain) = capture::gross_strain(take, rig) {
        ui.line(&format!("warning: {}: {}", path.display(), strain.warning(take)));
    }
}

/// Sets the times by a given rate. Without one, warns where the times look like frame numbers or
/// milliseconds.
fn times(take: &mut Take, rate: Option<f64>, path: &Path, ui: &Ui) {
    if let Some(rate) = rate {
        take.times = (0..take.frames()).map(|frame| frame as f64 / rate).collect();
        return;
    }
    let steps: Vec<f64> = take.times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.len() < FEW_STEPS {
        return;
    }
    let whole = take.times.iter().all(|time| time.fract() == 0.0);
    let between = |range: std::ops::Range<f64>| {
        steps.iter().filter(|step| range.contains(step)).count() * 10 > steps.len() * 9
    };
    let what = match () {
        () if whole && between(0.999..1.001) => "numbers of frames",
        () if between(3.9..101.0) => "milliseconds",
        () => return,
    };
    ui.line(&format!(
        "warning: {}: its times look like {what}, expected seconds; give the frame rate, such as --take-rate \
         30",
        path.display()
    ));
}

/// What TAKE.toml says, if there is one.
///
/// # Errors
/// As [`Setup::read`].
pub(crate) fn setup(path: Option<&Path>, reach: Reach) -> Result<Setup> {
    path.map_or_else(|| Ok(Setup::default()), |path| Setup::read(path, reach))
}
