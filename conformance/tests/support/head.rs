//! The full head through a real take, as a user sees it, on any device.
use super::real::{clean_take, face};
use rayon::prelude::*;
use rhytid_conformance::{evaluate, worst_difference};
use rhytid_core::{Device, NoProgress, Rig, Settings, Stage, UploadOptions};
use rhytid_solve::solve;

/// Every frame whose number is a multiple of this is compared.
const EVERY: usize = 50;

/// Frames in a batch: the last one is not full.
const BATCH: usize = 16;

/// The largest error of final positions against the f64 reference, over the bounding box's diagonal.
const TOLERANCE: f64 = 1e-5;

/// The largest error of the rest pose, in the same unit.
const AT_REST: f64 = 1e-6;

/// A solved head, frames of a take, and the f64 reference's results.
pub(crate) struct Head {
    rig: Rig,
    handle_positions: Vec<f32>,
    /// The largest allowed error, in mesh units.
    allowed: f64,
    /// The final positions of each frame.
    expected: Vec<Vec<[f64; 3]>>,
}

impl Head {
    /// `None`, with a message, if the shared data is missing.
    pub(crate) fn new() -> Option<Self> {
        let shared = rhytid_test_support::shared("")?;
        let face = face(&shared, "head", Settings::default());
        let [low, high] = face.neutral.bounds().unwrap();
        let diagonal = low.iter().zip(high).map(|(low, high)| (high - low).powi(2)).sum::<f64>().sqrt();
        // The reference evaluates the rounded rig that a device gets.
        let rig: Rig = solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let reference = rig.widened();
        let take = clean_take(&shared, &reference).handle_positions(&rig.handles().labels).unwrap();
        let frame = rig.handles().len() * 3;
        let handle_positions: Vec<f32> =
            take.chunks_exact(frame).step_by(EVERY).flat_map(<[f32]>::to_vec).collect();
        assert_eq!(handle_positions.len(), 81 * frame);
        let expected = handle_positions
            .par_chunks_exact(frame)
            .map(|frame| {
                let frame: Vec<[f64; 3]> =
                    frame.as_chunks::<3>().0.iter().map(|p| p.map(f64::from)).collect();
                evaluate(&reference, &frame).positions
            })
            .collect();
        Some(Self { rig, handle_positions, allowed: TOLERANCE * diagonal, expected })
    }

    /// Evaluates all frames on `device`.
    pub(crate) fn check(&self, device: &Device) -> Result<(), String> {
        let of_device = |e: rhytid_core::Error| e.to_string();
        let mut animator = device.upload(&self.rig, UploadOptions::frames(BATCH)).map_err(of_device)?;
        let mut positions = Vec::new();
        let mut worst: f64 = 0.0;
        let batches = self.handle_positions.chunks(BATCH * self.rig.handles().len() * 3);
        for (batch, expected) in batches.zip(self.expected.chunks(BATCH)) {
            animator.evaluate(batch).map_err(of_device)?;
            animator.read(Stage::Positions, &mut positions).map_err(of_device)?;
            let expected: Vec<f64> = expected.iter().flatten().flatten().copied().collect();
            worst = worst.max(worst_difference(&positions, &expected).size);
        }
        let rest: Vec<f32> = self.rig.handles().rest.iter().flatten().copied().collect();
        animator.evaluate(&rest).map_err(of_device)?;
        animator.read(Stage::Positions, &mut positions).map_err(of_device)?;
        let expected: Vec<f64> =
            self.rig.surface().rest.as_flattened().iter().map(|&x| f64::from(x)).collect();
        let at_rest = worst_difference(&positions, &expected).size / (self.allowed / TOLERANCE);
        if at_rest.is_nan() || at_rest > AT_REST {
            return Err(format!("the rest pose is off by {at_rest:.1e} of the diagonal"));
        }
        let said = format!("positions are off by {:.3} of what is allowed", worst / self.allowed);
        if worst <= self.allowed { Ok(()) } else { Err(said) }
    }
}
