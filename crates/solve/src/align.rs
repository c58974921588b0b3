//! Examples put into the neutral's place: what the scanned head moved by between two scans is no expression.
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{Example, Face};
use rhytid_geometry::laplacian::laplacian;
use rhytid_geometry::registration::{Similarity, what_stays};
use rhytid_geometry::triangulate;

/// Vertices that are compared, at most.
const COMPARED: usize = 20_000;

/// What comes within this of the neutral does not move, in metres; and what is worth the name where scans are rough.
const NEAR: [f64; 2] = [2e-4, 1e-3];

/// The part of the surface that must stay, at least.
const STAYS: f64 = 0.08;

/// And so many of the vertices that are compared: some motion brings a handful of any mesh's near to where they were.
const MANY: usize = 20;

/// An example that moves by less as a whole, in metres, is in the neutral's place.
const NOTHING: f64 = 2e-4;

/// So many times as much must stay with the motion taken out as without: a jaw that opens is no other place of the head.
const MORE: f64 = 4.0;

/// What an example was moved by as a whole, which [`crate::solve`] takes out.
#[derive(Debug, Clone, PartialEq)]
pub struct Misplaced {
    /// The example's name.
    pub example: String,
    /// How far it is turned.
    pub degrees: f64,
    /// How far its centroid is moved by it, in mesh units.
    pub moved: f64,
    /// Takes the example to the neutral's place.
    back: Similarity,
}

impl Misplaced {
    /// Brings the example's positions to the neutral's place.
    pub fn undo(&self, positions: &mut [[f64; 3]]) {
        positions.iter_mut().for_each(|x| *x = self.back.apply(DVec3::from_array(*x)).to_array());
    }
}

/// The examples that are not in the neutral's place, in their order: by the vertices that are pinned by name or, where none is, by the
/// largest part of the surface that is the same but for a rigid motion, where much less of it is the same without. Empty for a
/// face that is not whole.
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
        let still = what_stays(&here, &neutral, &weights)?;
        let squares = here.iter().zip(&weights).map(|(x, w)| w * still.motion.apply(*x).distance_squared(*x));
        let moved = (squares.sum::<f64>() / total).sqrt() * face.metres_per_unit;
        let near = (2.0 * still.tolerance).max(NEAR[0] / face.metres_per_unit);
        // How many stay, and their part of the surface.
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

/// The face with its examples in the neutral's place; `None` where the face does not ask for it or they are.
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
