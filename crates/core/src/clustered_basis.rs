//! The basis in clusters of vertices, each as the product of two small factors.
//!
//! The basis is smooth: neighbouring vertices move almost alike. So the rows of neighbouring vertices are
//! close to a space of few dimensions. Clustered principal components are known from light transport (Sloan
//! et al. 2003, *Clustered Principal Components for Precomputed Radiance Transfer*).
use crate::band_weights::next_power_of_two;
use crate::{BasisStorage, Rig, Table, VertexId};
use rayon::prelude::*;
use std::ops::Range;

/// A cluster has at most this many times H rows. H rows suffice but for the rounding to integers. Twice as
/// many take the rounding away as well, unless fp32 is too coarse for the basis.
const MOST_ROWS: usize = 3;

/// The largest integer of 16 bits.
const LARGEST_INTEGER: f32 = 32_767.0;

/// `B ≈ U W`, cluster by cluster. U has integers of 16 bits, since its numbers are all of one size. W has
/// their unit.
///
/// The differences of a row of B from its row of U W add up to at most
/// [`ClusteredBasis::LARGEST_ERROR`]. The rows of vertices that handles hold are those of B, up to the
/// rounding to fp32.
///
/// ```
/// # use rhytid_core::{ClusteredBasis, NoProgress, Result};
/// # fn main() -> Result<()> {
/// let rig = rhytid_solve::solve(&rhytid_demo::face(2_000), &NoProgress)?.rounded()?;
/// let clusters = ClusteredBasis::new(&rig);
/// let moved = clusters.product();
/// let differences = moved.row(100).iter().zip(rig.basis().row(100)).map(|(a, b)| (a - b).abs());
/// assert!(differences.sum::<f32>() < 0.000_2);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ClusteredBasis {
    handles: usize,
    clusters: Vec<Cluster>,
    /// The first row of each cluster, and R, the number of all rows.
    first_rows: Vec<usize>,
}

/// The factors of a cluster's vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct Cluster {
    /// Of U: for each row of W a number for each vertex of the cluster.
    pub columns: Vec<Vec<i16>>,
    /// Of W: H numbers a row.
    pub rows: Vec<Vec<f32>>,
    /// The largest sum of a vertex's differences from its row of B.
    pub largest_error: f64,
}

impl ClusteredBasis {
    /// Vertices of a cluster: neighbours in the order of the mesh. The last cluster may have fewer. This is a
    /// multiple of a tile.
    pub const VERTICES: usize = 256;

    /// How far the factors may move any vertex along an axis, as a part of the largest displacement of a
    /// handle: 0.005 mm if no handle moves by more than 30 mm.
    pub const LARGEST_ERROR: f64 = 0.005 / BasisStorage::MOTION_MM;

    /// The clusters of a rig's basis. Other processors find the same ones, bit for bit.
    pub fn new(rig: &Rig) -> Self {
        let mut held: Vec<usize> = rig.handles().held().map(VertexId::index).collect();
        held.sort_unstable();
        held.dedup();
        let of_cluster = |first: usize| {
            let vertices = first..(first + Self::VERTICES).min(rig.vertices());
            let of = |v: &usize| held.partition_point(|other| other < v);
            let held = &held[of(&vertices.start)..of(&vertices.end)];
            let held = held.iter().map(|v| v - first).collect();
            Residual::new(rig.basis().of_rows(vertices), rig.basis().columns()).factored(held)
        };
        let firsts: Vec<usize> = (0..rig.vertices()).step_by(Self::VERTICES).collect();
        let clusters: Vec<Cluster> = firsts.into_par_iter().map(of_cluster).collect();
        let mut first_rows = vec![0];
        let mut end = 0;
        for cluster in &clusters {
            end += cluster.rows.len();
            first_rows.push(end);
        }
        Self { handles: rig.handles().len(), clusters, first_rows }
    }

    /// All clusters, in the order of their vertices.
    pub fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    /// The rows of W that belong to a cluster, counted over all clusters.
    pub fn rows_of(&self, cluster: usize) -> Range<usize> {
        self.first_rows[cluster]..self.first_rows[cluster + 1]
    }

    /// R: the rows of W of all clusters.
    pub fn rows(&self) -> usize {
        self.first_rows.last().copied().unwrap_or(0)
    }

    /// W of all clusters, R×H.
    pub fn handle_factors(&self) -> Table<f32> {
        let rows = self.clusters.iter().flat_map(|cluster| cluster.rows.iter().flatten());
        Table::new(self.rows(), self.handles, rows.copied().collect())
    }

    /// The most rows of a cluster.
    pub fn highest_rank(&self) -> usize {
        self.clusters.iter().map(|cluster| cluster.rows.len()).max().unwrap_or(0)
    }

    /// The bytes of both factors.
    pub fn bytes(&self) -> usize {
        let bytes = |cluster: &Cluster| {
            cluster.columns.iter().map(|column| 2 * column.len() + 4 * self.handles).sum::<usize>()
        };
        self.clusters.iter().map(bytes).sum()
    }

    /// A bound of how far the factors move any vertex along an axis, as a part of the largest displacement of
    /// a handle. It is at most [`ClusteredBasis::LARGEST_ERROR`], unless the basis has numbers in the
    /// thousands.
    pub fn largest_error(&self) -> f64 {
        self.clusters.iter().map(|cluster| cluster.largest_error).fold(0.0, f64::max)
    }

