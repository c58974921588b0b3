//! The learned method: the fine detail, which is the residual of the examples after the thin shell, in two
//! bands.
//!
//! The linear band is a linear function of the relative movements of the nearby handles. The wrinkles are the
//! chapter's, made zero at rest.
mod blend;
mod choice;
mod confidence;
mod distances;
mod fade;
mod linear_band;
mod neighborhoods;
mod parts;
mod prior;
mod reach;
mod scan_plan;
mod smoothing;
#[cfg(test)]
mod tests;
mod vector_strains;
mod wrinkles;

use crate::Details;
use crate::Shell;
use crate::detail;
use crate::noise;
use crate::vectors::widest;
pub use choice::Candidate;
use choice::OfPrior;
pub use confidence::{Confidence, EXTRAPOLATION};
use distances::{Distances, Searched};
use fade::Fade;
use linear_band::{LinearBand, LinearSettings};
use neighborhoods::{ANCHORS, EdgeInfluences, InfluenceSource, LinearInfluences};
pub use parts::{FreeMotion, FreePart};
use prior::PriorBand;
use rayon::prelude::*;
use rhytid_core::{
    Contact, Example, Face, FineScale, HandleSet, Influences, Learned, LearnedSettings, Motions, Progress,
    Result, SurfacePoint, Table, VertexId, WrinkleStrains,
};
use rhytid_kernels::{large_scale, vec3};
pub use scan_plan::{PlannedScan, ScanPlan, plan_scans};
pub use smoothing::Smoothing;
use smoothing::sigma;
use vector_strains::VectorStrains;
use wrinkles::{Ridges, Wrinkles};

/// A vertex has no smooth residual if it is below this part of the mean rest length.
const NOTHING: f64 = 1e-7;

/// Metres in a millimetre, the unit of the marker noise in the settings.
const MILLIMETRE: f64 = 1e-3;

/// The results of the learned method's steps.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Steps {
    /// Ŵ, V×P in mesh units: the smooth part of the residual after the shell, and after what is taken of the
    /// prior.
    pub smooth_residual: Table<[f64; 3]>,
    /// What is taken of the prior in the examples, V×P in mesh units. `None` without a prior.
    pub of_prior: Option<Table<[f64; 3]>>,
    /// α.
    pub influences: EdgeInfluences,
    /// ω.
    pub linear_influences: LinearInfluences,
    /// D of the examples, P×(F + H).
    pub example_vectors: Table<[f64; 3]>,
    /// The parts without a handle, in the order of their lowest vertices.
    pub parts: Vec<FreePart>,
    /// The chosen s, λ and reach.
    pub chosen: Candidate,
    /// All choices, in the order in which they were tried.
    pub candidates: Vec<Candidate>,
    /// How much of the linear band is kept.
    pub fade: Fade,
    /// g with the prior's, c and the variances. ΔB is in the shell's basis.
    pub band: LinearBand,
    /// f of the centres, N×F.
    pub pose_features: Table<f64>,
    /// d, P×V in mesh units: the residual after the shell and the linear band, in the tangent frames of their
    /// surface.
    ///
    /// It has no columns with wrinkles of vector strains, which compute the residual vertex by vertex.
    pub detail: Table<[f64; 3]>,
    /// The wrinkles' weights.
    pub wrinkles: Wrinkles,
    strains: VectorStrains,
    linear_settings: LinearSettings,
}

