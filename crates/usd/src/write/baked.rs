//! Takes as shapes with curves, as USD: blend shapes of a mesh, and for each take an animation with their
//! weights in each frame. The shapes are those of compressed glTF ([`rhytid_export::morphs`]), or given ones.
use super::choices::Choices;
use super::face::of_rows;
use super::layer_writer::{Attached, Encoding, LayerWriter};
use super::names::identifiers;
use super::sample::Sample;
use super::shapes::{WEIGHTS, animation, around, bind, declare, posed_extent};
use super::surface::{Surface, custom_data, extent};
use super::textures;
use crate::build::attribute;
use crate::layer::{Attribute, Fields, Layer, Prim, Property, Value};
use rayon::prelude::*;
use rhytid_core::{AtomicFile, Error, Progress, Remedy, Result, RigidMotion, channel, human};
use rhytid_export::morphs::{ClipErrors, Frames, Off, Target, Values};
use rhytid_export::{Exporter, Frame, Options, Scene, Shape, ShapeSet, StatedRecipe, Written};
use std::path::{Path, PathBuf};

/// The numbers of the attributes that have samples: the head, the box around the mesh, and then the weights
/// of each clip.
const HEAD: usize = 0;
const EXTENT: usize = 1;
const FIRST_WEIGHTS: usize = 2;

/// What the frames become sums of.
pub enum Goal {
    /// So many shapes.
    Shapes(usize),
    /// These shapes, whose weights alone are free.
    Onto(ShapeSet),
}

impl Goal {
    /// The goal that `options` name, if they name one.
    pub fn of(options: &Options) -> Option<Self> {
        let onto = options.onto.clone().map(Self::Onto);
        onto.or(options.shapes.map(Self::Shapes))
    }
}

/// One take among the frames.
struct Clip {
    /// Names the prim of its weights.
    prim: String,
    /// Any text.
    name: String,
    frames: usize,
    first_time_code: f64,
    recipe: StatedRecipe,
}

/// Frames on their way to shapes, which are found once all are known.
pub struct Baked {
    path: PathBuf,
    encoding: Encoding,
    /// The face at rest, whose positions will be those of the shapes' base.
    surface: Surface,
    attached: Attached,
    frames: Frames,
    goal: Goal,
    clips: Vec<Clip>,
    metres_per_unit: f64,
    /// The head pose in each frame of the only clip; empty where it is not known.
    head: Vec<RigidMotion>,
}

impl Baked {
    /// Keeps what does not move.
    ///
    /// # Errors [`Error::Input`] if the scene has channels other than normals, for which there is no place,
    ///   or the folder does not exist, or for textures where this encoding has no place for them. Also if one
    ///   of several clips has another rate or says how the head moves: a stage has one rate, and the mesh one
    ///   transform. [`Error::Io`].
    pub fn create(
        path: &Path,
        encoding: Encoding,
        scene: &Scene<'_>,
        options: &Options,
        goal: Goal,
    ) -> Result<Self> {
        let others = scene.channels.iter().filter(|channel| channel.name != channel::NORMALS.name);
        let others: Vec<&str> = others.map(|channel| &*channel.name).collect();
        if !others.is_empty() {
            return Err(Error::conflict(format!(
                "{}: a USD file of shapes with curves has no place for {}; leave these channels or the \
                 shapes out",
                path.display(),
                others.join(", ")
            )));
        }
        check_clips(path, scene)?;
        let (assets, attached) = textures::place(path, encoding, scene, options)?;
        let mut surface = Surface::new(scene, "SkelRoot", &Choices::new(options, assets))?;
        surface.play(scene, HEAD);
        if scene.further.is_empty() {
            surface.root.push(extent_of_root());
        } else {
            // Each clip states how it was made.
            surface.root.metadata.retain(|(name, _)| name != "customData");
        }
        let lengths = scene.clips();
        let lengths = lengths.iter().map(|clip| clip.frames);
        let spool = AtomicFile::create(path)?.spool()?;
        let normals = scene.rest_normals.is_some();
        Ok(Self {
            path: path.to_owned(),
            encoding,
            surface,
            attached,
            frames: Frames::new(spool, path, scene.rest.len(), normals, Vec::new()).with_clips(lengths),
            goal,
            clips: clips(scene, options),
            metres_per_unit: scene.metres_per_unit,
            head: scene.head.unwrap_or_default().to_vec(),
        })
    }
}

