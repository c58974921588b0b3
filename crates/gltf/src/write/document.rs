//! The JSON: one mesh on one node, and its animation.

use super::super::attributes::{self, Attribute, Extras};
use super::super::meshopt;
use super::animation::{Nodes, y_up};
use super::buffers::{Buffers, Element};
use super::clips::{Clips, of_positions};
use super::container::{Container, Kind, Limit};
use super::materials::Looks;
use super::surface::Surface;
use ::gltf::json::accessor::{Accessor, ComponentType};
use ::gltf::json::mesh::{Mesh, Mode, MorphTarget, Primitive, Semantic};
use ::gltf::json::scene::UnitQuaternion;
use ::gltf::json::validation::Checked::Valid;
use ::gltf::json::{Asset, Index, Node, Root, extras};
use rhytid_core::{Error, Progress, Result, UpAxis, human};
use rhytid_export::morphs::Values;
use rhytid_export::{Deviation, Options, Scene, StatedRecipe, TextureFiles, Written};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::f32::consts::FRAC_1_SQRT_2;
use std::path::Path;

/// The extension that lets positions and normals be integers.
const QUANTIZATION: &str = "KHR_mesh_quantization";

/// The memory of morph targets on a GPU from which on the user is warned, in bytes.
const MUCH_MEMORY: u64 = 2_000_000_000;

/// The largest number of vertices whose indices a 32-bit float tells apart. (glTF allows no 32-bit integers
/// in attributes.)
const MOST_VERTICES: usize = 1 << 24;

/// What a file states in addition to its numbers.
pub(crate) struct About {
    /// Names the nodes and the mesh.
    name: String,
    metres_per_unit: f64,
    up_axis: UpAxis,
    /// The scene's extras so far.
    extras: Value,
}

impl About {
    /// The facts that every scene has.
    pub(crate) fn new(scene: &Scene<'_>) -> Self {
        Self {
            name: scene.name.to_owned(),
            metres_per_unit: scene.metres_per_unit,
            up_axis: scene.up_axis,
            extras: json!({
                "metresPerUnit": scene.metres_per_unit,
                "upAxis": match scene.up_axis { UpAxis::Y => "Y", UpAxis::Z => "Z" },
            }),
        }
    }

    /// The name of the nodes and the mesh.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Adds how the shapes were made, which belong to no clip.
    pub(super) fn with_recipe(mut self, recipe: &StatedRecipe) -> Self {
        self.extras["rhytid"] = json!(recipe);
        self
    }

    /// Adds which channels are in which attributes.
    pub(super) fn with_attributes(mut self, attributes: &[Attribute]) -> Self {
        if let Some(stated) = Attribute::stated(attributes) {
            self.extras["attributes"] = stated;
        }
        self
    }
}

/// How stored positions become mesh units: scaled, then moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placement {
    pub scale: f32,
    pub translation: [f32; 3],
}

impl Placement {
    /// Positions are stored in mesh units.
    pub(crate) const NONE: Self = Self { scale: 1.0, translation: [0.0; 3] };
}

/// A file being written: first [`Document::base`], then each [`Document::target`].
pub(super) struct Document {
    pub buffers: Buffers,
    about: About,
    surface: Surface,
    looks: Looks,
    /// Whether the vertices have their numbers as an attribute.
    vertex_ids: bool,
    /// Whether texture coordinates may be stored as 16-bit integers.
    quantize: bool,
    /// Whether any attribute needs the extension.
    quantized: bool,
    attributes: BTreeMap<Semantic, Index<Accessor>>,
    /// The corners of each part of the surface.
    indices: Vec<Index<Accessor>>,
    targets: Vec<MorphTarget>,
    target_names: Vec<String>,
    /// The further attributes of the targets, if there are any.
    target_extras: Vec<Extras>,
}

impl Document {
    /// An empty file for the mesh of `scene`.
    ///
    /// # Errors
    /// [`Error::Input`] if the vertices are to be numbered and are too many; [`Error::Io`].
    pub(super) fn create(
        path: &Path,
        kind: Kind,
        scene: &Scene<'_>,
        options: &Options,
        about: About,
    ) -> Result<Self> {
        if options.vertex_ids && scene.rest.len() > MOST_VERTICES {
            return Err(Error::too_large(format!(
                "{}: has {} vertices, and an attribute of a glTF file can number {MOST_VERTICES}; leave the \
                 numbers out, or write .usd, which keeps the order",
                path.display(),
                scene.rest.len()
            )));
        }
        let surface = Surface::new(scene, options.one_material);
        let mut container = Container::create(path, kind, Limit::new(kind, options))?;
        let looks = Looks::new(scene, &surface, options.textures != Some(TextureFiles::None));
        let looks = looks.with_files(&mut container, options.textures.unwrap_or(kind.default_textures()))?;
        Ok(Self {
            buffers: Buffers::new(container, options.meshopt),
            about,
            looks,
            surface,
            vertex_ids: options.vertex_ids,
            quantize: options.quantize,
            quantized: false,
            attributes: BTreeMap::new(),
            indices: Vec::new(),
            targets: Vec::new(),
            target_names: Vec::new(),
            target_extras: Vec::new(),
        })
    }

