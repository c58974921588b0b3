//! Shapes with curves: points that are sums of a base and weighted offsets.

use super::lookup::attribute;
use crate::layer::{Prim, Value};

/// The shapes of a mesh, and where their weights are.
pub(super) struct Shapes {
    /// The number of the weights' samples.
    pub(super) samples: usize,
    /// V points, and as many normals where there are some.
    base: [Vec<[f32; 3]>; 2],
    /// Of each shape the offsets of both, for all vertices.
    offsets: Vec<[Vec<[f32; 3]>; 2]>,
}

impl Shapes {
    /// Those of `mesh`, moved by `animation`; `None` if its weights have no samples.
    ///
    /// # Errors
    /// What is wrong with them.
    pub(super) fn read(animation: &Prim, mesh: &Prim) -> Result<Option<Self>, String> {
        let Some(samples) = attribute(animation, "blendShapeWeights").and_then(|weights| weights.samples)
        else {
            return Ok(None);
        };
        let fault = |what: &str| format!("its shapes {what}; export it again");
        let value = |prim: &Prim, name: &str| attribute(prim, name).and_then(|found| found.default.clone());
        let vectors = |prim: &Prim, name: &str| match value(prim, name) {
            Some(Value::Float3s(vectors)) => vectors,
            _ => Vec::new(),
        };
        let base = [vectors(mesh, "points"), vectors(mesh, "normals")];
        let vertices = base[0].len();
        if !base[1].is_empty() && base[1].len() != vertices {
            return Err(fault("have another number of normals than of points"));
        }
        let shapes: Vec<&Prim> =
            mesh.children.iter().filter(|child| child.type_name == "BlendShape").collect();
        let names = [value(mesh, "skel:blendShapes"), value(animation, "blendShapes")];
        let is_name = |names: &Option<Value>| match names {
            Some(Value::Tokens(names)) => shapes.iter().map(|shape| &shape.name).eq(names),
            _ => false,
        };
        if !names.iter().all(is_name) {
            return Err(fault("are not those that are animated, in their order"));
        }
        let spread = |shape: &Prim, name: &str| {
            let moved = vectors(shape, name);
            let Some(Value::Ints(places)) = value(shape, "pointIndices") else {
                return (moved.len() == vertices).then_some(moved);
            };
            let mut all = vec![[0.0; 3]; vertices];
            for (place, offset) in places.iter().zip(&moved) {
                *all.get_mut(usize::try_from(*place).ok()?)? = *offset;
            }
            (places.len() == moved.len()).then_some(all)
        };
        let has_normals = !base[1].is_empty();
        let of_shape = |shape: &&Prim| {
            let normals = if has_normals { spread(shape, "normalOffsets")? } else { Vec::new() };
            Some([spread(shape, "offsets")?, normals])
        };
        let offsets = shapes.iter().map(of_shape).collect::<Option<_>>();
        let offsets = offsets.ok_or_else(|| fault("do not have an offset for each vertex that they name"))?;
        Ok(Some(Self { samples, base, offsets }))
    }

    pub(super) fn has_normals(&self) -> bool {
        !self.base[1].is_empty()
    }

    /// A sample as the weight of each shape, from 0 to 1.
    pub(super) fn weights(&self, sample: Value) -> Option<Vec<f32>> {
        match sample {
            Value::Floats(weights)
                if weights.len() == self.offsets.len()
                    && weights.iter().all(|weight| (0.0..=1.0).contains(weight)) =>
            {
                Some(weights)
            }
            _ => None,
        }
    }

    /// Replaces `out` by the 3V points that the weights make.
    pub(super) fn positions(&self, weights: &[f32], out: &mut Vec<f32>) {
        out.clear();
        out.extend(self.sum(0, weights).iter().flatten().map(|x| *x as f32));
    }

    /// Replaces `out` by the 3V normals that the weights make, of length 1; empties it where there are none.
    pub(super) fn normals(&self, weights: &[f32], out: &mut Vec<f32>) {
        out.clear();
        for normal in self.sum(1, weights) {
            let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            out.extend(normal.map(|x| if length > 0.0 { (x / length) as f32 } else { 0.0 }));
        }
    }

    fn sum(&self, kind: usize, weights: &[f32]) -> Vec<[f64; 3]> {
        let mut sum: Vec<[f64; 3]> = self.base[kind].iter().map(|x| x.map(f64::from)).collect();
        for (offsets, weight) in self.offsets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
            for (sum, offset) in sum.iter_mut().zip(&offsets[kind]) {
                for (x, d) in sum.iter_mut().zip(offset) {
                    *x += f64::from(*weight) * f64::from(*d);
                }
            }
        }
        sum
    }
}
