//! OBJ out.

use super::check::check;
use rhytid_core::{AtomicFile, Materials, Mesh, Result};
use std::io::Write;
use std::path::Path;

/// Writes `mesh` as OBJ so that [`super::read()`] returns the same mesh. Numbers are the shortest that read
/// as the same `f64` (`f32` for texture coordinates). Texture indices that only repeat the vertex indices
/// become texture coordinates per vertex.
///
/// # Errors
/// [`rhytid_core::Error::Input`] if `mesh` does not pass [`check`] or the folder does not exist;
/// [`rhytid_core::Error::Io`]. Nothing is left behind then.
pub fn write_obj(path: &Path, mesh: &Mesh) -> Result<()> {
    check(mesh, &path.display().to_string())?;
    let mut file = AtomicFile::create(path)?;
    let failed = file.error();
    write(&mut file, mesh).map_err(failed)?;
    file.finish()
}

fn write(out: &mut impl Write, mesh: &Mesh) -> std::io::Result<()> {
    let mut number = ryu::Buffer::new();
    for position in &mesh.positions {
        out.write_all(b"v")?;
        for &x in position {
            write!(out, " {}", number.format_finite(x))?;
        }
        out.write_all(b"\n")?;
    }
    for uv in mesh.uvs.iter().flat_map(|uvs| &uvs.values) {
        out.write_all(b"vt")?;
        for &x in uv {
            write!(out, " {}", number.format_finite(x))?;
        }
        out.write_all(b"\n")?;
    }
    let mut corner = 0;
    let mut material = Materials::NONE;
    for (f, face) in mesh.faces.iter().enumerate() {
        if let Some(materials) = &mesh.materials
            && materials.of_face[f] != material
        {
            material = materials.of_face[f];
            let name = materials.list.get(material as usize).map_or("", |material| material.name.as_str());
            writeln!(out, "{}", format!("usemtl {}", name.replace(char::is_control, "_")).trim_end())?;
        }
        out.write_all(b"f")?;
        for &vertex in face {
            // OBJ counts from 1, which a u32 may not hold.
            write!(out, " {}", u64::from(vertex) + 1)?;
            if let Some(uvs) = &mesh.uvs {
                let uv = uvs.corners.as_ref().map_or(vertex, |corners| corners[corner]);
                write!(out, "/{}", u64::from(uv) + 1)?;
            }
            corner += 1;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}
