//! An animation before its first frame, as every format is given it.

use super::recipe::StatedRecipe;
use rhytid_core::channel::{self, Channel};
use rhytid_core::numbers::first_not_finite;
use rhytid_core::{Error, Faces, Materials, Result, Rig, RigidMotion, UpAxis, Uvs};

/// What is known of an animation before its first frame.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// Names the mesh in the file; any text.
    pub name: &'a str,
    /// V×3 rest positions in mesh units.
    pub rest: &'a [[f32; 3]],
    /// V×3 normals of the rest mesh, of length 1, or 0 at a vertex without area; `None` where the file is to
    /// have no normals.
    pub rest_normals: Option<&'a [[f32; 3]]>,
    /// The channels of every frame beside its positions, in the order of the file. Normals are among them if
    /// there are rest normals.
    pub channels: &'a [Channel],
    /// The polygons of the input mesh.
    pub faces: &'a Faces,
    /// The polygons cut into triangles, for formats that have triangles alone. Each triangle has three
    /// corners as indices into [`Faces::indices`], so that texture coordinates per corner are found.
    pub triangle_corners: &'a [[u32; 3]],
    /// Texture coordinates of the input mesh.
    pub uvs: Option<&'a Uvs>,
    /// The materials that the input mesh names.
    pub materials: Option<&'a Materials>,
    /// The head pose in the world in each frame. `None` if it is not known: the head then never moves.
    pub head: Option<&'a [RigidMotion]>,
    /// Metres in one mesh unit.
    pub metres_per_unit: f64,
    /// The mesh's up axis.
    pub up_axis: UpAxis,
    /// Number of frames that will follow, at least 1.
    pub frames: usize,
    /// Frames per second.
    pub rate: f64,
    /// The time code (frame number) of the first frame.
    pub first_time_code: f64,
    /// How the animation was made.
    pub recipe: &'a StatedRecipe,
    /// Further clips, whose frames follow. The fields above are those of the first clip.
    pub further: &'a [Clip<'a>],
}

/// The frames of one take among those of several.
#[derive(Debug, Clone, Copy)]
pub struct Clip<'a> {
    /// As [`Scene::head`].
    pub head: Option<&'a [RigidMotion]>,
    /// Number of frames, at least 1.
    pub frames: usize,
    /// Frames per second.
    pub rate: f64,
    /// The time code (frame number) of the first frame.
    pub first_time_code: f64,
    /// How the clip was made.
    pub recipe: &'a StatedRecipe,
}

impl<'a> Scene<'a> {
    /// A rig's mesh: one frame at 30 frames per second from time code 0, positions alone, without a head's
    /// motion.
    pub fn new(rig: &'a Rig, triangle_corners: &'a [[u32; 3]], recipe: &'a StatedRecipe) -> Self {
        Self {
            name: &rig.surface().name,
            rest: &rig.surface().rest,
            rest_normals: None,
            channels: &[],
            faces: &rig.surface().faces,
            triangle_corners,
            uvs: rig.surface().uvs.as_ref(),
            materials: rig.surface().materials.as_ref(),
            head: None,
            metres_per_unit: rig.surface().metres_per_unit,
            up_axis: rig.surface().up_axis,
            frames: 1,
            rate: 30.0,
            first_time_code: 0.0,
            recipe,
            further: &[],
        }
    }

