//! The least number of targets for which a fit is found.

use super::factors::Fit;
use super::fit;
use super::frames::{Centred, Frames, Gram};
use super::linear::Eigen;
use rhytid_core::{Progress, Result};

/// The search starts with so many principal components that their mean error is this part of the bound. The
/// worst vertex of a face is some ten times worse than the mean, and a fit to the worst vertices gains a
/// little on that.
const FIRST_GUESS: f64 = 0.15;

/// Fits that the search is expected to take, for progress reports.
const FITS: usize = 8;

/// The numbers of targets that are tried.
#[derive(Clone, Copy)]
pub(super) struct Numbers {
    /// Fewer are known to be too few.
    pub least: usize,
    pub most: usize,
    /// The search stops when it has at most this part more targets than it needs; 0 to have none too many.
    pub spare: f64,
}

/// Searches for the least number of targets that suffices; `None` if `most` do not suffice.
///
/// The search goes in growing steps from `least`, or from a first guess if `least` is 0, until it has a
/// number that suffices and one that does not. Then it bisects. The first fits start from principal
/// components. Once a number suffices, each fit starts from the smallest fit that sufficed, less its last
/// columns.
///
/// # Errors
/// As [`fit::fit`]; [`rhytid_core::Error::Cancelled`].
pub(super) fn fewest(
    frames: &mut Frames,
    gram: &Gram,
    start: &Eigen,
    bound: f64,
    numbers: Numbers,
    progress: &dyn Progress,
) -> Result<Option<Fit>> {
    const NAME: &str = "find morph targets";
    let mut least = numbers.least;
    let most = numbers.most.min(start.vectors.ncols() - 1);
    let total = FITS * fit::ROUNDS;
    let mut fits = 0;
    let mut centred = Centred::new(frames, gram);
    let mut attempt = |targets: usize, best: Option<&Fit>| {
        let before = fits * fit::ROUNDS;
        fits += 1;
        let mut tick =
            |round: usize| progress.step(NAME, (before + round).min(total - 1) as u64, total as u64);
        let from = match best {
            Some(best) => best.first(targets + 1),
            None => Fit::on(centred.frames, gram, start.vectors.subcols(0, targets + 1).to_owned())?,
        };
        let found = fit::fit(&mut centred, from, bound, &mut tick)?;
        log::debug!("{targets} morph targets: {}", if found.is_some() { "enough" } else { "too few" });
        Ok::<_, rhytid_core::Error>(found)
    };
    let first = if least > 0 { least } else { guess(gram, start, bound) };
    let mut next = first.min(most);
    let mut stride = if least > 0 { 2 } else { (next / 12).max(1) };
    let mut best: Option<(usize, Fit)> = None;
    // All numbers below `least` are too few.
    loop {
        match attempt(next, best.as_ref().map(|best| &best.1))? {
            Some(found) => best = Some((next, found)),
            None => least = next + 1,
        }
        let enough = best.as_ref().map(|best| best.0);
        next = match enough {
            Some(enough) if enough <= least + (numbers.spare * enough as f64) as usize => break,
            None if least > most => break,
            None => most.min(next + stride),
            Some(enough) if least == 0 => enough.saturating_sub(stride),
            Some(enough) => least.midpoint(enough),
        };
        stride *= 2;
    }
    progress.step(NAME, total as u64, total as u64)?;
    Ok(best.map(|best| best.1))
}

/// The most bounds that are tried for one number of targets.
const BOUNDS: usize = 8;
/// The search stops when the least bound met is less than this times the largest bound missed.
pub(super) const CLOSE: f64 = 1.04;

/// The first bound that is tried, as a part of the error of the principal components.
const FIRST_BOUND: f64 = 0.5;

/// The least bound found that so many targets meet, in mesh units, and a fit within that bound.
///
/// Without `near`, the first bound is [`FIRST_BOUND`] times the error of as many principal components. Until
/// a bound is missed, each further one is this part of the last error met. Then it is the geometric mean of
/// the last error met and the last bound missed. With `near`, this is the first bound, and bounds [`CLOSE`]
/// below it are known to be missed.
///
/// # Errors
/// As [`fit::fit`]; [`rhytid_core::Error::Cancelled`].
pub(super) fn nearest(
    frames: &mut Frames,
    gram: &Gram,
    start: &Eigen,
    targets: usize,
    near: Option<f64>,
    progress: &dyn Progress,
) -> Result<(Fit, f64)> {
    const NAME: &str = "fit morph targets";
    let columns = start.vectors.ncols().min(targets.saturating_add(1));
    let mut best = Fit::on(frames, gram, start.vectors.subcols(0, columns).to_owned())?;
    let mut centred = Centred::new(frames, gram);
    let mut met = fit::worst(&mut centred, &best)?;
    let mut missed = near.map_or(0.0, |near| near / CLOSE);
    let total = (BOUNDS * fit::ROUNDS) as u64;
    // With all columns, the only error is that of rounding.
    let tries = if columns == start.vectors.ncols() || met == 0.0 { 0 } else { BOUNDS };
    for i in 0..tries {
        let bound = match near {
            Some(near) if i == 0 => near,
            _ if missed > 0.0 => (met * missed).sqrt(),
            _ => FIRST_BOUND * met,
        };
        let mut tick = |round: usize| progress.step(NAME, (i * fit::ROUNDS + round) as u64, total);
        match fit::fit(&mut centred, best.clone(), bound, &mut tick)? {
            Some(found) => {
                met = fit::worst(&mut centred, &found)?;
                best = found;
            }
            None => missed = bound,
        }
        log::debug!("{targets} morph targets: within {met:.3e}, not within {missed:.3e}");
        if met < CLOSE * missed {
            break;
        }
    }
    progress.step(NAME, total, total)?;
    Ok((best, met))
}

/// The number of principal components that leave a mean error of [`FIRST_GUESS`] times the bound.
fn guess(gram: &Gram, start: &Eigen, bound: f64) -> usize {
    let frames = gram.matrix.nrows();
    let allowed = (FIRST_GUESS * bound).powi(2) * frames as f64 * gram.moving as f64;
    let mut left = 0.0;
    for (k, value) in start.values.iter().enumerate().rev() {
        left += value.max(0.0);
        if left > allowed {
            return k + 1;
        }
    }
    0
}
