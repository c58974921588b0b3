//! The solve: from scans to a [`Rig`], by sections 1 to 7 of the method (`docs/method.md`).
//!
//! Each step is a file, and all numbers are float64. The doctor ([`examine`]) reports what would harm a
//! solve. A program that only plays rigs does not need this crate.
//!
//! ```
//! use rhytid_core::{Face, Faces, Handles, Mesh, NoProgress, Settings, UpAxis, VertexId};
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
//!     handles: Handles { labels: ["a", "b", "c", "d"].map(String::from).to_vec(), points: [0, 2, 6, 8].map(|v| VertexId(v).into()).to_vec() },
//!     examples: Vec::new(),
//!     prior: None,
//!     settings: Settings::default(),
//! };
//! assert!(rhytid_solve::examine(&face).findings.iter().all(|finding| finding.severity < rhytid_solve::Severity::Error));
//! let rig = rhytid_solve::solve(&face, &NoProgress)?;
//! // The middle moves by the mean of the four corners.
//! let middle = rig.basis().row(4);
//! assert!(middle.iter().all(|weight| (weight - 0.25).abs() < 1e-9));
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

mod align;
pub mod basis;
mod bind;
mod contact;
mod detail;
mod doctor;
mod driven;
mod exposure;
mod face_parts;
mod face_places;
pub mod head;
pub mod influences;
mod learned;
mod mirror;
mod noise;
mod openings;
mod pins;
mod placement;
mod points;
mod profile;
mod rbf;
mod refine;
mod soft_shell;
mod spread;
mod system;
pub mod tangent_frames;
mod tissues;
mod vectors;
mod welded;

pub use align::{Misplaced, misplaced};
pub use contact::FoundEyeball;
pub use doctor::{ExampleSpace, Finding, Report, Severity, check, examine, example_spaces};
pub use driven::DrivenComponents;
pub use face_parts::{FacePart, face_parts};
pub use face_places::FacePlaces;
pub use learned::{
    Candidate, Confidence, EXTRAPOLATION, FreeMotion, FreePart, PlannedScan, ScanPlan, Smoothing, plan_scans,
};
pub use placement::{Placed, Skin};
pub use refine::Refine;
pub use soft_shell::SoftShell;
pub use system::System;
pub use welded::{Welded, points};

use rhytid_core::{
    Bind, Contact, Error, Examples, Face, FineScale, HandleId, HandleSet, Influences, Learned, Method,
    Progress, Result, Rig, RigParts, StrainEdges, Surface, Table, VertexId,
};
use rhytid_geometry::{Topology, geodesic, laplacian, triangulate};

/// ℓ where the user gives none: the mean rest length of the strain edges, which join neighbouring handles.
///
/// ℓ is the distance over which bending resists. With ℓ far below the handles' spacing, the surface forms a
/// tip at every marker. Far above it, a larger ℓ changes nothing. `None` without a strain edge.
pub fn default_bending_length(rest_lengths: &[f64]) -> Option<f64> {
    let mean = rest_lengths.iter().sum::<f64>() / rest_lengths.len() as f64;
    (mean > 0.0).then_some(mean)
}

/// Around a handle that keeps this much of the linear band, nothing is said to be faded.
pub const WHOLE: f64 = 0.95;

/// What is taken of a prior.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TakenPrior {
    /// The number of its expressions.
    pub expressions: usize,
    /// Its weight, 0 to 1: at 0 left-out examples are predicted no better with it.
    pub weight: f64,
}

/// What the solve reports in addition to the rig.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SolveReport {
    /// The number of points of the surface. It is that of the vertices if none are joined.
    pub points: usize,
    /// The motions that were taken out of examples which were not in the neutral's place.
    pub misplaced: Vec<Misplaced>,
    /// The noise of the examples, P in mesh units: the standard deviation of a vertex per axis.
    pub noise: Vec<f64>,
    /// The number of pinned vertices.
    pub pins: usize,
    /// The shares, ridges and reaches that were tried, the chosen ones first. Empty with the
    /// chapter's method.
    pub candidates: Vec<Candidate>,
    /// What is taken of the prior. `None` without a prior, and with the chapter's method.
    pub prior: Option<TakenPrior>,
    /// How much of the linear band is kept around each handle, H in 0..1: at 0 the shell is alone, because
    /// left-out examples are hardly better there with the band. Empty with the chapter's method.
    pub kept: Vec<f64>,
    /// The parts without a handle, in the order of their lowest vertices. Empty with the chapter's method.
    pub parts: Vec<FreePart>,
    /// The eyeballs on which lids slide.
    pub eyeballs: Vec<FoundEyeball>,
}

