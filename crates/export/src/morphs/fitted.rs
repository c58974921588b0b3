//! Other attributes for the weights that the positions have: least squares over the frames, as normals are
//! fitted.

use super::basis::Basis;
use super::factors::{follow, project};
use super::frames::{Attribute, Frames, TASK};
use super::linear::product;
use super::span::Span;
use super::values::Fitted;
use faer::{Mat, MatRef};
use rayon::prelude::*;
use rhytid_core::Result;

/// Fits attribute `extra` of all frames to the weights. Those of column k end at `tops[k]`.
///
/// # Errors
/// [`rhytid_core::Error::Io`].
pub(super) fn fit(
    frames: &mut Frames,
    extra: usize,
    basis: &Basis,
    spans: &[Span],
    tops: &[f64],
    weights: &[f32],
) -> Result<Fitted> {
    let (k, n) = (spans.len(), spans.len() + 1);
    let counted = frames.extras()[extra];
    let zero = vec![0.0; 3 * frames.vertices()];
    let mut t = project(frames, Attribute::Extra(extra), &zero, &basis.q)?;
    follow(&mut t, &basis.turn, n);
    let at_zero = |t: &[f32]| {
        let moved: f64 = t[1..].iter().zip(spans).map(|(&t, span)| f64::from(t) * span.zero).sum();
        (f64::from(t[0]) + moved) as f32
    };
    let base: Vec<f32> = t.chunks(n).map(at_zero).collect();
    let target = |k: usize| -> Vec<f32> {
        t.chunks(n).map(|t| (f64::from(t[k + 1]) * spans[k].range / tops[k]) as f32).collect()
    };
    let targets: Vec<Vec<f32>> = (0..k).map(target).collect();

    let f = frames.frames();
    let weights = Mat::from_fn(f, k, |i, j| f64::from(weights[i * k + j]));
    let (mut worst, mut sum) = (0.0_f64, 0.0);
    for first in frames.blocks() {
        let block = frames.block(Attribute::Extra(extra), first, &zero)?;
        let parts: Vec<(f64, f64)> = block
            .values
            .par_chunks(3 * TASK * f)
            .enumerate()
            .map(|(part, values)| {
                let start = 3 * (first + part * TASK);
                let columns = values.len() / f;
                let t: Vec<f64> = (start..start + columns)
                    .flat_map(|i| targets.iter().map(move |target| f64::from(target[i])))
                    .collect();
                let moved = product(weights.as_ref(), MatRef::from_column_major_slice(&t, k, columns));
                let (mut worst, mut sum) = (0.0_f64, 0.0);
                for v in 0..columns / 3 {
                    for frame in 0..f {
                        let square = |column: usize| {
                            let stored = f64::from(base[start + column]) + moved[(frame, column)];
                            (stored - f64::from(values[column * f + frame])).powi(2)
                        };
                        let square: f64 = (3 * v..3 * v + counted).map(square).sum();
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
    Ok(Fitted { base, targets, worst: worst.sqrt(), rms: (sum / (f * frames.vertices()) as f64).sqrt() })
}
