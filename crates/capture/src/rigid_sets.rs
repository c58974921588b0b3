//! Rigid sets: markers that keep their distances from each other, as those of a cap or a slate do.
use crate::tracks::Tracks;
use rayon::prelude::*;
use rhytid_core::numbers::median;

/// Part of the frames in which a pair may be farther from its usual distance, because of ghosts and swaps.
const BAD: f64 = 0.25;

/// Pairs that are seen together in a smaller part of the frames prove nothing.
const TOGETHER: f64 = 0.05;

/// More columns than these are not compared: each is compared with each.
const MOST_COLUMNS: usize = 1000;

/// How well some columns keep their distances from each other.
pub(crate) struct Distances {
    /// The N columns.
    pub columns: Vec<usize>,
    /// N × N medians of the distances; NaN for pairs that are hardly ever seen together.
    middle: Vec<f64>,
    /// N × N: three quarters of the frames are within this of the median. Infinite for pairs that are hardly
    /// ever seen together.
    off: Vec<f64>,
}

impl Distances {
    /// Compares these columns in all frames of `tracks`, which should be a few hundred.
    pub(crate) fn new(tracks: &Tracks, columns: &[usize]) -> Self {
        let columns = columns[..columns.len().min(MOST_COLUMNS)].to_vec();
        let n = columns.len();
        let fewest = ((TOGETHER * tracks.frames() as f64).ceil() as usize).max(2);
        let of_pair = |i: usize, j: usize| {
            let pairs = tracks.columns[columns[i]].iter().zip(&tracks.columns[columns[j]]);
            let mut distances: Vec<f64> = pairs.map(|(a, b)| a.distance(*b)).collect();
            distances.retain(|d| !d.is_nan());
            if i == j || distances.len() < fewest {
                return [f64::NAN, f64::INFINITY];
            }
            let middle = median(&mut distances);
            let mut off: Vec<f64> = distances.iter().map(|d| (d - middle).abs()).collect();
            let place = ((1.0 - BAD) * (off.len() - 1) as f64).round() as usize;
            [middle, *off.select_nth_unstable_by(place, f64::total_cmp).1]
        };
        let rows: Vec<Vec<[f64; 2]>> =
            (0..n).into_par_iter().map(|i| (0..=i).map(|j| of_pair(i, j)).collect()).collect();
        let at = |i: usize, j: usize| rows[i.max(j)][i.min(j)];
        let all = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let middle = all().map(|(i, j)| at(i, j)[0]).collect();
        let off = all().map(|(i, j)| at(i, j)[1]).collect();
        Self { columns, middle, off }
    }

    /// Sets of places in [`Distances::columns`], the largest first. Every pair of a set is within `most` of
    /// its distance. A set grows around each column, with the stiffest pairs first. Sets of fewer than three
    /// are left out, and so are sets of which larger sets have more than half.
    pub(crate) fn sets(&self, most: f64) -> Vec<Vec<usize>> {
        let n = self.columns.len();
        let grown = |seed: usize| {
            let mut near: Vec<usize> = (0..n).filter(|&i| self.off[seed * n + i] < most).collect();
            near.sort_by(|&a, &b| self.off[seed * n + a].total_cmp(&self.off[seed * n + b]));
            let mut set = vec![seed];
            for i in near {
                if set.iter().all(|&j| self.off[i * n + j] < most) {
                    set.push(i);
                }
            }
            set.sort_unstable();
            set
        };
        let grown: Vec<Vec<usize>> = (0..n).into_par_iter().map(grown).collect();
        let mut sets: Vec<Vec<usize>> = grown.into_iter().filter(|set| set.len() >= 3).collect();
        // Stable: equals stay in the order of their columns.
        sets.sort_by_key(|set| std::cmp::Reverse(set.len()));
        let mut is_in_a_set = vec![false; n];
        sets.retain(|set| {
            let is_new = 2 * set.iter().filter(|&&i| is_in_a_set[i]).count() <= set.len();
            if is_new {
                set.iter().for_each(|&i| is_in_a_set[i] = true);
            }
            is_new
        });
        sets
    }

    /// How far the distances of a set vary, in the tracks' unit; 0 where no pair is seen together.
    pub(crate) fn variation(&self, set: &[usize]) -> f64 {
        let n = self.columns.len();
        let pairs = set.iter().flat_map(|&i| set.iter().map(move |&j| (i, j))).filter(|(i, j)| i != j);
        pairs.map(|(i, j)| self.off[i * n + j]).filter(|off| off.is_finite()).fold(0.0, f64::max)
    }

    /// The largest distance in a set.
    pub(crate) fn span(&self, set: &[usize]) -> f64 {
        let n = self.columns.len();
        let pairs = set.iter().flat_map(|&i| set.iter().map(move |&j| self.middle[i * n + j]));
        pairs.filter(|d| !d.is_nan()).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};

    /// Two sets of four that turn differently, a marker that goes with neither, and one with a long gap.
    fn tracks() -> Tracks {
        let at = |c: usize, f: usize| {
            let t = f as f64 / 40.0;
            let p = DVec3::new((c * 5 % 7) as f64, (c * 3 % 5) as f64, (1 + c * c % 4) as f64) * 20.0;
            let turn = match c {
                0..4 => DQuat::from_rotation_y(0.4 * t.sin()),
                4..8 => DQuat::from_rotation_x(0.7 * (2.0 * t).sin()),
                _ => DQuat::IDENTITY,
            };
            turn * p + if c == 8 { DVec3::X * 30.0 * t.sin() } else { DVec3::ZERO }
        };
        let mut columns: Vec<Vec<DVec3>> = (0..9).map(|c| (0..200).map(|f| at(c, f)).collect()).collect();
        columns[2][20..170].fill(DVec3::NAN);
        columns[5][10] += DVec3::splat(40.0);
        Tracks { columns, rate: 100.0 }
    }

    #[test]
    fn each_set_is_found_once() {
        let distances = Distances::new(&tracks(), &[8, 3, 7, 1, 6, 0, 5, 2, 4]);
        let sets = distances.sets(0.5);
        let columns = |set: &Vec<usize>| {
            let mut columns: Vec<usize> = set.iter().map(|&i| distances.columns[i]).collect();
            columns.sort_unstable();
            columns
        };
        let mut found: Vec<Vec<usize>> = sets.iter().map(columns).collect();
        found.sort();
        assert_eq!(found, [vec![0, 1, 2, 3], vec![4, 5, 6, 7]]);
        assert!(sets.iter().all(|set| distances.variation(set) < 1e-9 && distances.span(set) > 30.0));
    }
}
