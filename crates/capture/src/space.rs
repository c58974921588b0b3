//! Finds takes that are not in the rig's space, and brings them there.
use crate::{Axes, Target};
use glam::{DMat3, DQuat, DVec3};
use rhytid_core::{LengthUnit, Take};
use rhytid_geometry::registration::fit_robustly;
use std::fmt;

/// Frames that are sampled.
const SAMPLED: usize = 60;

/// A fitting take has a frame whose mean distance from rest is below this part of the handles' extent.
const NEAR: f64 = 0.06;

/// Another space must bring the distance below this part of what it is.
const NEARER: f64 = 0.4;

/// A larger rotation, in radians, is a head's. The markers' own motion turns a robust fit by some degrees.
const TURNS: f64 = 0.14;

/// A robust fit gives less weight to markers that are off by this part of their extent.
const TOLERANCE: f64 = 0.03;

/// The unit and axes of a take that is in head space but not in the rig's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TakeSpace {
    /// Metres in one unit.
    pub metres_per_unit: f64,
    /// The take's axes that the mesh's x, y and z are.
    pub axes: Axes,
}

impl TakeSpace {
    /// Brings a take into the space of a mesh with this unit: its positions, and its head's motion.
    pub fn bring(&self, take: &mut Take, metres_per_unit: f64) {
        let scale = self.metres_per_unit / metres_per_unit;
        for x in &mut take.positions {
            *x = self.axes.apply(*x).map(|c| scale * c);
        }
        let turn = self.axes.matrix();
        for motion in take.head.iter_mut().flatten() {
            let rotation = turn * DMat3::from_quat(DQuat::from_array(motion.rotation)) * turn.transpose();
            motion.rotation = DQuat::from_mat3(&rotation).normalize().to_array();
            motion.translation = self.axes.apply(motion.translation).map(|c| scale * c);
        }
    }

    /// The unit's name, if it has one.
    pub fn unit(&self) -> Option<&'static str> {
        LengthUnit::of_metres(self.metres_per_unit).map(|unit| unit.name)
    }
}

/// Why a take is not in the rig's space.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Misfit {
    /// In this space it would fit.
    Space(TakeSpace),
    /// The take contains the head's motion: the largest rotation in degrees.
    HeadMotion(f64),
    /// No frame is near the rest pose, in no unit and with no axes.
    NoFrameNearRest,
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Space(space) => {
                write!(f, "no frame is near the rest pose, but one would be if the take were")?;
                if let Some(unit) = space.unit() {
                    write!(f, " in {unit}")?;
                }
                if space.axes != Axes::SAME {
                    let mirror = if space.axes.is_mirror_image() { ", a mirror image" } else { "" };
                    write!(f, " with {} for the mesh's x, y and z{mirror}", space.axes)?;
                }
                Ok(())
            }
            Self::HeadMotion(degrees) => {
                write!(
                    f,
                    "the markers turn together by up to {degrees:.0}°, as a head does: the take is not in head space"
                )
            }
            Self::NoFrameNearRest => {
                write!(f, "no frame is near the rest pose, whatever the take's unit and axes")
            }
        }
    }
}

