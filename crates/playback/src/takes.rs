//! Takes for a rig. Rhytid's own CSV is read as it is, curves play shapes, and files of capture systems go
//! through the whole clean-up.

use crate::{curve_take, fit, named_shapes};
use rhytid_capture::{
    self as capture, Cleaned, Edit, Event, Match, Misfit, Settings, Step, TakeSpace, Target, clean,
    match_by_position, misfit,
};
use rhytid_core::{Error, NoProgress, Progress, Remedy, Result, Rig, Take, Warning, input_file, rig_file};
use rhytid_formats::raw_take::{self, Contents};
use rhytid_formats::take;
use rhytid_formats::take::Missing;
use std::path::{Path, PathBuf};

/// How takes are read: raw ones are cleaned, clean ones are brought into the rig's space, and curves play
/// shapes.
#[derive(Debug, Clone, Default)]
pub struct CleanUp {
    /// Frames per second, in place of what the file says.
    pub rate: Option<f64>,
    /// The unit and axes of a clean take that is not in the rig's space.
    pub space: Option<TakeSpace>,
    /// Whether the noise of the markers is taken out ([`capture::soften`]). They are then met within their
    /// noise, not exactly.
    pub soft_markers: bool,
    /// Whether a take's CSV is in world space in spite of its format, so that the head's motion is removed.
    pub world: bool,
    /// The steps, and settings for the actor and the session.
    pub settings: Settings,
    /// The shapes that curves weigh: a glTF or USD file with blend shapes, a folder of meshes or a pattern of
    /// their names, a project file, or another rig. `None` for the rig's own examples.
    pub shapes: Option<PathBuf>,
}

/// A take that was read, and what was found in it.
#[derive(Debug, Clone)]
pub struct ReadTake {
    /// The take, with all of the rig's handles in every frame.
    pub take: Take,
    /// The events of the clean-up. For a clean take: repairs by hand, and strains that no skin has.
    pub events: Vec<Event>,
}

/// The take in a file, with all of the rig's handles in every frame. `clean_up` says how. `missing` is for
/// Rhytid's own CSV. A clean take that lacks some handles has them filled in, as those of a raw take. Repairs
/// by hand ([`Settings::edits`]) apply to both.
///
/// Warnings of what is likely wrong go to `progress`: times that are not seconds, a head that turns, strains
/// that no skin has, much noise.
///
/// # Errors
/// As reading, and as [`clean`]; [`Error::Input`] if the clean-up leaves gaps. For a clean take,
/// [`Error::Input`] if it is recognisably in another space than the rig. For curves, [`Error::Input`] if
/// there are no shapes, or none of the curves' names.
pub fn read_take(
    path: &Path,
    rig: &Rig,
    missing: Missing,
    clean_up: &CleanUp,
    progress: &dyn Progress,
) -> Result<ReadTake> {
    let in_file = |error: Error| error.in_file(path.display());
    let warn = |warning: Warning| progress.warn(&warning.in_file(path.display()));
    let mut events = Vec::new();
    let mut take = match raw_take::contents(path) {
        Contents::Take => {
            let mut take = match clean_up.settings.edits.is_empty() {
                true => clean_take(path, rig, missing, progress)?,
                false => {
                    let repaired = only_filled(path, rig, &clean_up.settings.edits, progress)?;
                    events = repaired.report.events;
                    repaired.take
                }
            };
            if let Some(rate) = clean_up.rate {
                take.times = (0..take.frames()).map(|frame| frame as f64 / rate).collect();
            }
            if let Some(space) = clean_up.space {
                space.bring(&mut take, rig.surface().metres_per_unit);
            }
            let fit = fit::examine(&take, rig, clean_up.space).map_err(in_file)?;
            fit.warnings.into_iter().for_each(warn);
            events.extend(fit.strains);
            take
        }
        Contents::Curves => {
            let CleanUp { rate, shapes, .. } = clean_up;
            reading(progress, || curve_take::read(path, rig, shapes.as_deref(), *rate, progress))?
        }
        Contents::Raw => {
            let cleaned = read_raw_take(path, rig, clean_up, progress)?.0;
            if cleaned.take.positions.iter().flatten().any(|x| x.is_nan()) {
                return Err(Error::missing_samples(format!(
                    "{}: has gaps that its setup leaves open; remove “gaps” from `skip` in the setup",
                    path.display()
                )));
            }
            log::info!("{}: is a raw take; it was cleaned", path.display());
            events = cleaned.report.events;
            cleaned.take
        }
    };
    if clean_up.soft_markers {
        capture::soften(&mut take).map_err(in_file)?;
    } else {
        fit::noise(&take, rig).into_iter().for_each(warn);
    }
    Ok(ReadTake { take, events })
}

/// The space in which a clean take would fit `rig`. `None` if it fits as it is, or in no space.
///
/// # Errors
/// As reading.
pub fn space_of_take(path: &Path, rig: &Rig, missing: Missing) -> Result<Option<TakeSpace>> {
    let take = clean_take(path, rig, missing, &NoProgress)?;
    Ok(match misfit(&take, &Target::from_rig(rig)) {
        Some(Misfit::Space(space)) => Some(space),
        _ => None,
    })
}

/// A clean take, with the handles filled in that it lacks.
fn clean_take(path: &Path, rig: &Rig, missing: Missing, progress: &dyn Progress) -> Result<Take> {
    let read = reading(progress, || take::read(path, Some(&rig.handles().labels), missing));
    match read {
        // A pipe cannot be read again.
        Err(error) if input_file::is_regular(path).unwrap_or(false) => {
            filled(path, rig, progress)?.ok_or(error)
        }
        read => read,
    }
}

