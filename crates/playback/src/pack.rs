//! Packed rigs: how far the numbers of a rig may be rounded so that frames stay within a bound.

use crate::Playback;
use crate::poses::poses;
use rhytid_core::rig_file::{self, Packing, Step};
use rhytid_core::{DeviceInfo, Error, Progress, Result, Rig};
use rhytid_formats::export::OutputStage;
use rhytid_kernels::vec3;

/// Poses that are evaluated at once.
const BATCH: usize = 16;
/// The first step of an array, as a part of its largest number.
const FIRST: f32 = 1.0 / 512.0;
/// The largest step of an array, as a part of its largest number.
const LARGEST: f32 = 1.0 / 16.0;
/// Steps are chosen so that the error is this part of the bound.
const AIM: f64 = 0.97;
/// The steps are good enough if the error is at least this part of the aim.
const CLOSE: f64 = 0.96;
/// How many times the steps of all arrays are chosen, at most.
const ROUNDS: usize = 8;

/// A packed rig.
pub struct Packed {
    /// The bytes of its file.
    pub bytes: Vec<u8>,
    /// What the file states.
    pub packing: Packing,
}

/// Packs a rig.
///
/// In all examples, half of the way to each, and in all frames of a take, no vertex is farther than
/// `max_error`, in mesh units, from where the rig has it. `take` has frames × H positions of handles, and may
/// be empty. Without examples, poses in which all handles move count instead of them.
///
/// The bound is for frames as a device gives them. Triangles that are turned back afterwards, and parts that
/// touch, may magnify the error of a few vertices; [`Packing::finished`] is the largest error then.
///
/// [`rig_file::read`] and [`rig_file::decode`] read the file as they read any rig.
///
/// # Errors
/// [`Error::Input`] if the bound is too small for the file's numbers. [`Error::Device`];
/// [`Error::Cancelled`].
pub fn pack(
    rig: &Rig,
    take: &[[f32; 3]],
    max_error: f64,
    devices: &[DeviceInfo],
    progress: &dyn Progress,
) -> Result<Packed> {
    const NAME: &str = "choose how to round";
    let own = poses(rig);
    let all = [&own, take].concat();
    let mut whole = Playback::new(rig, devices, BATCH)?;
    let mut off = |steps: &[Step], poses: &[[f32; 3]], frames: Frames| -> Result<Difference> {
        let rounded = rig_file::rounded(rig, steps)?;
        let mut packed = Playback::new(&rounded, devices, BATCH)?;
        difference(&mut whole, &mut packed, poses, frames, progress)
    };
    let arrays = rig_file::roundable(rig);
    let columns: usize = arrays.iter().map(|numbers| numbers.columns).sum();
    let total = (arrays.len() + ROUNDS) as u64;
    let mut steps = Vec::new();
    for (i, numbers) in arrays.iter().enumerate() {
        progress.step(NAME, i as u64, total)?;
        let first = Step { array: numbers.array, size: FIRST * numbers.largest };
        let worst = off(&[first], &own, Frames::OfDevice)?.worst;
        // An array with more numbers gets more of the error, since each number saves as much. Squares of
        // errors add up.
        let share = max_error * (numbers.columns as f64 / columns as f64).sqrt();
        let size = (f64::from(first.size) * share / worst) as f32;
        // Numbers that move nothing say how certain a position is.
        let size = if worst > 0.0 { size.min(LARGEST * numbers.largest) } else { first.size };
        steps.push(Step { size, ..first });
    }
    let mut best: Option<(Vec<Step>, Difference)> = None;
    for round in 0..ROUNDS {
        progress.step(NAME, (arrays.len() + round) as u64, total)?;
        let found = off(&steps, &all, Frames::OfDevice)?;
        let factor = AIM * max_error / found.worst.max(1e-3 * max_error);
        let is_larger = best.as_ref().is_none_or(|(_, best)| found.worst > best.worst);
        if found.worst <= max_error && is_larger {
            best = Some((steps.clone(), found));
        }
        if (CLOSE..=1.0 / CLOSE).contains(&factor) && best.is_some() {
            break;
        }
        steps.iter_mut().for_each(|step| step.size *= factor as f32);
    }
    progress.step(NAME, total, total)?;
    let Some((steps, found)) = best else {
        return Err(Error::out_of_range(
            "no rounding that saves bytes keeps all vertices within the error that is allowed; allow a larger one",
        ));
    };
    let finished = off(&steps, &all, Frames::Finished)?;
    let packing = Packing {
        worst: found.worst,
        rms: found.rms,
        normals: found.normals,
        finished: finished.worst,
        finished_beyond: finished.by_vertex.iter().filter(|&&worst| worst > found.worst).count(),
        poses: all.len() / rig.handles().len(),
        rig: rig_file::hash_of(rig)?,
    };
    Ok(Packed { bytes: rig_file::pack(rig, &steps, &packing)?, packing })
}

/// Which frames are compared.
#[derive(Clone, Copy)]
enum Frames {
    /// As a device gives them.
    OfDevice,
    /// With triangles turned back and parts kept apart.
    Finished,
}

