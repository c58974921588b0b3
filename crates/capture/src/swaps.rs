//! Label swaps: two markers that have each other's label for a while.
//!
//! From the neutral frames, where the labels are right, every marker is followed forwards and backwards in
//! time. If two markers jump and an exchange makes both continue where they were, they are exchanged from
//! that frame on.
use crate::neighbours::nearest;
use crate::tracks::{Tracks, median_point, seen};
use glam::DVec3;
use std::ops::Range;

/// One pair's exchange.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Swap {
    /// The two columns, the lower first.
    pub pair: [usize; 2],
    /// First frame.
    pub first: usize,
    /// Frame behind the last one.
    pub end: usize,
}

/// An exchange must make the squared jumps smaller by this factor.
const FACTOR: f64 = 8.0;

/// A smaller motion between frames is no jump, as a part of the face's extent.
const SMALLEST_JUMP: f64 = 0.012;

/// An exchange must remove this part of the squared errors against the neighbours' expectation.
const GAIN: f64 = 0.5;

/// Frames of a swap that are sampled.
const SAMPLED: usize = 2000;

/// A marker that was not seen for longer, in seconds, is not followed.
const LONGEST_AGE: f64 = 0.25;

/// Finds and undoes swaps. `neutral` is a frame with right labels, `rest` holds the markers' positions there,
/// `extent` is the face's.
pub(crate) fn undo(tracks: &mut Tracks, neutral: usize, rest: &[DVec3], extent: f64) -> Vec<Swap> {
    let frames = tracks.frames();
    let age = tracks.frames_in(LONGEST_AGE);
    let mut swaps = follow(tracks, (neutral..frames).collect(), age, extent);
    swaps.extend(follow(tracks, (0..neutral.min(frames)).rev().collect(), age, extent));
    let neighbours = nearest(rest, 8);
    // A swap is taken back where the markers fit their neighbours worse. The last swap comes first, since
    // each one builds on those before it.
    for k in (0..swaps.len()).rev() {
        let Swap { pair, first, end } = swaps[k];
        let better = where_better(tracks, &swaps[k], rest, &neighbours);
        if better.is_empty() {
            exchange(tracks, pair, first..end);
            swaps.remove(k);
        } else {
            exchange(tracks, pair, first..better.start);
            exchange(tracks, pair, better.end..end);
            swaps[k] = Swap { pair, first: better.start, end: better.end };
        }
    }
    swaps.sort_by_key(|swap| (swap.first, swap.pair));
    swaps
}

/// 0 where one of them was not seen.
fn square(a: DVec3, b: DVec3) -> f64 {
    let square = a.distance_squared(b);
    if square.is_nan() { 0.0 } else { square }
}

fn exchange(tracks: &mut Tracks, [a, b]: [usize; 2], frames: Range<usize>) {
    for f in frames {
        let at_a = tracks.columns[a][f];
        tracks.columns[a][f] = tracks.columns[b][f];
        tracks.columns[b][f] = at_a;
    }
}

/// Goes from frame to frame in this `order`.
fn follow(tracks: &mut Tracks, order: Vec<usize>, age: usize, extent: f64) -> Vec<Swap> {
    let markers = tracks.columns.len();
    let mut last: Vec<Option<(usize, DVec3)>> = vec![None; markers];
    // The pairs that are exchanged at present, in the order of their exchange, and the step at which each
    // began.
    let mut active: Vec<([usize; 2], usize)> = Vec::new();
    let mut swaps = Vec::new();
    let exchanged = |pair: [usize; 2], steps: Range<usize>| {
        let ends = [order[steps.start], order[steps.end - 1]];
        Swap { pair, first: ends[0].min(ends[1]), end: ends[0].max(ends[1]) + 1 }
    };
    for (i, &f) in order.iter().enumerate() {
        active.iter().for_each(|(pair, _)| exchange(tracks, *pair, f..f + 1));
        // Markers that jump, and unseen markers whose label another marker may have.
        let candidates: Vec<(usize, DVec3, bool)> = (0..markers)
            .filter_map(|j| {
                let (when, position) = last[j].filter(|(when, _)| i - when <= age)?;
                let now = tracks.columns[j][f];
                let limit = SMALLEST_JUMP * extent * (1.0 + 0.1 * (i - when - 1) as f64);
                let jumps = now.distance(position) > limit;
                (jumps || !seen(now)).then_some((j, position, jumps))
            })
            .collect();
        for (k, &(a, at_a, a_jumps)) in candidates.iter().enumerate() {
            for &(b, at_b, b_jumps) in &candidates[k + 1..] {
                if !(a_jumps || b_jumps) {
                    continue;
                }
                let (now_a, now_b) = (tracks.columns[a][f], tracks.columns[b][f]);
                let keep = square(now_a, at_a) + square(now_b, at_b);
                let swap = square(now_b, at_a) + square(now_a, at_b);
                if FACTOR * swap >= keep {
                    continue;
                }
                exchange(tracks, [a, b], f..f + 1);
                let pair = [a.min(b), a.max(b)];
                match active.iter().position(|(active, _)| *active == pair) {
                    Some(at) => {
                        let (pair, since) = active.remove(at);
                        swaps.push(exchanged(pair, since..i));
                    }
                    None => active.push((pair, i)),
                }
            }
        }
        for (j, last) in last.iter_mut().enumerate() {
            let now = tracks.columns[j][f];
            if seen(now) {
                *last = Some((i, now));
            }
        }
    }
    // A swap that lasts until the end of the file is undone until there.
    swaps.extend(active.into_iter().map(|(pair, since)| exchanged(pair, since..order.len())));
    swaps
}

