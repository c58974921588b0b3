//! Sparse Cholesky factorisation of section 2's system along the tree of a dissection: the multifrontal
//! method.
//!
//! The columns of a part are eliminated together, in one dense matrix, the front of the part. The front has
//! their own entries of A and the updates from the two halves below. So all arithmetic is dense, and parts
//! that share nothing are eliminated at the same time. No order of a sum depends on the number of threads.
use super::columns::Columns;
use super::dissection::Part;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::{matmul, triangular};
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par};
use rhytid_core::{Error, Progress, Result};
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// Parts of more columns than this are eliminated by several threads.
const WORTH_A_THREAD: usize = 4096;

/// Rows of a front that one thread computes at a time.
const ROWS_AT_ONCE: usize = 192;

/// L of A = L Lᵀ, as a tree: the columns of one part of the dissection, which all have their entries in the
/// same rows.
#[derive(Debug, Clone)]
pub struct Factor {
    columns: Range<usize>,
    /// The rows below the columns' own, ascending.
    rows: Vec<u32>,
    /// Column-major: the columns' own rows, of which the lower triangle counts, then `rows`.
    panel: Vec<f64>,
    halves: Option<Box<[Factor; 2]>>,
}

impl Factor {
    /// Factorises `matrix`, whose columns are in the order of the dissection `root` is from.
    ///
    /// # Errors
    /// [`Error::Input`] if the matrix is not positive definite in floating point, [`Error::Cancelled`].
    pub fn new(matrix: &Columns, root: &Part, progress: &dyn Progress) -> Result<Self> {
        let elimination = Elimination {
            matrix,
            progress,
            total: whole_cost(root),
            done: AtomicU64::new(0),
            stacks: Mutex::default(),
        };
        progress.step(STEP, 0, elimination.total)?;
        let (factor, _) = elimination.part(root)?;
        Ok(factor)
    }

    /// Entries stored, zeros among them.
    pub fn entries(&self) -> usize {
        self.panel.len() + self.halves().map(Self::entries).sum::<usize>()
    }

    /// Solves `A x = b` for k right-hand sides: `x`, n×k row-major, holds b before and x after. A right-hand
    /// side with few entries is solved for in little more than half the time.
    pub fn solve(&self, x: &mut [f64], k: usize) {
        let mut scratch = Vec::new();
        self.forward(x, k, &mut scratch);
        self.backward(x, k, &mut scratch);
    }

    fn halves(&self) -> impl DoubleEndedIterator<Item = &Self> {
        self.halves.iter().flat_map(|halves| halves.iter())
    }

    /// The columns' own triangle and the rows below.
    fn panel(&self) -> (MatRef<'_, f64>, MatRef<'_, f64>) {
        let n = self.columns.len();
        MatRef::from_column_major_slice(&self.panel, n + self.rows.len(), n).split_at_row(n)
    }

    fn forward(&self, x: &mut [f64], k: usize, scratch: &mut Vec<f64>) {
        self.halves().for_each(|half| half.forward(x, k, scratch));
        let own = &mut x[self.columns.start * k..self.columns.end * k];
        if own.iter().all(|&b| b == 0.0) {
            return;
        }
        let (top, bottom) = self.panel();
        let mut own = MatMut::from_row_major_slice_mut(own, self.columns.len(), k);
        solve_lower_triangular_in_place(top, own.rb_mut(), Par::Seq);
        scratch.resize(self.rows.len() * k, 0.0);
        let taken = MatMut::from_row_major_slice_mut(scratch, self.rows.len(), k);
        matmul(taken, Accum::Replace, bottom, own.rb(), 1.0, Par::Seq);
        for (&row, taken) in self.rows.iter().zip(scratch.chunks_exact(k)) {
            for (x, t) in x[row as usize * k..][..k].iter_mut().zip(taken) {
                *x -= t;
            }
        }
    }

    fn backward(&self, x: &mut [f64], k: usize, scratch: &mut Vec<f64>) {
        let (top, bottom) = self.panel();
        scratch.resize(self.rows.len() * k, 0.0);
        for (&row, known) in self.rows.iter().zip(scratch.chunks_exact_mut(k)) {
            known.copy_from_slice(&x[row as usize * k..][..k]);
        }
        let known = MatRef::from_row_major_slice(scratch, self.rows.len(), k);
        let own = &mut x[self.columns.start * k..self.columns.end * k];
        let mut own = MatMut::from_row_major_slice_mut(own, self.columns.len(), k);
        matmul(own.rb_mut(), Accum::Add, bottom.transpose(), known, -1.0, Par::Seq);
        solve_upper_triangular_in_place(top.transpose(), own, Par::Seq);
        self.halves().rev().for_each(|half| half.backward(x, k, scratch));
    }
}

