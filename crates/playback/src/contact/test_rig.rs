//! A rig in which something touches, and what holds for any contact.
use super::Contact;
use rhytid_conformance::evaluate;
use rhytid_core::{Face, NoProgress, Rig};
use rhytid_kernels::normals::{VertexTriangles, vertex_normal};
use rhytid_kernels::vec3;
use std::sync::Arc;

pub(super) fn rig(face: &Face) -> Rig {
    rhytid_solve::solve(face, &NoProgress).unwrap().rounded().unwrap()
}

pub(super) fn contact(rig: &Rig) -> Contact<'_> {
    let triangles = rig.surface().vertex_triangles();
    Contact::new(rig, Arc::new(triangles)).unwrap()
}

/// The farthest that any vertex is from one place to another.
pub(super) fn largest_step(a: &[[f32; 3]], b: &[[f32; 3]]) -> f32 {
    a.iter().zip(b).map(|(a, b)| vec3::length(vec3::sub(*a, *b))).fold(0.0, f32::max)
}

/// Checks that the normals are those of the positions.
pub(super) fn assert_normals(rig: &Rig, positions: &[[f32; 3]], normals: &[[f32; 3]]) {
    let triangles = &rig.surface().triangles;
    let at = VertexTriangles::new(rig.vertices(), triangles);
    for (v, normal) in normals.iter().enumerate() {
        let expected = vertex_normal(positions, triangles, at.at(v));
        assert!(vec3::length(vec3::sub(*normal, expected)) < 1e-5, "vertex {v}");
    }
}

/// Checks that the neutral and the first example stay bit for bit.
pub(super) fn assert_scans_stay(rig: &Rig) {
    let contact = contact(rig);
    for handles in [&rig.handles().rest[..], rig.examples().handles.row(0)] {
        let before = evaluate(rig, handles).positions;
        let mut after = before.clone();
        assert!(contact.frame(&mut after, &mut []).iter().all(|moved| !moved));
        assert_eq!(before, after);
    }
}
