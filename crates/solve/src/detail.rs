//! Section 6: the detail, which is the residual of the examples after the large scale.
use crate::Shell;
use crate::vectors::widest;
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{Example, HandleSet, Progress, Result, Table};
use rhytid_kernels::{fine_scale, large_scale, normals, vec3};

/// The number of vertices that one thread moves at a time.
const VERTICES_AT_ONCE: usize = 4096;

/// The features of the centres, N×F, the rest pose first.
pub(crate) fn pose_features(handles: &HandleSet<f64>, examples: &[Example]) -> Table<f64> {
    let edges = handles.strain_edges.len();
    let of_example = |example: &Example| handles.strains(&handles.at(&example.positions));
    let rest = vec![0.0; edges];
    let features = std::iter::once(rest).chain(examples.iter().map(of_example)).flatten().collect();
    Table::new(examples.len() + 1, edges, features)
}

/// The detail of the examples, P×V in mesh units, as components along t, b, n of the tangent frames of the
/// large scale.
///
/// The detail is zero at vertices for which `moves` is false, and at the corners of a handle's triangle:
/// there, three frames that turn differently would move the handle. `add` gets the handle positions of an
/// example and V×3 positions from the basis. It adds the rest of the large scale to these positions.
///
/// # Errors
/// [`rhytid_core::Error::Cancelled`].
pub(crate) fn detail(
    shell: &Shell,
    examples: &[Example],
    moves: impl Fn(usize) -> bool + Sync,
    add: impl Fn(&[[f64; 3]], &mut [[f64; 3]]),
    progress: &dyn Progress,
) -> Result<Table<[f64; 3]>> {
    let surface = &shell.surface;
    let mut detail = Table::filled(examples.len(), surface.rest.len(), [0.0; 3]);
    let mut is_corner = vec![false; surface.rest.len()];
    shell.handles.held().for_each(|v| is_corner[v.index()] = true);
    for (j, (example, detail)) in examples.iter().zip(detail.rows_mut()).enumerate() {
        progress.step("detail", j as u64, examples.len() as u64)?;
        let handle_positions = shell.handles.at(&example.positions);
        let mut smooth = smooth(shell, &handle_positions);
        add(&handle_positions, &mut smooth);
        detail.par_iter_mut().enumerate().filter(|(v, _)| moves(*v) && !is_corner[*v]).for_each(|(v, d)| {
            let left = vec3::sub(example.positions[v], smooth[v]);
            let triangles = shell.topology.vertex_triangles.at(v);
            let n = normals::vertex_normal(&smooth, &surface.triangles, triangles);
            let to_neighbor = vec3::sub(smooth[surface.tangent_neighbors[v].index()], smooth[v]);
            let frame = fine_scale::tangent_frame(to_neighbor, n);
            *d = frame.map(|axis| DVec3::from_array(axis).dot(DVec3::from_array(left)));
        });
    }
    progress.step("detail", examples.len() as u64, examples.len() as u64)?;
    Ok(detail)
}

/// The positions of all vertices by the basis.
pub(crate) fn smooth(shell: &Shell, handle_positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let all_rest = &shell.surface.rest;
    let mut smooth = vec![[0.0; 3]; all_rest.len()];
    let motions = shell.handles.motions(handle_positions);
    let parts = smooth.par_chunks_mut(VERTICES_AT_ONCE).zip(all_rest.par_chunks(VERTICES_AT_ONCE));
    parts.enumerate().for_each(|(part, (smooth, rest))| {
        let first = part * VERTICES_AT_ONCE;
        let basis = shell.basis.of_rows(first..first + rest.len());
        // The part's vertices, followed by the centre.
        let center = motions.center.map(|v| &all_rest[v.index()]);
        let with_center: Vec<_> = rest.iter().chain(center).copied().collect();
        let params = large_scale::Params::whole(1, rest.len(), shell.handles.len(), false);
        let params = params.turning(center.map(|_| rest.len() as u32));
        widest(
            #[inline(always)]
            || large_scale::large_scale(params, &with_center, basis, &motions.vectors, &[], smooth),
        );
    });
    smooth
}
