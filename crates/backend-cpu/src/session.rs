use crate::blocks::BLOCK;
use crate::detail::Detail;
use crate::large_scale::BasisTiles;
use crate::normals::Normals;
use crate::simd::widest;
use rayon::prelude::*;
use rhytid_core::{HandleFrames, Result, Rig, Session, Stage, UploadOptions};
use rhytid_kernels::{fine_scale, strain, vec3};
use std::time::{Duration, Instant};

/// A rig in host memory, and the results of the last batch.
#[derive(Debug)]
pub struct CpuSession {
    handles: usize,
    frames: usize,
    rest: Vec<[f32; 3]>,
    handle_rest: Vec<[f32; 3]>,
    basis: BasisTiles,
    triangles: Normals,
    strain_edges: Vec<[u32; 2]>,
    rest_lengths: Vec<f32>,
    rbf: Detail,
    frame_neighbors: Vec<u32>,

    strain: Vec<f32>,
    large_scale: Vec<[f32; 3]>,
    large_scale_normals: Vec<[f32; 3]>,
    detail: Vec<[f32; 3]>,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    stage_times: [Duration; 6],
}

impl CpuSession {
    pub(crate) fn new(rig: &Rig, options: UploadOptions) -> Self {
        let max_frames = options.max_frames;
        let vertices = rig.vertices();
        let results = || vec![[0.0; 3]; max_frames * vertices];
        Self {
            handles: rig.handles.len(),
            frames: 0,
            rest: rig.rest.clone(),
            handle_rest: rig.handles.iter().map(|&v| rig.rest[v as usize]).collect(),
            basis: BasisTiles::new(rig, options.basis),
            triangles: Normals::new(vertices, rig.triangles.clone()),
            strain_edges: rig.strain_edges.clone(),
            rest_lengths: strain::rest_lengths(&rig.rest, &rig.handles, &rig.strain_edges),
            rbf: Detail::new(rig),
            frame_neighbors: rig.frame_neighbors.clone(),
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
        self.basis.apply(&self.rest, &displacements, self.handles, &mut self.large_scale[..values]);
    }

    fn compute_fine_scale(&mut self) {
        let vertices = self.rest.len();
        for frame in 0..self.frames {
            let all = frame * vertices..(frame + 1) * vertices;
            let smooth = &self.large_scale[all.clone()];
            let smooth_normals = &self.large_scale_normals[all.clone()];
            let detail = self.detail[all.clone()].par_chunks(BLOCK);
            let positions = self.positions[all].par_chunks_mut(BLOCK);
            detail.zip(positions).enumerate().for_each(|(block, (detail, positions))| {
                let first = block * BLOCK;
                widest(
                    #[inline(always)]
                    || {
                        for (i, (d, x)) in detail.iter().zip(positions).enumerate() {
                            let v = first + i;
                            let to_neighbor = vec3::sub(smooth[self.frame_neighbors[v] as usize], smooth[v]);
                            let frame = fine_scale::local_frame(to_neighbor, smooth_normals[v]);
                            *x = fine_scale::add_detail(smooth[v], frame, *d);
                        }
                    },
                );
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
        let vertices = self.rest.len();
        let normals = &mut self.large_scale_normals[..values];
        self.triangles.apply(vertices, &self.large_scale[..values], normals);
        finished();
        let edges = self.strain_edges.len();
        self.rbf.apply(&self.strain, edges, vertices, &mut self.detail[..values]);
        finished();
        self.compute_fine_scale();
        finished();
        self.triangles.apply(vertices, &self.positions[..values], &mut self.normals[..values]);
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
