//! Findings about the unit and the place of the mesh.
use super::finding::{Report, Severity};
use super::impossible::FLOAT32;
use super::words::length;
use crate::head;
use glam::DVec3;
use rhytid_core::Face;

/// The plausible sizes of a head or face scan, in metres: the diagonal of its bounding box.
const PLAUSIBLE_DIAGONAL: std::ops::Range<f64> = 0.08..1.2;
/// Rounding to float32 that moves a vertex by less than this is not reported, in metres: a hundredth of a
/// millimetre.
const UNSEEN: f64 = 1e-5;

/// Whether a part of the mesh is a head of a plausible size, as of an avatar.
fn has_a_head(face: &Face) -> bool {
    let Ok(head) = head::find(face, &[], None) else { return false };
    let size = DVec3::from_array(head.size).length() * face.metres_per_unit;
    head.looks_ahead() && PLAUSIBLE_DIAGONAL.contains(&size)
}

/// Examines the unit and the place. The result is the length of the neutral's diagonal.
pub(super) fn examine(face: &Face, report: &mut Report) -> f64 {
    let [low, high] = face.neutral.bounds().unwrap_or_default().map(DVec3::from_array);
    let diagonal = high.distance(low);
    let metres = diagonal * face.metres_per_unit;
    if !PLAUSIBLE_DIAGONAL.contains(&metres) && !has_a_head(face) {
        let fitting: Vec<&str> = [("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("in", 0.0254)]
            .into_iter()
            .filter(|(_, unit)| PLAUSIBLE_DIAGONAL.contains(&(diagonal * unit)))
            .map(|(name, _)| name)
            .collect();
        let advice = match fitting.as_slice() {
            [] => "check the scan's scale".to_owned(),
            units => format!("units = \"{}\" would make it the size of a head", units.join("\" or \"")),
        };
        report.add(
            Severity::Warning,
            "units",
            format!("the neutral mesh is {} m across, not the size of a head; {advice}", length(metres)),
        );
    }
    let farthest = low.abs().max(high.abs()).max_element();
    let rounded = farthest * face.metres_per_unit * FLOAT32;
    // If a mesh is as large as it is far away, the fault is its unit.
    if rounded > UNSEEN && farthest > diagonal {
        report.add(
            Severity::Warning,
            "far-from-origin",
            format!(
                "the neutral mesh is {} m from the origin, where float32, the format of rigs and animations, \
                 rounds by up to {} mm; move all meshes to the origin, by the same offset",
                length(farthest * face.metres_per_unit),
                length(1000.0 * rounded)
            ),
        );
    }
    diagonal
}
