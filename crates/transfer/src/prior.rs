//! A face whose prior is the rig of another face.
use crate::{Settings, Transferred, transfer};
use rhytid_core::{DeviceInfo, Face, Prior, Progress, Reach, Result, rig_file};
use rhytid_formats::{project, tables};
use std::path::Path;

/// Reads a project file and everything that it names within `reach`, as [`project::read`] does. A prior that
/// is a rig is carried over to the face by [`transfer`], with all of its motion. The rig is evaluated on
/// `devices`.
///
/// # Errors
/// As [`project::load`], [`rig_file::read`] and [`transfer`].
pub fn read_face(path: &Path, reach: Reach, devices: &[DeviceInfo], progress: &dyn Progress) -> Result<Face> {
    let project = project::read_project(path)?;
    let mut face = project::load(&project, path, reach)?;
    let (Some(section), Some(rig_path)) = (&project.prior, project::prior_rig(&project, path, reach)?) else {
        return Ok(face);
    };
    let rig = rig_file::read(&rig_path)?;
    let landmarks = section.landmarks.as_ref().map(|file| {
        let file = rhytid_formats::named_file(path, file, "[prior] landmarks", reach)?;
        tables::read_landmarks(&file)
    });
    // Expressions with the name of an example would not be made.
    let examples = std::mem::take(&mut face.examples);
    let settings = Settings { landmarks: landmarks.transpose()?, linear_band: true };
    let named = |error: rhytid_core::Error| {
        error.reworded(|what| format!("{}: [prior] from: {what}", path.display()))
    };
    let Transferred { face: made, report, .. } =
        transfer(&rig, &face, &settings, devices, progress).map_err(named)?;
    for warning in report.warnings {
        log::warn!("{}: {warning}", rig_path.display());
    }
    face.prior = Some(Prior { expressions: made.examples, weight: section.weight });
    face.examples = examples;
    Ok(face)
}
