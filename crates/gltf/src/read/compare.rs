//! The differences between a file and the one that an export writes, apart from the numbers of its frames:
//! every object and value of the JSON, the triangles, the texture coordinates, and the bounds.
//!
//! The expected JSON is the file's own, with everything in it that the scene decides.

use super::AtRest;
use super::arrays::Arrays;
use super::layout::{Layout, Originals};
use crate::attributes::{self, Accessors, Extras};
use crate::node::local_transform;
use crate::write::{About, Looks, Placement, Surface, extensions, head_node, placed};
use ::gltf::json::accessor::{Accessor, ComponentType};
use ::gltf::json::mesh::{Mesh, MorphTarget, Primitive, Semantic};
use ::gltf::json::validation::Checked::Valid;
use ::gltf::json::{Asset, Image, Index, Node, Root, Scene as JsonScene};
use rhytid_core::{Error, Result};
use rhytid_export::Scene;
use serde_json::Value;

/// Texture coordinates of 16 bits are rounded by half of this, twice.
const OF_UVS: f64 = 1.0 / 65_535.0;

/// Rounding of the head's matrix to 32 bits, in metres or of a rotation.
const HEAD_ROUNDING: f64 = 1e-5;

/// The keys of a scene's extras, and of a clip's.
const EXTRAS: [&str; 13] = [
    "vertices",
    "copies",
    "metresPerUnit",
    "upAxis",
    "rhytid",
    "frames",
    "framesPerSecond",
    "firstTimeCode",
    "attributes",
    "error",
    "normalError",
    "strainError",
    "attributeErrors",
];

/// `json` is the text of the file's JSON, and `targets` are the accessors of its targets' own attributes.
/// `at_rest` is what the mesh and the head's node show where nothing is played.
pub(super) fn differences(
    arrays: &mut Arrays,
    json: &[u8],
    targets: &[Accessors],
    layout: &Layout,
    at_rest: &AtRest,
    scene: &Scene<'_>,
) -> Result<Vec<String>> {
    let broken = |e: serde_json::Error| Error::Internal(format!("JSON that was read before: {e}"));
    let found: Value = serde_json::from_slice(json).map_err(broken)?;
    let surface = expected_surface(&arrays.root, scene);
    let looks = Looks::new(scene, &surface, !arrays.root.images.is_empty());
    let mut expected =
        serde_json::to_value(expected(&arrays.root, layout, at_rest, scene, &looks)?).map_err(broken)?;
    let own = |target: &Accessors| -> Extras {
        target.iter().map(|(name, accessor)| (name.clone(), *accessor as u32)).collect()
    };
    attributes::add_to_targets(&mut expected, &targets.iter().map(own).collect::<Vec<_>>());
    let mut differences = Vec::new();
    compare("", &found, &expected, &mut differences);
    let of_clips = (0..layout.clips.len()).map(|clip| format!("animations/{clip}/extras"));
    for place in std::iter::once("scenes/0/extras".to_owned()).chain(of_clips) {
        let Some(Value::Object(extras)) = found.pointer(&format!("/{place}")) else { continue };
        let unknown = extras.keys().filter(|key| !EXTRAS.contains(&key.as_str()));
        differences.extend(unknown.map(|key| format!("{place}/{key}: is there, expected none")));
    }
    head_at_rest(&arrays.root, layout, at_rest, &mut differences);
    triangles_and_uvs(arrays, layout, &surface, &mut differences)?;
    images(arrays, &looks, &mut differences)?;
    bounds(arrays, layout, &mut differences)?;
    views(&arrays.root, &mut differences);
    Ok(differences)
}

