//! The animation of one mesh in one layer.

use super::images::{has_textures, image};
use super::lookup::{
    SCALE, attribute, below, default_prim, dictionary, face_of, field, meshes, stated_errors, stated_recipe,
};
use super::opened::{Opened, Samples, VARIANT_SET};
use super::shapes::Shapes;
use crate::channels;
use crate::compare::differences;
use crate::layer::{Attribute, Fields, Layer, Prim, Property, Specifier, Value};
use crate::write::{Assets, Choices, accept, animation_layer, baked_layer};
use rhytid_core::channel::{self, Channel, Timing};
use rhytid_core::{Error, Faces, Result, UpAxis};
use rhytid_export::{AnimationReader, Scene, StatedError, Summary, clip_number};
use std::path::{Path, PathBuf};

/// An animation that one layer holds.
pub(crate) struct Animation {
    /// The file's name.
    name: String,
    /// The file, if it is one.
    path: Option<PathBuf>,
    summary: Summary,
    samples: Box<dyn Samples>,
    numbers: Numbers,
    layer: Layer,
    /// What the reader of the layer has left out.
    unread: Vec<String>,
}

/// Under which numbers the samples are.
struct Numbers {
    /// The samples of every frame: its points, or the weights of shapes.
    frames: usize,
    /// The shapes, if the points are sums of shapes.
    shapes: Option<Shapes>,
    /// The channels that the mesh has samples of. If there are shapes, only those that the shapes do not
    /// make.
    channels: Vec<(Channel, usize)>,
    extent: Option<Extent>,
    head: Option<usize>,
}

/// What to do where a layer has variants, which are left out.
fn of_variants(unread: &[String]) -> String {
    let set = unread.iter().find(|what| what.starts_with(VARIANT_SET));
    set.map_or_else(String::new, |set| {
        format!("; {set} is not read: open a file that one of its variants has")
    })
}

/// The box around the positions.
#[derive(Clone, Copy)]
enum Extent {
    /// The samples of each frame's box.
    OfFrames(usize),
    /// One box around all frames of all clips.
    OfClips([[f32; 3]; 2]),
}

impl Animation {
    /// Finds the animation in a layer: the clip of the name `clip`, else the first. `name` is the file's, and
    /// `path` is where it is.
    ///
    /// # Errors
    /// [`Error::Input`] if the layer does not have one mesh below its default prim, with points that have a
    /// sample at each of consecutive time codes, or has no such clip.
    pub(crate) fn new(opened: Opened, name: String, path: Option<&Path>, clip: Option<&str>) -> Result<Self> {
        let Opened { layer, mut samples, unread } = opened;
        let clip = clip_number(&default_prim(&layer).map(clips).unwrap_or_default(), clip, Path::new(&name))?;
        let found = find(&layer, samples.as_mut(), clip).map_err(|fault| match fault {
            Fault::Found(what) => Error::malformed(format!("{name}: {what}{}", of_variants(&unread))),
            Fault::Unread(error) => error,
        });
        let path = path.map(Path::to_owned);
        found.map(|(summary, numbers)| Self { name, path, summary, samples, numbers, layer, unread })
    }

    /// The numbers of a channel in a sample.
    fn sample(&mut self, channel: &Channel, number: usize, frame: usize, out: &mut Vec<f32>) -> Result<()> {
        let frame_of_sample = if channel.timing == Timing::Constant { 0 } else { frame };
        let (width, numbers) = match self.samples.read(number, frame_of_sample)? {
            Value::Floats(numbers) => (1, numbers),
            Value::Float2s(pairs) => (2, pairs.into_flattened()),
            Value::Float3s(vectors) => (3, vectors.into_flattened()),
            _ => return Err(self.damaged(&channel.words, frame, "another type, expected floats")),
        };
        let expected = channel.numbers(self.summary.vertices, self.summary.faces.len());
        if width != channel.width || numbers.len() != expected {
            let (found, expected) = (numbers.len(), expected / channel.width);
            let what =
                format!("{found} numbers, {width} for each value, expected {expected} × {}", channel.width);
            return Err(self.damaged(&channel.words, frame, &what));
        }
        *out = numbers;
        Ok(())
    }

    fn damaged(&self, what: &str, frame: usize, found: &str) -> Error {
        let (name, time) = (&self.name, self.summary.time_code(frame));
        Error::malformed(format!("{name}: its {what} at time code {time} have {found}; export it again"))
    }
}

impl AnimationReader for Animation {
    fn summary(&self) -> &Summary {
        &self.summary
    }