impl Frames {
    /// Hands positions and normals of each pose to `each`.
    fn play(
        self,
        playback: &mut Playback<'_>,
        poses: &[[f32; 3]],
        progress: &dyn Progress,
        mut each: impl FnMut(&[[f32; 3]], &[[f32; 3]]),
    ) -> Result<()> {
        match self {
            Self::OfDevice => playback.evaluate_unfinished(poses, progress, each),
            Self::Finished => {
                let handles = poses.as_flattened();
                playback.evaluate(handles, OutputStage::Full, true, progress, |positions, normals| {
                    each(positions.as_chunks().0, normals.as_chunks().0);
                    Ok(())
                })
            }
        }
    }
}

/// How far poses of two rigs are from each other.
struct Difference {
    /// The largest distance of a vertex.
    worst: f64,
    /// V: the largest distance of each vertex.
    by_vertex: Vec<f64>,
    rms: f64,
    /// The root of the mean squared angle between normals, in degrees.
    normals: f64,
}

fn difference(
    whole: &mut Playback<'_>,
    packed: &mut Playback<'_>,
    poses: &[[f32; 3]],
    frames: Frames,
    progress: &dyn Progress,
) -> Result<Difference> {
    let handles = whole.rig().handles().len();
    let mut by_vertex = vec![0.0_f64; whole.rig().vertices()];
    let (mut squares, mut turned, mut count) = (0.0, 0.0, 0_usize);
    let apart = |a: &[f32; 3], b: &[f32; 3]| {
        let off = vec3::sub(a.map(f64::from), b.map(f64::from));
        vec3::dot(off, off)
    };
    for (i, some) in poses.chunks(BATCH * handles).enumerate() {
        if let Frames::Finished = frames {
            progress.step("compare finished frames", (i * BATCH) as u64, (poses.len() / handles) as u64)?;
        }
        let mut of_whole = Vec::new();
        frames.play(whole, some, progress, |positions, normals| {
            of_whole.push((positions.to_vec(), normals.to_vec()));
        })?;
        let mut of_whole = of_whole.into_iter();
        frames.play(packed, some, progress, |positions, normals| {
            let (before, normals_before) = of_whole.next().unwrap_or_default();
            for ((worst, a), b) in by_vertex.iter_mut().zip(positions).zip(&before) {
                let square = apart(a, b);
                *worst = worst.max(square);
                squares += square;
            }
            // The chord of a small angle is about as long as the angle.
            turned += normals.iter().zip(&normals_before).map(|(a, b)| apart(a, b)).sum::<f64>();
            count += positions.len();
        })?;
    }
    by_vertex.iter_mut().for_each(|square| *square = square.sqrt());
    let mean = |sum: f64| (sum / count.max(1) as f64).sqrt();
    Ok(Difference {
        worst: by_vertex.iter().copied().fold(0.0, f64::max),
        by_vertex,
        rms: mean(squares),
        normals: mean(turned).to_degrees(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_conformance::evaluate;
    use rhytid_core::NoProgress;
    use rhytid_devices::{Guard, choose_devices};
    use rhytid_test_support::lips;

    /// Beside the reference evaluation of both rigs.
    #[test]
    fn a_packed_rig_is_within_the_bound_and_meets_its_markers() {
        let devices = choose_devices("cpu:0", Guard::NONE, &NoProgress).unwrap().devices;
        for face in [rhytid_demo::face(1_000), lips::face()] {
            let rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
            let extent =
                10.0 * f64::from(rig.surface().rest.iter().flatten().fold(0.0_f32, |m, x| m.max(x.abs())));
            for max_error in [1e-3 * extent, 1e-5 * extent] {
                let packed = pack(&rig, &[], max_error, &devices, &NoProgress).unwrap();
                let found = rig_file::decode(&packed.bytes, "small").unwrap();
                let mut worst = 0.0_f64;
                for pose in poses(&rig).chunks(rig.handles().len()) {
                    let [before, after] = [&rig, &found].map(|rig| evaluate(rig, pose).positions);
                    for (a, b) in before.iter().zip(&after) {
                        let off = vec3::sub(a.map(f64::from), b.map(f64::from));
                        worst = worst.max(vec3::length(off));
                    }
                    for (point, marker) in found.handles().points.iter().zip(pose) {
                        let off = vec3::sub(point.at(&after), *marker);
                        assert!(f64::from(vec3::length(off)) < 1e-6 * extent, "{point:?}");
                    }
                }
                assert!(worst <= max_error * 1.001, "{worst} of {max_error}");
                assert!(worst > 0.5 * max_error, "{worst} of {max_error}: bytes are wasted");
                assert!((worst - packed.packing.worst).abs() < 1e-2 * max_error + 1e-6 * extent);
            }
            let [coarse, fine] =
                [1e-3, 1e-5].map(|part| pack(&rig, &[], part * extent, &devices, &NoProgress).unwrap());
            let whole = rig_file::encode(&rig).unwrap().len();
            assert!(coarse.bytes.len() < fine.bytes.len() && 2 * fine.bytes.len() < whole);
            assert_eq!(coarse.packing.rig, rig_file::hash_of(&rig).unwrap());
        }
    }

    #[test]
    fn a_rig_without_examples_is_packed_too() {
        let mut face = rhytid_demo::face(1_000);
        face.examples.clear();
        let rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let devices = choose_devices("cpu:0", Guard::NONE, &NoProgress).unwrap().devices;
        let packed = pack(&rig, &[], 0.01, &devices, &NoProgress).unwrap();
        assert_eq!(packed.packing.poses, 3);
        assert!(rig_file::decode(&packed.bytes, "small").unwrap().vertices() == rig.vertices());
    }
}
