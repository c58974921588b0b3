//! What each vertex is part of: the skin that is seen, or what is inside of it and behind it.
use crate::FacePlaces;
use crate::exposure::exposure;
use rhytid_core::{Materials, Rig, SurfacePoint, Tissue, VertexId};
use rhytid_geometry::{Topology, components};
use rhytid_kernels::Real;
use serde::Serialize;

/// Skin is inside if less than this part of the directions that it faces is open.
const INSIDE: f64 = 0.1;

/// A part of a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FacePart {
    /// Skin that is seen from outside.
    Skin,
    /// The inside of the mouth, with gums and tongue.
    Mouth,
    /// Teeth.
    Teeth,
    /// Eyeballs, and what is clear before them.
    Eyes,
    /// Lashes, brows and other hair.
    Hair,
    /// Skin that is not seen elsewhere than in the mouth: in sockets, nostrils and behind lids.
    Inside,
    /// Other parts without a handle.
    Other,
}

impl FacePart {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Skin, Self::Mouth, Self::Teeth, Self::Eyes, Self::Hair, Self::Inside, Self::Other];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Skin => "skin",
            Self::Mouth => "inside of the mouth",
            Self::Teeth => "teeth",
            Self::Eyes => "eyes",
            Self::Hair => "lashes and hair",
            Self::Inside => "sockets and nostrils",
            Self::Other => "other parts",
        }
    }
}

/// The part of each of a rig's V vertices.
///
/// Connected parts with a handle are skin where they are seen from outside. What the other parts are is known
/// from the materials, as far as these say it or the solve recognised it.
pub fn face_parts<T: Real>(rig: &Rig<T>) -> Vec<FacePart> {
    let surface = rig.surface();
    let triangles = surface.joined_triangles();
    let (part_of, count) = components(rig.vertices(), triangles.iter());
    let mut has_handle = vec![false; count];
    for v in rig.handles().points.iter().flat_map(SurfacePoint::triangle) {
        has_handle[part_of[surface.first(v.0) as usize] as usize] = true;
    }
    let tissues = tissues(rig);
    let mut parts = vec![FacePart::Other; rig.vertices()];
    for (v, part) in parts.iter_mut().enumerate() {
        *part = match tissues[v] {
            Tissue::Eye | Tissue::Iris | Tissue::Clear => FacePart::Eyes,
            Tissue::Teeth => FacePart::Teeth,
            Tissue::Mouth => FacePart::Mouth,
            Tissue::Hair => FacePart::Hair,
            Tissue::Skin if has_handle[part_of[v] as usize] => FacePart::Skin,
            Tissue::Skin => FacePart::Other,
        };
    }

    // Only eyeballs hide skin as well: what is under hair is still skin.
    let hides = |t: &&[u32; 3]| matches!(parts[t[0] as usize], FacePart::Skin | FacePart::Eyes);
    let hiding: Vec<[u32; 3]> = triangles.iter().filter(hides).copied().collect();
    let rest: Vec<[f64; 3]> = surface.rest.iter().map(|x| x.map(T::widen)).collect();
    let seen = exposure(&rest, &hiding, &Topology::new(rest.len(), &hiding));
    let places = FacePlaces::of_rig(rig);
    for v in 0..parts.len() {
        let first = surface.first(v as u32) as usize;
        if parts[v] == FacePart::Skin && seen[first] < INSIDE {
            let is_mouth = places.as_ref().is_some_and(|places| places.is_at_mouth(rest[v]));
            parts[v] = if is_mouth { FacePart::Mouth } else { FacePart::Inside };
        }
    }
    surface.copies().for_each(|(v, first): (VertexId, VertexId)| parts[v.index()] = parts[first.index()]);
    parts
}

/// The tissue of each vertex: that of the last face around it.
fn tissues<T: Real>(rig: &Rig<T>) -> Vec<Tissue> {
    let mut tissues = vec![Tissue::Skin; rig.vertices()];
    let Some(materials) = &rig.surface().materials else { return tissues };
    for (face, &material) in rig.surface().faces.iter().zip(&materials.of_face) {
        if material != Materials::NONE {
            face.iter().for_each(|&v| tissues[v as usize] = materials.list[material as usize].tissue);
        }
    }
    tissues
}