/// Tells why a take is not in the rig's space; `None` if it is. A take in the rig's space has the target's
/// handles in their order and without gaps. One of its frames is near the rest pose, and its head is still.
pub fn misfit(take: &Take, target: &Target) -> Option<Misfit> {
    let handles = target.rest.len();
    if handles < 4 || take.labels.len() != handles || take.frames() == 0 {
        return None;
    }
    let (low, high) =
        target.rest.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
    let extent = low.distance(high);
    let step = take.frames().div_ceil(SAMPLED);
    let frames: Vec<&[[f64; 3]]> = take.positions.chunks_exact(handles).step_by(step).collect();
    // The smallest mean distance from rest of any frame, as a part of the extent.
    let off = |to_mesh: &dyn Fn([f64; 3]) -> DVec3| {
        let of_frame = |frame: &&[[f64; 3]]| {
            let distances = frame.iter().zip(&target.rest).map(|(x, rest)| to_mesh(*x).distance(*rest));
            distances.sum::<f64>() / (handles as f64 * extent)
        };
        frames.iter().map(of_frame).fold(f64::INFINITY, f64::min)
    };
    let as_it_is = off(&DVec3::from_array);
    if as_it_is > NEAR {
        let usual = LengthUnit::ALL.map(|unit| unit.metres);
        let units = std::iter::once(target.metres_per_unit).chain(usual);
        // Simple spaces come first. A later one must be better by 0.1 %.
        let spaces = units.flat_map(|metres_per_unit| {
            let turns = std::iter::once(Axes::SAME).chain(Axes::all()).chain(Axes::with_mirror_images());
            turns.map(move |axes| TakeSpace { metres_per_unit, axes })
        });
        let mut best = (f64::INFINITY, None);
        for space in spaces {
            let scale = space.metres_per_unit / target.metres_per_unit;
            let found = off(&|x| scale * DVec3::from_array(space.axes.apply(x)));
            if found < 0.999 * best.0 {
                best = (found, Some(space));
            }
        }
        if let (found, Some(space)) = best
            && found <= NEAR
            && found < NEARER * as_it_is
        {
            return Some(Misfit::Space(space));
        }
    }
    // The rotation of a frame against rest, if there is one.
    let turned = |frame: &&[[f64; 3]]| {
        let now: Vec<DVec3> = frame.iter().copied().map(DVec3::from_array).collect();
        let (motion, _) = fit_robustly(&target.rest, &now, false, TOLERANCE * extent)?;
        let mean = |from: &dyn Fn(DVec3) -> DVec3| {
            now.iter().zip(&target.rest).map(|(a, b)| a.distance(from(*b))).sum::<f64>() / handles as f64
        };
        let (before, after) = (mean(&|x| x), mean(&|x| motion.apply(x)));
        // A pose far from rest also turns a fit, but the fit does not explain the pose.
        (after < 0.5 * before && after < NEAR * extent)
            .then(|| motion.rotation.angle_between(DQuat::IDENTITY))
    };
    let most = frames.iter().filter_map(turned).fold(0.0, f64::max);
    if most > TURNS {
        return Some(Misfit::HeadMotion(most.to_degrees()));
    }
    (as_it_is > NEAR).then_some(Misfit::NoFrameNearRest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::RigidMotion;

    fn target() -> Target {
        let rest = (0..20).map(|i| {
            let (x, y) = (f64::from(i % 5) - 2.0, f64::from(i / 5) - 1.0);
            DVec3::new(4.0 * x, 5.0 * y, 9.0 - 0.4 * x * x - 0.2 * y * y + 0.1 * f64::from(i % 3))
        });
        Target {
            labels: (0..20).map(|i| format!("m{i}")).collect(),
            rest: rest.collect(),
            metres_per_unit: 0.01,
            strains: vec![],
            examples: vec![],
        }
    }

    /// At rest, and then away from it.
    fn take(target: &Target) -> Take {
        let moved = |f: i32| {
            target.rest.iter().enumerate().map(move |(i, x)| {
                let by = 0.05 * f64::from(f) * ((i as f64).sin() + 0.3);
                (*x + DVec3::new(0.2 * by, by, -0.3 * by)).to_array()
            })
        };
        Take {
            labels: target.labels.clone(),
            times: (0..30).map(|f| f64::from(f) / 30.0).collect(),
            positions: (0..30).flat_map(moved).collect(),
            head: Some(vec![
                RigidMotion { rotation: [0.0, 0.6, 0.0, 0.8], translation: [1.0, 2.0, 3.0] };
                30
            ]),
            ..Take::default()
        }
    }

    #[test]
    fn a_take_in_the_rigs_space_is_left_in_peace() {
        let target = target();
        assert_eq!(misfit(&take(&target), &target), None);
    }

    #[test]
    fn units_axes_and_mirror_images_are_found_and_undone() {
        let target = target();
        let right = take(&target);
        for (metres_per_unit, axes) in
            [(1e-3, "+x+y+z"), (0.0254, "+x+y+z"), (0.01, "+x+z-y"), (0.01, "-x+y+z"), (1.0, "-z+y+x")]
        {
            let space = TakeSpace { metres_per_unit, axes: axes.parse().unwrap() };
            let mut wrong = right.clone();
            let inverse = space.axes.matrix().transpose();
            let out = |x: [f64; 3]| (inverse * DVec3::from_array(x) * (0.01 / metres_per_unit)).to_array();
            wrong.positions.iter_mut().for_each(|x| *x = out(*x));
            for motion in wrong.head.iter_mut().flatten() {
                motion.translation = out(motion.translation);
                let turned =
                    inverse * DMat3::from_quat(DQuat::from_array(motion.rotation)) * inverse.transpose();
                motion.rotation = DQuat::from_mat3(&turned).to_array();
            }
            assert_eq!(misfit(&wrong, &target), Some(Misfit::Space(space)), "{axes}");
            space.bring(&mut wrong, 0.01);
            for (a, b) in wrong.positions.iter().zip(&right.positions) {
                assert!(DVec3::from_array(*a).distance(DVec3::from_array(*b)) < 1e-12);
            }
            let [a, b] = [&wrong, &right].map(|take| take.head.as_ref().unwrap()[3]);
            assert!(DVec3::from_array(a.translation).distance(DVec3::from_array(b.translation)) < 1e-12);
            let [a, b] = [a, b].map(|motion| DQuat::from_array(motion.rotation));
            assert!(a.angle_between(b) < 1e-7, "{a} {b}");
        }
    }

    #[test]
    fn head_motion_and_nonsense_are_told_apart() {
        let target = target();
        let mut turning = take(&target);
        for (f, frame) in turning.positions.chunks_mut(20).enumerate() {
            let turn = DQuat::from_rotation_y(20.0_f64.to_radians() * f as f64 / 29.0);
            frame.iter_mut().for_each(|x| *x = (turn * DVec3::from_array(*x)).to_array());
        }
        let Some(Misfit::HeadMotion(degrees)) = misfit(&turning, &target) else { panic!("a turning head") };
        assert!((15.0..22.0).contains(&degrees), "{degrees}");
        let mut nonsense = take(&target);
        for (i, x) in nonsense.positions.iter_mut().enumerate() {
            *x = [90.0 * (i as f64).sin(), 70.0 * (3.0 * i as f64).cos(), 80.0 * (1.7 * i as f64).sin()];
        }
        assert_eq!(misfit(&nonsense, &target), Some(Misfit::NoFrameNearRest));
    }
}
