//! Packed rigs: how far the numbers of a rig may be rounded so that frames stay within a bound.

use crate::Playback;
use rhytid_core::rig_file::{self, Packing, Step};
use rhytid_core::{DeviceInfo, Error, Progress, Result, Rig, human};
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
    /// The root of the mean squared angle between the normals of both rigs, in degrees.
    pub normals: f64,
}

/// Packs a rig.
///
/// In all examples, and half of the way to each, no vertex is farther than `max_error`, in mesh units, from
/// where the rig has it. Without examples, poses in which all handles move count instead. Triangles that are
/// turned back afterwards, and parts that touch, may magnify the error of a few vertices.
///
/// [`rig_file::read`] and [`rig_file::decode`] read the file as they read any rig.
///
/// # Errors
/// [`Error::Input`] if the bound is too small for the file's numbers. [`Error::Device`];
/// [`Error::Cancelled`].
pub fn pack(rig: &Rig, max_error: f64, devices: &[DeviceInfo], progress: &dyn Progress) -> Result<Packed> {
    const NAME: &str = "choose how to round";
    let poses = poses(rig);
    let mut whole = Playback::new(rig, devices, BATCH)?;
    let mut off = |steps: &[Step]| -> Result<Difference> {
        let rounded = rig_file::rounded(rig, steps)?;
        let mut packed = Playback::new(&rounded, devices, BATCH)?;
        difference(&mut whole, &mut packed, &poses, progress)
    };
    let arrays = rig_file::roundable(rig);
    let columns: usize = arrays.iter().map(|numbers| numbers.columns).sum();
    let total = (arrays.len() + ROUNDS) as u64;
    let mut steps = Vec::new();
    for (i, numbers) in arrays.iter().enumerate() {
        progress.step(NAME, i as u64, total)?;
        let first = Step { array: numbers.array, size: FIRST * numbers.largest };
        let worst = off(&[first])?.worst;
        // An array with more numbers gets more of the error, since each number saves as much.
        let share = max_error * numbers.columns as f64 / columns as f64;
        let size = (f64::from(first.size) * share / worst) as f32;
        // Numbers that move nothing say how certain a position is.
        let size = if worst > 0.0 { size.min(LARGEST * numbers.largest) } else { first.size };
        steps.push(Step { size, ..first });
    }
    let mut best: Option<(Vec<Step>, Difference)> = None;
    for round in 0..ROUNDS {
        progress.step(NAME, (arrays.len() + round) as u64, total)?;
        let found = off(&steps)?;
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
        return Err(Error::out_of_range(format!(
            "no rounding that saves bytes keeps all vertices within {} mm; allow a larger error",
            human::number(max_error * rig.surface().metres_per_unit * 1000.0)
        )));
    };
    let packing = Packing {
        worst: found.worst,
        rms: found.rms,
        poses: poses.len() / rig.handles().len(),
        rig: rig_file::hash_of(rig)?,
    };
    Ok(Packed { bytes: rig_file::pack(rig, &steps, &packing)?, packing, normals: found.normals })
}

/// The poses that are compared.
fn poses(rig: &Rig) -> Vec<[f32; 3]> {
    let (examples, rest) = (&rig.examples().handles, &rig.handles().rest);
    if examples.is_empty() {
        return moved(rig);
    }
    let between = examples
        .as_slice()
        .iter()
        .zip(rest.iter().cycle())
        .map(|(at, rest)| std::array::from_fn(|axis| 0.5 * (at[axis] + rest[axis])));
    examples.as_slice().iter().copied().chain(between).collect()
}

/// Poses of a rig without examples: all handles move by a hundredth of the face, along each axis, every other
/// one back.
fn moved(rig: &Rig) -> Vec<[f32; 3]> {
    let rest = &rig.handles().rest;
    let extent = |axis: usize| {
        let [low, high] = rig
            .surface()
            .rest
            .iter()
            .fold([f32::MAX, f32::MIN], |[low, high], x| [low.min(x[axis]), high.max(x[axis])]);
        high - low
    };
    let step = 0.01 * (0..3).map(extent).fold(0.0, f32::max);
    let pose = |axis: usize| {
        rest.iter().enumerate().map(move |(h, at)| {
            let mut at = *at;
            at[axis] += if h % 2 == 0 { step } else { -step };
            at
        })
    };
    (0..3).flat_map(pose).collect()
}

/// How far poses of two rigs are from each other.
struct Difference {
    /// The largest distance of a vertex.
    worst: f64,
    rms: f64,
    /// The root of the mean squared angle between normals, in degrees.
    normals: f64,
}

fn difference(
    whole: &mut Playback<'_>,
    packed: &mut Playback<'_>,
    poses: &[[f32; 3]],
    progress: &dyn Progress,
) -> Result<Difference> {
    let handles = whole.rig().handles().len();
    let (mut worst, mut squares, mut turned, mut count) = (0.0_f64, 0.0, 0.0, 0_usize);
    let each = |a: &[[f32; 3]], b: &[[f32; 3]], see: &mut dyn FnMut(f64)| {
        for (a, b) in a.iter().zip(b) {
            let off = vec3::sub(a.map(f64::from), b.map(f64::from));
            see(vec3::dot(off, off));
        }
    };
    for poses in poses.chunks(BATCH * handles) {
        let mut frames = Vec::new();
        whole.evaluate_unfinished(poses, progress, |positions, normals| {
            frames.push((positions.to_vec(), normals.to_vec()));
        })?;
        let mut frames = frames.into_iter();
        packed.evaluate_unfinished(poses, progress, |positions, normals| {
            let (before, normals_before) = frames.next().unwrap_or_default();
            each(positions, &before, &mut |square| {
                worst = worst.max(square);
                squares += square;
            });
            // The chord of a small angle is about as long as the angle.
            each(normals, &normals_before, &mut |square| turned += square);
            count += positions.len();
        })?;
    }
    let mean = |sum: f64| (sum / count.max(1) as f64).sqrt();
    Ok(Difference { worst: worst.sqrt(), rms: mean(squares), normals: mean(turned).to_degrees() })
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
                let packed = pack(&rig, max_error, &devices, &NoProgress).unwrap();
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
                [1e-3, 1e-5].map(|part| pack(&rig, part * extent, &devices, &NoProgress).unwrap());
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
        let packed = pack(&rig, 0.01, &devices, &NoProgress).unwrap();
        assert_eq!(packed.packing.poses, 3);
        assert!(rig_file::decode(&packed.bytes, "small").unwrap().vertices() == rig.vertices());
    }
}
