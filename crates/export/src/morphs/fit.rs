//! Frames as combinations of n columns, so that no vertex is further than a bound from its place.
//!
//! Wanted is a matrix M = Q T of rank n (F×3V; Q: F×n, orthonormal, its first column constant; T: n×3V) within the
//! bound of Y, the centred positions, for each vertex of each frame. ADMM (Boyd et al. 2011, sections 5.1 and 9.1)
//! projects in turn onto the matrices near Y (each 3-vector for itself, pulled to the ball around its place) and onto
//! those of rank n (the leading directions), with multipliers U that remember how hard each 3-vector had to be pulled.
//! With Z the pulled M + U:
//!
//! `U ← M + U − Z`, `M ← rank n of Z − U`
//!
//! Only what is near the bound is pulled, so `Z − U` differs from M in few numbers, D. Vertices that are far from the
//! bound just follow Q meanwhile ([`super::active`] has the others); all are looked at every few iterations, those that
//! have come near the bound join, and nothing is returned before all vertices of all frames were found within it.

use super::active::{Active, improve};
use super::factors::{Fit, combine, distances, narrow};
use super::frames::{Centred, TASK};
use rayon::prelude::*;
use rhytid_core::Result;

/// Times that all vertices are looked at.
pub(super) const ROUNDS: usize = 16;
/// So many numbers of (vertex, frame) beyond the bound, foreseen for the last round, are too many to go on. The last
/// few go faster than those before them: where 6 were foreseen, the rank has succeeded after all.
const HOPELESS: f64 = 10.0;
/// Vertices with an error above this part of the bound are looked at in every iteration.
const NEAR: f32 = 0.75;
/// Memory for these, in bytes. If more vertices are beyond the bound, there are too few columns.
const ACTIVE_BYTES: usize = 1 << 30;

/// Improves a fit until it is within the bound; none if its number of columns does not seem to suffice. `tick` is
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

/// Whether too much will be left beyond the bound after all rounds if each takes away the part that the last two took.
/// Few numbers come and go, so that they may grow.
fn hopeless(history: &[usize]) -> bool {
    let &[.., before, _, now] = history else { return false };
    let (before, now) = (before as f64, now as f64);
    let left = ROUNDS - history.len();
    now * (now / before).min(1.0).powf(left as f64 / 2.0) > HOPELESS
}

/// Looks at all vertices.
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
            if error <= NEAR * bound && fit.pulls[vertex].is_empty() {
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