    /// The file's name, for messages.
    pub(super) fn path(&self) -> &Path {
        self.buffers.container.path()
    }

    /// The number of targets so far.
    pub(super) fn targets(&self) -> usize {
        self.targets.len()
    }

    /// Writes the mesh itself, of V positions and normals.
    pub(super) fn base(&mut self, positions: &Values, normals: Option<&Values>) -> Result<()> {
        for part in &self.surface.parts {
            self.indices.push(self.buffers.triangles(part)?);
        }
        let positions = self.vectors(positions, true)?;
        self.attributes.insert(Semantic::Positions, positions);
        if let Some(normals) = normals {
            let normals = self.vectors(normals, false)?;
            self.attributes.insert(Semantic::Normals, normals);
        }
        if let Some(uvs) = &self.surface.uvs {
            // Coordinates outside of 0 to 1 repeat the texture, and 16-bit integers cannot hold them.
            let within = uvs.as_flattened().iter().all(|x| (0.0..=1.0).contains(x));
            let uvs = if self.quantize && within {
                let uvs: Vec<_> = uvs.iter().map(|uv| uv.map(|x| (x * 65535.0).round() as u16)).collect();
                self.buffers.attribute(&uvs, Element::VEC2.normalized(ComponentType::U16))?
            } else {
                self.buffers.attribute(uvs, Element::VEC2)?
            };
            self.attributes.insert(Semantic::TexCoords(0), uvs);
        }
        if self.vertex_ids {
            // As wide as the other attributes of the application: Blender fails on attributes of two widths.
            let ids: Vec<[f32; 3]> = self.surface.ids().map(|id| [id as f32, 0.0, 0.0]).collect();
            let ids = self.buffers.attribute(&ids, Element::VEC3)?;
            self.attributes.insert(Semantic::Extras(attributes::VERTEX_ID.into()), ids);
        }
        Ok(())
    }

    /// Writes a further target: the offsets that its weight 1 adds to V positions and normals.
    pub(super) fn target(
        &mut self,
        name: String,
        positions: &Values,
        normals: Option<&Values>,
    ) -> Result<()> {
        let positions = Some(self.vectors(positions, true)?);
        let normals = normals.map(|normals| self.vectors(normals, false)).transpose()?;
        self.targets.push(MorphTarget { positions, normals, tangents: None });
        self.target_names.push(name);
        Ok(())
    }

    /// Writes a further attribute of the mesh: V×3 numbers.
    pub(super) fn base_extra(&mut self, name: &str, values: Vec<f32>) -> Result<()> {
        let index = self.vectors(&Values::F32(values), false)?;
        self.attributes.insert(Semantic::Extras(name.trim_start_matches('_').into()), index);
        Ok(())
    }

    /// Writes a further attribute of the last target: the offsets that its weight 1 adds.
    pub(super) fn target_extra(&mut self, name: &str, values: Vec<f32>) -> Result<()> {
        let index = self.vectors(&Values::F32(values), false)?;
        self.target_extras.resize(self.targets.len(), Extras::new());
        self.target_extras
            .iter_mut()
            .last()
            .into_iter()
            .for_each(|extras| extras.push((name.to_owned(), index.value() as u32)));
        Ok(())
    }

    /// States the deviation of shapes, which belong to no clip.
    pub(super) fn state(&mut self, error: Deviation) {
        self.about.extras["error"] = of_positions(error, self.about.metres_per_unit);
    }

    /// Says if a viewer needs much memory because it keeps a copy of all targets for each material.
    fn warn_of_copies_of_targets(&self) {
        let (parts, targets) = (self.surface.parts.len() as u64, self.targets.len() as u64);
        let kinds = if self.attributes.contains_key(&Semantic::Normals) { 2 } else { 1 };
        // A pixel of four floats for each vertex, of positions and of normals.
        let bytes = parts * targets * self.surface.vertices() as u64 * kinds * 16;
        if parts > 1 && bytes > MUCH_MEMORY {
            log::warn!(
                "{}: viewers such as three.js keep all {targets} morph targets of all vertices once for each of the \
                 {parts} materials, which takes {} of the GPU's memory; write one material, or compress to fewer \
                 targets",
                self.path().display(),
                human::bytes(bytes)
            );
        }
    }

    fn vectors(&mut self, values: &Values, bounds: bool) -> Result<Index<Accessor>> {
        self.quantized |= !matches!(values, Values::F32(_));
        self.buffers.vectors(values, &self.surface, bounds)
    }

