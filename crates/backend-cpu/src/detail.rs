//! The detail: radial basis functions of the strains.
//!
//! A vertex's distance from a centre, `Σ_k α_k (f_e(k) − f_je(k))²`, is a row of a sparse matrix, V × F, times a column of the table of
//! squared differences, F × N. Vertices that lie side by side are driven by nearly the same strain edges: sixteen of them share the list
//! of all their edges, and where an edge drives one of them and not the other, α is zero, which changes no sum. So nothing is gathered.
use crate::lanes::{Lanes, load3, store3};
use crate::rows::{GROUP, ROW, Row, RowVectors};
use pulp::Simd;
use rhytid_core::Rig;
use rhytid_kernels::detail::{pivoted, tile_influences};
use rhytid_kernels::{Number, differences};

/// Centres whose distances are summed at once in one frame.
const CENTERS: usize = differences::CENTERS_AT_ONCE;

/// Centres and vertices whose distances are summed at once in a group of frames: each number that is loaded serves several sums.
const GROUP_CENTERS: usize = 4;
const GROUP_VERTICES: usize = 2;

/// The squared differences of a strain edge and some of the centres, in one frame.
pub type TableRow = [f32; CENTERS];

/// The same in a group of frames.
pub type GroupTableRow = [Row; GROUP_CENTERS];

/// What the kernel reads of a rig.
#[derive(Debug)]
pub struct Detail {
    /// N.
    centers: usize,
    /// F.
    edges: usize,
    /// N × F.
    pose_features: Vec<f32>,
    influences: Influences,
    /// w, `[V/16][N][3][16]`, with the pivot's sum in its place.
    rbf_weights: Vec<RowVectors>,
    /// The pivot of each vertex; past V, 0.
    pivots: Vec<[u32; ROW]>,
}

/// The strain edges that drive any of sixteen vertices, ascending, and how much they drive each.
#[derive(Debug, Default)]
struct Influences {
    /// Where each sixteen vertices' edges begin, and where the last ones' end.
    first: Vec<usize>,
    edges: Vec<u32>,
    /// α; zero where an edge does not drive a vertex.
    weights: Vec<Row>,
}

impl Influences {
    fn new(rig: &Rig) -> Self {
        let mut all = Self { first: vec![0], ..Self::default() };
        let (vertices, k) = (rig.vertices(), rig.influences());
        for first in (0..vertices).step_by(ROW) {
            let here = first * k..(first + ROW).min(vertices) * k;
            let (edges, weights) = (&rig.influence_edges[here.clone()], &rig.influence_weights[here]);
            let (edges, weights) = tile_influences(k, edges, weights);
            all.edges.extend(edges);
            all.weights.extend(weights.into_iter().map(Row));
            all.first.push(all.edges.len());
        }
        all
    }

    /// The edges that drive the `row`th sixteen vertices, and α.
    #[inline(always)]
    fn at(&self, row: usize) -> (&[u32], &[Row]) {
        let range = self.first[row]..self.first[row + 1];
        (&self.edges[range.clone()], &self.weights[range])
    }
}

impl Detail {
    pub fn new(rig: &Rig) -> Self {
        let (vertices, centers) = (rig.vertices(), rig.centers());
        let (weights, pivots) = pivoted(&rig.rbf_weights, centers);
        let rows = vertices.div_ceil(ROW);
        let mut rbf_weights = vec![[Row::ZERO; 3]; rows * centers];
        for (i, w) in weights.iter().enumerate() {
            let (v, j) = (i / centers, i % centers);
            for c in 0..3 {
                rbf_weights[v / ROW * centers + j][c].0[v % ROW] = w[c];
            }
        }
        let mut in_rows = vec![[0; ROW]; rows];
        pivots.iter().enumerate().for_each(|(v, &pivot)| in_rows[v / ROW][v % ROW] = pivot);
        Self {
            centers,
            edges: rig.strain_edges.len(),
            pose_features: rig.pose_features.clone(),
            influences: Influences::new(rig),
            rbf_weights,
            pivots: in_rows,
        }
    }

    /// The squared differences of one frame's features, `[N/8][F][8]`; past N, 0.
    pub fn frame_table(&self, features: &[f32]) -> Vec<TableRow> {
        let mut table = vec![[0.0; CENTERS]; self.centers.div_ceil(CENTERS) * self.edges];
        let [strain_edges, centers] = [self.edges, self.centers].map(|n| n as u32);
        let params = differences::Params { frames: 1, strain_edges, centers };
        differences::differences(params, features, &self.pose_features, table.as_flattened_mut());
        table
    }

    /// The squared differences of frames × F features of at most [`GROUP`] frames, `[N/4][F][4][16]`; past N, 0.
    pub fn group_table(&self, features: &[f32]) -> Vec<GroupTableRow> {
        let rows = self.centers.div_ceil(GROUP_CENTERS) * self.edges;
        let mut table = vec![[Row::ZERO; GROUP_CENTERS]; rows];
        for (lane, features) in features.chunks_exact(self.edges.max(1)).enumerate() {
            for j in 0..self.centers {
                for (e, f) in features.iter().enumerate() {
                    let difference = f - self.pose_features[j * self.edges + e];
                    let row = j / GROUP_CENTERS * self.edges + e;
                    table[row][j % GROUP_CENTERS].0[lane] = difference * difference;
                }
            }
        }
        table
    }

    /// N.
    pub fn centers(&self) -> usize {
        self.centers
    }

