//! The mouth's opening and lips.
use super::site::{MOUTH_CUT, MOUTH_LINE, Site};
use crate::curve::{Curve, bell, pair, ramp, soft_max};
use glam::DVec3;

/// The width of the inside of the lips beside the cut, in the domain.
const INNER: f64 = 0.3;
/// How far the inside reaches back.
const INNER_DEPTH: f64 = 0.4;
/// Half the gap between the closed lips.
const GAP: f64 = 0.02;
/// Over this distance from the cut the domain makes room for the inside.
const REACH: f64 = 2.4;

#[derive(Debug)]
pub(crate) struct Mouth {
    /// y of the line between the lips, by the distance from the midline.
    line: Curve,
    /// Height of the upper lip's red, by the distance from the midline.
    upper: Curve,
    /// Height of the lower lip's red.
    lower: Curve,
    /// How far a lip stands out. Its argument is the distance from the line, in heights of the red.
    roll: Curve,
}

impl Mouth {
    pub(crate) fn new() -> Self {
        Self {
            line: Curve::new(&[
                [0.0, -6.52],
                [0.5, -6.46],
                [1.2, -6.43],
                [2.0, -6.47],
                [2.6, -6.47],
                [4.0, -6.4],
            ]),
            upper: Curve::new(&[
                [0.0, 0.66],
                [0.42, 0.78],
                [1.0, 0.62],
                [1.8, 0.36],
                [2.65, 0.12],
                [4.0, 0.1],
            ]),
            lower: Curve::new(&[
                [0.0, 0.98],
                [0.6, 0.95],
                [1.2, 0.78],
                [1.9, 0.46],
                [2.65, 0.14],
                [4.0, 0.1],
            ]),
            roll: Curve::new(&[
                [0.0, 0.1],
                [0.18, 0.64],
                [0.5, 1.0],
                [0.85, 0.86],
                [1.05, 0.66],
                [1.3, 0.46],
                [1.8, 0.22],
                [2.6, 0.05],
                [3.4, 0.0],
            ]),
        }
    }

    fn inner(across: f64) -> f64 {
        INNER * (1.0 - (across / MOUTH_CUT).powi(2).min(1.0)).powf(0.7)
    }

    /// `up` after the inside of the lips is folded in.
    pub(crate) fn open(&self, site: Site, up: f64) -> f64 {
        let from_cut = (site.up - MOUTH_LINE).abs();
        let reach = ramp(from_cut, REACH, 0.0);
        let inner = Self::inner(site.across);
        let shrunk = soft_max(from_cut - inner, 0.0, 0.25 * inner) - from_cut + GAP * inner / INNER;
        let line = self.line.at(site.across.abs()) - MOUTH_LINE;
        up + reach * (line + if site.above_mouth { shrunk } else { -shrunk })
    }

    /// The displacement by the lips of the point at `x`, `y`.
    pub(crate) fn lips(&self, site: Site, x: f64, y: f64) -> DVec3 {
        let side = x.abs();
        if side > 5.0 || !(-9.5..-3.5).contains(&y) {
            return DVec3::ZERO;
        }
        let from_line = (y - self.line.at(side)).abs();
        let (red, fullness) = if site.above_mouth {
            (self.upper.at(side), 0.52 + 0.06 * bell(x, 0.0, 0.3))
        } else {
            (self.lower.at(side), 0.56 - 0.04 * bell(x, 0.0, 0.25))
        };
        let across = ramp(side, 3.0, 0.6);
        let q = from_line / red.max(0.1);
        let roll = if q < 3.4 { fullness * across * self.roll.at(q) } else { 0.0 };
        // Between the lips the surface turns inwards.
        let inner = Self::inner(site.across);
        let from_cut = (site.up - MOUTH_LINE).abs();
        let inside = (1.0 - from_cut / (1.15 * inner + 1e-9)).max(0.0).powf(1.5);
        let seam = -0.1 * bell(from_line, 0.0, 0.16) * ramp(side, 3.1, 2.3);
        let philtrum = if site.above_mouth {
            0.1 * (pair(x, 0.42, 0.22) - 1.1 * bell(x, 0.0, 0.26)) * bell(y, -5.3, 0.5)
        } else {
            0.0
        };
        DVec3::new(0.0, 0.0, roll + seam + philtrum - INNER_DEPTH * inside * inner / INNER)
    }
}
