//! A rig's frames. The device that draws evaluates them, or another device does and passes them on.

use crate::edits::{EditedFrame, FrameEdits};
use crate::gpu::Gpu;
use crate::open_mesh::MeshFrames;
use crate::same::Same;
use rayon::prelude::*;
use rhytid_backend_cpu::Cpu;
use rhytid_backend_wgpu::WgpuSession;
use rhytid_core::{Animator, Backend, Error, Result, Rig, Session, Stage, UploadOptions};
use rhytid_kernels::normals::{VertexTriangles, vertex_normal};
use rhytid_render::{FrameBuffers, Vertices};
use std::sync::Arc;

/// The request for a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Wanted {
    /// The factor of the wrinkles, from 0 (only the large scale) to 2.
    pub gain: f32,
    /// Whether the whole frame is needed on the host, as for heat maps.
    pub on_host: bool,
    /// The frame of a mesh without a rig.
    pub frame: usize,
}

/// The effects of edits and pulls, and what they were made of.
struct Effects {
    moved: Vec<bool>,
    edits: Option<Same<FrameEdits>>,
    made: Arc<FrameEdits>,
}

/// A device that was opened for evaluation.
pub(crate) type OtherDevice = Animator<Box<dyn Session>>;

/// Evaluates one frame at a time.
pub(crate) struct FrameSource {
    rig: Arc<Rig>,
    /// The frames of a mesh without a rig, which are not evaluated.
    frames: Option<Same<MeshFrames>>,
    gpu: Gpu,
    /// The evaluation on the device that draws. `None` where another device was chosen, or where the device
    /// cannot evaluate.
    drawn: Option<Animator<WgpuSession>>,
    /// The chosen device. Where none was chosen, it is the processor, as soon as frames are needed on the
    /// host, or always where the device that draws cannot evaluate.
    other: Option<OtherDevice>,
    buffers: FrameBuffers,
    triangles: VertexTriangles,
    is_on_host: bool,
    positions: Vec<f32>,
    normals: Vec<f32>,
    large_scale: Vec<f32>,
    /// The effects of the last edits and pulls.
    effects: Option<Effects>,
    /// Positions, normals and large scale without the edits of handles. They are needed where edits have a
    /// falloff.
    without: [Vec<f32>; 3],
}

impl FrameSource {
    /// The frames of `rig`, drawn by `gpu`. Without an `other` device, `gpu` also evaluates them if it can. A
    /// mesh without a rig has `frames` of its own.
    ///
    /// # Errors
    /// As [`Animator::new`].
    pub(crate) fn new(
        rig: Arc<Rig>,
        gpu: &Gpu,
        other: Option<OtherDevice>,
        frames: Option<Same<MeshFrames>>,
    ) -> Result<Self> {
        let kernels = gpu.kernels().filter(|_| other.is_none() && frames.is_none());
        let upload = |wgpu| Animator::new(wgpu, &rig, UploadOptions::frames(1));
        let drawn = kernels.map(upload).transpose()?;
        Ok(Self {
            drawn,
            other,
            buffers: FrameBuffers::new(gpu.device(), gpu.queue(), rig.vertices())?,
            triangles: rig.surface().vertex_triangles(),
            gpu: gpu.clone(),
            is_on_host: false,
            effects: None,
            positions: Vec::new(),
            normals: Vec::new(),
            large_scale: Vec::new(),
            without: Default::default(),
            frames,
            rig,
        })
    }

    /// Evaluates a frame: H × 3 handle positions.
    ///
    /// # Errors
    /// As [`Animator::evaluate`].
    pub(crate) fn evaluate(
        &mut self,
        handles: &[f32],
        wanted: Wanted,
        edits: Option<&EditedFrame>,
    ) -> Result<()> {
        let is_direct = wanted.gain == 1.0 && !wanted.on_host && edits.is_none();
        if let (true, Some(drawn)) = (is_direct, &mut self.drawn) {
            drawn.evaluate(handles)?;
            // Waits, so that its time is measured apart from the drawing.
            drawn.session().wait()?;
            self.is_on_host = false;
            return Ok(());
        }
        self.evaluate_on_host(handles, wanted, edits)?;
        self.buffers.set(&self.positions, &self.normals, &[]);
        Ok(())
    }

    /// The numbers of a heat map, V of them, for the frame that was evaluated.
    pub(crate) fn set_numbers(&self, numbers: &[f32]) {
        self.buffers.set(&[], &[], numbers);
    }

