//! An animation read back from a file, whatever its format: what `rhytid verify` compares with a fresh evaluation,
//! and `rhytid stitch` looks at before it puts parts together. [`crate::animation::open`] opens one.

use crate::export::Provenance;
use rhytid_core::{Faces, Result, UpAxis};

/// What a file says of its animation before its first frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// The mesh's name in the file.
    pub name: String,
    /// V, the vertices of the mesh that was exported; copies that a format needs at texture seams do not count.
    pub vertices: usize,
    /// The polygons; in a format that has triangles alone, those. They index the V vertices.
    pub faces: Faces,
    /// The number of frames, at least 1.
    pub frames: usize,
    /// The time code of frame 0. Each further frame's is one more.
    pub first_time_code: f64,
    /// Frames per second.
    pub rate: f64,
    /// What the file calls frames per second, for people: that of [`Summary::rate`] where we wrote it; `None` where it does not say.
    pub frames_per_second: Option<f64>,
    /// Metres in one mesh unit.
    pub metres_per_unit: f64,
    /// The mesh's up axis, before any turn that the format asks for.
    pub up_axis: UpAxis,
    /// Whether the frames have normals.
    pub normals: bool,
    /// Whether the frames have velocities.
    pub velocities: bool,
    /// Whether the frames have principal strains.
    pub strain: bool,
    /// Whether the frames have extents: boxes around their positions, by which viewers know what is in sight. glTF has none.
    pub extents: bool,
    /// Whether the frames have the head's pose.
    pub head: bool,
    /// The largest deviation from what was exported that the file states (glTF: `worstMillimetres` in its extras), in
    /// mesh units; `None` where it states none, being exact.
    pub stated_error: Option<f64>,
    /// How far the strains are from those of the animation that was exported, as a root mean square, where the file states it (compressed glTF).
    pub stated_strain_error: Option<f64>,
    /// How the animation was made; `None` where the file does not say.
    pub provenance: Option<Provenance>,
}

impl Summary {
    /// The time code of `frame`, which counts from 0.
    pub fn time_code(&self, frame: usize) -> f64 {
        self.first_time_code + frame as f64
    }
}

/// An animation that is read frame by frame. Memory does not grow with the number of frames.
///
/// Frames count from 0. Whoever calls asks for frames below [`Summary::frames`] only. Every method returns
/// [`rhytid_core::Error::Input`] where the file turns out to be damaged, and [`rhytid_core::Error::Io`].
pub trait AnimationReader: Send {
    /// What is known of all frames.
    fn summary(&self) -> &Summary;

    /// Replaces `out` by the 3V positions of a frame, in mesh units along the mesh's own axes, without the head's
    /// motion.
    fn positions(&mut self, frame: usize, out: &mut Vec<f32>) -> Result<()>;

    /// Replaces `out` by the 3V normals of a frame; empties it where [`Summary::normals`] is false.
    fn normals(&mut self, frame: usize, out: &mut Vec<f32>) -> Result<()>;

    /// Replaces `out` by the 3V velocities of a frame, in mesh units per second; empties it where
    /// [`Summary::velocities`] is false.
    fn velocities(&mut self, frame: usize, out: &mut Vec<f32>) -> Result<()>;

    /// Replaces `out` by the 2V principal strains of a frame, the larger of each two first; empties it where [`Summary::strain`] is false.
    fn strain(&mut self, frame: usize, out: &mut Vec<f32>) -> Result<()>;

    /// The extent of a frame, its lowest and its highest corner in mesh units; `None` where [`Summary::extents`] is false.
    fn extent(&mut self, frame: usize) -> Result<Option<[[f32; 3]; 2]>>;

    /// The head pose of a frame, as [`rhytid_core::RigidMotion::matrix`] has it: for column vectors, in mesh units; `None` where [`Summary::head`] is false.
    fn head(&mut self, frame: usize) -> Result<Option<[[f64; 4]; 4]>>;
}