/// The file's document, with everything that the scene decides.
fn expected(
    found: &Root,
    layout: &Layout,
    at_rest: &AtRest,
    scene: &Scene<'_>,
    looks: &Looks,
) -> Result<Root> {
    let are_several = !layout.clips.is_empty();
    let about = About::new(scene);
    let is_integer = |accessor: Index<Accessor>| {
        let accessor = found.accessors.get(accessor.value()).map(|accessor| accessor.component_type);
        matches!(accessor, Some(Valid(component)) if component.0 != ComponentType::F32)
    };
    let mesh = found.meshes.first();
    let primitive = mesh.and_then(|mesh| mesh.primitives.first());
    let of_targets = primitive.into_iter().flat_map(|primitive| primitive.targets.iter().flatten());
    let of_targets = of_targets.flat_map(|target| [target.positions, target.normals]).flatten();
    let is_quantized = primitive
        .into_iter()
        .flat_map(|primitive| primitive.attributes.values().copied())
        .chain(of_targets)
        .any(is_integer);
    let has_views = |view: &::gltf::json::buffer::View| {
        view.extensions
            .as_ref()
            .is_some_and(|extensions| extensions.others.contains_key(crate::meshopt::EXTENSION))
    };
    let extensions = extensions(is_quantized, found.buffer_views.iter().any(has_views));
    let mut nodes = vec![mesh_node(found.nodes.first(), is_quantized, &about, scene)];
    if are_several && layout.head.is_some() {
        // Where nothing is played, the head is where another clip may have it.
        let node = found.nodes.get(1);
        nodes.push(Node {
            rotation: node.and_then(|node| node.rotation),
            translation: node.and_then(|node| node.translation),
            ..head_node(&[], scene.name, scene.metres_per_unit, scene.up_axis, Index::new(0))
        });
    } else if let Some(head) = scene.head {
        nodes.push(head_node(head, scene.name, scene.metres_per_unit, scene.up_axis, Index::new(0)));
    }
    let root = Index::new(nodes.len() as u32 - 1);
    let is_expected = |semantic: &Semantic| match semantic {
        Semantic::Positions | Semantic::Extras(_) => true,
        Semantic::Normals => scene.rest_normals.is_some(),
        Semantic::TexCoords(set) => *set == 0 && scene.uvs.is_some(),
        _ => false,
    };
    let plain = |target: &MorphTarget| MorphTarget { tangents: None, ..target.clone() };
    // All primitives share what the first one has, and each has triangles of its own.
    let shared = primitive.map(|primitive| Primitive {
        attributes: primitive
            .attributes
            .iter()
            .filter(|(semantic, _)| matches!(semantic, Valid(semantic) if is_expected(semantic)))
            .map(|(semantic, accessor)| (semantic.clone(), *accessor))
            .collect(),
        extensions: None,
        extras: None,
        indices: None,
        material: None,
        mode: Valid(::gltf::json::mesh::Mode::Triangles),
        targets: primitive.targets.as_ref().map(|targets| targets.iter().map(plain).collect()),
    });
    let mut primitives = Vec::new();
    for found in mesh.map_or(&[][..], |mesh| &mesh.primitives) {
        let material = Some(Index::new(primitives.len() as u32));
        primitives.extend(shared.clone().map(|shared| Primitive {
            indices: found.indices,
            material,
            ..shared
        }));
    }
    let mut animations = found.animations.clone();
    if !are_several {
        animations.truncate(1);
    }
    for animation in &mut animations {
        animation.extensions = None;
        animation.extras = animation.extras.take().filter(|_| are_several);
        animation.channels.iter_mut().for_each(|channel| {
            (channel.extensions, channel.extras) = (None, None);
            (channel.target.extensions, channel.target.extras) = (None, None);
        });
        animation.samplers.iter_mut().for_each(|sampler| (sampler.extensions, sampler.extras) = (None, None));
    }
    let extras = found.scenes.first().and_then(|scene| scene.extras.clone());
    // An image may be inside, beside or elsewhere; what it shows is compared later.
    let images = looks.images.iter().enumerate().map(|(i, image)| {
        let found = found.images.get(i);
        let (view, uri) =
            (found.and_then(|found| found.buffer_view), found.and_then(|found| found.uri.clone()));
        Image { buffer_view: view, uri, ..image.json() }
    });
    Ok(Root {
        asset: Asset { version: "2.0".into(), generator: found.asset.generator.clone(), ..Asset::default() },
        scene: Some(Index::new(0)),
        scenes: vec![JsonScene { extensions: None, extras, name: None, nodes: vec![root] }],
        nodes,
        meshes: vec![Mesh {
            extensions: None,
            extras: mesh.and_then(|mesh| mesh.extras.clone()),
            name: Some(scene.name.to_owned()),
            primitives,
            weights: Some(at_rest.weights.clone()).filter(|weights| !weights.is_empty()),
        }],
        materials: looks.materials()?,
        textures: looks.textures(),
        images: images.collect(),
        animations,
        buffers: found.buffers.clone(),
        buffer_views: found.buffer_views.clone(),
        accessors: found.accessors.clone(),
        extensions_used: extensions.clone(),
        extensions_required: extensions,
        ..Root::default()
    })
}

