//! From time to time, results of a device are compared with those of the processor. A driver may do nothing
//! and report success, or fail later. Without the comparison, all later frames would have its errors.

mod normals;

use normals::{Normals, Wrong};
use rayon::prelude::*;
use rhytid_core::{
    Animator, Device, DeviceErrorKind, DeviceInfo, Error, Result, Rig, Session, Stage, UploadOptions,
    VertexId,
};
use std::time::{Duration, Instant};

/// Vertices that are compared when a rig is uploaded.
const AT_FIRST: usize = 1024;
/// Vertices of one frame that are compared later.
const LATER: usize = 64;
/// Normals of each frame that are computed again.
const NORMALS: usize = 16;
/// The least time between two comparisons with the processor.
const PAUSE: Duration = Duration::from_secs(1);
/// Two devices differ by rounding. A vertex may be off by this part of the face's diagonal, or of the largest
/// coordinate if that is larger.
const ROUNDING: f32 = 1e-4;
/// The bound for displacements: this many diagonals of the face, plus this many times the displacement that
/// the handles can cause.
const FARTHEST: f32 = 4.0;

/// Watches one device. A `rhytid_playback::Playback` checks every frame with it. A program with its own
/// evaluation can use it too.
pub struct Watch<'a> {
    rig: &'a Rig,
    options: UploadOptions,
    device: String,
    processor: Device,
    diagonal: f32,
    bounds: [[f32; 3]; 2],
    /// The largest displacement of a vertex if every handle moves by 1.
    gain: f32,
    normals: Normals<'a>,
    last: Instant,
    /// The vertices that are compared next, and those whose normals are compared next.
    looks: Looks,
    normal_looks: Looks,
}

impl<'a> Watch<'a> {
    /// Begins to watch a device to which `rig` has just been uploaded. `None` where there is nothing to
    /// compare with, as for the processor itself.
    ///
    /// # Errors
    /// [`Error::Device`] if the device does not compute one frame as the processor does.
    pub fn begin(
        rig: &'a Rig,
        options: UploadOptions,
        info: &DeviceInfo,
        animator: &mut Animator<impl Session>,
    ) -> Result<Option<Self>> {
        if info.backend == "cpu" {
            return Ok(None);
        }
        let Some(processor) = crate::backends::find("cpu:0") else { return Ok(None) };
        let processor = crate::backends::open(&processor)?;
        let (low, high) = rig.surface().rest.iter().fold(([f32::MAX; 3], [f32::MIN; 3]), |(low, high), x| {
            ([0, 1, 2].map(|c| low[c].min(x[c])), [0, 1, 2].map(|c| high[c].max(x[c])))
        });
        let diagonal = (0..3).map(|c| (high[c] - low[c]).powi(2)).sum::<f32>().sqrt();
        let gain = |row: &[f32]| row.iter().map(|b| b.abs()).sum::<f32>();
        let gain = rig.basis().par_rows().map(gain).reduce(|| 1.0, f32::max);
        let options = UploadOptions { max_frames: 1, ..options };
        let mut watch = Self {
            rig,
            options,
            device: info.id(),
            processor,
            diagonal,
            bounds: [low, high],
            gain,
            normals: Normals::new(rig),
            last: Instant::now(),
            looks: Looks::default(),
            normal_looks: Looks::default(),
        };
        // The frame is an example. Without examples, the handles move apart.
        let handles: Vec<f32> = match rig.examples().handles.rows().next() {
            Some(example) => example.as_flattened().to_vec(),
            None => rig.handles().rest.iter().flat_map(|x| x.map(|x| 1.01 * x + 0.001 * diagonal)).collect(),
        };
        let stages = [Stage::Positions, Stage::Normals];
        let mut found = [Vec::new(), Vec::new()];
        animator.evaluate(&handles)?;
        for (stage, found) in stages.into_iter().zip(&mut found) {
            animator.read(stage, found)?;
        }
        watch.batch(&handles, &stages, &found)?;
        watch.compare(&handles, Stage::Positions, &found[0], AT_FIRST)?;
        watch.compare_normals(&found[0], &found[1], AT_FIRST)?;
        Ok(Some(watch))
    }

    /// Whether vertices of the next batch are compared: a second has passed since the last comparison. A
    /// program that does not need results on the host has to read those of such a batch.
    pub fn is_due(&self) -> bool {
        self.last.elapsed() > PAUSE
    }

    /// Checks `stages` of a batch, with the result of each in `found`. All positions must be where a face can
    /// be. From time to time, a few positions of the last frame must be those of the processor. All normals
    /// must have length 1, or 0 where the triangles have no direction. A few normals of each frame must be
    /// those of the triangles. Normals without positions are not checked. The other stages are not played,
    /// and not checked.
    ///
    /// # Errors
    /// [`Error::Device`] if a check fails; [`Error::Input`] if no device can hold the result.
    pub fn batch(&mut self, handles: &[f32], stages: &[Stage], found: &[Vec<f32>]) -> Result<()> {
        let of = |wanted| stages.iter().position(|stage| *stage == wanted).map(|i| &found[i]);
        let is_due = self.is_due();
        for stage in [Stage::LargeScale, Stage::Positions] {
            if let Some(found) = of(stage) {
                self.positions(handles, stage, found, is_due)?;
            }
        }
        for (positions, normals) in
            [(Stage::LargeScale, Stage::LargeScaleNormals), (Stage::Positions, Stage::Normals)]
        {
            let (Some(positions), Some(normals)) = (of(positions), of(normals)) else { continue };
            self.compare_normals(positions, normals, NORMALS)?;
        }
        if is_due {
            self.last = Instant::now();
        }
        Ok(())
    }

