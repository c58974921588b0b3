//! Positions as 16-bit and normals as 8-bit integers (KHR_mesh_quantization). Normals that turn far have 16
//! bits.
//!
//! Each frame is rounded as a whole, and a target holds the difference between the integers of its frame and
//! of the base. So a frame has only its own rounding error, without that of the base.

use super::document::Placement;
use rhytid_export::morphs::Values;

/// The largest integer of each kind; its negative is the smallest.
const I16: f64 = 32_767.0;
const I8: f64 = 127.0;

/// A normal of 8 bits is the sum of two vectors, and is not shorter than this. The rounding of the offset
/// turns it by at most 0.8°.
const SHORTEST_OF_8_BITS: f64 = 0.5;

/// The even grid on which positions lie.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    placement: Placement,
}

/// The numbers that a grid has to hold.
#[derive(Debug, Clone)]
pub(super) struct Extent {
    low: [f32; 3],
    high: [f32; 3],
    /// The largest coordinate of an offset from the base.
    offset: f64,
}

impl Extent {
    /// Of a base of 3V coordinates.
    pub(super) fn new(base: &[f32]) -> Self {
        let mut extent = Self { low: [f32::MAX; 3], high: [f32::MIN; 3], offset: 0.0 };
        extent.add(base, base);
        extent
    }

    /// Adds a frame.
    pub(super) fn add(&mut self, base: &[f32], frame: &[f32]) {
        for (i, (&from, &to)) in base.iter().zip(frame).enumerate() {
            self.low[i % 3] = self.low[i % 3].min(to);
            self.high[i % 3] = self.high[i % 3].max(to);
            self.offset = self.offset.max((f64::from(to) - f64::from(from)).abs());
        }
    }

    /// The finest grid that holds all of this; `None` if the numbers are too large for 32 bits.
    pub(super) fn grid(&self) -> Option<Grid> {
        let middle = |axis: usize| (f64::from(self.low[axis]) + f64::from(self.high[axis])) / 2.0;
        let translation: [f32; 3] = std::array::from_fn(|axis| middle(axis) as f32);
        let reach = (0..3).flat_map(|axis| {
            let from_middle = |x: f32| (f64::from(x) - f64::from(translation[axis])).abs();
            [from_middle(self.low[axis]), from_middle(self.high[axis])]
        });
        // A grid point is left over at either end, because an offset is a difference of two rounded numbers.
        let scale = (reach.fold(self.offset, f64::max) * (I16 + 1.0) / (I16 - 1.0)) as f32;
        let scale = if scale == 0.0 { 1.0 } else { scale };
        scale.is_finite().then_some(Grid { placement: Placement { scale, translation } })
    }
}

impl Grid {
    /// The node that takes the integers back to mesh units.
    pub(super) fn placement(&self) -> Placement {
        self.placement
    }

    /// The largest number that a reader computes with, in mesh units.
    pub(super) fn reach(&self) -> f64 {
        let Placement { scale, translation } = self.placement;
        translation.iter().fold(0.0, |largest: f64, &x| largest.max(x.abs().into())) + 2.0 * f64::from(scale)
    }

    /// The grid points nearest to 3V coordinates.
    pub(super) fn snap(&self, positions: &[f32]) -> Vec<i16> {
        let Placement { scale, translation } = self.placement;
        let step = f64::from(scale) / I16;
        let snapped = positions.iter().enumerate().map(|(i, &x)| {
            ((f64::from(x) - f64::from(translation[i % 3])) / step).round().clamp(-I16, I16) as i16
        });
        snapped.collect()
    }

    /// The coordinates of a grid point, or of the sum of two.
    pub(super) fn position(&self, point: [i32; 3]) -> [f64; 3] {
        let Placement { scale, translation } = self.placement;
        std::array::from_fn(|axis| {
            f64::from(translation[axis]) + f64::from(scale) * (f64::from(point[axis]) / I16)
        })
    }
}

/// The offsets from the grid points `from` to the grid points `to`.
pub(super) fn offsets(from: &[i16], to: &[i16]) -> Vec<i16> {
    // They fit, because the grid was made for the largest offset.
    from.iter().zip(to).map(|(&from, &to)| to.saturating_sub(from)).collect()
}

/// Unit vectors as integers.
pub(super) fn snap_normals(normals: &[f32]) -> Vec<i8> {
    normals.iter().map(|&x| (f64::from(x) * I8).round().clamp(-I8, I8) as i8).collect()
}