impl SolveReport {
    /// The handles around which less than [`WHOLE`] of the linear band is kept, with what is kept, the least
    /// first.
    pub fn faded(&self) -> Vec<(HandleId, f64)> {
        let kept = self.kept.iter().enumerate().map(|(h, kept)| (HandleId::from_index(h), *kept));
        let mut faded: Vec<_> = kept.filter(|(_, kept)| *kept < WHOLE).collect();
        faded.sort_by(|a, b| a.1.total_cmp(&b.1));
        faded
    }
}

/// A solved face, with the report of the solve.
#[derive(Debug, Clone, PartialEq)]
pub struct Solved {
    /// Everything a device needs to animate the face from handle positions.
    pub rig: Rig<f64>,
    /// What the solve reports of its work.
    pub report: SolveReport,
    /// The errors of examples that are left out, if they were asked for. `None` with the chapter's method.
    pub left_out: Option<LeaveOneOut>,
}

/// The errors of the smooth part of each example if that example is left out.
#[derive(Debug, Clone, PartialEq)]
pub struct LeaveOneOut {
    /// The error at each vertex, V×P in mesh units.
    pub errors: Table<[f64; 3]>,
    /// The error of the shell alone at each vertex, V×P in mesh units.
    pub of_shell: Table<[f64; 3]>,
    /// The area of skin around each vertex, V in mesh units squared. 0 at handles, and in parts without a
    /// handle such as eyes and teeth. [`Candidate::leave_one_out`] has the mean over this area.
    pub skin_area: Vec<f64>,
}

/// Solves `face`: everything a device needs to animate it from handle positions.
///
/// A solve takes seconds: under fifteen for 530,000 vertices on two cores. It reports to `progress`, and
/// stops when that says so.
///
/// # Errors
/// [`Error::Input`] with the first error that [`examine`] finds, or if the system cannot be factorised;
/// [`Error::Cancelled`].
pub fn solve(face: &Face, progress: &dyn Progress) -> Result<Rig<f64>> {
    Ok(solve_in_full(face, false, progress)?.rig)
}

/// Solves as [`solve`] does, and also gives the report, and [`Solved::left_out`] if `leave_one_out` is true.
///
/// # Errors
/// As [`solve`].
pub fn solve_in_full(face: &Face, leave_one_out: bool, progress: &dyn Progress) -> Result<Solved> {
    check(face)?;
    let mut solved = match Welded::new(face) {
        Some(welded) => {
            let name = |v: usize| welded.points.first[v];
            welded.expanded(solve_points(&welded.face, name, leave_one_out, progress)?, face)?
        }
        None => solve_points(face, VertexId::from_index, leave_one_out, progress)?,
    };
    let eyeballs: Vec<(VertexId, f64)> =
        solved.report.eyeballs.iter().map(|eyeball| (eyeball.first_vertex, eyeball.radius)).collect();
    if let Some(materials) = tissues::of_parts(&solved.rig, &eyeballs) {
        let mut parts = solved.rig.into_parts();
        parts.surface.materials = Some(materials);
        solved.rig = Rig::new(parts)?;
    }
    Ok(solved)
}

