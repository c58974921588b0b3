//! The finding of the mesh's unit.
use super::finding::{Report, Severity};
use super::words::length;
use glam::DVec3;
use rhytid_core::Face;

/// A head or face scan is about this large, in metres: the diagonal of its bounding box.
const PLAUSIBLE_DIAGONAL: std::ops::Range<f64> = 0.08..1.2;

/// Gives the length of the neutral's diagonal.
pub(super) fn examine(face: &Face, report: &mut Report) -> f64 {
    let [low, high] = face.neutral.bounds().unwrap_or_default().map(DVec3::from_array);
    let diagonal = high.distance(low);
    let metres = diagonal * face.metres_per_unit;
    if !PLAUSIBLE_DIAGONAL.contains(&metres) {
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
    diagonal
}
