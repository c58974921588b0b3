//! What is done to a frame once it was evaluated, in order: edits of markers, folds, triangles that are turned over, corrections.

use crate::bounds::Bounds;
use crate::correction::Correction;
use crate::fade::Fade;
use crate::local_normals;
use crate::reached::{Local, Reached};
use crate::untangle::Untangle;
use rhytid_core::Rig;
use rhytid_kernels::normals::VertexTriangles;

/// What there is to do, beside turning triangles back.
#[derive(Clone, Copy, Default)]
pub(crate) struct OnTop<'f, 'r> {
    pub fade: Option<&'f Fade<'r>>,
    pub reached: Option<&'f Reached>,
    pub corrections: &'f [Correction],
    /// Of each frame, in seconds; empty without corrections.
    pub times: &'f [f64],
}

/// A frame as a device gave it, without the edits of markers that are bounded; it is finished in place.
pub(crate) struct Given<'b> {
    /// V.
    pub positions: &'b mut [[f32; 3]],
    /// V; empty where they are not wanted.
    pub normals: &'b mut [[f32; 3]],
    /// V positions of the large scale, where the frame may fade all over the face.
    pub large_scale: Option<&'b [[f32; 3]]>,
    /// H positions without the edits of markers that are bounded, and with all edits.
    pub poses: [&'b [[f32; 3]]; 2],
}

/// Finishes frames, one after the other.
pub(crate) struct Finish<'f, 'r> {
    rig: &'f Rig,
    triangles: &'f VertexTriangles,
    on_top: OnTop<'f, 'r>,
    untangle: Option<&'f Untangle<'f>>,
    /// The farthest that each correction moved a vertex in each frame so far, in mesh units.
    pub corrected: Vec<Vec<f64>>,
    /// The triangles at what edits of markers hold, as [`Untangle::at`] gives them.
    held_triangles: Vec<u32>,
    /// V: whose normals change where edits of markers do something.
    is_beside: Vec<bool>,
    /// V positions of the large scale, of which those count that edits reach.
    large_scale: Vec<[f32; 3]>,
    /// V positions with the edits of markers, and of their large scale.
    edited: [Vec<[f32; 3]>; 2],
}

impl<'f, 'r> Finish<'f, 'r> {
    pub(crate) fn new(
        (rig, triangles): (&'f Rig, &'f VertexTriangles),
        on_top: OnTop<'f, 'r>,
        untangle: Option<&'f Untangle<'f>>,
    ) -> Self {
        let bounds = on_top.reached.and_then(Reached::bounds);
        let beside = |bounds: &Bounds| local_normals::beside(rig, triangles, bounds.held());
        let held = |untangle: &Untangle<'_>| bounds.map(|bounds| untangle.at(bounds.held()));
        Self {
            held_triangles: untangle.and_then(held).unwrap_or_default(),
            is_beside: bounds.map(beside).unwrap_or_default(),
            rig,
            triangles,
            on_top,
            untangle,
            corrected: vec![Vec::new(); on_top.corrections.len()],
            large_scale: Vec::new(),
            edited: <_>::default(),
        }
    }

    /// Finishes the frame with this number. What nothing is done to keeps every bit.
    pub(crate) fn frame(&mut self, number: usize, given: Given<'_>, local: Option<Local<'_>>) {
        let Given { positions, normals, large_scale, poses: [unedited, edited] } = given;
        let (rig, triangles, on_top, untangle) = (self.rig, self.triangles, self.on_top, self.untangle);
        let vertices = on_top.reached.map_or(&[][..], Reached::vertices);
        let mut large_scale: &[[f32; 3]] = large_scale.unwrap_or_default();
        if let (Some(found), true) = (local.and_then(|local| local.large_scale), large_scale.is_empty()) {
            self.large_scale.resize(rig.vertices(), [0.0; 3]);
            vertices.iter().zip(found).for_each(|(&v, x)| self.large_scale[v as usize] = *x);
            large_scale = &self.large_scale;
        }
        let fade = |large_scale: &[[f32; 3]], x: &mut [[f32; 3]], n: &mut [[f32; 3]]| {
            if let Some(fade) = on_top.fade {
                fade.frame(number, large_scale, x, n);
            }
        };
        let untangle_all = |pose: &[[f32; 3]], x: &mut [[f32; 3]], n: &mut [[f32; 3]]| {
            if let Some(untangle) = untangle {
                untangle.frame(pose, x, n);
            }
        };
        let bounds = on_top.reached.and_then(Reached::bounds);
        match bounds.zip(local.and_then(|local| local.edited)) {
            None => {
                fade(large_scale, positions, normals);
                untangle_all(edited, positions, normals);
            }
            Some((bounds, with)) => {
                // Both as a whole, since what is turned back goes by all that is around it.
                let without = [&*positions, large_scale];
                for ((blended, without), with) in self.edited.iter_mut().zip(without).zip(with) {
                    blended.clear();
                    blended.extend_from_slice(without);
                    if !without.is_empty() {
                        for (&v, x) in vertices.iter().zip(with) {
                            blended[v as usize] = bounds.between(v as usize, without[v as usize], *x);
                        }
                    }
                }
                let [blended, blended_large_scale] = &mut self.edited;
                fade(blended_large_scale, blended, &mut []);
                if let Some(untangle) = untangle {
                    untangle.frame_at(&self.held_triangles, edited, blended, &mut []);
                }
                fade(large_scale, positions, normals);
                untangle_all(unedited, positions, normals);
                bounds.held().for_each(|v| positions[v as usize] = blended[v as usize]);
                local_normals::update_where(&self.is_beside, rig, triangles, positions, normals);
            }
        }
        for (correction, moved) in on_top.corrections.iter().zip(&mut self.corrected) {
            moved.push(correction.apply(rig, triangles, (on_top.times[number], edited), positions, normals));
        }
    }
}
