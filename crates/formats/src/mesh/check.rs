use rhytid_core::{Error, Mesh, Result};

/// What every reader guarantees: every coordinate is finite and fits a 32-bit float; there is a face; each face
/// has three corners or more; every index is in range; there are as many texture coordinates as corners or
/// vertices ask for, all finite. `name` stands for the file in messages.
///
/// # Errors
/// [`Error::Input`] names the first thing that is wrong.
pub fn check(mesh: &Mesh, name: &str) -> Result<()> {
    let fail = |what: String| Err(Error::input(format!("{name}: {what}")));
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
    let (counts, indices) = (&mesh.faces.counts, &mesh.faces.indices);
    if counts.is_empty() {
        return fail(format!(
            "has {vertices} vertices but no faces, expected at least one polygon; export the surface, not only \
             its points"
        ));
    }
    if let Some(f) = counts.iter().position(|&n| n < 3) {
        return fail(format!("face {} has {} corners, expected at least 3; remove it", f + 1, counts[f]));
    }
    let corners: u64 = counts.iter().map(|&n| u64::from(n)).sum();
    if corners != indices.len() as u64 {
        return fail(format!("has {} corners, expected the {corners} of its faces", indices.len()));
    }
    if let Some(c) = indices.iter().position(|&v| v as usize >= vertices) {
        return fail(format!(
            "face {} refers to vertex {}, expected 0 to {} (its {vertices} vertices, counted from 0); the file \
             may be cut short",
            face_of_corner(counts, c) + 1,
            indices[c],
            vertices.saturating_sub(1)
        ));
    }
    let Some(uvs) = &mesh.uvs else { return Ok(()) };
    if let Some(i) = uvs.values.iter().position(|uv| !uv.iter().all(|x| x.is_finite())) {
        return fail(format!(
            "texture coordinate {i} (counted from 0) is {:?}, expected finite numbers; repair the texture map \
             or export the mesh without it",
            uvs.values[i]
        ));
    }
    match &uvs.corners {
        None if uvs.values.len() != vertices => fail(format!(
            "has {} texture coordinates for {vertices} vertices, expected one for each",
            uvs.values.len()
        )),
        Some(of_corner) if of_corner.len() != indices.len() => fail(format!(
            "has {} texture indices for {} face corners, expected one for each",
            of_corner.len(),
            indices.len()
        )),
        Some(of_corner) => match of_corner.iter().position(|&i| i as usize >= uvs.values.len()) {
            Some(c) => fail(format!(
                "face {} refers to texture coordinate {}, expected one of its {} (counted from 0); the file may \
                 be cut short",
                face_of_corner(counts, c) + 1,
                of_corner[c],
                uvs.values.len()
            )),
            None => Ok(()),
        },
        None => Ok(()),
    }
}

/// Whether the rig's 32-bit floats can hold `x`.
pub(super) fn representable(x: f64) -> bool {
    x.abs() <= f64::from(f32::MAX)
}

fn face_of_corner(counts: &[u32], corner: usize) -> usize {
    let mut end = 0;
    counts
        .iter()
        .position(|&n| {
            end += n as usize;
            corner < end
        })
        .unwrap_or(0)
}
