//! The contents of the JSON: the place and the meaning of everything.

use super::super::attributes::{self, Accessors, Attribute, Stated};
use super::super::meshopt;
use super::super::node::local_transform;
use ::gltf::json::Root;
use ::gltf::json::animation::{Animation, Interpolation, Property};
use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked::Valid;
use glam::{DMat4, DVec3};
use rhytid_core::channel::{self, Channel, Timing};
use rhytid_core::{Error, InputErrorKind, Result, UpAxis};
use rhytid_export::{Deviation, StatedError, StatedRecipe};
use serde::Deserialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

/// Where the numbers are (as accessors), and what else a file says.
pub(super) struct Layout {
    pub name: String,
    /// The corners of the triangles of each primitive; at least one. All primitives have the same vertices.
    pub indices: Vec<usize>,
    /// The attribute with the vertices' numbers, if there is one.
    pub ids: Option<usize>,
    /// The number of vertices without copies, and for each copy the vertex that it copies. `None` in older
    /// files, where the attribute says it.
    pub originals: Option<Originals>,
    /// Texture coordinates.
    pub uvs: Option<usize>,
    /// What the mesh has besides positions and normals.
    pub attributes: Vec<Attribute>,
    /// Positions, normals and each of the attributes of the base mesh. A file without positions is refused.
    pub base: Vec<Option<usize>>,
    /// The same of each target.
    pub targets: Vec<Vec<Option<usize>>>,
    /// The mesh's node: from the stored positions to metres with Y up.
    pub node: DMat4,
    /// From metres with Y up to mesh units along the mesh's axes.
    pub to_mesh: DMat4,
    /// The keys' times, if anything is animated.
    pub times: Option<usize>,
    pub weights: Option<usize>,
    /// Rotations and translations of the head.
    pub head: Option<[usize; 2]>,
    pub frames: usize,
    pub rate: f64,
    pub first_time_code: f64,
    pub metres_per_unit: f64,
    pub up_axis: UpAxis,
    /// In mesh units.
    pub stated_error: Option<Deviation>,
    pub stated_errors: Vec<StatedError>,
    pub recipe: Option<StatedRecipe>,
    /// The names of the clips, if there are several.
    pub clips: Vec<String>,
}

/// The vertices that are no copies, and those that copies copy.
pub(super) struct Originals {
    pub vertices: usize,
    pub copies: Vec<usize>,
}

/// The scene's extras.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Extras {
    frames: usize,
    frames_per_second: f64,
    first_time_code: f64,
    metres_per_unit: f64,
    up_axis: Axis,
    /// The vertices that are no copies.
    #[serde(default)]
    vertices: Option<usize>,
    /// For each copy the vertex that it copies.
    #[serde(default)]
    copies: Vec<usize>,
    #[serde(default)]
    rhytid: Option<StatedRecipe>,
    #[serde(default)]
    error: Option<StatedWorst>,
    #[serde(default)]
    strain_error: Option<Off>,
    #[serde(default)]
    normal_error: Option<Off>,
    /// Which channels are in which attributes.
    #[serde(default)]
    attributes: BTreeMap<String, Vec<Stated>>,
    #[serde(default)]
    attribute_errors: BTreeMap<String, Off>,
}

/// The part of a clip's extras that says how it was made.
#[derive(Deserialize)]
struct Made {
    #[serde(default)]
    rhytid: Option<StatedRecipe>,
}

/// How far an attribute is from what was exported.
#[derive(Deserialize, Clone, Copy)]
struct Off {
    worst: f64,
    rms: f64,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct StatedWorst {
    worst_millimetres: f64,
    /// What is missing is no number, or beyond every frame.
    #[serde(default = "nan")]
    rms_millimetres: f64,
    #[serde(default = "beyond")]
    frame: usize,
    #[serde(default = "beyond")]
    vertex: usize,
}

fn nan() -> f64 {
    f64::NAN
}

fn beyond() -> usize {
    usize::MAX
}

#[derive(Deserialize)]
enum Axis {
    Y,
    Z,
}

/// Makes errors of a file.
#[derive(Clone, Copy)]
struct Faults<'a> {
    /// What the file is called.
    name: &'a str,
}

impl Faults<'_> {
    /// What is wrong with a file.
    fn of_file(self, what: &str) -> Error {
        Error::malformed(format!("{}: {what}", self.name))
    }

    /// An error for something that files of other programs have or lack.
    fn of_others(self, what: &str) -> Error {
        self.of_file(&format!("{what}; expected a file that Rhytid has written"))
            .of_kind(InputErrorKind::UnsupportedFormat)
    }
}

