//! A group of frames: registers hold one vertex in neighbouring frames, so that nothing is gathered and what is read of the rig is
//! read once for all of them.
use crate::detail::GroupTableRow;
use crate::group_mesh::GroupMesh;
use crate::lanes::{load3, store3};
use crate::prefetch::Prefetch;
use crate::resident::Resident;
use crate::rows::{GROUP, ROW, Row, RowVectors, TILE};
use crate::times::Times;
use glam::{Mat4, Vec4};
use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use rhytid_core::{Rig, Stage};
use rhytid_kernels::{fine_scale, vec3};
use std::time::Instant;

/// Vertices that are put into frames at once: so many that each frame's part is written in long runs.
const BLOCK: usize = 512;

/// How many numbers ahead of its being written a frame's memory is asked for, a cache line at a time.
const AHEAD: usize = 256;

/// The mesh, and room for the results of a group, V each.
#[derive(Debug)]
pub struct Group {
    mesh: GroupMesh,
    smooth: Vec<RowVectors>,
    fine: Vec<RowVectors>,
}

/// What a thread computes on the way.
struct Scratch {
    /// Of a tile.
    normals: [RowVectors; TILE],
    details: [RowVectors; TILE],
    /// Of a vertex.
    distances: [Vec<Row>; 2],
}

const ZERO: RowVectors = [Row::ZERO; 3];

impl Group {
    pub fn new(rig: &Rig) -> Self {
        let vertices = rig.vertices();
        Self {
            mesh: GroupMesh::new(vertices, &rig.triangles),
            smooth: vec![ZERO; vertices],
            fine: vec![ZERO; vertices],
        }
    }

    /// The positions and normals from frames × H displacements and frames × F features, of as many frames as fill `positions`, at most [`GROUP`].
    pub fn evaluate(
        &mut self,
        face: &Resident,
        (u, features): (&[[f32; 3]], &[f32]),
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
        times: &Times,
    ) {
        let frames = positions.len() / face.rest.len();
        self.large_scale(face, u, frames, times);
        self.fine(face, features, Stage::Positions, times);
        let start = Instant::now();
        let Self { mesh, fine, .. } = &*self;
        let blocks = blocks(positions, face).zip(blocks(normals, face)).zip(fine.par_chunks(BLOCK));
        blocks.enumerate().for_each_init(Vec::new, |room, (i, ((positions, normals), own))| {
            interleave(own, positions);
            room.resize(own.len(), ZERO);
            face.vectors.run(Normals { mesh, positions: fine, first: i * BLOCK, out: room });
            interleave(room, normals);
        });
        times.add(Stage::Normals, start);
    }

    /// Another stage of the same.
    pub fn stage(
        &mut self,
        face: &Resident,
        (u, features): (&[[f32; 3]], &[f32]),
        stage: Stage,
        out: &mut [[f32; 3]],
    ) {
        let times = Times::default();
        self.large_scale(face, u, out.len() / face.rest.len(), &times);
        let result = if stage == Stage::LargeScale {
            &self.smooth
        } else {
            self.fine(face, features, stage, &times);
            &self.fine
        };
        blocks(out, face).zip(result.par_chunks(BLOCK)).for_each(|(out, result)| interleave(result, out));
    }

    fn large_scale(&mut self, face: &Resident, u: &[[f32; 3]], frames: usize, times: &Times) {
        let start = Instant::now();
        let handles = u.len() / frames;
        let mut by_handles = vec![ZERO; handles];
        for (i, u) in u.iter().enumerate() {
            for c in 0..3 {
                by_handles[i % handles][c].0[i / handles] = u[c];
            }
        }
        let tiles = self.smooth.par_chunks_mut(TILE).zip(face.rest.par_chunks(TILE));
        tiles.enumerate().for_each_init(Vec::new, |room, (tile, (out, rest))| {
            face.basis.group(face.vectors, tile, &by_handles, rest, out, room);
        });
        times.add(Stage::LargeScale, start);
    }

    /// From the large scale to `stage`: its normals, the detail or the positions.
    fn fine(&mut self, face: &Resident, features: &[f32], stage: Stage, times: &Times) {
        let table = face.detail.group_table(features);
        let (mesh, smooth) = (&self.mesh, &self.smooth);
        times.shared(|times| {
            self.fine.par_chunks_mut(TILE).enumerate().for_each_init(
                || Scratch {
                    normals: [ZERO; TILE],
                    details: [ZERO; TILE],
                    distances: face.detail.group_scratch(),
                },
                |scratch, (i, out)| {
                    let first = i * TILE;
                    face.vectors.run(Fine {
                        face,
                        mesh,
                        smooth,
                        table: &table,
                        scratch,
                        first,
                        stage,
                        out,
                        times,
                    });
                },
            );
        });
    }
}

