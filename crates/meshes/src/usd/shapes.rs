//! The blend shapes of a mesh prim.

use super::tree::{Placed, targets};
use super::values::Values;
use crate::shapes::Shape;
use rhytid_core::Result;
use rhytid_usd::layer::{Prim, Value};
use rhytid_usd::read::attribute;
use std::collections::{HashMap, HashSet};

/// The blend shapes of a mesh with so many points, in its own space.
pub(super) fn read(
    placed: &Placed<'_>,
    prims: &[Placed<'_>],
    points: usize,
    values: &mut Values<'_>,
) -> Result<Vec<Shape>> {
    let mut shapes = Vec::new();
    for named in named(placed, prims, values)? {
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
        let mut moved: Vec<(u32, [f64; 3])> = by_point.into_iter().filter(|(_, by)| *by != [0.0; 3]).collect();
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
fn named<'a>(
    placed: &Placed<'a>,
    prims: &[Placed<'a>],
    values: &mut Values<'_>,
) -> Result<Vec<Named<'a>>> {
    let names = match values.get(placed.prim, "skel:blendShapes")? {
        Some(Value::Tokens(names)) => names,
        _ => Vec::new(),
    };
    let targets = targets(placed.prim, "skel:blendShapeTargets");
    let mut found: Vec<Named<'a>> = Vec::new();
    if !names.is_empty() && names.len() == targets.len() {
        let by_path: HashMap<&str, &'a Prim> = prims.iter().map(|placed| (&*placed.path, placed.prim)).collect();
        let mut taken = HashSet::new();
        for (name, path) in names.into_iter().zip(targets) {
            let Some(prim) = by_path.get(path.as_str()) else { continue };
            if taken.insert(name.clone()) {
                found.push(Named { name, path: path.clone(), prim });
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

/// Moves points as the layer's animation wears the shapes, if a time is wanted. Says where shapes are worn
/// without a time.
pub(super) fn wear(
    points: &mut [[f64; 3]],
    shapes: &[Shape],
    prims: &[Placed<'_>],
    values: &mut Values<'_>,
) -> Result<()> {
    if shapes.is_empty() {
        return Ok(());
    }
    for animation in prims.iter().filter(|placed| placed.prim.type_name == "SkelAnimation") {
        let (names, weights) =
            match (values.get(animation.prim, "blendShapes")?, values.get(animation.prim, "blendShapeWeights")?) {
                (Some(Value::Tokens(names)), Some(Value::Floats(weights))) => (names, weights),
                _ => continue,
            };
        let is_animated = attribute(animation.prim, "blendShapeWeights").is_some_and(|a| a.samples.is_some());
        for (name, weight) in names.iter().zip(weights).filter(|(_, weight)| *weight != 0.0) {
            let Some(shape) = shapes.iter().find(|shape| shape.name == *name) else { continue };
            match values.time {
                Some(_) => {
                    for (v, by) in &shape.moved {
                        let point = &mut points[*v as usize];
                        point.iter_mut().zip(by).for_each(|(x, by)| *x += f64::from(weight) * by);
                    }
                }
                None if !is_animated => log::warn!(
                    "{}: shows the shape {name} with the weight {weight}; the mesh is read without it",
                    values.name
                ),
                None => {}
            }
        }
    }
    Ok(())
}