impl Extras {
    /// Those of a scene with those of its clip, if that is one of several. Their numbers are in their range.
    fn read(scene: &::gltf::json::Scene, clip: Option<&Animation>, faults: Faults<'_>) -> Result<Self> {
        let unread = |e: serde_json::Error| {
            faults.of_others(&format!("has data about its frames that cannot be read ({e})"))
        };
        let extras = scene.extras.as_ref().ok_or(faults.of_others("has no data about its frames"))?;
        let extras: Self = match clip {
            None => serde_json::from_str(extras.get()).map_err(unread)?,
            Some(clip) => {
                let own = clip.extras.as_ref().ok_or(faults.of_others("has a clip without data about it"))?;
                let mut all: Map<String, Value> = serde_json::from_str(extras.get()).map_err(unread)?;
                all.extend(serde_json::from_str::<Map<String, Value>>(own.get()).map_err(unread)?);
                // Text keeps the order of a recipe's fields.
                let Made { rhytid } = serde_json::from_str(own.get()).map_err(unread)?;
                Self { rhytid, ..serde_json::from_value(Value::Object(all)).map_err(unread)? }
            }
        };
        if extras.frames == 0 {
            return Err(faults.of_file("has 0 frames, expected at least 1"));
        }
        for (what, number) in [("rate", extras.frames_per_second), ("unit", extras.metres_per_unit)] {
            if !(number.is_finite() && number > 0.0) {
                let what = format!("has a {what} of {number}, expected a number above 0");
                return Err(faults.of_file(&what));
            }
        }
        if !extras.first_time_code.is_finite() {
            return Err(faults.of_file("has a first time code that is not finite"));
        }
        Ok(extras)
    }
}

/// What the base mesh has.
struct Base {
    /// Of positions, normals and each of the attributes.
    accessors: Vec<Option<usize>>,
    /// What it has besides positions and normals.
    attributes: Vec<Attribute>,
}

impl Base {
    /// `stated` is what the file says of its attributes' channels.
    fn read(primitive: &Primitive, stated: &BTreeMap<String, Vec<Stated>>) -> Self {
        let mut accessors =
            vec![accessor(primitive, Semantic::Positions), accessor(primitive, Semantic::Normals)];
        let mut attributes: Vec<Attribute> = Vec::new();
        for (semantic, accessor) in &primitive.attributes {
            let Valid(Semantic::Extras(name)) = semantic else { continue };
            let name = format!("_{name}");
            let Some(found) = Attribute::of_file(&name, stated.get(&name)) else { continue };
            // A channel is in one place.
            let of_others = attributes.iter().flat_map(|other| &other.channels);
            let others: Vec<&Channel> =
                [&channel::POSITIONS, &channel::NORMALS].into_iter().chain(of_others).collect();
            let is_known = |(i, new): (usize, &Channel)| {
                others.iter().copied().chain(&found.channels[..i]).any(|other| other.name == new.name)
            };
            if !found.channels.iter().enumerate().any(is_known) {
                attributes.push(found);
                accessors.push(Some(accessor.value()));
            }
        }
        Self { accessors, attributes }
    }
}

