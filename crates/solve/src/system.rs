//! Sparse symmetric matrices over the vertices of a mesh.
//!
//! The matrix of section 2 is A = −k_s C + k_b C M⁻¹ C with k_s = 1 and k_b = ℓ². The matrix that smooths is
//! M − (σ²/2) C.
use rayon::prelude::*;
use rhytid_core::VertexId;
use rhytid_geometry::cholesky::Columns;
use rhytid_geometry::cholesky::Graph;
use rhytid_geometry::laplacian::Laplacian;

/// The number of rows that one thread assembles at a time.
const ROWS_AT_ONCE: usize = 4096;

/// The place of a vertex that is not in an order.
pub(crate) const NONE: u32 = u32::MAX;

/// The energy of a matrix.
enum Energy {
    /// −C + ℓ² C M⁻¹ C, with ℓ².
    Shell(f64),
    /// M − (σ²/2) C, with σ²/2.
    Smoothing(f64),
}

/// A, row by row. Its entries are computed when they are asked for.
pub struct System {
    mass: Vec<f64>,
    energy: Energy,
    /// The neighbours of each vertex along edges of the mesh, and the vertex itself: the entries of C.
    rings: Graph,
    /// C, in the order of `rings`.
    laplacian: Vec<f64>,
    /// The entries of A: two rings for the shell, one for the matrix that smooths.
    pattern: Graph,
}

impl System {
    /// The matrix of the thin shell, for ℓ in mesh units.
    pub fn new(laplacian: Laplacian, bending_length: f64) -> Self {
        let (rings, values) = rows(&laplacian);
        let pattern = two_rings(&rings);
        let energy = Energy::Shell(bending_length * bending_length);
        Self { mass: laplacian.mass, energy, rings, laplacian: values, pattern }
    }

    /// The matrix that smooths, for σ in mesh units.
    pub fn smoothing(laplacian: Laplacian, sigma: f64) -> Self {
        let (rings, values) = rows(&laplacian);
        let energy = Energy::Smoothing(0.5 * sigma * sigma);
        Self { mass: laplacian.mass, energy, pattern: rings.clone(), rings, laplacian: values }
    }

    /// M of a vertex.
    pub fn mass(&self, v: u32) -> f64 {
        self.mass[v as usize]
    }

    /// `ℓ² M⁻¹ C x` of V positions x, for the shell; 0 at vertices without area.
    pub fn bending(&self, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let Energy::Shell(bending) = self.energy else { return vec![[0.0; 3]; positions.len()] };
        let of_vertex = |v: usize| {
            let mut sum = [0.0; 3];
            for (w, c) in self.laplacian_row(v as u32) {
                (0..3).for_each(|i| sum[i] += c * positions[w as usize][i]);
            }
            let scale = if self.mass[v] > 0.0 { bending / self.mass[v] } else { 0.0 };
            sum.map(|x| scale * x)
        };
        (0..positions.len()).into_par_iter().map(of_vertex).collect()
    }

    /// The entries of A.
    pub fn pattern(&self) -> &Graph {
        &self.pattern
    }

    /// Replaces `values` by the entries of row `v`, in the pattern's order.
    pub fn row(&self, v: u32, values: &mut Vec<f64>) {
        let pattern = self.pattern.neighbors(v);
        values.clear();
        values.resize(pattern.len(), 0.0);
        // Both lists are ascending, and the second is part of the first.
        let mut add = |scale: f64, row: u32| {
            let mut at = 0;
            for (w, c) in self.laplacian_row(row) {
                while pattern[at] < w {
                    at += 1;
                }
                values[at] += scale * c;
            }
        };
        match self.energy {
            Energy::Shell(bending) => {
                for (m, c) in self.laplacian_row(v) {
                    add(bending * c / self.mass[m as usize], m);
                }
                add(-1.0, v);
            }
            Energy::Smoothing(half) => {
                add(-half, v);
                let diagonal = pattern.partition_point(|&w| w < v);
                values[diagonal] += self.mass[v as usize];
            }
        }
    }

    /// Row `v` of C.
    pub fn laplacian_row(&self, v: u32) -> impl Iterator<Item = (u32, f64)> {
        let range = self.rings.offsets[v as usize]..self.rings.offsets[v as usize + 1];
        self.rings.neighbors(v).iter().copied().zip(self.laplacian[range].iter().copied())
    }