/// Learns the fine detail: the residual of the face's examples after the shell.
///
/// ΔB is added to the shell's basis.
///
/// # Errors
/// [`rhytid_core::Error::Cancelled`]. [`rhytid_core::Error::Input`] and [`rhytid_core::Error::Internal`] if a
/// system has no solution in floating point.
pub(crate) fn learn(
    shell: &mut Shell,
    face: &Face,
    settings: LearnedSettings,
    progress: &dyn Progress,
) -> Result<Steps> {
    let examples = &face.examples;
    // The basis also says how far vertices turn with the handles.
    let share = settings.share.or(face.settings.rotations.then_some(1.0));
    let settings = LearnedSettings { share, ..settings };
    // Without a strain edge there are only anchors, and the unit of their features does not matter.
    let mean = shell.handles.feature_lengths().last().copied().unwrap_or(1.0);
    let expressions = face.prior.as_ref().map_or(&[][..], |prior| &prior.expressions);

    let shown = if examples.is_empty() { expressions } else { examples };
    let (sources, mut free_parts) =
        parts::sources(&shell.surface.rest, &shell.parts, shown, face.settings.bind);
    let (influences, mut linear_influences) =
        neighborhoods(shell, &sources, face.settings.max_influences, mean, progress)?;
    let strains_of = |examples: &[Example]| {
        let of_example =
            |example: &Example| shell.handles.displacements(&shell.handles.at(&example.positions));
        let displacements: Vec<Vec<[f64; 3]>> = examples.iter().map(of_example).collect();
        VectorStrains::new(&displacements, &shell.handles.strain_edges, &shell.handles.rest_lengths(), mean)
    };
    let (mut strains, of_expressions) = (strains_of(examples), strains_of(expressions));
    let of_shown = if examples.is_empty() { &of_expressions } else { &strains };
    blend::bind(shell, shown, of_shown, &mut linear_influences, &mut free_parts, mean)?;
    let smoothing = match examples.is_empty() && expressions.is_empty() {
        true => None,
        false => Some(smoothing_of(shell, mean, progress)?),
    };
    let mut smooth_residual = smooth_residual(shell, examples, smoothing.as_ref(), progress)?;

    let marker_noise = settings.marker_noise * MILLIMETRE / face.metres_per_unit;
    let mut prior = match expressions.is_empty() {
        true => None,
        false => {
            let smooth = self::smooth_residual(shell, expressions, smoothing.as_ref(), progress)?;
            progress.step("prior", 0, 1)?;
            let prior =
                PriorBand::learn(of_expressions, &strains, &linear_influences, &smooth, marker_noise)?;
            progress.step("prior", 1, 1)?;
            Some(prior)
        }
    };
    progress.step("choice", 0, 1)?;
    let area = skin_area(shell);
    if let Some(smoothing) = smoothing.as_ref().filter(|_| shell.noise.iter().any(|sigma| *sigma > 0.0)) {
        let ridges = noise_ridges(shell, &smooth_residual, smoothing, &area, progress)?;
        strains = strains.with_noise(ridges);
    }
    let choose = |strains: &VectorStrains, prior: Option<OfPrior>| {
        choice::choose(strains, &linear_influences, &smooth_residual, &area, &settings, marker_noise, prior)
    };
    let mut choice = None;
    if let Some(learned) = &prior {
        let with_prior = strains.clone().with_prior(&learned.strains);
        let weight = face.prior.as_ref().and_then(|prior| prior.weight);
        let found = choose(&with_prior, Some(OfPrior { predicted: &learned.predicted, weight }))?;
        if found.0.prior > 0.0 {
            strains = with_prior;
            choice = Some(found);
        }
    }
    let (chosen, candidates) = match choice {
        Some(choice) => choice,
        // A prior that is not taken changes nothing.
        None => choose(&strains, None)?,
    };
    prior = prior.filter(|_| chosen.prior > 0.0);
    if let Some(prior) = &mut prior {
        prior.scale(chosen.prior);
        prior.subtract_from(&mut smooth_residual);
    }
    let linear_settings =
        LinearSettings { share: chosen.share, ridge: chosen.ridge, marker_noise, reach: chosen.reach };
    let fade = match settings.fade {
        true => Fade::by_leaving_out(&strains, &linear_influences, &smooth_residual, linear_settings, &area)?,
        false => Fade::whole(shell.handles.len(), shell.basis.height()),
    };
    progress.step("choice", 1, 1)?;
    let mut band = linear_band::linear_band(
        &strains,
        &linear_influences,
        &smooth_residual,
        linear_settings,
        &fade.of_vertices,
        &mut shell.basis,
        progress,
    )?;

    if let Some(prior) = &prior {
        prior.add_to(&linear_influences, &mut shell.basis, &mut band.feature_gains);
    }

    let pose_features = detail::pose_features(&shell.handles, examples);
    let smooth = LearnedBand {
        band: &band,
        influences: &linear_influences,
        strains: &strains,
        example_vectors: strains.by_example(),
        mean,
    };
    let (detail, wrinkles) = match settings.wrinkle_strains {
        WrinkleStrains::Vectors => {
            let wrinkles = smooth.vector_wrinkles(shell, examples, settings.wrinkle_ridge, progress)?;
            (Table::without_columns(examples.len()), wrinkles)
        }
        WrinkleStrains::Lengths => {
            let detail = smooth.detail(shell, examples, &sources, progress)?;
            let wrinkles = wrinkles::length_wrinkles(
                &pose_features,
                &influences,
                &detail,
                Ridges { ridge: settings.wrinkle_ridge, noise: &shell.noise },
                progress,
            )?;
            (detail, wrinkles)
        }
    };
    let example_vectors = smooth.example_vectors;
    Ok(Steps {
        smooth_residual,
        of_prior: prior.map(|prior| prior.predicted),
        influences,
        linear_influences,
        example_vectors,
        parts: free_parts,
        chosen,
        candidates,
        fade,
        band,
        pose_features,
        detail,
        wrinkles,
        strains,
        linear_settings,
    })
}

