//! Principal strains in glTF: an attribute of the application's own on the mesh and on its targets, which the crate `gltf` knows on meshes
//! alone.

use rhytid_core::PrincipalStrains;
use serde::Deserialize;
use serde_json::Value;

/// The strains, and that of the area.
pub(super) const STRAIN: &str = "_STRAIN";

/// The directions of the first strains.
pub(super) const DIRECTION: &str = "_STRAIN_DIRECTION";

/// V × 3 numbers: the strains and that of the area, (1 + e₁)(1 + e₂) − 1. Three, so that viewers may morph them as they morph colours.
pub(super) fn attribute(of: &PrincipalStrains) -> Vec<f32> {
    let three = |&[first, second]: &[f32; 2]| [first, second, (1.0 + first) * (1.0 + second) - 1.0];
    of.strains.iter().flat_map(three).collect()
}

/// What targets have besides: an accessor by its name.
pub(super) type Extras = Vec<(&'static str, u32)>;

/// Adds accessors to the targets of the only mesh of a document.
pub(super) fn add_to_targets(document: &mut Value, extras: &[Extras]) {
    let targets = document.pointer_mut("/meshes/0/primitives/0/targets").and_then(Value::as_array_mut);
    for (target, extras) in targets.into_iter().flatten().zip(extras) {
        for &(name, accessor) in extras {
            target[name] = accessor.into();
        }
    }
}

#[derive(Deserialize)]
struct Document {
    #[serde(default)]
    meshes: Vec<Mesh>,
}

#[derive(Deserialize)]
struct Mesh {
    #[serde(default)]
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    #[serde(default)]
    targets: Vec<Target>,
}

#[derive(Deserialize)]
struct Target {
    #[serde(rename = "_STRAIN", default)]
    strain: Option<usize>,
}

/// The accessor of each target's strains, for each mesh of a document; of its first primitive, if it has any strains.
pub(super) fn of_targets(json: &[u8]) -> Vec<Vec<Option<usize>>> {
    // Most files have none, and are not read twice.
    if !json.windows(STRAIN.len()).any(|window| window == STRAIN.as_bytes()) {
        return Vec::new();
    }
    let document: Document = serde_json::from_slice(json).unwrap_or(Document { meshes: Vec::new() });
    let of_mesh = |mesh: Mesh| {
        let targets = mesh.primitives.into_iter().take(1).flat_map(|primitive| primitive.targets);
        targets.map(|target| target.strain).collect()
    };
    document.meshes.into_iter().map(of_mesh).collect()
}