    /// d of the `row`th [`ROW`] vertices, in one frame. `distances` has room for those from N centres.
    #[inline(always)]
    pub fn frame<S: Simd>(
        &self,
        simd: S,
        row: usize,
        table: &[TableRow],
        distances: &mut [Row],
    ) -> RowVectors {
        let (edges, weights) = self.influences.at(row);
        let rbf_weights = &self.rbf_weights[row * self.centers..][..self.centers];
        let mut d = [Row::ZERO; 3];
        for part in 0..ROW / S::F32_LANES {
            for (r, table) in distances.chunks_mut(CENTERS).zip(table.chunks_exact(self.edges.max(1))) {
                let mut sums = [Lanes::splat(simd, 0.0); CENTERS];
                for (e, alpha) in edges.iter().zip(weights) {
                    let squares = &table[*e as usize];
                    let alpha = Lanes::load(simd, &alpha.0, part);
                    for j in 0..CENTERS {
                        sums[j] = alpha.times_plus(Lanes::splat(simd, squares[j]), sums[j]);
                    }
                }
                for (r, sum) in r.iter_mut().zip(sums) {
                    sum.root().store(&mut r.0, part);
                }
            }
            let pivots = S::as_simd_u32s(&self.pivots[row]).0[part];
            let is_pivot = |j: usize| simd.equal_u32s(pivots, simd.splat_u32s(j as u32));
            let mut at_pivot = Lanes::splat(simd, 0.0);
            for (j, r) in distances.iter().enumerate() {
                at_pivot.1 = simd.select_f32s(is_pivot(j), Lanes::load(simd, &r.0, part).1, at_pivot.1);
            }
            let mut sum = [Lanes::splat(simd, 0.0); 3];
            for (j, (r, w)) in distances.iter().zip(rbf_weights).enumerate() {
                let away = Lanes::load(simd, &r.0, part) - at_pivot;
                let factor = Lanes(simd, simd.select_f32s(is_pivot(j), at_pivot.1, away.1));
                let w = load3(simd, w, part);
                for c in 0..3 {
                    sum[c] = w[c].times_plus(factor, sum[c]);
                }
            }
            store3(sum, &mut d, part);
        }
        d
    }

    /// Room for the distances of a few vertices from all centres in a group of frames.
    pub fn group_scratch(&self) -> [Vec<Row>; GROUP_VERTICES] {
        std::array::from_fn(|_| vec![Row::ZERO; self.centers])
    }

    /// d of the vertices from `first` on, a multiple of [`ROW`], in a group of frames.
    #[inline(always)]
    pub fn group<S: Simd>(
        &self,
        simd: S,
        first: usize,
        table: &[GroupTableRow],
        distances: &mut [Vec<Row>; GROUP_VERTICES],
        out: &mut [RowVectors],
    ) {
        for (i, out) in out.chunks_mut(GROUP_VERTICES).enumerate() {
            let v = first + i * GROUP_VERTICES;
            for part in 0..GROUP / S::F32_LANES {
                self.group_distances(simd, v, part, table, distances);
                for (lane, (out, distances)) in out.iter_mut().zip(&*distances).enumerate() {
                    store3(self.group_sum(simd, v + lane, part, distances), out, part);
                }
            }
        }
    }

    /// r of a few vertices from each centre, in one part of a group.
    #[inline(always)]
    fn group_distances<S: Simd>(
        &self,
        simd: S,
        v: usize,
        part: usize,
        table: &[GroupTableRow],
        distances: &mut [Vec<Row>; GROUP_VERTICES],
    ) {
        let (edges, weights) = self.influences.at(v / ROW);
        for (chunk, table) in table.chunks_exact(self.edges.max(1)).enumerate() {
            let mut sums = [[Lanes::splat(simd, 0.0); GROUP_CENTERS]; GROUP_VERTICES];
            for (e, alphas) in edges.iter().zip(weights) {
                let squares = &table[*e as usize];
                let (alphas, _) = alphas.0.as_chunks::<GROUP_VERTICES>();
                let alphas = &alphas[v % ROW / GROUP_VERTICES];
                for j in 0..GROUP_CENTERS {
                    let squares = Lanes::load(simd, &squares[j].0, part);
                    for lane in 0..GROUP_VERTICES {
                        sums[lane][j] = Lanes::splat(simd, alphas[lane]).times_plus(squares, sums[lane][j]);
                    }
                }
            }
            for (r, sums) in distances.iter_mut().zip(sums) {
                for (r, sum) in r[chunk * GROUP_CENTERS..].iter_mut().zip(sums) {
                    sum.root().store(&mut r.0, part);
                }
            }
        }
    }

    /// d of vertex `v` from its distances, in one part of a group.
    #[inline(always)]
    fn group_sum<S: Simd>(&self, simd: S, v: usize, part: usize, distances: &[Row]) -> [Lanes<S>; 3] {
        let (row, lane) = (v / ROW, v % ROW);
        let weights = &self.rbf_weights[row * self.centers..][..self.centers];
        let pivot = self.pivots[row][lane] as usize;
        let at_pivot = Lanes::load(simd, &distances[pivot].0, part);
        let mut sum = [Lanes::splat(simd, 0.0); 3];
        for (j, (r, w)) in distances.iter().zip(weights).enumerate() {
            let away = Lanes::load(simd, &r.0, part) - at_pivot;
            let factor = if j == pivot { at_pivot } else { away };
            for c in 0..3 {
                sum[c] = Lanes::splat(simd, w[c].0[lane]).times_plus(factor, sum[c]);
            }
        }
        sum
    }
}
