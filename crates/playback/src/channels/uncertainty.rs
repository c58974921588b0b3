//! The uncertainty of every vertex in a take's frames: it is computed at a few hundred and interpolated
//! between.

use rhytid_core::{HandleId, Result, Rig, Table, VertexId};
use rhytid_solve::{Confidence, EXTRAPOLATION};
use std::collections::HashMap;

/// Vertices whose confidence is computed.
const SAMPLES: usize = 1200;

/// The number of samples that a vertex's uncertainty is interpolated from.
const NEAREST: usize = 4;

/// σ of a take on a rig of the learned method, relative to the σ of a left-out example.
pub(crate) struct Uncertainty {
    /// frames × S: σ relative to the σ of a left-out example at the sample.
    samples: Table<f32>,
    /// S factors, from 0 to 1. Times this factor, a number of `samples` is relative to the larger of two σ of
    /// a left-out example: at the sample, and over the whole face.
    significance: Vec<f32>,
    /// σ of a left-out example over the whole face, in mesh units.
    typical: f32,
    /// V: σ of a left-out example, in mesh units.
    left_out: Vec<f32>,
    /// V × [`NEAREST`] samples, and their weights, whose sum is 1.
    nearest: Vec<[(u32, f32); NEAREST]>,
}

impl Uncertainty {
    /// The uncertainty of frames × H handle positions. `None` where the rig has no learned method or no
    /// examples.
    ///
    /// # Errors
    /// As [`Confidence::new`].
    pub(crate) fn new(rig: &Rig, handle_positions: &[f32]) -> Result<Option<Self>> {
        if rig.learned().is_none() || rig.examples().names.is_empty() {
            return Ok(None);
        }
        let confidence = Confidence::sampled(rig, SAMPLES)?;
        let count = confidence.vertices().len();
        if count == 0 {
            return Ok(None);
        }
        let left_out: Vec<f64> = confidence.left_out().collect();
        let variances = confidence.variances(handle_positions.as_chunks::<3>().0);
        let relative = |(i, variance): (usize, &f64)| match left_out[i % count] {
            of_sample if of_sample > 0.0 => (variance / of_sample).sqrt() as f32,
            _ => 0.0,
        };
        let samples = variances.iter().enumerate().map(relative).collect();
        let samples = Table::new(variances.len() / count, count, samples);
        // In units of s_v it is smooth, as σ is.
        let learned = rig.learned().map_or(&[][..], |learned| &learned.variances);
        let unit = |(of_sample, v): (&f64, &VertexId)| match f64::from(learned[v.index()]) {
            variance if variance > 0.0 => (of_sample / variance).sqrt() as f32,
            _ => 0.0,
        };
        let units: Vec<f32> = left_out.iter().zip(confidence.vertices()).map(unit).collect();
        let typical = confidence.typical_left_out();
        let significance =
            left_out.iter().map(|of_sample| significance(of_sample.sqrt() as f32, typical.sqrt() as f32));
        let mut uncertainty = Self {
            samples,
            significance: significance.collect(),
            typical: typical.sqrt() as f32,
            left_out: Vec::new(),
            nearest: nearest(rig, confidence.vertices()),
        };
        uncertainty.left_out = learned
            .iter()
            .enumerate()
            .map(|(v, variance)| variance.sqrt() * uncertainty.at(v, &units))
            .collect();
        Ok(Some(uncertainty))
    }

    /// Whether a frame is far from the examples at any sample.
    pub(crate) fn is_far(&self, frame: usize) -> bool {
        let samples = self.samples(frame).iter().zip(&self.significance);
        samples.into_iter().any(|(n, significance)| f64::from(n * significance) > EXTRAPOLATION)
    }

    /// The uncertainty of vertex `v`, given the frame's [`Uncertainty::samples`].
    ///
    /// It is a multiple of σ of a left-out example: the larger of that at the vertex and that over the whole
    /// face.
    pub(crate) fn times(&self, v: usize, samples: &[f32]) -> f64 {
        f64::from(self.at(v, samples) * significance(self.left_out[v], self.typical))
    }

    /// The S numbers of a frame.
    pub(crate) fn samples(&self, frame: usize) -> &[f32] {
        self.samples.row(frame)
    }

    /// Replaces `sigma` by the frame's σ: V, in mesh units.
    pub(crate) fn sigma(&self, frame: usize, sigma: &mut Vec<f32>) {
        let samples = self.samples(frame);
        sigma.clear();
        sigma.extend(self.left_out.iter().enumerate().map(|(v, left_out)| left_out * self.at(v, samples)));
    }

