//! What a plan consists of.

use crate::Stage;
use rhytid_kernels::table::{Buffer, Kernel};
use std::borrow::Cow;
use std::ops::Range;

/// A buffer to make.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlannedBuffer {
    /// Which of the kernels' buffers.
    pub buffer: Buffer,
    /// Its size: a multiple of 4, at least 16.
    pub bytes: u64,
    /// What it is for.
    pub role: Role,
}

/// What a buffer is for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Role {
    /// Filled once, from [`super::Plan::contents`].
    Constant {
        /// The vertices of a tiled buffer. `None` for a buffer that is whole.
        part: Option<Range<usize>>,
    },
    /// Filled for each batch, from [`super::Plan::inputs`].
    Input {
        /// Which slice.
        slice: usize,
    },
    /// Written by a kernel for another kernel, not for the host.
    Scratch {
        /// Which slice.
        slice: usize,
    },
    /// Written by a kernel.
    Result {
        /// Which slice.
        slice: usize,
        /// The stage that it holds.
        stage: Stage,
    },
}

/// Consecutive frames of a batch whose results share their buffers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Slice {
    /// The frames, counted from the first of the batch.
    pub frames: Range<usize>,
    /// The indices of the buffers of their results, in the order of [`Stage::ALL`].
    pub results: [usize; 6],
}

/// What a buffer is filled with for a batch.
#[derive(Debug, Clone, PartialEq)]
pub struct Input<'a> {
    /// The index of the buffer.
    pub buffer: usize,
    /// The new first numbers of the buffer.
    pub numbers: Cow<'a, [f32]>,
}

/// One run of a kernel.
#[derive(Debug, Clone, PartialEq)]
pub struct Dispatch {
    /// Which kernel.
    pub kernel: Kernel,
    /// Frames of an invocation: the kernel's constant `FRAMES`, or 1 for a kernel without it.
    pub frames_at_once: u32,
    /// The stage that it computes, or a part of it. Before it, the earlier stages must be finished. In its
    /// own stage, the earlier dispatches of other kernels must be finished.
    pub stage: Stage,
    /// The indices of its buffers, in the order of its bindings.
    pub buffers: Vec<usize>,
    /// Its parameter block.
    pub params: Vec<u32>,
    /// Workgroups along x and y; z has one.
    pub workgroups: [u32; 2],
}

impl Dispatch {
    /// Whether this dispatch can begin only when `before`, the dispatch before it, is finished.
    pub fn follows(&self, before: &Self) -> bool {
        (self.stage, self.kernel) != (before.stage, before.kernel)
    }
}
