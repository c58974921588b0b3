//! The frames beside what stored targets give for them, part by part.

use super::frames::{Attribute, Frames, TASK};
use super::linear::product;
use faer::{Mat, MatRef};
use rayon::prelude::*;
use rhytid_core::Result;
use std::borrow::Cow;
use std::ops::Range;

/// The targets are converted once for all frames if they fit into so many bytes.
const KEPT_BYTES: usize = 1 << 26;

/// The stored numbers of an attribute without its base.
pub(super) struct Moving<'a, T> {
    /// Number i of target k is `target(k, i)`.
    pub target: T,
    /// K.
    pub targets: usize,
    /// Frames × K.
    pub weights: &'a [f32],
}

/// Some vertices in some frames.
pub(super) struct Part<'a> {
    /// The first vertex.
    pub vertex: usize,
    /// How many vertices.
    pub vertices: usize,
    /// The frames.
    pub frames: Range<usize>,
    /// K numbers of each component: those of the targets.
    pub targets: &'a [f64],
    moved: Mat<f64>,
    given: &'a [f32],
    numbers: usize,
}

impl Part<'_> {
    /// What the targets add to the components in a frame of the part.
    pub(super) fn moved(&self, frame: usize) -> &[f64] {
        self.moved.col_as_slice(frame - self.frames.start)
    }

    /// The components that came in.
    pub(super) fn given(&self, frame: usize) -> &[f32] {
        &self.given[(frame - self.frames.start) * self.numbers + 3 * self.vertex..][..3 * self.vertices]
    }
}

/// Calls `look` for all parts and `add` for the results, in a fixed order. A part is of one clip, which `add`
/// is told with the result.
///
/// # Errors
/// [`rhytid_core::Error::Io`].
pub(super) fn for_each<T, R>(
    frames: &mut Frames,
    attribute: Attribute,
    moving: &Moving<'_, T>,
    look: impl Fn(&Part<'_>) -> R + Sync,
    mut add: impl FnMut(usize, R),
) -> Result<()>
where
    T: Fn(usize, usize) -> f64 + Sync,
    R: Send,
{
    let (count, k) = (frames.vertices(), moving.targets);
    let targets_of = |task: usize| -> Vec<f64> {
        let components = 3 * TASK * task..3 * count.min(TASK * (task + 1));
        components.flat_map(|i| (0..k).map(move |k| (moving.target)(k, i))).collect()
    };
    let tasks = count.div_ceil(TASK);
    let fits = 3 * count * k * size_of::<f64>() <= KEPT_BYTES;
    let kept: Vec<Vec<f64>> =
        if fits { (0..tasks).into_par_iter().map(targets_of).collect() } else { Vec::new() };
    let mut given = Vec::new();
    for range in frames.batches() {
        frames.batch(attribute, range.clone(), &mut given)?;
        let weights =
            Mat::from_fn(k, range.len(), |j, i| f64::from(moving.weights[(range.start + i) * k + j]));
        let look_at = |task: usize| {
            let vertex = task * TASK;
            let vertices = TASK.min(count - vertex);
            let targets = kept.get(task).map_or_else(|| Cow::Owned(targets_of(task)), Cow::from);
            let t = MatRef::from_column_major_slice(&targets, k, 3 * vertices);
            let moved = product(t.transpose(), weights.as_ref());
            let frames = range.clone();
            look(&Part {
                vertex,
                vertices,
                frames,
                targets: &targets,
                moved,
                given: &given,
                numbers: 3 * count,
            })
        };
        let results: Vec<R> = (0..tasks).into_par_iter().map(look_at).collect();
        let clip = frames.clip(range.start);
        results.into_iter().for_each(|result| add(clip, result));
    }
    Ok(())
}
