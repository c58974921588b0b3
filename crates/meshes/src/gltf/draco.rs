//! Primitives that are compressed with KHR_draco_mesh_compression.

use super::accessor::is_stored;
use super::buffers::Buffers;
use ::gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use ::gltf::json::buffer::View;
use ::gltf::json::mesh::{Mode, Primitive};
use ::gltf::json::validation::{Checked, USize64};
use ::gltf::json::{Index, Root};
use draco_core::{DecodeLimits, DecoderBuffer, ErrorKind, Mesh, MeshDecoder, PointAttribute};
use rhytid_core::{Error, Result};
use serde::Deserialize;
use std::collections::BTreeMap;

/// The extension's name.
pub(super) const EXTENSION: &str = "KHR_draco_mesh_compression";

/// What the extension says of a primitive.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Compressed {
    buffer_view: usize,
    /// The identifiers of attributes in the stream.
    attributes: BTreeMap<String, u32>,
}

/// Replaces compressed primitives with plain ones. Those that are also stored in the plain way stay as they
/// are.
pub(super) fn unfold(root: &mut Root, buffers: &mut Buffers, name: &str) -> Result<()> {
    for m in 0..root.meshes.len() {
        for p in 0..root.meshes[m].primitives.len() {
            let primitive = &root.meshes[m].primitives[p];
            let Some(said) = primitive.extensions.as_ref().and_then(|e| e.others.get(EXTENSION)) else {
                continue;
            };
            let place = format!("{name}: mesh {m}, primitive {p}");
            let fail = |what: String| Err(Error::malformed(format!("{place} {what}")));
            let compressed = match Compressed::deserialize(said) {
                Ok(compressed) => compressed,
                Err(e) => {
                    return fail(format!("has a {EXTENSION} that cannot be read ({e}); export it without"));
                }
            };
            if !matches!(primitive.mode, Checked::Valid(Mode::Triangles)) {
                return fail(format!(
                    "is compressed with {EXTENSION} and has no list of triangles; export it without"
                ));
            }
            let wanted = wanted(root, primitive, &compressed);
            if wanted.is_empty() {
                continue;
            }
            let mesh = decode(root, buffers, compressed.buffer_view, &place, name)?;
            for Wanted { accessor, id } in wanted {
                let (bytes, component) = match id {
                    None => (indices(&mesh), ComponentType::U32),
                    Some(id) => values(root, accessor, &mesh, id, &place)?,
                };
                store(root, buffers, accessor, bytes, component);
            }
        }
    }
    Ok(())
}

/// An accessor without numbers.
struct Wanted {
    accessor: usize,
    /// The attribute in the stream; `None` for the triangles.
    id: Option<u32>,
}

/// The accessors that the stream fills and that a mesh is read from.
fn wanted(root: &Root, primitive: &Primitive, compressed: &Compressed) -> Vec<Wanted> {
    let is_empty = |index: usize| root.accessors.get(index).is_some_and(|accessor| !is_stored(accessor));
    let mut wanted = Vec::new();
    if let Some(indices) = primitive.indices.filter(|indices| is_empty(indices.value())) {
        wanted.push(Wanted { accessor: indices.value(), id: None });
    }
    for (semantic, accessor) in &primitive.attributes {
        let Checked::Valid(semantic) = semantic else { continue };
        let semantic = semantic.to_string();
        let is_read =
            ["POSITION", "TEXCOORD_", "JOINTS_", "WEIGHTS_"].iter().any(|start| semantic.starts_with(start));
        if let Some(&id) =
            compressed.attributes.get(&semantic).filter(|_| is_read && is_empty(accessor.value()))
        {
            wanted.push(Wanted { accessor: accessor.value(), id: Some(id) });
        }
    }
    wanted
}

