//! Section 2: the large-scale basis, by one sparse Cholesky factorisation.
use super::cholesky::Factor;
use super::dissection::{Dissection, dissect};
use super::laplacian::Laplacian;
use super::system::System;
use crate::progress::step;
use crate::{Progress, Result};
use rayon::prelude::*;

/// Right-hand sides solved for by one thread at a time: enough for dense kernels, few enough to bound the memory.
const COLUMNS_AT_ONCE: usize = 16;

/// Marks a vertex without an entry in an index.
const NONE: u32 = u32::MAX;

/// B, V×H row-major. `driven[v]` says whether vertex v is in a component with a handle; rows of other vertices
/// are zero, rows of handles are the identity.
///
/// # Errors
/// [`Error::Input`] if the system is not positive definite in floating point, [`Error::Cancelled`].
pub fn basis(
    rest: &[[f64; 3]],
    laplacian: &Laplacian,
    handles: &[u32],
    driven: &[bool],
    bending_length: f64,
    progress: &dyn Progress,
) -> Result<Vec<f64>> {
    let vertices = driven.len();
    let count = handles.len();
    let mut basis = vec![0.0; vertices * count];
    let mut free = driven.to_vec();
    for (h, &v) in handles.iter().enumerate() {
        free[v as usize] = false;
        basis[v as usize * count + h] = 1.0;
    }
    let free: Vec<u32> = (0..vertices as u32).filter(|&v| free[v as usize]).collect();

    step(progress, "assemble", 0, 1)?;
    let system = System::new(laplacian, bending_length);
    let Dissection { order, root } = dissect(rest, system.pattern(), free);
    let mut place = vec![NONE; vertices];
    for (i, &v) in order.iter().enumerate() {
        place[v as usize] = i as u32;
    }
    let matrix = system.lower(&order, &place);
    step(progress, "assemble", 1, 1)?;
    let factor = Factor::new(&matrix, &root, progress)?;
    drop((matrix, root));

    // Each thread has one block of right-hand sides at a time, in memory that it used before.
    let mut blocks = vec![Vec::new(); rayon::current_num_threads().min(count.div_ceil(COLUMNS_AT_ONCE))];
    let at_once = blocks.len() * COLUMNS_AT_ONCE;
    for first in (0..count).step_by(at_once) {
        step(progress, "basis", first as u64, count as u64)?;
        let handles = &handles[first..count.min(first + at_once)];
        handles.par_chunks(COLUMNS_AT_ONCE).zip(&mut blocks).for_each(|(handles, x)| {
            right_hand_sides(&system, handles, &place, order.len(), x);
            factor.solve(x, handles.len());
        });
        let solved = || handles.chunks(COLUMNS_AT_ONCE).map(<[u32]>::len).zip(&blocks);
        basis.par_chunks_mut(count).zip(&place).filter(|(_, place)| **place != NONE).for_each(|(row, &place)| {
            let mut row = &mut row[first..];
            for (k, x) in solved() {
                let (to, rest) = row.split_at_mut(k);
                to.copy_from_slice(&x[place as usize * k..][..k]);
                row = rest;
            }
        });
    }
    step(progress, "basis", count as u64, count as u64)?;
    Ok(basis)
}

/// −A_fH for some of the handles: n×k, row-major.
fn right_hand_sides(system: &System, handles: &[u32], place: &[u32], n: usize, x: &mut Vec<f64>) {
    let k = handles.len();
    x.clear();
    x.resize(n * k, 0.0);
    let mut row = Vec::new();
    for (j, &h) in handles.iter().enumerate() {
        system.row(h, &mut row);
        for (&w, value) in system.pattern().neighbors(h).iter().zip(&row) {
            if place[w as usize] != NONE {
                x[place[w as usize] as usize * k + j] = -value;
            }
        }
    }
}
