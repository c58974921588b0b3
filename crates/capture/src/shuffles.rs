//! Shuffles: a few labels that change places again and again, or in a ring, or while one of them is hidden.
//!
//! Jumps onto each other's places say which labels and frames are suspect. There the low-rank model of the
//! take tells where each marker is, from all markers that are not suspect. In each frame the suspect positions
//! are given to the markers that they fit best. A marker for which that is not clear is dropped there, to be
//! filled as a gap. Suspects that are where they should be stay as they are.
use crate::events::runs;
use crate::low_rank::{Effort, Model};
use crate::tracks::{Tracks, seen};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::Range;

/// What became of one marker in a shuffle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Shuffle {
    /// The column.
    pub marker: usize,
    /// The frames.
    pub frames: Range<usize>,
    /// Whether its positions there were dropped. Otherwise they were put right.
    pub is_dropped: bool,
}

/// A smaller motion between frames is no jump, as a part of the face's extent.
const SMALLEST_JUMP: f64 = 0.012;

/// A label arrives at another one's place if it ends within this part of its jump from there.
const ARRIVES: f64 = 0.5;

/// Exchanges within so many seconds of each other belong together. A marker that was not seen for longer is
/// not expected anywhere.
const WITHIN: f64 = 1.0;

/// Two labels that exchange places in fewer frames than this are a swap, which another step undoes …
const EXCHANGES: usize = 3;

/// … unless one of them was not seen for so many seconds before. The other step may not follow it then.
const HIDDEN: f64 = 0.05;

/// If a larger part of all markers jumps in a frame, that says nothing of their labels.
const TOGETHER: f64 = 0.5;

/// What was put right must have this part of the squared jumps that it had before, or less.
const SMOOTHER: f64 = 0.5;

/// More labels are not put right.
const MOST: usize = 6;

/// A position that is farther from where its marker is expected, as a part of the face's extent, is not the
/// marker's.
const NEAR: f64 = 0.025;

/// The next best assignment must be worse by the square of this part of the face's extent.
const CLEAR: f64 = 0.008;

/// A shuffle ends where all labels are right for so many seconds.
const CALM: f64 = 0.25;

/// How much the model learns.
const EFFORT: Effort = Effort { frames: 1200, iterations: 30 };

/// Rounds of learning. A shuffle that goes on for longer than its jumps is learned in the first round.
const ROUNDS: usize = 3;

/// A label that appears where another one was.
struct Arrival {
    frame: usize,
    label: usize,
    at: usize,
    /// Frames for which one of the two had not been seen.
    hidden: usize,
}

/// Labels that may have been shuffled, in frames around their jumps.
struct Suspects {
    labels: Vec<usize>,
    frames: Range<usize>,
}

/// Finds shuffles. Puts them right where that is clear, and makes positions NaN elsewhere. `extent` is the
/// face's; `noise` is the standard deviation of a coordinate.
pub(crate) fn settle(tracks: &mut Tracks, extent: f64, noise: f64) -> Vec<Shuffle> {
    let mut suspects = suspects(arrivals(tracks, extent), tracks);
    let mut expected = None;
    for _ in 0..ROUNDS {
        if suspects.is_empty() {
            break;
        }
        let Some(learned) = Expected::learn(tracks, &suspects, noise) else { break };
        let mut is_same = true;
        for suspects in &mut suspects {
            let (grown, _) = grown(tracks, suspects, &learned, extent);
            is_same &= grown.frames == suspects.frames;
            *suspects = grown;
        }
        expected = Some(learned);
        if is_same {
            break;
        }
    }
    let Some(expected) = expected else { return Vec::new() };
    let mut shuffles = Vec::new();
    // One after the other, since two may share labels and frames.
    for suspects in &suspects {
        let (suspects, outcomes) = grown(tracks, suspects, &expected, extent);
        shuffles.extend(put_right(tracks, &suspects, &outcomes, extent));
    }
    shuffles.sort_by_key(|shuffle| (shuffle.frames.start, shuffle.marker, shuffle.is_dropped));
    shuffles
}