/// Solves a face each of whose vertices is a point of its own. `name` is what messages call a vertex.
fn solve_points(
    face: &Face,
    name: impl Fn(usize) -> VertexId,
    leave_one_out: bool,
    progress: &dyn Progress,
) -> Result<Solved> {
    let (aligned, misplaced) = align::aligned(face).unzip();
    let face = aligned.as_ref().unwrap_or(face);
    let mirrored = mirror::with_mirror_images(face, &name)?;
    let face = mirrored.as_ref().unwrap_or(face);
    let at_rest = pins::with_pins_at_rest(face);
    let face = at_rest.as_ref().unwrap_or(face);
    let mut shell = shell(face, progress)?;
    let pins = shell.pinned.iter().filter(|pinned| **pinned).count();
    let (mut report, mut left_out) = (
        SolveReport {
            points: face.neutral.positions.len(),
            misplaced: misplaced.unwrap_or_default(),
            noise: shell.noise.clone(),
            pins,
            ..SolveReport::default()
        },
        None,
    );
    let details = match face.settings.method {
        Method::Chapter => chapter(face, &mut shell, progress)?,
        Method::Learned(settings) => {
            let steps = learned::learn(&mut shell, face, settings, progress)?;
            report.candidates.push(steps.chosen);
            let is_other = |other: &&Candidate| {
                (other.share, other.ridge, other.reach)
                    != (steps.chosen.share, steps.chosen.ridge, steps.chosen.reach)
            };
            report.candidates.extend(steps.candidates.iter().filter(is_other));
            report.prior = face
                .prior
                .as_ref()
                .map(|prior| TakenPrior { expressions: prior.expressions.len(), weight: steps.chosen.prior });
            report.parts.clone_from(&steps.parts);
            report.kept.clone_from(&steps.fade.of_handles);
            if leave_one_out {
                let vertices: Vec<VertexId> = (0..shell.basis.height()).map(VertexId::from_index).collect();
                let errors = steps.leave_one_out(&vertices)?;
                left_out = Some(LeaveOneOut {
                    errors,
                    of_shell: steps.residual_of_shell(),
                    skin_area: learned::skin_area(&shell),
                });
            }
            let mut contact = Contact::default();
            if face.settings.contact.eyes {
                progress.step("eyeballs", 0, 1)?;
                (contact, report.eyeballs) = contact::recognise(&shell, face, &report.parts);
                progress.step("eyeballs", 1, 1)?;
            }
            if face.settings.contact.openings {
                contact.openings = openings::recognise(&shell, face, &report.parts, progress)?;
            }
            steps.finish(&settings, &shell.handles, contact)
        }
    };
    if let Some(v) = not_finite(&shell.basis, &details.fine_scale.rbf_weights) {
        return Err(Error::not_solvable(format!(
            "the solve gives no finite result at vertex {}: coordinates or triangles there are beyond float64; \
             run the doctor and mend what it names",
            name(v)
        )));
    }
    let examples = Examples {
        names: face.examples.iter().map(|e| e.name.clone()).collect(),
        handles: Table::new(
            face.examples.len(),
            shell.handles.len(),
            face.examples.iter().flat_map(|e| shell.handles.at(&e.positions)).collect(),
        ),
    };
    let rig = Rig::new(RigParts {
        surface: shell.surface,
        handles: shell.handles,
        examples,
        bending_length: shell.bending_length,
        basis: shell.basis,
        influences: details.influences,
        fine_scale: details.fine_scale,
        learned: details.learned,
    })?;
    Ok(Solved { rig, report, left_out })
}

/// The shell, from which both methods start.
#[doc(hidden)]
pub struct Shell {
    /// The neutral mesh.
    pub surface: Surface<f64>,
    /// The handles.
    pub handles: HandleSet<f64>,
    /// ℓ in mesh units.
    pub bending_length: f64,
    /// The basis of the thin shell, V×H.
    pub basis: Table<f64>,
    /// The topology of the surface's triangles.
    pub topology: Topology,
    /// The parts of the mesh, and whether each has a handle.
    pub parts: DrivenComponents,
    /// σ_p, P in mesh units: the noise of the examples.
    pub(crate) noise: Vec<f64>,
    /// V: whether a vertex is pinned.
    pub(crate) pinned: Vec<bool>,
    /// The handle nearest to each vertex.
    pub(crate) cells: Vec<Option<geodesic::Cell>>,
    /// The Laplacian of the rest pose.
    pub(crate) laplacian: laplacian::Laplacian,
}

/// The parts of a rig that a method adds to the shell.
struct Details {
    influences: Influences<f64>,
    fine_scale: FineScale<f64>,
    learned: Option<Learned<f64>>,
}