/// The part of a swap in which the exchanged markers fit their neighbours' displacements better than before.
/// Empty if they do not fit clearly better.
fn where_better(tracks: &Tracks, swap: &Swap, rest: &[DVec3], neighbours: &[Vec<usize>]) -> Range<usize> {
    let [a, b] = swap.pair;
    let step = (swap.end - swap.first).div_ceil(SAMPLED);
    // The run of frames with the largest gain, and the largest gain possible in it.
    let (mut best, mut run) = ((0.0, 0.0, 0..0), (0.0, 0.0, swap.first..swap.first));
    for f in (swap.first..swap.end).step_by(step) {
        let expected = |j: usize| {
            let others = neighbours[j].iter().filter(|&&n| n != a && n != b);
            rest[j] + median_point(others.map(|&n| tracks.columns[n][f] - rest[n]).filter(|p| seen(*p)))
        };
        let (at_a, at_b) = (tracks.columns[a][f], tracks.columns[b][f]);
        let (to_a, to_b) = (expected(a), expected(b));
        let now = square(at_a, to_a) + square(at_b, to_b);
        let before = square(at_b, to_a) + square(at_a, to_b);
        run = (run.0 + before - now, run.1 + before, run.2.start..(f + step).min(swap.end));
        if run.0 > best.0 {
            best = run.clone();
        }
        if run.0 < 0.0 {
            run = (0.0, 0.0, run.2.end..run.2.end);
        }
    }
    let (gain, before, frames) = best;
    if gain >= GAIN * before { frames } else { 0..0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn face() -> (Tracks, Vec<DVec3>) {
        let rest: Vec<DVec3> =
            (0..16).map(|i| DVec3::new(f64::from(i % 4) * 2.0, f64::from(i / 4) * 2.0, 0.0)).collect();
        let columns = rest
            .iter()
            .map(|r| (0..500).map(|f| *r + DVec3::Y * (0.4 * (f64::from(f) * 0.1 + r.x).sin())).collect())
            .collect();
        (Tracks { columns, rate: 120.0 }, rest)
    }

    fn check(swapped: &[Swap], change: impl Fn(&mut Tracks)) {
        let (truth, rest) = face();
        let mut tracks = truth.clone();
        swapped.iter().for_each(|s| exchange(&mut tracks, s.pair, s.first..s.end));
        change(&mut tracks);
        let found = undo(&mut tracks, 250, &rest, 8.5);
        assert_eq!(found, swapped);
        for (found, truth) in tracks.columns.iter().zip(&truth.columns) {
            assert!(found.iter().zip(truth).all(|(a, b)| a.is_nan() || a == b));
        }
    }

    fn swap(a: usize, b: usize, first: usize, end: usize) -> Swap {
        Swap { pair: [a, b], first, end }
    }

    #[test]
    fn swaps_on_both_sides_of_the_neutral_frame_are_undone() {
        check(&[], |_| ());
        check(&[swap(1, 2, 300, 340)], |_| ());
        check(&[swap(5, 9, 100, 101), swap(1, 2, 200, 240), swap(5, 6, 300, 310)], |_| ());
        check(&[swap(0, 1, 0, 30), swap(10, 14, 400, 500)], |_| ());
    }

    #[test]
    fn a_swap_whose_end_was_not_seen_ends_where_it_fits_no_longer() {
        let (truth, rest) = face();
        let mut tracks = truth.clone();
        exchange(&mut tracks, [1, 2], 300..360);
        tracks.columns[1][330..400].fill(DVec3::NAN);
        tracks.columns[2][330..400].fill(DVec3::NAN);
        let found = undo(&mut tracks, 250, &rest, 8.5);
        assert!(found.len() == 1 && found[0].pair == [1, 2] && found[0].first == 300, "{found:?}");
        assert!((330..=400).contains(&found[0].end), "{found:?}");
        for (found, truth) in tracks.columns.iter().zip(&truth.columns) {
            assert!(found.iter().zip(truth).all(|(a, b)| a.is_nan() || a == b));
        }
    }

    #[test]
    fn gaps_and_ghosts_do_not_hide_a_swap_nor_make_one() {
        check(&[swap(1, 2, 300, 340)], |tracks| tracks.columns[1][290..305].fill(DVec3::NAN));
        let (truth, rest) = face();
        let mut tracks = truth.clone();
        tracks.columns[3][120] += DVec3::splat(3.0);
        tracks.columns[7][350] = tracks.columns[6][350] + DVec3::splat(0.1);
        let before = tracks.clone();
        assert!(undo(&mut tracks, 250, &rest, 8.5).is_empty());
        assert_eq!(tracks, before);
    }
    #[test]
    fn a_marker_that_comes_where_a_hidden_one_was_is_itself() {
        // A mouth that snaps shut while a marker of the upper lip is hidden.
        let (mut tracks, rest) = face();
        for (column, rest) in tracks.columns.iter_mut().zip(&rest) {
            column.iter_mut().for_each(|p| *p = rest.lerp(*p, 0.2));
        }
        tracks.columns[5][300..310].fill(DVec3::NAN);
        for column in &mut tracks.columns[8..] {
            column[305..].iter_mut().for_each(|p| *p -= DVec3::Y * 1.7);
        }
        let before = tracks.clone();
        assert_eq!(undo(&mut tracks, 250, &rest, 8.5), []);
        let mut pairs = tracks.columns.iter().flatten().zip(before.columns.iter().flatten());
        assert!(pairs.all(|(a, b)| a == b || (a.is_nan() && b.is_nan())));
    }
}