    fn channel(&mut self, channel: &Channel, frame: usize, out: &mut Vec<f32>) -> Result<()> {
        out.clear();
        let known = self.numbers.channels.iter().find(|(known, _)| known.name == channel.name);
        if let Some((known, number)) = known.cloned() {
            return self.sample(&known, number, frame, out);
        }
        let Some(shapes) = &self.numbers.shapes else { return Ok(()) };
        let is_positions = channel.name == channel::POSITIONS.name;
        if !is_positions && channel.name != channel::NORMALS.name {
            return Ok(());
        }
        let Some(weights) = shapes.weights(self.samples.read(self.numbers.frames, frame)?) else {
            return Err(self.damaged("weights", frame, "not one from 0 to 1 for each shape"));
        };
        if is_positions {
            shapes.positions(&weights, out);
        } else {
            shapes.normals(&weights, out);
        }
        Ok(())
    }

    fn extent(&mut self, frame: usize) -> Result<Option<[[f32; 3]; 2]>> {
        let number = match self.numbers.extent {
            None => return Ok(None),
            Some(Extent::OfClips(corners)) => return Ok(Some(corners)),
            Some(Extent::OfFrames(number)) => number,
        };
        match self.samples.read(number, frame)? {
            Value::Float3s(corners) if corners.len() == 2 => Ok(Some([corners[0], corners[1]])),
            _ => Err(self.damaged("extents", frame, "no two corners")),
        }
    }

    fn head(&mut self, frame: usize) -> Result<Option<[[f64; 4]; 4]>> {
        let Some(number) = self.numbers.head else { return Ok(None) };
        match self.samples.read(number, frame)? {
            // USD's vectors are rows.
            Value::Matrix4d(rows) => Ok(Some(std::array::from_fn(|i| std::array::from_fn(|j| rows[j][i])))),
            _ => Err(self.damaged("head's transforms", frame, "another type, expected matrix4d")),
        }
    }

    fn compare(&mut self, scene: &Scene<'_>) -> Result<Vec<String>> {
        // Textures may be left out, as an export can do it. Where they are is its choice, too.
        let assets = if has_textures(&self.layer) { Assets::named(scene) } else { Assets::NONE };
        let choices = Choices::of_layer(&self.layer, assets);
        let mut expected = match &self.numbers.shapes {
            None => animation_layer(scene, &choices)?,
            Some(_) => with_shapes(&self.layer, scene, &choices)?,
        };
        let path = self.path.as_deref();
        accept(&mut expected, &self.layer, scene, |asset, size| image(path?, asset, size));
        Ok(differences(&self.layer, &self.unread, &expected))
    }
}

/// The layer of an export with the base and the shapes that are in `layer`: their numbers are compared as
/// frames.
fn with_shapes(layer: &Layer, scene: &Scene<'_>, choices: &Choices) -> Result<Layer> {
    let was_there = || Error::Internal("a mesh was there before".into());
    let face = face_of(layer).ok_or_else(was_there)?;
    let mesh = face.mesh.ok_or_else(was_there)?;
    let shapes = mesh.children.iter().filter(|child| child.type_name == "BlendShape");
    let names = shapes.clone().map(|shape| shape.name.clone()).collect();
    let animations = below(face.prim, "SkelAnimation");
    let prims: Vec<String> = animations.iter().map(|animation| animation.name.clone()).collect();
    let mut expected = baked_layer(scene, choices, names, &prims, mesh)?;
    let prims_of_clips = prims.len();
    if prims_of_clips > 1 {
        // The stage plays the first clip, and the scene may be another one's.
        let of_file = |name: &str| field(&layer.metadata, name).cloned();
        for (name, value) in &mut expected.metadata {
            if ["startTimeCode", "endTimeCode"].contains(&name.as_str())
                && let Some(found) = of_file(name)
            {
                *value = found;
            }
        }
    }
    let extent = attribute(face.prim, "extent").filter(|extent| extent.samples.is_none()).cloned();
    let is_known = |property: &Property| match property {
        Property::Attribute(Attribute { name, uniform: true, samples: None, .. }) => {
            ["offsets", "normalOffsets", "pointIndices"].contains(&name.as_str())
        }
        _ => false,
    };
    let children = shapes.cloned().map(|mut shape| {
        shape.specifier = Specifier::Def;
        shape.properties.retain(is_known);
        Prim { metadata: Fields::new(), children: Vec::new(), ..shape }
    });
    // Along the path, each prim is the only one, and the first child of the last is the mesh.
    let (_, above) = face.path.split_last().ok_or_else(was_there)?;
    let prims = above.iter().try_fold(&mut expected.prims, |prims, _| Some(&mut prims.first_mut()?.children));
    let root = prims.and_then(|prims| prims.first_mut()).ok_or_else(was_there)?;
    // The box around the frames of several clips is compared with the frames of each clip.
    root.properties.extend(extent.filter(|_| prims_of_clips > 1).map(Property::Attribute));
    let mesh = root.children.first_mut().ok_or_else(was_there)?;
    mesh.children.extend(children);
    Ok(expected)
}

