//! The full head through a real take: what a user sees, on any device.
use super::real::{clean_take, face, settings};
use rayon::prelude::*;
use rhytid_conformance::{evaluate, worst_difference};
use rhytid_core::{Device, NoProgress, Rig, Stage, UploadOptions, solve};

/// Each so-manieth frame of the take is compared.
const EVERY: usize = 50;

/// Frames in a batch: the last one is not full.
const BATCH: usize = 16;

/// How far final positions may be from the f64 twin's of the f64 rig, over the bounding box's diagonal.
const TOLERANCE: f64 = 1e-5;

/// The same at the few vertices to which two examples look the same but for less than [`SAME`]: there weights of 10⁴
/// and more take each other away, and one unit in the last place of a strain is a twentieth of a millimetre.
const TOLERANCE_WHERE_SAME: f64 = 2e-4;

/// A part of the largest difference of two examples, as a vertex sees them.
const SAME: f64 = 1e-4;

/// Such vertices, at most, of the head's 26,719.
const MOST_SAME: usize = 50;

/// A solved head, frames of a take, and what the f64 twin makes of them.
pub struct Head {
    rig: Rig,
    handle_positions: Vec<f32>,
    /// What is allowed at each vertex, in mesh units.
    allowed: Vec<f64>,
    /// The final positions of each frame.
    expected: Vec<Vec<[f64; 3]>>,
}

impl Head {
    /// `None`, said loudly, without the shared data.
    pub fn new() -> Option<Self> {
        let shared = super::shared()?;
        let face = face(&shared, "head", settings());
        let [low, high] = face.neutral.bounds().unwrap();
        let diagonal = low.iter().zip(high).map(|(low, high)| (high - low).powi(2)).sum::<f64>().sqrt();
        let rig = solve(&face, &NoProgress).unwrap();
        let take = clean_take(&shared, &rig).handle_positions(&rig.labels).unwrap();
        let frame = rig.handles.len() * 3;
        let handle_positions: Vec<f32> =
            take.chunks_exact(frame).step_by(EVERY).flat_map(<[f32]>::to_vec).collect();
        assert_eq!(handle_positions.len(), 81 * frame);
        let expected = handle_positions
            .par_chunks_exact(frame)
            .map(|frame| {
                let frame: Vec<[f64; 3]> =
                    frame.as_chunks::<3>().0.iter().map(|p| p.map(f64::from)).collect();
                evaluate(&rig, &frame).positions
            })
            .collect();
        let apart: Vec<bool> = (0..rig.vertices()).map(|v| super::told_apart(&rig, v, SAME)).collect();
        assert!(apart.iter().filter(|apart| !**apart).count() <= MOST_SAME);
        let allowed = apart.iter().map(|&apart| if apart { TOLERANCE } else { TOLERANCE_WHERE_SAME });
        let allowed = allowed.map(|tolerance| tolerance * diagonal).collect();
        Some(Self { rig: rig.cast(), handle_positions, allowed, expected })
    }

    /// Evaluates all frames on `device`.
    pub fn check(&self, device: &Device) -> Result<(), String> {
        let of_device = |e: rhytid_core::Error| e.to_string();
        let mut animator = device.upload(&self.rig, UploadOptions::frames(BATCH)).map_err(of_device)?;
        let mut positions = Vec::new();
        let mut worst = (0.0, 0);
        let batches = self.handle_positions.chunks(BATCH * self.rig.handles.len() * 3);
        for (batch, expected) in batches.zip(self.expected.chunks(BATCH)) {
            animator.evaluate(batch).map_err(of_device)?;
            animator.read(Stage::Positions, &mut positions).map_err(of_device)?;
            let (positions, _) = positions.as_chunks::<3>();
            assert_eq!(positions.len(), expected.len() * self.allowed.len());
            for (found, expected) in positions.chunks(self.allowed.len()).zip(expected) {
                for v in 0..self.allowed.len() {
                    let off = worst_difference(&found[v], &expected[v]).size / self.allowed[v];
                    if off > worst.0 {
                        worst = (off, v);
                    }
                }
            }
        }
        let (off, v) = worst;
        let said = format!("positions are off by {off:.2} of what is allowed, at vertex {v}");
        if off <= 1.0 { Ok(()) } else { Err(said) }
    }
}
