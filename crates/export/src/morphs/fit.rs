//! Frames as combinations of n columns, so that no vertex is further than a bound from its place.
//!
//! Wanted is a matrix M = Q T of rank n. Q is F×n and orthonormal, and its first column is constant. T is
//! n×3V. With Y the centred positions, M has to be within the bound of Y for each vertex of each frame.
//!
//! ADMM (Boyd et al. 2011, sections 5.1 and 9.1) projects in turn onto two sets. The first is the matrices
//! near Y: each 3-vector is pulled to the ball around its own place. The second is the matrices of rank n:
//! the leading directions. Multipliers U remember how hard each 3-vector had to be pulled. With Z the pulled
//! M + U:
//!
//! `U ← M + U − Z`, `M ← rank n of Z − U`
//!
//! Only vectors near the bound are pulled, so `Z − U` differs from M in few numbers, D. Vertices far from the
//! bound just follow Q; [`super::active`] has the others. Every few iterations all vertices are examined, and
//! those that came near the bound join the active ones. A fit is returned only after all vertices of all
//! frames were found within the bound.

use super::active::{Active, improve};
use super::factors::{Fit, combine, distances, narrow};
use super::frames::{Centred, TASK};
use rayon::prelude::*;
use rhytid_core::Result;

/// How many times all vertices are examined.
pub(super) const ROUNDS: usize = 16;
/// The fit is given up if more than so many pairs of vertex and frame are foreseen beyond the bound after the
/// last round. The last few vanish faster than those before them: fits with 6 foreseen have still succeeded.
const HOPELESS: f64 = 10.0;
/// Vertices with an error above this part of the bound are active: every iteration works on them.
const NEAR: f32 = 0.75;
/// Memory for the active vertices, in bytes. If more vertices are beyond the bound, there are too few
/// columns.
const ACTIVE_BYTES: usize = 1 << 30;

/// Improves a fit until it is within the bound; `None` if its columns do not seem to suffice. `tick` is
/// called once a round.
///
/// # Errors
/// [`rhytid_core::Error::Io`], and what `tick` returns.
pub(super) fn fit(
    centred: &mut Centred<'_>,
    mut fit: Fit,
    bound: f64,
    tick: &mut dyn FnMut(usize) -> Result<()>,
) -> Result<Option<Fit>> {
    let bound = bound as f32;
    let mut history = Vec::new();
    for round in 0..ROUNDS {
        tick(round)?;
        let active = examine(centred, &fit, bound)?;
        if active.over == 0 {
            return Ok(Some(fit));
        }
        history.push(active.over);
        if !active.complete || hopeless(&history) {
            return Ok(None);
        }
        improve(&mut fit, &active, bound)?;
    }
    Ok(None)
}

/// Whether too many pairs will be beyond the bound after all rounds, if each round removes the same part as
/// the last two did. A small number may also grow for a while, which is not held against the fit.
fn hopeless(history: &[usize]) -> bool {
    let &[.., before, _, now] = history else { return false };
    let (before, now) = (before as f64, now as f64);
    let left = ROUNDS - history.len();
    now * (now / before).min(1.0).powf(left as f64 / 2.0) > HOPELESS
}

/// Examines all vertices and collects those near the bound.
fn examine(centred: &mut Centred<'_>, fit: &Fit, bound: f32) -> Result<Active> {
    let (f, n) = (fit.q.nrows(), fit.q.ncols());
    let q = narrow(&fit.q);
    let most = ACTIVE_BYTES / (24 * f);
    let mut active = Active { vertices: Vec::new(), y: Vec::new(), over: 0, complete: true };
    for first in centred.frames.blocks() {
        let block = centred.block(first)?;
        let found: Vec<Vec<(f32, usize)>> = block
            .values
            .par_chunks(3 * TASK * f)
            .zip(fit.t[3 * first * n..].par_chunks(3 * TASK * n))
            .map(|(y, t)| {
                let mut squares = vec![0.0; f];
                let m = combine(&q, &t[..y.len() / f * n]);
                let largest = |(y, m)| {
                    distances(y, m, &mut squares);
                    let most = squares.iter().fold(0.0, |most: f32, &square| most.max(square)).sqrt();
                    (most, squares.iter().filter(|&&square| square > bound * bound).count())
                };
                y.chunks(3 * f).zip(m.chunks(3 * f)).map(largest).collect()
            })
            .collect();
        let vertices = found.into_iter().flatten().zip(block.values.chunks_exact(3 * f));
        for (vertex, ((error, over), y)) in (first..).zip(vertices) {
            active.over += over;
            if error <= NEAR * bound && fit.multipliers[vertex].is_empty() {
                continue;
            }
            if active.vertices.len() >= most {
                active.complete &= over == 0;
                continue;
            }
            active.vertices.push(vertex);
            active.y.extend(y);
        }
    }
    Ok(active)
}

/// The largest distance of a vertex from its place in any frame.
///
/// # Errors
/// [`rhytid_core::Error::Io`].
pub(super) fn worst(centred: &mut Centred<'_>, fit: &Fit) -> Result<f64> {
    let (f, n) = (fit.q.nrows(), fit.q.ncols());
    let q = narrow(&fit.q);
    let mut worst = 0.0_f32;
    for first in centred.frames.blocks() {
        let block = centred.block(first)?;
        let found =
            block.values.par_chunks(3 * TASK * f).zip(fit.t[3 * first * n..].par_chunks(3 * TASK * n));
        let largest = found.map(|(y, t)| {
            let mut squares = vec![0.0; f];
            let m = combine(&q, &t[..y.len() / f * n]);
            let most = |(y, m)| {
                distances(y, m, &mut squares);
                squares.iter().fold(0.0, |most: f32, &square| most.max(square))
            };
            y.chunks(3 * f).zip(m.chunks(3 * f)).map(most).fold(0.0, f32::max)
        });
        worst = worst.max(largest.reduce(|| 0.0, f32::max));
    }
    Ok(f64::from(worst).sqrt())
}
