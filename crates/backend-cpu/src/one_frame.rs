//! One frame: registers hold neighbouring vertices.
use crate::detail::TableRow;
use crate::lanes::{load3, store3};
use crate::mesh::{BlockMesh, MeshScratch};
use crate::resident::Resident;
use crate::rows::{TileRow, TileVectors};
use crate::times::Times;
use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use rhytid_core::Stage;
use rhytid_kernels::table::TILE;
use rhytid_kernels::{fine_scale, vec3};
use std::time::Instant;

/// Room for the large scale of one frame, V.
#[derive(Debug)]
pub struct OneFrame {
    smooth: Vec<[f32; 3]>,
}

/// What a thread computes on the way, all of one block.
#[derive(Default)]
struct Scratch {
    mesh: MeshScratch,
    normals: Vec<TileVectors>,
    details: Vec<TileVectors>,
}

impl OneFrame {
    pub fn new(vertices: usize) -> Self {
        Self { smooth: vec![[0.0; 3]; vertices] }
    }

    /// The positions and normals from H displacements and F features.
    pub fn evaluate(
        &mut self,
        face: &Resident,
        (u, features): (&[[f32; 3]], &[f32]),
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
        times: &Times,
    ) {
        self.large_scale(face, u, times);
        self.fine(face, features, Stage::Positions, positions, times);
        let start = Instant::now();
        let blocks = face.meshes.par_iter().zip(normals.par_chunks_mut(face.block));
        blocks.for_each_init(Scratch::default, |scratch, (mesh, out)| {
            face.vectors.run(Normals { mesh, positions, scratch, out });
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
        self.large_scale(face, u, &times);
        match stage {
            Stage::LargeScale => out.copy_from_slice(&self.smooth),
            _ => self.fine(face, features, stage, out, &times),
        }
    }

    fn large_scale(&mut self, face: &Resident, u: &[[f32; 3]], times: &Times) {
        let start = Instant::now();
        let blocks = self.smooth.par_chunks_mut(face.block).zip(face.rest.par_chunks(face.block));
        blocks.enumerate().for_each_init(Vec::new, |room, (i, (out, rest))| {
            face.basis.frame(face.vectors, i * face.block, u, rest, out, room);
        });
        times.add(Stage::LargeScale, start);
    }

    /// From the large scale to `stage`: its normals, the detail or the positions.
    fn fine(&self, face: &Resident, features: &[f32], stage: Stage, out: &mut [[f32; 3]], times: &Times) {
        let table = face.detail.frame_table(features);
        let blocks = face.meshes.par_iter().zip(out.par_chunks_mut(face.block));
        times.shared(|times| {
            blocks.for_each_init(
                || (Scratch::default(), face.detail.tile_scratch()),
                |(scratch, distances), (mesh, out)| {
                    let smooth = &self.smooth;
                    face.vectors.run(Fine {
                        face,
                        mesh,
                        smooth,
                        table: &table,
                        scratch,
                        distances,
                        stage,
                        out,
                        times,
                    });
                },
            );
        });
    }
}

/// A block from the large scale on.
struct Fine<'a> {
    face: &'a Resident,
    mesh: &'a BlockMesh,
    smooth: &'a [[f32; 3]],
    table: &'a [TableRow],
    scratch: &'a mut Scratch,
    distances: &'a mut [TileRow],
    stage: Stage,
    out: &'a mut [[f32; 3]],
    times: &'a Times,
}

impl WithSimd for Fine<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Scratch { mesh, normals, details } = self.scratch;
        let start = Instant::now();
        self.mesh.normals(simd, self.smooth, mesh, normals);
        let start = self.times.add(Stage::LargeScaleNormals, start);
        details.clear();
        for i in 0..normals.len() {
            let tile = self.mesh.own().start / TILE + i;
            details.push(self.face.detail.tile(simd, tile, self.table, self.distances));
        }
        let start = self.times.add(Stage::Detail, start);
        for (i, out) in self.out.chunks_mut(TILE).enumerate() {
            match self.stage {
                Stage::LargeScaleNormals => interleave(&normals[i], out),
                Stage::Detail => interleave(&details[i], out),
                _ => {
                    let [own, neighbors] = self.mesh.with_neighbors(mesh, i);
                    interleave(&fine_tile(simd, &own, &neighbors, &normals[i], &details[i]), out);
                }
            }
        }
        self.times.add(Stage::Positions, start);
    }
}

/// A block's normals.
struct Normals<'a> {
    mesh: &'a BlockMesh,
    positions: &'a [[f32; 3]],
    scratch: &'a mut Scratch,
    out: &'a mut [[f32; 3]],
}

impl WithSimd for Normals<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Scratch { mesh, normals, .. } = self.scratch;
        self.mesh.normals(simd, self.positions, mesh, normals);
        for (normals, out) in normals.iter().zip(self.out.chunks_mut(TILE)) {
            interleave(normals, out);
        }
    }
}

/// x̃ + R d.
#[inline(always)]
fn fine_tile<S: Simd>(
    simd: S,
    own: &TileVectors,
    neighbors: &TileVectors,
    normals: &TileVectors,
    details: &TileVectors,
) -> TileVectors {
    let mut positions = [TileRow::ZERO; 3];
    for part in 0..TILE / S::F32_LANES {
        let load = |rows| load3(simd, rows, part);
        let smooth = load(own);
        let frame = fine_scale::local_frame(vec3::sub(load(neighbors), smooth), load(normals));
        store3(fine_scale::add_detail(smooth, frame, load(details)), &mut positions, part);
    }
    positions
}

/// The first vectors of a tile, as many as `out` has.
#[inline(always)]
fn interleave([x, y, z]: &TileVectors, out: &mut [[f32; 3]]) {
    for (lane, out) in out.iter_mut().enumerate() {
        *out = [x.0[lane], y.0[lane], z.0[lane]];
    }
}
