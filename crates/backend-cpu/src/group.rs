//! A group of frames. Registers hold one vertex in neighbouring frames. So nothing is gathered, and the rig's
//! data are read once for all of these frames.
use crate::bands::{self, Bands, Terms};
use crate::detail::Detail;
use crate::group_mesh::GroupMesh;
use crate::lanes::{load3, splat3, store3};
use crate::lines::{GROUP, Line, Line3, PANEL, PanelRows};
use crate::prefetch::Prefetch;
use crate::tile_weights::{CellTable, GroupCells};
use crate::times::Times;
use crate::uploaded::{Inputs, UploadedRig};
use glam::{Mat4, Vec4};
use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use rhytid_core::{Rig, Stage};
use rhytid_kernels::{fine_scale, large_scale, vec3};
use web_time::Instant;

/// Vertices whose results are written into their frames together. With this many, each frame gets a long
/// piece.
const CHUNK: usize = 512;

/// A frame's memory is requested this many numbers before they are written, a cache line at a time.
const AHEAD: usize = 256;

/// The mesh, and the results of a group, V each. The large scale is kept only where it is needed.
#[derive(Debug)]
pub(crate) struct Group {
    mesh: GroupMesh,
    smooth: Vec<Line3>,
    fine: Vec<Line3>,
}

/// A thread's scratch.
struct Scratch {
    /// The normals of a panel.
    normals: [Line3; PANEL],
    details: [Line3; PANEL],
    /// The distances of a vertex.
    distances: [Vec<Line>; 2],
}

const ZERO: Line3 = [Line::ZERO; 3];

impl Group {
    pub(crate) fn new(rig: &Rig) -> Self {
        let vertices = rig.vertices();
        Self {
            mesh: GroupMesh::new(vertices, &rig.surface().triangles, &rig.surface().vertex_triangles()),
            smooth: Vec::new(),
            fine: vec![ZERO; vertices],
        }
    }

    /// The positions and normals of as many frames as fill `positions`, at most [`GROUP`].
    pub(crate) fn evaluate(
        &mut self,
        rig: &UploadedRig,
        inputs: Inputs<'_>,
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
        times: &Times,
    ) {
        let frames = positions.len() / rig.rest.len();
        self.positions(rig, inputs, frames, Stage::Positions, times);
        let start = Instant::now();
        let Self { mesh, fine, .. } = &*self;
        let chunks = chunks(positions, rig).zip(chunks(normals, rig)).zip(fine.par_chunks(CHUNK));
        chunks.enumerate().for_each_init(Vec::new, |scratch, (i, ((positions, normals), own))| {
            interleave(own, positions);
            scratch.resize(own.len(), ZERO);
            rig.vectors.run(Normals { mesh, positions: fine, first: i * CHUNK, out: scratch });
            interleave(scratch, normals);
        });
        times.add(Stage::Normals, start);
    }

    /// Another stage of the same frames.
    pub(crate) fn stage(
        &mut self,
        rig: &UploadedRig,
        inputs: Inputs<'_>,
        stage: Stage,
        out: &mut [[f32; 3]],
    ) {
        let (frames, times) = (out.len() / rig.rest.len(), Times::default());
        match stage {
            Stage::LargeScale => large_scale(rig, inputs, frames, stage, &mut self.fine, &times),
            Stage::LargeScaleNormals => {
                self.smooth.resize(self.fine.len(), ZERO);
                let Self { mesh, smooth, fine } = self;
                large_scale(rig, inputs, frames, Stage::LargeScale, smooth, &times);
                fine.par_chunks_mut(PANEL).enumerate().for_each(|(i, out)| {
                    rig.vectors.run(Normals { mesh, positions: smooth, first: i * PANEL, out });
                });
            }
            _ => self.positions(rig, inputs, frames, stage, &times),
        }
        let results = self.fine.par_chunks(CHUNK);
        chunks(out, rig).zip(results).for_each(|(out, result)| interleave(result, out));
    }

    /// The detail or the positions, into `fine`.
    fn positions(
        &mut self,
        rig: &UploadedRig,
        inputs: Inputs<'_>,
        frames: usize,
        stage: Stage,
        times: &Times,
    ) {
        let Some(detail) = &rig.detail else {
            return large_scale(rig, inputs, frames, stage, &mut self.fine, times);
        };
        self.smooth.resize(self.fine.len(), ZERO);
        large_scale(rig, inputs, frames, Stage::LargeScale, &mut self.smooth, times);
        let table = detail.group_table(inputs.features);
        let Self { mesh, smooth, fine } = self;
        let scratch =
            || Scratch { normals: [ZERO; PANEL], details: [ZERO; PANEL], distances: detail.group_scratch() };
        times.shared(|times| {
            fine.par_chunks_mut(PANEL).enumerate().for_each_init(scratch, |scratch, (i, out)| {
                let (table, first) = (&table, i * PANEL);
                rig.vectors.run(Fine { rig, detail, mesh, smooth, table, scratch, first, stage, out, times });
            });
        });
    }
}

