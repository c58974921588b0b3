//! The solve: from scans to a [`Rig`], sections 1 to 7 of the method (`docs/method.md`), one step a file, all in float64;
//! and the doctor ([`examine`]), who says what would hurt it. A program that only plays rigs does not need this crate.
//!
//! ```
//! use rhytid_core::{Face, Faces, Handles, Mesh, NoProgress, Settings, UpAxis};
//!
//! // A sheet of 3 × 3 vertices in four quads, held at its corners.
//! let mut faces = Faces::default();
//! for [a, b, c, d] in [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]] {
//!     faces.push(&[a, b, c, d]);
//! }
//! let positions = (0..9).map(|v| [f64::from(v % 3), f64::from(v / 3), 0.0]).collect();
//! let face = Face {
//!     name: "sheet".into(),
//!     neutral: Mesh { positions, faces, ..Mesh::default() },
//!     metres_per_unit: 0.01,
//!     up_axis: UpAxis::Y,
//!     handles: Handles { labels: ["a", "b", "c", "d"].map(String::from).to_vec(), vertices: vec![0, 2, 6, 8] },
//!     examples: Vec::new(),
//!     settings: Settings::default(),
//! };
//! assert!(rhytid_solve::examine(&face).findings.iter().all(|finding| finding.severity < rhytid_solve::Severity::Error));
//! let rig = rhytid_solve::solve(&face, &NoProgress)?;
//! // The middle moves by the mean of the four corners.
//! let middle = &rig.basis[4 * 4..][..4];
//! assert!(middle.iter().all(|weight| (weight - 0.25).abs() < 1e-9));
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

mod align;
pub mod basis;
mod bind;
mod detail;
mod doctor;
mod driven;
mod exposure;
pub mod influences;
mod learned;
mod mirror;
mod pins;
mod placement;
mod rbf;
mod refine;
mod soft_shell;
mod system;
pub mod tangent_frames;

pub use align::{Misplaced, misplaced};
pub use doctor::{Finding, Report, Severity, check, examine};
pub use driven::DrivenComponents;
pub use learned::{Candidate, Confidence, FAR, FreePart, PlannedScan, ScanPlan, Smoothing, plan_scans};
pub use placement::{Placed, Skin};
pub use refine::Refine;
pub use soft_shell::SoftShell;
pub use system::System;

/// What the tests of the learned method take apart. No promise is made for it.
#[doc(hidden)]
pub mod internals {
    pub use crate::learned::{Steps, learn};
}

use rhytid_core::{Bind, Error, Face, Method, Progress, Result, Rig, StrainEdges};
use rhytid_geometry::{Topology, geodesic, laplacian, triangulate};
use rhytid_kernels::strain;

/// ℓ where the user gives none: the mean rest length of the strain edges, which join neighbouring handles.
///
/// ℓ is the distance over which bending resists: far below the handles' spacing the surface is pulled to a tip
/// at every marker, far above it nothing changes any more. `None` without a strain edge.
pub fn default_bending_length(rest_lengths: &[f64]) -> Option<f64> {
    let mean = rest_lengths.iter().sum::<f64>() / rest_lengths.len() as f64;
    (mean > 0.0).then_some(mean)
}

/// What the solve says of its work besides the rig.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Account {
    /// What was taken out of examples that were not in the neutral's place.
    pub misplaced: Vec<Misplaced>,
    /// How many vertices are pinned.
    pub pins: usize,
    /// The share and ridge of the linear band that were tried, the one that was taken first; none by the chapter's method.
    pub candidates: Vec<Candidate>,
    /// What became of the parts without a handle, in the order of their lowest vertices; none by the chapter's method.
    pub parts: Vec<FreePart>,
}

/// Solves `face`: everything a device needs to animate it from handle positions.
///
/// Takes seconds (530,000 vertices on two cores: under fifteen); reports to `progress` and stops when that says so.
///
/// # Errors
/// [`Error::Input`] with the first error that [`examine`] finds, or if the system cannot be factorised;
/// [`Error::Cancelled`].
pub fn solve(face: &Face, progress: &dyn Progress) -> Result<Rig<f64>> {
    Ok(solve_and_account(face, progress)?.0)
}

/// The same, with what was found on the way.
///
/// # Errors
/// As [`solve`].
pub fn solve_and_account(face: &Face, progress: &dyn Progress) -> Result<(Rig<f64>, Account)> {
    let (rig, account, _) = solve_with(face, progress, false)?;
    Ok((rig, account))
}

