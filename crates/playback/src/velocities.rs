//! Velocities from positions, for motion blur in renderers.

/// Returns frames one frame late, with their velocities.
///
/// A velocity is the central difference of the frames before and after. It is one-sided at the first and the
/// last frame.
pub(crate) struct Velocities {
    /// Frames per second.
    rate: f32,
    before: Vec<[f32; 3]>,
    current: Moved,
    seen: usize,
}

/// A frame with its velocities.
#[derive(Default, Clone)]
pub(crate) struct Moved {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub velocities: Vec<[f32; 3]>,
}

impl Velocities {
    pub(crate) fn new(rate: f64) -> Self {
        Self { rate: rate as f32, before: Vec::new(), current: Moved::default(), seen: 0 }
    }

    /// Takes a frame, and returns the frame before it, if there is one.
    pub(crate) fn frame(&mut self, positions: &[[f32; 3]], normals: &[[f32; 3]]) -> Option<Moved> {
        let passed_on = (self.seen > 0).then(|| self.moved(positions, false));
        self.before.clone_from(&self.current.positions);
        self.current.positions.clear();
        self.current.positions.extend_from_slice(positions);
        self.current.normals.clear();
        self.current.normals.extend_from_slice(normals);
        self.seen += 1;
        passed_on
    }

    /// The last frame, if there was any.
    pub(crate) fn last(&mut self) -> Option<Moved> {
        let last = self.current.positions.clone();
        (self.seen > 0).then(|| self.moved(&last, true))
    }

    /// The current frame with its velocities. `next` is the frame after it, or the current frame itself where
    /// `is_last`.
    fn moved(&self, next: &[[f32; 3]], is_last: bool) -> Moved {
        // One-sided at both ends.
        let (from, per_second) = match (self.seen, is_last) {
            (1, _) => (&self.current.positions, self.rate),
            (_, true) => (&self.before, self.rate),
            (_, false) => (&self.before, self.rate / 2.0),
        };
        let velocity =
            |(from, to): (&[f32; 3], &[f32; 3])| std::array::from_fn(|c| (to[c] - from[c]) * per_second);
        let velocities = from.iter().zip(next).map(velocity).collect();
        Moved { velocities, ..self.current.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The velocities of frames at these positions, a hundredth of a second apart. Also checks the positions
    /// and normals that come with them.
    fn velocities(positions: &[f32]) -> Vec<f32> {
        let mut velocities = Velocities::new(100.0);
        let mut moved: Vec<Moved> = Vec::new();
        for &x in positions {
            moved.extend(velocities.frame(&[[x, 0.0, 0.0]], &[[-x, 0.0, 0.0]]));
        }
        moved.extend(velocities.last());
        for (moved, &x) in moved.iter().zip(positions) {
            assert_eq!((moved.positions[0][0], moved.normals[0][0]), (x, -x));
        }
        moved.iter().map(|moved| moved.velocities[0][0]).collect()
    }

    #[test]
    fn a_parabola_has_its_derivative_inside() {
        // x = t² with t in hundredths: the velocity is 2 t per hundredth of a second.
        let squares: Vec<f32> = (0..6).map(|t| (t * t) as f32).collect();
        assert_eq!(velocities(&squares), [100.0, 200.0, 400.0, 600.0, 800.0, 900.0]);
    }

    #[test]
    fn short_animations() {
        assert_eq!(velocities(&[]), [0.0; 0]);
        assert_eq!(velocities(&[7.0]), [0.0]);
        assert_eq!(velocities(&[1.0, 3.0]), [200.0, 200.0]);
    }
}
