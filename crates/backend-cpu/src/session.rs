use rayon::prelude::*;
use rhytid_core::{HandleFrames, Result, Rig, Session, Stage};
use rhytid_kernels::normals::VertexTriangles;
use rhytid_kernels::{fine_scale, normals, strain, vec3};

/// Vertices that the large scale computes together: the basis is stored tile after tile, `[V/64][H][64]`, so
/// that one pass over it streams through memory and its inner loop is a whole number of SIMD registers.
const TILE: usize = 64;

/// Vertices that one task of the other kernels computes.
const VERTICES_PER_TASK: usize = 1024;

/// A rig in host memory, and the results of the last batch.
#[derive(Debug)]
pub struct CpuSession {
    handles: usize,
    frames: usize,
    fine: fine_scale::Params,
    rest: Vec<[f32; 3]>,
    handle_rest: Vec<[f32; 3]>,
    basis_tiles: Vec<[f32; TILE]>,
    triangles: Vec<[u32; 3]>,
    vertex_triangles: VertexTriangles,
    strain_edges: Vec<[u32; 2]>,
    rest_lengths: Vec<f32>,
    influence_edges: Vec<u32>,
    influence_weights: Vec<f32>,
    frame_neighbors: Vec<u32>,
    pose_features: Vec<f32>,
    rbf_weights: Vec<[f32; 3]>,

