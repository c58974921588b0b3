//! A clean take for a face, sampled at any time.
use crate::Face;
use rhytid_core::{Missing, Result, RigidMotion, Take};
use rhytid_takes::take;
use serde_json::{Value, json};

/// The handle positions of a take over time.
#[derive(Debug)]
pub struct Track {
    /// One time for each frame, in seconds, strictly increasing.
    times: Vec<f64>,
    /// frames × H × 3, mesh units, head space.
    positions: Vec<f32>,
    /// The numbers of a frame: H × 3.
    values: usize,
    head: Option<Vec<RigidMotion>>,
    rate: f64,
    warnings: Vec<String>,
    /// H × 3: the last sample.
    sample: Vec<f32>,
}

/// The head's motion in the world: a rotation, then a translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadPose {
    /// A quaternion of length 1 (x, y, z, w), then a translation in mesh units.
    pub numbers: [f64; 7],
}

/// A take is not in the rig's space if in every frame the markers are farther from rest than this part of
/// the face's size. Both are root mean squares.
const FARTHEST: f64 = 0.5;

impl Track {
    /// Reads the take `name`, a CSV in mesh units and head space, for the handles of `face`.
    ///
    /// # Errors
    /// As [`take::decode`].
    pub fn open(bytes: &[u8], name: &str, face: &Face, missing: Missing) -> Result<Self> {
        let handles = face.rig().handles();
        let take = take::decode(bytes, name, Some(&handles.labels), missing)?;
        Ok(Self {
            positions: take.handle_positions(&handles.labels)?,
            values: 3 * handles.len(),
            rate: take.rate(),
            warnings: far_from_rest(&take, &handles.rest, name).into_iter().collect(),
            head: take.head,
            times: take.times,
            sample: Vec::new(),
        })
    }

    /// The take as JSON: `frames`, `rate` in frames per second, `duration` in seconds from the first frame to
    /// the last, `hasHead`, and `warnings`.
    pub fn facts(&self) -> Value {
        json!({
            "frames": self.times.len(),
            "rate": self.rate,
            "duration": self.duration(),
            "hasHead": self.head.is_some(),
            "warnings": self.warnings,
        })
    }

    /// Seconds from the first frame to the last.
    fn duration(&self) -> f64 {
        self.times[self.times.len() - 1] - self.times[0]
    }

    /// H×3 handle positions at `seconds` after the first frame, linear between frames. Before the first frame
    /// it is the first, and after the last frame the last.
    pub fn at(&mut self, seconds: f64) -> &[f32] {
        let (frame, part) = self.place(seconds);
        let next = (frame + 1).min(self.times.len() - 1);
        let [a, b] = [frame, next].map(|frame| &self.positions[frame * self.values..][..self.values]);
        self.sample.clear();
        self.sample.extend(a.iter().zip(b).map(|(a, b)| {
            let (a, b) = (f64::from(*a), f64::from(*b));
            (a + part * (b - a)) as f32
        }));
        &self.sample
    }

    /// The head's motion at the same time; `None` if the take has none.
    pub fn head_at(&self, seconds: f64) -> Option<HeadPose> {
        let head = self.head.as_ref()?;
        let (frame, part) = self.place(seconds);
        let motion = head[frame].between(&head[(frame + 1).min(head.len() - 1)], part);
        let mut numbers = [0.0; 7];
        numbers[..4].copy_from_slice(&motion.rotation);
        numbers[4..].copy_from_slice(&motion.translation);
        Some(HeadPose { numbers })
    }

    /// The frame at or before a time, and how far it is on the way to the next one, from 0 to 1.
    fn place(&self, seconds: f64) -> (usize, f64) {
        let time = self.times[0] + if seconds.is_nan() { 0.0 } else { seconds };
        let frame = self.times.partition_point(|other| *other <= time).saturating_sub(1);
        match self.times.get(frame + 1) {
            Some(next) => {
                let part = (time - self.times[frame]) / (next - self.times[frame]);
                (frame, part.clamp(0.0, 1.0))
            }
            None => (frame, 0.0),
        }
    }
}

/// A warning if in no frame the markers are near the handles at rest.
fn far_from_rest(take: &Take, rest: &[[f32; 3]], name: &str) -> Option<String> {
    let rest: Vec<[f64; 3]> = rest.iter().map(|p| p.map(f64::from)).collect();
    let middle: [f64; 3] =
        std::array::from_fn(|i| rest.iter().map(|p| p[i]).sum::<f64>() / rest.len() as f64);
    let size = rms(rest.iter().map(|p| squared_distance(p, &middle)));
    let off = take.positions.chunks_exact(rest.len());
    let off = off.map(|frame| rms(frame.iter().zip(&rest).map(|(p, rest)| squared_distance(p, rest))));
    let least = off.fold(f64::INFINITY, f64::min);
    (rest.len() > 2 && least > FARTHEST * size).then(|| {
        format!(
            "{name}: in every frame the markers are at least {least:.3} mesh units from the rig's handles at rest \
             (RMS), and the handles are {size:.3} from their middle; bring the take into the rig's unit and axes, \
             and take the head's motion out"
        )
    })
}

fn squared_distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// The root of the mean.
fn rms(squares: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = squares.len().max(1) as f64;
    (squares.sum::<f64>() / count).sqrt()
}
