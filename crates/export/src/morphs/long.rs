//! Shapes for takes of any length, found for some of the frames.
//!
//! The search of [`super::search`] compares every frame with every other one. So it looks at frames that are
//! far from each other. Then [`super::weights`] looks for the weights of all frames. The frames that are
//! farthest beyond the bound join those that the search looks at, and the search goes on from where it ended.
//! Thus the frames that the search looks at become the hardest of the take. If shapes are too few for these
//! frames, they are too few for the take.

use super::factors::{Fit, follow};
use super::fit;
use super::frames::{Centred, Frames, Gram};
use super::linear::{self, cholesky, product, solve_lower};
use super::search;
use super::weights::{Known, Shapes};
use faer::Mat;
use rhytid_core::{Error, Progress, Result};

/// A search looks at all frames of a take if they are at most so many.
const SHORT: usize = 600;
/// How many frames the first search of a longer take looks at.
const FIRST: usize = 300;
/// How many frames join at a time, at most.
const MORE: usize = 200;
/// After the first search, at most so many frames are looked at, evenly spaced.
const GLANCE: usize = 2000;
/// Each further look is at so many times as many frames, until one is at all of them. Shapes that are too few
/// seldom need a look at all frames.
const WIDER: usize = 3;
/// Frames with an error above this part of the bound are looked at again with those beyond it: other shapes
/// move them beyond it most easily.
const AT_BOUND: f64 = 0.998;
/// A search that may go on later stops when it has at most this part more shapes than it needs. Shapes that
/// just suffice for some frames rarely suffice for all.
const SPARE: f64 = 0.025;
/// How many times frames join in [`nearest`], at most.
const JOINS: usize = 8;

/// Shapes for all frames.
pub(super) struct Solution {
    /// The shapes, and the weights of the frames that the search looked at.
    pub fit: Fit,
    /// The mean that the shapes are relative to.
    pub center: Vec<f32>,
    /// The frames that the search looked at, in ascending order.
    pub chosen: Vec<usize>,
    /// The weights of all frames, F×n.
    pub weights: Mat<f64>,
}

/// What a search found.
struct Search<'a> {
    fit: &'a Fit,
    gram: &'a Gram,
    /// The frames that it looked at, in ascending order.
    chosen: &'a [usize],
}

/// What [`all_weights`] finds.
struct Found {
    /// The weights of all frames. Those that were not looked at have what was known before.
    known: Known,
    /// How far the worst vertex of each frame is from its place; 0 for frames that were not looked at, and
    /// for those of the search.
    errors: Vec<f64>,
}

/// The frames that the first search looks at, in ascending order.
pub(super) fn first(frames: &Frames) -> Vec<usize> {
    let all = frames.frames();
    frames.sketches().spread(if all <= SHORT { all } else { FIRST })
}

/// The fewest shapes found that keep all vertices of all frames within the bound; `None` if `most` do not
/// suffice.
///
/// # Errors
/// As [`search::fewest`].
pub(super) fn fewest(
    frames: &mut Frames,
    bound: f64,
    most: usize,
    progress: &dyn Progress,
) -> Result<Option<Solution>> {
    let all: Vec<usize> = (0..frames.frames()).collect();
    let mut chosen = first(frames);
    frames.choose(chosen.clone());
    let mut gram = frames.gram(progress)?;
    let start = linear::principal(&gram.matrix)?;
    let spare = if chosen.len() < all.len() { SPARE } else { 0.0 };
    let range = |least| search::Numbers { least, most, spare };
    let Some(mut fit) = search::fewest(frames, &gram, &start, bound, range(0), progress)? else {
        frames.choose_all();
        return Ok(None);
    };
    // The frames whose weights are looked for.
    let mut stride = all.len().div_ceil(GLANCE).max(1);
    let mut looked_at: Vec<usize> = all.iter().copied().step_by(stride).collect();
    let mut known = None;
    loop {
        frames.choose_all();
        let search = Search { fit: &fit, gram: &gram, chosen: &chosen };
        let found = all_weights(frames, &search, &looked_at, known.as_ref(), bound, progress)?;
        let beyond = found.errors.iter().filter(|&&error| error > bound).count();
        log::debug!(
            "{} morph targets for {} frames: {beyond} of {} frames are beyond",
            fit.q.ncols() - 1,
            chosen.len(),
            looked_at.len()
        );
        if beyond == 0 && looked_at.len() == all.len() {
            let weights = found.known.weights;
            return Ok(Some(Solution { fit, center: gram.center, chosen, weights }));
        }
        if beyond == 0 {
            stride = (stride / WIDER).max(1);
            looked_at = all.iter().copied().step_by(stride).collect();
            known = Some(found.known);
            continue;
        }
        let before = join(&mut chosen, &found.errors, bound);
        // More frames are looked at again when none of these is beyond the bound.
        looked_at.retain(|&i| found.errors[i] > AT_BOUND * bound);
        frames.choose(chosen.clone());
        let grown = grown(&fit, &before, &chosen, &found.known.weights);
        known = Some(found.known);
        let columns = grown.q.clone();
        let again = fit::fit(&mut Centred::new(frames, &gram), grown, bound, &mut tick(progress))?;
        fit = match again {
            Some(again) => again,
            None => {
                let least = fit.q.ncols();
                gram = frames.gram(progress)?;
                let start = linear::principal_after(&gram.matrix, &columns)?;
                match search::fewest(frames, &gram, &start, bound, range(least), progress)? {
                    Some(fit) => fit,
                    None => {
                        frames.choose_all();
                        return Ok(None);
                    }
                }
            }
        };
    }
}

