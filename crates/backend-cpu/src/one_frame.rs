//! One frame: registers hold neighbouring vertices.
use crate::bands::{self, Bands, Terms};
use crate::detail::Detail;
use crate::lanes::{load3, store3};
use crate::lines::{Line, Line3, PanelRows};
use crate::mesh::{BlockMesh, MeshScratch};
use crate::tile_weights::{CellTable, FrameCells, TileWeights};
use crate::times::Times;
use crate::uploaded::{Inputs, UploadedRig};
use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use rhytid_core::Stage;
use rhytid_kernels::tile::TILE;
use rhytid_kernels::{fine_scale, large_scale, vec3};
use std::cell::RefCell;
use thread_local::ThreadLocal;
use web_time::Instant;

/// Vertices whose basis and bands are computed together. This is a multiple of a panel's length, and so few
/// that they stay in a core's caches between the two.
const CHUNK: usize = 1024;

/// The rest positions of a chunk at the origin.
const NOWHERE: [[f32; 3]; CHUNK] = [[0.0; 3]; CHUNK];

/// The large scale of one frame, V where it is needed, and the threads' scratch. They are kept, since new
/// memory is slow when it is first written.
#[derive(Debug)]
pub(crate) struct OneFrame {
    smooth: Vec<[f32; 3]>,
    scratch: ThreadLocal<RefCell<Scratch>>,
}

/// A thread's scratch, for one block.
#[derive(Debug, Default)]
struct Scratch {
    mesh: MeshScratch,
    normals: Vec<Line3>,
    details: Vec<Line3>,
    /// The distances of a tile's vertices from all centres.
    distances: Vec<Line>,
}

impl OneFrame {
    pub(crate) fn new() -> Self {
        Self { smooth: Vec::new(), scratch: ThreadLocal::new() }
    }

    /// The positions and normals from one frame's inputs.
    pub(crate) fn evaluate(
        &mut self,
        rig: &UploadedRig,
        inputs: Inputs<'_>,
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
        times: &Times,
    ) {
        self.positions(rig, inputs, Stage::Positions, positions, times);
        let start = Instant::now();
        self.normals(rig, positions, normals);
        times.add(Stage::Normals, start);
    }

    /// Another stage of the same frame.
    pub(crate) fn stage(
        &mut self,
        rig: &UploadedRig,
        inputs: Inputs<'_>,
        stage: Stage,
        out: &mut [[f32; 3]],
    ) {
        let times = Times::default();
        match stage {
            Stage::LargeScale => large_scale(rig, inputs, stage, out, &times),
            Stage::LargeScaleNormals => {
                self.smooth.resize(out.len(), [0.0; 3]);
                large_scale(rig, inputs, Stage::LargeScale, &mut self.smooth, &times);
                self.normals(rig, &self.smooth, out);
            }
            _ => self.positions(rig, inputs, stage, out, &times),
        }
    }

    /// The detail or the positions.
    fn positions(
        &mut self,
        rig: &UploadedRig,
        inputs: Inputs<'_>,
        stage: Stage,
        out: &mut [[f32; 3]],
        times: &Times,
    ) {
        let Some(detail) = &rig.detail else { return large_scale(rig, inputs, stage, out, times) };
        self.smooth.resize(out.len(), [0.0; 3]);
        large_scale(rig, inputs, Stage::LargeScale, &mut self.smooth, times);
        let table = detail.frame_table(inputs.features);
        let blocks = rig.meshes.par_iter().zip(out.par_chunks_mut(rig.block));
        times.shared(|times| {
            blocks.for_each(|(mesh, out)| {
                let scratch = &mut self.scratch.get_or_default().borrow_mut();
                scratch.distances.resize(detail.centers(), Line::ZERO);
                let (influences, table, smooth) = (&rig.influences, &table, &self.smooth[..]);
                rig.vectors.run(Fine { detail, influences, table, mesh, smooth, scratch, stage, out, times });
            });
        });
    }

    fn normals(&self, rig: &UploadedRig, positions: &[[f32; 3]], normals: &mut [[f32; 3]]) {
        let blocks = rig.meshes.par_iter().zip(normals.par_chunks_mut(rig.block));
        blocks.for_each(|(mesh, out)| {
            let scratch = &mut self.scratch.get_or_default().borrow_mut();
            rig.vectors.run(Normals { mesh, positions, scratch, out });
        });
    }
}

