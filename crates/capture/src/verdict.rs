//! What is wrong with placed handles, and what a person should look at.
use crate::handles_in_frame::{Laid, POOR};
use glam::{DMat3, DVec3};
use rhytid_core::numbers::median;
use rhytid_core::{Face, Handles};
use rhytid_solve::Placed;

/// A marker that was laid farther from its handle than this, in metres, is worth a look.
const DOUBTFUL: f64 = 0.008;

/// The largest part of the markers that may be doubtful.
const MOST_DOUBTFUL: f64 = 0.2;

/// The largest distance of a marker from its handle, in metres, at the median.
const LARGEST: f64 = 0.005;

/// A warning names at most so many markers.
const NAMED: usize = 8;

/// Markers on a patch that is narrower or lower than this, in metres, can slide along the skin: it fits
/// nearly as well a centimetre or two away. So can fewer markers than these, wherever they are.
const PATCH: [f64; 2] = [0.085, 0.1];
const FEW: usize = 24;

/// A warning that the markers may have slid along the skin, if they are few or on a part of the face alone.
/// `axes` are the mesh's right, up and forward axes.
pub(crate) fn may_slide(face: &Face, axes: DMat3, laid: &Laid) -> Option<String> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for point in &laid.fit.points {
        let point = axes.transpose() * *point * face.metres_per_unit;
        (low, high) = (low.min(point), high.max(point));
    }
    let size = high - low;
    let count = laid.fit.points.len();
    let markers = if size.x < PATCH[0] || size.y < PATCH[1] {
        format!("the markers cover {:.0} × {:.0} mm of the face", size.x * 1e3, size.y * 1e3)
    } else if count < FEW {
        format!("the handles are found from {count} markers alone")
    } else {
        return None;
    };
    Some(format!(
        "{markers}, which may have slid along the skin by a centimetre or two; look at the picture, and if a \
         marker is not where the actor has it, name the vertices of three markers"
    ))
}

/// A warning about the handles that went where the examples move as their markers do.
pub(crate) fn moved(handles: &Handles, moved: &[usize]) -> Option<String> {
    let names: Vec<String> = moved.iter().map(|&i| handles.labels[i].clone()).collect();
    (!names.is_empty()).then(|| {
        format!(
            "markers that move as no example moves the mesh where they lie, so that their handles are a little \
             farther, where the examples do: {}; look at the picture",
            shortened(names)
        )
    })
}

/// The first of some words, and how many more there are.
fn shortened(mut words: Vec<String>) -> String {
    let more = words.len().saturating_sub(NAMED);
    words.truncate(NAMED);
    let shown = words.join(", ");
    if more == 0 { shown } else { format!("{shown} and {more} more") }
}

/// Why handles are probably wrong: a sentence each.
pub(crate) fn faults(face: &Face, placed: &[Placed], laid: &Laid) -> Vec<String> {
    let mut distances: Vec<f64> =
        placed.iter().map(|placed| placed.distance * face.metres_per_unit).collect();
    let far = distances.iter().filter(|distance| **distance > DOUBTFUL).count();
    let usual = median(&mut distances);
    let mut faults = Vec::new();
    if usual > LARGEST || laid.fit.cost > POOR {
        faults.push(format!(
            "the markers fit the mesh badly: they are {:.1} mm from it (median), expected at most {:.0}",
            usual * 1e3,
            LARGEST * 1e3
        ));
    } else if far as f64 > MOST_DOUBTFUL * placed.len() as f64 {
        faults.push(format!(
            "the markers fit the mesh badly: {far} of {} are farther than {:.0} mm from it, expected \
             at most a fifth",
            placed.len(),
            DOUBTFUL * 1e3
        ));
    }
    faults.extend_from_slice(&laid.choice.faults);
    faults
}

/// What a person should look at: a sentence each.
pub(crate) fn warnings(face: &Face, handles: &Handles, placed: &[Placed], laid: &Laid) -> Vec<String> {
    let mut warnings: Vec<String> = laid.choice.warning.iter().cloned().collect();
    let far: Vec<String> = (0..placed.len())
        .filter(|&i| placed[i].distance * face.metres_per_unit > DOUBTFUL)
        .map(|i| handles.labels[i].clone())
        .collect();
    if !far.is_empty() {
        warnings.push(format!(
            "markers farther than {} mm from the mesh: {}; look at the picture",
            DOUBTFUL * 1e3,
            shortened(far)
        ));
    }
    let mut moved: Vec<String> = Vec::new();
    for (label, placed) in handles.labels.iter().zip(placed) {
        if let Some(other) = placed.beside {
            moved.push(format!("{label} (at the place of {})", handles.labels[other]));
        }
    }
    if !moved.is_empty() {
        warnings.push(format!(
            "markers that got the next free vertex, because other markers are at their nearest place: {}; \
             check that no marker is in the take under two labels",
            shortened(moved)
        ));
    }
    if laid.choice.evidence.is_mirrored() {
        warnings.push(
            "markers whose labels say left are on the face's right, and the reverse: the take, the mesh or \
             the labels are a mirror image"
                .to_owned(),
        );
    }
    warnings
}