impl Layout {
    /// `clip` is the number of the clip, counted from 0.
    pub(super) fn read(root: &Root, targets: &[Vec<Accessors>], name: &str, clip: usize) -> Result<Self> {
        let faults = Faults { name };
        let ours = |what: &str| faults.of_others(what);
        refuse_unknown_extensions(root, faults)?;
        let scene =
            root.scenes.get(root.scene.map_or(0, |scene| scene.value())).ok_or(ours("has no scene"))?;
        let clips = clips(root);
        let animation = root.animations.get(clip);
        let extras = Extras::read(scene, animation.filter(|_| !clips.is_empty()), faults)?;

        let (head, mesh_node) =
            nodes(root, scene).ok_or(ours("has other nodes than a head and a mesh on it"))?;
        let node = root.nodes.get(mesh_node).ok_or(ours("has no node with a mesh"))?;
        let mesh_index = node.mesh.ok_or(ours("has no mesh"))?.value();
        let mesh = root.meshes.get(mesh_index).ok_or(ours("has no mesh"))?;
        let primitive = mesh.primitives.first().ok_or(ours("has a mesh without a primitive"))?;
        let indices = indices(mesh).ok_or(ours(
            "has primitives that are no triangles, or that differ in their vertices or morph targets",
        ))?;
        let Base { accessors: base, mut attributes } = Base::read(primitive, &extras.attributes);
        let ids = accessor(primitive, Semantic::Extras(attributes::VERTEX_ID.into()));
        if base[0].is_none() || (ids.is_none() && extras.vertices.is_none()) {
            return Err(ours("does not say where its vertices are, and which of them are copies"));
        }
        let targets =
            self::targets(primitive, targets.get(mesh_index).map_or(&[], Vec::as_slice), &attributes);
        hold_what_no_target_has(&mut attributes, &targets);
        if let Some(odd) = odd_target(&targets, &base, &attributes) {
            return Err(ours(&format!("has a target {odd} (from 0) with other attributes than the mesh")));
        }

        let up_axis = match extras.up_axis {
            Axis::Y => UpAxis::Y,
            Axis::Z => UpAxis::Z,
        };
        let mut layout = Self {
            name: mesh.name.clone().unwrap_or_default(),
            indices,
            ids,
            originals: extras.vertices.map(|vertices| Originals { vertices, copies: extras.copies.clone() }),
            uvs: accessor(primitive, Semantic::TexCoords(0)),
            stated_errors: stated_errors(&attributes, &extras),
            attributes,
            base,
            targets,
            node: local_transform(node),
            to_mesh: to_mesh(extras.metres_per_unit, up_axis),
            times: None,
            weights: None,
            head: None,
            frames: extras.frames,
            rate: extras.frames_per_second,
            first_time_code: extras.first_time_code,
            metres_per_unit: extras.metres_per_unit,
            up_axis,
            stated_error: extras.error.map(|e| Deviation {
                worst: e.worst_millimetres / 1000.0 / extras.metres_per_unit,
                at: (e.frame, e.vertex),
                rms: e.rms_millimetres / 1000.0 / extras.metres_per_unit,
            }),
            recipe: extras.rhytid,
            clips,
        };
        layout
            .find_channels(animation, mesh_node, head)
            .ok_or(ours("animates something other than a face"))?;
        if !(layout.to_mesh * layout.node).is_finite() {
            return Err(faults.of_file("has a node whose numbers are not finite; the file is damaged"));
        }
        if layout.weights.is_some() == layout.targets.is_empty() || layout.head.is_some() != head.is_some() {
            return Err(ours("has morph targets or a head without animation, or animation without them"));
        }
        Ok(layout)
    }

    /// Finds what is animated, on the nodes `mesh` and `head`; `None` if there is anything else.
    fn find_channels(
        &mut self,
        animation: Option<&Animation>,
        mesh: usize,
        head: Option<usize>,
    ) -> Option<()> {
        let [mut rotations, mut translations] = [None, None];
        if let Some(animation) = animation {
            for channel in &animation.channels {
                let sampler = animation.samplers.get(channel.sampler.value())?;
                let input = sampler.input.value();
                if *self.times.get_or_insert(input) != input
                    || sampler.interpolation != Valid(Interpolation::Linear)
                {
                    return None;
                }
                let node = channel.target.node.value();
                let place = match channel.target.path {
                    Valid(Property::MorphTargetWeights) if node == mesh => &mut self.weights,
                    Valid(Property::Rotation) if Some(node) == head => &mut rotations,
                    Valid(Property::Translation) if Some(node) == head => &mut translations,
                    _ => return None,
                };
                if place.replace(sampler.output.value()).is_some() {
                    return None;
                }
            }
        }
        self.head = match (rotations, translations) {
            (Some(rotations), Some(translations)) => Some([rotations, translations]),
            (None, None) => None,
            _ => return None,
        };
        Some(())
    }
}

/// The names of a file's clips; none if it has no more than one.
pub(super) fn clips(root: &Root) -> Vec<String> {
    let names = root.animations.iter().map(|animation| animation.name.clone().unwrap_or_default());
    if root.animations.len() > 1 { names.collect() } else { Vec::new() }
}

fn refuse_unknown_extensions(root: &Root, faults: Faults<'_>) -> Result<()> {
    let known = ["KHR_mesh_quantization", meshopt::EXTENSION];
    match root.extensions_required.iter().find(|name| !known.contains(&name.as_str())) {
        Some(unknown) => Err(faults
            .of_file(&format!("requires the extension {unknown}, which Rhytid never writes"))
            .of_kind(InputErrorKind::UnsupportedFormat)),
        None => Ok(()),
    }
}

