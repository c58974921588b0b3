//! Runs a dispatch with the f32 twins. A backend for a GPU has the kernels' sources instead of this file.
use half::f16;
use rhytid_core::plan::Dispatch;
use rhytid_kernels::normals::VertexTriangles;
use rhytid_kernels::table::{TILE, WORKGROUP_SIZE};
use rhytid_kernels::{detail, fine_scale, large_scale, normals, strain};

/// Runs one dispatch: buffers are bound in the order of the kernel's table, the last is the one that it writes.
pub fn run(dispatch: &Dispatch, buffers: &mut [Vec<u32>]) {
    let [x, y] = dispatch.workgroups;
    let invocations = x * WORKGROUP_SIZE;
    let (written, read) = dispatch.buffers.split_last().expect("every kernel writes");
    let mut out = std::mem::take(&mut buffers[*written]);
    let words = |i: usize| buffers[read[i]].as_slice();
    let numbers = |i: usize| bytemuck::cast_slice::<u32, f32>(words(i));
    let vectors = |i: usize| numbers(i).as_chunks::<3>().0;
    let results: &mut [f32] = bytemuck::cast_slice_mut(&mut out);
    match dispatch.kernel.name {
        "strain" => {
            let mut params: strain::Params = parameters(dispatch);
            params.frames = params.frames.min(y);
            let edges = params.strain_edges as usize;
            let mut all = vec![0.0; params.frames as usize * edges];
            strain::strain(params, vectors(0), vectors(1), words(2).as_chunks().0, numbers(3), &mut all);
            let computed = edges.min(invocations as usize);
            for (frame, f) in all.chunks_exact(edges).enumerate() {
                results[frame * edges..][..computed].copy_from_slice(&f[..computed]);
            }
        }
        "large_scale" => {
            let mut params: large_scale::Params = parameters(dispatch);
            let (vertices, handles) = (params.part_vertices as usize, params.handles as usize);
            let basis = match params.half_basis {
                0 => untiled(numbers(1), handles, vertices),
                _ => {
                    let halves: &[u16] = bytemuck::cast_slice(words(1));
                    let halves = untiled(halves, handles, vertices);
                    halves.into_iter().map(|bits| f16::from_bits(bits).to_f32()).collect()
                }
            };
            params.frames = params.frames.min(y);
            params.part_vertices = params.part_vertices.min(invocations);
            let positions = results.as_chunks_mut().0;
            large_scale::large_scale(params, vectors(0), &basis, vectors(2), vectors(3), positions);
        }
        "normals" => {
            let mut params: normals::Params = parameters(dispatch);
            params.frames = params.frames.min(y);
            params.part_vertices = params.part_vertices.min(invocations);
            let vertex_triangles =
                VertexTriangles { offsets: words(2).to_vec(), triangles: words(3).to_vec() };
            let triangles = words(1).as_chunks().0;
            let vertex_normals = results.as_chunks_mut().0;
            normals::normals(params, vectors(0), triangles, &vertex_triangles, vertex_normals);
        }
        "detail" => {
            let mut params: detail::Params = parameters(dispatch);
            let (vertices, k) = (params.part_vertices as usize, params.influences as usize);
            let weights = untiled(numbers(4), 3 * params.centers as usize, vertices);
            let buffers = detail::Buffers {
                influence_edges: &untiled(words(1), k, vertices),
                influence_weights: &untiled(numbers(2), k, vertices),
                pose_features: numbers(3),
                rbf_weights: weights.as_chunks().0,
                pivots: &untiled(words(5), 1, vertices),
            };
            params.frames = params.frames.min(y);
            params.part_vertices = params.part_vertices.min(invocations);
            detail::detail(params, numbers(0), &buffers, results.as_chunks_mut().0);
        }
        "fine_scale" => {
            let mut params: fine_scale::Params = parameters(dispatch);
            params.frames = params.frames.min(y);
            params.part_vertices = params.part_vertices.min(invocations);
            let positions = results.as_chunks_mut().0;
            fine_scale::fine_scale(params, vectors(0), vectors(1), vectors(2), words(3), positions);
        }
        name => unreachable!("there is no kernel {name}"),
    }
    buffers[*written] = out;
}

fn parameters<T: bytemuck::AnyBitPattern>(dispatch: &Dispatch) -> T {
    bytemuck::pod_read_unaligned(bytemuck::cast_slice(&dispatch.params))
}

/// From `[⌈V/64⌉][n][64]` to n numbers for each vertex, as the twins have them.
fn untiled<T: Copy>(tiled: &[T], n: usize, vertices: usize) -> Vec<T> {
    let at = |v: usize, i: usize| tiled[(v / TILE * n + i) * TILE + v % TILE];
    (0..vertices).flat_map(|v| (0..n).map(move |i| at(v, i))).collect()
}
