//! A number at each vertex of a mesh, such as a weight that was painted: a primvar.

use super::lookup::{attribute, below, field};
use super::open;
use crate::layer::Attribute;
use crate::layer::Prim;
use crate::layer::Property;
use crate::layer::Value;
use rhytid_core::{Error, InputErrorKind, Result};
use std::path::Path;

/// Reads the numbers that the primvar `name` has at the vertices of a mesh. They are its value without a
/// time, or else its value at the first time code. The type is `float[]`, or a colour, of which red counts.
/// Indices are followed; references to other files are not.
///
/// # Errors
/// [`Error::Input`] unless exactly one mesh in the file has that primvar, and it has a number for each
/// vertex; [`Error::Io`].
pub fn read_primvar(path: &Path, name: &str) -> Result<Vec<f32>> {
    let fault = |what: String| Error::malformed(format!("{}: {what}", path.display()));
    let mut opened = open(path)?;
    let meshes: Vec<&Prim> = opened.layer.prims.iter().flat_map(with_meshes_below).collect();
    let wanted = format!("primvars:{name}");
    let with_it: Vec<(&Prim, &Attribute)> =
        meshes.iter().filter_map(|mesh| Some((*mesh, attribute(mesh, &wanted)?))).collect();
    let &[(mesh, found)] = &with_it[..] else {
        let names = |prims: &[&Prim]| prims.iter().map(|prim| &*prim.name).collect::<Vec<_>>().join(", ");
        return Err(match (&meshes[..], &with_it[..]) {
            ([], _) => fault("has no mesh; export the painted mesh into the file itself".into())
                .of_kind(InputErrorKind::Empty),
            (meshes, []) => {
                let known: Vec<&str> = meshes.iter().flat_map(|mesh| primvars(mesh)).collect();
                let known = if known.is_empty() { "none".into() } else { known.join(", ") };
                fault(format!("no mesh has a primvar “{name}”, found {known} on {}", names(meshes)))
                    .of_kind(InputErrorKind::UnknownName { name: name.to_owned() })
            }
            (_, several) => {
                let several: Vec<&Prim> = several.iter().map(|(mesh, _)| *mesh).collect();
                fault(format!(
                    "the primvar “{name}” is on several meshes, {}; leave one in the file",
                    names(&several)
                ))
                .of_kind(InputErrorKind::Conflict)
            }
        });
    };
    let interpolation = match field(&found.metadata, "interpolation") {
        Some(Value::Token(word)) => word.as_str(),
        // The default of USD.
        _ => "constant",
    };
    if !["vertex", "varying"].contains(&interpolation) {
        return Err(fault(format!(
            "the primvar “{name}” of {} has the interpolation {interpolation}, expected vertex: a number for each vertex",
            mesh.name
        )));
    }
    let (indices, kind) = (attribute(mesh, &format!("{wanted}:indices")), found.type_name.clone());
    let mut value = |attribute: &Attribute| match (&attribute.default, attribute.samples) {
        (Some(value), _) => Ok(Some(value.clone())),
        (None, Some(samples)) => opened.samples.read(samples, 0).map(Some),
        (None, None) => Ok(None),
    };
    let numbers = match value(found)? {
        Some(Value::Floats(numbers)) => numbers,
        Some(Value::Float3s(colours)) => colours.into_iter().map(|[red, ..]| red).collect(),
        Some(Value::Float4s(colours)) => colours.into_iter().map(|[red, ..]| red).collect(),
        _ => {
            return Err(fault(format!(
                "the primvar “{name}” of {} is {kind}, expected float[], color3f[] or color4f[] with values",
                mesh.name
            )));
        }
    };
    let Some(Value::Ints(indices)) = indices.map(&mut value).transpose()?.flatten() else {
        return Ok(numbers);
    };
    let at = |i: i32| usize::try_from(i).ok().and_then(|i| numbers.get(i)).copied();
    let number = |i: i32| {
        at(i).ok_or_else(|| {
            let (mesh, count) = (&mesh.name, numbers.len());
            fault(format!("the primvar “{name}” of {mesh} has {count} values, and an index of {i}"))
        })
    };
    indices.into_iter().map(number).collect()
}

