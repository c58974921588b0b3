//! A face's animation as USD; `docs/export.md` shows the layer.
use super::layer_writer::{Encoding, LayerWriter};
use super::sample::Sample;
use super::surface::{Surface, extent};
use crate::export::{Exporter, Frame, Scene, Written};
use crate::usd::build::{attribute, token};
use crate::usd::layer::{Attribute, Layer, Prim, Property};
use rhytid_core::{Progress, Result, RigidMotion};
use std::path::Path;

/// The numbers of the attributes that have samples.
const POINTS: usize = 0;
const EXTENT: usize = 1;
const NORMALS: usize = 2;
const VELOCITIES: usize = 3;
const HEAD: usize = 4;
const SIGMA: usize = 5;
const STRAIN: usize = 6;
const STRAIN_DIRECTIONS: [usize; 2] = [7, 8];

/// A USD file being written.
pub(crate) struct Face {
    writer: LayerWriter,
    first_time_code: f64,
    /// The head pose in each frame; empty where it is not known.
    head: Vec<RigidMotion>,
    done: usize,
}

impl Face {
    /// Writes everything that does not move.
    ///
    /// # Errors
    /// As [`LayerWriter::create`].
    pub(crate) fn create(path: &Path, encoding: Encoding, scene: &Scene<'_>) -> Result<Self> {
        let writer = LayerWriter::create(path, encoding, &layer(scene)?)?;
        let head = scene.head.unwrap_or_default().to_vec();
        Ok(Self { writer, first_time_code: scene.first_time_code, head, done: 0 })
    }
}

impl Exporter for Face {
    fn frame(&mut self, frame: Frame<'_>) -> Result<()> {
        let time = self.first_time_code + self.done as f64;
        let positions = vectors(frame.positions);
        self.writer.sample(POINTS, time, Sample::Float3s(positions))?;
        self.writer.sample(EXTENT, time, Sample::Float3s(&extent(positions)))?;
        if let Some(normals) = frame.normals {
            self.writer.sample(NORMALS, time, Sample::Float3s(vectors(normals)))?;
        }
        if let Some(velocities) = frame.velocities {
            self.writer.sample(VELOCITIES, time, Sample::Float3s(vectors(velocities)))?;
        }
        if let Some(sigma) = frame.sigma {
            self.writer.sample(SIGMA, time, Sample::Floats(sigma))?;
        }
        if let Some(strain) = frame.strain {
            self.writer.sample(STRAIN, time, Sample::Float2s(&strain.strains))?;
            for (number, directions) in STRAIN_DIRECTIONS.into_iter().zip([&strain.first, &strain.second]) {
                self.writer.sample(number, time, Sample::Float3s(directions))?;
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
        Ok(Written { bytes, targets: None, error: None })
    }
}

fn vectors(numbers: &[f32]) -> &[[f32; 3]] {
    numbers.as_chunks().0
}

/// The motion's matrix in the convention of row vectors.
pub(super) fn of_rows(motion: &RigidMotion) -> [[f64; 4]; 4] {
    let columns = motion.matrix();
    std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]))
}

/// All of the scene but the samples.
fn layer(scene: &Scene<'_>) -> Result<Layer> {
    let mut surface = Surface::new(scene, "Xform")?;
    surface.play(scene, HEAD);
    for (name, number) in [("points", POINTS), ("normals", NORMALS), ("extent", EXTENT)] {
        animate(&mut surface.mesh, name, number);
    }
    if scene.velocities {
        let velocities = attribute("vector3f[]", "velocities", None);
        surface.mesh.push(Attribute { samples: Some(VELOCITIES), ..velocities });
    }
    let sigma = [("float[]", "primvars:sigma", SIGMA)];
    let [first, second] = STRAIN_DIRECTIONS;
    let strain = [
        ("float2[]", "primvars:strain", STRAIN),
        ("vector3f[]", "primvars:strainDirection1", first),
        ("vector3f[]", "primvars:strainDirection2", second),
    ];
    let (sigma, strain) = (sigma.iter().filter(|_| scene.sigma), strain.iter().filter(|_| scene.strain));
    for &(type_name, name, number) in sigma.chain(strain) {
        surface.mesh.push(Attribute {
            metadata: vec![("interpolation".into(), token("vertex"))],
            samples: Some(number),
            ..attribute(type_name, name, None)
        });
    }
    Ok(surface.into_layer(Vec::new()))
}

/// Gives the attribute samples, if the prim has it.
fn animate(prim: &mut Prim, name: &str, number: usize) {
    for property in &mut prim.properties {
        if let Property::Attribute(attribute) = property
            && attribute.name == name
        {
            attribute.samples = Some(number);
        }
    }
}