impl Exporter for Baked {
    fn frame(&mut self, frame: &Frame<'_>) -> Result<()> {
        self.frames.push(frame.positions(), frame.get(&channel::NORMALS), &[])
    }

    fn finish(self: Box<Self>, progress: &dyn Progress) -> Result<Written> {
        let Self { path, encoding, mut surface, attached, frames, goal, clips, .. } = *self;
        let Self { metres_per_unit, head, .. } = *self;
        let morphs = match &goal {
            Goal::Shapes(shapes) => frames.bake(*shapes, false, progress)?,
            Goal::Onto(set) => frames.onto(set, progress)?,
        };
        let base = vectors(&morphs.base)?;
        replace(&mut surface.mesh, "extent", Value::Float3s(extent(&base).to_vec()));
        replace(&mut surface.mesh, "points", Value::Float3s(base.clone()));
        if let Some(normals) = &morphs.base_normals {
            replace(&mut surface.mesh, "normals", Value::Float3s(vectors(normals)?));
        }
        let named = |target: &Target| {
            Ok(Shape {
                name: target.name.clone(),
                offsets: vectors(&target.positions)?,
                normal_offsets: target.normals.as_ref().map(vectors).transpose()?,
            })
        };
        let shapes = morphs.targets.iter().map(named).collect::<Result<Vec<Shape>>>()?;
        let weights = |frame: usize| &morphs.weights[frame * shapes.len()..][..shapes.len()];
        let count = clips.iter().map(|clip| clip.frames).sum();
        let extents: Vec<[[f32; 3]; 2]> =
            (0..count).into_par_iter().map(|frame| posed_extent(&base, &shapes, weights(frame))).collect();
        let mut animations: Vec<Prim> =
            (FIRST_WEIGHTS..).zip(&clips).map(|(number, clip)| animation(&clip.prim, Some(number))).collect();
        if let ([_], [errors]) = (&clips[..], &morphs.clips[..]) {
            state(&mut surface.root, errors, metres_per_unit);
        } else {
            // A clip may be played at any time codes of the stage.
            let extent = around(extents.iter().copied()).to_vec();
            surface.root.set("float3[]", "extent", Value::Float3s(extent));
            for ((prim, clip), errors) in animations.iter_mut().zip(&clips).zip(&morphs.clips) {
                if let Value::Dictionary(mut data) = custom_data(&clip.recipe) {
                    data.push(("name".into(), Value::String(clip.name.clone())));
                    prim.metadata.push(("customData".into(), Value::Dictionary(data)));
                }
                state(prim, errors, metres_per_unit);
            }
        }
        let skeleton = bind(&mut surface, &shapes, animations)?;
        let mut writer = LayerWriter::with(&path, encoding, &surface.into_layer(vec![skeleton]), attached)?;
        let mut first = 0;
        for (number, clip) in (FIRST_WEIGHTS..).zip(&clips) {
            for (frame, extent) in extents[first..][..clip.frames].iter().enumerate() {
                let time = clip.first_time_code + frame as f64;
                writer.sample(number, time, Sample::Floats(weights(first + frame)))?;
                if clips.len() == 1 {
                    writer.sample(EXTENT, time, Sample::Float3s(extent))?;
                }
                if let Some(motion) = head.get(frame) {
                    writer.sample(HEAD, time, Sample::Matrix4d(&of_rows(motion)))?;
                }
            }
            first += clip.frames;
        }
        let errors = morphs.clips.iter().map(ClipErrors::deviation).collect();
        Ok(Written { bytes: writer.finish()?, targets: Some(shapes.len()), errors })
    }
}

/// The clips of a scene, with the names that `options` give.
fn clips(scene: &Scene<'_>, options: &Options) -> Vec<Clip> {
    let (clips, names) = (scene.clips(), scene.clip_names(options));
    let prims = match clips.len() {
        1 => vec![WEIGHTS.to_owned()],
        _ => identifiers(names.iter().map(String::as_str)),
    };
    let of_clip = |((prim, name), clip): ((String, String), &rhytid_export::Clip<'_>)| Clip {
        prim,
        name,
        frames: clip.frames,
        first_time_code: clip.first_time_code,
        recipe: clip.recipe.clone(),
    };
    prims.into_iter().zip(names).zip(&clips).map(of_clip).collect()
}