fn decode(root: &Root, buffers: &Buffers, view: usize, place: &str, name: &str) -> Result<Mesh> {
    let (stream, _) = buffers.view(root, view, name)?;
    let allowed = buffers.allowed();
    let limits = DecodeLimits::default()
        .with_max_decoded_bytes(allowed)
        .with_max_points(allowed / 12)
        .with_max_faces(allowed / 12);
    let mut mesh = Mesh::new();
    let mut decoder = MeshDecoder::new();
    decoder.decode(&mut DecoderBuffer::new(stream).with_limits(limits), &mut mesh).map_err(|e| match e.kind() {
        ErrorKind::LimitExceeded => buffers.too_much(name),
        _ => Error::malformed(format!(
            "{place} is compressed with {EXTENSION} and cannot be unfolded ({e}); the file may be damaged, or \
             export it without compression"
        )),
    })?;
    let of_points: usize = (0..mesh.num_attributes())
        .map(|a| mesh.attribute(a))
        .map(|a| usize::from(a.num_components()) * a.data_type().byte_length())
        .sum();
    buffers.spend((mesh.num_points() * of_points + mesh.num_faces() * 12) as u64, name)?;
    Ok(mesh)
}

fn indices(mesh: &Mesh) -> Vec<u8> {
    mesh.faces().iter().flatten().flat_map(|corner| corner.0.to_le_bytes()).collect()
}

/// The values of the points, in the component type that the accessor has.
fn values(
    root: &Root,
    accessor: usize,
    mesh: &Mesh,
    id: u32,
    place: &str,
) -> Result<(Vec<u8>, ComponentType)> {
    let fail = |what: String| Err(Error::malformed(format!("{place} {what}; the file is damaged")));
    let described = &root.accessors[accessor];
    let (Checked::Valid(component), Checked::Valid(shape)) = (described.component_type, described.type_)
    else {
        return fail(format!("has values of an unknown type in accessor {accessor}"));
    };
    let Some(attribute) = mesh.attribute_by_unique_id(id) else {
        return fail(format!("names the attribute {id}, which its {EXTENSION} does not have"));
    };
    let width = match shape {
        Type::Scalar => 1,
        Type::Vec2 => 2,
        Type::Vec3 => 3,
        _ => 4,
    };
    if usize::from(attribute.num_components()) != width {
        return fail(format!(
            "has {} components in its {EXTENSION}, expected the {width} of accessor {accessor}",
            attribute.num_components()
        ));
    }
    Ok((in_component(attribute, mesh.num_points(), width, component.0), component.0))
}

/// Integers that glTF has here are below 2^24, so that floats hold them.
fn in_component(
    attribute: &PointAttribute,
    points: usize,
    width: usize,
    component: ComponentType,
) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(points * width * component.size());
    for number in attribute.read_f32s(points, width) {
        match component {
            ComponentType::I8 => bytes.extend((number as i8).to_le_bytes()),
            ComponentType::U8 => bytes.extend((number as u8).to_le_bytes()),
            ComponentType::I16 => bytes.extend((number as i16).to_le_bytes()),
            ComponentType::U16 => bytes.extend((number as u16).to_le_bytes()),
            ComponentType::U32 => bytes.extend((number as u32).to_le_bytes()),
            ComponentType::F32 => bytes.extend(number.to_le_bytes()),
        }
    }
    bytes
}

/// Gives the accessor a buffer of its own.
fn store(root: &mut Root, buffers: &mut Buffers, accessor: usize, bytes: Vec<u8>, component: ComponentType) {
    let view = View {
        byte_length: USize64(bytes.len() as u64),
        buffer: Index::new(buffers.push(bytes) as u32),
        byte_offset: None,
        byte_stride: None,
        name: None,
        target: None,
        extensions: None,
        extras: None,
    };
    root.buffer_views.push(view);
    let accessor = &mut root.accessors[accessor];
    accessor.buffer_view = Some(Index::new((root.buffer_views.len() - 1) as u32));
    accessor.byte_offset = None;
    accessor.component_type = Checked::Valid(GenericComponentType(component));
}
