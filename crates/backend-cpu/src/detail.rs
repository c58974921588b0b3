//! The detail: radial basis functions of the strains.
//!
//! Vertices' distances from centres, `Σ_k α_k (f_e(k) − f_je(k))²`, are a sparse matrix, V × F, times the table of squared differences,
//! F × N. Vertices that lie side by side are driven by nearly the same strain edges: those of a tile share the list
//! of all their edges, and where an edge drives one of them and not the other, α is zero, which changes no sum. So nothing is gathered.
use crate::lanes::{Lanes, load3, store3};
use crate::lines::{GROUP, Line, Line3};
use pulp::Simd;
use rhytid_core::Rig;
use rhytid_kernels::detail::{pivoted, tile_influences};
use rhytid_kernels::table::TILE;
use rhytid_kernels::{Number, differences};

/// Centres whose distances are summed at once in one frame.
const CENTERS: usize = differences::CENTERS_AT_ONCE;

/// Centres and vertices whose distances are summed at once in a group of frames: each number that is loaded serves several sums.
const GROUP_CENTERS: usize = 4;
const GROUP_VERTICES: usize = 2;

/// The squared differences of a strain edge and some of the centres, in one frame.
pub(crate) type Differences = [f32; CENTERS];

/// The same in a group of frames.
pub(crate) type GroupDifferences = [Line; GROUP_CENTERS];

/// What the kernel reads of a rig.
#[derive(Debug)]
pub(crate) struct Detail {
    /// N.
    centers: usize,
    /// F.
    edges: usize,
    /// N × F.
    pose_features: Vec<f32>,
    influences: Influences,
    /// w, tiled, `[V/16][N][3][16]`, with the pivot's sum in its place.
    rbf_weights: Vec<Line3>,
    /// The pivot of each vertex, tiled; past V, 0.
    pivots: Vec<[u32; TILE]>,
}

/// The strain edges that drive any of a tile's vertices, ascending, and how much they drive each.
#[derive(Debug, Default)]
struct Influences {
    /// Where each tile's edges begin, and where the last one's end.
    first: Vec<usize>,
    edges: Vec<u32>,
    /// A row of α for each; zero where an edge does not drive a vertex.
    weights: Vec<Line>,
}

impl Influences {
    fn new(rig: &Rig) -> Self {
        let mut all = Self { first: vec![0], ..Self::default() };
        let (vertices, k) = (rig.vertices(), rig.influences());
        for first in (0..vertices).step_by(TILE) {
            let here = first * k..(first + TILE).min(vertices) * k;
            let (edges, weights) = (&rig.influence_edges[here.clone()], &rig.influence_weights[here]);
            let (edges, weights) = tile_influences(k, edges, weights);
            all.edges.extend(edges);
            all.weights.extend(weights.into_iter().map(Line));
            all.first.push(all.edges.len());
        }
        all
    }

    /// The edges that drive a tile's vertices, and α.
    #[inline(always)]
    fn at(&self, tile: usize) -> (&[u32], &[Line]) {
        let range = self.first[tile]..self.first[tile + 1];
        (&self.edges[range.clone()], &self.weights[range])
    }
}

impl Detail {
    pub(crate) fn new(rig: &Rig) -> Self {
        let (vertices, centers) = (rig.vertices(), rig.centers());
        let (weights, pivots) = pivoted(&rig.rbf_weights, centers);
        let tiles = vertices.div_ceil(TILE);
        let mut rbf_weights = vec![[Line::ZERO; 3]; tiles * centers];
        for (i, w) in weights.iter().enumerate() {
            let (v, j) = (i / centers, i % centers);
            for c in 0..3 {
                rbf_weights[v / TILE * centers + j][c].0[v % TILE] = w[c];
            }
        }
        let mut tiled_pivots = vec![[0; TILE]; tiles];
        pivots.iter().enumerate().for_each(|(v, &pivot)| tiled_pivots[v / TILE][v % TILE] = pivot);
        Self {
            centers,
            edges: rig.strain_edges.len(),
            pose_features: rig.pose_features.clone(),
            influences: Influences::new(rig),
            rbf_weights,
            pivots: tiled_pivots,
        }
    }

    /// The squared differences of one frame's features, `[N/8][F][8]`; past N, 0.
    pub(crate) fn frame_table(&self, features: &[f32]) -> Vec<Differences> {
        let mut table = vec![[0.0; CENTERS]; self.centers.div_ceil(CENTERS) * self.edges];
        let [strain_edges, centers] = [self.edges, self.centers].map(|n| n as u32);
        let params = differences::Params { frames: 1, strain_edges, centers };
        differences::differences(params, features, &self.pose_features, table.as_flattened_mut());
        table
    }

    /// The squared differences of frames × F features of at most [`GROUP`] frames, `[N/4][F][4][16]`; past N, 0.
    pub(crate) fn group_table(&self, features: &[f32]) -> Vec<GroupDifferences> {
        let mut table = vec![[Line::ZERO; GROUP_CENTERS]; self.centers.div_ceil(GROUP_CENTERS) * self.edges];
        for (lane, features) in features.chunks_exact(self.edges.max(1)).enumerate() {
            for j in 0..self.centers {
                for (e, f) in features.iter().enumerate() {
                    let difference = f - self.pose_features[j * self.edges + e];
                    let at = j / GROUP_CENTERS * self.edges + e;
                    table[at][j % GROUP_CENTERS].0[lane] = difference * difference;
                }
            }
        }
        table
    }

    /// N.
    pub(crate) fn centers(&self) -> usize {
        self.centers
    }