impl Steps {
    /// The error of each example if it is left out, in mesh units: a row of P for each of `vertices`.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Internal`] if a system has no solution in floating point.
    pub(crate) fn leave_one_out(&self, vertices: &[VertexId]) -> Result<Table<[f64; 3]>> {
        let mut errors = linear_band::leave_one_out(
            &self.strains,
            &self.linear_influences,
            &self.smooth_residual,
            self.linear_settings,
            vertices,
        )?;
        for (v, errors) in vertices.iter().zip(errors.rows_mut()) {
            let part = self.fade.of_vertices[v.index()];
            for (error, smooth) in errors.iter_mut().zip(self.smooth_residual.row(v.index())) {
                *error = fade::faded(part, *smooth, *error);
            }
        }
        Ok(errors)
    }

    /// Ŵ after the shell alone, V×P in mesh units.
    pub(crate) fn residual_of_shell(&self) -> Table<[f64; 3]> {
        let mut residual = self.smooth_residual.clone();
        if let Some(of_prior) = &self.of_prior {
            let (to, from) = (residual.as_mut_slice().as_flattened_mut(), of_prior.as_slice());
            to.iter_mut().zip(from.as_flattened()).for_each(|(to, from)| *to += from);
        }
        residual
    }

    /// The learned parts of a rig, except the basis.
    pub(crate) fn finish(
        self,
        settings: &LearnedSettings,
        handles: &HandleSet<f64>,
        contact: Contact<f64>,
    ) -> Details {
        // At vertices that stay, the residual of the examples fades to less than float32 can tell apart.
        let nothing = (NOTHING * handles.feature_lengths().last().copied().unwrap_or_default()).powi(2);
        // The rest pose's weight is the sum of the others': b stands in its place.
        let mut rbf_weights = self.wrinkles.weights;
        rbf_weights.rows_mut().zip(self.wrinkles.constants).for_each(|(w, b)| w[0] = b);
        let (edges, k) = (handles.strain_edges.len() as u32, self.influences.edges.columns());
        let anchors = self.linear_influences.anchors(edges, k, &self.band.feature_gains);
        Details {
            influences: Influences {
                edges: self.influences.edges,
                weights: self.influences.weights,
                beta: 0.0,
            },
            fine_scale: FineScale { pose_features: self.pose_features, rbf_weights },
            learned: Some(Learned {
                share: self.chosen.share,
                ridge: self.chosen.ridge,
                wrinkle_ridge: settings.wrinkle_ridge,
                marker_noise: self.linear_settings.marker_noise,
                reach: self.linear_settings.reach,
                prior_lengths: self.strains.prior_lengths().to_vec(),
                wrinkle_strains: settings.wrinkle_strains,
                anchors: anchors.handles,
                anchor_weights: anchors.weights,
                feature_gains: anchors.gains,
                example_weights: self.band.example_weights,
                variances: self
                    .band
                    .variances
                    .into_iter()
                    .map(|s| if s < nothing { 0.0 } else { s })
                    .collect(),
                contact,
            }),
        }
    }
}

/// α and ω: the influences on every vertex.
fn neighborhoods(
    shell: &Shell,
    sources: &[InfluenceSource],
    max_influences: usize,
    mean: f64,
    progress: &dyn Progress,
) -> Result<(EdgeInfluences, LinearInfluences)> {
    let Shell { surface, handles, topology, cells, .. } = shell;
    let k = max_influences.min(handles.strain_edges.len());
    let some_follow = sources.iter().any(|source| matches!(source, InfluenceSource::As(_)));
    let nearest_handles = if some_follow { k + ANCHORS } else { ANCHORS };
    let searched = Searched { rest: &surface.rest, topology, cells, nearest_edges: k + 1, nearest_handles };
    let distances = Distances::new(searched, handles, progress)?;
    progress.step("influences", 0, 1)?;
    let mut influences = neighborhoods::edge_influences(&distances, handles, mean, max_influences);
    let mut linear = neighborhoods::linear_influences(handles, &distances, &influences, sources, mean);
    // The corners of a handle's triangle are influenced alike. What is learned is then linear in their
    // residuals, with the same factors, so its mean stays 0 at the handle.
    for (corner, as_of) in handles.alike() {
        influences.copy(as_of, corner);
        linear.copy(as_of, corner);
    }
    progress.step("influences", 1, 1)?;
    Ok((influences, linear))
}

