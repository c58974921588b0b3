//! The learned method: what the thin shell leaves of the examples, in two bands. The smooth part is a linear function of
//! what the handles nearby do relative to each other; the folds are the chapter's, made zero at rest.
mod choice;
mod folds;
mod linear_band;
mod neighborhoods;
mod parts;
mod smoothing;

use crate::Topology;
use crate::bind::bind_nearest;
use crate::detail::{self, at_handles};
use crate::driven::DrivenComponents;
use crate::laplacian::laplacian;
use choice::Candidate;
use folds::Folds;
use linear_band::{LinearBand, LinearSettings, VectorStrains};
use neighborhoods::{Distances, EdgeInfluences, LinearInfluences, Listens};
use rayon::prelude::*;
use rhytid_core::{Example, Progress, Result, Rig};

/// σ of the smooth band in mean rest lengths.
const SMOOTHING: f64 = 1.0 / 12.0;

/// What a project may say of the learned method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LearnedSettings {
    /// s in [0, 1]; `None` chooses.
    pub share: Option<f64>,
    /// λ > 0; `None` chooses.
    pub ridge: Option<f64>,
    /// σ_m ≥ 0 in mesh units: the standard deviation of a marker's noise per axis.
    pub marker_noise: f64,
    /// μ > 0: what is added to the diagonal of the folds' systems, as a part of its mean.
    pub fold_ridge: f64,
}

/// All that the learned method makes of the examples, step by step.
#[derive(Debug, Clone, PartialEq)]
pub struct Learned {
    /// Ŵ, V×P×3 in mesh units: the smooth part of what the shell leaves.
    pub smooth_residual: Vec<[f64; 3]>,
    /// B + ΔB, V×H.
    pub basis: Vec<f64>,
    /// α.
    pub influences: EdgeInfluences,
    /// ω.
    pub linear_influences: LinearInfluences,
    /// D of the examples, P×(F + H).
    pub example_vectors: Vec<[f64; 3]>,
    /// The s and λ that were taken.
    pub chosen: Candidate,
    /// In the order in which they were tried.
    pub candidates: Vec<Candidate>,
    /// ΔB, c and the errors by leaving out.
    pub band: LinearBand,
    /// f of the centres, N×F.
    pub pose_features: Vec<f64>,
    /// d, P×V in mesh units: what both bands' large scale leaves, in its tangent frames.
    pub detail: Vec<[f64; 3]>,
    /// The folds' weights.
    pub folds: Folds,
}