    /// d of a tile's vertices, in one frame. `distances` is scratch for those from N centres.
    #[inline(always)]
    pub(crate) fn frame<S: Simd>(
        &self,
        simd: S,
        tile: usize,
        table: &[Differences],
        distances: &mut [Line],
    ) -> Line3 {
        let (edges, weights) = self.influences.at(tile);
        let rbf_weights = &self.rbf_weights[tile * self.centers..][..self.centers];
        let mut d = [Line::ZERO; 3];
        for register in 0..TILE / S::F32_LANES {
            for (r, table) in distances.chunks_mut(CENTERS).zip(table.chunks_exact(self.edges.max(1))) {
                let mut sums = [Lanes::splat(simd, 0.0); CENTERS];
                for (e, alpha) in edges.iter().zip(weights) {
                    let squares = &table[*e as usize];
                    let alpha = Lanes::load(simd, &alpha.0, register);
                    for j in 0..CENTERS {
                        sums[j] = alpha.mul_add(Lanes::splat(simd, squares[j]), sums[j]);
                    }
                }
                for (r, sum) in r.iter_mut().zip(sums) {
                    sum.sqrt().store(&mut r.0, register);
                }
            }
            let pivots = S::as_simd_u32s(&self.pivots[tile]).0[register];
            let is_pivot = |j: usize| simd.equal_u32s(pivots, simd.splat_u32s(j as u32));
            let mut at_pivot = Lanes::splat(simd, 0.0);
            for (j, r) in distances.iter().enumerate() {
                at_pivot.1 = simd.select_f32s(is_pivot(j), Lanes::load(simd, &r.0, register).1, at_pivot.1);
            }
            let mut sum = [Lanes::splat(simd, 0.0); 3];
            for (j, (r, w)) in distances.iter().zip(rbf_weights).enumerate() {
                let away = Lanes::load(simd, &r.0, register) - at_pivot;
                let factor = Lanes(simd, simd.select_f32s(is_pivot(j), at_pivot.1, away.1));
                let w = load3(simd, w, register);
                for c in 0..3 {
                    sum[c] = w[c].mul_add(factor, sum[c]);
                }
            }
            store3(sum, &mut d, register);
        }
        d
    }

    /// Scratch for the distances of a few vertices from all centres in a group of frames.
    pub(crate) fn group_scratch(&self) -> [Vec<Line>; GROUP_VERTICES] {
        std::array::from_fn(|_| vec![Line::ZERO; self.centers])
    }

    /// d of the vertices from `first` on, a multiple of [`TILE`], in a group of frames.
    #[inline(always)]
    pub(crate) fn group<S: Simd>(
        &self,
        simd: S,
        first: usize,
        table: &[GroupDifferences],
        distances: &mut [Vec<Line>; GROUP_VERTICES],
        out: &mut [Line3],
    ) {
        for (i, out) in out.chunks_mut(GROUP_VERTICES).enumerate() {
            let v = first + i * GROUP_VERTICES;
            for register in 0..GROUP / S::F32_LANES {
                self.group_distances(simd, v, register, table, distances);
                for (lane, (out, distances)) in out.iter_mut().zip(&*distances).enumerate() {
                    store3(self.group_sum(simd, v + lane, register, distances), out, register);
                }
            }
        }
    }

    /// r of a few vertices from each centre, in some frames of a group.
    #[inline(always)]
    fn group_distances<S: Simd>(
        &self,
        simd: S,
        v: usize,
        register: usize,
        table: &[GroupDifferences],
        distances: &mut [Vec<Line>; GROUP_VERTICES],
    ) {
        let (edges, weights) = self.influences.at(v / TILE);
        for (chunk, table) in table.chunks_exact(self.edges.max(1)).enumerate() {
            let mut sums = [[Lanes::splat(simd, 0.0); GROUP_CENTERS]; GROUP_VERTICES];
            for (e, alphas) in edges.iter().zip(weights) {
                let squares = &table[*e as usize];
                let (alphas, _) = alphas.0.as_chunks::<GROUP_VERTICES>();
                let alphas = &alphas[v % TILE / GROUP_VERTICES];
                for j in 0..GROUP_CENTERS {
                    let squares = Lanes::load(simd, &squares[j].0, register);
                    for lane in 0..GROUP_VERTICES {
                        sums[lane][j] = Lanes::splat(simd, alphas[lane]).mul_add(squares, sums[lane][j]);
                    }
                }
            }
            for (r, sums) in distances.iter_mut().zip(sums) {
                for (r, sum) in r[chunk * GROUP_CENTERS..].iter_mut().zip(sums) {
                    sum.sqrt().store(&mut r.0, register);
                }
            }
        }
    }

    /// d of vertex `v` from its distances, in some frames of a group.
    #[inline(always)]
    fn group_sum<S: Simd>(&self, simd: S, v: usize, register: usize, distances: &[Line]) -> [Lanes<S>; 3] {
        let (tile, lane) = (v / TILE, v % TILE);
        let weights = &self.rbf_weights[tile * self.centers..][..self.centers];
        let pivot = self.pivots[tile][lane] as usize;
        let at_pivot = Lanes::load(simd, &distances[pivot].0, register);
        let mut sum = [Lanes::splat(simd, 0.0); 3];
        for (j, (r, w)) in distances.iter().zip(weights).enumerate() {
            let away = Lanes::load(simd, &r.0, register) - at_pivot;
            let factor = if j == pivot { at_pivot } else { away };
            for c in 0..3 {
                sum[c] = Lanes::splat(simd, w[c].0[lane]).mul_add(factor, sum[c]);
            }
        }
        sum
    }
}
