//! The skin of a face in pictures, apart from what is inside and in front of it.

use rhytid_core::Rig;
use rhytid_solve::{FacePart, face_parts};

/// The parts of a rig's face, as pictures of numbers show them.
pub(crate) struct Skin<'a> {
    rig: &'a Rig,
    parts: Vec<FacePart>,
}

impl<'a> Skin<'a> {
    pub(crate) fn new(rig: &'a Rig) -> Self {
        Self { rig, parts: face_parts(rig) }
    }

    /// V numbers of the skin alone. What is not skin has none.
    pub(crate) fn only(&self, values: &[f32]) -> Vec<f32> {
        let of_skin = |(x, part): (&f32, &FacePart)| if *part == FacePart::Skin { *x } else { f32::NAN };
        values.iter().zip(&self.parts).map(of_skin).collect()
    }

    /// The triangles in a picture of the skin. Lashes and hair would hide it, and are left out.
    pub(crate) fn triangles(&self) -> Vec<[u32; 3]> {
        let is_shown = |t: &&[u32; 3]| t.iter().all(|&v| self.parts[v as usize] != FacePart::Hair);
        self.rig.surface().triangles.iter().filter(is_shown).copied().collect()
    }

    /// The triangles of what is not skin. The skin is cut away from them.
    pub(crate) fn inside(&self) -> Vec<[u32; 3]> {
        let is_shown = |t: &&[u32; 3]| t.iter().all(|&v| self.parts[v as usize] != FacePart::Skin);
        self.rig.surface().triangles.iter().filter(is_shown).copied().collect()
    }
}
