//! Which take the handles of a new project come from.

use super::super::placing::{Avatar, Placed, at_markers, spread};
use crate::args;
use crate::progress::Ui;
use rhytid::formats::FileKind;
use rhytid::{Error, Face, Result};
use std::path::{Path, PathBuf};

/// The number of handles without a take.
const HANDLES: usize = 90;

/// Places the handles at the markers of a take: the one that was given, else the first beside the neutral
/// whose markers fit the face. A warning names the files that are passed over. If the markers of none fit,
/// the handles are those of the first one, with what is wrong with them. Without a take, handles are spread
/// over the face.
///
/// # Errors
/// As reading and placing; [`Error::Input`] if options are about a take and there is none.
pub(super) fn find_handles(face: Face, avatar: &Avatar, args: &args::New, ui: &Ui) -> Result<Placed> {
    let options = &args.placement;
    if let Some(take) = &args.take {
        return at_markers(face, avatar, take, None, options, ui);
    }
    let mut unfit: Vec<Placed> = Vec::new();
    for take in takes_beside(&args.neutral) {
        match at_markers(face.clone(), avatar, &take, None, options, ui) {
            Err(error @ Error::Input(_)) => ui.line(&format!(
                "warning: {}: is passed over, since it is no take of this face ({error}); name a take with --take",
                take.display()
            )),
            Ok(placed) if placed.take.as_ref().is_some_and(|take| !take.found.faults.is_empty()) => {
                unfit.push(placed);
            }
            found => {
                for take in unfit.iter().filter_map(|placed| placed.take.as_ref()) {
                    ui.line(&format!(
                        "warning: {}: is passed over: {}; name a take with --take",
                        take.path.display(),
                        take.found.faults.join("; ")
                    ));
                }
                return found;
            }
        }
    }
    if let Some(placed) = unfit.into_iter().next() {
        return Ok(placed);
    }
    let is_of_take = options.frame.0.is_some() || options.rigid.is_some() || options.subject.is_some();
    if is_of_take || options.rate.is_some() {
        return Err(Error::conflict(format!(
            "{}: there is no take beside it, which --frame, --rigid, --subject and --rate are about; name one with \
             --take",
            args.neutral.display()
        )));
    }
    spread(face, avatar, HANDLES, options)
}

/// The takes in the neutral's folder, by name.
fn takes_beside(neutral: &Path) -> Vec<PathBuf> {
    let folder = neutral.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    files.sort();
    files.retain(|path| matches!(FileKind::detect(path), Some(FileKind::RawTake | FileKind::Take)));
    files
}