/// The accessors of the corners of each primitive; `None` if they are no triangles, or do not share their
/// vertices and targets.
fn indices(mesh: &::gltf::json::Mesh) -> Option<Vec<usize>> {
    let first = mesh.primitives.first()?;
    let of_targets = |primitive: &Primitive| -> Vec<[Option<usize>; 2]> {
        let value = |index: &Option<::gltf::json::Index<_>>| index.map(|index| index.value());
        let targets = primitive.targets.iter().flatten();
        targets.map(|target| [value(&target.positions), value(&target.normals)]).collect()
    };
    let mut indices = Vec::with_capacity(mesh.primitives.len());
    for primitive in &mesh.primitives {
        let shares = primitive.attributes.len() == first.attributes.len()
            && primitive.attributes.iter().all(|(semantic, accessor)| {
                first.attributes.get(semantic).is_some_and(|first| first.value() == accessor.value())
            })
            && of_targets(primitive) == of_targets(first);
        if !shares || primitive.mode != Valid(Mode::Triangles) {
            return None;
        }
        indices.push(primitive.indices?.value());
    }
    Some(indices)
}

fn accessor(primitive: &Primitive, semantic: Semantic) -> Option<usize> {
    primitive.attributes.get(&Valid(semantic)).map(::gltf::json::Index::value)
}

/// An attribute that no target has is the same in all frames.
fn hold_what_no_target_has(attributes: &mut [Attribute], targets: &[Vec<Option<usize>>]) {
    for (i, attribute) in attributes.iter_mut().enumerate() {
        if !targets.is_empty() && targets.iter().all(|target| target[2 + i].is_none()) {
            attribute.channels.iter_mut().for_each(|channel| channel.timing = Timing::Constant);
        }
    }
}

/// The first target that has other attributes than those of the mesh that change.
fn odd_target(
    targets: &[Vec<Option<usize>>],
    base: &[Option<usize>],
    attributes: &[Attribute],
) -> Option<usize> {
    let is_expected =
        |(i, base): (usize, &Option<usize>)| base.is_some() && (i < 2 || !attributes[i - 2].is_constant());
    let expected: Vec<bool> = base.iter().enumerate().map(is_expected).collect();
    let same = |target: &Vec<Option<usize>>| target.iter().map(Option::is_some).eq(expected.iter().copied());
    targets.iter().position(|target| !same(target))
}

/// The head's node, if there is one, and the mesh's; `None` if there are others.
fn nodes(root: &Root, scene: &::gltf::json::Scene) -> Option<(Option<usize>, usize)> {
    let [top] = &scene.nodes[..] else { return None };
    let node = root.nodes.get(top.value())?;
    match (node.children.as_deref(), node.mesh) {
        (None, Some(_)) => Some((None, top.value())),
        (Some([child]), None) => {
            let child_node = root.nodes.get(child.value())?;
            child_node.children.is_none().then_some((Some(top.value()), child.value()))
        }
        _ => None,
    }
}

/// Positions, normals and each of the attributes of each target.
fn targets(primitive: &Primitive, others: &[Accessors], attributes: &[Attribute]) -> Vec<Vec<Option<usize>>> {
    let value = |index: &Option<::gltf::json::Index<_>>| index.map(|index| index.value());
    let of_target = |(i, target): (usize, &::gltf::json::mesh::MorphTarget)| {
        let other = |attribute: &Attribute| others.get(i)?.get(&attribute.name).copied();
        let known = [value(&target.positions), value(&target.normals)];
        known.into_iter().chain(attributes.iter().map(other)).collect()
    };
    primitive.targets.iter().flatten().enumerate().map(of_target).collect()
}

/// What is stated of attributes, of each of their channels.
fn stated_errors(attributes: &[Attribute], extras: &Extras) -> Vec<StatedError> {
    let (of_strain, of_others) = (extras.strain_error, &extras.attribute_errors);
    let of_channel = |channel: &Channel, Off { worst, rms }: Off| StatedError {
        channel: channel.name.clone().into_owned(),
        worst,
        rms,
    };
    let normals = extras.normal_error.map(|off| of_channel(&channel::NORMALS, off));
    let strain = of_strain.map(|off| of_channel(&channel::STRAIN, off));
    let others =
        attributes.iter().filter_map(|attribute| Some((attribute, *of_others.get(&attribute.name)?)));
    let others = others
        .flat_map(|(attribute, off)| attribute.channels.iter().map(move |channel| of_channel(channel, off)));
    normals.into_iter().chain(strain).chain(others).collect()
}

fn to_mesh(metres_per_unit: f64, up_axis: UpAxis) -> DMat4 {
    let turn = match up_axis {
        UpAxis::Y => DMat4::IDENTITY,
        UpAxis::Z => DMat4::from_rotation_x(FRAC_PI_2),
    };
    turn * DMat4::from_scale(DVec3::splat(metres_per_unit.recip()))
}