    /// All clips, at least one.
    pub fn clips(&self) -> Vec<Clip<'a>> {
        let Self { head, frames, rate, first_time_code, recipe, .. } = *self;
        let first = Clip { head, frames, rate, first_time_code, recipe };
        std::iter::once(first).chain(self.further.iter().copied()).collect()
    }

    /// The frames of all clips.
    pub fn all_frames(&self) -> usize {
        self.clips().iter().map(|clip| clip.frames).sum()
    }

    /// Whether the frames have this channel.
    pub fn has(&self, channel: &Channel) -> bool {
        self.channels.iter().any(|known| known.name == channel.name)
    }

    /// How many numbers of a channel a frame has.
    pub fn numbers(&self, channel: &Channel) -> usize {
        channel.numbers(self.rest.len(), self.faces.len())
    }

    /// Checks every length, index and number, so that the exporters can rely on them.
    pub fn check(&self) -> Result<()> {
        match self.fault() {
            None => Ok(()),
            Some(fault) => Err(Error::bad_topology(format!("the animation of “{}”: {fault}", self.name))),
        }
    }

    /// What is wrong with the scene, as a phrase without its subject.
    pub fn fault(&self) -> Option<String> {
        let vertices = self.rest.len();
        let corners = self.faces.indices.len();
        if vertices == 0 || self.faces.is_empty() {
            return Some(format!("has {vertices} vertices and {} faces, expected some", self.faces.len()));
        }
        let rest_normals = self.rest_normals.unwrap_or_default();
        if self.rest_normals.is_some() && rest_normals.len() != vertices {
            return Some(format!("has {} rest normals for {vertices} vertices", rest_normals.len()));
        }
        if self.rest_normals.is_some() != self.has(&channel::NORMALS) {
            return Some("has rest normals or normals of its frames, expected both or none".into());
        }
        for (i, channel) in self.channels.iter().enumerate() {
            let is_twice = self.channels[..i].iter().any(|other| other.name == channel.name);
            if is_twice || channel.name == channel::POSITIONS.name || channel.width == 0 {
                return Some(format!("has the channel {} twice, or with no numbers", channel.name));
            }
        }
        if let Some(fault) = self.faces.fault(vertices) {
            return Some(fault);
        }
        if let Some(&c) = self.triangle_corners.as_flattened().iter().find(|&&c| c as usize >= corners) {
            return Some(format!("has a triangle with corner {c}, expected 0 to {}", corners - 1));
        }
        if self.triangle_corners.is_empty() {
            return Some("has no triangles".into());
        }
        if let Some(v) = first_not_finite(self.rest.as_flattened()).map(|i| i / 3) {
            return Some(format!("has a rest position that is not finite, at vertex {v}"));
        }
        if let Some(v) = first_not_finite(rest_normals.as_flattened()).map(|i| i / 3) {
            return Some(format!("has a rest normal that is not finite, at vertex {v}"));
        }
        if !(self.metres_per_unit.is_finite() && self.metres_per_unit > 0.0) {
            return Some(format!("has a unit of {} metres, expected a number above 0", self.metres_per_unit));
        }
        if let Some(fault) = self.clips().iter().find_map(Clip::fault) {
            return Some(fault);
        }
        let of_materials = || self.materials.and_then(|materials| materials.fault(self.faces));
        self.uvs.and_then(|uvs| uvs.fault(vertices, self.faces)).or_else(of_materials)
    }
}

impl Clip<'_> {
    /// What is wrong with the clip, as a phrase without its subject.
    fn fault(&self) -> Option<String> {
        if self.frames == 0 {
            return Some("has no frames, expected at least 1".into());
        }
        if !(1e-6..=1e6).contains(&self.rate) {
            return Some(format!("has {} frames per second, expected 0.000001 to 1000000", self.rate));
        }
        // Time codes are doubles: beyond this, neighbours would be equal.
        if !(self.first_time_code.abs() <= 1e12 && self.frames as f64 <= 1e12) {
            return Some(format!(
                "has {} frames from time code {}, expected at most 10¹²",
                self.frames, self.first_time_code
            ));
        }
        self.head.and_then(|head| self.fault_of_head(head))
    }

    fn fault_of_head(&self, head: &[RigidMotion]) -> Option<String> {
        if head.len() != self.frames {
            return Some(format!("has {} head motions for {} frames", head.len(), self.frames));
        }
        let bad = head.iter().position(|motion| !motion.is_rigid())?;
        Some(format!("has a head motion in frame {bad} (from 0) that is not rigid"))
    }
}
