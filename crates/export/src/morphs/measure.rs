//! The distance of the numbers of the file from the frames that came in.

use super::frames::{Attribute, Frames};
use super::parts::{Moving, Part, for_each};
use super::values::{Off, Values, Worst};
use glam::DVec3;
use rhytid_core::Result;

/// The stored numbers that a reader computes positions from.
#[derive(Clone, Copy)]
pub(super) struct Stored<'a> {
    pub scale: f32,
    pub translation: [f32; 3],
    pub base: &'a Values,
    pub targets: &'a [Values],
    /// Frames × K.
    pub weights: &'a [f32],
}

/// The errors of a clip's positions.
#[derive(Clone, Copy)]
pub(super) struct Measured {
    pub worst: Worst,
    /// The root of the mean squared error over all vertices and frames.
    pub rms: f64,
}

/// The errors of each clip. The worst error includes what float32 may add in any order of the sum:
/// `(K + 6) 2⁻²⁴` times the sum of the sizes of its terms.
///
/// # Errors
/// [`rhytid_core::Error::Io`].
pub(super) fn measure(frames: &mut Frames, stored: &Stored<'_>) -> Result<Vec<Measured>> {
    let k = stored.targets.len();
    let scale = f64::from(stored.scale);
    let rounding = (k + 6) as f64 * f64::from(f32::EPSILON) / 2.0;
    let shift = DVec3::from(stored.translation.map(f64::from));
    let target = |k: usize, i: usize| scale * stored.targets[k].get(i);
    let moving = Moving { target, targets: k, weights: stored.weights };
    let look = |part: &Part<'_>| {
        let place = |v: usize| {
            let columns = [3 * v, 3 * v + 1, 3 * v + 2];
            let base = DVec3::from(columns.map(|c| scale * stored.base.get(3 * part.vertex + c)));
            let targets = |c: usize| part.targets[c * k..][..k].iter().map(|t| t.abs()).sum::<f64>();
            let size = shift.abs() + base.abs() + DVec3::from(columns.map(targets));
            Place { base: shift + base, noise: rounding * size.length() }
        };
        let places: Vec<Place> = (0..part.vertices).map(place).collect();
        let mut worst = Worst { error: -1.0, frame: 0, vertex: 0 };
        let mut sum = 0.0;
        for frame in part.frames.clone() {
            let moved = part.moved(frame).as_chunks::<3>().0.iter().zip(part.given(frame).as_chunks::<3>().0);
            for (v, (place, (&moved, given))) in places.iter().zip(moved).enumerate() {
                let error = (place.base + DVec3::from(moved) - DVec3::from(given.map(f64::from))).length();
                sum += error * error;
                if error + place.noise > worst.error {
                    worst = Worst { error: error + place.noise, frame, vertex: part.vertex + v };
                }
            }
        }
        (worst, sum)
    };
    let none = Measured { worst: Worst { error: -1.0, frame: 0, vertex: 0 }, rms: 0.0 };
    let mut clips = vec![none; frames.clips()];
    let mut sums = vec![0.0; clips.len()];
    for_each(frames, Attribute::Positions, &moving, look, |clip, (worst, sum)| {
        sums[clip] += sum;
        if worst.error > clips[clip].worst.error {
            clips[clip].worst = worst;
        }
    })?;
    let counts = values_of_clips(frames);
    for (clip, measured) in clips.iter_mut().enumerate() {
        measured.rms = (sums[clip] / counts[clip]).sqrt();
        measured.worst.frame = measured.worst.frame.saturating_sub(frames.begin(clip));
    }
    Ok(clips)
}

/// The largest error of all clips.
pub(super) fn largest(clips: &[Measured]) -> f64 {
    clips.iter().map(|clip| clip.worst.error).fold(-1.0, f64::max)
}

/// For each clip, how many pairs of a vertex and a frame it has; at least 1.
fn values_of_clips(frames: &Frames) -> Vec<f64> {
    let mut counts = vec![0; frames.clips()];
    (0..frames.frames()).for_each(|frame| counts[frames.clip(frame)] += frames.vertices());
    counts.into_iter().map(|count| count.max(1) as f64).collect()
}

/// Collects the errors of an attribute, clip by clip.
pub(super) struct Offs {
    worst: Vec<f64>,
    sums: Vec<f64>,
}

impl Offs {
    pub(super) fn new(frames: &Frames) -> Self {
        Self { worst: vec![0.0; frames.clips()], sums: vec![0.0; frames.clips()] }
    }

    /// Adds the largest square and the sum of all squares of a part of a clip.
    pub(super) fn add(&mut self, clip: usize, largest: f64, sum: f64) {
        self.worst[clip] = self.worst[clip].max(largest);
        self.sums[clip] += sum;
    }

    /// The errors of each clip.
    pub(super) fn finish(self, frames: &Frames) -> Vec<Off> {
        let counts = values_of_clips(frames);
        let of_clip =
            |((worst, sum), count): ((f64, f64), f64)| Off { worst: worst.sqrt(), rms: (sum / count).sqrt() };
        self.worst.into_iter().zip(self.sums).zip(counts).map(of_clip).collect()
    }
}

/// A vertex of the base mesh in mesh units, and what float32 may add to its error.
struct Place {
    base: DVec3,
    noise: f64,
}

/// How far the unit normals of each clip are from those that came in.
///
/// # Errors
/// [`rhytid_core::Error::Io`].
pub(super) fn measure_normals(
    frames: &mut Frames,
    base: &Values,
    targets: &[&Values],
    weights: &[f32],
) -> Result<Vec<Off>> {
    let target = |k: usize, i: usize| targets[k].get(i);
    let moving = Moving { target, targets: targets.len(), weights };
    let look = |part: &Part<'_>| {
        let start = 3 * part.vertex;
        let base: Vec<f64> = (start..start + 3 * part.vertices).map(|i| base.get(i)).collect();
        let (mut worst, mut sum) = (0.0_f64, 0.0);
        for frame in part.frames.clone() {
            let moved = part.moved(frame).as_chunks::<3>().0.iter().zip(part.given(frame).as_chunks::<3>().0);
            for (&base, (&moved, given)) in base.as_chunks::<3>().0.iter().zip(moved) {
                let normal = (DVec3::from(base) + DVec3::from(moved)).normalize_or_zero();
                let square = (normal - DVec3::from(given.map(f64::from))).length_squared();
                worst = worst.max(square);
                sum += square;
            }
        }
        (worst, sum)
    };
    let mut offs = Offs::new(frames);
    for_each(frames, Attribute::Normals, &moving, look, |clip, (worst, sum)| offs.add(clip, worst, sum))?;
    Ok(offs.finish(frames))
}
