//! Meshes that are shown without a rig: as they are, or with the frames of an animation file.

use crate::same::Same;
use rhytid_core::{
    Error, Examples, Faces, FineScale, HandleSet, Influences, Materials, Mesh, Progress, Result, Rig,
    RigParts, Surface, SurfacePoint, Table, UpAxis, Uvs, VertexId,
};
use rhytid_formats::animation;
use rhytid_formats::export::AnimationReader;
use rhytid_formats::mesh::{self, Selection, Shapes, Space};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// The height of a head in metres, for meshes whose files state no unit.
const HEAD: f64 = 0.25;

/// A mesh that was opened.
#[derive(Debug)]
pub(crate) struct OpenMesh {
    pub name: String,
    /// The mesh as the surface of a rig that moves nothing. Nobody evaluates it.
    pub rig: Arc<Rig>,
    pub frames: Same<MeshFrames>,
    /// What is shown, and what could be done next.
    pub words: String,
}

/// The frames of a mesh. They are read when they are shown.
pub(crate) struct MeshFrames {
    /// 3V positions of the mesh at rest.
    rest: Vec<f32>,
    /// The times of the frames in seconds, at least one.
    pub times: Vec<f64>,
    /// Frames per second.
    pub rate: f64,
    /// `None` for a mesh that does not move.
    reader: Option<Mutex<Box<dyn AnimationReader>>>,
}

impl std::fmt::Debug for MeshFrames {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} frames of {} vertices", self.times.len(), self.rest.len() / 3)
    }
}

impl MeshFrames {
    /// Replaces `out` by the 3V positions of a frame, in mesh units.
    ///
    /// # Errors
    /// As [`AnimationReader::positions`].
    pub(crate) fn read(&self, frame: usize, out: &mut Vec<f32>) -> Result<()> {
        match &self.reader {
            Some(reader) => reader.lock().unwrap_or_else(PoisonError::into_inner).positions(frame, out),
            None => {
                out.clone_from(&self.rest);
                Ok(())
            }
        }
    }
}

/// Opens a mesh, or an animation that Rhytid exported.
///
/// # Errors
/// [`Error::Input`] if the file is no mesh; [`Error::Io`].
pub(crate) fn read(path: &Path, progress: &dyn Progress) -> Result<OpenMesh> {
    let may_move = matches!(mesh::Format::from_extension(path)?, mesh::Format::Gltf | mesh::Format::Usd);
    progress.report("read the mesh", 0, 1);
    let opened = match may_move.then(|| animation::open(path)) {
        Some(Ok(reader)) => moving(path, reader),
        Some(Err(why)) => still(path, Some(why)),
        None => still(path, None),
    };
    progress.report("read the mesh", 1, 1);
    opened
}

/// A mesh that does not move. `why` it was not an animation is said as well.
fn still(path: &Path, why: Option<Error>) -> Result<OpenMesh> {
    let name = path.display().to_string();
    let Shapes { neutral, shapes, space, .. } = mesh::read_file(path, &Selection::default(), true)?;
    let rest: Vec<[f32; 3]> = neutral.positions.iter().map(|p| p.map(|x| x as f32)).collect();
    let mut words = format!(
        "{name}: is a mesh of {} vertices without markers; to drag it, make a project of it and \
         open the project",
        rest.len()
    );
    match shapes.len() {
        0 => {}
        1 => words += "; its 1 blend shape becomes an example",
        many => words += &format!("; its {many} blend shapes become examples"),
    }
    if let Some(why) = why {
        words += &format!(". It is shown at rest: {why}");
    }
    let frames =
        MeshFrames { rest: rest.as_flattened().to_vec(), times: vec![0.0], rate: 30.0, reader: None };
    let Mesh { faces, uvs, materials, .. } = neutral;
    let surface = Drawn { rest, faces, uvs, materials, space };
    Ok(OpenMesh { rig: Arc::new(surface.rig(&name)?), frames: Same::new(frames), words, name })
}

/// An animation.
fn moving(path: &Path, mut reader: Box<dyn AnimationReader>) -> Result<OpenMesh> {
    let name = path.display().to_string();
    let mut rest = Vec::new();
    reader.positions(0, &mut rest)?;
    let summary = reader.summary();
    if summary.faces.is_empty() {
        return Err(Error::empty(format!(
            "{name}: goes over another file, which has its faces; open that file, or export the animation whole"
        )));
    }
    let words = format!(
        "{name}: is an animation of {} frames, played as the file has it, without markers; to drag it, open its \
         rig and its take",
        summary.frames
    );
    let (frames, rate) = (summary.frames, summary.rate);
    let space = Space { metres_per_unit: Some(summary.metres_per_unit), up: Some(summary.up_axis) };
    let surface = Drawn {
        rest: rest.as_chunks::<3>().0.to_vec(),
        faces: summary.faces.clone(),
        uvs: None,
        materials: None,
        space,
    };
    let frames = MeshFrames {
        rest,
        times: (0..frames).map(|frame| frame as f64 / rate).collect(),
        rate,
        reader: Some(Mutex::new(reader)),
    };
    Ok(OpenMesh { rig: Arc::new(surface.rig(&name)?), frames: Same::new(frames), words, name })
}

/// What is drawn of a mesh.
struct Drawn {
    rest: Vec<[f32; 3]>,
    faces: Faces,
    uvs: Option<Uvs>,
    materials: Option<Materials>,
    space: Space,
}

impl Drawn {
    /// A rig of this surface. Its one handle moves nothing.
    fn rig(self, name: &str) -> Result<Rig> {
        let Self { rest, faces, uvs, materials, space } = self;
        let count = rest.len();
        let positions = rest.iter().map(|p| p.map(f64::from)).collect();
        let triangles =
            rhytid_geometry::triangulate(&Mesh { positions, faces: faces.clone(), ..Mesh::default() });
        let tall = |c: usize| {
            let along = rest.iter().map(|p| f64::from(p[c]));
            along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
        };
        let up = space.up.unwrap_or_default();
        let height = tall(if up == UpAxis::Z { 2 } else { 1 });
        // The light in skin depends on the unit, and nothing else does.
        let guessed = if height > 0.0 { HEAD / height } else { 1.0 };
        let surface = Surface {
            name: "mesh".to_owned(),
            metres_per_unit: space.metres_per_unit.unwrap_or(guessed),
            up_axis: up,
            faces,
            uvs,
            materials,
            triangles,
            tangent_neighbors: (0..count).map(VertexId::from_index).collect(),
            joined: None,
            rest,
        };
        let handles = HandleSet {
            labels: vec!["none".to_owned()],
            points: vec![SurfacePoint::from(VertexId::from_index(0))],
            rest: vec![surface.rest[0]],
            strain_edges: Vec::new(),
            rotations: false,
        };
        let parts = RigParts {
            surface,
            handles,
            examples: Examples { names: Vec::new(), handles: Table::new(0, 1, Vec::new()) },
            bending_length: 0.0,
            basis: Table::filled(count, 1, 0.0),
            influences: Influences {
                edges: Table::new(count, 0, Vec::new()),
                weights: Table::new(count, 0, Vec::new()),
                beta: 0.0,
            },
            fine_scale: FineScale {
                pose_features: Table::new(1, 0, Vec::new()),
                rbf_weights: Table::filled(count, 1, [0.0; 3]),
            },
            learned: None,
        };
        Rig::new(parts).map_err(|error| error.in_file(name))
    }
}
