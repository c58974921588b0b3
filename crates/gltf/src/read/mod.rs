//! Reads back animations that [`super::write`] has written. Nothing in a file is trusted.

mod arrays;
mod compare;
mod layout;
mod motion;
mod source;

use super::attributes::{Accessors, Attribute};
use arrays::Arrays;
use glam::{DMat4, DVec3};
use layout::Layout;
use motion::Motion;
use rhytid_core::channel::{self, Channel};
use rhytid_core::{Error, Faces, Result};
use rhytid_export::{AnimationReader, Scene, Summary, clip_number};
use source::Document;
use std::path::Path;

/// Targets that were read are kept, up to so many numbers in all (of 8 bytes).
const KEPT: usize = 1 << 25;

/// Opens the animation in the `.glb` or `.gltf` file `path`: the clip of the name `clip`, else the first.
///
/// # Errors
/// [`Error::Input`] if the file is damaged or not such an animation, or has no clip of that name;
/// [`Error::Io`].
pub fn open(path: &Path, clip: Option<&str>) -> Result<Box<dyn AnimationReader>> {
    let (Document { root, targets, json }, source) = source::open(path)?;
    let clip = clip_number(&layout::clips(&root), clip, path)?;
    animation(Arrays { root, source, name: path.display().to_string() }, &targets, json, clip)
}

/// W×3 numbers of a base mesh or a target.
type Vectors = Vec<[f64; 3]>;

struct Animation {
    arrays: Arrays,
    summary: Summary,
    layout: Layout,
    motion: Motion,
    /// For each of the W vertices in the file the original that it is or copies.
    ids: Vec<usize>,
    /// Positions, normals and each attribute of the layout, as far as they were read.
    base: Vec<Option<Vectors>>,
    /// The same of each target as offsets, as far as they are kept.
    targets: Vec<Vec<Option<Vectors>>>,
    kept: usize,
    /// The text of the JSON.
    json: Vec<u8>,
    /// The accessors of the targets' own attributes.
    own: Vec<Accessors>,
    /// What is shown where nothing is played: the first frame of the first clip.
    at_rest: AtRest,
}

/// The first frame of the first clip.
struct AtRest {
    /// A weight for each target.
    weights: Vec<f32>,
    /// The head pose, along glTF's axes in metres.
    head: Option<DMat4>,
}

impl AtRest {
    fn new(motion: &Motion, targets: usize) -> Self {
        let mut weights = vec![0.0; targets];
        motion.weights_of(0).iter().for_each(|&(target, weight)| weights[target] = weight as f32);
        Self { weights, head: motion.head.as_ref().and_then(|head| head.first().copied()) }
    }
}

fn animation(
    mut arrays: Arrays,
    targets: &[Vec<Accessors>],
    json: Vec<u8>,
    clip: usize,
) -> Result<Box<dyn AnimationReader>> {
    let own = targets.first().cloned().unwrap_or_default();
    let layout = Layout::read(&arrays.root, targets, &arrays.name, clip)?;
    let ids = ids(&mut arrays, &layout)?;
    // Copies come after all originals.
    let vertices = ids.iter().max().map_or(0, |last| last + 1);
    let fault = |what: &str| Error::malformed(format!("{}: {what}; the file is damaged", arrays.name));
    if vertices == 0 || ids.iter().take(vertices).enumerate().any(|(v, &id)| v != id) {
        return Err(fault("its vertices are not numbered from 0 on, then the copies"));
    }
    let mut corners = Vec::new();
    for &part in &layout.indices {
        corners.extend(arrays.indices(part)?);
    }
    let fault = |what: &str| Error::malformed(format!("{}: {what}; the file is damaged", arrays.name));
    if corners.is_empty() || !corners.len().is_multiple_of(3) {
        return Err(fault(&format!(
            "has {} corners of triangles, expected a multiple of 3 above 0",
            corners.len()
        )));
    }
    let original = |corner: &u32| ids.get(*corner as usize).map(|&id| id as u32);
    let indices: Option<Vec<u32>> = corners.iter().map(original).collect();
    let indices = indices.ok_or_else(|| fault("a triangle has a vertex that does not exist"))?;
    let motion = Motion::read(&mut arrays, &layout)?;
    let at_rest = if clip == 0 {
        AtRest::new(&motion, layout.targets.len())
    } else {
        let first = Layout::read(&arrays.root, targets, &arrays.name, 0)?;
        AtRest::new(&Motion::read(&mut arrays, &first)?, layout.targets.len())
    };
    let summary = Summary {
        name: layout.name.clone(),
        vertices,
        faces: Faces { counts: vec![3; indices.len() / 3], indices },
        frames: layout.frames,
        first_time_code: layout.first_time_code,
        rate: layout.rate,
        frames_per_second: None,
        metres_per_unit: layout.metres_per_unit,
        up_axis: layout.up_axis,
        fitted: !motion.is_one_hot(layout.targets.len()),
        channels: channels(&layout),
        extents: false,
        head: motion.head.is_some(),
        stated_error: layout.stated_error,
        stated_channel_errors: layout.stated_errors.clone(),
        recipe: layout.recipe.clone(),
        clips: layout.clips.clone(),
    };
    let unread = vec![None; layout.base.len()];
    let targets = vec![unread.clone(); layout.targets.len()];
    Ok(Box::new(Animation {
        arrays,
        summary,
        layout,
        motion,
        ids,
        base: unread,
        targets,
        kept: 0,
        json,
        own,
        at_rest,
    }))
}

