//! The keys of each frame.

use super::arrays::Arrays;
use super::layout::Layout;
use glam::{DMat4, DQuat, DVec3};
use rhytid_core::{Error, Result};

/// What each frame is made of.
pub(super) struct Motion {
    /// The targets with a weight other than 0 and that weight, of all frames in turn.
    weights: Vec<(usize, f64)>,
    /// Where the part of each frame begins in `weights`, and where the last part ends; empty if there are no
    /// weights.
    begins: Vec<usize>,
    /// The head pose, along glTF's axes in metres.
    pub head: Option<Vec<DMat4>>,
}

impl Motion {
    pub(super) fn read(arrays: &mut Arrays, layout: &Layout) -> Result<Self> {
        check_times(arrays, layout)?;
        let mut motion = Self { weights: Vec::new(), begins: Vec::new(), head: None };
        if let Some(accessor) = layout.weights {
            motion.read_weights(arrays, accessor, layout)?;
        }
        if let Some(accessors) = layout.head {
            motion.head = Some(read_head(arrays, accessors, layout.frames)?);
        }
        Ok(motion)
    }

    /// The targets that take part in a frame, and how much.
    pub(super) fn weights_of(&self, frame: usize) -> &[(usize, f64)] {
        match self.begins.get(frame..frame + 2) {
            Some(&[begin, end]) => &self.weights[begin..end],
            _ => &[],
        }
    }

    /// Whether frame k is target k and nothing else, of so many targets.
    pub(super) fn is_one_hot(&self, targets: usize) -> bool {
        let frames = self.begins.len().saturating_sub(1);
        frames == targets && (0..frames).all(|frame| self.weights_of(frame) == [(frame, 1.0)])
    }

    fn read_weights(&mut self, arrays: &mut Arrays, accessor: usize, layout: &Layout) -> Result<()> {
        let (frames, targets) = (layout.frames as u64, layout.targets.len() as u64);
        let count = frames.checked_mul(targets).ok_or_else(|| {
            Error::malformed(format!(
                "{}: has {frames} frames of {targets} targets; it is damaged",
                arrays.name
            ))
        })?;
        for (place, weight) in arrays.nonzero(accessor, count)? {
            if !(0.0..=1.0).contains(&weight) {
                return Err(Error::malformed(format!(
                    "{}: weight {place} is {weight}, expected 0 to 1; the file is damaged",
                    arrays.name
                )));
            }
            // As many frames as there are times, which were read.
            self.begins.resize((place / targets) as usize + 1, self.weights.len());
            self.weights.push(((place % targets) as usize, weight));
        }
        self.begins.resize(layout.frames + 1, self.weights.len());
        Ok(())
    }
}

/// Frame k is to be shown at k / rate seconds, to 32-bit precision.
fn check_times(arrays: &mut Arrays, layout: &Layout) -> Result<()> {
    let Some(accessor) = layout.times else { return Ok(()) };
    let times = arrays.vectors::<1>(accessor)?;
    if times.len() != layout.frames {
        return Err(Error::malformed(format!(
            "{}: has {} times for {} frames; the file is damaged",
            arrays.name,
            times.len(),
            layout.frames
        )));
    }
    let wrong = times.iter().enumerate().find(|(k, [time])| {
        let expected = *k as f64 / layout.rate;
        let off = (time - expected).abs();
        off.is_nan() || off > f64::from(f32::EPSILON) * expected
    });
    match wrong {
        None => Ok(()),
        Some((k, [time])) => Err(Error::malformed(format!(
            "{}: frame {k} (from 0) is at {time} s, expected {} s; the file is damaged",
            arrays.name,
            k as f64 / layout.rate
        ))),
    }
}

fn read_head(
    arrays: &mut Arrays,
    [rotations, translations]: [usize; 2],
    frames: usize,
) -> Result<Vec<DMat4>> {
    let (rotations, translations) = (arrays.vectors::<4>(rotations)?, arrays.vectors::<3>(translations)?);
    let fault = |what: &str| Error::malformed(format!("{}: {what}; the file is damaged", arrays.name));
    if rotations.len() != frames || translations.len() != frames {
        return Err(fault("does not have the head pose of each frame"));
    }
    let keys = rotations.iter().zip(&translations).map(|(&rotation, &translation)| {
        let rotation = DQuat::from_array(rotation);
        let rigid = (rotation.length() - 1.0).abs() < 1e-5;
        rigid.then(|| DMat4::from_rotation_translation(rotation.normalize(), DVec3::from_array(translation)))
    });
    keys.collect::<Option<_>>()
        .ok_or_else(|| fault("has a rotation of the head that is not a unit quaternion"))
}
