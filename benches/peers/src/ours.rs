//! Rhytid's own side: the CPU backend.
use crate::FRAMES;
use crate::times::{Side, Times, What};
use rhytid_backend_cpu::{Cpu, CpuSession};
use rhytid_core::{Animator, BasisStorage, Error, Result, Rig, Stage, UploadOptions};
use std::time::{Duration, Instant};

/// A rig on the CPU backend, and the handle positions to evaluate.
pub(crate) struct Ours<'a> {
    animator: Animator<CpuSession>,
    handles: &'a [f32],
}

impl<'a> Ours<'a> {
    /// `handles` is [`FRAMES`] × H × 3, mesh units.
    pub(crate) fn new(rig: &Rig, handles: &'a [f32], basis: BasisStorage) -> Result<Self> {
        let animator = Animator::new(&Cpu, rig, UploadOptions { basis, ..UploadOptions::frames(FRAMES) })?;
        Ok(Self { animator, handles })
    }

    /// The handle positions to evaluate: frames × H × 3.
    pub(crate) fn handles(&self, what: What) -> &'a [f32] {
        &self.handles[..self.handles.len() / FRAMES * what.frames()]
    }

    /// Positions and normals, each frames × V × 3.
    pub(crate) fn results(&mut self, what: What) -> Result<[Vec<f32>; 2]> {
        self.evaluate(what)?;
        let mut results = [Vec::new(), Vec::new()];
        self.animator.read(Stage::Positions, &mut results[0])?;
        self.animator.read(Stage::Normals, &mut results[1])?;
        Ok(results)
    }
}

impl Side for Ours<'_> {
    fn evaluate(&mut self, what: What) -> Result<Times> {
        let handles = self.handles(what);
        let start = Instant::now();
        self.animator.evaluate(handles)?;
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        let whole = ms(start.elapsed());
        let stages = self.animator.stage_times()?;
        let stages = stages.ok_or_else(|| Error::Internal("the CPU backend has no stage times".into()))?;
        let [strain, large_scale, large_scale_normals, detail, positions, normals] = stages.map(ms);
        let detail = strain + detail + positions;
        Ok(Times { large_scale, large_scale_normals, detail, normals, rearranging: 0.0, whole })
    }
}
