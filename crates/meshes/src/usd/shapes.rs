//! The blend shapes of a mesh prim.

use super::tree::{Placed, Tree, targets};
use super::values::Values;
use crate::shapes::Shape;
use rhytid_core::Result;
use rhytid_usd::layer::{Prim, Value};
use rhytid_usd::read::attribute;
use std::collections::{HashMap, HashSet};

/// The blend shapes of a mesh with so many points, in its own space.
pub(super) fn read(
    placed: &Placed<'_>,
    tree: &Tree<'_>,
    points: usize,
    values: &mut Values<'_>,
) -> Result<Vec<Shape>> {
    let mut shapes = Vec::new();
    for named in named(placed, tree, values)? {
        let Named { name, path, prim } = named;
        let Some(offsets) = values.vectors(prim, "offsets")? else { continue };
        let moved: Vec<u32> = match values.indices(prim, &path, "pointIndices")? {
            Some(moved) => moved,
            None => (0..points as u32).collect(),
        };
        if moved.len() != offsets.len() || moved.iter().any(|v| *v as usize >= points) {
            let what = format!(
                "has {} offsets for {} points of the {points} of its mesh, expected one for each; export it again",
                offsets.len(),
                moved.len()
            );
            return Err(values.wrong(&path, &what));
        }
        if prim.properties.iter().any(|property| property.name().starts_with("inbetweens:")) {
            log::warn!(
                "{}: the blend shape {name} has shapes in between, which are left out: it is read as it is in full",
                values.name
            );
        }
        // A point that is named twice counts once, as USD applies the last offset to it.
        let by_point: HashMap<u32, [f64; 3]> = moved.iter().copied().zip(offsets).collect();
        let mut moved: Vec<(u32, [f64; 3])> =
            by_point.into_iter().filter(|(_, by)| *by != [0.0; 3]).collect();
        moved.sort_unstable_by_key(|(v, _)| *v);
        shapes.push(Shape { name, moved });
    }
    Ok(shapes)
}

/// A blend shape and what its mesh calls it.
struct Named<'a> {
    name: String,
    path: String,
    prim: &'a Prim,
}

/// The shapes that the mesh points to, else those below it. No two have the same name.
fn named<'a>(placed: &Placed<'a>, tree: &Tree<'a>, values: &mut Values<'_>) -> Result<Vec<Named<'a>>> {
    let names = match values.get(placed.prim, "skel:blendShapes")? {
        Some(Value::Tokens(names)) => names,
        _ => Vec::new(),
    };
    let targets = targets(placed.prim, "skel:blendShapeTargets");
    let mut found: Vec<Named<'a>> = Vec::new();
    if !names.is_empty() && names.len() == targets.len() {
        let mut taken = HashSet::new();
        for (name, path) in names.into_iter().zip(targets) {
            let Some(found_at) = tree.at(path) else { continue };
            if taken.insert(name.clone()) {
                found.push(Named { name, path: path.clone(), prim: found_at.prim });
            }
        }
        return Ok(found);
    }
    for child in placed.prim.children.iter().filter(|child| child.type_name == "BlendShape") {
        let path = format!("{}/{}", placed.path, child.name);
        found.push(Named { name: child.name.clone(), path, prim: child });
    }
    Ok(found)
}

/// A shape that the layer's animation shows.
pub(super) struct Worn {
    name: String,
    weight: f64,
    /// Whether the weight has time samples.
    is_animated: bool,
}

/// The shapes that the layer's animations show at the time that is wanted.
pub(super) fn worn(tree: &Tree<'_>, values: &mut Values<'_>) -> Result<Vec<Worn>> {
    let mut worn = Vec::new();
    for animation in tree.of_type("SkelAnimation") {
        let Some(Value::Tokens(names)) = values.get(animation.prim, "blendShapes")? else { continue };
        let Some(Value::Floats(weights)) = values.get(animation.prim, "blendShapeWeights")? else { continue };
        let samples = attribute(animation.prim, "blendShapeWeights").and_then(|weights| weights.samples);
        for (name, weight) in names.into_iter().zip(weights).filter(|(_, weight)| *weight != 0.0) {
            worn.push(Worn { name, weight: weight.into(), is_animated: samples.is_some() });
        }
    }
    Ok(worn)
}

/// Moves points by the shapes that are worn, if a time is wanted. Otherwise says which are worn.
pub(super) fn wear(points: &mut [[f64; 3]], shapes: &[Shape], worn: &[Worn], values: &Values<'_>) {
    let by_name: HashMap<&str, &Shape> = shapes.iter().map(|shape| (&*shape.name, shape)).collect();
    for Worn { name, weight, is_animated } in worn {
        let Some(shape) = by_name.get(name.as_str()) else { continue };
        if values.time.is_some() {
            for (v, by) in &shape.moved {
                points[*v as usize].iter_mut().zip(by).for_each(|(x, by)| *x += weight * by);
            }
        } else if !is_animated {
            log::warn!(
                "{}: shows the shape {name} with the weight {weight}; the mesh is read without it",
                values.name
            );
        }
    }
}
