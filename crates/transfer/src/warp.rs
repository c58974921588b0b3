//! The warp: one face's rest laid over another's, as a thin shell that is drawn to landmarks and to what is closest.
use crate::skin::Skin;
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{Progress, Result, Table, VertexId};
use rhytid_geometry::laplacian::laplacian;
use rhytid_solve::SoftShell;

/// In the rounds of closest points, over how far the shell smooths what draws it and how far it looks, both in spacings of the handles:
/// stiff first (Amberg, Romdhani and Vetter 2007).
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

/// A landmark draws as much as the surface around it, as wide as handles are apart, would over so many of their spacings.
const LANDMARK: f64 = 0.125;

/// Work whose steps are one step of other work: only the wish to stop goes through.
struct Within<'a>(&'a dyn Progress);

impl Progress for Within<'_> {
    fn report(&self, _: &'static str, _: u64, _: u64) {}

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

/// Where the vertices of `from`, which is where `onto` is already but for the difference of their shapes, come to lie on it. `landmarks` are pairs of
/// vertices; `spacing` is how far handles are apart.
///
/// # Errors
/// [`rhytid_core::Error::Input`] if the shell's system cannot be factorised; [`rhytid_core::Error::Cancelled`].
pub(crate) fn warp(
    from: &Skin<'_>,
    onto: &Skin<'_>,
    landmarks: &[[VertexId; 2]],
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
        // The landmarks alone bring it near.
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
        for &[a, b] in landmarks {
            let (v, both) = (a.index(), 1.0 / (LANDMARK * LANDMARK));
            let to = onto.positions[b.index()] - from.positions[v];
            let whole = weights[v] + both;
            targets[v] = ((DVec3::from_array(targets[v]) * weights[v] + to * both) / whole).to_array();
            weights[v] = whole;
        }
        let targets = Table::new(targets.len(), 1, targets);
        let moved = shell.drawn(&weights, &targets, &Within(progress))?;
        now = from.positions.iter().zip(moved.as_slice()).map(|(p, u)| *p + DVec3::from_array(*u)).collect();
    }
    progress.step("warp", total, total)?;
    Ok(now)
}
