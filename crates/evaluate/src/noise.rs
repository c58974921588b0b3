//! The response of a face to the noise of its markers.

use crate::Regions;
use crate::errors::{Errors, Sum, distances};
use rhytid_conformance::Numbers;
use rhytid_core::{DeviceInfo, Progress, Result, Rig};
use rhytid_formats::export::OutputStage;
use rhytid_playback::Playback;
use rhytid_solve::FacePart;

/// The standard deviation of the noise per axis, in millimetres.
pub const NOISE_MM: f64 = 0.1;

/// How many times each pose is played with noise.
const DRAWS: usize = 16;

/// The movement of the skin if the markers of the rest pose and of each example have noise: a summary, and
/// the RMS of each vertex in millimetres. The noise is the same every time.
///
/// # Errors
/// As playing.
pub(crate) fn noise(
    rig: &Rig,
    regions: &Regions,
    parts: &[FacePart],
    devices: &[DeviceInfo],
    progress: &dyn Progress,
) -> Result<(Errors, Vec<f32>)> {
    let millimetres = 1e3 * rig.surface().metres_per_unit;
    let rest = std::iter::once(&rig.handles().rest[..]);
    let mut numbers = Numbers::new(1);
    // Each pose as it is, and DRAWS times with noise.
    let mut frames = Vec::new();
    for pose in rest.chain(rig.examples().handles.rows()) {
        frames.extend_from_slice(pose.as_flattened());
        for _ in 0..DRAWS {
            let noisy = |x: &f32| (f64::from(*x) + normal(&mut numbers) * NOISE_MM / millimetres) as f32;
            frames.extend(pose.as_flattened().iter().map(noisy));
        }
    }
    let count = frames.len() / (3 * rig.handles().len());
    let mut playback = Playback::new(rig, devices, count)?;
    let mut sum = Sum::new(regions, parts, millimetres);
    let (mut without, mut frame) = (Vec::new(), 0);
    playback.evaluate(&frames, OutputStage::Full, false, progress, |positions, _| {
        if frame % (DRAWS + 1) == 0 {
            without.clear();
            without.extend_from_slice(positions);
        } else {
            sum.add(distances(positions, &without));
        }
        frame += 1;
        progress.step("markers' noise", frame as u64, count as u64)
    })?;
    let by_vertex = sum.by_vertex();
    Ok((sum.finish(), by_vertex))
}

/// A number with the normal distribution of variance 1 (Box and Muller).
fn normal(numbers: &mut Numbers) -> f64 {
    let radius = (-2.0 * (1.0 - numbers.unit()).ln()).sqrt();
    radius * (std::f64::consts::TAU * numbers.unit()).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_variance_it_should() {
        let mut numbers = Numbers::new(7);
        let drawn: Vec<f64> = (0..100_000).map(|_| normal(&mut numbers)).collect();
        let mean = drawn.iter().sum::<f64>() / drawn.len() as f64;
        let variance = drawn.iter().map(|x| x * x).sum::<f64>() / drawn.len() as f64;
        let beyond = drawn.iter().filter(|x| x.abs() > 1.96).count() as f64 / drawn.len() as f64;
        assert!(mean.abs() < 0.01 && (variance - 1.0).abs() < 0.02 && (beyond - 0.05).abs() < 0.003);
    }
}
