//! Few targets, found once all frames are known.

use super::animation::Weights;
use super::document::{Document, Placement};
use super::exact::Timing;
use super::targets::MOST_TARGETS;
use crate::export::{Deviation, Exporter, Frame, Options, Scene, Written};
use crate::gltf::morphs::{Frames, Settings};
use crate::gltf::strain;
use rhytid_core::{Progress, Result};

/// The base and the targets are whatever shows every frame within a bound (see [`crate::gltf::morphs`]).
pub(super) struct Compressed {
    document: Document,
    timing: Timing,
    frames: Frames,
    count: usize,
    goal: Goal,
    most_targets: usize,
    quantize: bool,
}

/// What the targets are chosen by.
#[derive(Clone, Copy)]
pub(super) enum Goal {
    /// As few as keep every vertex of every frame within so many mesh units.
    Within(f64),
    /// So many, as near to the frames as they come.
    Shapes(usize),
}

impl Compressed {
    pub(super) fn new(document: Document, scene: &Scene<'_>, options: &Options, goal: Goal) -> Result<Self> {
        let spool = document.buffers.container.spool()?;
        let frames = Frames::new(
            spool,
            document.path(),
            scene.rest.len(),
            [scene.rest_normals.is_some(), scene.strain],
        );
        Ok(Self {
            document,
            timing: Timing::new(scene),
            frames,
            count: scene.frames,
            goal,
            most_targets: if options.force { usize::MAX } else { MOST_TARGETS },
            quantize: options.quantize,
        })
    }
}

impl Exporter for Compressed {
    fn frame(&mut self, frame: Frame<'_>) -> Result<()> {
        let strain = frame.strain.map(strain::attribute);
        self.frames.push(frame.positions, frame.normals, strain.as_deref())
    }

    fn finish(self: Box<Self>, progress: &dyn Progress) -> Result<Written> {
        let Self { mut document, timing, frames, count, goal, most_targets, quantize } = *self;
        let morphs = match goal {
            Goal::Within(max_error) => {
                frames.compress(&Settings { max_error, most_targets, quantize }, progress)?
            }
            Goal::Shapes(shapes) => frames.bake(shapes, quantize, progress)?,
        };
        document.base(&morphs.base, morphs.base_normals.as_ref())?;
        let (strain_base, strain_targets) = match &morphs.strain {
            Some(strain) => (Some(&strain.base), &strain.targets[..]),
            None => (None, &[][..]),
        };
        strain_base.map_or(Ok(()), |base| document.base_extra(strain::STRAIN, base.clone()))?;
        for (k, target) in morphs.targets.iter().enumerate() {
            document.target(format!("shape {:02}", k + 1), &target.positions, target.normals.as_ref())?;
            strain_targets.get(k).map_or(Ok(()), |of| document.target_extra(strain::STRAIN, of.clone()))?;
        }
        if let Some(strain) = &morphs.strain {
            document.state_strain_error(strain.worst, strain.rms);
        }
        let first = morphs.weights.get(..morphs.targets.len()).map(<[f32]>::to_vec);
        let weights = (!morphs.targets.is_empty()).then_some(Weights::Each(morphs.weights));
        let placement = Placement { scale: morphs.scale, translation: morphs.translation };
        let error = Deviation {
            worst: morphs.worst.error,
            at: (morphs.worst.frame, morphs.worst.vertex),
            rms: morphs.rms,
        };
        document.finish(placement, first, Some(timing.animation(count, weights)), Some(error), progress)
    }
}
