//! The residuals of a rig's examples.

use rhytid_core::{DeviceInfo, Face, Result, Rig, Stage, SurfacePoint, UploadOptions};
use rhytid_devices::Evaluator;
use rhytid_solve::Misplaced;

/// The residual of a rig at one of the scans that it was made of, with the scan's handle positions.
#[derive(Debug, Clone, PartialEq)]
pub struct ExampleResiduals {
    /// The example; `None` for the rest pose.
    pub example: Option<String>,
    /// The root mean square distance of all vertices, in mesh units.
    pub rms: f64,
    /// The largest distance, in mesh units.
    pub worst: f64,
    /// The vertex with the largest distance.
    pub vertex: usize,
}

/// Evaluates the rest pose and each example of the `face` that `rig` was made of, and compares them with the
/// scans.
///
/// `misplaced` are the rigid motions that the solve removed from the scans. Mirror images are left out,
/// because they have no scan.
///
/// # Errors
/// [`rhytid_core::Error::Device`], as an [`Evaluator`]'s.
pub fn example_residuals(
    rig: &Rig,
    face: &Face,
    misplaced: &[Misplaced],
    devices: &[DeviceInfo],
) -> Result<Vec<ExampleResiduals>> {
    let rest = &face.neutral.positions;
    let mut states = vec![(None, rest.clone())];
    for example in &face.examples {
        let mut positions = example.positions.clone();
        if let Some(found) = misplaced.iter().find(|found| found.example == example.name) {
            found.undo(&mut positions);
        }
        states.push((Some(example.name.clone()), positions));
    }
    let mut evaluator =
        Evaluator::new(rig, UploadOptions::frames(1), devices, &rhytid_devices::backends::open)?;
    let mut found = Vec::new();
    let mut out = [Vec::new()];
    for (example, positions) in states {
        let at = |point: &SurfacePoint| point.at(&positions).map(|x| x as f32);
        let of_handles: Vec<[f32; 3]> = rig.handles().points.iter().map(at).collect();
        evaluator.evaluate(of_handles.as_flattened(), &[Stage::Positions], &mut out)?;
        let (mut squares, mut worst, mut vertex) = (0.0, 0.0_f64, 0);
        for (v, (x, y)) in out[0].as_chunks::<3>().0.iter().zip(&positions).enumerate() {
            let square: f64 = (0..3).map(|c| (f64::from(x[c]) - y[c]).powi(2)).sum();
            squares += square;
            if square > worst {
                (worst, vertex) = (square, v);
            }
        }
        let rms = (squares / positions.len().max(1) as f64).sqrt();
        found.push(ExampleResiduals { example, rms, worst: worst.sqrt(), vertex });
    }
    Ok(found)
}