/// A clean take that lacks some of the rig's handles, with these filled in.
///
/// The clean-up fills them as markers that are never seen, and warns about them. `None` if the take lacks no
/// handle or most of them, or has labels that the rig does not know.
fn filled(path: &Path, rig: &Rig, progress: &dyn Progress) -> Result<Option<Take>> {
    // Other errors were reported already.
    let Ok(found) = take::read(path, None, Missing::Leave) else { return Ok(None) };
    let lacking = rig.handles().labels.iter().filter(|label| !found.labels.contains(label)).count();
    // Unknown labels are probably other names of the missing ones.
    let is_part = found.labels.iter().all(|label| rig.handles().labels.contains(label));
    if lacking == 0 || 2 * lacking > rig.handles().labels.len() || !is_part {
        return Ok(None);
    }
    Ok(Some(only_filled(path, rig, &[], progress)?.take))
}

/// A clean take after these repairs by hand, with its gaps filled. Nothing else of it changes.
fn only_filled(path: &Path, rig: &Rig, repairs: &[Edit], progress: &dyn Progress) -> Result<Cleaned> {
    let skip = [Step::Head, Step::HeadLowPass, Step::Align, Step::Swaps, Step::Outliers, Step::LowPass];
    // Whoever reads the take says more of a wrong space than the clean-up does.
    let skip = skip.into_iter().collect();
    let settings = Settings { skip, force: true, edits: repairs.to_vec(), ..Settings::default() };
    let clean_up = CleanUp { settings, ..CleanUp::default() };
    Ok(read_raw_take(path, rig, &clean_up, progress)?.0)
}

/// The take in any readable file, cleaned, with the report of the clean-up.
///
/// Warnings go to `progress`. If fewer than half of the handles have a marker of their name, markers are
/// matched by position. The second result has these matches, and is empty otherwise.
///
/// # Errors
/// As reading, and as [`clean`].
pub fn read_raw_take(
    path: &Path,
    rig: &Rig,
    clean_up: &CleanUp,
    progress: &dyn Progress,
) -> Result<(Cleaned, Vec<Match>)> {
    let in_file = |error: Error| error.in_file(path.display());
    let mut raw = reading(progress, || raw_take::read(path, clean_up.rate))?;
    if clean_up.world && raw.in_head_space {
        raw.in_head_space = false;
        raw.metres_per_unit = raw.metres_per_unit.or(Some(rig.surface().metres_per_unit));
        raw_take::mark_missing(&mut raw);
    }
    let mut settings = clean_up.settings.clone();
    let (handles, subject) = (&rig.handles().labels, settings.subject.as_deref());
    let named =
        capture::same_names(handles, &raw.tracks.labels, &settings.markers, subject).map_err(in_file)?;
    let named = named.iter().flatten().count();
    let mut matches = Vec::new();
    if 2 * named < handles.len() && raw.tracks.frames() > 0 {
        progress.step("match the markers by position", 0, 1)?;
        matches = match match_by_position(rig, &raw, &settings.markers, subject, progress) {
            // Without a match, the clean-up's error names the markers that there are.
            Err(Error::Input(error)) if !error.remedies().contains(&Remedy::ChooseSubject) => Vec::new(),
            matches => matches.map_err(in_file)?,
        };
        let found = matches.iter().filter_map(|m| Some((m.handle.clone(), m.marker.clone()?)));
        settings.markers.extend(found);
        progress.step("match the markers by position", 1, 1)?;
    }
    let mut cleaned = clean(raw, &Target::from_rig(rig), &settings, progress).map_err(in_file)?;
    cleaned.report.warnings.extend(by_position(&matches, named));
    let shown = cleaned.report.warnings.iter().map(|warning| warning.clone().in_file(path.display()));
    shown.for_each(|warning| progress.warn(&warning));
    Ok((cleaned, matches))
}

/// A warning about markers that were matched by position.
fn by_position(matches: &[Match], named: usize) -> Option<Warning> {
    let found = || matches.iter().filter(|m| m.marker.is_some());
    let least = found().min_by(|a, b| a.sure.total_cmp(&b.sure))?;
    let warning = Warning::from(format!(
        "{named} of the rig's {} handles have a marker of their name; {} were matched by position, the least \
         certain being {} with {} ({:.2} of 1): check the table of the matches, and give the corrected table \
         as `markers`",
        matches.len(),
        found().count(),
        least.handle,
        least.marker.as_deref().unwrap_or_default(),
        least.sure
    ));
    Some(warning.with_remedies(&[Remedy::MarkerTable]))
}

/// A hash of all files that [`CleanUp::shapes`] names.
///
/// # Errors
/// [`Error::Input`] for a project file that cannot be read; [`Error::Io`].
pub fn shapes_hash(shapes: &Path) -> Result<String> {
    let mut hash = blake3::Hasher::new();
    for file in named_shapes::files(shapes)? {
        // A project's file may name others that are not there yet, such as its handles.
        if file.is_file() {
            hash.update(rig_file::hash(&file)?.as_bytes());
        }
    }
    Ok(hash.finalize().to_hex().to_string())
}

fn reading<T>(progress: &dyn Progress, read: impl FnOnce() -> Result<T>) -> Result<T> {
    progress.report("read the take", 0, 1);
    let result = read();
    progress.report("read the take", 1, 1);
    result
}