/// All jumps of a label onto the place of another one that has left it.
fn arrivals(tracks: &Tracks, extent: f64) -> Vec<Arrival> {
    let markers = tracks.columns.len();
    let within = tracks.frames_in(WITHIN);
    let mut last: Vec<Option<(usize, DVec3)>> = vec![None; markers];
    let mut arrivals = Vec::new();
    for f in 0..tracks.frames() {
        let now = |j: usize| tracks.columns[j][f];
        let before = |j: usize| last[j].filter(|(when, _)| f - when <= within);
        let has_left = |j: usize| {
            before(j).filter(|(_, at)| !seen(now(j)) || now(j).distance(*at) > SMALLEST_JUMP * extent)
        };
        let jumps = |j: &usize| seen(now(*j)) && has_left(*j).is_some();
        let jumping: Vec<usize> = (0..markers).filter(jumps).collect();
        // If most markers jump at once, it is a cut in the take or a fast motion of the whole face.
        if !jumping.is_empty() && jumping.len() as f64 <= TOGETHER * markers as f64 {
            let left: Vec<(usize, usize, DVec3)> =
                (0..markers).filter_map(|j| has_left(j).map(|(when, at)| (j, when, at))).collect();
            for &label in &jumping {
                let Some((when, from)) = before(label) else { continue };
                let jump = now(label).distance(from);
                let others = left.iter().filter(|(other, _, _)| *other != label);
                let nearest =
                    others.min_by(|a, b| now(label).distance(a.2).total_cmp(&now(label).distance(b.2)));
                if let Some((at, left_at, place)) = nearest
                    && now(label).distance(*place) < ARRIVES * jump
                {
                    arrivals.push(Arrival { frame: f, label, at: *at, hidden: f - when.min(*left_at) });
                }
            }
        }
        for (j, last) in last.iter_mut().enumerate() {
            if seen(now(j)) {
                *last = Some((f, now(j)));
            }
        }
    }
    arrivals
}

/// Arrivals that belong together.
struct Group {
    labels: BTreeSet<usize>,
    frames: BTreeSet<usize>,
    /// Pairs of labels that one arrival after a while out of sight names.
    hidden: BTreeSet<[usize; 2]>,
}

fn suspects(arrivals: Vec<Arrival>, tracks: &Tracks) -> Vec<Suspects> {
    let (within, calm, hidden) = (tracks.frames_in(WITHIN), tracks.frames_in(CALM), tracks.frames_in(HIDDEN));
    let mut groups: Vec<Group> = Vec::new();
    let mut open: Vec<Group> = Vec::new();
    for arrival in arrivals {
        let pair = [arrival.label, arrival.at];
        let mut joined =
            Group { labels: pair.into(), frames: [arrival.frame].into(), hidden: BTreeSet::new() };
        if arrival.hidden > hidden {
            joined.hidden.insert(pair);
        }
        for mut group in std::mem::take(&mut open) {
            let last = group.frames.last().copied().unwrap_or(0);
            if arrival.frame - last > within {
                groups.push(group);
            } else if pair.iter().any(|label| group.labels.contains(label)) {
                joined.labels.append(&mut group.labels);
                joined.frames.append(&mut group.frames);
                joined.hidden.append(&mut group.hidden);
            } else {
                open.push(group);
            }
        }
        open.push(joined);
    }
    groups.append(&mut open);
    groups.retain(|group| {
        let is_exchanged = |[a, b]: &[usize; 2]| group.hidden.contains(&[*b, *a]);
        group.frames.len() >= EXCHANGES || group.labels.len() > 2 || group.hidden.iter().any(is_exchanged)
    });
    let of_group = |group: Group| {
        let first = group.frames.first().copied().unwrap_or(0).saturating_sub(calm);
        let end = group.frames.last().map_or(0, |last| last + calm).min(tracks.frames());
        Suspects { labels: group.labels.into_iter().collect(), frames: first..end }
    };
    let mut suspects: Vec<Suspects> = groups.into_iter().map(of_group).collect();
    suspects.sort_by_key(|suspects| suspects.frames.start);
    suspects
}

/// Where markers are expected.
struct Expected {
    model: Model,
    /// The columns that the model knows.
    known: Vec<usize>,
    /// These columns, without the suspects.
    tracks: Tracks,
}

impl Expected {
    /// Learns from all that is not suspect.
    fn learn(tracks: &Tracks, suspects: &[Suspects], noise: f64) -> Option<Self> {
        let mut columns = tracks.columns.clone();
        for suspects in suspects {
            for &label in &suspects.labels {
                columns[label][suspects.frames.clone()].fill(DVec3::NAN);
            }
        }
        let is_known = |j: &usize| columns[*j].iter().any(|p| seen(*p));
        let known: Vec<usize> = (0..columns.len()).filter(is_known).collect();
        let columns = known.iter().map(|&j| std::mem::take(&mut columns[j])).collect();
        let tracks = Tracks { columns, rate: tracks.rate };
        Some(Self { model: Model::learn(&tracks, noise, EFFORT)?, known, tracks })
    }

