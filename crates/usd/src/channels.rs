//! Channels as attributes of a USD mesh: a single list for writing and reading.

use super::layer::{Attribute, Prim, Property, Value};
use rhytid_core::channel::{self, Channel, Interpolation, Quantity};

/// What the names of all other attributes begin with.
const PRIMVARS: &str = "primvars:";

/// The channels that the schema of meshes has attributes for, and their types.
fn of_schema() -> [(&'static Channel, &'static str, &'static str); 3] {
    [
        (&channel::POSITIONS, "points", "point3f[]"),
        (&channel::NORMALS, "normals", "normal3f[]"),
        (&channel::VELOCITIES, "velocities", "vector3f[]"),
    ]
}

/// The attribute's name.
pub(super) fn name(channel: &Channel) -> String {
    let of_schema = of_schema().into_iter().find(|(known, ..)| known.name == channel.name);
    of_schema.map_or_else(|| format!("{PRIMVARS}{}", channel.name), |(_, name, _)| name.to_owned())
}

/// Whether it is a primvar, which says how it is interpolated.
pub(super) fn is_primvar(channel: &Channel) -> bool {
    name(channel).starts_with(PRIMVARS)
}

/// The attribute's type.
///
/// # Errors
/// The channel's width, if USD has no type for it.
pub(super) fn type_name(channel: &Channel) -> Result<&'static str, usize> {
    let of_schema = of_schema().into_iter().find(|(known, ..)| known.name == channel.name);
    match (of_schema, channel.width, channel.quantity) {
        (Some((.., type_name)), ..) => Ok(type_name),
        (None, 1, _) => Ok("float[]"),
        (None, 2, _) => Ok("float2[]"),
        (None, 3, Quantity::Direction | Quantity::Velocity) => Ok("vector3f[]"),
        (None, 3, _) => Ok("float3[]"),
        (None, width, _) => Err(width),
    }
}

/// The channel that an attribute of a mesh has samples of; `None` where it is no channel.
pub(super) fn of_attribute(attribute: &Attribute) -> Option<Channel> {
    attribute.samples?;
    if let Some((channel, ..)) = of_schema().into_iter().find(|(_, name, _)| *name == attribute.name) {
        return Some(channel.clone());
    }
    let name = attribute.name.strip_prefix(PRIMVARS).filter(|name| !name.contains(':'))?;
    let width = match attribute.type_name.as_str() {
        "float[]" => 1,
        "float2[]" => 2,
        "float3[]" | "vector3f[]" | "point3f[]" | "normal3f[]" | "color3f[]" => 3,
        _ => return None,
    };
    let channel = Channel::of_file(name, width);
    let interpolation = attribute.metadata.iter().find(|(name, _)| name == "interpolation");
    match interpolation {
        Some((_, Value::Token(token))) if token == Interpolation::Uniform.name() => {
            Some(Channel { interpolation: Interpolation::Uniform, ..channel })
        }
        _ => Some(channel),
    }
}

/// The channels of a mesh with the numbers of their samples, positions first.
pub(super) fn of_mesh(mesh: &Prim) -> Vec<(Channel, usize)> {
    let found = mesh.properties.iter().filter_map(|property| match property {
        Property::Attribute(attribute) => Some((of_attribute(attribute)?, attribute.samples?)),
        Property::Relationship(_) => None,
    });
    let mut found: Vec<(Channel, usize)> = found.collect();
    found.sort_by_key(|(channel, _)| channel.name != channel::POSITIONS.name);
    found
}
