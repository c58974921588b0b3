//! From scans to a [`Rig`]: sections 1 to 7 of the method (`docs/method.md`), one step a file, all in float64.
pub mod basis;
pub mod bind;
pub mod cholesky;
pub mod detail;
pub mod dissection;
pub mod driven;
pub mod frames;
pub mod geodesic;
pub mod influences;
pub mod laplacian;
pub mod rbf;
pub mod sparse;
pub mod system;

use crate::doctor;
use crate::progress::step;
use crate::{Bind, Error, Face, Progress, Result, Rig, StrainEdges, Topology};
use driven::DrivenComponents;
use rhytid_kernels::strain;

/// ℓ where the user gives none: the mean rest length of the strain edges, which join neighbouring handles.
///
/// ℓ is the distance over which bending resists: far below the handles' spacing the surface is pulled to a tip
/// at every marker, far above it nothing changes any more. `None` without a strain edge.
pub fn default_bending_length(rest_lengths: &[f64]) -> Option<f64> {
    let mean = rest_lengths.iter().sum::<f64>() / rest_lengths.len() as f64;
    (mean > 0.0).then_some(mean)
}

/// Solves `face`: everything a device needs to animate it from handle positions.
///
/// Takes seconds (530,000 vertices on two cores: under ten); reports to `progress` and stops when that says so.
///
/// # Errors
/// [`Error::Input`] with the first error that [`crate::examine`] finds, or if the system cannot be factorised;
/// [`Error::Cancelled`].
pub fn solve(face: &Face, progress: &dyn Progress) -> Result<Rig<f64>> {
    doctor::check(face)?;
    step(progress, "strain edges", 0, 1)?;
    let rest = &face.neutral.positions;
    let triangles = face.neutral.triangles();
    let topology = Topology::new(rest.len(), &triangles);
    let handles = &face.handles.vertices;
    let DrivenComponents { driven, .. } = DrivenComponents::new(rest, &triangles, handles);
    let strain_edges = match &face.settings.strain_edges {
        StrainEdges::Given(edges) => edges.clone(),
        StrainEdges::Auto => {
            let cells = geodesic::voronoi_cells(rest, &topology, handles);
            let mut edges = geodesic::touching_cells(&topology, &cells);
            // Two handles at one place (lips that touch) have no strain between them.
            let at = |h: u32| rest[handles[h as usize] as usize];
            edges.retain(|&[a, b]| at(a) != at(b));
            edges
        }
    };
    let rest_lengths = strain::rest_lengths(rest, handles, &strain_edges);
    step(progress, "strain edges", 1, 1)?;

    let bending_length = match face.settings.bending_length {
        Some(length) => length,
        None => default_bending_length(&rest_lengths).unwrap_or_else(|| 0.25 * diagonal(face)),
    };
    let mut basis = basis::basis(rest, &triangles, handles, &driven, bending_length, progress)?;
    if face.settings.bind == Bind::Nearest {
        step(progress, "bind", 0, 1)?;
        bind::bind_nearest(rest, &triangles, &driven, handles.len(), &mut basis)?;
        step(progress, "bind", 1, 1)?;
    }

    step(progress, "influences", 0, 1)?;
    let handle_rest: Vec<[f64; 3]> = handles.iter().map(|&v| rest[v as usize]).collect();
    let influences = influences::influences(
        rest,
        &handle_rest,
        &strain_edges,
        &rest_lengths,
        face.settings.max_influences,
    );
    step(progress, "influences", 1, 1)?;

    step(progress, "frames", 0, 1)?;
    let tangent_neighbors = frames::tangent_neighbors(rest, &triangles, &topology);
    step(progress, "frames", 1, 1)?;
    let mut rig = Rig {
        name: face.name.clone(),
        metres_per_unit: face.metres_per_unit,
        up_axis: face.up_axis,
        labels: face.handles.labels.clone(),
        example_names: face.examples.iter().map(|e| e.name.clone()).collect(),
        faces: face.neutral.faces.clone(),
        uvs: face.neutral.uvs.clone(),
        materials: face.neutral.materials.clone(),
        bending_length,
        beta: influences.beta,
        handles: handles.clone(),
        tangent_neighbors,
        triangles,
        rest: rest.clone(),
        basis,
        strain_edges,
        influence_edges: influences.edges,
        influence_weights: influences.weights,
        pose_features: Vec::new(),
        rbf_weights: Vec::new(),
        example_handles: face
            .examples
            .iter()
            .flat_map(|e| handles.iter().map(|&v| e.positions[v as usize]))
            .collect(),
    };

    let moves = |v: usize| driven[v] || face.settings.bind == Bind::Nearest;
    let (pose_features, detail) =
        detail::features_and_detail(&rig, &rest_lengths, &topology, &face.examples, moves, progress)?;
    rig.pose_features = pose_features;
    rig.rbf_weights = rbf::rbf_weights(
        &rig.pose_features,
        rig.centers(),
        (&rig.influence_edges, &rig.influence_weights),
        &detail,
        rig.vertices(),
        progress,
    )?;
    if let Some(v) = not_finite(&rig) {
        return Err(Error::input(format!(
            "the solve gives no finite result at vertex {v}: coordinates or triangles there are beyond float64; \
             run the doctor and mend what it names"
        )));
    }
    Ok(rig)
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