    /// The lower triangle of A for the vertices `order` (distinct), in that order. Rows ascend in each
    /// column.
    pub fn lower(&self, order: &[u32]) -> Columns {
        let place = self.places(order);
        let assemble = |(block, vertices): (usize, &[u32])| {
            let mut columns = Columns::default();
            let (mut values, mut entries) = (Vec::new(), Vec::new());
            for (j, &v) in (block * ROWS_AT_ONCE..).zip(vertices) {
                self.row(v, &mut values);
                let rows = self.pattern.neighbors(v).iter().map(|&w| place[w as usize]);
                entries.clear();
                entries.extend(
                    rows.zip(values.iter().copied()).filter(|(row, _)| *row >= j as u32 && *row != NONE),
                );
                entries.sort_unstable_by_key(|entry| entry.0);
                columns.push(entries.iter().copied());
            }
            columns
        };
        let parts: Vec<Columns> = order.par_chunks(ROWS_AT_ONCE).enumerate().map(assemble).collect();
        let mut whole = Columns::default();
        parts.into_iter().for_each(|part| whole.append(part));
        whole
    }

    /// The right-hand sides −A_fH: a column for each of `handles`, over the vertices `order`.
    pub fn right(&self, order: &[u32], handles: &[VertexId]) -> Columns {
        let place = self.places(order);
        let mut right = Columns::default();
        let mut values = Vec::new();
        for &h in handles {
            self.row(h.0, &mut values);
            let rows = self.pattern.neighbors(h.0).iter().map(|&w| place[w as usize]);
            right.push(rows.zip(&values).filter(|(row, _)| *row != NONE).map(|(row, value)| (row, -value)));
        }
        right
    }

    /// The place of each vertex of the mesh in `order`; `u32::MAX` for vertices that are not in it.
    pub fn places(&self, order: &[u32]) -> Vec<u32> {
        let mut place = vec![NONE; self.mass.len()];
        for (i, &v) in order.iter().enumerate() {
            place[v as usize] = i as u32;
        }
        place
    }
}

/// C with its diagonal, columns ascending.
fn rows(laplacian: &Laplacian) -> (Graph, Vec<f64>) {
    let vertices = laplacian.diagonal.len();
    let mut offsets = vec![0; vertices + 1];
    offsets[1..].fill(1);
    for &(a, b, _) in &laplacian.edges {
        offsets[a as usize + 1] += 1;
        offsets[b as usize + 1] += 1;
    }
    for v in 0..vertices {
        offsets[v + 1] += offsets[v];
    }
    let mut next = offsets.clone();
    let mut neighbors = vec![0; offsets[vertices]];
    let mut values = vec![0.0; offsets[vertices]];
    let mut put = |row: u32, column: u32, value: f64| {
        let at = &mut next[row as usize];
        neighbors[*at] = column;
        values[*at] = value;
        *at += 1;
    };
    // Edges are sorted by (a, b), so the three passes leave every row ascending.
    for &(a, b, w) in &laplacian.edges {
        put(b, a, w);
    }
    for (v, &d) in laplacian.diagonal.iter().enumerate() {
        put(v as u32, v as u32, d);
    }
    for &(a, b, w) in &laplacian.edges {
        put(a, b, w);
    }
    (Graph { offsets, neighbors }, values)
}

/// The neighbours of the neighbours. A ring contains its own vertex, so direct neighbours are included.
fn two_rings(rings: &Graph) -> Graph {
    let vertices: Vec<u32> = (0..rings.offsets.len() as u32 - 1).collect();
    let join = |vertices: &[u32]| {
        let mut ends = Vec::with_capacity(vertices.len());
        let mut neighbors = Vec::new();
        let mut both = Vec::new();
        for &v in vertices {
            both.clear();
            both.extend(rings.neighbors(v).iter().flat_map(|&m| rings.neighbors(m)));
            both.sort_unstable();
            both.dedup();
            neighbors.extend_from_slice(&both);
            ends.push(neighbors.len());
        }
        (ends, neighbors)
    };
    let parts: Vec<(Vec<usize>, Vec<u32>)> = vertices.par_chunks(ROWS_AT_ONCE).map(join).collect();
    let mut whole = Graph { offsets: vec![0], neighbors: Vec::new() };
    for (ends, neighbors) in parts {
        let first = whole.neighbors.len();
        whole.offsets.extend(ends.iter().map(|end| first + end));
        whole.neighbors.extend(neighbors);
    }
    whole
}
