//! Channels in glTF: application-specific attributes on the mesh and on its targets. The crate `gltf` knows
//! such attributes on meshes alone.
//!
//! Each attribute is a VEC3. Blender's importer takes the attributes in the random order of a set, and fails
//! on two of different width if that order is not the file's. Viewers morph three numbers like colours. So
//! channels of one number are packed three to an attribute, and the scene's extras say where each channel is.

use rhytid_core::ChannelKind;
use rhytid_core::channel::{self, Channel, Interpolation, Quantity, Timing};
use rhytid_export::Frame;
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// The two strains, and the strain of the area, (1 + e₁)(1 + e₂) − 1.
const STRAIN: &str = "_STRAIN";

/// The directions of the first strains.
const DIRECTION: &str = "_STRAIN_DIRECTION";

/// Each vertex's number in the neutral, without the `_` in front. The number is the first of three.
pub(super) const VERTEX_ID: &str = "VERTEX_ID";

/// Whether glTF has a place for these channels.
pub fn carries(kind: ChannelKind) -> bool {
    !matches!(kind, ChannelKind::Velocities | ChannelKind::Sigma)
}

/// Channels that stand in an attribute one after the other, three numbers at most.
#[derive(Debug, Clone, PartialEq)]
pub struct Attribute {
    /// The name, with `_` in front.
    pub name: String,
    /// The channels whose numbers stand in this attribute, one after the other.
    pub channels: Vec<Channel>,
}

impl Attribute {
    /// The attributes that frames with these channels have, in their order. Channels without a place in glTF
    /// are left out; `rhytid_formats::animation::Format::carries` is asked before.
    pub fn of_channels<'c>(channels: impl IntoIterator<Item = &'c Channel>) -> Vec<Self> {
        let mut attributes: Vec<Self> = Vec::new();
        let has_place = |channel: &&Channel| {
            // Normals have a standard attribute. The second direction is at right angles to the first.
            let others = [&channel::POSITIONS, &channel::NORMALS, &channel::STRAIN_DIRECTION_2];
            others.iter().all(|other| other.name != channel.name)
                && channel.kind.is_none_or(carries)
                && channel.interpolation == Interpolation::Vertex
        };
        for channel in channels.into_iter().filter(has_place) {
            let named = |name: &str| Self { name: name.to_owned(), channels: vec![channel.clone()] };
            if channel.name == channel::STRAIN.name {
                attributes.push(named(STRAIN));
            } else if channel.name == channel::STRAIN_DIRECTION_1.name {
                attributes.push(named(DIRECTION));
            } else if let Some(last) = attributes.iter_mut().last().filter(|last| last.has_room_for(channel))
            {
                last.channels.push(channel.clone());
            } else {
                let what = channel.kind.map_or(&*channel.name, |kind| kind.name()).to_uppercase();
                let begin = format!("_{what}_");
                let before = attributes.iter().filter(|other| other.name.starts_with(&begin)).count();
                attributes.push(named(&format!("{begin}{before}")));
            }
        }
        attributes
    }

    /// The attribute that a file's mesh has under this name. `packed` are the channel names that the scene's
    /// extras state for it. `None` if the attribute is not one of Rhytid's.
    pub(super) fn of_file(name: &str, packed: Option<&Vec<Stated>>) -> Option<Self> {
        let channels = match (name, packed) {
            (STRAIN, _) => vec![channel::STRAIN.clone()],
            (DIRECTION, _) => vec![channel::STRAIN_DIRECTION_1.clone()],
            (_, stated) => {
                let stated = stated?.iter().filter(|stated| (1..=3).contains(&stated.width));
                stated.map(|stated| Channel::of_file(&stated.name, stated.width)).collect::<Vec<_>>()
            }
        };
        let attribute = Self { name: name.to_owned(), channels };
        (1..=3).contains(&attribute.width()).then_some(attribute)
    }

    fn width(&self) -> usize {
        self.channels.iter().map(|channel| channel.width).sum()
    }

    fn has_room_for(&self, channel: &Channel) -> bool {
        let is_alike = |last: &Channel| {
            last.kind.is_some() && last.kind == channel.kind && last.timing == channel.timing
        };
        ![STRAIN, DIRECTION].contains(&&*self.name)
            && self.channels.last().is_some_and(is_alike)
            && self.width() + channel.width <= 3
    }

    /// Whether the mesh has the attribute and its targets do not.
    pub(super) fn is_constant(&self) -> bool {
        self.channels.iter().all(|channel| channel.timing == Timing::Constant)
    }

    /// Whether the attribute can be a weighted sum of those of a few shapes. Directions cannot.
    pub fn can_be_fitted(&self) -> bool {
        self.channels.iter().all(|channel| channel.quantity != Quantity::Direction)
    }

    /// How many of its three numbers belong to a channel.
    pub(super) fn counted(&self) -> usize {
        self.width().min(3)
    }

    /// V × 3 numbers of a frame; empty if the frame has none of the channels.
    pub(super) fn of_frame(&self, frame: &Frame<'_>) -> Vec<f32> {
        if let (STRAIN, Some(strains)) = (&*self.name, frame.get(&channel::STRAIN)) {
            let three = |&[first, second]: &[f32; 2]| [first, second, (1.0 + first) * (1.0 + second) - 1.0];
            return strains.as_chunks().0.iter().flat_map(three).collect();
        }
        let mut numbers = Vec::new();
        let mut begin = 0;
        for channel in &self.channels {
            let Some(values) = frame.get(channel) else { continue };
            let values = values.chunks_exact(channel.width);
            numbers.resize(3 * values.len(), 0.0);
            for (three, value) in numbers.chunks_exact_mut(3).zip(values) {
                three[begin..begin + channel.width].copy_from_slice(value);
            }
            begin += channel.width;
        }
        numbers
    }

    /// A channel's numbers of V × 3.
    pub(super) fn channel(&self, channel: &Channel, numbers: &[f32]) -> Vec<f32> {
        let before = self.channels.iter().take_while(|other| other.name != channel.name);
        let begin: usize = before.map(|other| other.width).sum();
        numbers
            .chunks_exact(3)
            .flat_map(|three| three[begin..begin + channel.width].iter().copied())
            .collect()
    }

    /// What the scene's extras state of the attributes, if anything. Attributes whose names say everything
    /// need no entry.
    pub(super) fn stated(attributes: &[Self]) -> Option<Value> {
        let others = attributes.iter().filter(|attribute| ![STRAIN, DIRECTION].contains(&&*attribute.name));
        let stated = |channel: &Channel| serde_json::json!({ "name": channel.name, "width": channel.width });
        let entry =
            |attribute: &Self| (attribute.name.clone(), attribute.channels.iter().map(stated).collect());
        let stated: serde_json::Map<String, Value> = others.map(entry).collect();
        (!stated.is_empty()).then_some(Value::Object(stated))
    }
}

