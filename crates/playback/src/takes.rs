//! Takes for a rig. Rhytid's own CSV is read as it is, curves play shapes, and files of capture systems go
//! through the whole clean-up.

use crate::{curve_take, named_shapes};
use rhytid_capture::{self as capture, Cleaned, Match, Settings, Target, clean, match_by_position};
use rhytid_core::{Error, Progress, Remedy, Result, Rig, Take, Warning, rig_file};
use rhytid_formats::raw_take::{self, Contents};
use rhytid_formats::take;
use rhytid_formats::take::Missing;
use std::path::{Path, PathBuf};

/// How raw takes are read and cleaned, and what curves play.
#[derive(Debug, Clone, Default)]
pub struct CleanUp {
    /// Frames per second, in place of what the file says.
    pub rate: Option<f64>,
    /// Whether a take's CSV is in world space in spite of its format, so that the head's motion is removed.
    pub world: bool,
    /// The steps, and settings for the actor and the session.
    pub settings: Settings,
    /// The shapes that curves weigh: a glTF or USD file with blend shapes, a folder of meshes or a pattern of
    /// their names, a project file, or another rig. `None` for the rig's own examples.
    pub shapes: Option<PathBuf>,
}

/// The take in a file, with all of the rig's handles in every frame. `clean_up` is for raw takes and curves.
/// `missing` is for Rhytid's own CSV.
///
/// # Errors
/// As reading, and as [`clean`]; [`Error::Input`] if the clean-up leaves gaps. For curves, [`Error::Input`]
/// if there are no shapes, or none of the curves' names.
pub fn read_take(
    path: &Path,
    rig: &Rig,
    missing: Missing,
    clean_up: &CleanUp,
    progress: &dyn Progress,
) -> Result<Take> {
    match raw_take::contents(path) {
        Contents::Take => {
            return reading(progress, || take::read(path, Some(&rig.handles().labels), missing));
        }
        Contents::Curves => {
            let CleanUp { rate, shapes, .. } = clean_up;
            return reading(progress, || curve_take::read(path, rig, shapes.as_deref(), *rate, progress));
        }
        Contents::Raw => {}
    }
    let take = read_raw_take(path, rig, clean_up, progress)?.0.take;
    if take.positions.iter().flatten().any(|x| x.is_nan()) {
        return Err(Error::missing_samples(format!(
            "{}: has gaps that its setup leaves open; remove “gaps” from `skip` in the setup",
            path.display()
        )));
    }
    log::info!("{}: is a raw take; it was cleaned", path.display());
    Ok(take)
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
        matches = match match_by_position(rig, &raw, &settings.markers, subject) {
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