    /// The places of these markers in frame `f` as if none of them had been seen; NaN for one that is never
    /// seen elsewhere.
    fn places(&self, markers: &[usize], f: usize) -> Vec<DVec3> {
        let unseen = |j: &usize| markers.contains(j);
        let now = self.known.iter().zip(&self.tracks.columns);
        let frame: Vec<f64> = now
            .flat_map(|(j, column)| if unseen(j) { [f64::NAN; 3] } else { column[f].to_array() })
            .collect();
        let whole = self.model.complete(&frame);
        let place = |marker: &usize| self.known.binary_search(marker).ok();
        let at = |k: usize| DVec3::from_slice(&whole[3 * k..]);
        markers.iter().map(|marker| place(marker).map_or(DVec3::NAN, at)).collect()
    }
}

/// For each suspect label in one frame, the index of the label that has its marker. `None` if no label
/// clearly has it.
type Outcome = Vec<Option<usize>>;

/// The labels' outcomes in all frames up to where all of them are right for a while.
fn grown(tracks: &Tracks, suspects: &Suspects, expected: &Expected, extent: f64) -> (Suspects, Vec<Outcome>) {
    let Suspects { labels, frames } = suspects;
    let of_frame = |f: usize| {
        let at: Vec<DVec3> = labels.iter().map(|&label| tracks.columns[label][f]).collect();
        outcome(&at, &expected.places(labels, f), extent)
    };
    let calm = tracks.frames_in(CALM);
    let mut outcomes: Vec<Outcome> = frames.clone().into_par_iter().map(of_frame).collect();
    let calm_at = |outcomes: &mut dyn Iterator<Item = &Outcome>| outcomes.take_while(|o| !moves(o)).count();
    let mut since = calm_at(&mut outcomes.iter().rev());
    let mut end = frames.end;
    while end < tracks.frames() && since < calm {
        outcomes.push(of_frame(end));
        since = if outcomes.last().is_some_and(moves) { 0 } else { since + 1 };
        end += 1;
    }
    let mut since = calm_at(&mut outcomes.iter());
    let mut before = Vec::new();
    while before.len() < frames.start && since < calm {
        let outcome = of_frame(frames.start - 1 - before.len());
        since = if moves(&outcome) { 0 } else { since + 1 };
        before.push(outcome);
    }
    let first = frames.start - before.len();
    before.reverse();
    before.append(&mut outcomes);
    (Suspects { labels: labels.clone(), frames: first..end }, before)
}

/// Whether a marker clearly has another one's label.
fn moves(outcome: &Outcome) -> bool {
    outcome.iter().enumerate().any(|(k, from)| from.is_some_and(|from| from != k))
}

/// Gives the positions `at` to the markers that are expected at `places`.
fn outcome(at: &[DVec3], places: &[DVec3], extent: f64) -> Outcome {
    let most = (NEAR * extent).powi(2);
    // An unseen position, or an unknown place, is as far as a wrong one.
    let square = |marker: usize, label: usize| {
        let square = at[label].distance_squared(places[marker]);
        if square < most { square } else { most }
    };
    let has = |marker: usize, label: usize| (square(marker, label) < most).then_some(label);
    if at.len() > MOST {
        return (0..at.len()).map(|k| has(k, k)).collect();
    }
    let orders = orders(at.len());
    let cost = |order: &[usize]| order.iter().enumerate().map(|(k, &label)| square(k, label)).sum::<f64>();
    let costs: Vec<f64> = orders.iter().map(|order| cost(order)).collect();
    let best = (0..orders.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).unwrap_or(0);
    let of_marker = |k: usize| {
        let label = has(k, orders[best][k]);
        let others = orders.iter().zip(&costs).filter(|(order, _)| has(k, order[k]) != label);
        let next = others.map(|(_, cost)| *cost).fold(f64::INFINITY, f64::min);
        let clear = square(k, orders[best][k]) + (CLEAR * extent).powi(2);
        label.filter(|_| next - costs[best] > clear)
    };
    (0..at.len()).map(of_marker).collect()
}

/// All orders of the numbers below `count`, the ascending one first.
fn orders(count: usize) -> Vec<Vec<usize>> {
    let mut orders = vec![Vec::new()];
    for _ in 0..count {
        let longer = |order: &Vec<usize>| {
            let order = order.clone();
            let next = (0..count).filter(|k| !order.contains(k)).collect::<Vec<_>>();
            next.into_iter().map(move |k| [&order[..], &[k]].concat())
        };
        orders = orders.iter().flat_map(longer).collect();
    }
    orders
}