/// The large scale. Where the wrinkles are functions of vector strains, also the detail or the positions,
/// which then need no neighbours.
fn large_scale(rig: &UploadedRig, inputs: Inputs<'_>, stage: Stage, out: &mut [[f32; 3]], times: &Times) {
    let start = Instant::now();
    let of_handles = if rig.rotations.is_some() { inputs.motions } else { inputs.displacements };
    let motions = rig.basis.motions(rig.vectors, of_handles);
    let bands = rig.bands.as_ref().map(|bands| (bands, bands.frame_table(inputs.displacements)));
    let beyond = rig.beyond.as_ref().zip(rig.bands.as_ref());
    let excess = beyond.and_then(|(beyond, bands)| beyond.frame(bands, inputs.displacements));
    let scratch = || (OfHandles::default(), bands.as_ref().map(|(bands, _)| bands.scratch()));
    let blocks = out.par_chunks_mut(rig.block).enumerate();
    blocks.for_each_init(scratch, |(of_basis, of_bands), (i, block)| {
        for (j, out) in block.chunks_mut(CHUNK).enumerate() {
            let first = i * rig.block + j * CHUNK;
            without_bands(rig, first, &motions, out, of_basis);
            if let (Some((bands, table)), Some(scratch)) = (&bands, &mut *of_bands) {
                let terms = Terms { influences: &rig.influences, table, excess: excess.as_ref() };
                rig.vectors.run(AddBands { bands, terms, scratch, first, stage, out });
            }
        }
    });
    times.add(Stage::LargeScale, start);
}

/// A thread's scratch for the basis.
#[derive(Default)]
struct OfHandles {
    rows: Vec<PanelRows>,
    /// The products of the basis with the columns of R − I.
    columns: [Vec<[f32; 3]>; 3],
}

/// The large scale of consecutive vertices from the first one of a panel, without the bands. `motions` are
/// those of the basis.
fn without_bands(
    rig: &UploadedRig,
    first: usize,
    motions: &[[f32; 3]],
    out: &mut [[f32; 3]],
    scratch: &mut OfHandles,
) {
    let rest = &rig.rest[first..first + out.len()];
    if rig.rotations.is_none() {
        rig.basis.frame(rig.vectors, first, motions, rest, out, &mut scratch.rows);
        return;
    }
    let OfHandles { rows, columns } = scratch;
    let mut blend = |motion: &[[f32; 3]], out: &mut [[f32; 3]]| {
        rig.basis.frame(rig.vectors, first, motion, &NOWHERE[..out.len()], out, rows);
    };
    let mut motions = motions.chunks_exact(rig.basis.width());
    if let Some(motion) = motions.next() {
        blend(motion, out);
    }
    for (column, motion) in columns.iter_mut().zip(motions) {
        column.resize(out.len(), [0.0; 3]);
        blend(motion, column);
    }
    let center = rig.rest[rig.center];
    let columns = columns.each_ref().map(|column| &column[..out.len()]);
    for (i, (out, rest)) in out.iter_mut().zip(rest).enumerate() {
        let moved = large_scale::turned(*out, columns.map(|column| column[i]), vec3::sub(*rest, center));
        *out = vec3::add(*rest, moved);
    }
}

/// A chunk's bands.
struct AddBands<'a> {
    bands: &'a Bands,
    terms: Terms<'a, FrameCells, f32>,
    scratch: &'a mut bands::Scratch,
    first: usize,
    stage: Stage,
    out: &'a mut [[f32; 3]],
}

impl WithSimd for AddBands<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (i, out) in self.out.chunks_mut(TILE).enumerate() {
            let tile = self.first / TILE + i;
            self.bands.frame(simd, tile, self.stage, self.terms, self.scratch, out);
        }
    }
}

/// A block from the large scale on: the detail or the positions.
struct Fine<'a> {
    detail: &'a Detail,
    /// α.
    influences: &'a TileWeights,
    /// The frame's squared differences.
    table: &'a CellTable<FrameCells>,
    mesh: &'a BlockMesh,
    smooth: &'a [[f32; 3]],
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
        for tile in own.start / TILE..own.end.div_ceil(TILE) {
            details.push(self.detail.frame(simd, tile, self.influences, self.table, distances));
        }
        let start = self.times.add(Stage::Detail, start);
        for (i, out) in self.out.chunks_mut(TILE).enumerate() {
            if self.stage == Stage::Detail {
                interleave(&details[i], out);
            } else {
                let [own, neighbors] = self.mesh.with_neighbors(mesh, i);
                interleave(&fine_tile(simd, &own, &neighbors, &normals[i], &details[i]), out);
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

/// Writes the first vectors of a tile, as many as `out` has.
#[inline(always)]
fn interleave(lines: &Line3, out: &mut [[f32; 3]]) {
    let [x, y, z] = lines;
    let of_lane = |lane: usize| [x.0[lane], y.0[lane], z.0[lane]];
    match out.as_chunks_mut::<TILE>() {
        // A loop of known length is compiled to vectors.
        ([out], []) => out.iter_mut().enumerate().for_each(|(lane, out)| *out = of_lane(lane)),
        _ => out.iter_mut().enumerate().for_each(|(lane, out)| *out = of_lane(lane)),
    }
}