/// The large scale, V. Where the wrinkles are functions of vector strains, also the detail or the positions,
/// which then need no neighbours.
fn large_scale(
    rig: &UploadedRig,
    inputs: Inputs<'_>,
    frames: usize,
    stage: Stage,
    out: &mut [Line3],
    times: &Times,
) {
    let start = Instant::now();
    let handles = inputs.displacements.len() / frames;
    let moved = if rig.rotations.is_some() { inputs.motions } else { inputs.displacements };
    // Each frame has H vectors of displacements, or several times H vectors of motions, one after the other.
    let of_frame = moved.len() / frames;
    let mut by_handles = vec![ZERO; of_frame];
    for (i, u) in moved.iter().enumerate() {
        for c in 0..3 {
            by_handles[i % of_frame][c].0[i / of_frame] = u[c];
        }
    }
    let motions = rig.basis.group_motions(rig.vectors, &by_handles);
    let bands = rig.bands.as_ref().map(|bands| (bands, bands.group_table(inputs.displacements)));
    let beyond = rig.beyond.as_ref().zip(rig.bands.as_ref());
    let excess = beyond.and_then(|(beyond, bands)| beyond.group(bands, inputs.displacements, handles));
    let scratch = || (OfHandles::default(), bands.as_ref().map(|(bands, _)| bands.scratch()));
    let panels = out.par_chunks_mut(PANEL).zip(rig.rest.par_chunks(PANEL)).enumerate();
    panels.for_each_init(scratch, |(of_basis, of_bands), (panel, (out, rest))| {
        without_bands(rig, panel, &motions, rest, out, of_basis);
        if let (Some((bands, table)), Some(scratch)) = (&bands, of_bands) {
            let terms = Terms { influences: &rig.influences, table, excess: excess.as_ref() };
            rig.vectors.run(AddBands { bands, terms, scratch, first: panel * PANEL, stage, out });
        }
    });
    times.add(Stage::LargeScale, start);
}

/// A thread's scratch for the basis.
#[derive(Default)]
struct OfHandles {
    rows: Vec<PanelRows>,
    /// The products of the basis with the columns of R − I.
    columns: [Vec<Line3>; 3],
}

/// The large scale of a panel, without the bands. `motions` are those of the basis.
fn without_bands(
    rig: &UploadedRig,
    panel: usize,
    motions: &[Line3],
    rest: &[[f32; 3]],
    out: &mut [Line3],
    scratch: &mut OfHandles,
) {
    let OfHandles { rows, columns } = scratch;
    if rig.rotations.is_none() {
        rig.basis.group(rig.vectors, panel, motions, rest, out, rows);
        return;
    }
    let mut blend = |motion: &[Line3], out: &mut [Line3]| {
        rig.basis.group(rig.vectors, panel, motion, &[[0.0; 3]; PANEL][..out.len()], out, rows);
    };
    let mut motions = motions.chunks_exact(rig.basis.width());
    if let Some(motion) = motions.next() {
        blend(motion, out);
    }
    for (column, motion) in columns.iter_mut().zip(motions) {
        column.resize(PANEL, ZERO);
        blend(motion, &mut column[..out.len()]);
    }
    rig.vectors.run(Turn { columns, rest, center: rig.rest[rig.center], out });
}

/// A panel where the handles turn.
struct Turn<'a> {
    columns: &'a [Vec<Line3>; 3],
    rest: &'a [[f32; 3]],
    center: [f32; 3],
    /// First the displacements at the centre, then the positions of the vertices.
    out: &'a mut [Line3],
}

impl WithSimd for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (i, (out, rest)) in self.out.iter_mut().zip(self.rest).enumerate() {
            let from_center = splat3(simd, &vec3::sub(*rest, self.center));
            let rest = splat3(simd, rest);
            for register in 0..GROUP / S::F32_LANES {
                let load = |lines| load3(simd, lines, register);
                let columns = self.columns.each_ref().map(|column| load(&column[i]));
                let moved = large_scale::turned(load(out), columns, from_center);
                store3(vec3::add(rest, moved), out, register);
            }
        }
    }
}

