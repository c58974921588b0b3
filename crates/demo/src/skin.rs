//! A point of the neutral skin.
use crate::curve::{bell, pair, ramp};
use crate::shape::{BOTTOM, HALF_WIDTH, MOUTH_CUT, MOUTH_LINE, Shape, Site, TOP};
use glam::DVec3;

/// A point of the neutral skin, with the data that motions and wrinkles need.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Skin {
    /// Its place in the domain.
    pub site: Site,
    /// Its place in space.
    pub p: DVec3,
    /// The normal.
    pub n: DVec3,
    /// 1 on the face's left, -1 on its right, smoothly 0 on the midline.
    pub side: f64,
    /// The height above (positive) or below the mouth, measured around the corners. It jumps only at the cut.
    pub from_mouth: f64,
    /// 1 inside the face, 0 at the mesh's outer rim.
    pub inside: f64,
}

impl Skin {
    /// The point at `site`.
    pub(crate) fn new(shape: &Shape, site: Site) -> Self {
        let p = shape.position(site);
        let from_mouth = around(site.across, site.up - MOUTH_LINE, MOUTH_CUT, site.above_mouth);
        let inside = ramp(site.across.abs(), HALF_WIDTH, 7.6)
            * ramp(site.up, BOTTOM, BOTTOM + 2.4)
            * ramp(site.up, TOP, TOP - 2.6);
        Self { site, p, n: shape.normal(site), side: (p.x / 0.6).tanh(), from_mouth, inside }
    }

    /// A round region of the domain, on both sides: 1 at its centre.
    pub(crate) fn near(&self, across: f64, up: f64, wide: f64, high: f64) -> f64 {
        let x = self.site.across;
        let across = if across == 0.0 { bell(x, 0.0, wide) } else { pair(x, across, wide) };
        across * bell(self.site.up, up, high)
    }
}

/// The height above a cut from -`half` to `half`, along the lines that flow around it. It is the imaginary
/// part of √(z² − half²). At the two sides of the cut it is ±√(half² − x²), and at its ends 0.
fn around(x: f64, y: f64, half: f64, above: bool) -> f64 {
    let (re, im) = (x * x - y * y - half * half, 2.0 * x * y);
    let height = (0.5 * ((re * re + im * im).sqrt() - re)).max(0.0).sqrt();
    if above { height } else { -height }
}
