//! Animations and shapes as glTF: a base mesh and morph targets.

mod animation;
mod buffers;
mod compressed;
mod container;
mod document;
mod exact;
mod grid;
mod measure;
mod quantized;
mod shapes;
mod surface;

use super::morphs::Values;
use crate::export::{Exporter, Options, Scene};
use buffers::Buffers;
use container::{Container, Limit};
use document::{About, Document, MOST_VERTICES};
use rhytid_core::{Error, Result};
use std::path::Path;
use surface::Surface;

pub(crate) use shapes::write_shapes;

/// What WebGL2 promises, and more than most programs show as sliders.
const MOST_TARGETS: usize = 256;

/// The two kinds of file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Format {
    /// All in one.
    Glb,
    /// JSON, with its numbers beside it.
    Gltf,
}

/// Opens an exporter; `scene` has been checked.
///
/// # Errors
/// [`Error::Input`] if the file could not hold the scene, or would be larger than `options` allow; [`Error::Io`].
pub(crate) fn create(
    path: &Path,
    format: Format,
    scene: &Scene<'_>,
    options: &Options,
) -> Result<Box<dyn Exporter>> {
    if let Some(max_error) = options.max_error {
        let document = document(path, format, scene, options, About::new(scene).with_time(scene))?;
        return Ok(Box::new(compressed::Compressed::new(document, scene, options, max_error)?));
    }
    exact::check_frames(path, format, scene, options)?;
    let document = document(path, format, scene, options, About::new(scene).with_time(scene))?;
    match options.quantize {
        true => Ok(Box::new(quantized::Quantized::new(document, scene)?)),
        false => Ok(Box::new(exact::Exact::new(document, scene))),
    }
}

/// An empty file for the mesh of `scene`.
fn document(
    path: &Path,
    format: Format,
    scene: &Scene<'_>,
    options: &Options,
    about: About,
) -> Result<Document> {
    let surface = Surface::new(scene.rest.len(), scene.faces, scene.triangle_corners, scene.uvs);
    if scene.rest.len() > MOST_VERTICES {
        return Err(Error::input(format!(
            "{}: has {} vertices, and a glTF file can number {MOST_VERTICES}; write .usd instead",
            path.display(),
            scene.rest.len()
        )));
    }
    let container = Container::create(path, format, limit(format, options))?;
    let buffers = Buffers::new(container, options.meshopt);
    Ok(Document::new(buffers, about, surface, options.quantize))
}

/// How large a file may become.
fn limit(format: Format, options: &Options) -> Limit {
    match (options.force, format) {
        (false, _) => Limit {
            bytes: 1 << 30,
            sentence: "1 GiB, more than viewers are made for: write .usd, choose fewer frames with --frames, make it \
                       smaller with --compressed, --quantize or --meshopt, or insist with --force",
        },
        (true, Format::Glb) => Limit {
            bytes: u64::from(u32::MAX),
            sentence: "4 GiB, where a GLB file ends: write .usd or .gltf, choose fewer frames with --frames, or make \
                       it smaller with --compressed, --quantize or --meshopt",
        },
        (true, Format::Gltf) => Limit { bytes: u64::MAX, sentence: "any disk" },
    }
}

/// Base normals of 3V coordinates: glTF demands a direction even where there is none.
fn unit_normals(normals: &[f32]) -> Vec<f32> {
    let unit = |&normal: &[f32; 3]| if normal == [0.0; 3] { [0.0, 0.0, 1.0] } else { normal };
    normals.as_chunks::<3>().0.iter().flat_map(unit).collect()
}

/// `to` − `from`.
fn differences(from: &[f32], to: &[f32]) -> Vec<f32> {
    from.iter().zip(to).map(|(from, to)| to - from).collect()
}

/// What is to be added to the normals `from` for the directions `to`. Where there is none (a vector of 0), the base's
/// stays: viewers normalise the sum, and 0 has no direction.
fn normal_differences(from: &[f32], to: &[f32]) -> Vec<f32> {
    let pairs = from.as_chunks::<3>().0.iter().zip(to.as_chunks::<3>().0);
    let offset = |(from, to): (&[f32; 3], &[f32; 3])| match *to == [0.0; 3] {
        true => [0.0; 3],
        false => std::array::from_fn(|axis| to[axis] - from[axis]),
    };
    pairs.flat_map(offset).collect()
}

/// The name of the target that is frame `frame`.
fn frame_name(first_time_code: f64, frame: usize) -> String {
    format!("frame {:04}", first_time_code + frame as f64)
}

/// An error where an offset of 3V `offsets` overflows.
fn check_finite(offsets: &[f32], frame: usize, path: &Path) -> Result<()> {
    match offsets.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(i) => Err(Error::input(format!(
            "{}: in frame {frame} (from 0), vertex {} is farther from its place in frame 0 than a 32-bit number holds",
            path.display(),
            i / 3
        ))),
    }
}

/// 32-bit `values`, for an attribute.
fn floats(values: Vec<f32>) -> Values {
    Values::F32(values)
}