/// An error if one of several clips differs in what a stage and a mesh have but once.
fn check_clips(path: &Path, scene: &Scene<'_>) -> Result<()> {
    let (path, clips) = (path.display(), scene.clips());
    if clips.len() == 1 {
        return Ok(());
    }
    if clips.iter().any(|clip| clip.rate != scene.rate) {
        let rates: Vec<String> = clips.iter().map(|clip| human::number(clip.rate)).collect();
        return Err(Error::conflict(format!(
            "{path}: the takes have {} frames per second, and a USD stage has one rate for all; resample them to \
             one rate, or write .glb",
            rates.join(" and ")
        ))
        .with_remedies(&[Remedy::OneRate]));
    }
    if clips.iter().any(|clip| clip.head.is_some()) {
        return Err(Error::conflict(format!(
            "{path}: the takes say how the head moves, and in USD a mesh has one transform for all takes; leave \
             the head's motion out, or write .glb"
        ))
        .with_remedies(&[Remedy::DropHead]));
    }
    Ok(())
}

/// The layer of an export, without the samples and the shapes themselves. `names` are those of the shapes,
/// `clips` those of the animations' prims, and `mesh` is the mesh of a file, whose base is taken as it is.
pub(crate) fn baked_layer(
    scene: &Scene<'_>,
    choices: &Choices,
    names: Vec<String>,
    clips: &[String],
    mesh: &Prim,
) -> Result<Layer> {
    let mut surface = Surface::new(scene, "SkelRoot", choices)?;
    surface.play(scene, HEAD);
    if clips.len() == 1 {
        surface.root.push(extent_of_root());
    }
    for property in &mesh.properties {
        let Property::Attribute(Attribute { name, default: Some(Value::Float3s(base)), .. }) = property
        else {
            continue;
        };
        if name == "points" {
            replace(&mut surface.mesh, "extent", Value::Float3s(extent(base).to_vec()));
        }
        if name == "points" || name == "normals" {
            replace(&mut surface.mesh, name, Value::Float3s(base.clone()));
        }
    }
    let animations =
        (FIRST_WEIGHTS..).zip(clips).map(|(number, name)| animation(name, Some(number))).collect();
    let skeleton = declare(&mut surface, names, animations);
    Ok(surface.into_layer(vec![skeleton]))
}

/// The box around the mesh in each frame, which USD wants of the root of a skeleton.
fn extent_of_root() -> Attribute {
    Attribute { samples: Some(EXTENT), ..attribute("float3[]", "extent", None) }
}

fn vectors(values: &Values) -> Result<Vec<[f32; 3]>> {
    match values {
        Values::F32(numbers) => Ok(numbers.as_chunks().0.to_vec()),
        _ => Err(Error::Internal("shapes for USD were rounded to integers".into())),
    }
}

/// Gives the attribute another value, if the prim has it.
fn replace(prim: &mut Prim, name: &str, value: Value) {
    for property in &mut prim.properties {
        if let Property::Attribute(attribute) = property
            && attribute.name == name
        {
            attribute.default = Some(value);
            return;
        }
    }
}

/// States the errors beside the recipe, as glTF's extras do.
fn state(prim: &mut Prim, errors: &ClipErrors, metres_per_unit: f64) {
    let error = errors.deviation();
    let millimetres = |x: f64| Value::Double(x * metres_per_unit * 1000.0);
    let index = |n: usize| Value::Double(n as f64);
    let mut stated: Fields = vec![
        ("worstMillimetres".into(), millimetres(error.worst)),
        ("rmsMillimetres".into(), millimetres(error.rms)),
        ("frame".into(), index(error.at.0)),
        ("vertex".into(), index(error.at.1)),
    ];
    if let Some(Off { worst, rms }) = errors.normals {
        stated.push(("normalWorst".into(), Value::Double(worst)));
        stated.push(("normalRms".into(), Value::Double(rms)));
    }
    for (name, value) in &mut prim.metadata {
        if let ("customData", Value::Dictionary(custom)) = (name.as_str(), value) {
            custom.push(("rhytidError".into(), Value::Dictionary(stated)));
            return;
        }
    }
}