/// Learns from `examples` what the shell leaves of them.
///
/// `rig` needs its rest pose, triangles, handles, strain edges, tangent neighbours and, as its basis, the shell's;
/// `parts` says which parts have a handle; of the others, those that the examples show to be rigid get no rows, and the rest
/// those of the closest point of the driven surface.
///
/// # Errors
/// [`rhytid_core::Error::Cancelled`]; [`rhytid_core::Error::Input`] and [`rhytid_core::Error::Internal`] if a system has no
/// solution in floating point.
pub fn learn(
    rig: &mut Rig<f64>,
    topology: &Topology,
    parts: &DrivenComponents,
    examples: &[Example],
    max_influences: usize,
    settings: LearnedSettings,
    progress: &dyn Progress,
) -> Result<Learned> {
    let rest_lengths = rig.rest_lengths();
    let mean = rest_lengths.iter().sum::<f64>() / rest_lengths.len().max(1) as f64;
    let handle_rest = at_handles(rig, &rig.rest);
    let displacements: Vec<Vec<[f64; 3]>> = examples
        .iter()
        .map(|example| {
            let at = at_handles(rig, &example.positions);
            at.iter().zip(&handle_rest).map(|(x, rest)| [0, 1, 2].map(|c| x[c] - rest[c])).collect()
        })
        .collect();

    let listens = parts::listens(&rig.rest, parts, examples);
    let (driven, handles) = (&parts.driven, rig.handles.len());
    let follows = |v: usize| matches!(listens[v], Listens::As(_));
    bind_nearest(&rig.rest, &rig.triangles, driven, follows, handles, &mut rig.basis);
    let mut smooth_residual = residual(rig, examples, &displacements);
    smoothing::smooth(
        &rig.rest,
        &rig.triangles,
        &rig.handles,
        driven,
        SMOOTHING * mean,
        &mut smooth_residual,
        progress,
    )?;

    let distances = Distances::new(&rig.rest, topology, &rig.handles);
    let influences =
        neighborhoods::edge_influences(&distances, &rig.handles, &rig.strain_edges, mean, max_influences);
    let linear_influences = neighborhoods::linear_influences(
        &rig.rest,
        &rig.handles,
        &distances,
        &influences,
        &listens,
        rig.strain_edges.len(),
        mean,
    );
    drop(distances);

    let strains = VectorStrains::new(&displacements, &rig.strain_edges, &rest_lengths, mean);
    let mut area = laplacian(&rig.rest, &rig.triangles).mass;
    rig.handles.iter().for_each(|&v| area[v as usize] = 0.0);
    let (chosen, candidates) = choice::choose(
        &strains,
        &linear_influences,
        &smooth_residual,
        &area,
        (
            settings.share.as_ref().map_or(&choice::SHARES[..], std::slice::from_ref),
            settings.ridge.as_ref().map_or(&choice::RIDGES[..], std::slice::from_ref),
        ),
        settings.marker_noise,
    )?;
    let linear =
        LinearSettings { share: chosen.share, ridge: chosen.ridge, marker_noise: settings.marker_noise };
    let band =
        linear_band::linear_band(&strains, &linear_influences, &rig.handles, &smooth_residual, linear)?;
    rig.basis.par_iter_mut().zip(&band.basis_correction).for_each(|(b, more)| *b += more);

    let example_vectors = strains.by_example();
    let add_band = |handle_positions: &[[f64; 3]], positions: &mut [[f64; 3]]| {
        if band.example_weights.is_empty() {
            return;
        }
        let u: Vec<[f64; 3]> =
            handle_positions.iter().zip(&handle_rest).map(|(x, r)| [0, 1, 2].map(|c| x[c] - r[c])).collect();
        let of_frame = VectorStrains::new(&[u], &rig.strain_edges, &rest_lengths, mean).by_example();
        let table = products(&of_frame, &example_vectors);
        positions.par_iter_mut().enumerate().for_each(|(v, x)| {
            let c = &band.example_weights[v * examples.len()..][..examples.len()];
            let of_vertex = v * linear_influences.per_vertex..(v + 1) * linear_influences.per_vertex;
            for (p, c) in c.iter().enumerate() {
                let kappa: f64 = linear_influences.features[of_vertex.clone()]
                    .iter()
                    .zip(&linear_influences.weights[of_vertex.clone()])
                    .map(|(&e, w)| w * table[e as usize * examples.len() + p])
                    .sum();
                for axis in 0..3 {
                    x[axis] += c[axis] * kappa;
                }
            }
        });
    };
    let (pose_features, detail) =
        detail::features_and_detail(rig, &rest_lengths, topology, examples, |_| true, add_band, progress)?;
    let folds = folds::folds(
        &pose_features,
        examples.len(),
        &influences,
        &detail,
        rig.vertices(),
        settings.fold_ridge,
    )?;
    Ok(Learned {
        smooth_residual,
        basis: rig.basis.clone(),
        influences,
        linear_influences,
        example_vectors,
        chosen,
        candidates,
        band,
        pose_features,
        detail,
        folds,
    })
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
fn residual(rig: &Rig<f64>, examples: &[Example], displacements: &[Vec<[f64; 3]>]) -> Vec<[f64; 3]> {
    let (count, handles) = (examples.len(), rig.handles.len());
    let mut residual = vec![[0.0; 3]; rig.vertices() * count];
    if count == 0 {
        return residual;
    }
    residual.par_chunks_mut(count).enumerate().for_each(|(v, of_vertex)| {
        let row = &rig.basis[v * handles..][..handles];
        for ((w, example), u) in of_vertex.iter_mut().zip(examples).zip(displacements) {
            for c in 0..3 {
                let moved: f64 = row.iter().zip(u).map(|(b, u)| b * u[c]).sum();
                w[c] = example.positions[v][c] - (rig.rest[v][c] + moved);
            }
        }
    });
    residual
}
