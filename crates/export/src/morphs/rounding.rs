//! From a basis to the numbers of the file: weights from 0 to 1, offsets as float32 or as small integers.
//!
//! A target and its weights can be scaled against each other. So an integer target needs only as many levels
//! as its motion has steps of a size that matters. Its largest weight is then below 1.
//!
//! All targets get the same step in the basis (see [`super::basis`]): the largest step with which the bound
//! holds. Most targets then fit into 8 bits and use few of the values, which makes the file compress well.

use super::basis::Basis;
use super::fitted;
use super::frames::Frames;
use super::measure::{Measured, Stored, largest, measure, measure_normals};
use super::normals::Normals;
use super::settings::Settings;
use super::span::{Span, spans};
use super::values::{ClipErrors, Morphs, Target, Values, to_i8, to_i16};
use rayon::prelude::*;
use rhytid_core::{Progress, Result};

/// The first step that is tried, as a part of the bound.
const FIRST_STEP: f64 = 0.12;
/// The next step as a part of the one before.
const FINER: f64 = 0.85;
/// How many steps are tried.
const STEPS: usize = 24;
/// The base mesh is stored as 16-bit integers if their rounding uses at most this part of the bound, and as
/// float32 otherwise.
const SHARE_OF_BASE: f64 = 0.05;

/// How the positions of one target are stored.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    F32,
    I16,
    I8,
}

/// The node's scale and translation, the base, the targets, and the largest weight of each target.
struct Positions {
    scale: f32,
    translation: [f32; 3],
    base: Values,
    targets: Vec<Values>,
    tops: Vec<f64>,
}