    strain: Vec<f32>,
    large_scale: Vec<[f32; 3]>,
    large_scale_normals: Vec<[f32; 3]>,
    detail: Vec<[f32; 3]>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl CpuSession {
    pub(crate) fn new(rig: &Rig, max_frames: usize) -> Self {
        let vertices = rig.vertices();
        let results = || vec![[0.0; 3]; max_frames * vertices];
        Self {
            handles: rig.handles.len(),
            frames: 0,
            fine: fine_scale::Params {
                frames: 0,
                vertices: vertices as u32,
                strain_edges: rig.strain_edges.len() as u32,
                influences: rig.influences() as u32,
                centers: rig.centers() as u32,
            },
            rest: rig.rest.clone(),
            handle_rest: rig.handles.iter().map(|&v| rig.rest[v as usize]).collect(),
            basis_tiles: tiles(&rig.basis, vertices, rig.handles.len()),
            triangles: rig.triangles.clone(),
            vertex_triangles: VertexTriangles::new(vertices, &rig.triangles),
            strain_edges: rig.strain_edges.clone(),
            rest_lengths: strain::rest_lengths(&rig.rest, &rig.handles, &rig.strain_edges),
            influence_edges: rig.influence_edges.clone(),
            influence_weights: rig.influence_weights.clone(),
            frame_neighbors: rig.frame_neighbors.clone(),
            pose_features: rig.pose_features.clone(),
            rbf_weights: rig.rbf_weights.clone(),
            strain: vec![0.0; max_frames * rig.strain_edges.len()],
            large_scale: results(),
            large_scale_normals: results(),
            detail: results(),
            positions: results(),
            normals: results(),
        }
    }

    /// The length of a per-vertex result of the current batch.
    fn values(&self) -> usize {
        self.frames * self.rest.len()
    }

    fn compute_strain(&mut self, handle_positions: &[[f32; 3]]) {
        let params = strain::Params {
            frames: self.frames as u32,
            handles: self.handles as u32,
            strain_edges: self.strain_edges.len() as u32,
        };
        strain::strain(params, handle_positions, &self.strain_edges, &self.rest_lengths, &mut self.strain);
    }

    fn compute_large_scale(&mut self, handle_positions: &[[f32; 3]]) {
        let displacements: Vec<[f32; 3]> = handle_positions
            .chunks_exact(self.handles)
            .flat_map(|p| p.iter().zip(&self.handle_rest).map(|(p, rest)| vec3::sub(*p, *rest)))
            .collect();
        let values = self.values();
        // Each task takes one tile through all frames: the basis is read once for the batch.
        let mut parts: Vec<Vec<&mut [[f32; 3]]>> = Vec::new();
        parts.resize_with(self.rest.len().div_ceil(TILE), || Vec::with_capacity(self.frames));
        for frame in self.large_scale[..values].chunks_exact_mut(self.rest.len()) {
            for (part, tile) in frame.chunks_mut(TILE).zip(&mut parts) {
                tile.push(part);
            }
        }
        parts
            .into_par_iter()
            .zip(self.basis_tiles.par_chunks(self.handles))
            .zip(self.rest.par_chunks(TILE))
            .for_each(|((frames, basis), rest)| {
                for (out, u) in frames.into_iter().zip(displacements.chunks_exact(self.handles)) {
                    let mut sum = [[0.0; TILE]; 3];
                    for (row, u) in basis.iter().zip(u) {
                        for (sum, u) in sum.iter_mut().zip(u) {
                            for lane in 0..TILE {
                                sum[lane] += row[lane] * u;
                            }
                        }
                    }
                    for (lane, (out, rest)) in out.iter_mut().zip(rest).enumerate() {
                        *out = std::array::from_fn(|c| rest[c] + sum[c][lane]);
                    }
                }
            });
    }

    fn compute_normals(&self, positions: &[[f32; 3]], normals: &mut [[f32; 3]]) {
        let frames = positions.chunks_exact(self.rest.len()).zip(normals.chunks_exact_mut(self.rest.len()));
        for (positions, normals) in frames {
            normals.par_chunks_mut(VERTICES_PER_TASK).enumerate().for_each(|(task, normals)| {
                for (i, n) in normals.iter_mut().enumerate() {
                    let incident = self.vertex_triangles.at(task * VERTICES_PER_TASK + i);
                    *n = normals::vertex_normal(positions, &self.triangles, incident);
                }
            });
        }
    }

    fn compute_fine_scale(&mut self) {
        let buffers = fine_scale::Buffers {
            influence_edges: &self.influence_edges,
            influence_weights: &self.influence_weights,
            pose_features: &self.pose_features,
            rbf_weights: &self.rbf_weights,
            frame_neighbors: &self.frame_neighbors,
        };
        let (vertices, edges) = (self.rest.len(), self.strain_edges.len());
        for frame in 0..self.frames {
            let f = &self.strain[frame * edges..][..edges];
            let all = frame * vertices..(frame + 1) * vertices;
            let smooth = &self.large_scale[all.clone()];
            let smooth_normals = &self.large_scale_normals[all.clone()];
            let detail = self.detail[all.clone()].par_chunks_mut(VERTICES_PER_TASK);
            let positions = self.positions[all].par_chunks_mut(VERTICES_PER_TASK);
            detail.zip(positions).enumerate().for_each(|(task, (detail, positions))| {
                for (i, (d, x)) in detail.iter_mut().zip(positions).enumerate() {
                    let v = task * VERTICES_PER_TASK + i;
                    let to_neighbor = vec3::sub(smooth[self.frame_neighbors[v] as usize], smooth[v]);
                    *d = fine_scale::vertex_detail(self.fine, &buffers, f, v);
                    let frame = fine_scale::local_frame(to_neighbor, smooth_normals[v]);
                    *x = fine_scale::add_detail(smooth[v], frame, *d);
                }
            });
        }
    }
}

impl Session for CpuSession {
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()> {
        self.frames = frames.frames;
        self.fine.frames = frames.frames as u32;
        let (handle_positions, _) = frames.positions.as_chunks::<3>();
        self.compute_strain(handle_positions);
        self.compute_large_scale(handle_positions);
        let values = self.values();
        let mut smooth_normals = std::mem::take(&mut self.large_scale_normals);
        self.compute_normals(&self.large_scale[..values], &mut smooth_normals[..values]);
        self.large_scale_normals = smooth_normals;
        self.compute_fine_scale();
        let mut normals = std::mem::take(&mut self.normals);
        self.compute_normals(&self.positions[..values], &mut normals[..values]);
        self.normals = normals;
        Ok(())
    }

    fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        let values = self.values();
        let result: &[f32] = match stage {
            Stage::Strain => &self.strain[..self.frames * self.strain_edges.len()],
            Stage::LargeScale => self.large_scale[..values].as_flattened(),
            Stage::LargeScaleNormals => self.large_scale_normals[..values].as_flattened(),
            Stage::Detail => self.detail[..values].as_flattened(),
            Stage::Positions => self.positions[..values].as_flattened(),
            Stage::Normals => self.normals[..values].as_flattened(),
        };
        out.clear();
        out.extend_from_slice(result);
        Ok(())
    }
}

/// B from V×H to `[V/64][H][64]`; rows past V are zero.
fn tiles(basis: &[f32], vertices: usize, handles: usize) -> Vec<[f32; TILE]> {
    let mut tiles = vec![[0.0; TILE]; vertices.div_ceil(TILE) * handles];
    for (v, row) in basis.chunks_exact(handles).enumerate() {
        for (h, &b) in row.iter().enumerate() {
            tiles[v / TILE * handles + h][v % TILE] = b;
        }
    }
    tiles
}