    fn positions(&mut self, handles: &[f32], stage: Stage, found: &[f32], is_due: bool) -> Result<()> {
        let (per_frame, of_frame) = (self.rig.handles().len() * 3, self.rig.vertices() * 3);
        for (handles, found) in handles.chunks_exact(per_frame).zip(found.chunks_exact(of_frame)) {
            if let Some(vertex) = self.out_of_bounds(handles, found) {
                // The handles may be where no face has them. The processor then gives the same result, which
                // is no error.
                self.compare_vertices(handles, stage, found, &[VertexId::from_index(vertex)])?;
            }
        }
        if is_due {
            let (handles, found) = (&handles[handles.len() - per_frame..], &found[found.len() - of_frame..]);
            self.compare(handles, stage, found, LATER)?;
        }
        Ok(())
    }

    /// The first vertex that is farther away than any face can go, or is not a number.
    fn out_of_bounds(&self, handles: &[f32], found: &[f32]) -> Option<usize> {
        let rest = self.rig.handles().rest.iter().flatten().copied();
        let moved = handles.iter().zip(rest).map(|(x, rest)| (x - rest).abs()).fold(0.0, f32::max);
        let most = FARTHEST * (self.diagonal + self.gain * moved);
        let [low, high] = self.bounds;
        let (low, high) = (low.map(|x| x - most), high.map(|x| x + most));
        // The blocks have no early exit, so the processor compares many at a time.
        let is_in = |block: &[[f32; 3]]| {
            block
                .iter()
                .fold(true, |all, x| (0..3).fold(all, |all, c| all & (x[c] >= low[c]) & (x[c] <= high[c])))
        };
        let (found, _) = found.as_chunks::<3>();
        let block = found.par_chunks(4096).position_first(|block| !is_in(block))?;
        let first = block * 4096;
        found[first..].iter().position(|x| !is_in(std::slice::from_ref(x))).map(|v| first + v)
    }

    /// Compares `count` vertices of a frame with the processor's.
    fn compare(&mut self, handles: &[f32], stage: Stage, found: &[f32], count: usize) -> Result<()> {
        let vertices: Vec<VertexId> =
            self.looks.next(self.rig.vertices(), count).map(VertexId::from_index).collect();
        self.compare_vertices(handles, stage, found, &vertices)
    }

    /// Checks `count` normals of each frame, and all normals whose length is not 1, by computing them again.
    fn compare_normals(&mut self, positions: &[f32], normals: &[f32], count: usize) -> Result<()> {
        let v = self.rig.vertices();
        let (positions, normals) = (positions.as_chunks().0, normals.as_chunks().0);
        let are_units = normals::are_units(normals);
        for (positions, normals) in positions.chunks_exact(v).zip(normals.chunks_exact(v)) {
            let others = if are_units { &[] } else { normals };
            let others = normals::no_units(others);
            let vertices = self.normal_looks.next(v, count).chain(others);
            if let Some(Wrong { vertex, found, expected }) =
                self.normals.first_wrong(positions, normals, vertices)
            {
                return Err(self.wrong(format!(
                    "vertex {vertex} has the normal {found:?}, and its triangles have {expected:?}"
                )));
            }
        }
        Ok(())
    }

    fn compare_vertices(
        &self,
        handles: &[f32],
        stage: Stage,
        found: &[f32],
        vertices: &[VertexId],
    ) -> Result<()> {
        let part = self.rig.part(vertices);
        let mut expected = Vec::new();
        let mut processor = self.processor.upload(&part, self.options)?;
        processor.evaluate(handles)?;
        processor.read(stage, &mut expected)?;
        let size = expected.iter().map(|x| x.abs()).fold(self.diagonal, f32::max);
        for (&v, expected) in vertices.iter().zip(expected.as_chunks::<3>().0) {
            let found = &found.as_chunks::<3>().0[v.index()];
            if expected.iter().any(|x| !x.is_finite()) {
                return Err(Error::out_of_range(format!(
                    "vertex {v} would be at {expected:?}: numbers of the rig or positions of the take are too \
                     large; solve the face again, or look for the marker that is far away"
                )));
            }
            let apart = (0..3).map(|c| (found[c] - expected[c]).powi(2)).sum::<f32>().sqrt();
            if apart.is_nan() || apart > ROUNDING * size {
                return Err(
                    self.wrong(format!("vertex {v} is at {found:?}, and the processor finds {expected:?}"))
                );
            }
        }
        Ok(())
    }

    fn wrong(&self, what: String) -> Error {
        Error::Device {
            kind: DeviceErrorKind::Driver,
            device: self.device.clone(),
            message: format!("its driver computes wrongly: {what}"),
        }
    }
}

/// The vertices to check: other ones each time.
#[derive(Default)]
struct Looks(u64);

impl Looks {
    /// Up to `count` of `vertices` vertices, evenly spread.
    fn next(&mut self, vertices: usize, count: usize) -> impl Iterator<Item = usize> + use<> {
        let step = vertices.div_ceil(count).max(1);
        // Steps of the golden section reach every part of the face soon, for any number of vertices.
        let part = self.0.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
        self.0 += 1;
        let first = ((part * step as u64) >> 32) as usize;
        (first..vertices).step_by(step)
    }
}

#[cfg(test)]
mod tests;
