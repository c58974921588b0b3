//! Runs a dispatch with the f32 references. A backend for a GPU has the kernels' sources instead.
use half::f16;
use rhytid_core::plan::Dispatch;
use rhytid_kernels::table::{Access, Kernel, WORKGROUP_SIZE};
use rhytid_kernels::tile::TILE;
use rhytid_kernels::{
    bands, beyond, clusters, detail, differences, fine_scale, large_scale, normals, strain,
    vector_differences,
};
use std::ops::Range;

/// Runs one dispatch. Buffers are bound in the order of the kernel's table; the kernel writes the last ones.
pub(super) fn run(dispatch: &Dispatch, buffers: &mut [Vec<u32>]) {
    let [x, y] = dispatch.workgroups;
    let invocations = x * WORKGROUP_SIZE * dispatch.kernel.entry().at_once;
    let frames = y * dispatch.frames_at_once;
    let reads = dispatch.kernel.entry().bindings.iter().take_while(|binding| binding.access == Access::Read);
    let (read, written) = dispatch.buffers.split_at(reads.count());
    let mut outs: Vec<Vec<u32>> =
        written.iter().map(|&buffer| std::mem::take(&mut buffers[buffer])).collect();
    let words = |i: usize| buffers[read[i]].as_slice();
    let numbers = |i: usize| bytemuck::cast_slice::<u32, f32>(words(i));
    let vectors = |i: usize| numbers(i).as_chunks::<3>().0;
    let (out, others) = outs.split_first_mut().expect("every kernel writes");
    let results: &mut [f32] = bytemuck::cast_slice_mut(out);
    match dispatch.kernel {
        Kernel::Strain => {
            let mut params: strain::Params = parameters(dispatch);
            params.frames = params.frames.min(frames);
            let edges = params.strain_edges as usize;
            let mut all = vec![0.0; params.frames as usize * edges];
            strain::strain(params, vectors(0), vectors(1), words(2).as_chunks().0, numbers(3), &mut all);
            let computed = edges.min(invocations as usize);
            for (frame, f) in all.chunks_exact(edges).enumerate() {
                results[frame * edges..][..computed].copy_from_slice(&f[..computed]);
            }
        }
        Kernel::LargeScale => {
            let mut params: large_scale::Params = parameters(dispatch);
            // The vectors of a frame in which the handles turn are summed like four frames.
            params.frames = params.frames.min(frames / params.vectors() as u32);
            let end = params.part_vertices.min(invocations) as usize;
            let positions = results.as_chunks_mut().0;
            let motions: Vec<[f32; 3]> =
                numbers(3).as_chunks::<4>().0.iter().map(|&[x, y, z, _]| [x, y, z]).collect();
            let all_motions = params.motions as usize;
            // The reference has one cluster. A tile by itself is within one.
            for (tile, rows) in words(2).windows(3).step_by(2).enumerate() {
                let rows_here = rows[0] as usize..rows[2] as usize;
                let first = tile * TILE;
                let vertices = TILE.min(end.saturating_sub(first));
                let at = rows_here.start * TILE..rows_here.end * TILE;
                let basis: Vec<f32> = match params.basis_format {
                    0 => numbers(1)[at].to_vec(),
                    1 => bytemuck::cast_slice::<u32, u16>(words(1))[at]
                        .iter()
                        .map(|&bits| f16::from_bits(bits).to_f32())
                        .collect(),
                    _ => {
                        bytemuck::cast_slice::<u32, i16>(words(1))[at].iter().map(|&c| f32::from(c)).collect()
                    }
                };
                let frames = motions.chunks_exact(all_motions);
                let of_cluster: Vec<[f32; 3]> =
                    frames.flat_map(|frame| &frame[rows[1] as usize..][..rows_here.len()]).copied().collect();
                let of_tile = large_scale::Params {
                    first_vertex: params.first_vertex + first as u32,
                    part_vertices: vertices as u32,
                    motions: rows_here.len() as u32,
                    ..params
                };
                let basis = untiled(&basis, rows_here.len(), vertices);
                large_scale::large_scale(of_tile, vectors(0), &basis, &of_cluster, vectors(4), positions);
            }
        }
        Kernel::Clusters => {
            let mut params: clusters::Params = parameters(dispatch);
            params.frames = params.frames.min(frames);
            let rows = params.cluster_rows as usize;
            let displacements: Vec<[f32; 3]> =
                numbers(1).as_chunks::<4>().0.iter().map(|&[x, y, z, _]| [x, y, z]).collect();
            let mut all = vec![[0.0; 3]; params.frames as usize * rows];
            let factors = &numbers(0)[..params.handles as usize * rows];
            clusters::clusters(params, factors, &displacements, &mut all);
            for (i, &[x, y, z]) in all.iter().enumerate() {
                if i % rows < invocations as usize {
                    results[4 * i..][..4].copy_from_slice(&[x, y, z, 0.0]);
                }
            }
        }
        Kernel::VectorDifferences => {
            let mut params: vector_differences::Params = parameters(dispatch);
            params.frames = params.frames.min(frames);
            let displacements: Vec<[f32; 3]> =
                numbers(0).as_chunks::<4>().0.iter().map(|&[x, y, z, _]| [x, y, z]).collect();
            let features = (params.strain_edges + params.handles) as usize;
            let len = differences::table_len(features, params.centers as usize);
            let mut all = vec![0.0; params.frames as usize * len];
            let buffers = vector_differences::Buffers {
                strain_edges: &words(1).as_chunks().0[..params.strain_edges as usize],
                feature_lengths: &numbers(2)[..features],
                example_vectors: vectors(3),
                feature_limits: &numbers(4)[..features],
            };
            vector_differences::vector_differences(params, &displacements, &buffers, &mut all);
            for (i, cells) in all.chunks_exact(8).enumerate() {
                if i % features < invocations as usize {
                    results[8 * i..][..8].copy_from_slice(cells);
                }
            }
        }
        Kernel::Bands => {
            let mut params: bands::Params = parameters(dispatch);
            let offsets = words(1);
            params.frames = params.frames.min(frames);
            let band_offsets = results.as_chunks_mut::<3>().0;
            let details: &mut [f32] = bytemuck::cast_slice_mut(&mut others[0]);
            let details = details.as_chunks_mut::<3>().0;
            for i in 0..params.part_vertices.min(invocations) as usize {
                // The reference uses each vertex's influences and anchors. Here they are those of its tile.
                let at = |list: usize| offsets[i / TILE * 2 + list] as usize;
                let (edges, anchors) = (at(0)..at(1), at(1)..at(2));
                let of_vertex = |rows: &Range<usize>| -> Vec<f32> {
                    let at = rows.clone().map(|row| TILE * row + i % TILE);
                    at.map(|at| influence_weight(params, words(3), at)).collect()
                };
                let buffers = bands::Buffers {
                    influences: edges.len(),
                    influence_edges: &words(2)[edges.clone()],
                    influence_weights: &of_vertex(&edges),
                    anchors_per_vertex: anchors.len(),
                    // Their indices already start at F.
                    anchors: &words(2)[anchors.clone()],
                    anchor_weights: &of_vertex(&anchors),
                    band_weights: &band_weights(params, words(4), i),
                };
                for frame in 0..params.frames as usize {
                    let len = differences::table_len(params.features as usize, params.centers as usize);
                    let table = &numbers(0)[frame * len..];
                    let v = frame * params.vertices as usize + params.first_vertex as usize + i;
                    let [offset, detail] = bands::vertex_bands(params, &buffers, 0, table, 0);
                    band_offsets[v] = offset;
                    if params.wrinkles != 0 {
                        details[v] = detail;
                    }
                }
            }
        }
        Kernel::Beyond => {
            let mut params: beyond::Params = parameters(dispatch);
            params.frames = params.frames.min(frames);
            let (offsets, gains) = (words(1), numbers(3).as_chunks::<TILE>().0);
            let features = params.features as usize;
            let excess: Vec<[f32; 3]> = numbers(0).as_chunks::<4>().0[..params.frames as usize * features]
                .iter()
                .map(|&[x, y, z, _]| [x, y, z])
                .collect();
            for i in 0..params.part_vertices.min(invocations) {
                let tile = i as usize / TILE;
                let rows = offsets[2 * tile] as usize..offsets[2 * tile + 2] as usize;
                let of_vertex: Vec<f32> =
                    gains[rows.clone()].iter().map(|row| row[i as usize % TILE]).collect();
                let buffers =
                    beyond::Buffers { influences: rows.len(), features: &words(2)[rows], gains: &of_vertex };
                let first_vertex = params.first_vertex + i;
                let params = beyond::Params { first_vertex, part_vertices: 1, ..params };
                beyond::beyond(params, &excess, &buffers, results.as_chunks_mut().0);
            }
        }
        Kernel::Normals => {
            let mut params: normals::Params = parameters(dispatch);
            params.frames = params.frames.min(frames);
            params.part_vertices = params.part_vertices.min(invocations);
            let (offsets, fans) = (words(1), words(2).as_chunks::<TILE>().0);
            let vertex_normals = results.as_chunks_mut().0;
            for i in 0..params.part_vertices as usize {
                let v = params.first_vertex + i as u32;
                let at = offsets[i / TILE] as usize..offsets[i / TILE + 1] as usize;
                let at = at.start.min(fans.len())..at.end.min(fans.len());
                let fan: Vec<u32> = fans[at].iter().map(|row| row[i % TILE]).collect();
                let triangles: Vec<_> = fan.array_windows().map(|&[a, b]| [v, a, b]).collect();
                let all: Vec<u32> = (0..triangles.len() as u32).collect();
                for frame in 0..params.frames as usize {
                    let first = frame * params.vertices as usize;
                    let positions = &vectors(0)[first..];
                    vertex_normals[first + v as usize] = normals::vertex_normal(positions, &triangles, &all);
                }
            }
        }
        Kernel::Differences => {
            let mut params: differences::Params = parameters(dispatch);
            params.frames = params.frames.min(frames);
            params.strain_edges = params.strain_edges.min(invocations);
            differences::differences(params, numbers(0), numbers(1), results);
        }
        Kernel::Detail => {
            let mut params: detail::Params = parameters(dispatch);
            let (vertices, n) = (params.part_vertices as usize, params.centers as usize);
            let weights = untiled(numbers(4), 3 * n, vertices);
            let weights = weights.as_chunks().0;
            let (offsets, alphas) = (words(1), numbers(3).as_chunks::<TILE>().0);
            params.frames = params.frames.min(frames);
            let local_detail = results.as_chunks_mut().0;
            for i in 0..params.part_vertices.min(invocations) as usize {
                // The reference uses each vertex's influences. Here they are those of its tile.
                let at = offsets[i / TILE * 2] as usize..offsets[i / TILE * 2 + 1] as usize;
                let buffers = detail::Buffers {
                    influences: at.len(),
                    influence_edges: &words(2)[at.clone()],
                    influence_weights: &alphas[at].iter().map(|row| row[i % TILE]).collect::<Vec<f32>>(),
                    rbf_weights: &weights[i * n..][..n],
                    pivots: &words(5)[i..=i],
                };
                for frame in 0..params.frames as usize {
                    let len = differences::table_len(params.strain_edges as usize, n);
                    let table = &numbers(0)[frame * len..];
                    let v = frame * params.vertices as usize + params.first_vertex as usize + i;
                    local_detail[v] = detail::vertex_detail(params, &buffers, table, 0);
                }
            }
        }
        Kernel::FineScale => {
            let mut params: fine_scale::Params = parameters(dispatch);
            params.frames = params.frames.min(frames);
            params.part_vertices = params.part_vertices.min(invocations);
            let positions = results.as_chunks_mut().0;
            fine_scale::fine_scale(params, vectors(0), vectors(1), vectors(2), words(3), positions);
        }
    }
    for (&buffer, out) in written.iter().zip(outs) {
        buffers[buffer] = out;
    }
}

