//! Tiles: neighbouring vertices whose numbers are stored together.

/// Vertices in a *tile*: neighbouring ones, from a multiple of 16 on. A *row* is a number for each of them. An array of n numbers per
/// vertex that is *tiled* is stored as `[⌈V/16⌉][n][16]`, n rows for each tile, the numbers past V being zero: neighbouring invocations
/// read neighbouring words, at least 32 bytes of them, and a processor behind a GPU's API, which computes one tile after the other,
/// reads memory from its start to its end.
pub const TILE: usize = 16;

/// The influences of a tile's vertices, at most 16 with K each: the strain edges that drive any of them, ascending, and of each edge
/// α for all of them. That is zero where the edge does not drive the vertex, which changes no sum.
///
/// Vertices that lie side by side are driven by nearly the same edges, so that there are not many more of these than each has.
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