/// The name of a factorisation in progress reports.
const STEP: &str = "factorise";

/// The approximate cost of eliminating the columns of a part alone, in an arbitrary unit.
fn cost(part: &Part) -> u64 {
    let n = part.columns.len() as u64;
    n.saturating_pow(3).saturating_add(4096 * n)
}

/// The cost of a part and of all parts below it.
fn whole_cost(part: &Part) -> u64 {
    let halves = part.halves.iter().flat_map(|halves| halves.iter());
    halves.map(whole_cost).fold(cost(part), u64::saturating_add)
}

/// The update from the eliminated columns of a part, which is subtracted from the rows below: the lower
/// triangle of a square, column-major.
type Update = Vec<f64>;

struct Elimination<'a> {
    matrix: &'a Columns,
    progress: &'a dyn Progress,
    total: u64,
    done: AtomicU64,
    /// Memory for updates, which is reused: memory fresh from the system is slow.
    stacks: Mutex<Vec<Vec<f64>>>,
}

impl Elimination<'_> {
    fn part(&self, part: &Part) -> Result<(Factor, Update)> {
        match &part.halves {
            Some(halves) if part.places.len() > WORTH_A_THREAD => self.large_part(part, halves),
            _ => self.small_part(part),
        }
    }

    fn large_part(&self, part: &Part, [left, right]: &[Part; 2]) -> Result<(Factor, Update)> {
        let (left, right) = rayon::join(|| self.part(left), || self.part(right));
        let ((left, left_update), (right, right_update)) = (left?, right?);
        let halves = Box::new([left, right]);
        let rows = self.rows(part, &*halves);
        let mut update = zeros(rows.len() * rows.len());
        let panel = self.front(part, &rows, &*halves, &[&left_update, &right_update], &mut update)?;
        self.report(cost(part))?;
        Ok((Factor { columns: part.columns.clone(), rows, panel, halves: Some(halves) }, update))
    }

    /// Also all parts below, by this thread.
    fn small_part(&self, part: &Part) -> Result<(Factor, Update)> {
        let stacks = || self.stacks.lock().unwrap_or_else(PoisonError::into_inner);
        let mut stack = stacks().pop().unwrap_or_default();
        let factor = self.on_stack(part, &mut stack)?;
        let update = stack.clone();
        stack.clear();
        stacks().push(stack);
        self.report(whole_cost(part))?;
        Ok((factor, update))
    }

    /// Leaves its update on the stack.
    fn on_stack(&self, part: &Part, stack: &mut Vec<f64>) -> Result<Factor> {
        let first = stack.len();
        let halves = match part.halves.as_deref() {
            Some([left, right]) => {
                let left = self.on_stack(left, stack)?;
                Some(Box::new([left, self.on_stack(right, stack)?]))
            }
            None => None,
        };
        let below = halves.as_deref().map_or(&[][..], |halves| halves);
        let rows = self.rows(part, below);
        let last = stack.len();
        stack.resize(last + rows.len() * rows.len(), 0.0);
        let (theirs, update) = stack[first..].split_at_mut(last - first);
        let (left, right) = theirs.split_at(below.first().map_or(0, |left| left.rows.len().pow(2)));
        let panel = self.front(part, &rows, below, &[left, right], update)?;
        stack.copy_within(last.., first);
        stack.truncate(first + rows.len() * rows.len());
        Ok(Factor { columns: part.columns.clone(), rows, panel, halves })
    }

    /// The rows below a part's columns in which the columns have entries: those of A, and those of the parts
    /// below.
    fn rows(&self, part: &Part, halves: &[Factor]) -> Vec<u32> {
        let mut rows: Vec<u32> =
            part.columns.clone().flat_map(|j| self.matrix.column(j).0).copied().collect();
        rows.extend(halves.iter().flat_map(|half| &half.rows));
        rows.retain(|&row| row as usize >= part.columns.end);
        rows.sort_unstable();
        rows.dedup();
        rows.shrink_to_fit();
        rows
    }

    /// Eliminates the columns of one part. `update` is zero before.
    fn front(
        &self,
        part: &Part,
        rows: &[u32],
        halves: &[Factor],
        updates: &[&[f64]; 2],
        update: &mut [f64],
    ) -> Result<Vec<f64>> {
        let n = part.columns.len();
        let height = n + rows.len();
        let mut panel = zeros(height * n);
        let mut places = Vec::new();
        for (j, column) in part.columns.clone().zip(panel.chunks_exact_mut(height.max(1))) {
            let (entries, values) = self.matrix.column(j);
            find(entries, &part.columns, rows, &mut places);
            for (&place, value) in places.iter().zip(values) {
                column[place] = *value;
            }
        }
        for (half, theirs) in halves.iter().zip(updates) {
            find(&half.rows, &part.columns, rows, &mut places);
            for (j, column) in theirs.chunks_exact(places.len().max(1)).enumerate() {
                let (own, first) = match places[j].checked_sub(n) {
                    None => (&mut panel[places[j] * height..][..height], 0),
                    Some(j) => (&mut update[j * rows.len()..][..rows.len()], n),
                };
                for (&place, value) in places[j..].iter().zip(&column[j..]) {
                    own[place - first] += value;
                }
            }
        }
        let (mut top, mut bottom) =
            MatMut::from_column_major_slice_mut(&mut panel, height, n).split_at_row_mut(n);
        let mut memory = MemBuffer::new(cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default()));
        let (stack, settings) = (MemStack::new(&mut memory), Default::default());
        cholesky_in_place(top.rb_mut(), Default::default(), Par::Seq, stack, settings).map_err(|e| {
            Error::not_solvable(format!(
                "the large-scale system cannot be factorised ({e:?}): some triangles are too thin for float64; \
                 run the doctor and mend what it names, or choose a smaller bending_length"
            ))
        })?;
        solve_rows(top.rb(), bottom.rb_mut());
        let update = MatMut::from_column_major_slice_mut(update, rows.len(), rows.len());
        subtract_square(bottom.rb(), update);
        Ok(panel)
    }

    fn report(&self, cost: u64) -> Result<()> {
        let done = self.done.fetch_add(cost, Ordering::Relaxed) + cost;
        self.progress.step(STEP, done, self.total)
    }
}

