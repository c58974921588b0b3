//! The check that every mesh passes.

use rhytid_core::{Error, Mesh, Result};

/// Checks the properties that every reader guarantees. `name` stands for the file in messages.
///
/// - Every coordinate is finite and fits a 32-bit float.
/// - There is a face, and each face has three corners or more.
/// - Every index is in range.
/// - There are as many texture coordinates as corners or vertices ask for, all finite.
/// - The material of every face is one of the named ones.
/// - No face has more than 4,096 corners, and no vertex is in more faces than that.
///
/// # Errors
/// [`Error::Input`] names the first thing that is wrong.
pub fn check(mesh: &Mesh, name: &str) -> Result<()> {
    let fail = |what: String| Err(Error::bad_topology(format!("{name}: {what}")));
    let vertices = mesh.positions.len();
    if u32::try_from(vertices).is_err() {
        return fail(format!("has {vertices} vertices, expected at most {}; decimate the mesh", u32::MAX));
    }
    if let Some(i) = mesh.positions.iter().position(|p| !p.iter().all(|&x| representable(x))) {
        return fail(format!(
            "vertex {i} (counted from 0) is at {:?}, expected finite coordinates below 3.4e38; repair the mesh \
             or export it again",
            mesh.positions[i]
        ));
    }
    if mesh.faces.is_empty() {
        return fail(format!(
            "has {vertices} vertices but no faces, expected at least one polygon; export the surface, not only \
             its points"
        ));
    }
    let uv_fault = || mesh.uvs.as_ref().and_then(|uvs| uvs.fault(vertices, &mesh.faces));
    let material_fault = || mesh.materials.as_ref().and_then(|materials| materials.fault(&mesh.faces));
    match mesh.faces.fault(vertices).or_else(uv_fault).or_else(material_fault) {
        Some(fault) => fail(format!("{fault}; the file may be cut short: export it again")),
        None => check_degrees(mesh, name),
    }
}

/// Work at a corner or around a vertex takes the square of these, at worst.
const MOST_CORNERS: u32 = 4096;
const MOST_AROUND: u32 = 4096;

/// No face has a corner too many, and no vertex a face.
fn check_degrees(mesh: &Mesh, name: &str) -> Result<()> {
    let fail = |what: String| Err(Error::bad_topology(format!("{name}: {what}")));
    if let Some((f, &n)) = mesh.faces.counts.iter().enumerate().find(|(_, n)| **n > MOST_CORNERS) {
        return fail(format!(
            "face {} has {n} corners, expected at most {MOST_CORNERS}; cut it into smaller ones",
            f + 1
        ));
    }
    let mut around = vec![0_u32; mesh.positions.len()];
    mesh.faces.indices.iter().for_each(|&v| around[v as usize] += 1);
    match around.iter().position(|&n| n > MOST_AROUND) {
        None => Ok(()),
        Some(v) => fail(format!(
            "vertex {v} (counted from 0) is a corner of {} faces, expected at most {MOST_AROUND}; check that \
             the mesh is the surface of a scan",
            around[v]
        )),
    }
}

/// Whether the rig's 32-bit floats can hold `x`.
pub(super) fn representable(x: f64) -> bool {
    x.abs() <= f64::from(f32::MAX)
}
