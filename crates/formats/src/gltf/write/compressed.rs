//! Few targets, found once all frames are known.

use super::animation::Weights;
use super::document::{Document, Placement};
use super::exact::Timing;
use super::targets::MOST_TARGETS;
use crate::export::{Deviation, Exporter, Frame, Options, Scene, Written};
use crate::gltf::morphs::{Frames, Settings};
use rhytid_core::{Progress, Result};

/// The base and the targets are whatever shows every frame within a bound (see [`crate::gltf::morphs`]).
pub(super) struct Compressed {
    document: Document,
    timing: Timing,
    frames: Frames,
    count: usize,
    settings: Settings,
}

impl Compressed {
    pub(super) fn new(
        document: Document,
        scene: &Scene<'_>,
        options: &Options,
        max_error: f64,
    ) -> Result<Self> {
        let spool = document.buffers.container.spool()?;
        let frames = Frames::new(spool, document.path(), scene.rest.len(), scene.rest_normals.is_some());
        let settings = Settings {
            max_error,
            most_targets: if options.force { usize::MAX } else { MOST_TARGETS },
            quantize: options.quantize,
        };
        Ok(Self { document, timing: Timing::new(scene), frames, count: scene.frames, settings })
    }
}

impl Exporter for Compressed {
    fn frame(&mut self, frame: Frame<'_>) -> Result<()> {
        self.frames.push(frame.positions, frame.normals)
    }

    fn finish(self: Box<Self>, progress: &dyn Progress) -> Result<Written> {
        let Self { mut document, timing, frames, count, settings } = *self;
        let morphs = frames.compress(&settings, progress)?;
        document.base(&morphs.base, morphs.base_normals.as_ref())?;
        for (k, target) in morphs.targets.iter().enumerate() {
            document.target(format!("shape {:02}", k + 1), &target.positions, target.normals.as_ref())?;
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
