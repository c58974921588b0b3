//! Which way is up: chooses among the ways in which the markers come to lie on the face.
use crate::label_words::{says_above, says_left};
use crate::posture::Posture;
use glam::{DMat3, DVec3};
use rhytid_core::numbers::median;
use rhytid_geometry::registration::OntoSurface;

/// A fit that is so many times farther from the mesh than the nearest one is not right, whatever speaks for
/// it.
const FARTHEST: f64 = 2.5;

/// The weight of a fit's distance from the mesh: of the ratio's natural logarithm.
const DISTANCE: f64 = 4.0;

/// The weights of what a take shows, each from −1 to 1. Labels are written by people, who know the face.
const UPRIGHT: f64 = 2.0;
const CONVENTION: f64 = 0.5;
const HALVES: f64 = 3.0;
const SIDES: f64 = 2.0;
const MOTION: f64 = 2.0;

/// Less than this does not tell one orientation from another.
const DECIDES: f64 = 1.5;

/// A second orientation is turned by more than this, in degrees, and its markers are nearly as near.
const TURNED: f64 = 30.0;
const NEARLY: f64 = 1.2;

/// A head is between these heights above the floor, in metres. A body's head is so far above its middle.
const HEIGHTS: [f64; 2] = [0.5, 2.6];
const ABOVE_BODY: f64 = 0.2;

/// The markers that move most move at least this far, in metres, or the take is still.
const MOVES: f64 = 0.004;

/// What is known of the markers that were laid.
pub(crate) struct Known<'a> {
    /// The posture of the actor.
    pub posture: &'a Posture,
    /// The columns of the markers.
    pub columns: &'a [usize],
    /// Their labels.
    pub labels: Vec<&'a str>,
    /// The mesh's right, up and forward axes.
    pub axes: DMat3,
    /// The middle of the mesh's face.
    pub middle: DVec3,
    /// Metres in one unit of the mesh.
    pub metres_per_unit: f64,
    /// Whether the take has the axes of the mesh.
    pub in_head_space: bool,
}

/// What speaks for an orientation, or against it where it is negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Evidence {
    /// Actors are upright.
    upright: f64,
    /// Labels such as chin and brow.
    halves: f64,
    /// Labels of left and right.
    sides: f64,
    /// The jaw moves most.
    motion: f64,
}

impl Evidence {
    fn new(laid: &OntoSurface, known: &Known<'_>) -> Self {
        let to_axes = known.axes.transpose();
        let at = |i: usize| to_axes * (laid.points[i] - known.middle);
        let count = laid.points.len();
        let share = |says: &dyn Fn(usize) -> Option<bool>| {
            let says: Vec<bool> = (0..count).filter_map(says).collect();
            let agree = says.iter().filter(|agrees| **agrees).count() as f64;
            // A single label may be wrong.
            if says.is_empty() { 0.0 } else { (2.0 * agree - says.len() as f64) / says.len().max(3) as f64 }
        };
        // Where both halves have labels, they are compared with each other.
        let mean_height = |above: bool| {
            let of: Vec<f64> =
                (0..count).filter(|&i| says_above(known.labels[i]) == Some(above)).map(|i| at(i).y).collect();
            (!of.is_empty()).then(|| of.iter().sum::<f64>() / of.len() as f64)
        };
        let border = match (mean_height(true), mean_height(false)) {
            (Some(above), Some(below)) => 0.5 * (above + below),
            _ => 0.0,
        };
        let heights: Vec<f64> = (0..count).map(|i| at(i).y).collect();
        let (above, moved) = known.posture.motion_above(known.columns, &heights);
        let metres = laid.motion.scale * known.metres_per_unit;
        Self {
            upright: upright(laid, known, metres),
            halves: HALVES * share(&|i| says_above(known.labels[i]).map(|above| above == (at(i).y > border))),
            sides: SIDES * share(&|i| says_left(known.labels[i]).map(|left| left == (at(i).x > 0.0))),
            motion: if moved * metres > MOVES { -MOTION * above } else { 0.0 },
        }
    }

    fn sum(&self) -> f64 {
        self.upright + self.halves + self.sides + self.motion
    }

    /// Whether most labels of left and right are on the wrong sides.
    pub(crate) fn is_mirrored(&self) -> bool {
        self.sides < -0.35 * SIDES
    }

