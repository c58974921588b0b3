//! Normals for the weights that the positions have: least squares over the frames.

use super::basis::Basis;
use super::factors::{follow, project};
use super::frames::{Attribute, Frames};
use super::span::Span;
use super::values::{Values, to_i8};
use glam::DVec3;
use rhytid_core::Result;

/// A base normal is divided by its length, but by no less than this. Otherwise the offsets of its vertex
/// would grow without bound.
const SHORTEST: f64 = 0.25;

/// Bisection steps that find the part of a vertex's turning that small integers can hold.
const HALVINGS: usize = 20;

/// Normals as combinations of the basis's columns.
pub(super) struct Normals {
    /// Column-major n×3V.
    t: Vec<f32>,
    spans: Vec<Span>,
    /// V×3: the sums at weights 0, not yet of length 1.
    base: Vec<DVec3>,
    /// V: the factor of the offsets of each vertex.
    scales: Vec<f64>,
    /// For each target, its largest offset at the full range of its weights.
    reach: Vec<f64>,
}

impl Normals {
    /// Fits the normals of all frames. With `quantize`, no offset is larger than 1: see [`turning`].
    ///
    /// # Errors
    /// [`rhytid_core::Error::Io`].
    pub(super) fn fit(frames: &mut Frames, basis: &Basis, spans: &[Span], quantize: bool) -> Result<Self> {
        let n = spans.len() + 1;
        let zero = vec![0.0; 3 * frames.vertices()];
        let mut t = project(frames, Attribute::Normals, &zero, &basis.q)?;
        follow(&mut t, &basis.turn, n);
        let frames = basis.weights.nrows() as f64;
        let means: Vec<f64> = (1..n).map(|k| basis.weights.col(k).iter().sum::<f64>() / frames).collect();
        let zeros: Vec<f64> = spans.iter().map(|span| span.zero).collect();
        // The sums of a vertex at some weights.
        let at = |vertex: &[f32], weights: &[f64]| {
            let mut components = vertex.chunks(n).map(|t| {
                f64::from(t[0]) + t[1..].iter().zip(weights).map(|(&t, w)| f64::from(t) * w).sum::<f64>()
            });
            DVec3::from([0, 1, 2].map(|_| components.next().unwrap_or(0.0)))
        };
        let (mut base, mut scales) = (Vec::new(), Vec::new());
        for vertex in t.chunks(3 * n) {
            let at_zero = at(vertex, &zeros);
            let offsets = vertex.chunks(n).flat_map(|t| t[1..].iter().zip(spans));
            let largest = offsets.map(|(&t, span)| (f64::from(t) * span.range).abs()).fold(0.0, f64::max);
            if quantize && largest > at_zero.length() {
                let turned = turning(at(vertex, &means), at_zero, largest);
                scales.push(turned.part / turned.base.length().max(f64::MIN_POSITIVE));
                base.push(turned.base);
            } else {
                scales.push(1.0 / at_zero.length().max(SHORTEST));
                base.push(at_zero);
            }
        }
        let mut normals = Self { t, spans: spans.to_vec(), base, scales, reach: Vec::new() };
        let largest = |k: usize| normals.components().map(|i| normals.offset(i, k).abs()).fold(0.0, f64::max);
        normals.reach = (0..spans.len()).map(largest).collect();
        Ok(normals)
    }

    fn components(&self) -> std::ops::Range<usize> {
        0..3 * self.base.len()
    }

    /// Offset i of target k at the full range of its weights. The base and the offsets of a vertex are scaled
    /// alike, so that the base gets length 1. This keeps the direction of their sum.
    fn offset(&self, i: usize, k: usize) -> f64 {
        let n = self.spans.len() + 1;
        f64::from(self.t[i * n + k + 1]) * self.spans[k].range * self.scales[i / 3]
    }

    /// The largest offset of target k at the full range of its weights.
    pub(super) fn reach(&self, k: usize) -> f64 {
        self.reach[k]
    }

    /// The offsets of target k, whose weights end at `top`.
    pub(super) fn target(&self, k: usize, top: f64, quantize: bool) -> Values {
        let offsets = self.components().map(|i| self.offset(i, k) / top);
        if quantize && self.reach(k) <= top {
            Values::I8(offsets.map(to_i8).collect())
        } else {
            Values::F32(offsets.map(|x| x as f32).collect())
        }
    }

    /// The unit normals of the base mesh; (0, 0, 1) where there is none.
    pub(super) fn base(&self, quantize: bool) -> Values {
        let unit = self.base.iter().flat_map(|&n| {
            let length = n.length();
            if length > 1e-6 { (n / length).to_array() } else { [0.0, 0.0, 1.0] }
        });
        if quantize {
            Values::I8(unit.map(to_i8).collect())
        } else {
            Values::F32(unit.map(|x| x as f32).collect())
        }
    }
}

/// A vertex that turns less.
struct Turned {
    /// The part of its turning that is kept, from 0 to 1.
    part: f64,
    base: DVec3,
}

/// Reduces the turning of a vertex whose offsets do not fit into normalised integers.
///
/// Where the normals of a vertex nearly cancel at weights 0, its offsets are longer than its base. No
/// normalised integer holds such offsets, and a handful of these vertices would make whole targets 32-bit. So
/// their normals turn less about the mean over the frames. This finds the largest part of the turning with
/// which the base is at least as long as the `largest` offset. It returns that part and its base.
fn turning(mean: DVec3, at_zero: DVec3, largest: f64) -> Turned {
    let base = |part: f64| (1.0 - part) * mean + part * at_zero;
    let (mut enough, mut most) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let part = f64::midpoint(enough, most);
        if part * largest <= base(part).length() { enough = part } else { most = part }
    }
    Turned { part: enough, base: base(enough) }
}
