//! Comparison of two rigs on a take.

use rhytid_core::{DeviceInfo, Error, Result, Rig, Stage, Take, UploadOptions};
use rhytid_devices::Evaluator;

/// The difference between two rigs in a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// The take's frame.
    pub frame: usize,
    /// The largest distance of a vertex, in mesh units.
    pub worst: f64,
    /// The vertex with the largest distance.
    pub vertex: usize,
}

/// The changes from one rig to another of the same face in these frames of a take.
///
/// # Errors
/// [`Error::Input`] if the take lacks handles, or the rigs have different vertices or handles;
/// [`Error::Device`].
pub fn rig_diff(
    rigs: [&Rig; 2],
    take: &Take,
    frames: &[usize],
    devices: &[DeviceInfo],
) -> Result<Vec<Change>> {
    let [a, b] = rigs;
    if a.vertices() != b.vertices() || a.handles().labels != b.handles().labels {
        return Err(Error::mismatch(
            "the rigs are of different faces, expected the same vertices and handles",
        ));
    }
    let handles = take.pick(frames).handle_positions(&a.handles().labels)?;
    let mut evaluators = Vec::with_capacity(2);
    for rig in rigs {
        evaluators.push(Evaluator::new(
            rig,
            UploadOptions::frames(1),
            devices,
            &rhytid_devices::backends::open,
        )?);
    }
    let mut out = [[Vec::new()], [Vec::new()]];
    let mut changes = Vec::with_capacity(frames.len());
    for (&frame, handles) in frames.iter().zip(handles.chunks_exact(3 * a.handles().labels.len())) {
        for (evaluator, out) in evaluators.iter_mut().zip(&mut out) {
            evaluator.evaluate(handles, &[Stage::Positions], out)?;
        }
        let [[x], [y]] = &out;
        let square = |(x, y): (&[f32; 3], &[f32; 3])| {
            (0..3).map(|c| (f64::from(x[c]) - f64::from(y[c])).powi(2)).sum::<f64>()
        };
        let squares = x.as_chunks().0.iter().zip(y.as_chunks().0).map(square);
        let (vertex, worst) = squares.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
        changes.push(Change { frame, worst: worst.sqrt(), vertex });
    }
    Ok(changes)
}
