//! Shuffles: a few labels that change places again and again, or in a ring, or while one of them is hidden.
//!
//! Jumps onto each other's places say which labels and frames are suspect. There the low-rank model of the
//! take tells where each marker is, from all markers that are not suspect. In each frame the suspect
//! positions are given to the markers that they fit best. A marker for which that is not clear is dropped
//! there, to be filled as a gap. Suspects that are where they should be stay as they are.
use crate::events::runs;
use crate::expected::{Expected, Suspects};
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

/// What was found.
pub(crate) struct Settled {
    /// What became of the markers that were shuffled.
    pub shuffles: Vec<Shuffle>,
    /// All labels that seemed to be shuffled, whether they were or not.
    pub suspects: Vec<Suspects>,
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

/// More labels are not put right.
const MOST: usize = 6;

/// A position that is farther from where its marker is expected, as a part of the face's extent, is not the
/// marker's.
const NEAR: f64 = 0.025;

/// The next best assignment must be worse by the square of this part of the face's extent.
const CLEAR: f64 = 0.008;

/// A shuffle ends where all labels are right for so many seconds.
const CALM: f64 = 0.25;

/// Rounds of learning. A shuffle that goes on for longer than its jumps is learned in the first round.
const ROUNDS: usize = 3;

/// A label that appears where another one was.
struct Arrival {
    frame: usize,
    label: usize,
    at: usize,
    /// Frames for which one of the two had not been seen.
    hidden: usize,
    /// Whether both are seen now, and one of them jumped from where it was in the frame before.
    is_both: bool,
}

/// Finds shuffles. Puts them right where that is clear, and makes positions NaN elsewhere. `neutral` is
/// a frame with right labels, `extent` is the face's, and `noise` is the standard deviation of a coordinate.
pub(crate) fn settle(tracks: &mut Tracks, neutral: usize, extent: f64, noise: f64) -> Settled {
    let mut suspects = suspects(&arrivals(tracks, extent), tracks, neutral);
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
    let mut shuffles = Vec::new();
    let Some(expected) = expected else { return Settled { shuffles, suspects } };
    // One after the other, since two may share labels and frames.
    for suspects in &mut suspects {
        let (grown, outcomes) = grown(tracks, suspects, &expected, extent);
        shuffles.extend(put_right(tracks, &grown, &outcomes));
        *suspects = grown;
    }
    shuffles.sort_by_key(|shuffle| (shuffle.frames.start, shuffle.marker, shuffle.is_dropped));
    Settled { shuffles, suspects }
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
                    let is_both = seen(now(*at)) && f - when.max(*left_at) == 1;
                    arrivals.push(Arrival {
                        frame: f,
                        label,
                        at: *at,
                        hidden: f - when.min(*left_at),
                        is_both,
                    });
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
    /// Labels that arrive after a while out of sight, and at whose place.
    hidden: BTreeSet<[usize; 2]>,
}

impl Group {
    fn is_exchanged_out_of_sight(&self) -> bool {
        self.hidden.iter().any(|[a, b]| self.hidden.contains(&[*b, *a]))
    }
}

fn suspects(arrivals: &[Arrival], tracks: &Tracks, neutral: usize) -> Vec<Suspects> {
    let (within, calm, hidden) = (tracks.frames_in(WITHIN), tracks.frames_in(CALM), tracks.frames_in(HIDDEN));
    let mut groups: Vec<Group> = Vec::new();
    let mut open: Vec<Group> = Vec::new();
    for arrival in arrivals {
        let pair = [arrival.label, arrival.at];
        let mut joined =
            Group { labels: pair.into(), frames: [arrival.frame].into(), hidden: BTreeSet::new() };
        if arrival.hidden > hidden {
            joined.hidden.insert(pair);
            if arrival.is_both {
                joined.hidden.insert([arrival.at, arrival.label]);
            }
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
        group.frames.len() >= EXCHANGES || group.labels.len() > 2 || group.is_exchanged_out_of_sight()
    });
    let of_group = |group: Group| {
        let mut first = group.frames.first().copied().unwrap_or(0);
        let mut last = group.frames.last().copied().unwrap_or(0);
        if group.is_exchanged_out_of_sight() {
            // The labels may stay exchanged until they are next seen to change places. At the neutral frame
            // they are right.
            let is_of_group = |a: &&Arrival| group.labels.contains(&a.label) && group.labels.contains(&a.at);
            let others = || arrivals.iter().filter(is_of_group).map(|arrival| arrival.frame);
            if neutral < first {
                last = others().find(|frame| *frame > last).unwrap_or(tracks.frames());
            } else if neutral > last {
                first = others().rfind(|frame| *frame < first).unwrap_or(0);
            }
        }
        let frames = first.saturating_sub(calm)..(last + calm).min(tracks.frames());
        Suspects { labels: group.labels.into_iter().collect(), frames }
    };
    let mut suspects: Vec<Suspects> = groups.into_iter().map(of_group).collect();
    suspects.sort_by_key(|suspects| suspects.frames.start);
    suspects
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

/// Puts labels right from the first to the last frame in which one is wrong.
fn put_right(tracks: &mut Tracks, suspects: &Suspects, outcomes: &[Outcome]) -> Vec<Shuffle> {
    let first = outcomes.iter().position(moves);
    let last = outcomes.iter().rposition(moves);
    let (Some(first), Some(last)) = (first, last) else { return Vec::new() };
    let start = suspects.frames.start;
    let whole = start + first..start + last + 1;
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
        // Nor where one choice is hardly better.
        assert_eq!(of(&[DVec3::X * 0.45, DVec3::X * 0.55]), [None, None]);
    }

    #[test]
    fn orders_are_all_there_are() {
        let all = orders(4);
        assert_eq!((all.len(), &all[0]), (24, &vec![0, 1, 2, 3]));
        assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), 24);
    }
}
