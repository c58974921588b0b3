//! Texture coordinates on their way into a mesh.

use rhytid_core::{Mesh, Uvs};

/// Texture coordinates of face corners, gathered while a mesh is read.
#[derive(Default)]
pub(super) struct CornerUvs {
    /// The coordinates.
    pub values: Vec<[f32; 2]>,
    /// For each corner of the mesh, its entry in `values`, or [`NONE`].
    corners: Vec<u32>,
}

/// The entry of a corner without a texture coordinate.
pub(super) const NONE: u32 = u32::MAX;

/// The entry of a corner that names a texture coordinate which the file cannot have.
pub(super) const MISSING: u32 = u32::MAX - 1;

/// The coordinate of corners without one.
const NOWHERE: [f32; 2] = [0.0; 2];

impl CornerUvs {
    /// With coordinates that come first.
    pub(super) fn new(values: Vec<[f32; 2]>) -> Self {
        Self { values, corners: Vec::new() }
    }

    /// Adds a corner with its entry in the values, which may come later.
    pub(super) fn push(&mut self, entry: u32) {
        self.corners.push(entry);
    }

    /// Adds corners without a coordinate.
    pub(super) fn push_none(&mut self, corners: usize) {
        self.corners.resize(self.corners.len() + corners, NONE);
    }

    /// Puts the coordinates into the mesh, in their simplest form. Corners without one are at [`NOWHERE`],
    /// and a warning counts them. If all are, the mesh has no texture coordinates.
    pub(super) fn finish(mut self, mesh: &mut Mesh, name: &str) {
        let all = self.corners.len();
        let (mut without, mut past, mut odd) = (0, 0, 0);
        for &entry in &self.corners {
            match self.values.get(entry as usize) {
                _ if entry == NONE => without += 1,
                None => past += 1,
                Some(uv) if !uv.iter().all(|x| x.is_finite()) => odd += 1,
                Some(_) => {}
            }
        }
        let has_some = without + past + odd < all;
        if past + odd > 0 || (has_some && without > 0) {
            warn(name, all, [without, past, odd], has_some);
        }
        if !has_some {
            return;
        }
        for uv in self.values.iter_mut().filter(|uv| !uv.iter().all(|x| x.is_finite())) {
            *uv = NOWHERE;
        }
        let known = self.values.len() as u32;
        if without + past > 0 {
            self.values.push(NOWHERE);
        }
        self.corners.iter_mut().for_each(|entry| *entry = known.min(*entry));
        let per_vertex = self.values.len() == mesh.positions.len() && self.corners == mesh.faces.indices;
        mesh.uvs = Some(Uvs { values: self.values, corners: (!per_vertex).then_some(self.corners) });
    }
}

/// Says once how many of `all` corners have no usable coordinate, and why.
fn warn(name: &str, all: usize, [without, past, odd]: [usize; 3], has_some: bool) {
    let reasons = [
        (without, "without any"),
        (past, "with one past the last of the file"),
        (odd, "with one that is not a number"),
    ];
    let found = reasons.iter().filter(|(count, _)| *count > 0);
    let found: Vec<String> = found.map(|(count, what)| format!("{count} {what}")).collect();
    let fate = match has_some {
        true => "they get 0 0 and the others keep theirs; unwrap those parts if an image is to cover them",
        false => "the mesh has no texture coordinates; export it with them if an image is to cover it",
    };
    log::warn!(
        "{name}: {} of {all} face corners have no usable texture coordinates ({}), so {fate}",
        without + past + odd,
        found.join(", ")
    );
}
