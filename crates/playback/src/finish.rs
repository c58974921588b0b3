//! What is done to a frame once it was evaluated, in order: folds, triangles that are turned over, how far edits of markers reach, corrections.

use crate::bounds::Bounds;
use crate::correction::Correction;
use crate::fade::Fade;
use crate::untangle::Untangle;
use rhytid_core::Rig;
use rhytid_kernels::normals::VertexTriangles;
use std::ops::Range;

/// What there is to do, beside turning triangles back.
#[derive(Default)]
pub(crate) struct OnTop<'f, 'r> {
    pub fade: Option<&'f mut Fade<'r>>,
    pub corrections: &'f [Correction],
    /// Of each frame, in seconds; empty without corrections.
    pub times: &'f [f64],
    /// Where edits of markers are bounded, and frames × H × 3 positions without them.
    pub bounds: Option<(&'f Bounds, &'f [f32])>,
}

/// A frame as a device gave it.
#[derive(Clone, Copy)]
pub(crate) struct Given<'b> {
    /// 3V positions, and normals; empty where they are not wanted.
    shown: [&'b [f32]; 2],
    /// 3V positions of the large scale, where it may fade.
    large_scale: Option<&'b [f32]>,
    /// 3H positions of its handles.
    pose: &'b [f32],
}

impl<'b> Given<'b> {
    /// From the part `of` of each stage: positions, normals if there are any, and the large scale if the frame fades.
    pub(crate) fn new(
        results: &'b [Vec<f32>],
        of: Range<usize>,
        (normals, fades): (bool, bool),
        pose: &'b [f32],
    ) -> Self {
        let stage = |stage: usize| &results[stage][of.clone()];
        let shown = [stage(0), if normals { stage(1) } else { &[] }];
        Self { shown, large_scale: fades.then(|| stage(results.len() - 1)), pose }
    }
}

/// V positions and normals.
type Shape = [Vec<[f32; 3]>; 2];

/// Finishes frames, one after the other.
pub(crate) struct Finish<'f, 'r, 'u> {
    rig: &'f Rig,
    triangles: &'f VertexTriangles,
    on_top: OnTop<'f, 'r>,
    untangle: Option<&'f mut Untangle<'u>>,
    /// The farthest that each correction moved a vertex in each frame so far, in mesh units.
    pub corrected: Vec<Vec<f64>>,
    with: Shape,
    without: Shape,
}

impl<'f, 'r, 'u> Finish<'f, 'r, 'u> {
    pub(crate) fn new(
        (rig, triangles): (&'f Rig, &'f VertexTriangles),
        on_top: OnTop<'f, 'r>,
        untangle: Option<&'f mut Untangle<'u>>,
    ) -> Self {
        let corrected = vec![Vec::new(); on_top.corrections.len()];
        Self { rig, triangles, on_top, untangle, corrected, with: <_>::default(), without: <_>::default() }
    }

    /// 3V positions and normals of the frame with this number, from those that were given, with edits of markers and, where these are bounded and move any, `without`.
    /// What nothing is done to keeps every bit.
    pub(crate) fn frame<'s>(
        &'s mut self,
        number: usize,
        given: Given<'s>,
        without: Option<Given<'_>>,
    ) -> [&'s [f32]; 2] {
        let Self { rig, triangles, on_top, untangle, .. } = self;
        if on_top.corrections.is_empty() && without.is_none() {
            return turned_back(on_top, untangle, number, given);
        }
        let bounds = without.zip(on_top.bounds).map(|(without, (bounds, _))| {
            copy(turned_back(on_top, untangle, number, without), &mut self.without);
            bounds
        });
        copy(turned_back(on_top, untangle, number, given), &mut self.with);
        let [x, n] = &mut self.with;
        if let Some(bounds) = bounds {
            bounds.blend(&self.without[0], x);
            bounds.blend_normals(rig, triangles, x, &self.without[1], n);
        }
        for (correction, moved) in on_top.corrections.iter().zip(&mut self.corrected) {
            let pose = (on_top.times[number], given.pose.as_chunks().0);
            moved.push(correction.apply(rig, triangles, pose, x, n));
        }
        [x.as_flattened(), n.as_flattened()]
    }
}

/// A frame with its folds as they are wanted, and no triangle turned over.
fn turned_back<'s>(
    on_top: &'s mut OnTop<'_, '_>,
    untangle: &'s mut Option<&mut Untangle<'_>>,
    number: usize,
    Given { shown, large_scale, pose }: Given<'s>,
) -> [&'s [f32]; 2] {
    let shown = match on_top.fade.as_deref_mut().zip(large_scale) {
        Some((fade, large_scale)) => fade.frame(number, large_scale, shown),
        None => shown,
    };
    match untangle {
        Some(untangle) => untangle.frame(pose, shown),
        None => shown,
    }
}

fn copy([positions, normals]: [&[f32]; 2], into: &mut Shape) {
    for (from, into) in [positions, normals].into_iter().zip(into) {
        into.clear();
        into.extend_from_slice(from.as_chunks().0);
    }
}
