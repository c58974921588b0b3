//! A small vector for each frame, so that frames can be compared without their vertices.

/// Numbers of a sketch.
const WIDTH: usize = 192;

/// The sketches of the frames so far: linear in the positions, and about as far from each other as these.
///
/// Each component of the positions is added to one of the numbers, or subtracted from it (a count sketch).
#[derive(Debug, Default)]
pub(super) struct Sketches {
    /// 3V, the first frame.
    first: Vec<f32>,
    /// [`WIDTH`] of each frame.
    numbers: Vec<f32>,
}

impl Sketches {
    /// Adds the sketch of the next frame.
    pub(super) fn push(&mut self, positions: &[f32]) {
        if self.numbers.is_empty() {
            self.first = positions.to_vec();
        }
        let mut sketch = [0.0_f64; WIDTH];
        for (i, (x, first)) in positions.iter().zip(&self.first).enumerate() {
            // The high bits of a product are a good hash of the index.
            let hash = (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32;
            let moved = f64::from(x - first);
            let number = &mut sketch[(hash >> 1) as usize % WIDTH];
            *number += if hash & 1 == 0 { moved } else { -moved };
        }
        self.numbers.extend(sketch.map(|x| x as f32));
    }

    /// `count` frames, or all if there are fewer, in ascending order. Each is the one that was farthest from
    /// those before it.
    pub(super) fn spread(&self, count: usize) -> Vec<usize> {
        let sketches = self.numbers.as_chunks::<WIDTH>().0;
        let mut distances = vec![f32::INFINITY; sketches.len()];
        let mut chosen = Vec::new();
        let mut next = 0;
        while chosen.len() < count.min(sketches.len()) {
            chosen.push(next);
            // Below all distances, so that it is not chosen again.
            distances[next] = -1.0;
            let center = &sketches[next];
            let (mut farthest, mut most) = (0, -1.0);
            for (i, sketch) in sketches.iter().enumerate() {
                let squares = sketch.iter().zip(center).map(|(a, b)| (a - b) * (a - b));
                distances[i] = distances[i].min(squares.sum());
                if distances[i] > most {
                    (farthest, most) = (i, distances[i]);
                }
            }
            next = farthest;
        }
        chosen.sort_unstable();
        chosen
    }
}
