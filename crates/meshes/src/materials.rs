//! The materials of faces, gathered.

use rhytid_core::{Material, Materials};
use std::collections::HashMap;

/// Collects which face has which material while a mesh is read.
#[derive(Default)]
pub(super) struct Assigned {
    indices: HashMap<String, u32>,
    materials: Materials,
    /// Of the faces to come.
    current: Option<String>,
}

impl Assigned {
    /// The faces to come have this material; `None` for none.
    pub(super) fn choose(&mut self, name: Option<String>) {
        self.current = name;
    }

    /// Faces have been added to the mesh, which has `total` now.
    pub(super) fn fill(&mut self, total: usize) {
        if total == self.materials.of_face.len() {
            return;
        }
        let index = self.current.as_ref().map(|name| match self.indices.get(name) {
            Some(&index) => index,
            None => {
                let index = self.indices.len() as u32;
                self.indices.insert(name.clone(), index);
                self.materials.list.push(Material::new(name));
                index
            }
        });
        self.materials.of_face.resize(total, index.unwrap_or(Materials::NONE));
    }

    /// `None` where no face has a material.
    pub(super) fn finish(self) -> Option<Materials> {
        (!self.materials.list.is_empty()).then_some(self.materials)
    }
}
