//! Dense meshes over time, from files of several kinds. A rig is measured against them, and examples are cut
//! out of them.

use crate::animation;
use crate::npy::{self, Array};
use rhytid_core::text::listed;
use rhytid_core::{Error, Mesh, Result};
use rhytid_export::AnimationReader;
use rhytid_meshes as mesh;
use std::path::{Path, PathBuf};

/// Frames of a mesh with the vertices of a neutral one.
pub struct Sequence {
    kept: Kept,
    frames: usize,
}

enum Kept {
    /// In a USD or glTF file.
    Animation(Box<dyn AnimationReader>),
    /// Each in a file of its own, by name.
    Meshes { files: Vec<PathBuf>, neutral: Box<Mesh>, neutral_path: PathBuf },
    /// One array, frames × V × 3.
    Array(Vec<f32>),
}

impl Sequence {
    /// Opens a sequence of one of three kinds.
    ///
    /// - A USD or glTF animation. Its unit has to be that of the neutral, `metres_per_unit`.
    /// - A NumPy array (`.npy`) of frames × V × 3 float32 or float64 in mesh units.
    /// - A folder of meshes. The frames are in the order of the names of the files.
    ///
    /// `neutral` was read from `neutral_path`.
    ///
    /// # Errors
    /// [`Error::Input`] if `path` is none of these, has no frame, or has other vertices than `neutral`;
    /// [`Error::Io`].
    pub fn open(path: &Path, neutral: &Mesh, neutral_path: &Path, metres_per_unit: f64) -> Result<Self> {
        let fault = |what: String| Err(Error::mismatch(format!("{}: {what}", path.display())));
        let vertices = neutral.positions.len();
        if path.is_dir() {
            let files = meshes_in(path)?;
            if files.is_empty() {
                return Err(Error::empty(format!(
                    "{}: has no mesh, expected one .obj, .ply, .glb or .gltf for each frame",
                    path.display()
                )));
            }
            let frames = files.len();
            let kept =
                Kept::Meshes { files, neutral: Box::new(neutral.clone()), neutral_path: neutral_path.into() };
            return Ok(Self { kept, frames });
        }
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npy")) {
            let (frames, positions) = array(path, vertices)?;
            return Ok(Self { kept: Kept::Array(positions), frames });
        }
        let reader = animation::open(path).map_err(|error| match animation::Format::from_extension(path) {
            Ok(format) if format != animation::Format::Csv => error,
            _ => error.reworded(|message| {
                format!(
                    "{message}; dense meshes over time are read from those, from .npy, or from a folder of meshes"
                )
            }),
        })?;
        let summary = reader.summary();
        if !summary.clips.is_empty() {
            return fault(format!(
                "holds the clips {}; give a file of one animation",
                listed(summary.clips.iter().map(String::as_str))
            ));
        }
        if summary.vertices != vertices {
            return fault(format!(
                "has {} vertices, but {} has {vertices}; the frames need the neutral's vertices in the same order",
                summary.vertices,
                neutral_path.display()
            ));
        }
        if (summary.metres_per_unit / metres_per_unit - 1.0).abs() > 1e-6 {
            return fault(format!(
                "its unit is {} m, but the face's is {metres_per_unit} m; export it in the face's unit",
                summary.metres_per_unit
            ));
        }
        let frames = summary.frames;
        Ok(Self { kept: Kept::Animation(reader), frames })
    }

    /// The number of frames, at least 1.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Replaces `out` by the 3V positions of a frame below [`Sequence::frames`], in mesh units.
    ///
    /// # Errors
    /// [`Error::Input`] if the frame is damaged or has other vertices or faces than the neutral;
    /// [`Error::Io`].
    pub fn positions(&mut self, frame: usize, out: &mut Vec<f32>) -> Result<()> {
        match &mut self.kept {
            Kept::Animation(reader) => reader.positions(frame, out),
            Kept::Meshes { files, neutral, neutral_path } => {
                let positions = mesh::read_like(neutral, neutral_path, &files[frame])?;
                out.clear();
                out.extend(positions.as_flattened().iter().map(|&x| x as f32));
                Ok(())
            }
            Kept::Array(positions) => {
                let per_frame = positions.len() / self.frames;
                out.clear();
                out.extend_from_slice(&positions[frame * per_frame..][..per_frame]);
                Ok(())
            }
        }
    }
}

/// The meshes of a folder by name. Other files do not matter.
fn meshes_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let io = Error::io(folder);
    let entries = std::fs::read_dir(folder).and_then(Iterator::collect::<std::io::Result<Vec<_>>>);
    let mut files: Vec<PathBuf> = entries.map_err(io)?.into_iter().map(|entry| entry.path()).collect();
    files.retain(|file| file.is_file() && mesh::Format::from_extension(file).is_ok());
    files.sort();
    Ok(files)
}

/// The frames of a NumPy array and their positions.
fn array(path: &Path, vertices: usize) -> Result<(usize, Vec<f32>)> {
    let name = path.display();
    let Array { shape, numbers } = npy::read(path)?;
    let frames = match shape[..] {
        [frames, v, 3] if frames > 0 && v == vertices => frames,
        _ => {
            return Err(Error::mismatch(format!(
                "{name}: is an array of the shape {shape:?}, expected frames × {vertices} × 3 in C order"
            )));
        }
    };
    if let Some(at) = numbers.iter().position(|x| !x.is_finite()) {
        let (frame, vertex) = (at / (3 * vertices), at / 3 % vertices);
        return Err(Error::out_of_range(format!(
            "{name}: is not finite in frame {frame} at vertex {vertex} (both from 0)"
        )));
    }
    Ok((frames, numbers))
}
