//! Tiles: neighbouring vertices whose numbers are stored together.

/// Vertices in a *tile*: neighbouring ones, from a multiple of 16 on. A *row* is a number for each of them.
/// An array of n numbers per vertex that is *tiled* is stored as `[⌈V/16⌉][n][16]`. Each tile has n rows, and
/// the numbers past V are zero. Neighbouring invocations then read neighbouring words, at least 32 bytes of
/// them. A processor behind a GPU's API computes one tile after the other, and so reads memory from its start
/// to its end.
pub const TILE: usize = 16;

/// The influences of a tile's vertices, at most 16 with K each. They are the strain edges that drive any of
/// the vertices, ascending, and α of each edge for all of the vertices. Where an edge does not drive a
/// vertex, α is zero, which changes no sum.
///
/// Nearly the same edges drive vertices that lie side by side. So a tile has not many more edges than each
/// vertex.
pub fn tile_influences(k: usize, edges: &[u32], weights: &[f32]) -> (Vec<u32>, Vec<[f32; TILE]>) {
    let all = || edges.iter().zip(weights).enumerate().filter(|(_, (_, alpha))| **alpha != 0.0);
    let mut list: Vec<u32> = all().map(|(_, (&e, _))| e).collect();
    list.sort_unstable();
    list.dedup();
    let mut of_vertices = vec![[0.0; TILE]; list.len()];
    for (i, (&e, &alpha)) in all() {
        of_vertices[list.partition_point(|&other| other < e)][i / k] = alpha;
    }
    (list, of_vertices)
}
