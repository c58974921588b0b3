//! The distance of the stored positions from the given ones.

use glam::DVec3;
use rhytid_export::Deviation;

/// Collects the distances of all vertices in all frames.
#[derive(Debug, Default)]
pub(super) struct Measure {
    /// The largest squared distance, and its frame and vertex.
    worst: f64,
    at: (usize, usize),
    sum: f64,
    count: u64,
    /// The largest coordinate that a reader computes with.
    largest: f64,
}

impl Measure {
    /// Adds a vertex of a frame: it was `given` at one place and is `stored` at another, by exact arithmetic.
    pub(super) fn add(&mut self, frame: usize, vertex: usize, given: [f64; 3], stored: [f64; 3]) {
        let squared = DVec3::from(given).distance_squared(DVec3::from(stored));
        if squared > self.worst {
            (self.worst, self.at) = (squared, (frame, vertex));
        }
        self.sum += squared;
        self.count += 1;
        self.largest = stored.iter().fold(self.largest, |largest, x| largest.max(x.abs()));
    }

    /// The outcome. `reach` is the largest number that a reader computes with on its way to a coordinate,
    /// beyond the coordinates themselves.
    ///
    /// The worst distance includes the rounding of a reader's 32-bit arithmetic: at most eight roundings of a
    /// number of that size along each axis. They are of integers to fractions, their sum, scale and
    /// translation (which are rounded themselves) and a rotation.
    pub(super) fn deviation(&self, reach: f64) -> Deviation {
        let rounding = f64::from(f32::EPSILON) / 2.0 * self.largest.max(reach);
        Deviation {
            worst: self.worst.sqrt() + 3.0_f64.sqrt() * 8.0 * rounding,
            at: self.at,
            rms: (self.sum / self.count.max(1) as f64).sqrt(),
        }
    }
}
