//! Poses in which rigs are compared.

use rhytid_core::Rig;

/// Handle positions of a rig's examples, and half of the way to each; or of poses in which all handles move,
/// where there is no example. Poses × H.
pub(crate) fn poses(rig: &Rig) -> Vec<[f32; 3]> {
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
