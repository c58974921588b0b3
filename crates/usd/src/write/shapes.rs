//! Shapes with sliders as USD: a mesh with blend shapes, and an animation with their weights, all 0. The
//! animation is on a skeleton of one joint that does not move the mesh.
use super::choices::Choices;
use super::layer_writer::{Encoding, LayerWriter};
use super::names::{display_name, identifiers};
use super::numbers::integer;
use super::surface::{Surface, extent};
use super::textures;
use crate::build::{attribute, prim, token};
use crate::layer::{Attribute, Layer, Prim, Property, Value};
use rhytid_core::Result;
use rhytid_export::{Options, Shape, Shapes};
use std::path::Path;

/// Writes shapes to a file, and returns its size in bytes.
///
/// # Errors
/// As [`LayerWriter::create`]; [`rhytid_core::Error::Input`] for textures where this encoding has no place
/// for them.
pub fn write_shapes(path: &Path, encoding: Encoding, shapes: &Shapes<'_>, options: &Options) -> Result<u64> {
    let (assets, attached) = textures::place(path, encoding, &shapes.rest_scene(), options)?;
    LayerWriter::with(path, encoding, &layer(shapes, &Choices::new(options, assets))?, attached)?.finish()
}

fn layer(shapes: &Shapes<'_>, choices: &Choices) -> Result<Layer> {
    let mut surface = Surface::new(&shapes.rest_scene(), "SkelRoot", choices)?;
    let extent = extent_of_sliders(shapes.rest, shapes.shapes).to_vec();
    surface.root.set("float3[]", "extent", Value::Float3s(extent));
    let skeleton = bind(&mut surface, shapes.shapes, vec![animation(WEIGHTS, None)])?;
    Ok(surface.into_layer(vec![skeleton]))
}

/// The box around the mesh at rest and with each slider alone at 1.
fn extent_of_sliders(rest: &[[f32; 3]], shapes: &[Shape]) -> [[f32; 3]; 2] {
    let alone = |k: usize| posed_extent(rest, &shapes[k..=k], &[1.0]);
    around((0..shapes.len()).map(alone).chain([extent(rest)]))
}

/// The box around boxes.
pub(super) fn around(boxes: impl Iterator<Item = [[f32; 3]; 2]>) -> [[f32; 3]; 2] {
    let of = |a: [f32; 3], b: [f32; 3], of: fn(f32, f32) -> f32| [0, 1, 2].map(|axis| of(a[axis], b[axis]));
    boxes.reduce(|[a, b], [c, d]| [of(a, c, f32::min), of(b, d, f32::max)]).unwrap_or_default()
}

/// Programs add the shapes in 32 bits. Their points are farther off than the sums in 64 bits by up to this
/// part of the farthest coordinate.
const ROUNDING: f64 = 1e-6;

/// The box around the base with shapes of these weights, however a program rounds.
pub(super) fn posed_extent(base: &[[f32; 3]], shapes: &[Shape], weights: &[f32]) -> [[f32; 3]; 2] {
    let weighted: Vec<(&Shape, f64)> =
        shapes.iter().zip(weights).map(|(shape, weight)| (shape, f64::from(*weight))).collect();
    let [mut low, mut high] = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for (v, base) in base.iter().enumerate() {
        for axis in 0..3 {
            let moved: f64 =
                weighted.iter().map(|(shape, weight)| weight * f64::from(shape.offsets[v][axis])).sum();
            let x = f64::from(base[axis]) + moved;
            low[axis] = low[axis].min(x);
            high[axis] = high[axis].max(x);
        }
    }
    let farthest = low.iter().chain(&high).fold(0.0, |most: f64, x| most.max(x.abs()));
    let [low, high] = [low.map(|x| x - ROUNDING * farthest), high.map(|x| x + ROUNDING * farthest)];
    [low.map(|x| x as f32), high.map(|x| x as f32)]
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
    let root = surface.path();
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
    blend_shape.metadata.extend(display_name(name, &shape.name));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_around_all_boxes_along_every_axis() {
        let [low, high] = [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]];
        for axis in 0..3 {
            let [mut below, mut above] = [[low, high]; 2];
            below[0][axis] = -1.0;
            above[1][axis] = 9.0;
            let found = around([[low, high], below, above].into_iter());
            assert_eq!(found, [below[0], above[1]], "axis {axis}");
        }
    }
}
