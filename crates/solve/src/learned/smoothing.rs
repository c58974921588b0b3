//! The smooth part of what the shell leaves of the examples (step 3 of the learned method).
use crate::cholesky::Factor;
use crate::dissection::{Dissection, dissect};
use crate::laplacian::Laplacian;
use crate::system::{NONE, System};
use rayon::prelude::*;
use rhytid_core::{Progress, Result};

/// Columns of the right-hand side that one thread solves for at a time.
const COLUMNS_AT_ONCE: usize = 16;

/// `Ŵ = (M_ff − (σ²/2) C_ff)⁻¹ M_ff W_f` at the vertices that are free: those of parts with a handle that are no handles
/// themselves. At handles it is 0; parts without a handle keep their W.
///
/// `residual` is W, V×P×3 in mesh units, and becomes Ŵ; σ is in mesh units; `driven[v]` says whether vertex v is in a part
/// with a handle.
///
/// # Errors
/// [`rhytid_core::Error::Input`] if the system is not positive definite in floating point,
/// [`rhytid_core::Error::Cancelled`].
pub(crate) fn smooth(
    rest: &[[f64; 3]],
    laplacian: Laplacian,
    handles: &[u32],
    driven: &[bool],
    sigma: f64,
    residual: &mut [[f64; 3]],
    progress: &dyn Progress,
) -> Result<()> {
    let width = 3 * residual.len() / rest.len().max(1);
    if width == 0 {
        return Ok(());
    }
    let mut free = driven.to_vec();
    for &v in handles {
        free[v as usize] = false;
        residual.as_flattened_mut()[v as usize * width..][..width].fill(0.0);
    }
    progress.step("smooth", 0, width as u64)?;
    let free: Vec<u32> = (0..rest.len() as u32).filter(|&v| free[v as usize]).collect();
    let system = System::smoothing(laplacian, sigma);
    let Dissection { order, root } = dissect(rest, system.pattern(), free);
    let factor = Factor::new(&system.lower(&order), &root, progress)?;
    let place = system.places(&order);

    let mut firsts: Vec<usize> = (0..width).step_by(COLUMNS_AT_ONCE).collect();
    let at_once = rayon::current_num_threads().min(firsts.len());
    let mut solved: Vec<Vec<f64>> = vec![Vec::new(); at_once];
    for firsts in firsts.chunks_mut(at_once) {
        progress.step("smooth", firsts[0] as u64, width as u64)?;
        let from = residual.as_flattened();
        solved.par_iter_mut().zip(firsts.par_iter()).for_each(|(x, &first)| {
            let k = COLUMNS_AT_ONCE.min(width - first);
            x.clear();
            for &v in &order {
                let mass = system.mass(v);
                x.extend(from[v as usize * width + first..][..k].iter().map(|w| mass * w));
            }
            factor.solve(x, k);
        });
        residual.as_flattened_mut().par_chunks_mut(width).zip(&place).filter(|(_, p)| **p != NONE).for_each(
            |(row, &place)| {
                for (x, &first) in solved.iter().zip(firsts.iter()) {
                    let k = COLUMNS_AT_ONCE.min(width - first);
                    row[first..][..k].copy_from_slice(&x[place as usize * k..][..k]);
                }
            },
        );
    }
    progress.step("smooth", width as u64, width as u64)
}
