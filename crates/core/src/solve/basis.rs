//! Section 2: the large-scale basis, by one sparse Cholesky factorisation.
use super::laplacian::Laplacian;
use crate::progress::step;
use crate::{Error, Progress, Result};
use faer::linalg::solvers::SolveCore;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Conj, Mat, Side};
use rayon::prelude::*;

/// Right-hand sides solved for at once: enough for dense kernels, few enough to bound the memory.
const COLUMNS_AT_ONCE: usize = 16;

/// Marks a vertex without an entry in an index.
const NONE: u32 = u32::MAX;

/// Rows of C with their diagonals, columns ascending.
struct Rows {
    offsets: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl Rows {
    fn new(laplacian: &Laplacian) -> Self {
        let vertices = laplacian.diagonal.len();
        let mut offsets = vec![0; vertices + 1];
        for v in 0..vertices {
            offsets[v + 1] = 1;
        }
        for &(a, b, _) in &laplacian.edges {
            offsets[a as usize + 1] += 1;
            offsets[b as usize + 1] += 1;
        }
        for v in 0..vertices {
            offsets[v + 1] += offsets[v];
        }
        let mut next = offsets.clone();
        let mut columns = vec![0; offsets[vertices]];
        let mut values = vec![0.0; offsets[vertices]];
        let mut put = |row: u32, column: u32, value: f64| {
            let at = &mut next[row as usize];
            columns[*at] = column;
            values[*at] = value;
            *at += 1;
        };
        // Edges are sorted by (a, b), so the three passes leave every row ascending.
        for &(a, b, w) in &laplacian.edges {
            put(b, a, w);
        }
        for v in 0..vertices {
            put(v as u32, v as u32, laplacian.diagonal[v]);
        }
        for &(a, b, w) in &laplacian.edges {
            put(a, b, w);
        }
        Self { offsets, columns, values }
    }

    fn row(&self, v: usize) -> impl Iterator<Item = (usize, f64)> {
        let range = self.offsets[v]..self.offsets[v + 1];
        self.columns[range.clone()].iter().map(|&c| c as usize).zip(self.values[range].iter().copied())
    }
}

/// One free vertex' part of A = −k_s C + k_b C M⁻¹ C with k_s = 1 and k_b = ℓ².
struct Column {
    /// Rows at and below the diagonal, as free indices, ascending, with their entries of A_ff.
    lower: Vec<(usize, f64)>,
    /// Handles with their entries of A_fH.
    handles: Vec<(u32, f64)>,
}

/// B, V×H row-major. `driven[v]` says whether vertex v is in a component with a handle; rows of other vertices
/// are zero, rows of handles are the identity.
///
/// # Errors
/// [`Error::Input`] if the system is not positive definite in floating point, [`Error::Cancelled`].
pub fn basis(
    laplacian: &Laplacian,
    handles: &[u32],
    driven: &[bool],
    bending_length: f64,
    progress: &dyn Progress,
) -> Result<Vec<f64>> {
    let vertices = driven.len();
    let mut free_index = vec![NONE; vertices];
    let mut handle_index = vec![NONE; vertices];
    let mut basis = vec![0.0; vertices * handles.len()];
    for (h, &v) in handles.iter().enumerate() {
        handle_index[v as usize] = h as u32;
        basis[v as usize * handles.len() + h] = 1.0;
    }
    let free: Vec<usize> = (0..vertices).filter(|&v| driven[v] && handle_index[v] == NONE).collect();
    for (i, &v) in free.iter().enumerate() {
        free_index[v] = i as u32;
    }
    if free.is_empty() {
        return Ok(basis);
    }

    step(progress, "assemble", 0, 1)?;
    let rows = Rows::new(laplacian);
    let bending = bending_length * bending_length;
    let columns: Vec<Column> = free
        .par_iter()
        .map_init(
            || vec![0.0; vertices],
            |sums, &v| assemble(v, &rows, laplacian, bending, (&free_index, &handle_index), sums),
        )
        .collect();
    step(progress, "assemble", 1, 1)?;

    step(progress, "factorise", 0, 2)?;
    let matrix = lower_triangle(&columns);
    let symbolic = SymbolicLlt::try_new(matrix.symbolic(), Side::Lower)
        .map_err(|e| Error::Internal(format!("the symbolic factorisation failed: {e:?}")))?;
    step(progress, "factorise", 1, 2)?;
    let factor = Llt::try_new_with_symbolic(symbolic, matrix.as_ref(), Side::Lower).map_err(|e| {
        Error::input(format!(
            "the large-scale system cannot be factorised ({e:?}): some triangles are too thin for float64; \
             run the doctor and mend what it names, or choose a smaller bending_length"
        ))
    })?;
    drop(matrix);
    step(progress, "factorise", 2, 2)?;

    let total = handles.len() as u64;
    for first in (0..handles.len()).step_by(COLUMNS_AT_ONCE) {
        step(progress, "basis", first as u64, total)?;
        let count = COLUMNS_AT_ONCE.min(handles.len() - first);
        let mut rhs = Mat::<f64>::zeros(free.len(), count);
        for (i, column) in columns.iter().enumerate() {
            for &(h, value) in &column.handles {
                if (first..first + count).contains(&(h as usize)) {
                    rhs[(i, h as usize - first)] = -value;
                }
            }
        }
        factor.solve_in_place_with_conj(Conj::No, rhs.as_mut());
        for (i, &v) in free.iter().enumerate() {
            for j in 0..count {
                basis[v * handles.len() + first + j] = rhs[(i, j)];
            }
        }
    }
    step(progress, "basis", total, total)?;
    Ok(basis)
}

/// The part of A that belongs to the free vertex `v`. `sums` is all zero before and after.
fn assemble(
    v: usize,
    rows: &Rows,
    laplacian: &Laplacian,
    bending: f64,
    (free_index, handle_index): (&[u32], &[u32]),
    sums: &mut [f64],
) -> Column {
    let mut touched = Vec::new();
    for (m, c_vm) in rows.row(v) {
        let scale = bending * c_vm / laplacian.mass[m];
        for (w, c_mw) in rows.row(m) {
            touched.push(w);
            sums[w] += scale * c_mw;
        }
    }
    for (w, c_vw) in rows.row(v) {
        sums[w] -= c_vw;
    }
    touched.sort_unstable();
    touched.dedup();
    let mut column = Column { lower: Vec::new(), handles: Vec::new() };
    for w in touched {
        let value = std::mem::take(&mut sums[w]);
        if handle_index[w] != NONE {
            column.handles.push((handle_index[w], value));
        } else if w >= v {
            column.lower.push((free_index[w] as usize, value));
        }
    }
    column
}

fn lower_triangle(columns: &[Column]) -> SparseColMat<usize, f64> {
    let mut offsets = vec![0];
    let mut rows = Vec::new();
    let mut values = Vec::new();
    for column in columns {
        rows.extend(column.lower.iter().map(|e| e.0));
        values.extend(column.lower.iter().map(|e| e.1));
        offsets.push(rows.len());
    }
    let symbolic = SymbolicSparseColMat::new_checked(columns.len(), columns.len(), offsets, None, rows);
    SparseColMat::new(symbolic, values)
}