    /// The interpolated number of a vertex, given [`Uncertainty::samples`].
    fn at(&self, v: usize, samples: &[f32]) -> f32 {
        self.nearest[v].iter().map(|&(sample, weight)| weight * samples[sample as usize]).sum()
    }
}

fn significance(left_out: f32, typical: f32) -> f32 {
    if left_out > 0.0 { left_out / left_out.max(typical) } else { 0.0 }
}

/// The nearest samples of each vertex, with their weights.
///
/// Only samples that share an anchor with the vertex count. So lips and lids do not take values across their
/// opening.
fn nearest(rig: &Rig, samples: &[VertexId]) -> Vec<[(u32, f32); NEAREST]> {
    let anchors = |v: usize| {
        let anchors = rig.learned().into_iter().flat_map(move |learned| learned.anchors_of(v));
        anchors.filter(|(_, weight)| *weight > 0.0)
    };
    // The samples, grouped by the handle that is each one's strongest anchor.
    let mut by_handle: HashMap<HandleId, Vec<u32>> = HashMap::new();
    // A sample that never moves says nothing about its neighbours.
    let moves = |v: &VertexId| rig.learned().is_some_and(|learned| learned.variances[v.index()] > 0.0);
    for (i, &v) in samples.iter().enumerate().filter(|(_, v)| moves(v)) {
        if let Some((handle, _)) = anchors(v.index()).max_by(|a, b| a.1.total_cmp(&b.1)) {
            by_handle.entry(handle).or_default().push(i as u32);
        }
    }
    let square = |v: usize, sample: u32| {
        let (a, b) = (rig.surface().rest[v], rig.surface().rest[samples[sample as usize].index()]);
        (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>()
    };
    let of_vertex = |v: usize| {
        let near = anchors(v).filter_map(|(handle, _)| by_handle.get(&handle)).flatten();
        let mut near: Vec<(f32, u32)> = near.map(|&sample| (square(v, sample), sample)).collect();
        if near.is_empty() {
            near = (0..samples.len() as u32).map(|sample| (square(v, sample), sample)).collect();
        }
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.truncate(NEAREST);
        // Distances are relative to the closest sample's, so that a sample vertex keeps its own number.
        let closest = near.first().map_or(0.0, |near| near.0).max(f32::MIN_POSITIVE);
        let weight = |square: f32| closest / square.max(f32::MIN_POSITIVE);
        let sum: f32 = near.iter().map(|near| weight(near.0)).sum();
        let mut found = [(0, 0.0); NEAREST];
        found.iter_mut().zip(near).for_each(|(to, (square, sample))| *to = (sample, weight(square) / sum));
        found
    };
    (0..rig.vertices()).map(of_vertex).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::NoProgress;

    #[test]
    fn what_is_spread_is_close_to_what_every_vertex_has() {
        let face = rhytid_demo::face(4_000);
        let rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let take = rhytid_demo::performance(&face);
        let mut positions = take.handle_positions(&rig.handles().labels).unwrap();
        positions.truncate(40 * 3 * rig.handles().len());
        let spread = Uncertainty::new(&rig, &positions).unwrap().unwrap();
        let all: Vec<VertexId> = (0..rig.vertices()).map(VertexId::from_index).collect();
        let exact = Confidence::new(&rig, &all).unwrap();
        let left_out: Vec<f64> = exact.left_out().collect();
        let variances = exact.variances(positions.as_chunks::<3>().0);
        let (mut off, mut size) = (0.0, 0.0);
        let (mut sigma, mut off_sigma, mut size_sigma) = (Vec::new(), 0.0, 0.0);
        for (frame, variances) in variances.chunks(all.len()).enumerate() {
            let samples = spread.samples(frame);
            spread.sigma(frame, &mut sigma);
            assert!(rig.handles().held().all(|v| sigma[v.index()] == 0.0));
            for (v, variance) in variances.iter().enumerate().filter(|(v, _)| left_out[*v] > 0.0) {
                let relative = (variance / left_out[v]).sqrt();
                off += (f64::from(spread.at(v, samples)) - relative).powi(2);
                size += relative.powi(2);
                off_sigma += (f64::from(sigma[v]) - variance.sqrt()).powi(2);
                size_sigma += variance;
            }
        }
        assert!(size > 0.0 && (off / size).sqrt() < 0.4, "{}", (off / size).sqrt());
        assert!((off_sigma / size_sigma).sqrt() < 0.4, "{}", (off_sigma / size_sigma).sqrt());
    }
}