/// The numbers of the file and their error. The error may be beyond the bound: with integers only if no step
/// is fine enough. Of each step, the frames of `hardest` are looked at first, and all only if these are
/// within the bound.
///
/// # Errors
/// [`rhytid_core::Error::Io`]; [`rhytid_core::Error::Cancelled`].
pub(super) fn round(
    frames: &mut Frames,
    center: &[f32],
    hardest: &[usize],
    basis: &Basis,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Morphs> {
    const NAME: &str = "round and measure";
    let spans = spans(basis);
    let normals = if frames.has_normals() {
        Some(Normals::fit(frames, basis, &spans, settings.quantize)?)
    } else {
        None
    };
    let tries = if settings.quantize { STEPS } else { 1 };
    let mut size = FIRST_STEP * settings.max_error;
    let mut done = 0;
    let (positions, weights, measured) = loop {
        progress.step(NAME, done as u64, tries as u64)?;
        let positions = if settings.quantize {
            integers(center, basis, &spans, size, settings.max_error, normals.as_ref())
        } else {
            floats(center, basis, &spans)
        };
        let weights = weights(basis, &spans, &positions.tops);
        let Positions { scale, translation, ref base, ref targets, .. } = positions;
        let stored = Stored { scale, translation, base, targets, weights: &weights };
        done += 1;
        if done < tries && hardest.len() < frames.frames() {
            let k = targets.len();
            let some: Vec<f32> = hardest.iter().flat_map(|&i| &weights[i * k..][..k]).copied().collect();
            frames.choose(hardest.to_vec());
            let worst = largest(&measure(frames, &Stored { weights: &some, ..stored })?);
            frames.choose_all();
            if worst > settings.max_error {
                size *= FINER;
                continue;
            }
        }
        let measured = measure(frames, &stored)?;
        if largest(&measured) <= settings.max_error || done == tries {
            break (positions, weights, measured);
        }
        size *= FINER;
    };
    progress.step(NAME, tries as u64, tries as u64)?;
    let Positions { scale, translation, base, targets, tops } = positions;
    let extras = 0..frames.extras().len();
    let extras = extras.map(|extra| fitted::fit(frames, extra, basis, &spans, &tops, &weights));
    let (extras, extras_off): (Vec<_>, Vec<_>) = extras.collect::<Result<Vec<_>>>()?.into_iter().unzip();
    let targets = targets.into_iter().enumerate().map(|(k, positions)| Target {
        name: format!("shape {:02}", k + 1),
        positions,
        normals: normals.as_ref().map(|normals| normals.target(k, tops[k], settings.quantize)),
    });
    let targets: Vec<Target> = targets.collect();
    let base_normals = normals.as_ref().map(|normals| normals.base(settings.quantize));
    let normals_off = match &base_normals {
        Some(base) => {
            let targets: Vec<&Values> = targets.iter().filter_map(|target| target.normals.as_ref()).collect();
            Some(measure_normals(frames, base, &targets, &weights)?)
        }
        None => None,
    };
    let of_clip = |(clip, measured): (usize, &Measured)| ClipErrors {
        worst: measured.worst,
        rms: measured.rms,
        extras: extras_off.iter().map(|of_extra| of_extra[clip]).collect(),
        normals: normals_off.as_ref().map(|of_normals| of_normals[clip]),
    };
    let clips = measured.iter().enumerate().map(of_clip).collect();
    Ok(Morphs { scale, translation, base, base_normals, targets, weights, extras, clips })
}

/// The weights, frames × K; those of column k run from 0 to `tops[k]`.
fn weights(basis: &Basis, spans: &[Span], tops: &[f64]) -> Vec<f32> {
    (0..basis.weights.nrows())
        .flat_map(|frame| {
            spans.iter().zip(tops).enumerate().map(move |(k, (span, top))| {
                let w = (basis.weights[(frame, k + 1)] - span.zero) / span.range;
                (w.clamp(0.0, 1.0) * top) as f32
            })
        })
        .collect()
}

/// Component i of the base mesh, if column k moves component i by `offset(k)` for each unit of its weights.
fn base(center: &[f32], basis: &Basis, spans: &[Span], i: usize, offset: impl Fn(usize) -> f64) -> f64 {
    let n = spans.len() + 1;
    let zero: f64 = spans.iter().enumerate().map(|(k, span)| span.zero * offset(k)).sum();
    f64::from(center[i]) + f64::from(basis.t[i * n]) + zero
}

fn floats(center: &[f32], basis: &Basis, spans: &[Span]) -> Positions {
    let n = spans.len() + 1;
    let components = 0..center.len();
    let exact = |i: usize, k: usize| f64::from(basis.t[i * n + k + 1]);
    let target = |(k, span): (usize, &Span)| {
        Values::F32(components.clone().into_par_iter().map(|i| (exact(i, k) * span.range) as f32).collect())
    };
    let targets = spans.iter().enumerate().map(target).collect();
    let base =
        components.clone().into_par_iter().map(|i| base(center, basis, spans, i, |k| exact(i, k)) as f32);
    let base = Values::F32(base.collect());
    Positions { scale: 1.0, translation: [0.0; 3], base, targets, tops: vec![1.0; spans.len()] }
}

/// `size` is the step in mesh units for a unit of a column's weights.
fn integers(
    center: &[f32],
    basis: &Basis,
    spans: &[Span],
    size: f64,
    max_error: f64,
    normals: Option<&Normals>,
) -> Positions {
    let n = spans.len() + 1;
    let components = 0..center.len();
    let exact = |i: usize, k: usize| f64::from(basis.t[i * n + k + 1]);
    let reach: Vec<f64> = (0..spans.len())
        .map(|k| {
            let largest =
                components.clone().into_par_iter().map(|i| exact(i, k).abs()).reduce(|| 0.0, f64::max);
            largest * spans[k].range.abs()
        })
        .collect();
    // The box of the base mesh. Rounding the targets moves the base a little, hence the margin.
    let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    let smooth: Vec<f64> =
        components.clone().into_par_iter().map(|i| base(center, basis, spans, i, |k| exact(i, k))).collect();
    for (i, x) in smooth.into_iter().enumerate() {
        let [low, high] = &mut bounds[i % 3];
        (*low, *high) = (low.min(x), high.max(x));
    }
    let translation = bounds.map(|[low, high]| low.midpoint(high) as f32);
    let margin: f64 = spans.iter().map(|span| size * span.zero.abs()).sum();
    let half = bounds.iter().map(|[low, high]| (high - low) / 2.0).fold(0.0, f64::max) + margin;
    let extent =
        (half * 1.001).max(reach.iter().copied().fold(0.0, f64::max)).max(f64::from(f32::MIN_POSITIVE));
    let scale = extent as f32;
    let extent = f64::from(scale);

    let mut tops = vec![1.0; spans.len()];
    let mut kinds = vec![Kind::F32; spans.len()];
    for (k, span) in spans.iter().enumerate() {
        // The offsets of normals are not scaled and end at 1. This keeps the weights from becoming too small.
        let least = normals.map_or(0.0, |normals| normals.reach(k)).min(1.0);
        for (kind, levels) in [(Kind::I8, 127.0), (Kind::I16, 32767.0)] {
            let top = (levels * size * span.range.abs() / extent).min(1.0);
            if top >= least && reach[k] <= top * extent * (1.0 + 1e-9) {
                (kinds[k], tops[k]) = (kind, top);
                break;
            }
        }
    }
    let stored = |i: usize, k: usize| exact(i, k) * spans[k].range / (tops[k] * extent);
    let values = |k: usize| match kinds[k] {
        Kind::F32 => Values::F32(components.clone().into_par_iter().map(|i| stored(i, k) as f32).collect()),
        Kind::I16 => Values::I16(components.clone().into_par_iter().map(|i| to_i16(stored(i, k))).collect()),
        Kind::I8 => Values::I8(components.clone().into_par_iter().map(|i| to_i8(stored(i, k))).collect()),
    };
    let targets: Vec<Values> = (0..spans.len()).map(values).collect();
    let rounded = |i: usize, k: usize| targets[k].get(i) * tops[k] * extent / spans[k].range;
    let base = components
        .clone()
        .into_par_iter()
        .map(|i| (base(center, basis, spans, i, |k| rounded(i, k)) - f64::from(translation[i % 3])) / extent);
    let base = if 3.0_f64.sqrt() / 2.0 * extent / 32767.0 <= SHARE_OF_BASE * max_error {
        Values::I16(base.map(to_i16).collect())
    } else {
        Values::F32(base.map(|x| x as f32).collect())
    };
    Positions { scale, translation, base, targets, tops }
}
