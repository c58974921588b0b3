//! One frame: registers hold neighbouring vertices.
use crate::detail::Detail;
use crate::lanes::{load3, store3};
use crate::linear_band::{self, LinearBand};
use crate::lines::{Line, Line3};
use crate::mesh::{BlockMesh, MeshScratch};
use crate::tile_weights::{FrameCells, TileWeights};
use crate::times::Times;
use crate::uploaded::UploadedRig;
use glam::{Mat4, Vec4};
use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use rhytid_core::Stage;
use rhytid_kernels::table::TILE;
use rhytid_kernels::{fine_scale, vec3};
use std::cell::RefCell;
use std::time::Instant;
use thread_local::ThreadLocal;

/// Vertices whose large scale and detail are computed together, where there is a linear band: a multiple of the panels', and so few that
/// their influences stay in a core's caches between the two.
const CHUNK: usize = 1024;

/// The large scale of one frame, V, and the threads' scratch: kept, since new memory is slow when it is first
/// written.
#[derive(Debug)]
pub(crate) struct OneFrame {
    smooth: Vec<[f32; 3]>,
    scratch: ThreadLocal<RefCell<Scratch>>,
}

/// What a thread computes on the way, all of one block.
#[derive(Debug, Default)]
struct Scratch {
    mesh: MeshScratch,
    normals: Vec<Line3>,
    details: Vec<Line3>,
    /// Of a tile's vertices from all centres.
    distances: Vec<Line>,
}

impl OneFrame {
    pub(crate) fn new(vertices: usize) -> Self {
        Self { smooth: vec![[0.0; 3]; vertices], scratch: ThreadLocal::new() }
    }

    /// The positions and normals from H displacements and F features.
    pub(crate) fn evaluate(
        &mut self,
        rig: &UploadedRig,
        (u, features): (&[[f32; 3]], &[f32]),
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
        times: &Times,
    ) {
        self.large_scale(rig, (u, features), positions, times);
        self.fine(rig, features, Stage::Positions, positions, times);
        let start = Instant::now();
        let blocks = rig.meshes.par_iter().zip(normals.par_chunks_mut(rig.block));
        blocks.for_each(|(mesh, out)| {
            let scratch = &mut self.scratch.get_or_default().borrow_mut();
            rig.vectors.run(Normals { mesh, positions, scratch, out });
        });
        times.add(Stage::Normals, start);
    }

    /// Another stage of the same.
    pub(crate) fn stage(
        &mut self,
        rig: &UploadedRig,
        (u, features): (&[[f32; 3]], &[f32]),
        stage: Stage,
        out: &mut [[f32; 3]],
    ) {
        let times = Times::default();
        self.large_scale(rig, (u, features), out, &times);
        match stage {
            Stage::LargeScale => out.copy_from_slice(&self.smooth),
            _ => self.fine(rig, features, stage, out, &times),
        }
    }

    /// The large scale; where there is a linear band, the detail with it, since both read the same influences. It goes into
    /// `details`, V, as [`put_apart`] has it.
    fn large_scale(
        &mut self,
        rig: &UploadedRig,
        (u, features): (&[[f32; 3]], &[f32]),
        details: &mut [[f32; 3]],
        times: &Times,
    ) {
        let band = rig.linear_band.as_ref();
        let band = band.map(|band| (band, band.frame_table(u), rig.detail.frame_table(features)));
        let of_band = || band.as_ref().map(|(band, ..)| band.scratch());
        let scratch = || (Vec::new(), of_band(), vec![Line::ZERO; rig.detail.centers()]);
        let blocks = self.smooth.par_chunks_mut(rig.block).zip(details.par_chunks_mut(rig.block));
        times.shared(|times| {
            blocks.enumerate().for_each_init(scratch, |(of_basis, of_band, distances), (i, block)| {
                let chunks = block.0.chunks_mut(CHUNK).zip(block.1.chunks_mut(CHUNK));
                for (j, (smooth, details)) in chunks.enumerate() {
                    let first = i * rig.block + j * CHUNK;
                    let start = Instant::now();
                    let rest = &rig.rest[first..first + smooth.len()];
                    rig.basis.frame(rig.vectors, first, u, rest, smooth, of_basis);
                    if let (Some((band, table, _)), Some(scratch)) = (&band, &mut *of_band) {
                        rig.vectors.run(AddBand {
                            band,
                            influences: &rig.detail.influences,
                            table,
                            scratch,
                            first,
                            out: smooth,
                        });
                    }
                    let start = times.add(Stage::LargeScale, start);
                    if let Some((_, _, table)) = &band {
                        rig.vectors.run(Details {
                            detail: &rig.detail,
                            table,
                            distances,
                            first,
                            out: details,
                        });
                        times.add(Stage::Detail, start);
                    }
                }
            });
        });
    }