/// The head's node among several clips, where nothing is played: it is as in the first frame of the first
/// clip.
fn head_at_rest(root: &Root, layout: &Layout, at_rest: &AtRest, differences: &mut Vec<String>) {
    let (Some(expected), Some(node)) = (at_rest.head, root.nodes.get(1)) else { return };
    if !layout.clips.is_empty() && !local_transform(node).abs_diff_eq(expected, HEAD_ROUNDING) {
        differences.push("nodes/1: is not as in the first frame of the first clip".into());
    }
}

/// The surface that an export writes: a part for each material, or a single one if the file has one.
fn expected_surface(found: &Root, scene: &Scene<'_>) -> Surface {
    let one_material = found.meshes.first().is_some_and(|mesh| mesh.primitives.len() == 1);
    Surface::new(scene, one_material)
}

/// The node of the mesh. Integers are placed by the node, and are compared as positions.
fn mesh_node(found: Option<&Node>, is_quantized: bool, about: &About, scene: &Scene<'_>) -> Node {
    let placed = placed(Placement::NONE, scene.metres_per_unit, scene.up_axis);
    let (scale, translation) = match found.filter(|_| is_quantized) {
        Some(found) => (found.scale, found.translation),
        None => (placed.scale, placed.translation),
    };
    Node { mesh: Some(Index::new(0)), name: Some(about.name().to_owned()), scale, translation, ..placed }
}

/// Adds what differs, with its place.
fn compare(place: &str, found: &Value, expected: &Value, differences: &mut Vec<String>) {
    let at = |key: &dyn std::fmt::Display| {
        if place.is_empty() { key.to_string() } else { format!("{place}/{key}") }
    };
    match (found, expected) {
        (Value::Object(found), Value::Object(expected)) => {
            for (key, expected) in expected {
                match found.get(key) {
                    Some(found) => compare(&at(key), found, expected, differences),
                    None => differences.push(format!("{}: is missing", at(key))),
                }
            }
            let unknown = found.keys().filter(|key| !expected.contains_key(*key));
            differences.extend(unknown.map(|key| format!("{}: is there, expected none", at(key))));
        }
        (Value::Array(found), Value::Array(expected)) if found.len() == expected.len() => {
            for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
                compare(&at(&i), found, expected, differences);
            }
        }
        (Value::Array(found), Value::Array(expected)) => {
            differences.push(format!("{place}: has {} elements, expected {}", found.len(), expected.len()));
        }
        (Value::Number(found), Value::Number(expected)) => {
            let (a, b) = (found.as_f64().unwrap_or(f64::NAN), expected.as_f64().unwrap_or(f64::NAN));
            let apart = (a - b).abs();
            if apart.is_nan() || apart > 1e-6 * b.abs().max(1e-3) {
                differences.push(format!("{place}: is {found}, expected {expected}"));
            }
        }
        _ if found == expected => {}
        _ => {
            let words = |value: &Value| value.to_string().chars().take(60).collect::<String>();
            differences.push(format!("{place}: is {}, expected {}", words(found), words(expected)));
        }
    }
}