/// Why there is no animation.
enum Fault {
    /// What is wrong with the layer.
    Found(String),
    /// A sample could not be read.
    Unread(Error),
}

impl From<String> for Fault {
    fn from(what: String) -> Self {
        Self::Found(what)
    }
}

/// The names of the clips below the default prim `root`; none if it has no more than one.
fn clips(root: &Prim) -> Vec<String> {
    let animations = below(root, "SkelAnimation");
    let name = |animation: &&Prim| {
        let data = dictionary(&animation.metadata, "customData");
        match data.and_then(|data| field(data, "name")) {
            Some(Value::String(name)) => name.clone(),
            _ => animation.name.clone(),
        }
    };
    if animations.len() > 1 { animations.iter().map(name).collect() } else { Vec::new() }
}

/// The box around the frames of several clips; `None` for a single one.
fn extent_of_clips(root: &Prim, animations: &[&Prim]) -> Option<[[f32; 3]; 2]> {
    match attribute(root, "extent")?.default.as_ref()? {
        Value::Float3s(corners) if animations.len() > 1 => <[[f32; 3]; 2]>::try_from(&corners[..]).ok(),
        _ => None,
    }
}

fn find(layer: &Layer, samples: &mut dyn Samples, clip: usize) -> Result<(Summary, Numbers), Fault> {
    let face = face_of(layer).ok_or_else(|| {
        "has no default prim, expected that of an exported animation; export it again".to_owned()
    })?;
    let root = face.prim;
    let meshes = meshes(root);
    let [mesh] = meshes[..] else {
        return Err(Fault::Found(format!(
            "has {} meshes below its default prim {}, expected the one of an exported animation",
            meshes.len(),
            root.name
        )));
    };
    let sampled = |prim: &Prim, name: &str| attribute(prim, name).and_then(|attribute| attribute.samples);
    let animations = below(root, "SkelAnimation");
    let read = |clip: usize| match animations.get(clip) {
        Some(animation) => Shapes::read(animation, mesh),
        None => Ok(None),
    };
    let shapes = read(clip)?;
    let first_clip = if clip > 0 { read(0)?.map(|shapes| shapes.samples) } else { None };
    let channels = channels::of_mesh(mesh);
    let points = sampled(mesh, "points").or_else(|| shapes.as_ref().map(|shapes| shapes.samples));
    let frames = points.ok_or_else(|| {
        format!("its mesh {} has no time samples of points, expected an exported animation", mesh.name)
    })?;
    let mut numbers = Numbers {
        frames,
        shapes,
        channels,
        extent: match sampled(mesh, "extent").or_else(|| sampled(root, "extent")) {
            Some(number) => Some(Extent::OfFrames(number)),
            None => extent_of_clips(root, &animations).map(Extent::OfClips),
        },
        head: sampled(root, "xformOp:transform"),
    };
    let (first_time_code, frames) = check_times(&mut numbers, samples)?;
    match first_clip.map(|samples_of_first| samples.times(samples_of_first)) {
        // The stage plays the first clip.
        Some([first, .., last]) => check_metadata(layer, mesh, *first, (last - first) as usize + 1)?,
        Some([first]) => check_metadata(layer, mesh, *first, 1)?,
        _ => check_metadata(layer, mesh, first_time_code, frames)?,
    }
    let stated_by = match animations.get(clip) {
        Some(animation) if animations.len() > 1 => *animation,
        _ => root,
    };
    let vertices = match attribute(mesh, "points").and_then(|points| points.default.as_ref()) {
        Some(Value::Float3s(rest)) => rest.len(),
        _ => match samples.read(numbers.frames, 0).map_err(Fault::Unread)? {
            Value::Float3s(points) => points.len(),
            _ => 0,
        },
    };
    // If a layer does not state a value, USD takes the default.
    let number = |name: &str, fallback: f64| match field(&layer.metadata, name) {
        Some(Value::Double(x)) => *x,
        _ => fallback,
    };
    let scale = match attribute(root, SCALE).and_then(|scale| scale.default.as_ref()) {
        Some(Value::Double3([x, ..])) => *x,
        _ => 1.0,
    };
    let metres_per_unit = number("metersPerUnit", 0.01) * scale;
    let up_axis = match field(&layer.metadata, "upAxis") {
        Some(Value::Token(axis)) if axis == "Z" => UpAxis::Z,
        _ => UpAxis::Y,
    };
    // The faces are in the layer below.
    let is_over = root.specifier == Specifier::Over && attribute(mesh, "faceVertexCounts").is_none();
    let errors = stated_errors(stated_by, metres_per_unit);
    let has_normals = numbers.shapes.as_ref().is_some_and(Shapes::has_normals);
    let of_normals = errors.as_ref().filter(|_| has_normals).map(|errors| StatedError {
        channel: channel::NORMALS.name.clone().into_owned(),
        worst: errors.normals.worst,
        rms: errors.normals.rms,
    });
    let stated_channel_errors = of_normals.into_iter().collect();
    let summary = Summary {
        name: mesh.name.clone(),
        vertices,
        faces: if is_over { Faces::default() } else { faces(mesh, vertices)? },
        frames,
        first_time_code,
        rate: number("timeCodesPerSecond", 24.0),
        frames_per_second: match field(&layer.metadata, "framesPerSecond") {
            Some(Value::Double(x)) => Some(*x),
            _ => None,
        },
        metres_per_unit,
        up_axis,
        fitted: numbers.shapes.is_some(),
        channels: summarised(&numbers),
        extents: numbers.extent.is_some(),
        head: numbers.head.is_some(),
        recipe: stated_recipe(stated_by),
        clips: clips(root),
        stated_error: errors.map(|errors| errors.positions),
        stated_channel_errors,
    };
    Ok((summary, numbers))
}

