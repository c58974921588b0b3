//! The distance of the numbers of the file from the frames that came in.

use super::frames::{Attribute, Frames, TASK};
use super::linear::product;
use super::values::{NormalsOff, Values, Worst};
use faer::{Mat, MatRef};
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::Result;

/// The stored numbers that a reader computes positions from.
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
    let weights = Mat::from_fn(f, k, |i, j| f64::from(stored.weights[i * k + j]));
    let rounding = (k + 6) as f64 * f64::from(f32::EPSILON) / 2.0;
    let zero = vec![0.0; 3 * frames.vertices()];
    let mut worst = Worst { error: -1.0, frame: 0, vertex: 0 };
    let mut sum = 0.0;
    for first in frames.blocks() {
        let block = frames.block(Attribute::Positions, first, &zero)?;
        let parts: Vec<(Worst, f64)> = block
            .values
            .par_chunks(3 * TASK * f)
            .enumerate()
            .map(|(part, values)| {
                let columns = values.len() / f;
                let start = 3 * (first + part * TASK);
                let t: Vec<f64> = (0..columns)
                    .flat_map(|c| stored.targets.iter().map(move |target| scale * target.get(start + c)))
                    .collect();
                let moved = product(weights.as_ref(), MatRef::from_column_major_slice(&t, k, columns));
                let mut worst = Worst { error: -1.0, frame: 0, vertex: 0 };
                let mut sum = 0.0;
                for v in 0..columns / 3 {
                    let columns = [3 * v, 3 * v + 1, 3 * v + 2];
                    let shift = DVec3::from(stored.translation.map(f64::from));
                    let base = DVec3::from(columns.map(|c| scale * stored.base.get(start + c)));
                    let targets = |c: usize| t[c * k..][..k].iter().map(|t| t.abs()).sum::<f64>();
                    let size = shift.abs() + base.abs() + DVec3::from(columns.map(targets));
                    let noise = rounding * size.length();
                    for i in 0..f {
                        let moved = DVec3::from(columns.map(|c| moved[(i, c)]));
                        let given = DVec3::from(columns.map(|c| f64::from(values[c * f + i])));
                        let error = (shift + base + moved - given).length();
                        sum += error * error;
                        if error + noise > worst.error {
                            worst = Worst { error: error + noise, frame: i, vertex: start / 3 + v };
                        }
                    }
                }
                (worst, sum)
            })
            .collect();
        for part in parts {
            sum += part.1;
            if part.0.error > worst.error {
                worst = part.0;
            }
        }
    }
    Ok((worst, (sum / (f * frames.vertices()) as f64).sqrt()))
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
    let (f, k) = (frames.frames(), targets.len());
    let weights = Mat::from_fn(f, k, |i, j| f64::from(weights[i * k + j]));
    let zero = vec![0.0; 3 * frames.vertices()];
    let (mut worst, mut sum) = (0.0_f64, 0.0);
    for first in frames.blocks() {
        let block = frames.block(Attribute::Normals, first, &zero)?;
        let parts: Vec<(f64, f64)> = block
            .values
            .par_chunks(3 * TASK * f)
            .enumerate()
            .map(|(part, values)| {
                let columns = values.len() / f;
                let start = 3 * (first + part * TASK);
                let t: Vec<f64> = (start..start + columns)
                    .flat_map(|i| targets.iter().map(move |target| target.get(i)))
                    .collect();
                let moved = product(weights.as_ref(), MatRef::from_column_major_slice(&t, k, columns));
                let (mut worst, mut sum) = (0.0_f64, 0.0);
                for v in 0..columns / 3 {
                    let columns = [3 * v, 3 * v + 1, 3 * v + 2];
                    let base = DVec3::from(columns.map(|c| base.get(start + c)));
                    for i in 0..f {
                        let moved = DVec3::from(columns.map(|c| moved[(i, c)]));
                        let given = DVec3::from(columns.map(|c| f64::from(values[c * f + i])));
                        let square = ((base + moved).normalize_or_zero() - given).length_squared();
                        worst = worst.max(square);
                        sum += square;
                    }
                }
                (worst, sum)
            })
            .collect();
        for part in parts {
            worst = worst.max(part.0);
            sum += part.1;
        }
    }
    Ok(NormalsOff { worst: worst.sqrt(), rms: (sum / (f * frames.vertices()) as f64).sqrt() })
}