/// The offsets from the normals `from` (integers) to the directions of `to` (3V coordinates). If a direction
/// is 0, the base's stays.
///
/// An offset is at most 1. If a normal turns so far that it would be larger, the sum is a shorter vector:
/// viewers normalise it. 8 bits are too coarse for a short vector, so that all offsets have 16 bits then.
pub(super) fn normal_offsets(from: &[i8], to: &[f32]) -> Values {
    let pairs = || {
        let pairs = from.as_chunks::<3>().0.iter().zip(to.as_chunks::<3>().0);
        pairs.map(|(from, to)| (from.map(|x| f64::from(x) / I8), to.map(f64::from)))
    };
    let shortest = pairs().map(|(from, to)| length_of_sum(from, to)).fold(1.0, f64::min);
    if shortest >= SHORTEST_OF_8_BITS {
        Values::I8(pairs().flat_map(|(from, to)| offset(from, to, I8)).map(|x| x as i8).collect())
    } else {
        Values::I16(pairs().flat_map(|(from, to)| offset(from, to, I16)).map(|x| x as i16).collect())
    }
}

/// The length, at most 1, of the longest vector in the direction `to` that is no farther than 1 from `from`
/// along each axis.
fn length_of_sum(from: [f64; 3], to: [f64; 3]) -> f64 {
    (0..3).fold(1.0, |length, axis| match to[axis] {
        0.0 => length,
        x => length.min((1.0 + from[axis] * x.signum()) / x.abs()),
    })
}

/// An offset in `steps` to 1.
fn offset(from: [f64; 3], to: [f64; 3], steps: f64) -> [f64; 3] {
    if to == [0.0; 3] {
        return to;
    }
    // Straight back, there is only room for a vector of 0. The smallest vector has the direction.
    let length = length_of_sum(from, to).max(1.0 / steps);
    std::array::from_fn(|axis| ((length * to[axis] - from[axis]) * steps).round().clamp(-steps, steps))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_normal_that_turns_far_keeps_its_direction() {
        let axis = |x: f32, y: f32, z: f32| {
            let length = (x * x + y * y + z * z).sqrt();
            [x / length, y / length, z / length]
        };
        let from = axis(1.0, 0.1, 0.0);
        for (to, is_short) in [
            (axis(1.0, 0.2, 0.0), false),
            (axis(0.0, 1.0, 0.0), false),
            (axis(0.1, 1.0, 0.3), false),
            (axis(-0.4, 1.0, 0.0), true),
            // Against the base's own direction there is next to no room.
            (axis(-1.0, 0.3, 0.0), true),
        ] {
            let base = snap_normals(&from);
            let offsets = normal_offsets(&base, &to);
            assert_eq!(matches!(offsets, Values::I16(_)), is_short, "{to:?}");
            let offset = |i: usize| match &offsets {
                Values::I8(offsets) => f64::from(offsets[i]) / I8,
                Values::I16(offsets) => f64::from(offsets[i]) / I16,
                Values::F32(_) => unreachable!(),
            };
            let sum: Vec<f64> = (0..3).map(|i| f64::from(base[i]) / I8 + offset(i)).collect();
            let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
            let cosine: f64 = sum.iter().zip(to).map(|(x, to)| x / length * f64::from(to)).sum();
            assert!(cosine.min(1.0).acos().to_degrees() < 0.7, "{to:?}: {sum:?}");
        }
        assert_eq!(normal_offsets(&[127, 0, 0], &[0.0; 3]), Values::I8(vec![0; 3]));
    }

    #[test]
    fn a_grid_holds_its_extent_and_little_more() {
        let base = [0.0, 5.0, -3.0, 10.0, 5.0, -3.0];
        let frame = [10.0, 5.0, -3.0, 0.0, 5.0, -3.0];
        let mut extent = Extent::new(&base);
        extent.add(&base, &frame);
        let grid = extent.grid().unwrap();
        // Half of the extent would do for the positions; the offsets take all of it.
        assert!((grid.placement().scale - 10.0).abs() < 0.001, "{:?}", grid.placement());
        let (from, to) = (grid.snap(&base), grid.snap(&frame));
        let sum: Vec<i16> = from.iter().zip(offsets(&from, &to)).map(|(a, b)| a + b).collect();
        assert_eq!(sum, to);
        // A single point.
        let grid = Extent::new(&[7.0, 8.0, 9.0]).grid().unwrap();
        assert_eq!(
            grid.position(
                grid.snap(&[7.0, 8.0, 9.0]).try_into().map(|p: [i16; 3]| p.map(i32::from)).unwrap()
            ),
            [7.0, 8.0, 9.0]
        );
    }
}