/// Solves the thin shell of a face in which the doctor finds no error.
///
/// # Errors
/// [`Error::Input`] if the system cannot be factorised; [`Error::Cancelled`].
#[doc(hidden)]
pub fn shell(face: &Face, progress: &dyn Progress) -> Result<Shell> {
    progress.step("strain edges", 0, 1)?;
    let rest = &face.neutral.positions;
    let triangles = triangulate(&face.neutral);
    let topology = Topology::new(rest.len(), &triangles);
    let points = &face.handles.points;
    let parts = DrivenComponents::new(rest, &triangles, points);
    let graph = geodesic::EdgeGraph::new(rest, &topology);
    let cells = geodesic::nearest_handles(&graph, points);
    let strain_edges = match &face.settings.strain_edges {
        StrainEdges::Given(edges) => edges.clone(),
        StrainEdges::Auto => {
            let of_handle: Vec<Option<HandleId>> =
                cells.iter().map(|cell| cell.map(|cell| cell.handle)).collect();
            let mut edges = geodesic::touching_cells(&topology, &of_handle);
            // Two handles at one place (lips that touch) have no strain between them.
            let at = |h: HandleId| points[h.index()].at(rest);
            edges.retain(|&[a, b]| at(a) != at(b));
            // Rigs of the chapter's method keep all edges.
            if matches!(face.settings.method, Method::Learned(_)) {
                geodesic::drop_far_pairs(&graph, &cells, at, &mut edges);
            }
            edges
        }
    };
    let handles = HandleSet {
        labels: face.handles.labels.clone(),
        rest: face.handles.at(rest),
        points: points.clone(),
        strain_edges,
        rotations: face.settings.rotations,
    };
    let rest_lengths = handles.rest_lengths();
    progress.step("strain edges", 1, 1)?;

    let bending_length = match face.settings.bending_length {
        Some(length) => length,
        None => default_bending_length(&rest_lengths).unwrap_or_else(|| 0.25 * diagonal(face)),
    };
    let laplacian = laplacian::laplacian(rest, &triangles);
    let spacing = default_bending_length(&rest_lengths).unwrap_or(bending_length);
    let noise = noise::of_examples(face, &face.examples, &laplacian);
    let pinned = pins::pins(face, &noise, &cells, spacing);
    let moves: Vec<bool> =
        parts.driven.iter().zip(&pinned).map(|(driven, pinned)| *driven && !pinned).collect();
    let basis = basis::basis(rest, laplacian.clone(), points, &moves, bending_length, progress)?;
    progress.step("frames", 0, 1)?;
    let tangent_neighbors = tangent_frames::tangent_neighbors(rest, &triangles, &topology);
    progress.step("frames", 1, 1)?;
    let surface = Surface {
        name: face.name.clone(),
        metres_per_unit: face.metres_per_unit,
        up_axis: face.up_axis,
        faces: face.neutral.faces.clone(),
        uvs: face.neutral.uvs.clone(),
        materials: face.neutral.materials.clone(),
        triangles,
        rest: rest.clone(),
        tangent_neighbors,
        joined: None,
    };
    Ok(Shell { surface, handles, bending_length, basis, topology, parts, noise, pinned, cells, laplacian })
}

/// Sections 4, 6 and 7: the chapter's method from the shell on.
fn chapter(face: &Face, shell: &mut Shell, progress: &dyn Progress) -> Result<Details> {
    let Shell { surface, handles, basis, parts, pinned, .. } = shell;
    let binds = face.settings.bind == Bind::Nearest;
    if binds {
        progress.step("bind", 0, 1)?;
        let follows = |v: usize| !parts.driven[v] && !pinned[v];
        bind::bind_nearest(&surface.rest, &surface.triangles, &parts.driven, follows, basis);
        progress.step("bind", 1, 1)?;
    }

    progress.step("influences", 0, 1)?;
    let influences = influences::influences(
        &surface.rest,
        &handles.rest,
        &handles.strain_edges,
        &handles.rest_lengths(),
        face.settings.max_influences,
    );
    progress.step("influences", 1, 1)?;

    let pose_features = detail::pose_features(handles, &face.examples);
    let moves = |v: usize| shell.parts.driven[v] || binds;
    let detail = detail::detail(shell, &face.examples, moves, |_, _| (), progress)?;
    let rbf_weights = rbf::rbf_weights(&pose_features, &influences, &detail, progress)?;
    Ok(Details { influences, fine_scale: FineScale { pose_features, rbf_weights }, learned: None })
}

/// The length of the neutral's bounding-box diagonal.
fn diagonal(face: &Face) -> f64 {
    let [low, high] = face.neutral.bounds().unwrap_or_default();
    (0..3).map(|c| (high[c] - low[c]).powi(2)).sum::<f64>().sqrt()
}

/// The first vertex with a number that is not finite.
fn not_finite(basis: &Table<f64>, weights: &Table<[f64; 3]>) -> Option<usize> {
    let in_basis = basis.rows().position(|row| row.iter().any(|b| !b.is_finite()));
    let in_weights = || weights.rows().position(|row| row.as_flattened().iter().any(|w| !w.is_finite()));
    in_basis.or_else(in_weights)
}