    /// Writes the rest and gives the file its name. `weights` are those of the targets where nothing is
    /// animated, such as those of the first frame; all are 0 if none are given.
    pub(super) fn finish(
        mut self,
        placement: Placement,
        weights: Option<Vec<f32>>,
        clips: Clips,
        progress: &dyn Progress,
    ) -> Result<Written> {
        self.warn_of_copies_of_targets();
        let About { name, metres_per_unit, up_axis, mut extras } = self.about;
        let node = Node {
            mesh: Some(Index::new(0)),
            name: Some(name.clone()),
            ..placed(placement, metres_per_unit, up_axis)
        };
        let mut nodes = Nodes { mesh: Index::new(0), root: Index::new(0), head: None, nodes: vec![node] };
        let errors = clips.errors();
        let animations =
            clips.write(&mut self.buffers, &mut nodes, &mut extras, &name, metres_per_unit, up_axis)?;
        let images = self.looks.write(&mut self.buffers)?;
        let extensions = extensions(self.quantized, self.buffers.meshopt);
        let targets = self.targets.len();
        let attributes: BTreeMap<_, _> =
            self.attributes.into_iter().map(|(semantic, index)| (Valid(semantic), index)).collect();
        let of_targets = (targets > 0).then_some(self.targets);
        let primitives = self.indices.iter().zip(0..).map(|(&indices, material)| Primitive {
            attributes: attributes.clone(),
            extensions: None,
            extras: None,
            indices: Some(indices),
            material: Some(Index::new(material)),
            mode: Valid(Mode::Triangles),
            targets: of_targets.clone(),
        });
        // Some programs take the weights for granted where there are targets.
        let weights = weights.unwrap_or_else(|| vec![0.0; targets]);
        let mesh = Mesh {
            extensions: None,
            extras: if targets > 0 { raw(&json!({ "targetNames": self.target_names }))? } else { None },
            name: Some(name),
            primitives: primitives.collect(),
            weights: (targets > 0).then_some(weights),
        };
        extras["vertices"] = self.surface.originals().into();
        if !self.surface.copied().is_empty() {
            extras["copies"] = self.surface.copied().into();
        }
        let scene = ::gltf::json::Scene {
            extensions: None,
            extras: raw(&extras)?,
            name: None,
            nodes: vec![nodes.root],
        };
        let root = Root {
            asset: Asset {
                version: "2.0".into(),
                generator: Some(concat!("Rhytid ", env!("CARGO_PKG_VERSION")).into()),
                ..Asset::default()
            },
            scene: Some(Index::new(0)),
            scenes: vec![scene],
            nodes: nodes.nodes,
            meshes: vec![mesh],
            materials: self.looks.materials()?,
            textures: self.looks.textures(),
            images,
            animations,
            buffers: self.buffers.buffers(),
            buffer_views: self.buffers.views,
            accessors: self.buffers.accessors,
            extensions_used: extensions.clone(),
            extensions_required: extensions,
            ..Root::default()
        };
        let bytes = self.buffers.container.finish(text(&root, &self.target_extras)?, progress)?;
        Ok(Written { bytes, targets: Some(targets), errors })
    }
}

/// The extensions that a reader has to know.
pub(crate) fn extensions(is_quantized: bool, is_meshopt: bool) -> Vec<String> {
    let mut extensions = Vec::new();
    if is_quantized {
        extensions.push(QUANTIZATION.to_owned());
    }
    if is_meshopt {
        extensions.push(meshopt::EXTENSION.to_owned());
    }
    extensions
}

/// The JSON, with the further attributes of targets, for which `root` has no place.
fn text(root: &Root, target_extras: &[Extras]) -> Result<Vec<u8>> {
    let internal = |e: serde_json::Error| Error::Internal(format!("a glTF document: {e}"));
    if target_extras.is_empty() {
        return root.to_vec().map_err(internal);
    }
    let mut document = serde_json::to_value(root).map_err(internal)?;
    attributes::add_to_targets(&mut document, target_extras);
    serde_json::to_vec(&document).map_err(internal)
}

/// A node that takes the stored positions to metres with Y up.
pub(crate) fn placed(placement: Placement, metres_per_unit: f64, up_axis: UpAxis) -> Node {
    let scale = (metres_per_unit * f64::from(placement.scale)) as f32;
    let translation = placement.translation.map(|x| (metres_per_unit * f64::from(x)) as f32);
    Node {
        scale: (scale != 1.0).then_some([scale; 3]),
        rotation: (up_axis == UpAxis::Z).then_some(UnitQuaternion([-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2])),
        translation: (translation != [0.0; 3]).then_some(y_up(translation, up_axis)),
        ..Node::default()
    }
}

/// Data of the application.
pub(super) fn raw(value: &Value) -> Result<extras::Extras> {
    let raw = serde_json::value::to_raw_value(value).map_err(|e| Error::Internal(format!("extras: {e}")))?;
    Ok(Some(raw))
}
