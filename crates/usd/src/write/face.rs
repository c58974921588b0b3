//! A face's animation as USD; `docs/export.md` shows the layer.
use super::choices::Choices;
use super::layer_writer::{Encoding, LayerWriter};
use super::sample::Sample;
use super::surface::{Surface, extent};
use super::textures;
use crate::build::{attribute, token};
use crate::channels;
use crate::layer::{Attribute, Layer, Prim, Property};
use rhytid_core::channel::{self, Channel};
use rhytid_core::{Error, Progress, Result, RigidMotion};
use rhytid_export::{Exporter, Frame, Options, Scene, Written};
use std::path::Path;

/// The numbers of the attributes that have samples, beside those of the channels, which come after them.
const EXTENT: usize = 0;
const HEAD: usize = 1;
const CHANNELS: usize = 2;

/// A USD file being written.
pub struct Face {
    writer: LayerWriter,
    first_time_code: f64,
    /// Positions, and what else each frame has.
    channels: Vec<Channel>,
    /// The head pose in each frame; empty where it is not known.
    head: Vec<RigidMotion>,
    done: usize,
}

impl Face {
    /// Writes everything that does not move.
    ///
    /// # Errors
    /// As [`LayerWriter::create`]; [`Error::Input`] for a channel of so many numbers that USD has no type for
    /// it, or for textures where this encoding has no place for them.
    pub fn create(path: &Path, encoding: Encoding, scene: &Scene<'_>, options: &Options) -> Result<Self> {
        let channels: Vec<Channel> =
            std::iter::once(&channel::POSITIONS).chain(scene.channels).cloned().collect();
        let (assets, attached) = textures::place(path, encoding, scene, options)?;
        let layer = layer(scene, &channels, &Choices::new(options, assets))?;
        let writer = LayerWriter::with(path, encoding, &layer, attached)?;
        let head = scene.head.unwrap_or_default().to_vec();
        Ok(Self { writer, first_time_code: scene.first_time_code, channels, head, done: 0 })
    }
}

impl Exporter for Face {
    fn frame(&mut self, frame: &Frame<'_>) -> Result<()> {
        let time = self.first_time_code + self.done as f64;
        for (i, channel) in self.channels.iter().enumerate() {
            let Some(numbers) = frame.get(channel) else { continue };
            let sample = match channel.width {
                1 => Sample::Floats(numbers),
                2 => Sample::Float2s(numbers.as_chunks().0),
                _ => Sample::Float3s(numbers.as_chunks().0),
            };
            self.writer.sample(CHANNELS + i, time, sample)?;
            if channel.name == channel::POSITIONS.name {
                self.writer.sample(EXTENT, time, Sample::Float3s(&extent(numbers.as_chunks().0)))?;
            }
        }
        if let Some(motion) = self.head.get(self.done) {
            self.writer.sample(HEAD, time, Sample::Matrix4d(&of_rows(motion)))?;
        }
        self.done += 1;
        Ok(())
    }

    fn finish(self: Box<Self>, _progress: &dyn Progress) -> Result<Written> {
        let bytes = self.writer.finish()?;
        Ok(Written { bytes, targets: None, errors: Vec::new() })
    }
}

/// The motion's matrix in the convention of row vectors.
pub(super) fn of_rows(motion: &RigidMotion) -> [[f64; 4]; 4] {
    let columns = motion.matrix();
    std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]))
}

/// The layer of an export, without the samples.
///
/// # Errors
/// As [`Face::create`].
pub(crate) fn animation_layer(scene: &Scene<'_>, choices: &Choices) -> Result<Layer> {
    let channels: Vec<Channel> =
        std::iter::once(&channel::POSITIONS).chain(scene.channels).cloned().collect();
    layer(scene, &channels, choices)
}

/// All of the scene but the samples.
fn layer(scene: &Scene<'_>, channels: &[Channel], choices: &Choices) -> Result<Layer> {
    let mut surface = Surface::new(scene, "Xform", choices)?;
    surface.play(scene, HEAD);
    animate(&mut surface.mesh, "extent", EXTENT);
    for (number, channel) in (CHANNELS..).zip(channels) {
        let name = channels::name(channel);
        // Points and normals are there at rest.
        if animate(&mut surface.mesh, &name, number) {
            continue;
        }
        let type_name = channels::type_name(channel).map_err(|width| {
            Error::unsupported_format(format!(
                "the channel {}: {width} numbers at a vertex, for which USD has no type",
                channel.name
            ))
        })?;
        let mut animated = Attribute { samples: Some(number), ..attribute(type_name, &name, None) };
        if channels::is_primvar(channel) {
            animated.metadata.push(("interpolation".into(), token(channel.interpolation.name())));
        }
        surface.mesh.push(animated);
    }
    Ok(surface.into_layer(Vec::new()))
}

/// Gives the attribute samples, if the prim has it.
fn animate(prim: &mut Prim, name: &str, number: usize) -> bool {
    for property in &mut prim.properties {
        if let Property::Attribute(attribute) = property
            && attribute.name == name
        {
            attribute.samples = Some(number);
            return true;
        }
    }
    false
}
