//! Doubts: markers that are not where they are expected after their labels were exchanged.
//!
//! An exchange may be wrong: the labels may have been right before, or one of them may have gone elsewhere.
//! So all markers whose labels were exchanged, or nearly so, are compared once more with the low-rank model
//! of the take, which knows them only from other frames. Positions that are far off are dropped, whoever put
//! them there.
use crate::events::runs;
use crate::expected::{Expected, Suspects};
use crate::tracks::{Tracks, seen};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Positions of one marker that were dropped.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Doubt {
    /// The column.
    pub marker: usize,
    /// The frames.
    pub frames: Range<usize>,
}

/// Labels are in doubt for so many seconds before and after an exchange.
const AROUND: f64 = 0.25;

/// A position that is farther from where its marker is expected, as a part of the face's extent, is not the
/// marker's …
const FAR: f64 = 0.012;

/// … nor are those right before and after it that are farther than this part of that.
const RATHER: f64 = 0.5;

/// A marker's distance from where it is expected.
struct Off {
    marker: usize,
    distance: f64,
}

/// Drops what is far off in and around these stretches. `extent` is the face's, `noise` the standard
/// deviation of a coordinate.
pub(crate) fn drop(tracks: &mut Tracks, stretches: &[Suspects], extent: f64, noise: f64) -> Vec<Doubt> {
    if stretches.is_empty() {
        return Vec::new();
    }
    let (frames, around) = (tracks.frames(), tracks.frames_in(AROUND));
    let wider = |Suspects { labels, frames: of }: &Suspects| Suspects {
        labels: labels.clone(),
        frames: of.start.saturating_sub(around)..(of.end + around).min(frames),
    };
    let suspects: Vec<Suspects> = stretches.iter().map(wider).collect();
    let Some(expected) = Expected::learn(tracks, &suspects, noise) else { return Vec::new() };
    let mut of_frame: Vec<Vec<usize>> = vec![Vec::new(); frames];
    for Suspects { labels, frames } in &suspects {
        of_frame[frames.clone()].iter_mut().for_each(|all| all.extend(labels));
    }
    let off: Vec<Vec<Off>> = of_frame
        .par_iter_mut()
        .enumerate()
        .map(|(f, markers)| {
            markers.sort_unstable();
            markers.dedup();
            if markers.is_empty() {
                return Vec::new();
            }
            let places = expected.places(markers, f);
            let of_marker = |(&marker, at): (&usize, DVec3)| Off {
                marker,
                distance: at.distance(tracks.columns[marker][f]),
            };
            markers.iter().zip(places).map(of_marker).collect()
        })
        .collect();
    let mut doubts = Vec::new();
    for marker in 0..tracks.columns.len() {
        let is_seen = |f: &usize| seen(tracks.columns[marker][*f]);
        let at = |f: usize| off[f].iter().find(|off| off.marker == marker).map_or(0.0, |off| off.distance);
        let is_rather = |f: &usize| !is_seen(f) || at(*f) > RATHER * FAR * extent;
        let in_doubt = |f: &usize| of_frame[*f].contains(&marker);
        let rather: Vec<usize> = (0..frames).filter(in_doubt).filter(is_rather).collect();
        for run in runs(&rather) {
            let worst = run.clone().filter(is_seen).map(at).fold(0.0, f64::max);
            if worst > FAR * extent {
                let first = run.clone().find(is_seen).unwrap_or(run.start);
                let end = run.clone().rev().find(is_seen).map_or(run.end, |last| last + 1);
                doubts.push(Doubt { marker, frames: first..end });
            }
        }
    }
    for doubt in &doubts {
        tracks.columns[doubt.marker][doubt.frames.clone()].fill(DVec3::NAN);
    }
    doubts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three motions of twelve markers, about 10 units wide.
    fn face() -> Tracks {
        let wave = |f: usize, k: usize| (f as f64 * [0.05, 0.13, 0.031][k]).sin() / (k + 1) as f64;
        let shape = |j: usize, c: usize, k: usize| ((j * 7 + c * 3 + k * 5) as f64).sin();
        let at = |j: usize, f: usize| {
            let rest = DVec3::new((j % 4) as f64, (j / 4) as f64, 0.0) * 2.5;
            let moved = |c: usize| (0..3).map(|k| wave(f, k) * shape(j, c, k)).sum();
            rest + DVec3::from_array([0, 1, 2].map(moved))
        };
        Tracks { columns: (0..12).map(|j| (0..600).map(|f| at(j, f)).collect()).collect(), rate: 120.0 }
    }

    fn doubts(tracks: &mut Tracks, labels: [usize; 2]) -> Vec<Doubt> {
        drop(tracks, &[Suspects { labels: labels.into(), frames: 300..340 }], 10.0, 1e-4)
    }

    #[test]
    fn a_wrong_exchange_is_dropped_and_a_right_one_stays() {
        let mut tracks = face();
        let [a, b] = [5, 6].map(|j| tracks.columns[j][305..330].to_vec());
        tracks.columns[5][305..330].copy_from_slice(&b);
        tracks.columns[6][305..330].copy_from_slice(&a);
        let found = doubts(&mut tracks, [5, 6]);
        assert_eq!(found, [5, 6].map(|marker| Doubt { marker, frames: 305..330 }));
        for (j, (found, truth)) in tracks.columns.iter().zip(face().columns).enumerate() {
            for (f, (found, truth)) in found.iter().zip(truth).enumerate() {
                let is_dropped = (j == 5 || j == 6) && (305..330).contains(&f);
                assert!(if is_dropped { found.is_nan() } else { *found == truth }, "{j} {f}");
            }
        }
        assert_eq!(doubts(&mut face(), [5, 6]), []);
    }

    #[test]
    fn what_is_rather_far_goes_with_what_is_far() {
        let pushed = |slightly: f64| {
            let mut tracks = face();
            let mut push = |frames: Range<usize>, by: f64| {
                tracks.columns[5][frames].iter_mut().for_each(|p| p.y += by);
            };
            push(300..310, slightly);
            push(310..320, 3.0 * FAR * 10.0);
            push(320..330, slightly);
            doubts(&mut tracks, [5, 6])
        };
        let dropped = |frames| [Doubt { marker: 5, frames }];
        assert_eq!(pushed(0.75 * FAR * 10.0), dropped(300..330));
        assert_eq!(pushed(0.25 * FAR * 10.0), dropped(310..320));
    }
}
