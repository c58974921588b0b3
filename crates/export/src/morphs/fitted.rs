//! Other attributes for the weights that the positions have: least squares over the frames, as normals are
//! fitted.

use super::basis::Basis;
use super::factors::{follow, project};
use super::frames::{Attribute, Frames};
use super::measure::Offs;
use super::parts::{Moving, Part, for_each};
use super::span::Span;
use super::values::{Fitted, Off};
use rhytid_core::Result;

/// Fits attribute `extra` of all frames to the weights. Those of column k end at `tops[k]`. The second result
/// has the errors of each clip.
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
) -> Result<(Fitted, Vec<Off>)> {
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

    let target = |k: usize, i: usize| f64::from(targets[k][i]);
    let moving = Moving { target, targets: k, weights };
    let look = |part: &Part<'_>| {
        let base = &base[3 * part.vertex..][..3 * part.vertices];
        let (mut worst, mut sum) = (0.0_f64, 0.0);
        for frame in part.frames.clone() {
            let (moved, given) = (part.moved(frame), part.given(frame));
            for v in 0..part.vertices {
                let square = |i: usize| (f64::from(base[i]) + moved[i] - f64::from(given[i])).powi(2);
                let square: f64 = (3 * v..3 * v + counted).map(square).sum();
                worst = worst.max(square);
                sum += square;
            }
        }
        (worst, sum)
    };
    let mut offs = Offs::new(frames);
    for_each(frames, Attribute::Extra(extra), &moving, look, |clip, (worst, sum)| {
        offs.add(clip, worst, sum);
    })?;
    Ok((Fitted { base, targets }, offs.finish(frames)))
}
