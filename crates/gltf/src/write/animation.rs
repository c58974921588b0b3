//! The animation: the targets' weights and the head, a key for each frame.

use super::buffers::{Buffers, Element};
use ::gltf::json::accessor::Accessor;
use ::gltf::json::animation::{Animation as Json, Channel, Interpolation, Property, Sampler, Target};
use ::gltf::json::scene::UnitQuaternion;
use ::gltf::json::validation::Checked::Valid;
use ::gltf::json::{Index, Node};
use rhytid_core::{Result, RigidMotion, UpAxis};

/// An animation. Readers interpolate its keys linearly (and rotations spherically).
pub(super) struct Animation {
    /// Names it in the file.
    pub name: String,
    /// The number of frames, at least 1.
    pub frames: usize,
    /// Frames per second.
    pub rate: f64,
    /// The weights of the targets, unless there are none.
    pub weights: Option<Weights>,
    /// The head pose in each frame.
    pub head: Option<Vec<RigidMotion>>,
}

/// The weights of K targets in each frame.
pub(super) enum Weights {
    /// There is a target for each frame, and it has the weight 1 in its own and 0 in all others.
    OneHot,
    /// Frames × K.
    Each(Vec<f32>),
}

/// The nodes of a file.
pub(super) struct Nodes {
    /// The node that has the mesh.
    pub mesh: Index<Node>,
    /// The one above all others.
    pub root: Index<Node>,
    /// The node that moves like the head, if one was added.
    pub head: Option<Index<Node>>,
    pub nodes: Vec<Node>,
}

impl Animation {
    /// Writes the keys, and adds the node to `nodes` that moves like the head, unless it is there. `mesh` is
    /// the mesh's name. `None` if nothing moves.
    pub(super) fn write(
        self,
        buffers: &mut Buffers,
        nodes: &mut Nodes,
        mesh: &str,
        metres_per_unit: f64,
        up_axis: UpAxis,
    ) -> Result<Option<Json>> {
        if self.weights.is_none() && self.head.is_none() {
            return Ok(None);
        }
        let times: Vec<[f32; 1]> = (0..self.frames).map(|k| [(k as f64 / self.rate) as f32]).collect();
        let input = buffers.numbers(&times, Element::SCALAR)?;
        let bounds = [&times[0], &times[times.len() - 1]].map(|&[time]| Some(vec![f64::from(time)].into()));
        [buffers.accessors[input.value()].min, buffers.accessors[input.value()].max] = bounds;
        let mut json = Json {
            extensions: None,
            extras: None,
            channels: vec![],
            name: Some(self.name),
            samplers: vec![],
        };
        let mut add = |node, path, output| {
            let sampler = Sampler {
                extensions: None,
                extras: None,
                input,
                interpolation: Valid(Interpolation::Linear),
                output,
            };
            let sampler = Index::push(&mut json.samplers, sampler);
            let target = Target { extensions: None, extras: None, node, path: Valid(path) };
            json.channels.push(Channel { sampler, target, extensions: None, extras: None });
        };
        if let Some(weights) = &self.weights {
            let output = match weights {
                Weights::OneHot => buffers.identity(self.frames)?,
                Weights::Each(weights) => buffers.numbers(weights.as_chunks::<1>().0, Element::SCALAR)?,
            };
            add(nodes.mesh, Property::MorphTargetWeights, output);
        }
        if let Some(head) = &self.head {
            let (rotations, translations): (Vec<_>, Vec<_>) = keys(head, metres_per_unit, up_axis).unzip();
            let rotation_keys: Index<Accessor> = buffers.numbers(&rotations, Element::VEC4)?;
            let translation_keys = buffers.numbers(&translations, Element::VEC3)?;
            let node = match nodes.head {
                Some(node) => node,
                None => {
                    let node = head_node(head, mesh, metres_per_unit, up_axis, nodes.root);
                    Index::push(&mut nodes.nodes, node)
                }
            };
            (nodes.root, nodes.head) = (node, Some(node));
            add(node, Property::Rotation, rotation_keys);
            add(node, Property::Translation, translation_keys);
        }
        Ok(Some(json))
    }
}

/// The node above the node `below`, which moves like the head. Where nothing is played, it is as in frame 0.
pub(crate) fn head_node(
    head: &[RigidMotion],
    name: &str,
    metres_per_unit: f64,
    up_axis: UpAxis,
    below: Index<Node>,
) -> Node {
    let (rotation, translation) = keys(head, metres_per_unit, up_axis).next().unzip();
    Node {
        name: Some(format!("{name} head")),
        children: Some(vec![below]),
        rotation: rotation.map(UnitQuaternion),
        translation,
        ..Node::default()
    }
}

/// Turns a vector from the mesh's axes to glTF's.
pub(super) fn y_up<T: Copy + std::ops::Neg<Output = T>>([x, y, z]: [T; 3], up_axis: UpAxis) -> [T; 3] {
    match up_axis {
        UpAxis::Y => [x, y, z],
        UpAxis::Z => [x, z, -y],
    }
}

/// Rotations and translations along glTF's axes, in metres. A quaternion and its negative are the same
/// rotation. Each quaternion has the sign that is nearer to the one before.
fn keys(
    head: &[RigidMotion],
    metres_per_unit: f64,
    up_axis: UpAxis,
) -> impl Iterator<Item = ([f32; 4], [f32; 3])> {
    let mut before = head.first().map_or([0.0; 4], |motion| motion.rotation);
    head.iter().map(move |motion| {
        let dot: f64 = motion.rotation.iter().zip(&before).map(|(a, b)| a * b).sum();
        let sign = if dot < 0.0 { -1.0 } else { 1.0 };
        before = motion.rotation.map(|x| sign * x);
        let [x, y, z, w] = before;
        let [x, y, z] = y_up([x, y, z], up_axis);
        let length = (x * x + y * y + z * z + w * w).sqrt();
        let rotation = [x, y, z, w].map(|x| (x / length) as f32);
        let translation = y_up(motion.translation, up_axis).map(|x| (x * metres_per_unit) as f32);
        (rotation, translation)
    })
}