/// What the frames have.
fn channels(layout: &Layout) -> Vec<Channel> {
    let of_mesh = [&channel::POSITIONS, &channel::NORMALS].into_iter().zip(&layout.base);
    let of_mesh = of_mesh.filter(|(_, accessor)| accessor.is_some()).map(|(channel, _)| channel);
    of_mesh.chain(layout.attributes.iter().flat_map(|attribute| &attribute.channels)).cloned().collect()
}

/// For each vertex in the file the original that it is or copies.
fn ids(arrays: &mut Arrays, layout: &Layout) -> Result<Vec<usize>> {
    let name = arrays.name.clone();
    let fault = |what: &str| Error::malformed(format!("{name}: {what}; the file is damaged"));
    let Some(originals) = &layout.originals else {
        let accessor = layout.ids.ok_or_else(|| fault("does not number its vertices"))?;
        let numbers = arrays.vertex_ids(accessor)?;
        let count = numbers.len();
        let id = |x: f64| (x >= 0.0 && x.fract() == 0.0 && x < count as f64).then_some(x as usize);
        let ids: Option<_> = numbers.into_iter().map(id).collect();
        return ids.ok_or_else(|| fault("its _VERTEX_ID has numbers that are not vertices"));
    };
    let positions = layout.base[0].ok_or_else(|| fault("has no positions"))?;
    let (there, copies) = (arrays.count(positions)?, originals.copies.len() as u64);
    if (originals.vertices as u64).checked_add(copies) != Some(there) {
        return Err(fault(&format!(
            "has {there} vertices, expected the {} and {copies} copies that it states",
            originals.vertices
        )));
    }
    if let Some(copied) = originals.copies.iter().find(|&&copied| copied >= originals.vertices) {
        return Err(fault(&format!(
            "states a copy of vertex {copied}, expected 0 to {}",
            originals.vertices.saturating_sub(1)
        )));
    }
    // An accessor may announce more than there is. The positions are read before anything is made of the
    // number.
    arrays.vectors::<3>(positions)?;
    Ok((0..originals.vertices).chain(originals.copies.iter().copied()).collect())
}

impl Animation {
    /// W positions (`kind` 0), normals (1) or numbers of an attribute (2 and on) of a frame, as stored.
    fn evaluate(&mut self, frame: usize, kind: usize) -> Result<Vectors> {
        let missing = || Error::Internal("a file was asked for an attribute that it lacks".into());
        if self.base[kind].is_none() {
            let accessor = self.layout.base[kind].ok_or_else(missing)?;
            self.base[kind] = Some(self.vectors(accessor)?);
        }
        let mut sum = self.base[kind].clone().ok_or_else(missing)?;
        for (target, weight) in self.motion.weights_of(frame).to_vec() {
            let add = |sum: &mut Vectors, offsets: &Vectors| {
                for (sum, offset) in sum.iter_mut().flatten().zip(offsets.as_flattened()) {
                    *sum += weight * offset;
                }
            };
            if let Some(offsets) = &self.targets[target][kind] {
                add(&mut sum, offsets);
                continue;
            }
            // What is the same in all frames has no offsets.
            let Some(accessor) = self.layout.targets[target][kind] else { continue };
            let offsets = self.vectors(accessor)?;
            add(&mut sum, &offsets);
            if self.kept + 3 * offsets.len() <= KEPT {
                self.kept += 3 * offsets.len();
                self.targets[target][kind] = Some(offsets);
            }
        }
        Ok(sum)
    }