/// The triangles of each material, the copies of vertices, and the texture coordinates.
fn triangles_and_uvs(
    arrays: &mut Arrays,
    layout: &Layout,
    expected: &Surface,
    differences: &mut Vec<String>,
) -> Result<()> {
    if layout.indices.len() != expected.parts.len() {
        differences.push(format!(
            "meshes/0/primitives: are {}, expected {}, one for each material",
            layout.indices.len(),
            expected.parts.len()
        ));
    }
    for (i, (&indices, part)) in layout.indices.iter().zip(&expected.parts).enumerate() {
        if arrays.indices(indices)? != part.indices {
            differences.push(format!("meshes/0/primitives/{i}: the triangles are others"));
        }
    }
    if let Some(Originals { vertices, copies }) = &layout.originals {
        let copied = expected.copied().iter().map(|&vertex| vertex as usize);
        if *vertices != expected.originals() || !copies.iter().copied().eq(copied) {
            differences.push("scenes/0/extras/copies: are others".into());
        }
    }
    if let Some(accessor) = layout.ids
        && !arrays.vertex_ids(accessor)?.into_iter().eq(expected.ids().map(f64::from))
    {
        differences.push("_VERTEX_ID: has other numbers".into());
    }
    match (layout.uvs, &expected.uvs) {
        (None, None) | (Some(_), None) => {}
        (None, Some(_)) => differences.push("TEXCOORD_0: is missing".into()),
        (Some(accessor), Some(expected)) => {
            let found = arrays.vectors::<2>(accessor)?;
            let is_off =
                |(a, b): (&[f64; 2], &[f32; 2])| (0..2).any(|c| (a[c] - f64::from(b[c])).abs() > OF_UVS);
            let off = found.iter().zip(expected).filter(|pair| is_off(*pair)).count();
            if off > 0 || found.len() != expected.len() {
                differences.push(format!("TEXCOORD_0: {off} texture coordinates are others"));
            }
        }
    }
    Ok(())
}

/// The bytes of the images, inside the file or beside it. Images elsewhere are compared by their paths.
fn images(arrays: &mut Arrays, looks: &Looks, differences: &mut Vec<String>) -> Result<()> {
    for (i, expected) in looks.images.iter().enumerate() {
        let Some(found) = arrays.root.images.get(i) else { continue };
        let is_right = match (found.buffer_view, &found.uri) {
            (Some(view), None) => arrays.bytes(view.value())? == *expected.bytes,
            (None, Some(uri)) if Some(uri) == expected.path.as_ref() => true,
            (None, Some(uri)) => {
                arrays.source.beside(uri, expected.bytes.len() as u64) == Some(expected.bytes.to_vec())
            }
            _ => false,
        };
        if !is_right {
            differences.push(format!("images/{i}: is not the texture {}", expected.name));
        }
    }
    Ok(())
}

/// The bounds of the base and of each target: viewers leave out what seems to be out of sight.
fn bounds(arrays: &mut Arrays, layout: &Layout, differences: &mut Vec<String>) -> Result<()> {
    let of_targets = layout.targets.iter().map(|target| target.first().copied().flatten());
    let accessors: Vec<usize> =
        layout.base.first().copied().into_iter().chain(of_targets).flatten().collect();
    for accessor in accessors {
        let vectors = arrays.vectors::<3>(accessor)?;
        let stated = &arrays.root.accessors[accessor];
        // Bounds are those of the stored numbers.
        let unit = match (stated.normalized, stated.component_type) {
            (true, Valid(component)) if component.0 == ComponentType::I8 => 127.0,
            (true, Valid(component)) if component.0 == ComponentType::I16 => 32_767.0,
            _ => 1.0,
        };
        let of = |end: fn(f64, f64) -> f64, begin: f64| {
            vectors.iter().fold([begin; 3], |all, x| std::array::from_fn(|c| end(all[c], x[c] * unit)))
        };
        let ends = [of(f64::min, f64::INFINITY), of(f64::max, f64::NEG_INFINITY)];
        for (stated, found) in [&stated.min, &stated.max].into_iter().zip(ends) {
            let stated: Option<Vec<f64>> = stated
                .as_ref()
                .and_then(Value::as_array)
                .map(|numbers| numbers.iter().map(|x| x.as_f64().unwrap_or(f64::NAN)).collect());
            let is_right = stated.is_some_and(|stated| {
                stated.len() == 3
                    && stated.iter().zip(found).all(|(a, b)| (a - b).abs() <= 1e-5 * b.abs().max(1e-3))
            });
            if !is_right {
                differences.push(format!("accessors/{accessor}: its bounds are not those of its numbers"));
            }
        }
    }
    let Some(times) = layout.times else { return Ok(()) };
    let keys = arrays.vectors::<1>(times)?;
    let stated = &arrays.root.accessors[times];
    for (stated, found) in [(&stated.min, keys.first()), (&stated.max, keys.last())] {
        let stated = stated.as_ref().and_then(|stated| stated.get(0)).and_then(Value::as_f64);
        if stated
            .zip(found)
            .is_none_or(|(stated, [found])| (stated - found).abs() > 1e-5 * found.abs().max(1e-3))
        {
            differences.push(format!("accessors/{times}: its bounds are not those of its times"));
        }
    }
    Ok(())
}

