//! The neutral surface: a continuous function from a flat domain to space, sampled at any resolution.
//!
//! The domain is a sheet laid over the face, in centimetres: `across` runs from the right temple (negative)
//! to the left, `up` from the neck to the hairline. It is cut along three lines: those of the two eyes and of
//! the mouth. The surface pulls the sides of a cut apart, so openings have smooth rims at every resolution.
//!
//! Space: x to the face's left, y up, z forward, in centimetres; the pupils are at y = 0.

mod eye;
mod head;
mod mouth;
mod nose;
mod site;

pub(crate) use site::{BOTTOM, EYE_CUT, EYE_LINE, HALF_WIDTH, MOUTH_CUT, MOUTH_LINE, Site, TOP};

use eye::Eye;
use mouth::Mouth;

use crate::curve::{lattice, ramp};
use glam::DVec3;
use head::Head;
use nose::Nose;

/// The neutral face.
#[derive(Debug)]
pub(crate) struct Shape {
    head: Head,
    nose: Nose,
    /// Opening and lids.
    pub eye: Eye,
    /// Opening and lips.
    pub mouth: Mouth,
}

impl Shape {
    /// The only neutral face.
    pub(crate) fn new() -> Self {
        Self { head: Head::new(), nose: Nose::new(), eye: Eye::new(), mouth: Mouth::new() }
    }

    /// The point in space of a site, without pores.
    pub(crate) fn position(&self, site: Site) -> DVec3 {
        let opened = self.mouth.open(site, self.eye.open(site, site.up));
        let mut p = self.head.position(site.across, opened);
        let (x, y) = (p.x, p.y);
        p.z += self.nose.height(x, y);
        p.z = self.eye.lids(x, y, p.z);
        p.y += self.nose.droop(x, y);
        p += self.mouth.lips(site, x, y);
        p.z += self.eye.margin(site);
        p
    }

    /// The outward normal of a site, of length 1.
    pub(crate) fn normal(&self, site: Site) -> DVec3 {
        const STEP: f64 = 0.02;
        let across = self.position(site.shifted(STEP, 0.0)) - self.position(site.shifted(-STEP, 0.0));
        // The difference is taken away from the nearest cut, which must not be crossed.
        let middle = 0.5 * (EYE_LINE + MOUTH_LINE);
        let upward = site.above_eyes || (site.above_mouth && site.up < middle);
        let step = if upward { STEP } else { -STEP };
        let up = (self.position(site.shifted(0.0, step)) - self.position(site)) / step;
        across.cross(up).normalize_or_zero()
    }
}

/// The depth of the pores at a site, in centimetres along the normal.
pub(crate) fn pores(site: Site) -> f64 {
    const SPACING: f64 = 0.085;
    const RADIUS: f64 = 0.42;
    let (x, y) = (site.across / SPACING, site.up / SPACING);
    let (i, j) = (x.floor() as i32, y.floor() as i32);
    let mut depth = 0.0;
    for (di, dj) in (-1..=1).flat_map(|di| (-1..=1).map(move |dj| (di, dj))) {
        let (ci, cj) = (i + di, j + dj);
        let dx = f64::from(ci) + 0.5 + 0.45 * lattice(ci, cj, 1) - x;
        let dy = f64::from(cj) + 0.5 + 0.45 * lattice(ci, cj, 2) - y;
        let size = 0.6 + 0.4 * lattice(ci, cj, 3);
        depth += size * ramp((dx * dx + dy * dy).sqrt(), 2.0 * RADIUS, 0.0);
    }
    -0.006 * depth
}
