//! Few targets, found once all frames are known.

use super::clips::Clips;
use super::document::{Document, Placement};
use super::targets::most_targets;
use crate::attributes::Attribute;
use rhytid_core::{Error, Progress, Result, channel};
use rhytid_export::morphs::{Frames, Settings};
use rhytid_export::{Exporter, Frame, Options, Scene, ShapeSet, Written};

/// The base and the targets are chosen so that they reproduce every frame within a bound (see
/// [`rhytid_export::morphs`]).
pub(super) struct Compressed {
    document: Document,
    clips: Clips,
    frames: Frames,
    attributes: Vec<Attribute>,
    /// The attributes that are the same in all frames, V × 3 numbers of each.
    constants: Vec<(Attribute, Vec<f32>)>,
    goal: Goal,
    most_targets: usize,
    quantize: bool,
}

/// The goal of the choice of targets.
pub(super) enum Goal {
    /// As few as keep every vertex of every frame within so many mesh units.
    Within(f64),
    /// So many targets, with the least deviation from the frames.
    Shapes(usize),
    /// These targets, whose weights alone are free.
    Onto(ShapeSet),
}

impl Compressed {
    pub(super) fn new(
        document: Document,
        scene: &Scene<'_>,
        attributes: Vec<Attribute>,
        options: &Options,
        goal: Goal,
    ) -> Result<Self> {
        let spool = document.buffers.container.spool()?;
        let (constants, attributes): (Vec<_>, Vec<_>) =
            attributes.into_iter().partition(Attribute::is_constant);
        let frames = Frames::new(
            spool,
            document.path(),
            scene.rest.len(),
            scene.rest_normals.is_some(),
            attributes.iter().map(Attribute::counted).collect(),
        )
        .with_clips(scene.clips().iter().map(|clip| clip.frames));
        let constants = constants.into_iter().map(|attribute| (attribute, Vec::new())).collect();
        Ok(Self {
            document,
            clips: Clips::new(scene, options),
            frames,
            attributes,
            constants,
            goal,
            most_targets: most_targets(options),
            quantize: options.quantize,
        })
    }
}

impl Exporter for Compressed {
    fn frame(&mut self, frame: &Frame<'_>) -> Result<()> {
        if self.frames.frames() == 0 {
            self.constants.iter_mut().for_each(|(attribute, numbers)| *numbers = attribute.of_frame(frame));
        }
        let others: Vec<Vec<f32>> =
            self.attributes.iter().map(|attribute| attribute.of_frame(frame)).collect();
        self.frames.push(frame.positions(), frame.get(&channel::NORMALS), &others)
    }

    fn finish(self: Box<Self>, progress: &dyn Progress) -> Result<Written> {
        let Self { mut document, clips, frames, attributes, constants, goal, most_targets, quantize } = *self;
        let morphs = match goal {
            Goal::Within(max_error) => {
                frames.compress(&Settings { max_error, most_targets, quantize }, progress)?
            }
            Goal::Shapes(shapes) => frames.bake(shapes, quantize, progress)?,
            Goal::Onto(set) => frames.onto(&set, progress)?,
        };
        if morphs.targets.is_empty() && clips.are_several() && !clips.has_head() {
            return Err(Error::empty(format!(
                "{}: nothing moves in any of the takes, and glTF has no animation without motion; write one \
                 take",
                document.path().display()
            )));
        }
        document.base(&morphs.base, morphs.base_normals.as_ref())?;
        for (attribute, fitted) in attributes.iter().zip(&morphs.extras) {
            document.base_extra(&attribute.name, fitted.base.clone())?;
        }
        for (attribute, numbers) in constants {
            document.base_extra(&attribute.name, numbers)?;
        }
        for (k, target) in morphs.targets.iter().enumerate() {
            document.target(target.name.clone(), &target.positions, target.normals.as_ref())?;
            for (attribute, fitted) in attributes.iter().zip(&morphs.extras) {
                document.target_extra(&attribute.name, fitted.targets[k].clone())?;
            }
        }
        let first = morphs.weights.get(..morphs.targets.len()).map(<[f32]>::to_vec);
        let clips = clips.fitted(&morphs.weights, morphs.targets.len(), &morphs.clips, &attributes);
        let placement = Placement { scale: morphs.scale, translation: morphs.translation };
        document.finish(placement, first, clips, progress)
    }
}