/// Puts labels right from the first to the last frame in which one is wrong. Leaves all as it is if the markers
/// would not move more smoothly.
fn put_right(tracks: &mut Tracks, suspects: &Suspects, outcomes: &[Outcome], extent: f64) -> Vec<Shuffle> {
    let first = outcomes.iter().position(moves);
    let last = outcomes.iter().rposition(moves);
    let (Some(first), Some(last)) = (first, last) else { return Vec::new() };
    let start = suspects.frames.start;
    let whole = start + first..start + last + 1;
    let within = tracks.frames_in(WITHIN);
    let around = whole.start.saturating_sub(within)..(whole.end + within).min(tracks.frames());
    let labels = &suspects.labels;
    // A label that keeps its marker, and whose marker no other label has, only stood by.
    let is_mixed = |k: usize| {
        let in_frame = |outcome: &Outcome| {
            let pairs = outcome.iter().enumerate();
            pairs
                .filter_map(|(marker, from)| Some((marker, (*from)?)))
                .any(|(a, b)| a != b && (a == k || b == k))
        };
        outcomes.iter().any(in_frame)
    };
    let mixed: Vec<bool> = (0..labels.len()).map(is_mixed).collect();
    let before: Vec<Vec<DVec3>> =
        labels.iter().map(|&label| tracks.columns[label][whole.clone()].to_vec()).collect();
    let jump = SMALLEST_JUMP * extent;
    let rough = jumps(tracks, labels, around.clone(), jump);
    let mut dropped: Vec<Vec<usize>> = vec![Vec::new(); labels.len()];
    for (i, f) in whole.clone().enumerate() {
        for (k, &label) in labels.iter().enumerate().filter(|(k, _)| mixed[*k]) {
            let from = outcomes[first + i][k];
            tracks.columns[label][f] = from.map_or(DVec3::NAN, |from| before[from][i]);
            if from.is_none() && seen(before[k][i]) {
                dropped[k].push(f);
            }
        }
    }
    if jumps(tracks, labels, around, jump) > SMOOTHER * rough {
        for (&label, before) in labels.iter().zip(before) {
            tracks.columns[label][whole.clone()].copy_from_slice(&before);
        }
        return Vec::new();
    }
    let mut shuffles = Vec::new();
    for (k, &marker) in labels.iter().enumerate() {
        let of_run = |frames| Shuffle { marker, frames, is_dropped: true };
        shuffles.extend(runs(&dropped[k]).into_iter().map(of_run));
        if mixed[k] {
            shuffles.push(Shuffle { marker, frames: whole.clone(), is_dropped: false });
        }
    }
    shuffles
}

/// The sum of the squared steps between positions that were seen one after the other, of those steps that are
/// longer than `least`.
fn jumps(tracks: &Tracks, markers: &[usize], frames: Range<usize>, least: f64) -> f64 {
    let mut sum = 0.0;
    for &marker in markers {
        let mut last = None;
        for p in tracks.columns[marker][frames.clone()].iter().filter(|p| seen(**p)) {
            let step = last.map_or(0.0, |last| p.distance(last));
            sum += if step > least { step * step } else { 0.0 };
            last = Some(*p);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_go_to_the_markers_that_they_fit() {
        let places = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let of = |at: &[DVec3]| outcome(at, &places[..at.len()], 50.0);
        assert_eq!(of(&[DVec3::ZERO, DVec3::X, DVec3::Y]), [Some(0), Some(1), Some(2)]);
        // A ring of three, a swap beside an unseen one, and a position that belongs to none.
        assert_eq!(of(&[DVec3::X, DVec3::Y, DVec3::ZERO]), [Some(2), Some(0), Some(1)]);
        assert_eq!(of(&[DVec3::X, DVec3::ZERO, DVec3::NAN]), [Some(1), Some(0), None]);
        assert_eq!(of(&[DVec3::X, DVec3::ZERO, DVec3::Z * 9.0]), [Some(1), Some(0), None]);
        // In the middle between two places, nobody can tell.
        assert_eq!(of(&[DVec3::X * 0.5, DVec3::X * 0.5 + DVec3::Z * 0.01]), [None, None]);
    }

    #[test]
    fn orders_are_all_there_are() {
        let all = orders(4);
        assert_eq!((all.len(), &all[0]), (24, &vec![0, 1, 2, 3]));
        assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), 24);
    }
}