/// The same, and the leave-one-out map: P errors at each vertex, V×P×3 in mesh units, that the smooth part of each of the rig's
/// examples would have if it were left out. Empty by the chapter's method.
///
/// # Errors
/// As [`solve`].
pub fn solve_and_leave_one_out(
    face: &Face,
    progress: &dyn Progress,
) -> Result<(Rig<f64>, Account, Vec<[f64; 3]>)> {
    solve_with(face, progress, true)
}

fn solve_with(
    face: &Face,
    progress: &dyn Progress,
    leave_one_out: bool,
) -> Result<(Rig<f64>, Account, Vec<[f64; 3]>)> {
    check(face)?;
    let (aligned, misplaced) = align::aligned(face).unzip();
    let face = aligned.as_ref().unwrap_or(face);
    let mirrored = mirror::with_mirror_images(face)?;
    let face = mirrored.as_ref().unwrap_or(face);
    let at_rest = pins::with_pins_at_rest(face);
    let face = at_rest.as_ref().unwrap_or(face);
    let mut shell = shell(face, progress)?;
    let pins = shell.pinned.iter().filter(|pinned| **pinned).count();
    let (mut account, mut errors) =
        (Account { misplaced: misplaced.unwrap_or_default(), pins, ..Account::default() }, Vec::new());
    match face.settings.method {
        Method::Chapter => chapter(face, &mut shell, progress)?,
        Method::Learned(settings) => {
            let steps = learned::learn(&mut shell, face, settings, progress)?;
            account.candidates.push(steps.chosen);
            let is_other =
                |other: &&Candidate| (other.share, other.ridge) != (steps.chosen.share, steps.chosen.ridge);
            account.candidates.extend(steps.candidates.iter().filter(is_other));
            account.parts.clone_from(&steps.parts);
            if leave_one_out {
                let vertices: Vec<u32> = (0..face.neutral.positions.len() as u32).collect();
                errors = steps.leave_one_out(&vertices)?;
            }
            steps.finish(&settings, &mut shell.rig);
        }
    }
    let rig = shell.rig;
    if let Some(v) = not_finite(&rig) {
        return Err(Error::not_solvable(format!(
            "the solve gives no finite result at vertex {v}: coordinates or triangles there are beyond float64; \
             run the doctor and mend what it names"
        )));
    }
    Ok((rig, account, errors))
}

/// What both methods start from.
#[doc(hidden)]
pub struct Shell {
    /// A rig without influences, features and weights, and with the thin shell's basis.
    pub rig: Rig<f64>,
    /// Of the rig's triangles.
    pub topology: Topology,
    /// Which parts have a handle.
    pub parts: DrivenComponents,
    /// Which vertices are pinned.
    pub(crate) pinned: Vec<bool>,
    /// The handle nearest to each vertex.
    pub(crate) cells: Vec<geodesic::Cell>,
    /// Of the rest pose.
    pub(crate) laplacian: laplacian::Laplacian,
}

