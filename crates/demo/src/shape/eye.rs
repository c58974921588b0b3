//! The eyes' openings and lids.
use super::site::{EYE_CUT, EYE_LINE, Site};
use crate::curve::{Curve, bell, plateau, ramp, soft_max};

/// The eyeball's centre; the lids lie on it.
const BALL: [f64; 3] = [3.04, 0.02, -2.07];
/// The lids' outer radius.
const LID_RADIUS: f64 = 1.42;
/// The width of the lid's margin beside the cut, in the domain. The margin faces the eyeball.
const MARGIN: f64 = 0.1;
/// Over this distance from the cut the domain makes room for the opening.
const REACH: f64 = 2.2;

#[derive(Debug)]
pub(crate) struct Eye {
    /// The height of the upper lid's rim over the line between the corners. Its argument is the way from the
    /// inner corner (0) to the outer one (1).
    upper: Curve,
    /// The depth of the lower lid's rim below this line.
    lower: Curve,
}

impl Eye {
    pub(crate) fn new() -> Self {
        Self {
            upper: Curve::new(&[
                [0.0, 0.0],
                [0.1, 0.19],
                [0.25, 0.4],
                [0.45, 0.52],
                [0.65, 0.47],
                [0.85, 0.25],
                [1.0, 0.0],
            ]),
            lower: Curve::new(&[
                [0.0, 0.0],
                [0.1, 0.1],
                [0.3, 0.24],
                [0.6, 0.36],
                [0.8, 0.28],
                [0.92, 0.14],
                [1.0, 0.0],
            ]),
        }
    }

    /// The way from the inner corner to the outer.
    fn way(across: f64) -> f64 {
        ((across.abs() - EYE_CUT[0]) / (EYE_CUT[1] - EYE_CUT[0])).clamp(0.0, 1.0)
    }

    /// `up` after the opening was made: the lids' rims are pushed apart.
    pub(crate) fn open(&self, site: Site, up: f64) -> f64 {
        let way = Self::way(site.across);
        let reach = ramp((site.up - EYE_LINE).abs(), REACH, 0.0);
        let line = -0.14 + 0.32 * ramp(site.across.abs(), EYE_CUT[0] - 1.0, EYE_CUT[1] + 1.0);
        let from_cut = (site.up - EYE_LINE).abs();
        let margin = Self::margin_width(way);
        let shrunk = soft_max(from_cut - margin, 0.0, 0.3 * margin) - from_cut;
        let rim = if site.above_eyes { self.upper.at(way) } else { self.lower.at(way) };
        let away = (rim + shrunk) * reach;
        up + line * reach + if site.above_eyes { away } else { -away }
    }

    /// The heights of the rims over and below the line between the corners, at `across`.
    pub(crate) fn rims(&self, across: f64) -> (f64, f64) {
        let way = Self::way(across);
        (self.upper.at(way), self.lower.at(way))
    }

    fn margin_width(way: f64) -> f64 {
        MARGIN * (1.0 - (2.0 * way - 1.0).powi(4))
    }

    /// The height `z` of the socket, covered by the lids.
    pub(crate) fn lids(&self, x: f64, y: f64, z: f64) -> f64 {
        soft_max(z, Self::ball(x, y), 0.3) + self.crease(x, y)
    }

    /// The height of the ball on which the lids lie.
    fn ball(x: f64, y: f64) -> f64 {
        let (dx, dy) = (x.abs() - BALL[0], y - BALL[1]);
        let outside = LID_RADIUS * LID_RADIUS - 0.8 * dx * dx - dy * dy;
        // Beyond the sphere it continues as a slope, far below the socket.
        BALL[2] + if outside > 0.04 { outside.sqrt() } else { 0.2 + (outside - 0.04) * 2.5 }
    }

    /// The fold above the upper lid.
    fn crease(&self, x: f64, y: f64) -> f64 {
        let way = (x.abs() - 1.73) / 2.62;
        let rim = self.upper.at(way.clamp(0.0, 1.0)) + 0.1;
        let above = y - rim - 0.36 + 0.25 * (way - 0.5) * (way - 0.5);
        let along = plateau(way, 0.25, 0.7, 0.3);
        along * (0.12 * bell(above, 0.22, 0.2) - 0.13 * bell(above, 0.0, 0.1))
    }

    /// The lids' margins turn back towards the eyeball.
    pub(crate) fn margin(&self, site: Site) -> f64 {
        let margin = Self::margin_width(Self::way(site.across));
        let inside = (1.0 - (site.up - EYE_LINE).abs() / (1.6 * margin + 1e-9)).max(0.0).powf(1.5);
        -0.28 * margin / MARGIN * inside
    }
}