/// A prim, if it is a mesh, and all meshes below it.
fn with_meshes_below(prim: &Prim) -> Vec<&Prim> {
    let mut meshes = below(prim, "Mesh");
    meshes.extend((prim.type_name == "Mesh").then_some(prim));
    meshes
}

/// The names of a prim's primvars.
fn primvars(prim: &Prim) -> impl Iterator<Item = &str> {
    let names = prim.properties.iter().map(Property::name);
    names.filter_map(|name| name.strip_prefix("primvars:")).filter(|name| !name.ends_with(":indices"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of one mesh, or two, with these properties.
    fn read(name: &str, meshes: &[&str]) -> Result<Vec<f32>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("painted.usda");
        let mesh = |(i, properties): (usize, &&str)| {
            format!("    def Mesh \"m{i}\"\n    {{\n{properties}\n    }}\n")
        };
        let meshes: String = meshes.iter().enumerate().map(mesh).collect();
        std::fs::write(&path, format!("#usda 1.0\n\ndef Xform \"face\"\n{{\n{meshes}}}\n")).unwrap();
        read_primvar(&path, name).map_err(|error| error.to_string())
    }

    const BROW: &str = "float[] primvars:brow = [0, 0.25, 1] ( interpolation = \"vertex\" )";

    #[test]
    fn numbers_colours_samples_and_indices_are_read() {
        assert_eq!(read("brow", &[BROW]).unwrap(), [0.0, 0.25, 1.0]);
        // Another mesh without it does not matter.
        assert_eq!(read("brow", &["", BROW]).unwrap(), [0.0, 0.25, 1.0]);
        let colours =
            "color3f[] primvars:displayColor = [(0.5, 1, 0), (1, 0, 0)] ( interpolation = \"vertex\" )";
        assert_eq!(read("displayColor", &[colours]).unwrap(), [0.5, 1.0]);
        let colours = "color4f[] primvars:paint = [(0.25, 1, 0, 1)] ( interpolation = \"vertex\" )";
        assert_eq!(read("paint", &[colours]).unwrap(), [0.25]);
        let indexed = "float[] primvars:a = [0.5, 1] ( interpolation = \"varying\" )\nint[] primvars:a:indices = [1, 0, 0, 1]";
        assert_eq!(read("a", &[indexed]).unwrap(), [1.0, 0.5, 0.5, 1.0]);
        let sampled = "float[] primvars:a ( interpolation = \"vertex\" )\nfloat[] primvars:a.timeSamples = { 3: [0, 1], 7: [1, 1], }";
        assert_eq!(read("a", &[sampled]).unwrap(), [0.0, 1.0]);
    }

    #[test]
    fn what_is_no_number_for_each_vertex_is_said() {
        for (name, meshes, words) in [
            ("nose", &[BROW][..], "no mesh has a primvar “nose”, found brow on m0"),
            ("nose", &[""], "no mesh has a primvar “nose”, found none on m0"),
            ("brow", &[], "has no mesh"),
            ("brow", &[BROW, BROW], "“brow” is on several meshes, m0, m1"),
            ("a", &["float[] primvars:a = [1]"], "has the interpolation constant, expected vertex"),
            (
                "a",
                &["float[] primvars:a = [1] ( interpolation = \"faceVarying\" )"],
                "m0 has the interpolation faceVarying, expected vertex",
            ),
            ("a", &["int[] primvars:a = [1] ( interpolation = \"vertex\" )"], "is int[], expected float[]"),
            ("a", &["float[] primvars:a ( interpolation = \"vertex\" )"], "is float[], expected float[]"),
            (
                "a",
                &[
                    "float[] primvars:a = [1] ( interpolation = \"vertex\" )\nint[] primvars:a:indices = [0, -1]",
                ],
                "has 1 values, and an index of -1",
            ),
        ] {
            let error = read(name, meshes).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
    }
}
