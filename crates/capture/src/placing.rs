//! What the file's numbers mean: its unit, the rigid markers, and how far markers are from their handles.
use crate::fit::Similarity;
use crate::head::find_rigid;
use crate::settings::Settings;
use crate::tracks::{Tracks, extent, median_of, seen};
use glam::DVec3;
use rhytid_core::{Error, Result};
use std::ops::Range;

/// The median extent of the columns over the take, in the file's unit; 0 where none was ever seen.
pub fn typical_extent(tracks: &Tracks, columns: &[usize]) -> f64 {
    let step = tracks.frames().div_ceil(200).max(1);
    let extents =
        (0..tracks.frames()).step_by(step).map(|f| extent(columns.iter().map(|&c| tracks.columns[c][f])));
    let mut extents: Vec<f64> = extents.filter(|e| *e > 0.0).collect();
    if extents.is_empty() { 0.0 } else { median_of(&mut extents) }
}

/// The columns of the rigid markers: those that the settings name, else those of `others` that keep their distances.
///
/// # Errors
/// [`Error::Input`] if the settings name a marker that is not there, or one or two.
pub fn rigid_markers(
    tracks: &Tracks,
    others: &[usize],
    labels: &[String],
    settings: &Settings,
    extent: f64,
) -> Result<Vec<usize>> {
    let Some(named) = &settings.rigid else { return Ok(find_rigid(tracks, others, extent)) };
    if named.len() == 1 || named.len() == 2 {
        return Err(Error::input(format!(
            "{} rigid markers are given, expected at least 3, or none to go by the whole face",
            named.len()
        )));
    }
    let column = |label: &String| {
        let unknown = || Error::input(format!("the rigid marker “{label}” is not in the file"));
        labels.iter().position(|l| l == label).ok_or_else(unknown)
    };
    named.iter().map(column).collect()
}

/// Metres in one unit of the file, and whether that is a guess. `fitted` takes the file's space to the mesh's, whose unit is `mesh` metres.
pub fn unit(
    stated: Option<f64>,
    settings: &Settings,
    mesh: f64,
    fitted: &Similarity,
    warnings: &mut Vec<String>,
) -> (f64, bool) {
    const UNITS: [(&str, f64); 5] = [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("in", 0.0254), ("ft", 0.3048)];
    if let Some(given) = settings.metres_per_unit {
        return (given, false);
    }
    let scale = |unit: f64| unit / (mesh * fitted.scale);
    if let Some(stated) = stated {
        if (0.4..2.5).contains(&scale(stated)) {
            return (stated, false);
        }
        warnings.push(format!(
            "the file says that its unit is {stated} m, which makes the actor {:.3} times the rig's size",
            scale(stated)
        ));
    }
    let unlike = |unit: f64| scale(unit).ln().abs();
    let (name, unit) =
        UNITS.into_iter().min_by(|a, b| unlike(a.1).total_cmp(&unlike(b.1))).unwrap_or(UNITS[0]);
    warnings.push(format!(
        "the unit is taken for {name}, with which the actor is {:.3} times the rig's size",
        scale(unit)
    ));
    (unit, true)
}

/// How far each handle's marker is from its handle, in millimetres; `None` where it was not seen at neutral. Warns where it looks like another label.
pub fn offsets(
    pose: &[DVec3],
    rest: &[DVec3],
    millimetres: f64,
    labels: &[String],
    warnings: &mut Vec<String>,
) -> Vec<Option<f64>> {
    /// As a part of the face's extent.
    const LARGEST: f64 = 0.08;
    let largest = LARGEST * extent(rest.iter().copied()) * millimetres;
    let mut offsets = Vec::with_capacity(rest.len());
    for ((p, r), label) in pose.iter().zip(rest).zip(labels) {
        let offset = seen(*p).then(|| p.distance(*r) * millimetres);
        if let Some(offset) = offset.filter(|offset| *offset > largest) {
            warnings.push(format!(
                "at neutral the marker of {label} is {offset:.1} mm from its handle: is it another's?"
            ));
        }
        offsets.push(offset);
    }
    offsets
}

/// The mean of what was seen; `None` if nothing was.
pub fn mean(column: &[DVec3], frames: &Range<usize>) -> Option<DVec3> {
    let points = || column[frames.clone()].iter().filter(|p| seen(**p));
    let n = points().count();
    (n > 0).then(|| points().sum::<DVec3>() / n as f64)
}

/// The standard deviation of a coordinate's noise: of the second differences, which hardly any motion has, by their median.
pub fn noise(tracks: &Tracks) -> f64 {
    /// As many frames of each marker are enough.
    const FRAMES: usize = 2000;
    let step = (tracks.frames() / FRAMES).max(1);
    let mut seconds: Vec<f64> = Vec::new();
    for column in &tracks.columns {
        for f in (1..tracks.frames().saturating_sub(1)).step_by(step) {
            let second = column[f - 1] - 2.0 * column[f] + column[f + 1];
            if seen(second) {
                seconds.extend(second.to_array().map(f64::abs));
            }
        }
    }
    // Of a normal distribution half lies within 0.6745 σ; the variance of a second difference is 1 + 4 + 1 times a sample's.
    if seconds.is_empty() { 0.0 } else { median_of(&mut seconds) / (0.674_489_75 * 6.0_f64.sqrt()) }
}
