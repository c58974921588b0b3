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
//! Only vectors near the bound are pulled, so `Z − U` differs from M in few numbers, D. Vectors far from the
//! bound just follow Q; [`super::active`] has the others. Every few iterations all vertices of all frames are
//! examined, and those that came near the bound join the active ones. A fit is returned only after all of
//! them were found within the bound.

use super::active::{Active, ActiveVertex, Place, improve};
use super::factors::{Fit, Multiplier, combine, distances, narrow};
use super::frames::{Centred, TASK};
use glam::Vec3;
use pulp::Arch;
use rayon::prelude::*;
use rhytid_core::Result;

/// How many times all vertices are examined.
pub(super) const ROUNDS: usize = 16;
/// The fit is given up if more than so many pairs of vertex and frame are foreseen beyond the bound after the
/// last round. The last few vanish faster than those before them: fits with 6 foreseen have still succeeded.
const HOPELESS: f64 = 10.0;
/// A vertex is active in the frames with an error above this part of the bound: every iteration looks there.
const NEAR: f32 = 0.6;
/// Memory for what is active, in bytes. If more is beyond the bound, there are too few columns.
const ACTIVE_BYTES: usize = 1 << 28;

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
        improve(&mut fit, active, bound)?;
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

/// Examines all vertices and collects what is near the bound.
fn examine(centred: &mut Centred<'_>, fit: &Fit, bound: f32) -> Result<Active> {
    let (f, n) = (fit.q.nrows(), fit.q.ncols());
    let q = narrow(&fit.q);
    let mut memory = ACTIVE_BYTES;
    let mut active = Active { vertices: Vec::new(), over: 0, complete: true };
    let arch = Arch::new();
    for first in centred.frames.blocks() {
        let block = centred.block(first)?;
        let found: Vec<Vec<Found>> = block
            .values
            .par_chunks(3 * TASK * f)
            .zip(fit.t[3 * first * n..].par_chunks(3 * TASK * n))
            .zip(fit.multipliers[first..].par_chunks(TASK))
            .map(|((y, t), multipliers)| {
                let mut squares = vec![0.0; f];
                let m = combine(&q, &t[..y.len() / f * n]);
                let look = |((y, m), multipliers): ((&[f32], &[f32]), &Vec<Multiplier>)| {
                    let largest = distances(arch, y, m, &mut squares);
                    Found::new(y, &squares, largest, multipliers, bound)
                };
                y.chunks(3 * f).zip(m.chunks(3 * f)).zip(multipliers).map(look).collect()
            })
            .collect();
        for (vertex, Found { over, places }) in (first..).zip(found.into_iter().flatten()) {
            active.over += over;
            if places.is_empty() {
                continue;
            }
            match memory.checked_sub(places.len() * size_of::<Place>()) {
                Some(left) => {
                    memory = left;
                    active.vertices.push(ActiveVertex { vertex, places });
                }
                None => active.complete &= over == 0,
            }
        }
    }
    Ok(active)
}

/// What is found of a vertex.
struct Found {
    /// In how many frames it is beyond the bound.
    over: usize,
    /// Where it is active.
    places: Vec<Place>,
}

impl Found {
    /// `y` has where the vertex should be, component by component. `squares` has the squared distances from
    /// there, of which `largest` is the largest.
    fn new(y: &[f32], squares: &[f32], largest: f32, multipliers: &[Multiplier], bound: f32) -> Self {
        let near = (NEAR * bound).powi(2);
        let mut found = Self { over: 0, places: Vec::new() };
        if multipliers.is_empty() && largest <= near {
            return found;
        }
        let f = squares.len();
        let mut multipliers = multipliers.iter().peekable();
        for (frame, &square) in squares.iter().enumerate() {
            let multiplier = multipliers.next_if(|multiplier| multiplier.frame as usize == frame);
            if square <= near && multiplier.is_none() {
                continue;
            }
            found.over += usize::from(square > bound * bound);
            let y = Vec3::new(y[frame], y[f + frame], y[2 * f + frame]);
            let u = multiplier.map_or(Vec3::ZERO, |multiplier| multiplier.u);
            found.places.push(Place { frame: frame as u32, y, u });
        }
        found
    }
}

/// The largest distance of a vertex from its place in any frame.
///
/// # Errors
/// [`rhytid_core::Error::Io`].
pub(super) fn worst(centred: &mut Centred<'_>, fit: &Fit) -> Result<f64> {
    let (f, n) = (fit.q.nrows(), fit.q.ncols());
    let q = narrow(&fit.q);
    let arch = Arch::new();
    let mut worst = 0.0_f32;
    for first in centred.frames.blocks() {
        let block = centred.block(first)?;
        let found =
            block.values.par_chunks(3 * TASK * f).zip(fit.t[3 * first * n..].par_chunks(3 * TASK * n));
        let largest = found.map(|(y, t)| {
            let mut squares = vec![0.0; f];
            let m = combine(&q, &t[..y.len() / f * n]);
            let most = |(y, m)| distances(arch, y, m, &mut squares);
            y.chunks(3 * f).zip(m.chunks(3 * f)).map(most).fold(0.0, f32::max)
        });
        worst = worst.max(largest.reduce(|| 0.0, f32::max));
    }
    Ok(f64::from(worst).sqrt())
}
