//! Shapes with sliders as USD: a mesh with blend shapes, and an animation with their weights, all 0. The
//! animation is on a skeleton of one joint that does not move the mesh.
use super::layer_writer::{Encoding, LayerWriter};
use super::names::identifiers;
use super::numbers::integer;
use super::surface::Surface;
use crate::build::{attribute, prim, token};
use crate::layer::{Attribute, Layer, Prim, Property, Value};
use rhytid_core::Result;
use rhytid_export::{Shape, Shapes};
use std::path::Path;

/// Writes shapes to a file, and returns its size in bytes.
///
/// # Errors
/// As [`LayerWriter::create`].
pub fn write_shapes(path: &Path, encoding: Encoding, shapes: &Shapes<'_>) -> Result<u64> {
    LayerWriter::create(path, encoding, &layer(shapes)?)?.finish()
}

fn layer(shapes: &Shapes<'_>) -> Result<Layer> {
    let mut surface = Surface::new(&shapes.rest_scene(), "SkelRoot")?;
    let skeleton = bind(&mut surface, shapes.shapes, vec![animation(WEIGHTS, None)])?;
    Ok(surface.into_layer(vec![skeleton]))
}

/// The name of an animation that is the only one.
pub(super) const WEIGHTS: &str = "weights";

/// An animation of weights: all 0, or samples under the number `samples`. Its shapes are not named yet.
pub(super) fn animation(name: &str, samples: Option<usize>) -> Prim {
    let mut weights = prim("SkelAnimation", name);
    weights.push(Attribute { samples, ..attribute("float[]", "blendShapeWeights", None) });
    weights
}

/// Gives the mesh its shapes, and returns the skeleton that has the animations of their weights.
pub(super) fn bind(surface: &mut Surface, shapes: &[Shape], animations: Vec<Prim>) -> Result<Prim> {
    let names = identifiers(shapes.iter().map(|shape| shape.name.as_str()));
    let skeleton = declare(surface, names.clone(), animations);
    for (name, shape) in names.iter().zip(shapes) {
        surface.mesh.children.push(blend_shape(name, shape)?);
    }
    Ok(skeleton)
}

/// Says that the mesh has shapes of these names, and returns the skeleton that has the animations of their
/// weights. The first one is bound.
pub(super) fn declare(surface: &mut Surface, names: Vec<String>, animations: Vec<Prim>) -> Prim {
    let root = format!("/{}", surface.root.name);
    let skeleton = format!("{root}/skeleton");
    let mesh = &mut surface.mesh;
    let mesh_path = format!("{root}/{}", mesh.name);
    mesh.apply("SkelBindingAPI");
    mesh.set_uniform("token[]", "skel:blendShapes", Value::Tokens(names.clone()));
    let targets = names.iter().map(|name| format!("{mesh_path}/{name}")).collect();
    mesh.relate("skel:blendShapeTargets", targets);
    mesh.relate("skel:skeleton", vec![skeleton.clone()]);
    skeleton_prim(&names, &skeleton, animations)
}

/// A shape with only the vertices that it moves, if a quarter or more stand still.
fn blend_shape(name: &str, shape: &Shape) -> Result<Prim> {
    let normals = shape.normal_offsets.as_deref();
    let moves =
        |&v: &usize| shape.offsets[v] != [0.0; 3] || normals.is_some_and(|normals| normals[v] != [0.0; 3]);
    let vertices = shape.offsets.len();
    let moving: Vec<usize> = (0..vertices).filter(moves).collect();
    let sparse = moving.len() <= vertices / 4 * 3;
    let pick = |offsets: &[[f32; 3]]| {
        Value::Float3s(if sparse { moving.iter().map(|&v| offsets[v]).collect() } else { offsets.to_vec() })
    };
    let mut blend_shape = prim("BlendShape", name);
    let data = vec![("name".into(), Value::String(shape.name.clone()))];
    blend_shape.metadata.push(("customData".into(), Value::Dictionary(data)));
    blend_shape.set_uniform("vector3f[]", "offsets", pick(&shape.offsets));
    if let Some(normals) = normals {
        blend_shape.set_uniform("vector3f[]", "normalOffsets", pick(normals));
    }
    if sparse {
        let indices = moving.iter().map(|&v| integer(v)).collect::<Result<_>>()?;
        blend_shape.set_uniform("int[]", "pointIndices", Value::Ints(indices));
    }
    Ok(blend_shape)
}

/// The skeleton at the path `path`, with the animations below it.
fn skeleton_prim(names: &[String], path: &str, animations: Vec<Prim>) -> Prim {
    const IDENTITY: [[f64; 4]; 4] =
        [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let mut skeleton = prim("Skeleton", "skeleton");
    skeleton.apply("SkelBindingAPI");
    skeleton.set_uniform("token[]", "joints", Value::Tokens(vec!["root".into()]));
    skeleton.set_uniform("matrix4d[]", "bindTransforms", Value::Matrix4ds(vec![IDENTITY]));
    skeleton.set_uniform("matrix4d[]", "restTransforms", Value::Matrix4ds(vec![IDENTITY]));
    // The skeleton is not shown.
    skeleton.set_uniform("token", "purpose", token("guide"));
    let bound = animations.iter().take(1).map(|animation| format!("{path}/{}", animation.name)).collect();
    skeleton.relate("skel:animationSource", bound);
    for mut animation in animations {
        let mut weights = std::mem::take(&mut animation.properties);
        for property in &mut weights {
            if let Property::Attribute(weights) = property
                && weights.samples.is_none()
            {
                weights.default = Some(Value::Floats(vec![0.0; names.len()]));
            }
        }
        animation.set_uniform("token[]", "blendShapes", Value::Tokens(names.to_vec()));
        animation.properties.extend(weights);
        skeleton.children.push(animation);
    }
    skeleton
}