    /// The last frame, for drawing.
    pub(crate) fn vertices(&self) -> Result<Vertices<'_>> {
        let Some(drawn) = self.drawn.as_ref().filter(|_| !self.is_on_host) else {
            return Ok(self.buffers.vertices());
        };
        let result = |stage| {
            let slice = drawn.session().results(stage).next().map(|(_, buffer)| buffer.slice(..));
            slice.ok_or_else(|| Error::Internal("a frame was evaluated and has no result".into()))
        };
        Ok(Vertices { positions: result(Stage::Positions)?, normals: result(Stage::Normals)?, numbers: None })
    }

    /// V × 3 positions and those of the large scale of a frame, on the host.
    ///
    /// # Errors
    /// As [`Animator::evaluate`].
    pub(crate) fn on_host(
        &mut self,
        handles: &[f32],
        wanted: Wanted,
        edits: Option<&EditedFrame>,
    ) -> Result<[&[f32]; 2]> {
        self.evaluate_on_host(handles, wanted, edits)?;
        Ok([&self.positions, &self.large_scale])
    }

    /// The same for the last frame, if it was requested on the host.
    pub(crate) fn last_on_host(&self) -> [&[f32]; 2] {
        [&self.positions, &self.large_scale]
    }

    fn evaluate_on_host(
        &mut self,
        handles: &[f32],
        wanted: Wanted,
        edits: Option<&EditedFrame>,
    ) -> Result<()> {
        self.is_on_host = true;
        let gain = wanted.gain;
        if let Some(frames) = &self.frames {
            frames.read(wanted.frame, &mut self.positions)?;
            self.large_scale.clone_from(&self.positions);
            self.compute_normals();
            return Ok(());
        }
        let effects = edits.map(|edits| self.effects_of(edits));
        let edits = edits.zip(effects.as_deref());
        if let Some(without) = edits.and_then(|(edits, _)| edits.without.as_ref()) {
            self.evaluate_one(without.as_flattened(), gain, edits)?;
            self.without =
                [&mut self.positions, &mut self.normals, &mut self.large_scale].map(std::mem::take);
        }
        self.evaluate_one(handles, gain, edits)?;
        let Some((edits, effects)) = edits else { return Ok(()) };
        let (positions, _) = self.positions.as_chunks_mut::<3>();
        let (normals, _) = self.normals.as_chunks_mut::<3>();
        if edits.without.is_some() {
            let [x, n, large_scale] = self.without.each_ref().map(|numbers| numbers.as_chunks::<3>().0);
            effects.blend(&self.rig, &self.triangles, [x, n], positions, normals);
            // The wrinkles are the difference of the two.
            let (large, _) = self.large_scale.as_chunks_mut::<3>();
            effects.blend(&self.rig, &self.triangles, [large_scale, &[]], large, &mut []);
        }
        let (handles, _) = handles.as_chunks::<3>();
        effects.correct(&self.rig, &self.triangles, edits.time, handles, positions, normals);
        Ok(())
    }

    /// The effects of edits and pulls. They are the same in all frames of a take, so the last ones are kept.
    fn effects_of(&mut self, edits: &EditedFrame) -> Arc<FrameEdits> {
        if let Some(kept) = &self.effects
            && kept.moved == edits.moved
            && kept.edits == edits.edits
        {
            return kept.made.clone();
        }
        let none = FrameEdits::default();
        let of_file = edits.edits.as_deref().unwrap_or(&none);
        let made = Arc::new(of_file.with_edited(&self.rig, &edits.moved));
        let kept = Effects { moved: edits.moved.clone(), edits: edits.edits.clone(), made: made.clone() };
        self.effects = Some(kept);
        made
    }

    /// Positions, large scale and normals of H × 3 handle positions. Their wrinkles are multiplied by `gain`.
    fn evaluate_one(
        &mut self,
        handles: &[f32],
        gain: f32,
        edits: Option<(&EditedFrame, &FrameEdits)>,
    ) -> Result<()> {
        let other = match &mut self.other {
            Some(other) => other,
            none => {
                let found = Cpu::devices()?.into_iter().next();
                let info = found.ok_or_else(|| Error::Internal("there is no processor".into()))?;
                let animator = Animator::new(&Cpu::open(&info)?, &self.rig, UploadOptions::frames(1))?;
                none.insert(animator.boxed())
            }
        };
        other.evaluate(handles)?;
        other.read(Stage::Positions, &mut self.positions)?;
        other.read(Stage::LargeScale, &mut self.large_scale)?;
        let scale = |(edits, effects): (&EditedFrame, &FrameEdits)| {
            effects.scale_wrinkles(edits.time, &self.large_scale, &mut self.positions)
        };
        let scaled = edits.is_some_and(scale);
        if gain == 1.0 && !scaled {
            return other.read(Stage::Normals, &mut self.normals);
        }
        for (x, large) in self.positions.iter_mut().zip(&self.large_scale) {
            *x = large + gain * (*x - large);
        }
        self.compute_normals();
        Ok(())
    }

    /// The normals of the present positions.
    fn compute_normals(&mut self) {
        let (points, _) = self.positions.as_chunks::<3>();
        let normal = |v: usize| vertex_normal(points, &self.rig.surface().triangles, self.triangles.at(v));
        self.normals.resize(self.positions.len(), 0.0);
        let (normals, _) = self.normals.as_chunks_mut::<3>();
        normals.par_iter_mut().enumerate().for_each(|(v, n)| *n = normal(v));
    }

    /// The frames of a mesh without a rig.
    pub(crate) fn frames(&self) -> Option<Same<MeshFrames>> {
        self.frames.clone()
    }

    /// The device that draws.
    pub(crate) fn gpu(&self) -> &Gpu {
        &self.gpu
    }
}