/// At most `targets` shapes with the least bound found that all frames meet, and that bound.
///
/// # Errors
/// As [`search::nearest`].
pub(super) fn nearest(
    frames: &mut Frames,
    targets: usize,
    progress: &dyn Progress,
) -> Result<(Solution, f64)> {
    let all: Vec<usize> = (0..frames.frames()).collect();
    let mut chosen = first(frames);
    frames.choose(chosen.clone());
    let mut gram = frames.gram(progress)?;
    let start = linear::principal(&gram.matrix)?;
    let (mut fit, mut met) = search::nearest(frames, &gram, &start, targets, None, progress)?;
    let mut best: Option<(Solution, f64)> = None;
    let mut known = None;
    for joins in 0.. {
        frames.choose_all();
        let search = Search { fit: &fit, gram: &gram, chosen: &chosen };
        let found = all_weights(frames, &search, &all, known.as_ref(), met, progress)?;
        let worst = found.errors.iter().copied().fold(met, f64::max);
        log::debug!(
            "{targets} morph targets: {} frames are within {met:.3e}, all within {worst:.3e}",
            chosen.len()
        );
        if best.as_ref().is_none_or(|best| worst < best.1) {
            let (center, weights) = (gram.center.clone(), found.known.weights.clone());
            best = Some((Solution { fit: fit.clone(), center, chosen: chosen.clone(), weights }, worst));
        }
        if worst <= search::CLOSE * met || joins == JOINS {
            break;
        }
        let before = join(&mut chosen, &found.errors, met);
        frames.choose(chosen.clone());
        let grown = grown(&fit, &before, &chosen, &found.known.weights);
        known = Some(found.known);
        let again = fit::fit(&mut Centred::new(frames, &gram), grown, met, &mut tick(progress))?;
        if let Some(again) = again {
            fit = again;
        } else {
            gram = frames.gram(progress)?;
            let start = linear::principal(&gram.matrix)?;
            (fit, met) = search::nearest(frames, &gram, &start, targets, Some(met), progress)?;
        }
    }
    best.ok_or_else(|| Error::Internal("no search was made".into()))
}

/// Reports the rounds of a fit.
fn tick(progress: &dyn Progress) -> impl FnMut(usize) -> Result<()> + '_ {
    move |round| progress.step("fit the hardest frames", round as u64, fit::ROUNDS as u64)
}

/// The weights of the frames that are `looked_at`. The search has found those of the frames that it looked
/// at. `known` has what was found for the shapes before.
fn all_weights(
    frames: &mut Frames,
    search: &Search<'_>,
    looked_at: &[usize],
    known: Option<&Known>,
    bound: f64,
    progress: &dyn Progress,
) -> Result<Found> {
    let Search { fit, gram, chosen } = search;
    let all = frames.frames();
    let shapes = Shapes::new(fit, &gram.center)?;
    let start = known.map(|known| shapes.carried(known));
    let mut weights = match &start {
        Some(start) => shapes.turned_back(start),
        None => Mat::full(all, fit.q.ncols(), f64::NAN),
    };
    let mut errors = vec![0.0; all];
    let mut keep = |frame: usize, found: &Mat<f64>, row: usize| {
        (0..found.ncols()).for_each(|j| weights[(frame, j)] = found[(row, j)]);
    };
    let others: Vec<usize> = looked_at.iter().copied().filter(|i| chosen.binary_search(i).is_err()).collect();
    if !others.is_empty() {
        frames.choose(others.clone());
        let found = shapes.weights(frames, &others, start.as_ref(), bound, progress)?;
        frames.choose_all();
        let of_t = shapes.turned_back(&found.weights);
        for (i, &frame) in others.iter().enumerate() {
            errors[frame] = found.errors[i];
            keep(frame, &of_t, i);
        }
    }
    for (i, &frame) in chosen.iter().enumerate() {
        keep(frame, &fit.q, i);
    }
    let known = Known { weights, t: fit.t.clone(), center: gram.center.clone() };
    Ok(Found { known, errors })
}

/// The frames farthest beyond the bound join the others, at most [`MORE`] of them. Neighbours are alike, so
/// only the worst of those that follow each other joins. Returns the frames before.
fn join(chosen: &mut Vec<usize>, errors: &[f64], bound: f64) -> Vec<usize> {
    let before = chosen.clone();
    let error = |i: Option<usize>| i.and_then(|i| errors.get(i)).copied().unwrap_or(0.0);
    let mut peaks: Vec<usize> = Vec::new();
    for (i, &here) in errors.iter().enumerate() {
        if here > bound && here > error(i.checked_sub(1)) && here >= error(Some(i + 1)) {
            peaks.push(i);
        }
    }
    peaks.sort_by(|&a, &b| errors[b].total_cmp(&errors[a]).then(a.cmp(&b)));
    chosen.extend(peaks.into_iter().take(MORE));
    chosen.sort_unstable();
    before
}

/// A fit of the frames `before` as a fit of the frames `chosen`, which contain them. `weights` has the
/// weights of all frames.
fn grown(fit: &Fit, before: &[usize], chosen: &[usize], weights: &Mat<f64>) -> Fit {
    let n = fit.q.ncols();
    let rows = Mat::from_fn(chosen.len(), n, |i, j| weights[(chosen[i], j)]);
    let factor = cholesky(&product(rows.transpose(), rows.as_ref()));
    let mut t = fit.t.clone();
    follow(&mut t, &factor.transpose().to_owned(), n);
    let mut multipliers = fit.multipliers.clone();
    for multiplier in multipliers.iter_mut().flatten() {
        let place = chosen.partition_point(|&frame| frame < before[multiplier.frame as usize]);
        multiplier.frame = place as u32;
    }
    Fit { q: solve_lower(&factor, &rows), t, multipliers }
}
