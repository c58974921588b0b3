//! A target for each frame, written as the frames come.

use super::animation::Weights;
use super::clips::Clips;
use super::container::{Kind, Limit};
use super::document::{Document, Placement};
use super::measure::Measure;
use super::targets::{
    check_finite, differences, floats, frame_name, most_targets, normal_differences,
    targets_that_viewers_show, unit_normals,
};
use crate::attributes::Attribute;
use rhytid_core::{Error, Progress, Remedy, Result, channel};
use rhytid_export::{Exporter, Frame, Options, Scene, Written};
use std::path::Path;

/// The weights are a square matrix whose elements are numbered by `u32`.
const MOST_FRAMES: usize = 65_535;

/// JSON for a target: its accessors, views and name.
const JSON_PER_TARGET: u64 = 700;

/// The base is the first frame, target k is frame k, and its weight is 1 in that frame and 0 in all others.
pub(super) struct Exact {
    document: Document,
    clips: Clips,
    first_time_code: f64,
    /// 3V positions of the first frame, and its normals.
    base: Vec<f32>,
    base_normals: Vec<f32>,
    attributes: Vec<Attribute>,
    others: OtherTargets,
    measure: Measure,
}

/// The further attributes of the mesh and its targets, of frame after frame. The base has those of the first
/// frame.
pub(super) struct OtherTargets {
    attributes: Vec<Attribute>,
    base: Vec<Vec<f32>>,
}

impl OtherTargets {
    pub(super) fn new(attributes: Vec<Attribute>) -> Self {
        Self { attributes, base: Vec::new() }
    }

    /// Adds `of_frame`, 3V numbers for each attribute, to the target that was written last, and to the base
    /// that of the first.
    pub(super) fn write(&mut self, document: &mut Document, of_frame: Vec<Vec<f32>>) -> Result<()> {
        if self.base.is_empty() {
            for (attribute, numbers) in self.attributes.iter().zip(&of_frame) {
                document.base_extra(&attribute.name, numbers.clone())?;
            }
            self.base.clone_from(&of_frame);
        }
        for ((attribute, base), numbers) in self.attributes.iter().zip(&self.base).zip(&of_frame) {
            if !attribute.is_constant() {
                document.target_extra(&attribute.name, differences(base, numbers))?;
            }
        }
        Ok(())
    }
}

impl Exact {
    pub(super) fn new(
        document: Document,
        scene: &Scene<'_>,
        attributes: Vec<Attribute>,
        options: &Options,
    ) -> Self {
        Self {
            document,
            clips: Clips::new(scene, options),
            first_time_code: scene.first_time_code,
            base: Vec::new(),
            base_normals: Vec::new(),
            attributes: attributes.clone(),
            others: OtherTargets::new(attributes),
            measure: Measure::default(),
        }
    }
}

impl Exporter for Exact {
    fn frame(&mut self, frame: &Frame<'_>) -> Result<()> {
        let k = self.document.targets();
        let (positions, normals) = (frame.positions(), frame.get(&channel::NORMALS));
        if k == 0 {
            self.base = positions.to_vec();
            self.base_normals = normals.map(unit_normals).unwrap_or_default();
            let normals = normals.map(|_| floats(self.base_normals.clone()));
            self.document.base(&floats(self.base.clone()), normals.as_ref())?;
        }
        let offsets = differences(&self.base, positions);
        check_finite(&offsets, k, self.document.path())?;
        let vectors = |numbers| <[f32]>::as_chunks::<3>(numbers).0;
        let stored = vectors(&self.base).iter().zip(vectors(&offsets));
        for (v, (given, (base, offset))) in vectors(positions).iter().zip(stored).enumerate() {
            let stored = std::array::from_fn(|axis| f64::from(base[axis]) + f64::from(offset[axis]));
            self.measure.add(k, v, given.map(f64::from), stored);
        }
        let normals = normals.map(|normals| floats(normal_differences(&self.base_normals, normals)));
        self.document.target(frame_name(self.first_time_code, k), &floats(offsets), normals.as_ref())?;
        let of_frame = self.attributes.iter().map(|attribute| attribute.of_frame(frame)).collect();
        self.others.write(&mut self.document, of_frame)
    }

    fn finish(self: Box<Self>, progress: &dyn Progress) -> Result<Written> {
        let first = Some(first_of_all(self.document.targets()));
        let clips = self.clips.of_one(Weights::OneHot, self.measure.deviation(0.0));
        self.document.finish(Placement::NONE, first, clips, progress)
    }
}

/// The weights of `frames` targets in the first frame, which is the first target.
pub(super) fn first_of_all(frames: usize) -> Vec<f32> {
    (0..frames).map(|k| if k == 0 { 1.0 } else { 0.0 }).collect()
}

/// An error if the frames of `scene` are more than the file may hold, as far as can be told before they come.
pub(super) fn check_frames(
    path: &Path,
    kind: Kind,
    scene: &Scene<'_>,
    attributes: &[Attribute],
    options: &Options,
) -> Result<()> {
    let frames = scene.frames;
    let most = most_targets(options);
    if frames > most {
        return Err(Error::too_large(format!(
            "{}: {frames} frames with a morph target each are more than {}: write .usd, choose fewer frames, \
             compress to fewer targets, or lift the limit",
            path.display(),
            targets_that_viewers_show(most)
        ))
        .with_remedies(&[Remedy::FewerFrames, Remedy::Compress, Remedy::MostTargets, Remedy::Force]));
    }
    if frames > MOST_FRAMES {
        return Err(Error::too_large(format!(
            "{}: {frames} frames with a morph target each are more than the {MOST_FRAMES} targets that a \
             glTF file holds: write .usd, choose fewer frames, or compress to fewer targets",
            path.display()
        ))
        .with_remedies(&[Remedy::FewerFrames, Remedy::Compress]));
    }
    if options.meshopt {
        // The compressed size is known only later.
        return Ok(());
    }
    let bytes_of = |float: u64, integer: u64| if options.quantize { integer } else { float };
    let of_normals = if scene.rest_normals.is_some() { bytes_of(12, 4) } else { 0 };
    let per_vertex = bytes_of(12, 8) + of_normals + 12 * attributes.len() as u64;
    // Copies of vertices at seams come on top. Each frame has a weight for each target.
    let per_frame = scene.rest.len() as u64 * per_vertex + JSON_PER_TARGET + 4 * frames as u64;
    let limit = Limit::new(kind, options);
    // The base mesh, and then the frames.
    let fit = (limit.bytes / per_frame).saturating_sub(1);
    match frames as u64 <= fit {
        true => Ok(()),
        false => Err(Error::too_large(format!(
            "{}: {frames} frames of {} vertices become larger than {} (about {fit} frames fit)",
            path.display(),
            scene.rest.len(),
            limit.sentence
        ))
        .with_remedies(limit.remedies)),
    }
}