/// The learned linear band, on top of which the wrinkles are learned.
struct LearnedBand<'a> {
    band: &'a LinearBand,
    influences: &'a LinearInfluences,
    strains: &'a VectorStrains,
    /// D of the examples, P×(F + H).
    example_vectors: Table<[f64; 3]>,
    /// The mean rest length, in mesh units.
    mean: f64,
}

impl LearnedBand<'_> {
    /// The wrinkles of vector strains, from the residual after the shell and the band in the space of the
    /// mesh.
    fn vector_wrinkles(
        &self,
        shell: &Shell,
        examples: &[Example],
        wrinkle_ridge: f64,
        progress: &dyn Progress,
    ) -> Result<Wrinkles> {
        progress.step("detail", 0, 1)?;
        let left = residual(shell, examples);
        progress.step("detail", 1, 1)?;
        let edges = shell.handles.strain_edges.len() as u32;
        let c = &self.band.example_weights;
        let ridges = Ridges { ridge: wrinkle_ridge, noise: &shell.noise };
        wrinkles::vector_wrinkles(self.strains, self.influences, edges, &left, c, ridges, progress)
    }

    /// d, P×V: the residual after the shell and the band, in the tangent frames of their surface.
    fn detail(
        &self,
        shell: &Shell,
        examples: &[Example],
        sources: &[InfluenceSource],
        progress: &dyn Progress,
    ) -> Result<Table<[f64; 3]>> {
        let (handles, rest_lengths) = (&shell.handles, shell.handles.rest_lengths());
        let add_band = |handle_positions: &[[f64; 3]], positions: &mut [[f64; 3]]| {
            let u = handles.displacements(handle_positions);
            let of_frame =
                VectorStrains::new(&[u], &handles.strain_edges, &rest_lengths, self.mean).by_example();
            self.add(&products(of_frame.row(0), &self.example_vectors), positions);
        };
        let moves = |v: usize| sources[v] != InfluenceSource::Nothing;
        detail::detail(shell, examples, moves, add_band, progress)
    }

    /// Adds `Σ_p c_vp κ_vp` to V positions, given T of a frame.
    fn add(&self, table: &Table<f64>, positions: &mut [[f64; 3]]) {
        positions.par_iter_mut().enumerate().for_each(|(v, x)| {
            for (p, c) in self.band.example_weights.row(v).iter().enumerate() {
                let kappa: f64 = self.influences.at(v).map(|(e, w)| w * table.row(e as usize)[p]).sum();
                for axis in 0..3 {
                    x[axis] += c[axis] * kappa;
                }
            }
        });
    }
}

/// `T_ep = D_e · D_pe`, (F + H)×P: the products of one frame's vector strains with those of P examples.
fn products(of_frame: &[[f64; 3]], of_examples: &Table<[f64; 3]>) -> Table<f64> {
    let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let of_feature = |(e, d)| of_examples.rows().map(move |of_example| dot(d, &of_example[e]));
    let products = of_frame.iter().enumerate().flat_map(of_feature).collect();
    Table::new(of_frame.len(), of_examples.height(), products)
}

/// The smoothing of residuals, given the mean rest length.
fn smoothing_of(shell: &Shell, mean: f64, progress: &dyn Progress) -> Result<Smoothing> {
    let Shell { surface, handles, parts, pinned, laplacian, .. } = shell;
    progress.step("smooth", 0, 1)?;
    let smoothed: Vec<bool> =
        parts.driven.iter().zip(pinned).map(|(driven, pinned)| *driven && !pinned).collect();
    let (rest, points) = (&surface.rest, &handles.points);
    Smoothing::from_surface(rest, laplacian.clone(), points, &smoothed, sigma(mean), progress)
}

/// Ŵ, V×P: the smooth part of the residual of each example after the shell.
fn smooth_residual(
    shell: &Shell,
    examples: &[Example],
    smoothing: Option<&Smoothing>,
    progress: &dyn Progress,
) -> Result<Table<[f64; 3]>> {
    progress.step("residual", 0, 1)?;
    let mut residual = residual(shell, examples);
    progress.step("residual", 1, 1)?;
    if let Some(smoothing) = smoothing {
        smoothing.apply(&mut residual, progress)?;
    }
    // At pinned vertices, which no example moves, the residual is rounding and not to be learned.
    for (v, _) in shell.pinned.iter().enumerate().filter(|(_, pinned)| **pinned) {
        residual.row_mut(v).fill([0.0; 3]);
    }
    Ok(residual)
}

