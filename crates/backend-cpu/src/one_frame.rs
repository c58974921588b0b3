//! One frame: registers hold neighbouring vertices.
use crate::detail::TableRow;
use crate::lanes::{load3, store3};
use crate::mesh::{BlockMesh, MeshScratch};
use crate::resident::Resident;
use crate::rows::{ROW, Row, RowVectors};
use crate::times::Times;
use glam::{Mat4, Vec4};
use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use rhytid_core::Stage;
use rhytid_kernels::{fine_scale, vec3};
use std::cell::RefCell;
use std::time::Instant;
use thread_local::ThreadLocal;

/// Room for the large scale of one frame, V, and for what threads compute on the way: kept, since new memory is slow when it is first
/// written.
#[derive(Debug)]
pub struct OneFrame {
    smooth: Vec<[f32; 3]>,
    scratch: ThreadLocal<RefCell<Scratch>>,
}

/// What a thread computes on the way, all of one block.
#[derive(Debug, Default)]
struct Scratch {
    mesh: MeshScratch,
    normals: Vec<RowVectors>,
    details: Vec<RowVectors>,
    /// Of a row of vertices from all centres.
    distances: Vec<Row>,
}

impl OneFrame {
    pub fn new(vertices: usize) -> Self {
        Self { smooth: vec![[0.0; 3]; vertices], scratch: ThreadLocal::new() }
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
        blocks.for_each(|(mesh, out)| {
            let scratch = &mut self.scratch.get_or_default().borrow_mut();
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
            blocks.for_each(|(mesh, out)| {
                let scratch = &mut self.scratch.get_or_default().borrow_mut();
                scratch.distances.resize(face.detail.centers(), Row::ZERO);
                face.vectors.run(Fine {
                    face,
                    mesh,
                    smooth: &self.smooth,
                    table: &table,
                    scratch,
                    stage,
                    out,
                    times,
                });
            });
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
    stage: Stage,
    out: &'a mut [[f32; 3]],
    times: &'a Times,
}

impl WithSimd for Fine<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Scratch { mesh, normals, details, distances } = self.scratch;
        let start = Instant::now();
        self.mesh.normals(simd, self.smooth, mesh, normals);
        let start = self.times.add(Stage::LargeScaleNormals, start);
        details.clear();
        let own = self.mesh.own();
        for row in own.start / ROW..own.end.div_ceil(ROW) {
            details.push(self.face.detail.frame(simd, row, self.table, distances));
        }
        let start = self.times.add(Stage::Detail, start);
        for (i, out) in self.out.chunks_mut(ROW).enumerate() {
            match self.stage {
                Stage::LargeScaleNormals => interleave(&normals[i], out),
                Stage::Detail => interleave(&details[i], out),
                _ => {
                    let [own, neighbors] = self.mesh.with_neighbors(mesh, i);
                    interleave(&fine_row(simd, &own, &neighbors, &normals[i], &details[i]), out);
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
        for (normals, out) in normals.iter().zip(self.out.chunks_mut(ROW)) {
            interleave(normals, out);
        }
    }
}

/// x̃ + R d.
#[inline(always)]
fn fine_row<S: Simd>(
    simd: S,
    own: &RowVectors,
    neighbors: &RowVectors,
    normals: &RowVectors,
    details: &RowVectors,
) -> RowVectors {
    let mut positions = [Row::ZERO; 3];
    for part in 0..ROW / S::F32_LANES {
        let load = |rows| load3(simd, rows, part);
        let smooth = load(own);
        let frame = fine_scale::local_frame(vec3::sub(load(neighbors), smooth), load(normals));
        store3(fine_scale::add_detail(smooth, frame, load(details)), &mut positions, part);
    }
    positions
}

/// The first vectors of a row, as many as `out` has.
#[inline(always)]
fn interleave(row: &RowVectors, out: &mut [[f32; 3]]) {
    if let ([out], []) = out.as_chunks_mut::<ROW>() {
        let out = out.as_flattened_mut();
        for lane in (0..ROW).step_by(4) {
            let [x, y, z] = row.each_ref().map(|numbers| Vec4::from_slice(&numbers.0[lane..]));
            let vectors = Mat4::from_cols(x, y, z, Vec4::ZERO).transpose().to_cols_array_2d();
            // Four numbers at a time, of which the last is in the next vector's place and is overwritten.
            for (i, vector) in vectors.iter().enumerate() {
                let first = 3 * (lane + i);
                let numbers = vector.len().min(out.len() - first);
                out[first..first + numbers].copy_from_slice(&vector[..numbers]);
            }
        }
    } else {
        for (lane, out) in out.iter_mut().enumerate() {
            *out = row.each_ref().map(|numbers| numbers.0[lane]);
        }
    }
}
