//! The learned method: what the thin shell leaves of the examples, in two bands. The smooth part is a linear function of
//! what the handles nearby do relative to each other; the folds are the chapter's, made zero at rest.
mod choice;
mod confidence;
mod distances;
mod folds;
mod linear_band;
mod neighborhoods;
mod parts;
mod reach;
mod scan_plan;
mod smoothing;

use crate::Shell;
use crate::bind::bind_nearest;
use crate::detail::{self, at_handles};
pub use choice::Candidate;
pub use confidence::{Confidence, FAR};
use distances::Distances;
use folds::Folds;
use linear_band::{LinearBand, LinearSettings, VectorStrains};
use neighborhoods::{ANCHORS, EdgeInfluences, LinearInfluences, Listens};
pub use parts::FreePart;
use pulp::Arch;
use rayon::prelude::*;
use rhytid_core::{Example, Face, FoldStrains, Learned, LearnedSettings, Progress, Result, Rig};
use rhytid_geometry::Topology;
use rhytid_geometry::geodesic::Cell;
use rhytid_kernels::{large_scale, vec3};
pub use scan_plan::{PlannedScan, ScanPlan, plan_scans};
pub use smoothing::Smoothing;
use smoothing::sigma;

/// A vertex whose smooth residual is below this part of the mean rest length has none.
const NOTHING: f64 = 1e-7;

/// Metres in a millimetre, the unit of the marker noise that is asked for.
const MILLIMETRE: f64 = 1e-3;

/// All that the learned method makes of the examples, step by step.
#[derive(Debug, Clone, PartialEq)]
pub struct Steps {
    /// Ŵ, V×P×3 in mesh units: the smooth part of what the shell leaves.
    pub smooth_residual: Vec<[f64; 3]>,
    /// α.
    pub influences: EdgeInfluences,
    /// ω.
    pub linear_influences: LinearInfluences,
    /// D of the examples, P×(F + H).
    pub example_vectors: Vec<[f64; 3]>,
    /// The parts without a handle, in the order of their lowest vertices.
    pub parts: Vec<FreePart>,
    /// The s and λ that were taken.
    pub chosen: Candidate,
    /// In the order in which they were tried.
    pub candidates: Vec<Candidate>,
    /// g, c and the variances. ΔB is in the rig's basis.
    pub band: LinearBand,
    /// f of the centres, N×F.
    pub pose_features: Vec<f64>,
    /// d, P×V in mesh units: what both bands' large scale leaves, in its tangent frames; empty where the folds are of vector strains,
    /// which have it vertex by vertex.
    pub detail: Vec<[f64; 3]>,
    /// The folds' weights.
    pub folds: Folds,
    strains: VectorStrains,
    linear_settings: LinearSettings,
}

