//! Curves: a number for each name and frame, such as the weights of blend shapes that a phone records.
//!
//! Curves are no places of markers. They become places on a rig whose shapes have the same names.
mod live_link;
mod names;
mod read;
mod write;

pub use live_link::write_weights;
pub use names::{Meant, meant};
pub use read::{decode, read};
pub use write::write_curves;

/// Curves over time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curves {
    /// N distinct names, as the file has them.
    pub names: Vec<String>,
    /// One time per frame, in seconds, strictly increasing.
    pub times: Vec<f64>,
    /// frames × N numbers. 1 is the whole shape, and numbers outside 0 to 1 are kept.
    pub weights: Vec<f32>,
    /// What the reader had to assume or to leave out, one sentence each.
    pub warnings: Vec<String>,
}

impl Curves {
    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.times.len()
    }

    /// The largest absolute weight of curve `i`; 0 without frames.
    pub fn largest(&self, i: usize) -> f32 {
        let column = self.weights.iter().skip(i).step_by(self.names.len().max(1));
        column.fold(0.0, |largest, weight| largest.max(weight.abs()))
    }
}

/// Whether a column of this name holds an angle or a place of the head or an eye, and no weight.
pub(crate) fn is_pose(name: &str) -> bool {
    const ANGLES: [&str; 3] = ["yaw", "pitch", "roll"];
    const AXES: [&str; 4] = ["x", "y", "z", "w"];
    let words = names::words(name);
    let has = |part: &str| words.iter().any(|word| word.contains(part));
    // `HeadYaw`, `head_rot_x`, `headTX` and `head_qw`.
    let is_axis = |word: &str| AXES.contains(&word.strip_prefix(['t', 'r', 'q']).unwrap_or(word));
    let ends = |word: &String| ANGLES.iter().any(|angle| word.ends_with(angle)) || is_axis(word);
    (has("head") || has("eye")) && words.last().is_some_and(ends)
}

/// Whether a name is one of the 52 of ARKit, in any spelling, or one of a MetaHuman's controls.
pub(crate) fn is_known(name: &str) -> bool {
    let key = names::Key::of(name);
    names::ARKIT.contains(&&*key.base) || name.to_ascii_lowercase().contains("ctrl_expressions_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_head_and_the_eyes_have_poses_and_no_weights() {
        for name in
            ["HeadYaw", "headyaw", "LeftEyePitch", "head_x", "headPosX", "head_rot_z", "headTX", "head_qw"]
        {
            assert!(is_pose(name), "{name}");
        }
        for name in ["EyeBlinkLeft", "eyeLookInLeft", "mouthRollLower", "jawOpen", "head", "rollx", ""] {
            assert!(!is_pose(name), "{name}");
        }
    }
}