    /// Vectors of all W vertices.
    fn vectors(&mut self, accessor: usize) -> Result<Vectors> {
        let vectors = self.arrays.vectors::<3>(accessor)?;
        match vectors.len() == self.ids.len() {
            true => Ok(vectors),
            false => Err(Error::malformed(format!(
                "{}: accessor {accessor} has {} elements for {} vertices; the file is damaged",
                self.arrays.name,
                vectors.len(),
                self.ids.len()
            ))),
        }
    }

    /// Replaces `out` by the V originals' part of the W `vectors`; an error if a copy differs from its
    /// original.
    fn originals(&self, vectors: &[[f32; 3]], frame: usize, out: &mut Vec<f32>) -> Result<()> {
        let vertices = self.summary.vertices;
        if let Some(w) = (vertices..vectors.len()).find(|&w| vectors[w] != vectors[self.ids[w]]) {
            return Err(Error::malformed(format!(
                "{}: in frame {frame} (from 0), vertex {} and its copy {w} are not in the same place; the file is \
                 damaged",
                self.arrays.name, self.ids[w]
            )));
        }
        out.clear();
        out.extend(vectors[..vertices].as_flattened());
        Ok(())
    }
}

impl AnimationReader for Animation {
    fn summary(&self) -> &Summary {
        &self.summary
    }

    fn channel(&mut self, channel: &Channel, frame: usize, out: &mut Vec<f32>) -> Result<()> {
        out.clear();
        let place = self.layout.to_mesh * self.layout.node;
        if channel.name == channel::POSITIONS.name {
            // The places that a viewer gives them, in metres with Y up, brought back to mesh units.
            let vectors = self.evaluate(frame, 0)?;
            let placed =
                vectors.iter().map(|&v| place.transform_point3(DVec3::from_array(v)).as_vec3().to_array());
            return self.originals(&placed.collect::<Vec<_>>(), frame, out);
        }
        if channel.name == channel::NORMALS.name && self.layout.base[1].is_some() {
            let vectors = self.evaluate(frame, 1)?;
            let unit = |&v: &[f64; 3]| {
                let turned = place.transform_vector3(DVec3::from_array(v));
                turned.normalize_or_zero().as_vec3().to_array()
            };
            return self.originals(&vectors.iter().map(unit).collect::<Vec<_>>(), frame, out);
        }
        let has = |attribute: &Attribute| attribute.channels.iter().any(|known| known.name == channel.name);
        let Some(place) = self.layout.attributes.iter().position(has) else { return Ok(()) };
        let narrow = |numbers: &[f64; 3]| numbers.map(|x| x as f32);
        let vectors: Vec<_> = self.evaluate(frame, 2 + place)?.iter().map(narrow).collect();
        let mut all = Vec::new();
        self.originals(&vectors, frame, &mut all)?;
        *out = self.layout.attributes[place].channel(channel, &all);
        Ok(())
    }

    fn extent(&mut self, _frame: usize) -> Result<Option<[[f32; 3]; 2]>> {
        Ok(None)
    }

    fn head(&mut self, frame: usize) -> Result<Option<[[f64; 4]; 4]>> {
        let Some(keys) = &self.motion.head else { return Ok(None) };
        let motion: DMat4 = keys[frame];
        // The head pose is along glTF's axes in metres; the result is in the mesh's own axes and units.
        let to_mesh = self.layout.to_mesh;
        let columns = (to_mesh * motion * to_mesh.inverse()).to_cols_array_2d();
        Ok(Some(std::array::from_fn(|row| std::array::from_fn(|column| columns[column][row]))))
    }

    fn compare(&mut self, scene: &Scene<'_>) -> Result<Vec<String>> {
        compare::differences(&mut self.arrays, &self.json, &self.own, &self.layout, &self.at_rest, scene)
    }
}
