//! Weights of vertices, as they are painted: a property of a PLY's vertices, or a primvar.

use super::ply;
use rhytid_core::{Error, InputErrorKind, Result, input_file};
use rhytid_usd::read::read_primvar;
use std::path::Path;

/// Reads the weights of a painted mesh's vertices, from 0 to 1. In a PLY they are the numbers of `property`;
/// whole numbers of a byte, as colours are, are divided by 255. In a USD file they are the primvar of this
/// name, as [`read_primvar`] returns it. `vertices` is the number of vertices that there have to be.
///
/// # Errors
/// [`Error::Input`] if the file is neither, has another number of vertices or no such property, or where a
/// weight is not from 0 to 1; [`Error::Io`].
pub fn read_weights(path: &Path, property: &str, vertices: usize) -> Result<Vec<f32>> {
    let fault = |what: String| Error::input(format!("{}: {what}", path.display()));
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    let weights = match extension.as_deref() {
        Some("ply") => of_ply(path, property)?,
        Some("usd" | "usda" | "usdc" | "usdz") => {
            read_primvar(path, property)?.into_iter().map(f64::from).collect()
        }
        _ => {
            return Err(fault(
                "weights are read from .ply and .usd; export the painted mesh in one of these formats".into(),
            )
            .of_kind(InputErrorKind::UnsupportedFormat));
        }
    };
    if weights.len() != vertices {
        return Err(fault(format!("has {} vertices, expected the rig's {vertices}", weights.len()))
            .of_kind(InputErrorKind::Mismatch));
    }
    match weights.iter().position(|weight| !(0.0..=1.0).contains(weight)) {
        Some(vertex) => Err(fault(format!(
            "vertex {vertex} has {} as its {property}, expected a weight from 0 to 1",
            weights[vertex]
        ))
        .of_kind(InputErrorKind::OutOfRange)),
        None => Ok(weights.into_iter().map(|weight| weight as f32).collect()),
    }
}

fn of_ply(path: &Path, property: &str) -> Result<Vec<f64>> {
    let bytes = input_file::read(path, input_file::LARGEST_MESH_OR_TAKE)?;
    let mut found = ply::scalars(&bytes, &path.display().to_string())?;
    let Some(at) = found.iter().position(|(name, _)| name == property) else {
        let known: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
        return Err(Error::input(format!(
            "{}: its vertices have no property “{property}”, expected one of {}",
            path.display(),
            known.join(", ")
        ))
        .of_kind(InputErrorKind::UnknownName { name: property.to_owned() }));
    };
    Ok(found.swap_remove(at).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_numbers_or_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, kind: &str, values: [&str; 3]| {
            let path = folder.path().join(name);
            let rows: String = values.iter().map(|value| format!("0 {value} 0 0\n")).collect();
            let text = format!(
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty {kind} brow\nproperty float y\nproperty float z\nelement \
                 face 1\nproperty list uchar int vertex_indices\nend_header\n{rows}3 0 1 2\n"
            );
            std::fs::write(&path, text).unwrap();
            path
        };
        let read = |path: &Path, property: &str, vertices| {
            read_weights(path, property, vertices).map_err(|error| error.to_string())
        };
        let floats = write("a.ply", "float", ["0", "0.25", "1"]);
        assert_eq!(read(&floats, "brow", 3).unwrap(), [0.0, 0.25, 1.0]);
        assert_eq!(
            read(&write("b.ply", "uchar", ["0", "51", "255"]), "brow", 3).unwrap(),
            [0.0, 51.0 / 255.0, 1.0]
        );
        for (path, property, vertices, words) in [
            (floats.clone(), "nose", 3, "have no property “nose”, expected one of x, brow, y, z"),
            (floats, "brow", 4, "has 3 vertices, expected the rig's 4"),
            (write("c.ply", "float", ["0", "1.5", "1"]), "brow", 3, "vertex 1 has 1.5 as its brow"),
            (write("d.ply", "float", ["0", "nan", "1"]), "brow", 3, "vertex 1 has NaN as its brow"),
            ("e.obj".into(), "brow", 3, "weights are read from .ply and .usd"),
        ] {
            let error = read(&path, property, vertices).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
    }
}
