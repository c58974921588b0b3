//! Section 2's matrix, A = −k_s C + k_b C M⁻¹ C with k_s = 1 and k_b = ℓ².
use super::cholesky::Lower;
use super::dissection::Graph;
use super::laplacian::Laplacian;
use rayon::prelude::*;

/// Rows assembled by one thread at a time.
const ROWS_AT_ONCE: usize = 4096;

/// A, row by row: its entries are made when they are asked for.
pub struct System<'a> {
    mass: &'a [f64],
    bending: f64,
    /// Which vertices share an edge of the mesh, each with itself: where C has entries.
    rings: Graph,
    /// C, in the order of `rings`.
    laplacian: Vec<f64>,
    /// Where A has entries: two rings.
    pattern: Graph,
}

impl<'a> System<'a> {
    /// For ℓ in mesh units.
    pub fn new(laplacian: &'a Laplacian, bending_length: f64) -> Self {
        let (rings, values) = rows(laplacian);
        let pattern = two_rings(&rings);
        let bending = bending_length * bending_length;
        Self { mass: &laplacian.mass, bending, rings, laplacian: values, pattern }
    }

    /// Where A has entries.
    pub fn pattern(&self) -> &Graph {
        &self.pattern
    }

    /// The entries of row `v`, in the pattern's order, in place of what was in `values`.
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
        for (m, c) in self.laplacian_row(v) {
            add(self.bending * c / self.mass[m as usize], m);
        }
        add(-1.0, v);
    }

    fn laplacian_row(&self, v: u32) -> impl Iterator<Item = (u32, f64)> {
        let range = self.rings.offsets[v as usize]..self.rings.offsets[v as usize + 1];
        self.rings.neighbors(v).iter().copied().zip(self.laplacian[range].iter().copied())
    }

    /// The rows and columns of `order`, in that order: `place[v]` is where `v` stands in it, or
    /// [`u32::MAX`].
    pub fn lower(&self, order: &[u32], place: &[u32]) -> Lower {
        let assemble = |(block, vertices): (usize, &[u32])| {
            let mut values = Vec::new();
            let mut entries = Vec::new();
            let mut part = Lower { offsets: Vec::new(), rows: Vec::new(), values: Vec::new() };
            for (i, &v) in vertices.iter().enumerate() {
                let column = (block * ROWS_AT_ONCE + i) as u32;
                self.row(v, &mut values);
                entries.clear();
                let rows = self.pattern.neighbors(v).iter().map(|&w| place[w as usize]);
                entries.extend(rows.zip(values.iter().copied()).filter(|&(row, _)| row >= column && row != u32::MAX));
                entries.sort_unstable_by_key(|e| e.0);
                part.rows.extend(entries.iter().map(|e| e.0));
                part.values.extend(entries.iter().map(|e| e.1));
                part.offsets.push(part.rows.len());
            }
            part
        };
        let parts: Vec<Lower> = order.par_chunks(ROWS_AT_ONCE).enumerate().map(assemble).collect();
        let mut whole = Lower { offsets: vec![0], rows: Vec::new(), values: Vec::new() };
        for part in parts {
            let first = whole.rows.len();
            whole.offsets.extend(part.offsets.iter().map(|offset| first + offset));
            whole.rows.extend(part.rows);
            whole.values.extend(part.values);
        }
        whole
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

/// The neighbours' neighbours, which with each vertex itself in its ring are its neighbours too.
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
