//! Where the low-rank model of a take expects markers whose labels are in doubt, from all the others.
use crate::low_rank::{Effort, Model};
use crate::tracks::{Tracks, seen};
use glam::DVec3;
use std::ops::Range;

/// How much the model learns.
const EFFORT: Effort = Effort { frames: 1200, iterations: 30 };

/// Labels that may be at the wrong markers, in these frames.
#[derive(Debug, Clone)]
pub(crate) struct Suspects {
    /// The columns.
    pub labels: Vec<usize>,
    /// The frames.
    pub frames: Range<usize>,
}

/// Where markers are expected.
pub(crate) struct Expected {
    model: Model,
    /// The columns that the model knows.
    known: Vec<usize>,
    /// These columns, without the suspects.
    tracks: Tracks,
}

impl Expected {
    /// Learns from all that is not suspect. `noise` is the standard deviation of a coordinate. `None` if
    /// there is nothing to learn from.
    pub(crate) fn learn(tracks: &Tracks, suspects: &[Suspects], noise: f64) -> Option<Self> {
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
    pub(crate) fn places(&self, markers: &[usize], f: usize) -> Vec<DVec3> {
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
