//! The warp: one face's rest mesh is laid over another's.
//!
//! It is a thin shell that is drawn to landmarks and to the closest points.
use crate::landmarks::at_point;
use crate::skin::Skin;
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{Progress, Result, SurfacePoint, Table};
use rhytid_geometry::laplacian::laplacian;
use rhytid_solve::SoftShell;

/// The smoothing length and the search distance of each round of closest points, in spacings of the handles.
/// Stiff rounds come first (Amberg, Romdhani and Vetter 2007).
const ROUNDS: [[f64; 2]; 14] = [
    [1.0, 2.0],
    [1.0, 2.0],
    [0.7, 1.5],
    [0.5, 1.5],
    [0.35, 1.0],
    [0.25, 1.0],
    [0.18, 1.0],
    [0.125, 0.75],
    [0.125, 0.75],
    [0.09, 0.75],
    [0.0625, 0.5],
    [0.0625, 0.5],
    [0.0625, 0.5],
    [0.0625, 0.5],
];

/// The strength of a landmark. It draws as much as a patch of the surface, as wide as the spacing of the
/// handles, with this smoothing length in spacings.
const LANDMARK: f64 = 0.125;

/// The progress of an inner task that is one step of an outer one. Only cancelling is passed on.
struct Within<'a>(&'a dyn Progress);

impl Progress for Within<'_> {
    fn report(&self, _: &'static str, _: u64, _: u64) {}

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

/// The places of the vertices of `from` on `onto`.
///
/// `from` is already at the place of `onto`, except for the difference of their shapes. `landmarks` are pairs
/// of points, and `spacing` is the distance between handles.
///
/// # Errors
/// [`rhytid_core::Error::Input`] if the shell's system cannot be factorised;
/// [`rhytid_core::Error::Cancelled`].
pub(crate) fn warp(
    from: &Skin<'_>,
    onto: &Skin<'_>,
    landmarks: &[[SurfacePoint; 2]],
    spacing: f64,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>> {
    let rest: Vec<[f64; 3]> = from.positions.iter().map(DVec3::to_array).collect();
    let area = laplacian(&rest, from.triangles).mass;
    let shell = SoftShell::new(&rest, from.triangles, &from.takes_part, spacing);
    let surface = onto.facing(&onto.positions);
    let mut now = from.positions.clone();
    let total = ROUNDS.len() as u64 + 1;
    for round in 0..=ROUNDS.len() {
        progress.step("warp", round as u64, total)?;
        let mut weights = vec![0.0; rest.len()];
        let mut targets = vec![[0.0; 3]; rest.len()];
        // In the first round, the landmarks alone bring the face near.
        if let Some([smooth, within]) = round.checked_sub(1).map(|round| ROUNDS[round].map(|x| x * spacing)) {
            let normals = from.normals_of(&now);
            let target = |v: usize| {
                if !from.takes_part[v] || area[v] == 0.0 {
                    return None;
                }
                let closest = surface.closest(now[v], normals[v], within)?;
                (!onto.is_border(&closest)).then_some(closest.point)
            };
            let found: Vec<Option<DVec3>> = (0..rest.len()).into_par_iter().map(target).collect();
            for (v, point) in found.into_iter().enumerate() {
                if let Some(point) = point {
                    weights[v] = area[v] / (smooth * smooth);
                    targets[v] = (point - from.positions[v]).to_array();
                }
            }
        }
        for [a, b] in landmarks {
            let to = at_point(b, &onto.positions) - at_point(a, &from.positions);
            for (v, part) in a.corners() {
                let (v, drawn) = (v.index(), part / (LANDMARK * LANDMARK));
                let whole = weights[v] + drawn;
                targets[v] = ((DVec3::from_array(targets[v]) * weights[v] + to * drawn) / whole).to_array();
                weights[v] = whole;
            }
        }
        let targets = Table::new(targets.len(), 1, targets);
        let moved = shell.drawn(&weights, &targets, &Within(progress))?;
        now = from.positions.iter().zip(moved.as_slice()).map(|(p, u)| *p + DVec3::from_array(*u)).collect();
    }
    progress.step("warp", total, total)?;
    Ok(now)
}
