//! The numbers of the file: the result of a compression.

use crate::Deviation;

/// Numbers of a vertex attribute, V×3, as an accessor holds them. Elements of integers are to be padded to
/// four bytes in the file.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Component type 5126.
    F32(Vec<f32>),
    /// Component type 5122, normalised: n stands for n / 32767. Never −32768.
    I16(Vec<i16>),
    /// Component type 5120, normalised: n stands for n / 127. Never −128.
    I8(Vec<i8>),
}

impl Values {
    /// The value that number `i` stands for.
    pub fn get(&self, i: usize) -> f64 {
        match self {
            Self::F32(values) => f64::from(values[i]),
            Self::I16(values) => f64::from(values[i]) / 32767.0,
            Self::I8(values) => f64::from(values[i]) / 127.0,
        }
    }
}

/// The normalised 16-bit integer nearest to x.
pub(super) fn to_i16(x: f64) -> i16 {
    (x * 32767.0).round().clamp(-32767.0, 32767.0) as i16
}

/// The normalised 8-bit integer nearest to x.
pub(super) fn to_i8(x: f64) -> i8 {
    (x * 127.0).round().clamp(-127.0, 127.0) as i8
}

/// One morph target.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Any text, different from the other targets' names.
    pub name: String,
    /// Offsets of the positions, in units of the node's scale.
    pub positions: Values,
    /// Offsets of the normals, where the frames had normals.
    pub normals: Option<Values>,
}

/// Where the result is furthest from what came in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Worst {
    /// In mesh units; an upper bound for a reader that computes in float32.
    pub error: f64,
    /// Counted from 0 in its clip.
    pub frame: usize,
    /// Counted from 0.
    pub vertex: usize,
}

/// V × 3 numbers of the base mesh and of each target.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    pub base: Vec<f32>,
    pub targets: Vec<Vec<f32>>,
}

/// How far an attribute is from what came in: unit normals, or another attribute over the components that
/// count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Off {
    /// The largest difference at a vertex in a frame, as a length.
    pub worst: f64,
    /// The root of the mean of its square.
    pub rms: f64,
}

/// How far the frames of a clip are from those that came in.
#[derive(Debug, Clone, PartialEq)]
pub struct ClipErrors {
    /// The largest error of a vertex in a frame.
    pub worst: Worst,
    /// The root of the mean squared distance over all vertices and frames, in mesh units.
    pub rms: f64,
    /// The errors of the other attributes, in their order.
    pub extras: Vec<Off>,
    /// The error of the unit normals, if there are some.
    pub normals: Option<Off>,
}

impl ClipErrors {
    /// The deviation of the positions.
    pub fn deviation(&self) -> Deviation {
        let Worst { error, frame, vertex } = self.worst;
        Deviation { worst: error, at: (frame, vertex), rms: self.rms }
    }
}

/// A base mesh, targets and weights; the module above has the equation.
#[derive(Debug, Clone, PartialEq)]
pub struct Morphs {
    /// The node's scale, the same along each axis; 1 without quantisation.
    pub scale: f32,
    /// The node's translation; 0 without quantisation.
    pub translation: [f32; 3],
    /// Positions of the base mesh; `F32` or `I16`.
    pub base: Values,
    /// Unit normals of the base mesh, where the frames had normals; `F32` or `I8`.
    pub base_normals: Option<Values>,
    /// The K targets, those that move most first; none if nothing moves further than the bound.
    pub targets: Vec<Target>,
    /// Frames × K, each within 0 and 1.
    pub weights: Vec<f32>,
    /// The other attributes of the frames, in their order.
    pub extras: Vec<Fitted>,
    /// The errors of each clip, at least one.
    pub clips: Vec<ClipErrors>,
}

impl Morphs {
    /// The largest error of a vertex in a frame of any clip, in mesh units.
    pub fn worst(&self) -> f64 {
        self.clips.iter().map(|clip| clip.worst.error).fold(0.0, f64::max)
    }
}
