//! The clips of a file: an animation for each take, and what the file states of it.
//!
//! A file of one clip states everything in the scene's extras. In a file of several, each animation has the
//! facts of its own frames in its own extras.

use super::animation::{Animation, Nodes, Weights};
use super::buffers::Buffers;
use super::document::raw;
use crate::attributes::Attribute;
use ::gltf::json::animation::Animation as Json;
use rhytid_core::{Result, RigidMotion, UpAxis, channel};
use rhytid_export::morphs::{ClipErrors, Off};
use rhytid_export::{Deviation, Options, Scene};
use serde_json::{Map, Value, json};

/// The clips of a file; none in a file of shapes alone.
#[derive(Default)]
pub(super) struct Clips(Vec<Clip>);

/// A clip.
struct Clip {
    animation: Animation,
    /// What the file states of its frames.
    stated: Map<String, Value>,
    error: Option<Deviation>,
}

impl Clips {
    /// The clips of a scene, with the names that `options` give. Nothing is known of their weights yet.
    pub(super) fn new(scene: &Scene<'_>, options: &Options) -> Self {
        let clips = scene.clips();
        let names = scene.clip_names(options);
        // The head's node is animated in every clip, or it would keep the place that another clip left it in.
        let moves = clips.iter().any(|clip| clip.head.is_some());
        let of_clip = |(name, clip): (String, &rhytid_export::Clip<'_>)| {
            let head = clip.head.map(<[RigidMotion]>::to_vec);
            let head = head.or_else(|| moves.then(|| vec![RigidMotion::IDENTITY; clip.frames]));
            let mut stated = Map::new();
            stated.insert("rhytid".into(), json!(clip.recipe));
            stated.insert("frames".into(), clip.frames.into());
            stated.insert("framesPerSecond".into(), clip.rate.into());
            stated.insert("firstTimeCode".into(), clip.first_time_code.into());
            let animation = Animation { name, frames: clip.frames, rate: clip.rate, weights: None, head };
            Clip { animation, stated, error: None }
        };
        Self(names.into_iter().zip(&clips).map(of_clip).collect())
    }

    /// The only clip, with its weights and its error.
    pub(super) fn of_one(mut self, weights: Weights, error: Deviation) -> Self {
        if let [clip] = &mut self.0[..] {
            clip.animation.weights = Some(weights);
            clip.error = Some(error);
        }
        self
    }

    /// The clips of fitted frames: `weights` has the K weights of the frames of all clips, and `errors` the
    /// errors of each. `attributes` are those that were fitted.
    pub(super) fn fitted(
        mut self,
        weights: &[f32],
        targets: usize,
        errors: &[ClipErrors],
        attributes: &[Attribute],
    ) -> Self {
        let mut rest = weights;
        for (clip, errors) in self.0.iter_mut().zip(errors) {
            let (own, others) = rest.split_at((clip.animation.frames * targets).min(rest.len()));
            rest = others;
            clip.animation.weights = (targets > 0).then(|| Weights::Each(own.to_vec()));
            clip.error = Some(errors.deviation());
            attributes.iter().zip(&errors.extras).for_each(|(attribute, off)| clip.state(attribute, *off));
            if let Some(Off { worst, rms }) = errors.normals {
                clip.stated.insert("normalError".into(), json!({ "worst": worst, "rms": rms }));
            }
        }
        self
    }

    /// Whether there is more than one.
    pub(super) fn are_several(&self) -> bool {
        self.0.len() > 1
    }

    /// Whether any clip says how the head moves.
    pub(super) fn has_head(&self) -> bool {
        self.0.iter().any(|clip| clip.animation.head.is_some())
    }

    /// The deviation of each.
    pub(super) fn errors(&self) -> Vec<Deviation> {
        self.0.iter().filter_map(|clip| clip.error).collect()
    }

    /// Writes the animations, and states what is known of them: of a single clip in the `extras` of the
    /// scene. `mesh` is the mesh's name.
    pub(super) fn write(
        self,
        buffers: &mut Buffers,
        nodes: &mut Nodes,
        extras: &mut Value,
        mesh: &str,
        metres_per_unit: f64,
        up_axis: UpAxis,
    ) -> Result<Vec<Json>> {
        let are_several = self.are_several();
        let mut animations = Vec::with_capacity(self.0.len());
        for Clip { animation, mut stated, error } in self.0 {
            if let Some(error) = error {
                stated.insert("error".into(), of_positions(error, metres_per_unit));
            }
            let animation = animation.write(buffers, nodes, mesh, metres_per_unit, up_axis)?;
            if are_several {
                let stated = raw(&Value::Object(stated))?;
                animations.extend(animation.map(|animation| Json { extras: stated, ..animation }));
            } else {
                stated.into_iter().for_each(|(name, value)| extras[name] = value);
                animations.extend(animation);
            }
        }
        Ok(animations)
    }
}

impl Clip {
    /// States the deviation of an attribute from the numbers that came in.
    fn state(&mut self, attribute: &Attribute, Off { worst, rms }: Off) {
        let stated = json!({ "worst": worst, "rms": rms });
        match attribute.channels.as_slice() {
            [only] if only.name == channel::STRAIN.name => {
                self.stated.insert("strainError".into(), stated);
            }
            _ => {
                let errors = self.stated.entry("attributeErrors").or_insert_with(|| json!({}));
                errors[&attribute.name] = stated;
            }
        }
    }
}

/// The deviation of the positions from those that came in.
pub(super) fn of_positions(error: Deviation, metres_per_unit: f64) -> Value {
    let Deviation { worst, at: (frame, vertex), rms } = error;
    let millimetres = |x: f64| x * metres_per_unit * 1000.0;
    json!({
        "worstMillimetres": millimetres(worst), "rmsMillimetres": millimetres(rms),
        "frame": frame, "vertex": vertex,
    })
}
