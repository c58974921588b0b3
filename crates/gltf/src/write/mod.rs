//! Animations and shapes as glTF: a base mesh and morph targets.

mod animation;
mod buffers;
mod clips;
mod compressed;
mod container;
mod document;
mod exact;
mod grid;
mod materials;
mod measure;
mod quantized;
mod shapes;
mod surface;
mod targets;

use super::attributes::Attribute;
use compressed::Goal;
use document::Document;
use rhytid_core::{Error, Result};
use rhytid_export::{Exporter, Options, Scene};
use std::path::Path;

pub(crate) use animation::head_node;
pub use container::Kind;
pub(crate) use document::{About, Placement, extensions, placed};
pub(crate) use materials::Looks;
pub use shapes::{check_count, write_shapes};
pub(crate) use surface::Surface;

/// Opens an exporter; `scene` has been checked.
///
/// # Errors
/// [`rhytid_core::Error::Input`] if the file could not hold the scene, or would be larger than `options`
/// allow; [`rhytid_core::Error::Io`].
pub fn create(path: &Path, kind: Kind, scene: &Scene<'_>, options: &Options) -> Result<Box<dyn Exporter>> {
    let goal = match (&options.onto, options.shapes, options.max_error) {
        (Some(set), ..) => {
            check_count(path, set.shapes.len(), options)?;
            Some(Goal::Onto(set.clone()))
        }
        (None, Some(shapes), _) => {
            check_count(path, shapes, options)?;
            Some(Goal::Shapes(shapes))
        }
        (None, None, Some(max_error)) => Some(Goal::Within(max_error)),
        (None, None, None) => None,
    };
    let mut attributes = Attribute::of_channels(scene.channels);
    if goal.is_some() {
        attributes.retain(Attribute::can_be_fitted);
    } else {
        exact::check_frames(path, kind, scene, &attributes, options)?;
    }
    if let Some(attribute) = attributes.first().filter(|_| options.onto.is_some()) {
        let channels: Vec<&str> = attribute.channels.iter().map(|channel| &*channel.name).collect();
        return Err(Error::conflict(format!(
            "{}: shapes that are given say nothing of {}; leave these channels out",
            path.display(),
            channels.join(", ")
        )));
    }
    let about = About::new(scene).with_attributes(&attributes);
    let document = Document::create(path, kind, scene, options, about)?;
    match goal {
        Some(goal) => Ok(Box::new(compressed::Compressed::new(document, scene, attributes, options, goal)?)),
        None if options.quantize => {
            Ok(Box::new(quantized::Quantized::new(document, scene, attributes, options)?))
        }
        None => Ok(Box::new(exact::Exact::new(document, scene, attributes, options))),
    }
}
