//! An animation of any format read back from a file. A check compares it with a fresh evaluation, and
//! stitching compares the parts before it joins them. `rhytid_formats::animation::open` opens one.

use crate::{Deviation, Scene, StatedRecipe};
use rhytid_core::channel::{self, Channel};
use rhytid_core::text::{listed, quoted};
use rhytid_core::{Error, Faces, Remedy, Result, UpAxis};
use std::path::Path;

/// What a file says of its animation before its first frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// The mesh's name in the file.
    pub name: String,
    /// V, the vertices of the mesh that was exported; copies that a format needs at texture seams do not
    /// count.
    pub vertices: usize,
    /// The polygons, as indices of the V vertices. In a format that has triangles alone, these are the
    /// triangles. There are none in a USD layer that goes over another with the mesh.
    pub faces: Faces,
    /// The number of frames, at least 1.
    pub frames: usize,
    /// The time code of frame 0. Each further frame's is one more.
    pub first_time_code: f64,
    /// Frames per second.
    pub rate: f64,
    /// The frames per second that the file states for people: [`Summary::rate`] if Rhytid wrote the file;
    /// `None` if the file does not say.
    pub frames_per_second: Option<f64>,
    /// Metres in one mesh unit.
    pub metres_per_unit: f64,
    /// The mesh's up axis, before any turn that the format asks for.
    pub up_axis: UpAxis,
    /// Whether the frames are sums of few shapes, and so only near the frames that were exported.
    pub fitted: bool,
    /// The channels of the frames: positions, and others.
    pub channels: Vec<Channel>,
    /// Whether the frames have extents: boxes around their positions, which tell viewers what is in sight.
    /// glTF has none.
    pub extents: bool,
    /// Whether the frames have the head's pose.
    pub head: bool,
    /// The largest deviation from the exported frames that the file states, in mesh units (glTF:
    /// `worstMillimetres` in its extras). `None` if the file is exact and states none.
    pub stated_error: Option<Deviation>,
    /// The deviations of other channels from the exported ones, if the file states them (compressed glTF).
    pub stated_channel_errors: Vec<StatedError>,
    /// The recipe of the animation; `None` where the file does not say how it was made.
    pub recipe: Option<StatedRecipe>,
    /// The names of the file's clips, if it has several. All else is said of the clip that was opened.
    pub clips: Vec<String>,
}

/// The number of the clip called `name`, among those of the file `path`; the first without a name. A file of
/// one clip has no `clips`, and its only clip any name.
///
/// # Errors
/// [`Error::Input`] if there is no such clip.
pub fn clip_number(clips: &[String], name: Option<&str>, path: &Path) -> Result<usize> {
    let Some(name) = name.filter(|_| !clips.is_empty()) else { return Ok(0) };
    clips.iter().position(|clip| clip == name).ok_or_else(|| {
        Error::mismatch(format!(
            "{}: has no clip {}, expected one of {}",
            path.display(),
            quoted(name),
            listed(clips.iter().map(String::as_str))
        ))
        .with_remedies(&[Remedy::ChooseClip])
    })
}

/// The deviation of a channel from the animation that was exported, as the file states it.
#[derive(Debug, Clone, PartialEq)]
pub struct StatedError {
    /// The channel's name.
    pub channel: String,
    /// The largest difference at a vertex in a frame, as a length.
    pub worst: f64,
    /// The root of the mean of its square.
    pub rms: f64,
}

impl Summary {
    /// Whether its frames have this channel.
    pub fn has(&self, channel: &Channel) -> bool {
        self.channels.iter().any(|known| known.name == channel.name)
    }

    /// What the file states of a channel's error.
    pub fn stated_channel_error(&self, channel: &Channel) -> Option<&StatedError> {
        self.stated_channel_errors.iter().find(|stated| stated.channel == channel.name)
    }

    /// The time code of `frame`, which counts from 0.
    pub fn time_code(&self, frame: usize) -> f64 {
        self.first_time_code + frame as f64
    }
}

/// An animation that is read frame by frame. Memory does not grow with the number of frames.
///
/// Frames count from 0. Callers ask for frames below [`Summary::frames`] only. Every method returns
/// [`rhytid_core::Error::Input`] if the file turns out to be damaged, and [`rhytid_core::Error::Io`].
pub trait AnimationReader: Send {
    /// What is known of all frames.
    fn summary(&self) -> &Summary;

    /// Replaces `out` by a frame's numbers of a channel. Positions are in mesh units along the mesh's own
    /// axes, without the head's motion; other channels are as [`Channel::quantity`] says. `out` becomes empty
    /// if the file does not have the channel. A constant channel is the same in each frame.
    fn channel(&mut self, channel: &Channel, frame: usize, out: &mut Vec<f32>) -> Result<()>;

    /// The 3V positions of a frame, as [`AnimationReader::channel`].
    fn positions(&mut self, frame: usize, out: &mut Vec<f32>) -> Result<()> {
        self.channel(&channel::POSITIONS, frame, out)
    }

    /// The extent of a frame, its lowest and its highest corner in mesh units; `None` where
    /// [`Summary::extents`] is false. A file of several clips has one for all frames of all clips.
    fn extent(&mut self, frame: usize) -> Result<Option<[[f32; 3]; 2]>>;

    /// The head pose of a frame, as [`rhytid_core::RigidMotion::matrix`] has it: for column vectors, in mesh
    /// units; `None` where [`Summary::head`] is false.
    fn head(&mut self, frame: usize) -> Result<Option<[[f64; 4]; 4]>>;

    /// How the file differs from what an export of `scene` writes, apart from the numbers of its frames:
    /// every object and value that is missing, other or not expected.
    fn compare(&mut self, scene: &Scene<'_>) -> Result<Vec<String>>;
}