/// Where the numbers stand: each accessor has a view of its own, one after the other. So has each image
/// inside.
fn views(root: &Root, differences: &mut Vec<String>) {
    let sizes = |accessor: &Accessor| {
        let (Valid(component), Valid(kind)) = (accessor.component_type, accessor.type_) else { return None };
        Some((component.0, component.0.size() * kind.multiplicity()))
    };
    let mut expected: Vec<Option<(usize, usize)>> = vec![None; root.buffer_views.len()];
    let mut place = |view: Index<::gltf::json::buffer::View>, length: usize, stride: usize| {
        match expected.get_mut(view.value()) {
            Some(place @ None) => *place = Some((length, stride)),
            _ => return false,
        }
        true
    };
    let mut are_own = true;
    for view in root.images.iter().filter_map(|image| image.buffer_view) {
        let length = root.buffer_views.get(view.value()).map_or(0, |view| view.byte_length.0);
        are_own &= place(view, length as usize, 1);
    }
    for (i, accessor) in root.accessors.iter().enumerate() {
        let Some((component, size)) = sizes(accessor) else { continue };
        let (stride, count) = (size.next_multiple_of(4), accessor.count.0 as usize);
        let is_integer = !matches!(component, ComponentType::F32 | ComponentType::U32);
        if is_integer != accessor.normalized || component == ComponentType::U8 {
            differences
                .push(format!("accessors/{i}: has integers that are not normalised, or of another kind"));
        }
        if let Some(view) = accessor.buffer_view {
            are_own &= accessor.byte_offset.unwrap_or_default().0 == 0;
            are_own &= place(view, count.saturating_mul(stride), stride);
        }
        if let Some(sparse) = &accessor.sparse {
            let length = (sparse.count.0 as usize).saturating_mul(4);
            are_own &=
                place(sparse.indices.buffer_view, length, 4) && place(sparse.values.buffer_view, length, 4);
        }
    }
    if !are_own || expected.iter().any(Option::is_none) {
        differences.push("bufferViews: not each of them belongs to one accessor".into());
        return;
    }
    let is_plain = root.buffer_views.iter().all(|view| view.extensions.is_none());
    let mut end = 0;
    for (i, (view, expected)) in root.buffer_views.iter().zip(expected).enumerate() {
        let (length, stride) = expected.unwrap_or_default();
        let is_of_vertices = matches!(view.target, Some(Valid(::gltf::json::buffer::Target::ArrayBuffer)));
        let found_stride = view.byte_stride.map(|stride| stride.0);
        if view.byte_length.0 != length as u64 || found_stride != is_of_vertices.then_some(stride) {
            differences.push(format!("bufferViews/{i}: has another length or stride than its numbers"));
        }
        if is_plain {
            if view.byte_offset.unwrap_or_default().0 != end {
                differences.push(format!("bufferViews/{i}: begins somewhere else"));
            }
            end += (length as u64).next_multiple_of(4);
        }
    }
    if is_plain && root.buffers.first().is_some_and(|buffer| buffer.byte_length.0 != end) {
        differences.push("buffers/0: has another length than its numbers".into());
    }
}