    /// From the large scale to `stage`: its normals, the detail or the positions. Where there is a linear band, `out` has the detail.
    fn fine(&self, rig: &UploadedRig, features: &[f32], stage: Stage, out: &mut [[f32; 3]], times: &Times) {
        let table = rig.linear_band.is_none().then(|| rig.detail.frame_table(features));
        let blocks = rig.meshes.par_iter().zip(out.par_chunks_mut(rig.block));
        times.shared(|times| {
            blocks.for_each(|(mesh, out)| {
                let scratch = &mut self.scratch.get_or_default().borrow_mut();
                scratch.distances.resize(rig.detail.centers(), Line::ZERO);
                rig.vectors.run(Fine {
                    rig,
                    mesh,
                    smooth: &self.smooth,
                    table: table.as_deref(),
                    scratch,
                    stage,
                    out,
                    times,
                });
            });
        });
    }
}

/// A chunk's linear band.
struct AddBand<'a> {
    band: &'a LinearBand,
    influences: &'a TileWeights,
    table: &'a [FrameCells],
    scratch: &'a mut linear_band::Scratch,
    first: usize,
    out: &'a mut [[f32; 3]],
}

impl WithSimd for AddBand<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (i, out) in self.out.chunks_mut(TILE).enumerate() {
            self.band.add_to_frame(
                simd,
                self.first / TILE + i,
                (self.influences, self.table),
                self.scratch,
                out,
            );
        }
    }
}

/// A chunk's detail.
struct Details<'a> {
    detail: &'a Detail,
    table: &'a [FrameCells],
    distances: &'a mut [Line],
    first: usize,
    out: &'a mut [[f32; 3]],
}

impl WithSimd for Details<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (i, out) in self.out.chunks_mut(TILE).enumerate() {
            put_apart(&self.detail.frame(simd, self.first / TILE + i, self.table, self.distances), out);
        }
    }
}

/// A block from the large scale on.
struct Fine<'a> {
    rig: &'a UploadedRig,
    mesh: &'a BlockMesh,
    smooth: &'a [[f32; 3]],
    /// Of the detail, unless it is in `out` already.
    table: Option<&'a [FrameCells]>,
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
        let turned = !self.rig.mesh_axes;
        if turned || self.stage == Stage::LargeScaleNormals {
            self.mesh.normals(simd, self.smooth, mesh, normals);
        }
        let start = self.times.add(Stage::LargeScaleNormals, start);
        details.clear();
        if let Some(table) = self.table {
            let own = self.mesh.own();
            for tile in own.start / TILE..own.end.div_ceil(TILE) {
                details.push(self.rig.detail.frame(simd, tile, table, distances));
            }
        }
        let start = self.times.add(Stage::Detail, start);
        for (i, out) in self.out.chunks_mut(TILE).enumerate() {
            let details = details.get(i).copied().unwrap_or_else(|| taken_apart(out));
            match self.stage {
                Stage::LargeScaleNormals => interleave(&normals[i], out),
                Stage::Detail => interleave(&details, out),
                _ if turned => {
                    let [own, neighbors] = self.mesh.with_neighbors(mesh, i);
                    interleave(&fine_tile(simd, &own, &neighbors, &normals[i], &details), out);
                }
                _ => {
                    interleave(&details, out);
                    let smooth = &self.smooth[self.mesh.own()][i * TILE..];
                    out.iter_mut().zip(smooth).for_each(|(x, smooth)| *x = vec3::add(*smooth, *x));
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

/// x̃ + R d of a tile's vertices.
#[inline(always)]
fn fine_tile<S: Simd>(simd: S, own: &Line3, neighbors: &Line3, normals: &Line3, details: &Line3) -> Line3 {
    let mut positions = [Line::ZERO; 3];
    for register in 0..TILE / S::F32_LANES {
        let load = |lines| load3(simd, lines, register);
        let smooth = load(own);
        let axes = fine_scale::tangent_frame(vec3::sub(load(neighbors), smooth), load(normals));
        store3(fine_scale::add_detail(smooth, axes, load(details)), &mut positions, register);
    }
    positions
}

/// The first vectors of a tile, as many as `out` has, with their coordinates apart.
#[inline(always)]
fn put_apart(lines: &Line3, out: &mut [[f32; 3]]) {
    let vectors = out.len();
    for (line, out) in lines.iter().zip(out.as_flattened_mut().chunks_exact_mut(vectors)) {
        out.copy_from_slice(&line.0[..vectors]);
    }
}

/// What [`put_apart`] put there.
#[inline(always)]
fn taken_apart(vectors: &[[f32; 3]]) -> Line3 {
    let mut lines = [Line::ZERO; 3];
    for (line, numbers) in lines.iter_mut().zip(vectors.as_flattened().chunks_exact(vectors.len())) {
        line.0[..numbers.len()].copy_from_slice(numbers);
    }
    lines
}

/// The first vectors of a tile, as many as `out` has.
#[inline(always)]
fn interleave(lines: &Line3, out: &mut [[f32; 3]]) {
    if let ([out], []) = out.as_chunks_mut::<TILE>() {
        let out = out.as_flattened_mut();
        for lane in (0..TILE).step_by(4) {
            let [x, y, z] = lines.each_ref().map(|line| Vec4::from_slice(&line.0[lane..]));
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
            *out = lines.each_ref().map(|line| line.0[lane]);
        }
    }
}
