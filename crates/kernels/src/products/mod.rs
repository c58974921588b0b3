#![doc = include_str!("README.md")]
use crate::differences::{CENTERS_AT_ONCE, table_index, table_len};
use crate::params::parameter_block;
use crate::{Real, vec3};

parameter_block!(
    /// Frames in the batch.
    frames,
    /// H.
    handles,
    /// F.
    strain_edges,
    /// P.
    examples,
);

/// The twin. `displacements` is frames × H, `feature_bounds` 2 × (F + H).
pub fn products<T: Real>(
    params: Params,
    displacements: &[[T; 3]],
    strain_edges: &[[u32; 2]],
    example_vectors: &[[T; 3]],
    feature_bounds: &[[T; 3]],
    strain_products: &mut [T],
) {
    let (handles, examples) = (params.handles as usize, params.examples as usize);
    let edges = params.strain_edges as usize;
    let features = edges + handles;
    let len = table_len(features, examples);
    for frame in 0..params.frames as usize {
        let u = &displacements[frame * handles..][..handles];
        let table = &mut strain_products[frame * len..][..len];
        for e in 0..features {
            let moved = match strain_edges[..edges].get(e) {
                Some(&[a, b]) => vec3::sub(u[b as usize], u[a as usize]),
                None => u[e - edges],
            };
            let (least, most) = (feature_bounds[e], feature_bounds[features + e]);
            let moved: [T; 3] = std::array::from_fn(|c| match moved[c] {
                x if x < least[c] => least[c],
                x if x > most[c] => most[c],
                x => x,
            });
            for p in 0..examples.next_multiple_of(CENTERS_AT_ONCE) {
                table[table_index(features, e, p)] =
                    if p < examples { vec3::dot(moved, example_vectors[p * features + e]) } else { T::ZERO };
            }
        }
    }
}
