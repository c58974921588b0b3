//! The handles of a face from one frame of a take: which point of the skin each marker is at.
use crate::tracks::seen;
use crate::typical::{rigid_set, typical_frame};
use glam::DVec3;
use rhytid_core::{Error, Face, Handles, InputErrorKind, RawTake, Result, SurfacePoint};
use rhytid_geometry::registration::OntoSurface;
use rhytid_solve::head::Region;
use rhytid_solve::{Placed, Skin};
use std::collections::BTreeSet;

/// A marker on a head band keeps its distance from others and is at least this far off the skin, in metres.
const OFF_SKIN: f64 = 0.005;

/// Rounds in which markers of a head band are told from those of the face.
const PASSES: usize = 3;

/// A marker that was laid farther from its vertex than this, in metres, is worth a look.
const DOUBTFUL: f64 = 0.008;

/// Fits with a greater cost are useless.
pub(crate) const POOR: f64 = 0.75;

/// A fit with another rotation whose cost is below this multiple might be the right one.
const AMBIGUOUS: f64 = 1.15;

/// What is known about the frame. Everything else is found.
#[derive(Debug, Clone, Default)]
pub struct HandleSettings {
    /// The frame to use, counted from 0; else the most typical one.
    pub frame: Option<usize>,
    /// Metres in one unit of the file; else the file's statement, or what fits the mesh's size.
    pub metres_per_unit: Option<f64>,
    /// Markers that are not on skin; else found.
    pub rigid: Option<Vec<String>>,
    /// Points of markers that are known.
    pub known: Vec<(String, SurfacePoint)>,
    /// The head, if the mesh has more and it is found already.
    pub head: Option<Region>,
}

/// Where a frame's markers are on a mesh.
#[derive(Debug, Clone)]
pub struct PlacedHandles {
    /// A handle for each marker on skin, in the file's order.
    pub handles: Handles,
    /// How far each point is from where its marker was laid, in mesh units.
    pub distances: Vec<f64>,
    /// Where each marker was laid, in mesh units.
    pub markers: Vec<[f64; 3]>,
    /// Markers that were left out: on a cap or a head band.
    pub rigid: Vec<String>,
    /// Markers that the frame does not show.
    pub unseen: Vec<String>,
    /// The frame.
    pub frame: usize,
    /// How badly the markers fit, from 0 to 1.
    pub cost: f64,
    /// What a person should look at: a sentence each.
    pub warnings: Vec<String>,
}

/// Places a handle for each marker on skin, from one frame of `raw`. The handles of `face` are ignored.
///
/// # Errors
/// [`Error::Input`]: a frame or a label that the take does not have, fewer than four markers, a mesh that is
/// not whole or looks elsewhere.
pub fn place_handles(face: &Face, raw: &RawTake, settings: &HandleSettings) -> Result<PlacedHandles> {
    let take = &raw.tracks;
    let (labels, count) = (&take.labels, take.labels.len());
    let index = |label: &String| {
        labels.iter().position(|known| known == label).ok_or_else(|| {
            Error::input(format!("no marker of the take is called “{label}”; it has {}", labels.join(", ")))
                .of_kind(InputErrorKind::UnknownMarkers { labels: vec![label.clone()] })
        })
    };
    let frame = settings.frame.unwrap_or_else(|| typical_frame(take));
    if frame >= take.frames() {
        return Err(Error::out_of_range(format!(
            "the frame {frame} is not in the take, expected 0 to {}",
            take.frames().saturating_sub(1)
        )));
    }
    let at = |m: usize| DVec3::from_array(take.positions[frame * count + m]);
    let skin = match &settings.head {
        Some(head) => Skin::from_region(face, head)?,
        None => Skin::from_face(face)?,
    };
    let mut known = vec![None; count];
    for (label, point) in &settings.known {
        if let Some(vertex) = point.triangle().iter().find(|v| v.index() >= face.neutral.positions.len()) {
            return Err(Error::out_of_range(format!(
                "the marker “{label}” is said to be at vertex {vertex}, expected 0 to {}",
                face.neutral.positions.len().saturating_sub(1)
            )));
        }
        known[index(label)?] = Some(*point);
    }
    let metres = settings.metres_per_unit.or(raw.metres_per_unit);
    let metres = metres.or(raw.in_head_space.then_some(face.metres_per_unit));
    let lay = |markers: &[usize]| {
        let positions: Vec<DVec3> = markers.iter().map(|&m| at(m)).collect();
        skin.place(&positions, metres, &markers.iter().map(|&m| known[m]).collect::<Vec<_>>())
    };
    let shown: Vec<usize> = (0..count).filter(|&m| seen(at(m))).collect();
    let rigid: BTreeSet<usize> = match &settings.rigid {
        Some(rigid) => rigid.iter().map(index).collect::<Result<_>>()?,
        None => {
            // A fit with all markers says roughly which ones are off the skin. A fit without these says which
            // really are.
            let mut rigid = BTreeSet::new();
            for _ in 0..PASSES {
                let others: Vec<usize> = shown.iter().copied().filter(|m| !rigid.contains(m)).collect();
                let (laid, _) = lay(&others)?;
                let distance = |m: usize| skin.distance(laid.motion.apply(at(m))) * face.metres_per_unit;
                // Markers whose labels say so come first, then the farthest.
                let rank = |&m: &usize| (says_head(&labels[m]), distance(m), m);
                let mut off: Vec<(bool, f64, usize)> = shown.iter().map(rank).collect();
                off.retain(|(says, distance, m)| known[*m].is_none() && (*says || *distance > OFF_SKIN));
                off.sort_by(|a, b| b.0.cmp(&a.0).then(b.1.total_cmp(&a.1)));
                let off: Vec<usize> = off.into_iter().map(|(_, _, m)| m).collect();
                rigid = rigid_set(take, &off).into_iter().collect();
                if shown.len() < rigid.len() + 4 {
                    rigid.clear();
                }
            }
            rigid
        }
    };
    let on_skin: Vec<usize> = shown.iter().copied().filter(|m| !rigid.contains(m)).collect();
    let (laid, placed) = lay(&on_skin)?;
    let handles = Handles {
        labels: on_skin.iter().map(|&m| labels[m].clone()).collect(),
        points: placed.iter().map(|placed| placed.point).collect(),
    };
    let warnings = warnings(face, &handles, &placed, &laid);
    Ok(PlacedHandles {
        distances: placed.iter().map(|placed| placed.distance).collect(),
        markers: laid.points.iter().map(DVec3::to_array).collect(),
        rigid: rigid.iter().map(|&m| labels[m].clone()).collect(),
        unseen: (0..count).filter(|&m| !seen(at(m))).map(|m| labels[m].clone()).collect(),
        handles,
        frame,
        cost: laid.cost,
        warnings,
    })
}

