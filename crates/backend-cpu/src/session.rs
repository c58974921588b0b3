use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;
use rhytid_core::{BasisStorage, HandleFrames, Result, Rig, Session, Stage, UploadOptions};
use rhytid_kernels::normals::VertexTriangles;
use rhytid_kernels::table::TILE;
use rhytid_kernels::{detail, fine_scale, normals, strain, vec3};
use std::time::{Duration, Instant};

/// Vertices that one task of the other kernels computes.
const VERTICES_PER_TASK: usize = 1024;

/// A rig in host memory, and the results of the last batch.
#[derive(Debug)]
pub struct CpuSession {
    handles: usize,
    frames: usize,
    detail_params: detail::Params,
    rest: Vec<[f32; 3]>,
    handle_rest: Vec<[f32; 3]>,
    basis: BasisTiles,
    triangles: Vec<[u32; 3]>,
    vertex_triangles: VertexTriangles,
    strain_edges: Vec<[u32; 2]>,
    rest_lengths: Vec<f32>,
    influence_edges: Vec<u32>,
    influence_weights: Vec<f32>,
    frame_neighbors: Vec<u32>,
    pose_features: Vec<f32>,
    rbf_weights: Vec<[f32; 3]>,
    pivots: Vec<u32>,

    strain: Vec<f32>,
    large_scale: Vec<[f32; 3]>,
    large_scale_normals: Vec<[f32; 3]>,
    detail: Vec<[f32; 3]>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    stage_times: [Duration; 6],
}

/// B in tiles, `[V/64][H][64]`, rows past V being zero: one pass over it streams through memory, and the inner loop of
/// the large scale is a whole number of SIMD registers.
#[derive(Debug)]
enum BasisTiles {
    F32(Vec<[f32; TILE]>),
    F16(Vec<[f16; TILE]>),
}

