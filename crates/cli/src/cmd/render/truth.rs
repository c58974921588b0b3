//! The truth that pictures are compared with.

use super::shape::Shape;
use crate::args;
use rayon::prelude::*;
use rhytid::core::Mesh;
use rhytid::formats::sequence::Sequence;
use rhytid::formats::tables;
use rhytid::{Error, Result, Rig, Take, evaluate};
use rhytid_kernels::normals::{VertexTriangles, vertex_normal};
use std::ops::Range;
use std::path::Path;

/// Dense meshes, and the frames of the take that they show.
pub(super) struct Truth {
    meshes: Sequence,
    frames: Vec<usize>,
    triangles: Vec<[u32; 3]>,
    at_vertices: VertexTriangles,
    positions: Vec<f32>,
    normals: Vec<f32>,
}

impl Truth {
    /// The truth in `path` for a take on a rig, matched as in `evaluate`.
    ///
    /// # Errors
    /// As [`Sequence::open`] and [`evaluate::Truth::new`].
    pub(super) fn open(path: &Path, args: &args::Render, rig: &Rig, take: &Take) -> Result<Self> {
        let neutral = Mesh {
            positions: rig.surface().rest.iter().map(|x| x.map(f64::from)).collect(),
            faces: rig.surface().faces.clone(),
            uvs: rig.surface().uvs.clone(),
            materials: rig.surface().materials.clone(),
        };
        let meshes = Sequence::open(path, &neutral, &args.rig, rig.surface().metres_per_unit)?;
        let frames = args.truth_frames.as_ref().map(|path| tables::read_frames(path, take.frames()));
        let evaluate::Truth { meshes, frames, .. } =
            evaluate::Truth::new(meshes, frames.transpose()?, take.clone())?;
        let truth = Self {
            meshes,
            frames,
            at_vertices: rig.surface().vertex_triangles(),
            triangles: rig.surface().triangles.clone(),
            positions: Vec::new(),
            normals: Vec::new(),
        };
        Ok(truth)
    }

    /// The frames of a range that the truth has, rising.
    ///
    /// # Errors
    /// [`Error::Input`] if there is none.
    pub(super) fn within(&self, range: Range<usize>) -> Result<Vec<usize>> {
        let mut frames: Vec<usize> =
            self.frames.iter().copied().filter(|frame| range.contains(frame)).collect();
        frames.sort_unstable();
        frames.dedup();
        match frames.is_empty() {
            true => Err(Error::out_of_range(format!(
                "--frames {}..{}: the truth has none of these; its first is {}",
                range.start,
                range.end,
                self.frames.iter().min().copied().unwrap_or_default()
            ))),
            false => Ok(frames),
        }
    }

    /// The true shape of one of its frames of the take, with normals computed as a rig's.
    ///
    /// # Errors
    /// As [`Sequence::positions`].
    pub(super) fn frame(&mut self, frame: usize) -> Result<Shape<'_>> {
        let mesh = self.frames.iter().position(|own| *own == frame);
        let mesh = mesh.ok_or_else(|| Error::Internal(format!("the truth has no frame {frame}")))?;
        self.meshes.positions(mesh, &mut self.positions)?;
        let (points, _) = self.positions.as_chunks::<3>();
        let normal = |v: usize| vertex_normal(points, &self.triangles, self.at_vertices.at(v));
        let normals: Vec<[f32; 3]> = (0..points.len()).into_par_iter().map(normal).collect();
        self.normals = normals.into_flattened();
        Ok(Shape { positions: &self.positions, normals: &self.normals })
    }
}