/// A channel in the scene's extras.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Stated {
    name: String,
    width: usize,
}

/// The further attributes of targets: an accessor by the name of its attribute.
pub(super) type Extras = Vec<(String, u32)>;

/// Adds accessors to the targets of each primitive of the only mesh of a document.
pub(super) fn add_to_targets(document: &mut Value, extras: &[Extras]) {
    let primitives = document.pointer_mut("/meshes/0/primitives").and_then(Value::as_array_mut);
    for primitive in primitives.into_iter().flatten() {
        let targets = primitive.get_mut("targets").and_then(Value::as_array_mut);
        for (target, extras) in targets.into_iter().flatten().zip(extras) {
            for (name, accessor) in extras {
                target[name] = (*accessor).into();
            }
        }
    }
}

#[derive(Deserialize)]
struct Document {
    #[serde(default)]
    meshes: Vec<Mesh>,
}

#[derive(Deserialize)]
struct Mesh {
    #[serde(default)]
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    #[serde(default)]
    targets: Vec<Accessors>,
}

/// The accessors of a target by the names of its attributes.
pub(super) type Accessors = BTreeMap<String, usize>;

/// The accessors of each target, for each mesh of a document; of its first primitive.
pub(super) fn of_targets(json: &[u8]) -> Vec<Vec<Accessors>> {
    let document: Document = serde_json::from_slice(json).unwrap_or(Document { meshes: Vec::new() });
    let of_mesh =
        |mesh: Mesh| mesh.primitives.into_iter().take(1).flat_map(|primitive| primitive.targets).collect();
    document.meshes.into_iter().map(of_mesh).collect()
}