/// Learns from the face's examples what the shell leaves of them.
///
/// ΔB is added to the shell's basis.
///
/// # Errors
/// [`rhytid_core::Error::Cancelled`]; [`rhytid_core::Error::Input`] and [`rhytid_core::Error::Internal`] if a system has no
/// solution in floating point.
pub fn learn(
    shell: &mut Shell,
    face: &Face,
    settings: LearnedSettings,
    progress: &dyn Progress,
) -> Result<Steps> {
    let Shell { rig, topology, parts, pinned, cells, laplacian } = shell;
    let (topology, parts) = (&*topology, &*parts);
    let examples = &face.examples;
    let rest_lengths = rig.rest_lengths();
    // Of anchors alone where there is no strain edge: then the unit of their features does not matter.
    let mean = rig.feature_lengths().last().copied().unwrap_or(1.0);
    let displacements = displacements(rig, examples);

    let (listens, free_parts) = parts::listens(&rig.rest, parts, examples, face.settings.bind);
    let follows = |v: usize| matches!(listens[v], Listens::As(_)) && !pinned[v];
    bind_nearest(&rig.rest, &rig.triangles, &parts.driven, follows, rig.handles.len(), &mut rig.basis);
    progress.step("residual", 0, 1)?;
    let mut smooth_residual = residual(rig, examples);
    progress.step("residual", 1, 1)?;
    // The choice below is for the skin: eyes and teeth have large areas and nothing to choose.
    let mut area = laplacian.mass.clone();
    area.iter_mut().zip(&parts.driven).filter(|(_, driven)| !**driven).for_each(|(area, _)| *area = 0.0);
    rig.handles.iter().for_each(|&v| area[v as usize] = 0.0);
    progress.step("smooth", 0, 1)?;
    if !examples.is_empty() {
        let smoothed: Vec<bool> =
            parts.driven.iter().zip(&*pinned).map(|(driven, pinned)| *driven && !pinned).collect();
        Smoothing::of(&rig.rest, laplacian.clone(), &rig.handles, &smoothed, sigma(mean), progress)?
            .apply(&mut smooth_residual, progress)?;
    }
    // What is left of what no example moves is rounding, and nothing to learn of.
    for (v, _) in pinned.iter().enumerate().filter(|(_, pinned)| **pinned) {
        smooth_residual[v * examples.len()..][..examples.len()].fill([0.0; 3]);
    }

    let (influences, linear_influences) =
        neighborhoods(rig, (topology, cells), &listens, face.settings.max_influences, mean, progress)?;
    let strains = VectorStrains::new(&displacements, &rig.strain_edges, &rest_lengths, mean);
    let marker_noise = settings.marker_noise * MILLIMETRE / face.metres_per_unit;
    progress.step("choice", 0, 1)?;
    let (chosen, candidates) =
        choice::choose(&strains, &linear_influences, &smooth_residual, &area, &settings, marker_noise)?;
    progress.step("choice", 1, 1)?;
    let linear_settings =
        LinearSettings { share: chosen.share, ridge: chosen.ridge, marker_noise, reach: settings.reach };
    let band = linear_band::linear_band(
        &strains,
        &linear_influences,
        &smooth_residual,
        linear_settings,
        &mut rig.basis,
        progress,
    )?;

    let example_vectors = strains.by_example();
    let pose_features = detail::pose_features(rig, examples);
    let (mut detail, fold_ridge) = (Vec::new(), settings.fold_ridge);
    let folds = if settings.fold_strains == FoldStrains::Vectors {
        progress.step("detail", 0, 1)?;
        let left = residual(rig, examples);
        progress.step("detail", 1, 1)?;
        let edges = rig.strain_edges.len() as u32;
        folds::vector_folds(
            &strains,
            (&linear_influences, edges),
            (&left, rig.vertices()),
            &band.example_weights,
            fold_ridge,
            progress,
        )?
    } else {
        let add_band = |handle_positions: &[[f64; 3]], positions: &mut [[f64; 3]]| {
            let rest = at_handles(rig, &rig.rest);
            let u = handle_positions.iter().zip(&rest).map(|(x, r)| [0, 1, 2].map(|c| x[c] - r[c])).collect();
            let of_frame = VectorStrains::new(&[u], &rig.strain_edges, &rest_lengths, mean).by_example();
            add_band(&band, &linear_influences, &products(&of_frame, &example_vectors), positions);
        };
        let moves = |v: usize| listens[v] != Listens::Nothing;
        detail = detail::detail(rig, topology, examples, moves, add_band, progress)?;
        let sizes = (examples.len(), rig.vertices());
        folds::length_folds(&pose_features, sizes.0, &influences, &detail, sizes.1, fold_ridge, progress)?
    };
    Ok(Steps {
        smooth_residual,
        influences,
        linear_influences,
        example_vectors,
        parts: free_parts,
        chosen,
        candidates,
        band,
        pose_features,
        detail,
        folds,
        strains,
        linear_settings,
    })
}

impl Steps {
    /// What each example would be off by if it were left out, P×3 in mesh units at each of `vertices`.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Internal`] if a system has no solution in floating point.
    pub fn leave_one_out(&self, vertices: &[u32]) -> Result<Vec<[f64; 3]>> {
        linear_band::leave_one_out(
            &self.strains,
            &self.linear_influences,
            &self.smooth_residual,
            self.linear_settings,
            vertices,
        )
    }

    /// Puts all that a device needs into `rig`.
    pub(crate) fn finish(self, settings: &LearnedSettings, rig: &mut Rig<f64>) {
        let centers = rig.centers();
        // Beside what stays, what is left of the examples fades to less than float32 can tell apart.
        let nothing = (NOTHING * rig.feature_lengths().last().copied().unwrap_or_default()).powi(2);
        rig.influence_edges = self.influences.edges;
        rig.influence_weights = self.influences.weights;
        rig.pose_features = self.pose_features;
        // The rest pose's weight is the sum of the others': b stands in its place.
        rig.rbf_weights = self.folds.weights;
        rig.rbf_weights.chunks_mut(centers).zip(self.folds.constants).for_each(|(w, b)| w[0] = b);
        let (anchors, anchor_weights, feature_gains) = self.linear_influences.anchors(
            rig.strain_edges.len() as u32,
            rig.influences(),
            &self.band.feature_gains,
        );
        rig.learned = Some(Learned {
            share: self.chosen.share,
            ridge: self.chosen.ridge,
            fold_ridge: settings.fold_ridge,
            marker_noise: self.linear_settings.marker_noise,
            reach: self.linear_settings.reach,
            fold_strains: settings.fold_strains,
            anchors,
            anchor_weights,
            feature_gains,
            example_weights: self.band.example_weights,
            variances: self.band.variances.into_iter().map(|s| if s < nothing { 0.0 } else { s }).collect(),
        });
    }
}

