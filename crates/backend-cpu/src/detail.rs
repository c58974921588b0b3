//! The detail: radial basis functions of the strains, from a table of squared differences.
//!
//! `(f_e − f_je)²` depends on frame, strain edge and centre alone. A table of it, with the centres of an edge side by side, makes K × N
//! gathers at each vertex K loads.
use crate::blocks::{BLOCK, blocks};
use crate::simd::widest;
use rayon::prelude::*;
use rhytid_core::Rig;
use rhytid_kernels::detail::pivoted;
use rhytid_kernels::table::TILE;

/// Centres that are summed at once.
const CENTERS: usize = 8;

/// What the kernel reads of a rig.
#[derive(Debug)]
pub struct Detail {
    influences: usize,
    centers: usize,
    /// N × F.
    pose_features: Vec<f32>,
    edges: Edges,
    /// α, V × K.
    weights: Vec<f32>,
    /// w, `[V/64][N][3][64]`, with the pivot's sum in its place.
    rbf_weights: Vec<[[f32; TILE]; 3]>,
    /// The pivot of each vertex; past V, 0.
    pivots: Vec<[u32; TILE]>,
}

/// V × K indices of strain edges, in as many bytes as they need.
#[derive(Debug)]
enum Edges {
    U8(Vec<u8>),
    U32(Vec<u32>),
}

impl Detail {
    pub fn new(rig: &Rig) -> Self {
        let (vertices, centers) = (rig.vertices(), rig.centers());
        let (weights, pivots) = pivoted(&rig.rbf_weights, centers);
        let mut rbf_weights = vec![[[0.0; TILE]; 3]; vertices.div_ceil(TILE) * centers];
        for (i, w) in weights.iter().enumerate() {
            let (v, j) = (i / centers, i % centers);
            for c in 0..3 {
                rbf_weights[v / TILE * centers + j][c][v % TILE] = w[c];
            }
        }
        let mut tiled = vec![[0; TILE]; vertices.div_ceil(TILE)];
        pivots.iter().enumerate().for_each(|(v, &pivot)| tiled[v / TILE][v % TILE] = pivot);
        let edges = &rig.influence_edges;
        Self {
            influences: rig.influences(),
            centers,
            pose_features: rig.pose_features.clone(),
            edges: if rig.strain_edges.len() <= 256 {
                Edges::U8(edges.iter().map(|&e| e as u8).collect())
            } else {
                Edges::U32(edges.clone())
            },
            weights: rig.influence_weights.clone(),
            rbf_weights,
            pivots: tiled,
        }
    }

    /// d_v of all vertices in all frames; `features` is frames × F.
    pub fn apply(&self, features: &[f32], edges: usize, vertices: usize, out: &mut [[f32; 3]]) {
        let tables: Vec<Vec<[f32; CENTERS]>> =
            (0..out.len() / vertices).map(|frame| self.table(&features[frame * edges..][..edges])).collect();
        match &self.edges {
            Edges::U8(indices) => self.by_blocks(indices, &tables, edges, vertices, out),
            Edges::U32(indices) => self.by_blocks(indices, &tables, edges, vertices, out),
        }
    }

    /// `[N/8][F][8]` squared differences; past N, 0.
    fn table(&self, f: &[f32]) -> Vec<[f32; CENTERS]> {
        let mut table = vec![[0.0; CENTERS]; self.centers.div_ceil(CENTERS) * f.len()];
        for (j, f_j) in self.pose_features.chunks_exact(f.len().max(1)).enumerate() {
            let rows = &mut table[j / CENTERS * f.len()..];
            for (row, (f, f_j)) in rows.iter_mut().zip(f.iter().zip(f_j)) {
                let difference = f - f_j;
                row[j % CENTERS] = difference * difference;
            }
        }
        table
    }

    fn by_blocks<I: Copy + Into<u32> + Sync>(
        &self,
        indices: &[I],
        tables: &[Vec<[f32; CENTERS]>],
        edges: usize,
        vertices: usize,
        out: &mut [[f32; 3]],
    ) {
        blocks(out, vertices).into_par_iter().enumerate().for_each_init(
            Vec::new,
            |distances, (block, frames)| {
                let mut frames: Vec<_> = frames.into_iter().map(|frame| frame.chunks_mut(TILE)).collect();
                distances.resize(self.centers, [0.0; TILE]);
                for i in 0..(vertices - block * BLOCK).min(BLOCK).div_ceil(TILE) {
                    for (frame, table) in frames.iter_mut().zip(tables) {
                        if let Some(out) = frame.next() {
                            let tile = block * (BLOCK / TILE) + i;
                            widest(
                                #[inline(always)]
                                || self.tile(tile, indices, table, edges, distances, out),
                            );
                        }
                    }
                }
            },
        );
    }

    /// One tile of one frame; `distances` is room for N rows.
    #[inline(always)]
    fn tile<I: Copy + Into<u32>>(
        &self,
        tile: usize,
        indices: &[I],
        table: &[[f32; CENTERS]],
        edges: usize,
        distances: &mut [[f32; TILE]],
        out: &mut [[f32; 3]],
    ) {
        let (k, n) = (self.influences, self.centers);
        let here = tile * TILE * k..(tile * TILE + out.len()) * k;
        let (indices, weights) = (&indices[here.clone()], &self.weights[here]);
        for (chunk, rows) in distances.chunks_mut(CENTERS).enumerate() {
            let table = &table[chunk * edges..][..edges];
            for lane in 0..out.len() {
                let mut sum = [0.0; CENTERS];
                for (e, alpha) in indices[lane * k..][..k].iter().zip(&weights[lane * k..][..k]) {
                    let squares = &table[(*e).into() as usize];
                    for c in 0..CENTERS {
                        sum[c] += alpha * squares[c];
                    }
                }
                for r in &mut sum {
                    *r = r.sqrt();
                }
                for (row, r) in rows.iter_mut().zip(&sum) {
                    row[lane] = *r;
                }
            }
        }
        let pivots = &self.pivots[tile];
        let rbf_weights = &self.rbf_weights[tile * n..][..n];
        let mut r_pivot = [0.0; TILE];
        let mut d = [[0.0; TILE]; 3];
        for (j, (r, w)) in distances.iter().zip(rbf_weights).enumerate() {
            for lane in 0..TILE {
                let is_pivot = pivots[lane] == j as u32;
                r_pivot[lane] = if is_pivot { r[lane] } else { r_pivot[lane] };
                for c in 0..3 {
                    d[c][lane] = if is_pivot { w[c][lane] * r[lane] } else { d[c][lane] };
                }
            }
        }
        for (j, (r, w)) in distances.iter().zip(rbf_weights).enumerate() {
            for lane in 0..TILE {
                let (is_pivot, away) = (pivots[lane] == j as u32, r[lane] - r_pivot[lane]);
                for c in 0..3 {
                    // What adds nothing is -0: with it every number keeps its bits.
                    d[c][lane] += if is_pivot { -0.0 } else { w[c][lane] * away };
                }
            }
        }
        for (lane, out) in out.iter_mut().enumerate() {
            *out = [d[0][lane], d[1][lane], d[2][lane]];
        }
    }
}
