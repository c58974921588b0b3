//! Positions as 16-bit and normals as 8-bit integers (KHR_mesh_quantization).
//!
//! Each frame is rounded as a whole, and a target holds the difference between the integers of its frame and
//! of the base. So a frame has only its own rounding error, without that of the base.

use super::document::Placement;

/// The largest integer of each kind; its negative is the smallest.
const I16: f64 = 32_767.0;
const I8: f64 = 127.0;

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
/// is 0, the base's stays. If a normal turns so far that an offset would be larger than 1, the sum is a
/// shorter vector: viewers normalise it.
pub(super) fn normal_offsets(from: &[i8], to: &[f32]) -> Vec<i8> {
    let pairs = from.as_chunks::<3>().0.iter().zip(to.as_chunks::<3>().0);
    let offset = |(from, to): (&[i8; 3], &[f32; 3])| {
        if *to == [0.0; 3] {
            return [0; 3];
        }
        let from = from.map(f64::from);
        let to = to.map(|x| f64::from(x) * I8);
        // Each coordinate of the sum has room for one vector of this length at least.
        let length = (0..3).fold(1.0_f64, |length, axis| {
            let room = if to[axis] < 0.0 { from[axis] - I8 } else { from[axis] + I8 };
            if to[axis] == 0.0 { length } else { length.min(room / to[axis]) }
        });
        // Straight back, there is only room for a vector of 0. The smallest vector has the direction.
        let length = length.max(1.0 / I8);
        std::array::from_fn(|axis| (length * to[axis] - from[axis]).round().clamp(-I8, I8) as i8)
    };
    pairs.flat_map(offset).collect()
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
        for (to, degrees) in [
            (axis(1.0, 0.2, 0.0), 0.7),
            (axis(0.0, 1.0, 0.0), 0.7),
            (axis(0.1, 1.0, 0.3), 0.7),
            // Against the base's own direction there is next to no room.
            (axis(-0.4, 1.0, 0.0), 6.0),
        ] {
            let base = snap_normals(&from);
            let offsets = normal_offsets(&base, &to);
            let sum: Vec<f64> =
                base.iter().zip(&offsets).map(|(a, b)| f64::from(*a) + f64::from(*b)).collect();
            let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
            let cosine: f64 = sum.iter().zip(to).map(|(x, to)| x / length * f64::from(to)).sum();
            assert!(cosine.min(1.0).acos().to_degrees() < degrees, "{to:?}: {sum:?}");
        }
        assert_eq!(normal_offsets(&[127, 0, 0], &[0.0; 3]), [0; 3]);
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