/// Memory that is written before it is read: fresh zeros, read first, would be mapped twice.
fn zeros(len: usize) -> Vec<f64> {
    let mut zeros = Vec::with_capacity(len);
    zeros.resize(len, 0.0);
    zeros
}

/// Where each of the ascending `wanted` stands in a front of `columns` and the `rows` below, which hold them
/// all.
fn find(wanted: &[u32], columns: &Range<usize>, rows: &[u32], places: &mut Vec<usize>) {
    let mut at = 0;
    places.clear();
    places.extend(wanted.iter().map(|&row| {
        if (row as usize) < columns.end {
            return row as usize - columns.start;
        }
        while rows[at] < row {
            at += 1;
        }
        columns.len() + at
    }));
}

/// Turns the rows B below the columns' own triangle A = L Lᵀ into the rows of L: B L⁻ᵀ.
fn solve_rows(triangle: MatRef<'_, f64>, rows: MatMut<'_, f64>) {
    if rows.nrows() <= ROWS_AT_ONCE {
        return solve_lower_triangular_in_place(triangle, rows.transpose_mut(), Par::Seq);
    }
    let half = rows.nrows() / 2;
    let (upper, lower) = rows.split_at_row_mut(half);
    rayon::join(|| solve_rows(triangle, upper), || solve_rows(triangle, lower));
}

/// Subtracts the lower triangle of `rows rowsᵀ`.
fn subtract_square(rows: MatRef<'_, f64>, from: MatMut<'_, f64>) {
    use triangular::BlockStructure::{Rectangular, TriangularLower};
    if rows.nrows() <= ROWS_AT_ONCE {
        let (whole, transposed) = (Rectangular, rows.transpose());
        return triangular::matmul(
            from,
            TriangularLower,
            Accum::Add,
            rows,
            whole,
            transposed,
            whole,
            -1.0,
            Par::Seq,
        );
    }
    let half = rows.nrows() / 2;
    let (upper, lower) = rows.split_at_row(half);
    let (corner, _, below, rest) = from.split_at_mut(half, half);
    rayon::join(
        || rayon::join(|| subtract_square(upper, corner), || subtract_square(lower, rest)),
        || subtract_product(lower, upper, below),
    );
}

/// Subtracts `a bᵀ`.
fn subtract_product(a: MatRef<'_, f64>, b: MatRef<'_, f64>, from: MatMut<'_, f64>) {
    if a.nrows() <= 2 * ROWS_AT_ONCE {
        return matmul(from, Accum::Add, a, b.transpose(), -1.0, Par::Seq);
    }
    let half = a.nrows() / 2;
    let (upper, lower) = a.split_at_row(half);
    let (from_upper, from_lower) = from.split_at_row_mut(half);
    rayon::join(|| subtract_product(upper, b, from_upper), || subtract_product(lower, b, from_lower));
}