/// The results of frames × V, in chunks of [`CHUNK`] vertices in every frame.
fn chunks<'a>(
    results: &'a mut [[f32; 3]],
    rig: &UploadedRig,
) -> impl IndexedParallelIterator<Item = Vec<&'a mut [[f32; 3]]>> {
    let vertices = rig.rest.len();
    let mut chunks: Vec<Vec<&mut [[f32; 3]]>> = Vec::new();
    chunks.resize_with(vertices.div_ceil(CHUNK), || Vec::with_capacity(GROUP));
    for frame in results.chunks_exact_mut(vertices) {
        for (results, chunk) in frame.chunks_mut(CHUNK).zip(&mut chunks) {
            chunk.push(results);
        }
    }
    chunks.into_par_iter()
}

/// Transposes from one vertex in all frames to all vertices in one frame, four lines by four frames at a
/// time.
fn interleave(vectors: &[Line3], mut frames: Vec<&mut [[f32; 3]]>) {
    let prefetch = Prefetch::new();
    let (lines, last) = vectors.as_flattened().as_chunks::<4>();
    for (q, frames) in frames.chunks_mut(4).enumerate() {
        for (i, lines) in lines.iter().enumerate() {
            if i % 4 == 0 {
                let ahead = 4 * i + AHEAD..4 * i + AHEAD + GROUP;
                for out in &*frames {
                    let ahead = out.as_flattened().get(ahead.clone()).unwrap_or_default();
                    prefetch.ask(bytemuck::cast_slice(ahead));
                }
            }
            let four = lines.each_ref().map(|line| Vec4::from_slice(&line.0[4 * q..]));
            let by_frame = Mat4::from_cols(four[0], four[1], four[2], four[3]).transpose();
            for (out, numbers) in frames.iter_mut().zip(by_frame.to_cols_array_2d()) {
                out.as_flattened_mut()[4 * i..4 * i + 4].copy_from_slice(&numbers);
            }
        }
        for (lane, out) in frames.iter_mut().enumerate() {
            let out = &mut out.as_flattened_mut()[4 * lines.len()..];
            out.iter_mut().zip(last).for_each(|(out, line)| *out = line.0[4 * q + lane]);
        }
    }
}

/// A panel's bands.
struct AddBands<'a> {
    bands: &'a Bands,
    terms: Terms<'a, GroupCells, Line>,
    scratch: &'a mut bands::Scratch,
    first: usize,
    stage: Stage,
    out: &'a mut [Line3],
}

impl WithSimd for AddBands<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { bands, terms, scratch, first, stage, out } = self;
        bands.group(simd, first, stage, terms, scratch, out);
    }
}

/// A panel from the large scale on: the detail or the positions.
struct Fine<'a> {
    rig: &'a UploadedRig,
    detail: &'a Detail,
    mesh: &'a GroupMesh,
    smooth: &'a [Line3],
    table: &'a CellTable<GroupCells>,
    scratch: &'a mut Scratch,
    first: usize,
    stage: Stage,
    out: &'a mut [Line3],
    times: &'a Times,
}

impl WithSimd for Fine<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { rig, smooth, first, .. } = self;
        let Scratch { normals, details, distances } = self.scratch;
        let (normals, details) = (&mut normals[..self.out.len()], &mut details[..self.out.len()]);
        let start = Instant::now();
        self.mesh.normals(simd, smooth, first, normals);
        let start = self.times.add(Stage::LargeScaleNormals, start);
        self.detail.group(simd, first, &rig.influences, self.table, distances, details);
        let start = self.times.add(Stage::Detail, start);
        if self.stage == Stage::Detail {
            self.out.copy_from_slice(details);
            return;
        }
        for (i, out) in self.out.iter_mut().enumerate() {
            let neighbor = rig.tangent_neighbors[first + i] as usize;
            for register in 0..GROUP / S::F32_LANES {
                let load = |lines| load3(simd, lines, register);
                let own = load(&smooth[first + i]);
                let to_neighbor = vec3::sub(load(&smooth[neighbor]), own);
                let axes = fine_scale::tangent_frame(to_neighbor, load(&normals[i]));
                store3(fine_scale::add_detail(own, axes, load(&details[i])), out, register);
            }
        }
        self.times.add(Stage::Positions, start);
    }
}

/// The normals of consecutive vertices.
struct Normals<'a> {
    mesh: &'a GroupMesh,
    positions: &'a [Line3],
    first: usize,
    out: &'a mut [Line3],
}

impl WithSimd for Normals<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.mesh.normals(simd, self.positions, self.first, self.out);
    }
}
