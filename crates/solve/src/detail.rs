//! Section 6: what the large scale leaves of the examples.
use glam::DVec3;
use pulp::Arch;
use rayon::prelude::*;
use rhytid_core::{Example, Progress, Result, Rig};
use rhytid_geometry::Topology;
use rhytid_kernels::{fine_scale, large_scale, normals, strain, vec3};

/// Vertices that one thread moves at a time.
const VERTICES_AT_ONCE: usize = 4096;

/// The features of the centres, N×F, the rest pose first.
pub(crate) fn pose_features(rig: &Rig<f64>, examples: &[Example]) -> Vec<f64> {
    let edges = rig.strain_edges.len();
    let (rest_lengths, handle_rest) = (rig.rest_lengths(), at_handles(rig, &rig.rest));
    let mut features = vec![0.0; (examples.len() + 1) * edges];
    for (j, example) in examples.iter().enumerate() {
        strain::strain(
            strain::Params { frames: 1, handles: rig.handles.len() as u32, strain_edges: edges as u32 },
            &at_handles(rig, &example.positions),
            &handle_rest,
            &rig.strain_edges,
            &rest_lengths,
            &mut features[(j + 1) * edges..][..edges],
        );
    }
    features
}

/// The detail of the examples, P×V×3 in mesh units, components along t, b, n of the tangent frames on the large scale.
///
/// `rig` needs everything up to its basis. The detail is zero where `moves` says that a vertex does not. `add` is given
/// the positions of the handles in an example, and adds to the V×3 positions that the basis gives what else the large scale
/// has.
///
/// # Errors
/// [`rhytid_core::Error::Cancelled`].
pub(crate) fn detail(
    rig: &Rig<f64>,
    topology: &Topology,
    examples: &[Example],
    moves: impl Fn(usize) -> bool + Sync,
    add: impl Fn(&[[f64; 3]], &mut [[f64; 3]]),
    progress: &dyn Progress,
) -> Result<Vec<[f64; 3]>> {
    let vertices = rig.vertices();
    let mut detail = vec![[0.0; 3]; examples.len() * vertices];
    for (j, example) in examples.iter().enumerate() {
        progress.step("detail", j as u64, examples.len() as u64)?;
        let handle_positions = at_handles(rig, &example.positions);
        let mut smooth = smooth(rig, &handle_positions);
        add(&handle_positions, &mut smooth);
        detail[j * vertices..][..vertices].par_iter_mut().enumerate().filter(|(v, _)| moves(*v)).for_each(
            |(v, d)| {
                let left = vec3::sub(example.positions[v], smooth[v]);
                let n = normals::vertex_normal(&smooth, &rig.triangles, topology.vertex_triangles.at(v));
                let to_neighbor = vec3::sub(smooth[rig.tangent_neighbors[v] as usize], smooth[v]);
                let frame = fine_scale::tangent_frame(to_neighbor, n);
                *d = frame.map(|axis| DVec3::from_array(axis).dot(DVec3::from_array(left)));
            },
        );
    }
    progress.step("detail", examples.len() as u64, examples.len() as u64)?;
    Ok(detail)
}

/// Where the handles are among V positions.
pub(crate) fn at_handles(rig: &Rig<f64>, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    rig.handles.iter().map(|&v| positions[v as usize]).collect()
}

/// The positions of all vertices that the basis gives.
pub(crate) fn smooth(rig: &Rig<f64>, handle_positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let handles = rig.handles.len();
    let mut smooth = vec![[0.0; 3]; rig.vertices()];
    let vectors = Arch::new();
    let (motions, center) = rig.motions(handle_positions);
    let parts = smooth.par_chunks_mut(VERTICES_AT_ONCE).zip(rig.rest.par_chunks(VERTICES_AT_ONCE));
    parts.zip(rig.basis.par_chunks(VERTICES_AT_ONCE * handles)).for_each(|((smooth, rest), basis)| {
        // The part's vertices, and behind them the centre.
        let with_center: Vec<_> = rest.iter().chain(center.map(|v| &rig.rest[v as usize])).copied().collect();
        let params = large_scale::Params::whole(1, rest.len(), handles, false);
        let params = params.turning(center.map(|_| rest.len() as u32));
        vectors.dispatch(
            #[inline(always)]
            || large_scale::large_scale(params, &with_center, basis, &motions, &[], smooth),
        );
    });
    smooth
}