    /// U W, V×H.
    pub fn product(&self) -> Table<f32> {
        let of_cluster = |cluster: &Cluster| {
            let vertices = cluster.columns.first().map_or(0, Vec::len);
            let mut product = vec![0.0_f64; vertices * self.handles];
            for (column, row) in cluster.columns.iter().zip(&cluster.rows) {
                for (product, &c) in product.chunks_exact_mut(self.handles).zip(column) {
                    for (product, &w) in product.iter_mut().zip(row) {
                        *product += f64::from(c) * f64::from(w);
                    }
                }
            }
            product.into_iter().map(|b| b as f32)
        };
        let products: Vec<f32> = self.clusters.iter().flat_map(of_cluster).collect();
        Table::new(products.len() / self.handles.max(1), self.handles, products)
    }
}

/// What the factors of a cluster leave of its rows.
struct Residual {
    handles: usize,
    /// n×H.
    rows: Vec<f32>,
}

impl Residual {
    fn new(rows: &[f32], handles: usize) -> Self {
        Self { handles, rows: rows.to_vec() }
    }

    /// Takes the rows of the `held` vertices away, and then one direction after the other, until every row is
    /// small enough.
    fn factored(mut self, held: Vec<usize>) -> Cluster {
        let mut cluster = Cluster { columns: Vec::new(), rows: Vec::new(), largest_error: 0.0 };
        for v in held {
            let row = self.row(v).to_vec();
            if row.iter().any(|&x| x != 0.0) {
                self.take(&row, Some(v), &mut cluster);
            }
        }
        loop {
            let (worst, error) = self.worst();
            // A cluster without a direction has one nevertheless, so that it has as many numbers as vertices.
            let enough = error <= ClusteredBasis::LARGEST_ERROR && !cluster.rows.is_empty();
            if enough || cluster.rows.len() > MOST_ROWS * self.handles {
                cluster.largest_error = error;
                return cluster;
            }
            // One step from the worst row towards the direction that most rows share.
            let shared = self.transposed_products(&self.products(self.row(worst)));
            let length = dot(&shared, &shared).sqrt();
            let direction = if length > 0.0 {
                shared.iter().map(|x| x / length).collect()
            } else {
                self.row(worst).to_vec()
            };
            self.take(&direction, None, &mut cluster);
        }
    }

    fn row(&self, v: usize) -> &[f32] {
        &self.rows[v * self.handles..][..self.handles]
    }

    /// The vertex with the largest sum of what is left, and that sum.
    fn worst(&self) -> (usize, f64) {
        let mut worst = (0, 0.0);
        for (v, row) in self.rows.chunks_exact(self.handles).enumerate() {
            let sum = row.iter().map(|&x| f64::from(x.abs())).sum();
            if sum > worst.1 {
                worst = (v, sum);
            }
        }
        worst
    }

    /// The product of each row with a direction.
    fn products(&self, direction: &[f32]) -> Vec<f32> {
        self.rows.chunks_exact(self.handles).map(|row| dot(row, direction)).collect()
    }

    /// The sum of all rows, each times its number.
    fn transposed_products(&self, numbers: &[f32]) -> Vec<f32> {
        let mut sum = vec![0.0; self.handles];
        for (row, &number) in self.rows.chunks_exact(self.handles).zip(numbers) {
            sum.iter_mut().zip(row).for_each(|(sum, x)| *sum += number * x);
        }
        sum
    }

    /// Takes a direction away from all rows, and adds it to the cluster. If the direction is the row of a
    /// vertex, nothing is left of that row.
    fn take(&mut self, direction: &[f32], of_vertex: Option<usize>, cluster: &mut Cluster) {
        let square = dot(direction, direction);
        let numbers = if square > 0.0 { self.products(direction) } else { vec![0.0; self.vertices()] };
        let numbers: Vec<f32> = numbers.iter().map(|number| number / square.max(f32::MIN_POSITIVE)).collect();
        let largest = numbers.iter().fold(1.0_f32 / LARGEST_INTEGER, |largest, x| largest.max(x.abs()));
        // A power of two, so that the number 1 of a vertex that a handle holds is exact.
        let unit = next_power_of_two(largest / LARGEST_INTEGER);
        let mut column: Vec<i16> = numbers.iter().map(|number| (number / unit).round() as i16).collect();
        if let Some(v) = of_vertex {
            column[v] = (1.0 / unit) as i16;
        }
        let row: Vec<f32> = direction.iter().map(|x| x * unit).collect();
        for (rows, &c) in self.rows.chunks_exact_mut(self.handles).zip(&column) {
            let c = f32::from(c);
            rows.iter_mut().zip(&row).for_each(|(x, w)| *x -= c * w);
        }
        cluster.columns.push(column);
        cluster.rows.push(row);
    }

    fn vertices(&self) -> usize {
        self.rows.len() / self.handles.max(1)
    }
}

/// The sum of the products, eight partial sums at a time.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0_f32; 8];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    for (a, b) in a.iter().zip(b) {
        for i in 0..8 {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum::<f32>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f32>()
}
