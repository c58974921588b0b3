//! Morph targets: their number, their names, and what they add to the base.

use rhytid_core::{Error, Result};
use rhytid_export::Options;
use rhytid_export::morphs::Values;
use std::path::Path;

/// The number of targets that WebGL 2 guarantees. It is more than most programs show as sliders.
const MOST_TARGETS: usize = 256;

/// The largest number of targets that `options` allow.
pub(super) fn most_targets(options: &Options) -> usize {
    let without_force = if options.force { usize::MAX } else { MOST_TARGETS };
    options.most_targets.unwrap_or(without_force)
}

/// The phrase for an error about a limit of `most` targets: which programs have which limit.
pub(super) fn targets_that_viewers_show(most: usize) -> String {
    format!(
        "the limit of {most} morph targets (WebGL 2 promises three.js and Babylon.js {MOST_TARGETS}; some game engines \
         show 64)"
    )
}

/// Base normals of 3V coordinates: glTF demands a direction even where there is none.
pub(super) fn unit_normals(normals: &[f32]) -> Vec<f32> {
    let unit = |&normal: &[f32; 3]| if normal == [0.0; 3] { [0.0, 0.0, 1.0] } else { normal };
    normals.as_chunks::<3>().0.iter().flat_map(unit).collect()
}

/// `to` − `from`.
pub(super) fn differences(from: &[f32], to: &[f32]) -> Vec<f32> {
    from.iter().zip(to).map(|(from, to)| to - from).collect()
}

/// The offsets from the normals `from` to the directions `to`. If a direction is 0, the base's stays: viewers
/// normalise the sum, and 0 has no direction.
pub(super) fn normal_differences(from: &[f32], to: &[f32]) -> Vec<f32> {
    let pairs = from.as_chunks::<3>().0.iter().zip(to.as_chunks::<3>().0);
    let offset = |(from, to): (&[f32; 3], &[f32; 3])| match *to == [0.0; 3] {
        true => [0.0; 3],
        false => std::array::from_fn(|axis| to[axis] - from[axis]),
    };
    pairs.flat_map(offset).collect()
}

/// The name of the target that is frame `frame`.
pub(super) fn frame_name(first_time_code: f64, frame: usize) -> String {
    format!("frame {:04}", first_time_code + frame as f64)
}

/// An error where an offset of 3V `offsets` overflows.
pub(super) fn check_finite(offsets: &[f32], frame: usize, path: &Path) -> Result<()> {
    match offsets.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(i) => Err(Error::out_of_range(format!(
            "{}: in frame {frame} (from 0), vertex {} is farther from its place in frame 0 than a 32-bit number holds",
            path.display(),
            i / 3
        ))),
    }
}

/// 32-bit `values`, for an attribute.
pub(super) fn floats(values: Vec<f32>) -> Values {
    Values::F32(values)
}