/// Solves the thin shell of a face that the doctor lets through.
///
/// # Errors
/// [`Error::Input`] if the system cannot be factorised; [`Error::Cancelled`].
#[doc(hidden)]
pub fn shell(face: &Face, progress: &dyn Progress) -> Result<Shell> {
    progress.step("strain edges", 0, 1)?;
    let rest = &face.neutral.positions;
    let triangles = triangulate(&face.neutral);
    let topology = Topology::new(rest.len(), &triangles);
    let handles = &face.handles.vertices;
    let parts = DrivenComponents::new(rest, &triangles, handles);
    let graph = geodesic::EdgeGraph::new(rest, &topology);
    let cells = geodesic::nearest_handles(&graph, handles);
    let strain_edges = match &face.settings.strain_edges {
        StrainEdges::Given(edges) => edges.clone(),
        StrainEdges::Auto => {
            let of_handle: Vec<Option<u32>> =
                cells.iter().map(|cell| cell.map(|(_, handle)| handle)).collect();
            let mut edges = geodesic::touching_cells(&topology, &of_handle);
            // Two handles at one place (lips that touch) have no strain between them.
            let at = |h: u32| rest[handles[h as usize] as usize];
            edges.retain(|&[a, b]| at(a) != at(b));
            // The chapter's rigs keep the edges that they had.
            if matches!(face.settings.method, Method::Learned(_)) {
                geodesic::drop_far_pairs(&graph, &cells, &mut edges);
            }
            edges
        }
    };
    let rest_lengths = strain::rest_lengths(rest, handles, &strain_edges);
    progress.step("strain edges", 1, 1)?;

    let bending_length = match face.settings.bending_length {
        Some(length) => length,
        None => default_bending_length(&rest_lengths).unwrap_or_else(|| 0.25 * diagonal(face)),
    };
    let laplacian = laplacian::laplacian(rest, &triangles);
    let spacing = default_bending_length(&rest_lengths).unwrap_or(bending_length);
    let pinned = pins::pins(face, &cells, spacing);
    let moves: Vec<bool> =
        parts.driven.iter().zip(&pinned).map(|(driven, pinned)| *driven && !pinned).collect();
    let basis = basis::basis(rest, laplacian.clone(), handles, &moves, bending_length, progress)?;
    progress.step("frames", 0, 1)?;
    let tangent_neighbors = tangent_frames::tangent_neighbors(rest, &triangles, &topology);
    progress.step("frames", 1, 1)?;
    let rig = Rig {
        name: face.name.clone(),
        metres_per_unit: face.metres_per_unit,
        up_axis: face.up_axis,
        labels: face.handles.labels.clone(),
        example_names: face.examples.iter().map(|e| e.name.clone()).collect(),
        faces: face.neutral.faces.clone(),
        uvs: face.neutral.uvs.clone(),
        materials: face.neutral.materials.clone(),
        bending_length,
        beta: 0.0,
        handles: handles.clone(),
        tangent_neighbors,
        triangles,
        rest: rest.clone(),
        basis,
        strain_edges,
        influence_edges: Vec::new(),
        influence_weights: Vec::new(),
        pose_features: Vec::new(),
        rbf_weights: Vec::new(),
        example_handles: face
            .examples
            .iter()
            .flat_map(|e| handles.iter().map(|&v| e.positions[v as usize]))
            .collect(),
        rotations: face.settings.rotations,
        learned: None,
    };
    Ok(Shell { rig, topology, parts, pinned, cells, laplacian })
}

/// Sections 4, 6 and 7: the chapter's method from the shell on.
fn chapter(face: &Face, shell: &mut Shell, progress: &dyn Progress) -> Result<()> {
    let Shell { rig, topology, parts, pinned, .. } = shell;
    let follows = face.settings.bind == Bind::Nearest;
    if follows {
        progress.step("bind", 0, 1)?;
        let (driven, handles) = (&parts.driven, rig.handles.len());
        let follows = |v: usize| !driven[v] && !pinned[v];
        bind::bind_nearest(&rig.rest, &rig.triangles, driven, follows, handles, &mut rig.basis);
        progress.step("bind", 1, 1)?;
    }

    progress.step("influences", 0, 1)?;
    let rest_lengths = rig.rest_lengths();
    let handle_rest: Vec<[f64; 3]> = rig.handles.iter().map(|&v| rig.rest[v as usize]).collect();
    let influences = influences::influences(
        &rig.rest,
        &handle_rest,
        &rig.strain_edges,
        &rest_lengths,
        face.settings.max_influences,
    );
    rig.beta = influences.beta;
    rig.influence_edges = influences.edges;
    rig.influence_weights = influences.weights;
    progress.step("influences", 1, 1)?;

    rig.pose_features = detail::pose_features(rig, &face.examples);
    let moves = |v| parts.driven[v] || follows;
    let detail = detail::detail(rig, topology, &face.examples, moves, |_, _| (), progress)?;
    rig.rbf_weights = rbf::rbf_weights(
        &rig.pose_features,
        rig.centers(),
        (&rig.influence_edges, &rig.influence_weights),
        &detail,
        rig.vertices(),
        progress,
    )?;
    Ok(())
}

/// The length of the neutral's bounding-box diagonal.
fn diagonal(face: &Face) -> f64 {
    let [low, high] = face.neutral.bounds().unwrap_or_default();
    (0..3).map(|c| (high[c] - low[c]).powi(2)).sum::<f64>().sqrt()
}

fn not_finite(rig: &Rig<f64>) -> Option<usize> {
    let basis = rig.basis.iter().position(|x| !x.is_finite()).map(|i| i / rig.handles.len());
    let weights = || rig.rbf_weights.iter().position(|w| w.iter().any(|x| !x.is_finite()));
    basis.or_else(|| weights().map(|i| i / rig.centers()))
}
