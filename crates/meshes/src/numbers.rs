//! Numbers at vertices: the properties of a PLY's vertices, which many programs paint, show and write.

use super::{check, ply};
use rhytid_core::{AtomicFile, Error, Mesh, Result, input_file};
use std::io::Write;
use std::path::Path;

/// A name, and a number for each vertex.
pub type Numbers = (String, Vec<f32>);

/// Reads the numbers of a PLY's vertices beside their positions, in the order of the file. Bytes, such as
/// colours, are divided by 255. `vertices` is the number of vertices that there have to be.
///
/// # Errors
/// [`Error::Input`] if the file is no PLY, or has other vertices or no numbers; [`Error::Io`].
pub fn read_numbers(path: &Path, vertices: usize) -> Result<Vec<Numbers>> {
    let bytes = input_file::read(path, input_file::LARGEST_MESH_OR_TAKE)?;
    decode_numbers(&bytes, &path.display().to_string(), vertices)
}

/// The same from memory; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_numbers`].
pub fn decode_numbers(bytes: &[u8], name: &str, vertices: usize) -> Result<Vec<Numbers>> {
    let mut found = ply::scalars(bytes, name)?;
    if let Some((_, numbers)) = found.first().filter(|(_, numbers)| numbers.len() != vertices) {
        let found = numbers.len();
        return Err(Error::mismatch(format!("{name}: has {found} vertices, expected the rig's {vertices}")));
    }
    found.retain(|(name, _)| !["x", "y", "z"].contains(&&**name));
    if found.is_empty() {
        return Err(Error::empty(format!("{name}: its vertices have no numbers beside their positions")));
    }
    let narrow =
        |(name, numbers): (String, Vec<f64>)| (name, numbers.into_iter().map(|x| x as f32).collect());
    Ok(found.into_iter().map(narrow).collect())
}

/// Writes a mesh as PLY (binary, positions in 32 bits) with numbers at its vertices, under names without
/// blanks.
///
/// # Errors
/// [`Error::Input`] if the mesh does not pass [`check`], or a list has not a number for each vertex;
/// [`Error::Io`]. Nothing is left behind then.
pub fn write_numbers(path: &Path, mesh: &Mesh, numbers: &[(&str, &[f32])]) -> Result<()> {
    check(mesh, &path.display().to_string())?;
    let vertices = mesh.positions.len();
    if let Some((name, list)) = numbers.iter().find(|(_, list)| list.len() != vertices) {
        let found = list.len();
        return Err(Error::mismatch(format!(
            "{}: {found} numbers for {name}, expected one for each of {vertices} vertices",
            path.display()
        )));
    }
    let mut file = AtomicFile::create(path)?;
    let failed = file.error();
    write(&mut file, mesh, numbers).map_err(failed)?;
    file.finish()
}

fn write(out: &mut impl Write, mesh: &Mesh, numbers: &[(&str, &[f32])]) -> std::io::Result<()> {
    let names = ["x", "y", "z"].into_iter().chain(numbers.iter().map(|(name, _)| *name));
    let properties: String =
        names.map(|name| format!("property float {}\n", name.replace(' ', "_"))).collect();
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n{properties}element face {}\nproperty list uint uint vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.faces.len()
    )?;
    for (v, x) in mesh.positions.iter().enumerate() {
        let own = numbers.iter().map(|(_, list)| list[v]);
        for number in x.iter().map(|x| *x as f32).chain(own) {
            out.write_all(&number.to_le_bytes())?;
        }
    }
    for face in mesh.faces.iter() {
        out.write_all(&(face.len() as u32).to_le_bytes())?;
        face.iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::Faces;

    #[test]
    fn numbers_come_back_and_the_mesh_with_them() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("maps.ply");
        let faces = Faces { counts: vec![4, 3], indices: vec![0, 1, 2, 3, 2, 1, 4] };
        let positions = (0..5).map(|i| [f64::from(i), 0.5, -1.0 / f64::from(i + 1)]).collect();
        let mesh = Mesh { positions, faces, ..Mesh::default() };
        let (a, b) = ([0.0, 1.5, f32::NAN, -2.0, 1e9], [1.0; 5]);
        write_numbers(&path, &mesh, &[("distance mm", &a), ("b", &b)]).unwrap();
        let found = read_numbers(&path, 5).unwrap();
        assert_eq!(found.iter().map(|(name, _)| &**name).collect::<Vec<_>>(), ["distance_mm", "b"]);
        let bits = |list: &[f32]| list.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!((bits(&found[0].1), &found[1].1[..]), (bits(&a), &b[..]));
        let read = super::super::read(&path).unwrap();
        assert_eq!(read.faces, mesh.faces);
        for (found, expected) in [
            (read_numbers(&path, 6), "has 5 vertices, expected the rig's 6"),
            (write_numbers(&path, &mesh, &[("a", &a[1..])]).map(|()| Vec::new()), "4 numbers for a"),
        ] {
            let error = found.unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
        write_numbers(&path, &mesh, &[]).unwrap();
        let error = read_numbers(&path, 5).unwrap_err().to_string();
        assert!(error.contains("no numbers beside their positions"), "{error}");
    }
}
