//! Alignment of the examples with the neutral: a movement of the scanned head between two scans is no
//! expression.
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{Example, Face};
use rhytid_geometry::laplacian::laplacian;
use rhytid_geometry::registration::{Similarity, rigid_inliers};
use rhytid_geometry::triangulate;

/// The most vertices that are compared.
const COMPARED: usize = 20_000;

/// Tolerances of vertices that stay, in metres: at least the first, and at most the second where scans are
/// rough.
const NEAR: [f64; 2] = [2e-4, 1e-3];

/// The least part of the surface that must stay.
const STAYS: f64 = 0.08;

/// The least number of compared vertices that must stay. Some motion brings a handful of any mesh's vertices
/// near to where they were.
const MANY: usize = 20;

/// An example that moves by less as a whole, in metres, is in the neutral's place.
const NOTHING: f64 = 2e-4;

/// This many times as much of the surface must stay with the motion taken out as without. So a jaw that opens
/// is no movement of the head.
const MORE: f64 = 4.0;

/// The rigid motion of an example as a whole, which [`crate::solve`] takes out.
#[derive(Debug, Clone, PartialEq)]
pub struct Misplaced {
    /// The example's name.
    pub example: String,
    /// The angle of the turn.
    pub degrees: f64,
    /// The distance that the motion moves the centroid, in mesh units.
    pub moved: f64,
    /// The motion from the example to the neutral's place.
    back: Similarity,
}

impl Misplaced {
    /// Moves the example's positions to the neutral's place.
    pub fn undo(&self, positions: &mut [[f64; 3]]) {
        positions.iter_mut().for_each(|x| *x = self.back.apply(DVec3::from_array(*x)).to_array());
    }
}

/// The examples that are not in the neutral's place, in their order.
///
/// At least three vertices that are pinned by name decide. Without them, it is the largest part of the
/// surface that moves rigidly. This part counts only if much less of the surface stays without the motion.
/// Empty for a face that is not whole.
pub fn misplaced(face: &Face) -> Vec<Misplaced> {
    let rest = &face.neutral.positions;
    let whole = |example: &&Example| example.positions.len() == rest.len();
    let mask = &face.settings.pins.vertices;
    let area = laplacian(rest, &triangulate(&face.neutral)).mass;
    let compared: Vec<usize> = match mask.len() {
        0..3 => (0..rest.len()).step_by(rest.len().div_ceil(COMPARED).max(1)).collect(),
        _ => mask.iter().map(|&v| v.index()).collect(),
    };
    let weights: Vec<f64> = compared.iter().map(|&v| area[v]).collect();
    let at = |positions: &[[f64; 3]]| {
        compared.iter().map(|&v| DVec3::from_array(positions[v])).collect::<Vec<_>>()
    };
    let neutral = at(rest);
    let total: f64 = weights.iter().sum();
    let of_example = |example: &Example| {
        let here = at(&example.positions);
        let still = rigid_inliers(&here, &neutral, &weights)?;
        let squares = here.iter().zip(&weights).map(|(x, w)| w * still.motion.apply(*x).distance_squared(*x));
        let moved = (squares.sum::<f64>() / total).sqrt() * face.metres_per_unit;
        let near = (2.0 * still.tolerance).max(NEAR[0] / face.metres_per_unit);
        // The number of vertices that stay, and their area.
        let stays = |motion: &Similarity| {
            let pairs = here.iter().zip(&neutral).zip(&weights);
            let near = pairs.filter(|((a, b), _)| motion.apply(**a).distance(**b) <= near);
            near.fold((0, 0.0), |(many, area), (_, w)| (many + 1, area + w))
        };
        let (many, of_surface) = stays(&still.motion);
        let is_clear = many >= MANY
            && of_surface >= (STAYS * total).max(MORE * stays(&Similarity::IDENTITY).1)
            && near * face.metres_per_unit <= NEAR[1];
        let is_clear = is_clear || mask.len() >= 3;
        let centroid = here.iter().zip(&weights).map(|(x, w)| *x * (w / total)).sum::<DVec3>();
        (is_clear && moved >= NOTHING).then(|| Misplaced {
            example: example.name.clone(),
            degrees: still.motion.rotation.to_axis_angle().1.to_degrees(),
            moved: still.motion.apply(centroid).distance(centroid),
            back: still.motion,
        })
    };
    face.examples.par_iter().filter(whole).filter_map(of_example).collect()
}

/// The face with its examples in the neutral's place. `None` if the face does not ask for it, or if all are
/// in place.
pub(crate) fn aligned(face: &Face) -> Option<(Face, Vec<Misplaced>)> {
    let misplaced = if face.settings.align { misplaced(face) } else { Vec::new() };
    if misplaced.is_empty() {
        return None;
    }
    let mut aligned = face.clone();
    for found in &misplaced {
        let example = aligned.examples.iter_mut().find(|example| example.name == found.example)?;
        found.undo(&mut example.positions);
    }
    Some((aligned, misplaced))
}