fn warnings(face: &Face, handles: &Handles, placed: &[Placed], laid: &OntoSurface) -> Vec<String> {
    let mut warnings = Vec::new();
    let named = |chosen: &dyn Fn(usize) -> bool| {
        let all: Vec<&str> =
            (0..placed.len()).filter(|&i| chosen(i)).map(|i| handles.labels[i].as_str()).collect();
        (!all.is_empty()).then(|| all.join(", "))
    };
    if laid.cost > POOR {
        warnings.push(
            "the markers fit the mesh badly: look at the picture, and choose another frame or give the \
             vertices of three or four markers by hand"
                .to_owned(),
        );
    } else if laid.runner_up < AMBIGUOUS * laid.cost {
        warnings.push(
            "the markers fit the mesh nearly as well in another orientation: look at the picture, and if it \
             is wrong, give the vertices of three or four markers by hand"
                .to_owned(),
        );
    }
    if let Some(far) = named(&|i| placed[i].distance * face.metres_per_unit > DOUBTFUL) {
        warnings.push(format!("markers farther than {} mm from the mesh: {far}", DOUBTFUL * 1e3));
    }
    let mut moved: Vec<String> = Vec::new();
    for (label, placed) in handles.labels.iter().zip(placed) {
        if let Some(other) = placed.beside {
            moved.push(format!("{label} (at the place of {})", handles.labels[other]));
        }
    }
    if !moved.is_empty() {
        warnings.push(format!(
            "markers that got the next free vertex, because other markers are at their nearest place: {}; check \
             that no marker is in the take under two labels",
            moved.join(", ")
        ));
    }
    let side = |i: usize| side(&handles.labels[i]).map(|left| left == (laid.points[i].x > middle(face)));
    let sides: Vec<bool> = (0..placed.len()).filter_map(side).collect();
    let right = sides.iter().filter(|right| **right).count();
    if sides.len() >= 4 && 2 * right < sides.len() {
        warnings.push(
            "markers whose labels say left are on the face's right, and the reverse: the take, the mesh or \
             the labels are a mirror image"
                .to_owned(),
        );
    }
    warnings
}

/// The middle between the face's left and its right.
fn middle(face: &Face) -> f64 {
    face.neutral.bounds().map_or(0.0, |[low, high]| 0.5 * (low[0] + high[0]))
}

/// Whether a label says that its marker is on a cap or a head band.
pub(crate) fn says_head(label: &str) -> bool {
    let lower = label.to_lowercase();
    let words = ["head", "cap", "helmet", "band", "hat"];
    !lower.contains("forehead") && words.iter().any(|word| lower.starts_with(word) || lower.ends_with(word))
}

/// Whether a label says left or right: `brow_l`, `LeftBrow`, `R_Cheek`, `lip.R`.
fn side(label: &str) -> Option<bool> {
    let lower = label.to_lowercase();
    for (word, left) in [("left", true), ("right", false)] {
        if lower.contains(word) {
            return Some(left);
        }
    }
    let parts: Vec<&str> = label.split(['_', '.', '-', ' ', ':']).collect();
    if parts.len() > 1 {
        for part in [parts[0], parts[parts.len() - 1]] {
            match part {
                "l" | "L" => return Some(true),
                "r" | "R" => return Some(false),
                _ => {}
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::{says_head, side};

    #[test]
    fn labels_say_their_side() {
        for (label, expected) in [
            ("brow_l", Some(true)),
            ("R_Cheek", Some(false)),
            ("LeftBrow3", Some(true)),
            ("lip.R", Some(false)),
            ("actor:jaw-right", Some(false)),
            ("mp30", None),
            ("lip", None),
            ("l", None),
        ] {
            assert_eq!(side(label), expected, "{label}");
        }
    }

    #[test]
    fn labels_say_what_is_on_the_head() {
        let says = ["head0", "Head_L", "HAT", "anna:cap", "headband2"].map(says_head);
        assert_eq!(says, [true; 5]);
        assert_eq!(["forehead_l", "brow", "LeftCheek"].map(says_head), [false; 3]);
    }
}
