//! Section 2: the large-scale basis, by one sparse Cholesky factorisation.
use crate::points;
use crate::system::{NONE, System};
use rayon::prelude::*;
use rhytid_core::{Progress, Result, SurfacePoint, Table};
use rhytid_geometry::cholesky::Columns;
use rhytid_geometry::cholesky::Dissection;
use rhytid_geometry::cholesky::Factor;
use rhytid_geometry::cholesky::dissect;
use rhytid_geometry::laplacian::Laplacian;

/// The number of right-hand sides that one thread solves for at a time: enough for dense kernels, and few
/// enough to bound the memory.
const COLUMNS_AT_ONCE: usize = 16;

/// B, V×H. `moves[v]` says whether vertex v is in a component with a handle and no pin; rows of other
/// vertices are zero. At each handle, the basis is the identity: in the row of its vertex or, inside a
/// triangle, in the mean of the rows of its corners.
///
/// # Errors
/// [`rhytid_core::Error::Input`] if the system is not positive definite in floating point,
/// [`rhytid_core::Error::Cancelled`].
pub fn basis(
    rest: &[[f64; 3]],
    laplacian: Laplacian,
    handles: &[SurfacePoint],
    moves: &[bool],
    bending_length: f64,
    progress: &dyn Progress,
) -> Result<Table<f64>> {
    let vertices = moves.len();
    let held = points::held(handles);
    let mut basis = Table::filled(vertices, held.len(), 0.0);
    let mut free = moves.to_vec();
    for (i, v) in held.iter().enumerate() {
        free[v.index()] = false;
        basis.row_mut(v.index())[i] = 1.0;
    }
    let free: Vec<u32> = (0..vertices as u32).filter(|&v| free[v as usize]).collect();

    progress.step("assemble", 0, 1)?;
    let system = System::new(laplacian, bending_length);
    let Dissection { order, root } = dissect(rest, system.pattern(), free);
    let matrix = system.lower(&order);
    progress.step("assemble", 1, 1)?;
    let factor = Factor::new(&matrix, &root, progress)?;
    drop((matrix, root));
    solve_columns(&system, &factor, &order, &system.right(&order, &held), &mut basis, progress)?;
    if handles.iter().all(|point| point.vertex().is_some()) {
        return Ok(basis);
    }
    points::from_vertices_to_points(&system, &factor, &order, &held, handles, &basis, progress)
}

/// A_ff⁻¹ times the columns of `right`, into the rows of `order` of `solution`, V×n.
///
/// # Errors
/// [`rhytid_core::Error::Cancelled`].
pub fn solve_columns(
    system: &System,
    factor: &Factor,
    order: &[u32],
    right: &Columns,
    solution: &mut Table<f64>,
    progress: &dyn Progress,
) -> Result<()> {
    let count = solution.columns();
    let place = system.places(order);
    // Each thread has one block of right-hand sides at a time, and uses its memory again.
    let mut blocks = vec![Vec::new(); rayon::current_num_threads().min(count.div_ceil(COLUMNS_AT_ONCE))];
    let at_once = blocks.len() * COLUMNS_AT_ONCE;
    for first in (0..count).step_by(at_once.max(1)) {
        progress.step("basis", first as u64, count as u64)?;
        let end = count.min(first + at_once);
        let width = |block: usize| COLUMNS_AT_ONCE.min(end - first - block * COLUMNS_AT_ONCE);
        blocks.truncate((end - first).div_ceil(COLUMNS_AT_ONCE));
        blocks.par_iter_mut().enumerate().for_each(|(block, x)| {
            let k = width(block);
            x.clear();
            x.resize(order.len() * k, 0.0);
            for j in 0..k {
                let (rows, values) = right.column(first + block * COLUMNS_AT_ONCE + j);
                for (&row, &value) in rows.iter().zip(values) {
                    x[row as usize * k + j] = value;
                }
            }
            factor.solve(x, k);
        });
        let rows = solution.par_rows_mut().zip(&place).filter(|(_, place)| **place != NONE);
        rows.for_each(|(row, &place)| {
            for (block, (x, row)) in
                blocks.iter().zip(row[first..end].chunks_mut(COLUMNS_AT_ONCE)).enumerate()
            {
                let k = width(block);
                row.copy_from_slice(&x[place as usize * k..][..k]);
            }
        });
    }
    progress.step("basis", count as u64, count as u64)
}