    /// What speaks against the orientation, in words.
    fn against(&self) -> Vec<&'static str> {
        let mut words = Vec::new();
        for (evidence, said) in [
            (self.upright, "the actor is upside down"),
            (self.halves, "labels of the upper face are on the lower face"),
            (self.motion, "the jaw moves less than the forehead"),
        ] {
            if evidence < -0.5 {
                words.push(said);
            }
        }
        words
    }
}

/// From −1 to 1 times the weights: whether the actor is upright in a fit.
fn upright(laid: &OntoSurface, known: &Known<'_>, metres: f64) -> f64 {
    let posture = known.posture;
    let up = posture.turn * (laid.motion.rotation.conjugate() * known.axes.y_axis);
    let up = up.normalize_or_zero();
    if known.in_head_space {
        return UPRIGHT * up.dot(known.axes.y_axis);
    }
    let above_body = up.dot(posture.from_body) * metres;
    let height = up.dot(posture.place) * metres;
    let measured = if above_body.abs() > ABOVE_BODY {
        above_body.signum()
    } else if height.abs() > HEIGHTS[0] && height < HEIGHTS[1] {
        height.signum()
    } else {
        0.0
    };
    // Up is y or z in nearly all files.
    let high = up.y.max(up.z);
    let low = up.y.min(up.z);
    let convention = if high > 0.8 {
        1.0
    } else if low < -0.8 {
        -1.0
    } else {
        0.0
    };
    UPRIGHT * measured + CONVENTION * convention
}

/// The orientation that was chosen.
pub(crate) struct Choice {
    /// Its place among the fits.
    pub chosen: usize,
    /// What speaks for it.
    pub evidence: Evidence,
    /// What is wrong with it, a sentence each.
    pub faults: Vec<String>,
    /// What speaks against it, if more speaks for it.
    pub warning: Option<String>,
}

/// Chooses the orientation for which most speaks, with the distances of the markers from the mesh.
/// `distance` is that of one marker of a fit in mesh units.
pub(crate) fn choose(
    laid: &[OntoSurface],
    known: &Known<'_>,
    distance: &dyn Fn(&OntoSurface, usize) -> f64,
) -> Choice {
    let millimetres = 1e3 * known.metres_per_unit;
    // Below a tenth of a millimetre, a distance is noise.
    let residual = |fit: &OntoSurface| {
        let mut distances: Vec<f64> = (0..fit.points.len()).map(|i| distance(fit, i)).collect();
        (median(&mut distances) * millimetres).max(0.1)
    };
    let residuals: Vec<f64> = laid.iter().map(residual).collect();
    let least = residuals.iter().copied().fold(f64::INFINITY, f64::min);
    let evidence: Vec<Evidence> = laid.iter().map(|fit| Evidence::new(fit, known)).collect();
    let score = |i: usize| evidence[i].sum() - DISTANCE * (residuals[i] / least).ln();
    let possible: Vec<usize> = (0..laid.len()).filter(|&i| residuals[i] <= FARTHEST * least).collect();
    let mut chosen = 0;
    for (i, &candidate) in possible.iter().enumerate() {
        if i == 0 || score(candidate) > score(chosen) {
            chosen = candidate;
        }
    }
    let mut faults = Vec::new();
    let turn = |i: usize| laid[i].motion.rotation.angle_between(laid[chosen].motion.rotation).to_degrees();
    let is_rival = |i: &usize| {
        let advantage = score(chosen) - score(*i);
        turn(*i) > TURNED && residuals[*i] <= NEARLY * residuals[chosen] && advantage < DECIDES
    };
    if let Some(rival) = (0..laid.len()).filter(|i| *i != chosen).find(is_rival) {
        faults.push(format!(
            "the markers fit the mesh nearly as well when they are turned by {:.0}°: {:.1} mm from it in \
             place of {:.1} (median)",
            turn(rival),
            residuals[rival],
            residuals[chosen]
        ));
    }
    let against = evidence[chosen].against().join(", and ");
    let mut warning = None;
    if evidence[chosen].sum() < -DECIDES && !against.is_empty() {
        faults.push(format!("the markers are probably laid the wrong way round: {against}"));
    } else if !against.is_empty() {
        warning = Some(format!(
            "the take and the mesh do not agree about which way is up: as the markers fit best, {against}; \
             look at the picture"
        ));
    }
    Choice { chosen, evidence: evidence[chosen], faults, warning }
}