/// ρ_p of the linear band: what the noise of each example adds to its ridge, P.
///
/// It is r σ_p²/s². s² is the variance of Ŵ on the skin, per axis and without noise. r is the part of the
/// variance of a vertex's noise that is left in Ŵ, after the shell that follows noisy handles and the
/// smoothing. It is measured on noise of variance 1.
fn noise_ridges(
    shell: &Shell,
    smooth: &Table<[f64; 3]>,
    smoothing: &Smoothing,
    area: &[f64],
    progress: &dyn Progress,
) -> Result<Vec<f64>> {
    let at = |(v, rest): (usize, &[f64; 3])| [0, 1, 2].map(|c| rest[c] + noise::white(3 * v + c));
    let positions = shell.surface.rest.iter().enumerate().map(at).collect();
    let noisy = Example { name: String::new(), positions, mirror: false, noise: None };
    let of_noise = smooth_residual(shell, &[noisy], Some(smoothing), progress)?;
    let sample = choice::sample(area, choice::SAMPLES);
    let variance = |field: &Table<[f64; 3]>| {
        let squares = sample.iter().flat_map(|&v| field.row(v)).map(|w| vec3::dot(*w, *w));
        squares.sum::<f64>() / (3 * sample.len() * field.columns()).max(1) as f64
    };
    let squares: Vec<f64> = shell.noise.iter().map(|sigma| variance(&of_noise) * sigma * sigma).collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    let of_face = (variance(smooth) - mean).max(noise::LEAST_VARIANCE * mean);
    // Where there is no skin, there is nothing to learn.
    Ok(squares.iter().map(|square| if of_face > 0.0 { square / of_face } else { 0.0 }).collect())
}

/// The areas by which s, λ and the reach are chosen, V: 0 at handles and off the skin. Eyes and teeth have
/// large areas, but are not chosen for.
pub(crate) fn skin_area(shell: &Shell) -> Vec<f64> {
    let Shell { handles, parts, laplacian, .. } = shell;
    let mut area = laplacian.mass.clone();
    area.iter_mut().zip(&parts.driven).filter(|(_, driven)| !**driven).for_each(|(area, _)| *area = 0.0);
    let vertices = handles.points.iter().filter_map(SurfacePoint::vertex);
    vertices.for_each(|v| area[v.index()] = 0.0);
    area
}

/// W, V×P: the residual of each example after the shell, in the space of the mesh.
fn residual(shell: &Shell, examples: &[Example]) -> Table<[f64; 3]> {
    let Shell { surface, handles, basis, .. } = shell;
    let (count, rest) = (examples.len(), &surface.rest);
    let mut residual = Table::filled(rest.len(), count, [0.0; 3]);
    if count == 0 {
        return residual;
    }
    // One vector of each handle in each example, or four where the handles turn.
    let of_examples: Vec<Motions<f64>> =
        examples.iter().map(|e| handles.motions(&handles.at(&e.positions))).collect();
    let center = of_examples[0].center.map(|v| rest[v.index()]);
    let per_example = of_examples[0].vectors.len() / handles.len();
    // Handle by handle, x, y, z of the vectors of one example after the other.
    let of_handle =
        |h: usize| of_examples.iter().flat_map(move |of| of.vectors.iter().skip(h).step_by(handles.len()));
    let by_handle: Vec<f64> = (0..handles.len()).flat_map(of_handle).flatten().copied().collect();
    let numbers = 3 * per_example * count;
    let by_handle = Table::new(handles.len(), numbers, by_handle);
    residual.par_rows_mut().enumerate().for_each_init(
        || vec![0.0; numbers],
        |moved, (v, of_vertex)| {
            let row = basis.row(v);
            widest(
                #[inline(always)]
                || {
                    moved.fill(0.0);
                    for (b, u) in row.iter().zip(by_handle.rows()) {
                        moved.iter_mut().zip(u).for_each(|(moved, u)| *moved += b * u);
                    }
                },
            );
            let moved = moved.as_chunks::<3>().0.chunks_exact(per_example);
            for ((w, example), moved) in of_vertex.iter_mut().zip(examples).zip(moved) {
                let rest = rest[v];
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
