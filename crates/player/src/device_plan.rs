//! What JavaScript does with a device of WebGPU: the buffers to make, and the kernels to run.
use crate::Face;
use rhytid_core::plan::{Dispatch, Plan, PlanLimits, Role};
use rhytid_core::{HandleFrames, Result, Stage, UploadOptions};
use rhytid_kernels::table::{Access, Kernel, WORKGROUP_SIZE};
use serde_json::{Map, Value, json};
use std::borrow::Cow;

/// The kernel that fills the copies of vertices at seams.
const COPIES: &str = include_str!("copies.wgsl");

/// The plan of a face for one frame at a time.
///
/// The buffers of positions and normals are (V + C) × 3 numbers: V vertices, and behind them the copies of
/// the face's [`Drawing`](crate::Drawing). They are vertex buffers as they are.
#[derive(Debug)]
pub struct DevicePlan {
    plan: Plan,
    copies: usize,
    limits: PlanLimits,
}

/// What a buffer is filled with for a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct DeviceInput {
    /// The index of the buffer.
    pub buffer: usize,
    /// The new numbers of the buffer.
    pub numbers: Vec<f32>,
}

/// A kernel, compiled once.
#[derive(Clone, Copy, PartialEq)]
struct Pipeline {
    kernel: Kernel,
    frames: u32,
}

impl DevicePlan {
    /// Plans `face` for a device with these limits.
    ///
    /// # Errors
    /// As [`UploadOptions::check`] and [`Plan::new`].
    pub fn new(face: &Face, limits: PlanLimits) -> Result<Self> {
        let options = UploadOptions { max_frames: 1, basis: face.basis() };
        options.check(face.rig())?;
        let plan = Plan::new(face.rig(), options, limits, "WebGPU")?;
        Ok(Self { plan, copies: face.drawing().copies.len(), limits })
    }

    /// The plan as JSON.
    ///
    /// - `buffers`: each with `name`, `bytes` and `use`: `constant`, `input`, `scratch` or `result`.
    /// - `pipelines`: each with `name` (the entry point), `wgsl`, `writes` (for each binding whether it is
    ///   written) and `frames` (the constant `FRAMES`, or null).
    /// - `dispatches`, in the order in which they run: each with `pipeline` and `buffers` (indices), `params`
    ///   (words), `workgroups` (x and y), `stage` and `onDemand` (whether it runs only when that stage is
    ///   read).
    /// - `results`: the index of the buffer of each stage, and `values`: how many numbers a stage has.
    pub fn facts(&self) -> Value {
        let mut pipelines: Vec<Pipeline> = Vec::new();
        let mut dispatches = Vec::new();
        for Dispatch { kernel, frames_at_once, stage, buffers, params, workgroups } in self.plan.dispatches(1)
        {
            let pipeline = Pipeline { kernel, frames: frames_at_once };
            let known = pipelines.iter().position(|known| *known == pipeline);
            let index = known.unwrap_or_else(|| {
                pipelines.push(pipeline);
                pipelines.len() - 1
            });
            dispatches.push(json!({
                "pipeline": index,
                "buffers": buffers,
                "params": params,
                "workgroups": workgroups,
                "stage": stage.name(),
                "onDemand": self.plan.is_on_demand(stage),
            }));
        }
        let mut pipelines: Vec<Value> = pipelines.iter().map(Pipeline::facts).collect();
        if self.copies > 0 {
            let groups = (self.copies as u32).div_ceil(WORKGROUP_SIZE).min(self.limits.max_workgroups);
            let vertices = self.plan.frame_bytes(Stage::Positions) / 12;
            for stage in [Stage::Positions, Stage::Normals] {
                dispatches.push(json!({
                    "pipeline": pipelines.len(),
                    "buffers": [self.buffer_of_copies(), self.result(stage)],
                    "params": [vertices, self.copies, groups * WORKGROUP_SIZE],
                    "workgroups": [groups, 1],
                    "stage": Stage::Normals.name(),
                    "onDemand": false,
                }));
            }
            pipelines.push(json!({
                "name": "copies_of_vertices",
                "wgsl": COPIES,
                "writes": [false, true],
                "frames": null,
            }));
        }
        let of_stage = |value: &dyn Fn(Stage) -> usize| {
            let values = Stage::ALL.map(|stage| (stage.name().to_owned(), json!(value(stage))));
            Value::Object(Map::from_iter(values))
        };
        json!({
            "buffers": self.buffers(),
            "pipelines": pipelines,
            "dispatches": dispatches,
            "results": of_stage(&|stage| self.result(stage)),
            "values": of_stage(&|stage| self.plan.frame_bytes(stage) / 4),
        })
    }

    fn buffers(&self) -> Vec<Value> {
        let drawn = [Stage::Positions, Stage::Normals].map(|stage| self.result(stage));
        let planned = self.plan.buffers().iter().enumerate().map(|(i, planned)| {
            let copies = if drawn.contains(&i) { self.copies as u64 * 12 } else { 0 };
            let role = match planned.role {
                Role::Constant { .. } => "constant",
                Role::Input { .. } => "input",
                Role::Scratch { .. } => "scratch",
                Role::Result { .. } => "result",
            };
            json!({ "name": planned.buffer.name(), "bytes": planned.bytes + copies, "use": role })
        });
        let copies = json!({ "name": "copies", "bytes": self.copies * 4, "use": "constant" });
        planned.chain((self.copies > 0).then_some(copies)).collect()
    }

    /// The index of the buffer with the vertices of the copies, behind those of the plan.
    fn buffer_of_copies(&self) -> usize {
        self.plan.buffers().len()
    }

    /// The index of the buffer of a stage's result.
    fn result(&self, stage: Stage) -> usize {
        // One frame is one slice.
        self.plan.slices(1).map(|slice| slice.results[stage as usize]).next().unwrap_or(0)
    }

    /// The content of a constant buffer. Empty for the others. `face` must be the one that was planned.
    pub fn contents<'a>(&self, face: &'a Face, buffer: usize) -> Cow<'a, [u8]> {
        if buffer == self.buffer_of_copies() {
            return face.drawing().copies.iter().flat_map(|copy| copy.to_le_bytes()).collect();
        }
        self.plan.contents(face.rig(), buffer)
    }

    /// What to write before a frame of these H×3 handle positions runs.
    ///
    /// # Errors
    /// As [`HandleFrames::checked`].
    pub fn inputs(&self, positions: &[f32]) -> Result<Vec<DeviceInput>> {
        let frames = HandleFrames::checked(positions, self.plan.values_per_frame() / 3, 1)?;
        let input = |input: rhytid_core::plan::Input<'_>| DeviceInput {
            buffer: input.buffer,
            numbers: input.numbers.into_owned(),
        };
        Ok(self.plan.inputs(frames).map(input).collect())
    }
}

impl Pipeline {
    fn facts(&self) -> Value {
        let entry = self.kernel.entry();
        let writes: Vec<bool> = entry.bindings.iter().map(|b| b.access != Access::Read).collect();
        json!({
            "name": entry.name,
            "wgsl": entry.wgsl,
            "writes": writes,
            "frames": entry.batched.then_some(self.frames),
        })
    }
}