fn parameters<T: bytemuck::AnyBitPattern>(dispatch: &Dispatch) -> T {
    bytemuck::pod_read_unaligned(bytemuck::cast_slice(&dispatch.params))
}

/// A weight of an influence, as the kernel `bands` reads it.
fn influence_weight(params: bands::Params, words: &[u32], at: usize) -> f32 {
    match params.narrow {
        0 => f32::from_bits(words[at]),
        _ => bands::weight_of_bits(bytemuck::cast_slice::<u32, u16>(words)[at]),
    }
}

/// The weights of vertex `i`, as the kernel `bands` reads them.
fn band_weights(params: bands::Params, words: &[u32], i: usize) -> Vec<[f32; 3]> {
    let (record, lane) = (words[i / TILE] as usize, i % TILE);
    let vectors = params.kinds() * params.centers as usize;
    let (first, is_narrow) = (record & !1, record & 1 == 1);
    let single = |j: usize| [0, 1, 2].map(|axis| f32::from_bits(words[first + 48 * j + TILE * axis + lane]));
    if !is_narrow {
        return (0..vectors).map(single).collect();
    }
    let units = first + 48 * params.kinds();
    let rows = units + (vectors - params.kinds()).next_multiple_of(TILE);
    let integers = bytemuck::cast_slice::<u32, i16>(&words[rows..]);
    let integer = |j: usize| {
        let unit = f32::from_bits(words[units + j]);
        [0, 1, 2].map(|axis| unit * f32::from(integers[48 * j + TILE * axis + lane]))
    };
    (0..params.kinds()).map(single).chain((0..vectors - params.kinds()).map(integer)).collect()
}

/// From `[⌈V/16⌉][n][16]` to n numbers for each vertex, as the references use them.
fn untiled<T: Copy>(tiled: &[T], n: usize, vertices: usize) -> Vec<T> {
    let at = |v: usize, i: usize| tiled[(v / TILE * n + i) * TILE + v % TILE];
    (0..vertices).flat_map(|v| (0..n).map(move |i| at(v, i))).collect()
}