/// The channels of the frames: those with samples, and those that shapes make.
fn summarised(numbers: &Numbers) -> Vec<Channel> {
    let sampled = numbers.channels.iter().map(|(channel, _)| channel.clone());
    let Some(shapes) = &numbers.shapes else { return sampled.collect() };
    let made = [Some(&channel::POSITIONS), Some(&channel::NORMALS).filter(|_| shapes.has_normals())];
    let made: Vec<Channel> = made.into_iter().flatten().cloned().collect();
    let sampled: Vec<Channel> = sampled.filter(|channel| !made.contains(channel)).collect();
    made.into_iter().chain(sampled).collect()
}

/// Checks that the layer's other statements fit its samples. Otherwise programs would play another range, or
/// see the faces from behind.
fn check_metadata(layer: &Layer, mesh: &Prim, first: f64, frames: usize) -> Result<(), String> {
    let number = |name: &str| match field(&layer.metadata, name) {
        Some(Value::Double(x)) => Some(*x),
        _ => None,
    };
    let last = first + (frames - 1) as f64;
    for (name, expected, what) in
        [("startTimeCode", first, "its first sample"), ("endTimeCode", last, "its last sample")]
    {
        if let Some(found) = number(name).filter(|found| *found != expected) {
            return Err(format!(
                "has the {name} {found}, expected {expected}, the time code of {what}; export it again"
            ));
        }
    }
    let orientation = attribute(mesh, "orientation").and_then(|attribute| attribute.default.as_ref());
    match orientation {
        Some(Value::Token(token)) if token == "leftHanded" => {
            Err("has left-handed faces, expected those of an exported animation, which are right-handed"
                .into())
        }
        _ => Ok(()),
    }
}

/// The first time code and the number of frames, which all that is sampled has.
fn check_times(numbers: &mut Numbers, samples: &dyn Samples) -> Result<(f64, usize), String> {
    let times = samples.times(numbers.frames);
    let Some(&first) = times.first() else {
        return Err("its points have no time samples, expected one for each frame; export it again".into());
    };
    if times.iter().enumerate().any(|(i, &time)| time != first + i as f64) {
        return Err(format!(
            "its points do not have a sample at each time code from {first} on, expected one for each frame, \
             as in an exported animation"
        ));
    }
    let fault = |what: &str| {
        Err(format!("its points and its {what} have samples at different time codes; export it again"))
    };
    for (channel, number) in &mut numbers.channels {
        match samples.times(*number) {
            found if found == times => {}
            [found] if *found == first => channel.timing = Timing::Constant,
            _ => return fault(&channel.words),
        }
    }
    let extent = match numbers.extent {
        Some(Extent::OfFrames(number)) => Some(number),
        _ => None,
    };
    for (what, number) in [("extents", extent), ("head", numbers.head)] {
        if number.is_some_and(|number| samples.times(number) != times) {
            return fault(what);
        }
    }
    Ok((first, times.len()))
}

/// The polygons of the mesh.
fn faces(mesh: &Prim, vertices: usize) -> Result<Faces, String> {
    let numbers = |name: &str| {
        let Some(Value::Ints(numbers)) =
            attribute(mesh, name).and_then(|attribute| attribute.default.as_ref())
        else {
            return Err(format!("its mesh {} has no {name}; export it again", mesh.name));
        };
        let positive: Result<Vec<u32>, _> = numbers.iter().map(|&x| u32::try_from(x)).collect();
        positive
            .map_err(|_| format!("its mesh {} has negative numbers in {name}; export it again", mesh.name))
    };
    let faces = Faces { counts: numbers("faceVertexCounts")?, indices: numbers("faceVertexIndices")? };
    match faces.fault(vertices) {
        None => Ok(faces),
        Some(fault) => Err(format!("its mesh {} {fault}; export it again", mesh.name)),
    }
}