/// u of every example, P×H.
fn displacements(rig: &Rig<f64>, examples: &[Example]) -> Vec<Vec<[f64; 3]>> {
    let rest = at_handles(rig, &rig.rest);
    let of_example = |example: &Example| {
        let at = at_handles(rig, &example.positions);
        at.iter().zip(&rest).map(|(x, rest)| [0, 1, 2].map(|c| x[c] - rest[c])).collect()
    };
    examples.iter().map(of_example).collect()
}

/// α and ω: what every vertex listens to.
fn neighborhoods(
    rig: &Rig<f64>,
    along: (&Topology, &[Cell]),
    listens: &[Listens],
    max_influences: usize,
    mean: f64,
    progress: &dyn Progress,
) -> Result<(EdgeInfluences, LinearInfluences)> {
    let (edges, handles) = (&rig.strain_edges, &rig.handles);
    let k = max_influences.min(edges.len());
    let some_follow = listens.iter().any(|listens| matches!(listens, Listens::As(_)));
    let anchors = if some_follow { k + ANCHORS } else { ANCHORS };
    let distances = Distances::new(&rig.rest, along, handles, edges, (k + 1, anchors), progress)?;
    progress.step("influences", 0, 1)?;
    let influences = neighborhoods::edge_influences(&distances, handles, edges, mean, max_influences);
    let linear = neighborhoods::linear_influences(
        &rig.rest,
        handles,
        &distances,
        &influences,
        listens,
        edges.len(),
        mean,
    );
    progress.step("influences", 1, 1)?;
    Ok((influences, linear))
}

/// Adds `Σ_p c_vp κ_vp` to V positions, given T of a frame.
fn add_band(band: &LinearBand, influences: &LinearInfluences, table: &[f64], positions: &mut [[f64; 3]]) {
    let examples = band.example_weights.len() / positions.len().max(1);
    if examples == 0 {
        return;
    }
    positions.par_iter_mut().enumerate().for_each(|(v, x)| {
        let c = &band.example_weights[v * examples..][..examples];
        let of_vertex = v * influences.per_vertex..(v + 1) * influences.per_vertex;
        let listens =
            || influences.features[of_vertex.clone()].iter().zip(&influences.weights[of_vertex.clone()]);
        for (p, c) in c.iter().enumerate() {
            let kappa: f64 = listens().map(|(&e, w)| w * table[e as usize * examples + p]).sum();
            for axis in 0..3 {
                x[axis] += c[axis] * kappa;
            }
        }
    });
}

/// `T_ep = D_e · D_pe`, (F + H)×P: of one frame's vector strains with those of P examples.
fn products(of_frame: &[[f64; 3]], of_examples: &[[f64; 3]]) -> Vec<f64> {
    let examples = of_examples.len() / of_frame.len().max(1);
    let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let features = of_frame.iter().enumerate();
    features
        .flat_map(|(e, d)| (0..examples).map(move |p| dot(d, &of_examples[p * of_frame.len() + e])))
        .collect()
}

/// W, V×P×3: what the shell leaves of each example, in the space of the mesh.
fn residual(rig: &Rig<f64>, examples: &[Example]) -> Vec<[f64; 3]> {
    let (count, handles) = (examples.len(), rig.handles.len());
    let mut residual = vec![[0.0; 3]; rig.vertices() * count];
    if count == 0 {
        return residual;
    }
    // One vector of each handle in each example, or four where the handles turn.
    let of_examples: Vec<_> = examples.iter().map(|e| rig.motions(&at_handles(rig, &e.positions))).collect();
    let center = of_examples[0].1.map(|v| rig.rest[v as usize]);
    let per_example = of_examples[0].0.len() / handles;
    // Handle by handle, x, y, z of one example's vectors after the other.
    let of_handle = |h: usize| of_examples.iter().flat_map(move |(of, _)| of.iter().skip(h).step_by(handles));
    let by_handle: Vec<f64> = (0..handles).flat_map(of_handle).flatten().copied().collect();
    let numbers = 3 * per_example * count;
    let vectors = Arch::new();
    residual.par_chunks_mut(count).enumerate().for_each_init(
        || vec![0.0; numbers],
        |moved, (v, of_vertex)| {
            let row = &rig.basis[v * handles..][..handles];
            vectors.dispatch(
                #[inline(always)]
                || {
                    moved.fill(0.0);
                    for (b, u) in row.iter().zip(by_handle.chunks_exact(numbers)) {
                        moved.iter_mut().zip(u).for_each(|(moved, u)| *moved += b * u);
                    }
                },
            );
            let moved = moved.as_chunks::<3>().0.chunks_exact(per_example);
            for ((w, example), moved) in of_vertex.iter_mut().zip(examples).zip(moved) {
                let rest = rig.rest[v];
                let moved = match (moved, center) {
                    (&[at_center, x, y, z], Some(center)) => {
                        large_scale::turned(at_center, [x, y, z], vec3::sub(rest, center))
                    }
                    _ => moved[0],
                };
                *w = vec3::sub(example.positions[v], vec3::add(rest, moved));
            }
        },
    );
    residual
}