/// Each block's parts of frames × V results.
fn blocks<'a>(
    results: &'a mut [[f32; 3]],
    face: &Resident,
) -> impl IndexedParallelIterator<Item = Vec<&'a mut [[f32; 3]]>> {
    let vertices = face.rest.len();
    let mut blocks: Vec<Vec<&mut [[f32; 3]]>> = Vec::new();
    blocks.resize_with(vertices.div_ceil(BLOCK), || Vec::with_capacity(GROUP));
    for frame in results.chunks_exact_mut(vertices) {
        for (part, block) in frame.chunks_mut(BLOCK).zip(&mut blocks) {
            block.push(part);
        }
    }
    blocks.into_par_iter()
}

/// From one vertex in all frames to one frame of all vertices: a transposition, four rows by four columns at a time.
fn interleave(vectors: &[RowVectors], mut frames: Vec<&mut [[f32; 3]]>) {
    let prefetch = Prefetch::new();
    let (rows, last) = vectors.as_flattened().as_chunks::<4>();
    for (q, frames) in frames.chunks_mut(4).enumerate() {
        for (i, rows) in rows.iter().enumerate() {
            if i % 4 == 0 {
                let line = 4 * i + AHEAD..4 * i + AHEAD + ROW;
                for out in &*frames {
                    let line = out.as_flattened().get(line.clone()).unwrap_or_default();
                    prefetch.ask(bytemuck::cast_slice(line));
                }
            }
            let columns = rows.each_ref().map(|row| Vec4::from_slice(&row.0[4 * q..]));
            let by_frame = Mat4::from_cols(columns[0], columns[1], columns[2], columns[3]).transpose();
            for (out, numbers) in frames.iter_mut().zip(by_frame.to_cols_array_2d()) {
                out.as_flattened_mut()[4 * i..4 * i + 4].copy_from_slice(&numbers);
            }
        }
        for (lane, out) in frames.iter_mut().enumerate() {
            let out = &mut out.as_flattened_mut()[4 * rows.len()..];
            out.iter_mut().zip(last).for_each(|(out, row)| *out = row.0[4 * q + lane]);
        }
    }
}

/// A tile from the large scale on.
struct Fine<'a> {
    face: &'a Resident,
    mesh: &'a GroupMesh,
    smooth: &'a [RowVectors],
    table: &'a [GroupTableRow],
    scratch: &'a mut Scratch,
    first: usize,
    stage: Stage,
    out: &'a mut [RowVectors],
    times: &'a Times,
}

impl WithSimd for Fine<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { face, smooth, first, .. } = self;
        let Scratch { normals, details, distances } = self.scratch;
        let (normals, details) = (&mut normals[..self.out.len()], &mut details[..self.out.len()]);
        let start = Instant::now();
        self.mesh.normals(simd, smooth, first, normals);
        let start = self.times.add(Stage::LargeScaleNormals, start);
        face.detail.group(simd, first, self.table, distances, details);
        let start = self.times.add(Stage::Detail, start);
        match self.stage {
            Stage::LargeScaleNormals => self.out.copy_from_slice(normals),
            Stage::Detail => self.out.copy_from_slice(details),
            _ => {
                for (i, out) in self.out.iter_mut().enumerate() {
                    let neighbor = face.frame_neighbors[first + i] as usize;
                    for part in 0..GROUP / S::F32_LANES {
                        let load = |rows| load3(simd, rows, part);
                        let own = load(&smooth[first + i]);
                        let to_neighbor = vec3::sub(load(&smooth[neighbor]), own);
                        let frame = fine_scale::local_frame(to_neighbor, load(&normals[i]));
                        store3(fine_scale::add_detail(own, frame, load(&details[i])), out, part);
                    }
                }
            }
        }
        self.times.add(Stage::Positions, start);
    }
}

/// The normals of consecutive vertices.
struct Normals<'a> {
    mesh: &'a GroupMesh,
    positions: &'a [RowVectors],
    first: usize,
    out: &'a mut [RowVectors],
}

impl WithSimd for Normals<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.mesh.normals(simd, self.positions, self.first, self.out);
    }
}
