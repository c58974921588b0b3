//! The distance of the numbers of the file from the frames that came in.

use super::frames::{Attribute, Frames};
use super::parts::{Moving, Part, for_each};
use super::values::{NormalsOff, Values, Worst};
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

/// The worst error and the root of the mean squared error, over all vertices and frames. The worst error
/// includes what float32 may add in any order of the sum: `(K + 6) 2⁻²⁴` times the sum of the sizes of its
/// terms.
///
/// # Errors
/// [`rhytid_core::Error::Io`].
pub(super) fn measure(frames: &mut Frames, stored: &Stored<'_>) -> Result<(Worst, f64)> {
    let (f, k) = (frames.frames(), stored.targets.len());
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
    let mut worst = Worst { error: -1.0, frame: 0, vertex: 0 };
    let mut sum = 0.0;
    for_each(frames, Attribute::Positions, &moving, look, |part| {
        sum += part.1;
        if part.0.error > worst.error {
            worst = part.0;
        }
    })?;
    Ok((worst, (sum / (f * frames.vertices()) as f64).sqrt()))
}

/// A vertex of the base mesh in mesh units, and what float32 may add to its error.
struct Place {
    base: DVec3,
    noise: f64,
}

/// The largest difference of a unit normal from the one that came in, as a length, and the root of the mean
/// of its square, over all vertices and frames.
///
/// # Errors
/// [`rhytid_core::Error::Io`].
pub(super) fn measure_normals(
    frames: &mut Frames,
    base: &Values,
    targets: &[&Values],
    weights: &[f32],
) -> Result<NormalsOff> {
    let f = frames.frames();
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
    let (mut worst, mut sum) = (0.0_f64, 0.0);
    for_each(frames, Attribute::Normals, &moving, look, |part| {
        worst = worst.max(part.0);
        sum += part.1;
    })?;
    Ok(NormalsOff { worst: worst.sqrt(), rms: (sum / (f * frames.vertices()) as f64).sqrt() })
}