impl CpuSession {
    pub(crate) fn new(rig: &Rig, options: UploadOptions) -> Self {
        let max_frames = options.max_frames;
        let vertices = rig.vertices();
        let (rbf_weights, pivots) = detail::pivoted(&rig.rbf_weights, rig.centers());
        let results = || vec![[0.0; 3]; max_frames * vertices];
        Self {
            handles: rig.handles.len(),
            frames: 0,
            detail_params: detail::Params::whole(
                0,
                vertices,
                rig.strain_edges.len(),
                rig.influences(),
                rig.centers(),
            ),
            rest: rig.rest.clone(),
            handle_rest: rig.handles.iter().map(|&v| rig.rest[v as usize]).collect(),
            basis: BasisTiles::new(rig, options.basis),
            triangles: rig.triangles.clone(),
            vertex_triangles: VertexTriangles::new(vertices, &rig.triangles),
            strain_edges: rig.strain_edges.clone(),
            rest_lengths: strain::rest_lengths(&rig.rest, &rig.handles, &rig.strain_edges),
            influence_edges: rig.influence_edges.clone(),
            influence_weights: rig.influence_weights.clone(),
            frame_neighbors: rig.frame_neighbors.clone(),
            pose_features: rig.pose_features.clone(),
            rbf_weights,
            pivots,
            strain: vec![0.0; max_frames * rig.strain_edges.len()],
            large_scale: results(),
            large_scale_normals: results(),
            detail: results(),
            positions: results(),
            normals: results(),
            stage_times: Default::default(),
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
        strain::strain(
            params,
            handle_positions,
            &self.handle_rest,
            &self.strain_edges,
            &self.rest_lengths,
            &mut self.strain,
        );
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
        parts.into_par_iter().zip(self.rest.par_chunks(TILE)).enumerate().for_each_init(
            Vec::new,
            |widened, (tile, (frames, rest))| {
                let basis = self.basis.tile(tile, self.handles, widened);
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
            },
        );
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

    fn compute_detail(&mut self) {
        let buffers = detail::Buffers {
            influence_edges: &self.influence_edges,
            influence_weights: &self.influence_weights,
            pose_features: &self.pose_features,
            rbf_weights: &self.rbf_weights,
            pivots: &self.pivots,
        };
        let (vertices, edges) = (self.rest.len(), self.strain_edges.len());
        for (frame, detail) in self.detail[..self.frames * vertices].chunks_exact_mut(vertices).enumerate() {
            let f = &self.strain[frame * edges..][..edges];
            detail.par_chunks_mut(VERTICES_PER_TASK).enumerate().for_each(|(task, detail)| {
                for (i, d) in detail.iter_mut().enumerate() {
                    *d = detail::vertex_detail(self.detail_params, &buffers, f, task * VERTICES_PER_TASK + i);
                }
            });
        }
    }

    fn compute_fine_scale(&mut self) {
        let vertices = self.rest.len();
        for frame in 0..self.frames {
            let all = frame * vertices..(frame + 1) * vertices;
            let smooth = &self.large_scale[all.clone()];
            let smooth_normals = &self.large_scale_normals[all.clone()];
            let detail = self.detail[all.clone()].par_chunks(VERTICES_PER_TASK);
            let positions = self.positions[all].par_chunks_mut(VERTICES_PER_TASK);
            detail.zip(positions).enumerate().for_each(|(task, (detail, positions))| {
                for (i, (d, x)) in detail.iter().zip(positions).enumerate() {
                    let v = task * VERTICES_PER_TASK + i;
                    let to_neighbor = vec3::sub(smooth[self.frame_neighbors[v] as usize], smooth[v]);
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
        let mut last = Instant::now();
        let mut stage_times = Vec::with_capacity(6);
        let mut finished = || {
            let now = Instant::now();
            stage_times.push(now - std::mem::replace(&mut last, now));
        };
        let (handle_positions, _) = frames.positions.as_chunks::<3>();
        self.compute_strain(handle_positions);
        finished();
        self.compute_large_scale(handle_positions);
        finished();
        let values = self.values();
        let mut smooth_normals = std::mem::take(&mut self.large_scale_normals);
        self.compute_normals(&self.large_scale[..values], &mut smooth_normals[..values]);
        self.large_scale_normals = smooth_normals;
        finished();
        self.compute_detail();
        finished();
        self.compute_fine_scale();
        finished();
        let mut normals = std::mem::take(&mut self.normals);
        self.compute_normals(&self.positions[..values], &mut normals[..values]);
        self.normals = normals;
        finished();
        self.stage_times.copy_from_slice(&stage_times);
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

    fn stage_times(&mut self) -> Result<Option<[Duration; 6]>> {
        Ok(Some(self.stage_times))
    }
}

impl BasisTiles {
    fn new(rig: &Rig, storage: BasisStorage) -> Self {
        let (vertices, handles) = (rig.vertices(), rig.handles.len());
        match storage {
            BasisStorage::F32 => Self::F32(tiles(&rig.basis, vertices, handles, |b| b)),
            BasisStorage::F16 => Self::F16(tiles(&rig.basis, vertices, handles, f16::from_f32)),
        }
    }

    /// The H rows of one tile; `widened` is room for them where they are stored in halves.
    fn tile<'a>(
        &'a self,
        tile: usize,
        handles: usize,
        widened: &'a mut Vec<[f32; TILE]>,
    ) -> &'a [[f32; TILE]] {
        match self {
            Self::F32(rows) => &rows[tile * handles..][..handles],
            Self::F16(rows) => {
                widened.resize(handles, [0.0; TILE]);
                for (row, halves) in widened.iter_mut().zip(&rows[tile * handles..]) {
                    halves.convert_to_f32_slice(row);
                }
                widened
            }
        }
    }
}

/// B from V×H to `[V/64][H][64]`.
fn tiles<T: Copy + Default>(
    basis: &[f32],
    vertices: usize,
    handles: usize,
    round: impl Fn(f32) -> T,
) -> Vec<[T; TILE]> {
    let mut tiles = vec![[T::default(); TILE]; vertices.div_ceil(TILE) * handles];
    for (v, row) in basis.chunks_exact(handles).enumerate() {
        for (h, &b) in row.iter().enumerate() {
            tiles[v / TILE * handles + h][v % TILE] = round(b);
        }
    }
    tiles
}
