//! Velocities from positions: what renderers blur motion by.

use rhytid_core::Result;

/// Passes frames on one frame late, with their velocities: the central difference of the frames before and after,
/// one-sided at the first and the last.
pub(crate) struct Velocities {
    /// Frames per second.
    rate: f32,
    before: Vec<f32>,
    current: Vec<f32>,
    normals: Vec<f32>,
    velocities: Vec<f32>,
    seen: usize,
}

/// Positions, normals, velocities.
pub(crate) type Each<'a> = &'a mut dyn FnMut(&[f32], &[f32], &[f32]) -> Result<()>;

impl Velocities {
    pub(crate) fn new(rate: f64) -> Self {
        let empty = Vec::new;
        let (before, current, normals, velocities) = (empty(), empty(), empty(), empty());
        Self { rate: rate as f32, before, current, normals, velocities, seen: 0 }
    }

    /// Takes a frame, and hands on the one before it.
    ///
    /// # Errors
    /// As `each`.
    pub(crate) fn frame(&mut self, positions: &[f32], normals: &[f32], each: Each<'_>) -> Result<()> {
        match self.seen {
            0 => {}
            1 => self.hand_on(&self.current.clone(), positions, self.rate, each)?,
            _ => {
                let before = std::mem::take(&mut self.before);
                self.hand_on(&before, positions, self.rate / 2.0, each)?;
                self.before = before;
            }
        }
        std::mem::swap(&mut self.before, &mut self.current);
        self.current.clear();
        self.current.extend_from_slice(positions);
        self.normals.clear();
        self.normals.extend_from_slice(normals);
        self.seen += 1;
        Ok(())
    }

    /// Hands on the last frame.
    ///
    /// # Errors
    /// As `each`.
    pub(crate) fn finish(mut self, each: Each<'_>) -> Result<()> {
        let last = self.current.clone();
        match self.seen {
            0 => Ok(()),
            1 => self.hand_on(&last, &last, self.rate, each),
            _ => {
                let before = std::mem::take(&mut self.before);
                self.hand_on(&before, &last, self.rate, each)
            }
        }
    }

    /// Hands on the current frame, with the velocities by which `from` becomes `to`.
    fn hand_on(&mut self, from: &[f32], to: &[f32], per_second: f32, each: Each<'_>) -> Result<()> {
        self.velocities.clear();
        self.velocities.extend(from.iter().zip(to).map(|(from, to)| (to - from) * per_second));
        each(&self.current, &self.normals, &self.velocities)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The velocities of frames at these positions, a hundredth of a second apart; checks what comes with them.
    fn of(positions: &[f32]) -> Vec<f32> {
        let mut found = Vec::new();
        let mut each = |position: &[f32], normal: &[f32], velocity: &[f32]| {
            assert_eq!((position[0], normal[0]), (positions[found.len()], -positions[found.len()]));
            found.push(velocity[0]);
            Ok(())
        };
        let mut velocities = Velocities::new(100.0);
        for x in positions {
            velocities.frame(&[*x], &[-x], &mut each).unwrap();
        }
        velocities.finish(&mut each).unwrap();
        found
    }

    #[test]
    fn a_parabola_has_its_derivative_inside() {
        // x = t² with t in hundredths: the velocity is 2 t per hundredth of a second.
        let squares: Vec<f32> = (0..6).map(|t| (t * t) as f32).collect();
        assert_eq!(of(&squares), [100.0, 200.0, 400.0, 600.0, 800.0, 900.0]);
    }

    #[test]
    fn short_animations() {
        assert_eq!(of(&[]), [0.0; 0]);
        assert_eq!(of(&[7.0]), [0.0]);
        assert_eq!(of(&[1.0, 3.0]), [200.0, 200.0]);
    }
}
