//! A take as a given number of shapes with curves, as USD: blend shapes of a mesh, and an animation with
//! their weights in each frame. The shapes are those of compressed glTF ([`rhytid_export::morphs`]).
use super::choices::Choices;
use super::face::of_rows;
use super::layer_writer::{Attached, Encoding, LayerWriter};
use super::sample::Sample;
use super::shapes::{bind, declare, posed_extent};
use super::surface::{Surface, extent};
use super::textures;
use crate::build::attribute;
use crate::layer::{Attribute, Fields, Layer, Prim, Property, Value};
use rhytid_core::{AtomicFile, Error, Progress, Result, RigidMotion, channel};
use rhytid_export::morphs::{Frames, NormalsOff, Target, Values};
use rhytid_export::{Deviation, Exporter, Frame, Options, Scene, Shape, Written};
use std::path::{Path, PathBuf};

/// The numbers of the attributes that have samples.
const WEIGHTS: usize = 0;
const HEAD: usize = 1;
const EXTENT: usize = 2;

/// Frames on their way to shapes, which are found once all are known.
pub struct Baked {
    path: PathBuf,
    encoding: Encoding,
    /// The face at rest, whose positions will be those of the shapes' base.
    surface: Surface,
    attached: Attached,
    frames: Frames,
    shapes: usize,
    first_time_code: f64,
    metres_per_unit: f64,
    head: Vec<RigidMotion>,
}

impl Baked {
    /// Keeps what does not move.
    ///
    /// # Errors
    /// [`Error::Input`] if the scene has channels other than normals, for which there is no place, or the
    /// folder does not exist, or for textures where this encoding has no place for them; [`Error::Io`].
    pub fn create(
        path: &Path,
        encoding: Encoding,
        scene: &Scene<'_>,
        shapes: usize,
        options: &Options,
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
        let (assets, attached) = textures::place(path, encoding, scene, options)?;
        let mut surface = Surface::new(scene, "SkelRoot", &Choices::new(options, assets))?;
        surface.play(scene, HEAD);
        surface.root.push(extent_of_root());
        let spool = AtomicFile::create(path)?.spool()?;
        Ok(Self {
            path: path.to_owned(),
            encoding,
            surface,
            attached,
            frames: Frames::new(spool, path, scene.rest.len(), scene.rest_normals.is_some(), Vec::new()),
            shapes,
            first_time_code: scene.first_time_code,
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
        let Self { path, encoding, mut surface, attached, frames, shapes, .. } = *self;
        let Self { first_time_code, metres_per_unit, head, .. } = *self;
        let count = frames.frames();
        let morphs = frames.bake(shapes, false, progress)?;
        let base = vectors(&morphs.base)?;
        replace(&mut surface.mesh, "extent", Value::Float3s(extent(&base).to_vec()));
        replace(&mut surface.mesh, "points", Value::Float3s(base.clone()));
        if let Some(normals) = &morphs.base_normals {
            replace(&mut surface.mesh, "normals", Value::Float3s(vectors(normals)?));
        }
        let named = |(k, target): (usize, &Target)| {
            Ok(Shape {
                name: format!("shape {:02}", k + 1),
                offsets: vectors(&target.positions)?,
                normal_offsets: target.normals.as_ref().map(vectors).transpose()?,
            })
        };
        let shapes = morphs.targets.iter().enumerate().map(named).collect::<Result<Vec<Shape>>>()?;
        let error = Deviation {
            worst: morphs.worst.error,
            at: (morphs.worst.frame, morphs.worst.vertex),
            rms: morphs.rms,
        };
        state(&mut surface.root, &error, morphs.normals_off, metres_per_unit);
        let skeleton = bind(&mut surface, &shapes, Some(WEIGHTS))?;
        let mut writer = LayerWriter::with(&path, encoding, &surface.into_layer(vec![skeleton]), attached)?;
        for frame in 0..count {
            let time = first_time_code + frame as f64;
            let weights = &morphs.weights[frame * shapes.len()..][..shapes.len()];
            writer.sample(WEIGHTS, time, Sample::Floats(weights))?;
            writer.sample(EXTENT, time, Sample::Float3s(&posed_extent(&base, &shapes, weights)))?;
            if let Some(motion) = head.get(frame) {
                writer.sample(HEAD, time, Sample::Matrix4d(&of_rows(motion)))?;
            }
        }
        Ok(Written { bytes: writer.finish()?, targets: Some(shapes.len()), error: Some(error) })
    }
}

/// The layer of an export, without the samples and the shapes themselves. `names` are those of the shapes,
/// and `mesh` is the mesh of a file, whose base is taken as it is.
pub(crate) fn baked_layer(
    scene: &Scene<'_>,
    choices: &Choices,
    names: Vec<String>,
    mesh: &Prim,
) -> Result<Layer> {
    let mut surface = Surface::new(scene, "SkelRoot", choices)?;
    surface.play(scene, HEAD);
    surface.root.push(extent_of_root());
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
    let skeleton = declare(&mut surface, names, Some(WEIGHTS));
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

/// States the error beside the recipe, as glTF's extras do.
fn state(root: &mut Prim, error: &Deviation, normals: Option<NormalsOff>, metres_per_unit: f64) {
    let millimetres = |x: f64| Value::Double(x * metres_per_unit * 1000.0);
    let index = |n: usize| Value::Double(n as f64);
    let mut stated: Fields = vec![
        ("worstMillimetres".into(), millimetres(error.worst)),
        ("rmsMillimetres".into(), millimetres(error.rms)),
        ("frame".into(), index(error.at.0)),
        ("vertex".into(), index(error.at.1)),
    ];
    if let Some(NormalsOff { worst, rms }) = normals {
        stated.push(("normalWorst".into(), Value::Double(worst)));
        stated.push(("normalRms".into(), Value::Double(rms)));
    }
    for (name, value) in &mut root.metadata {
        if let ("customData", Value::Dictionary(custom)) = (name.as_str(), value) {
            custom.push(("rhytidError".into(), Value::Dictionary(stated)));
            return;
        }
    }
}
