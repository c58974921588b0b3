//! Where vertices stand: where their node is, or where the joints of a skin put them.

use super::accessor::Accessors;
use super::nodes::Nodes;
use ::gltf::json::mesh::{Primitive, Semantic};
use ::gltf::json::validation::Checked;
use glam::DMat4;
use rhytid_core::{Error, Result};
use std::rc::Rc;

/// The transforms of a skin's joints, from the stored mesh to scene space, in the pose that the nodes have.
pub(super) struct Skin {
    joints: Vec<DMat4>,
}

/// The accessors of up to four joints of each vertex, and of their weights.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Set {
    joints: usize,
    weights: usize,
}

/// The most sets that are read. Faces have one or two.
const MOST_SETS: u32 = 4;

/// The sets of a primitive. Empty if it has none.
pub(super) fn sets(primitive: &Primitive, place: &str, name: &str) -> Result<Vec<Set>> {
    let attribute =
        |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(::gltf::json::Index::value);
    let mut sets = Vec::new();
    for number in 0..=MOST_SETS {
        let found = (attribute(Semantic::Joints(number)), attribute(Semantic::Weights(number)));
        match found {
            (None, None) => break,
            (Some(joints), Some(weights)) if number < MOST_SETS => sets.push(Set { joints, weights }),
            (Some(_), Some(_)) => {
                return Err(Error::unsupported_format(format!(
                    "{name}: {place} has more than {} joints for each vertex, which is not supported; export \
                     it with fewer",
                    4 * MOST_SETS
                )));
            }
            _ => {
                return Err(Error::malformed(format!(
                    "{name}: {place} has only one of JOINTS_{number} and WEIGHTS_{number}, expected both; \
                     export the mesh again"
                )));
            }
        }
    }
    Ok(sets)
}

/// How far a vertex follows a joint.
#[derive(Clone, Copy)]
struct Influence {
    joint: u32,
    /// Those of a vertex add up to 1.
    weight: f64,
}

/// Where the vertices of a primitive stand.
pub(super) enum Placement {
    /// All where their node is.
    Node(DMat4),
    /// Each where its joints put it.
    Joints(Skinned),
}

/// What joints do to the vertices of a primitive.
pub(super) struct Skinned {
    skin: Rc<Skin>,
    /// As many for each vertex as for the others.
    influences: Vec<Influence>,
    of_each: usize,
}

impl Placement {
    /// The transform of a vertex, from its stored position to scene space.
    pub(super) fn of(&self, vertex: usize) -> DMat4 {
        match self {
            Self::Node(transform) => *transform,
            Self::Joints(skinned) => {
                let own = &skinned.influences[vertex * skinned.of_each..][..skinned.of_each];
                let mut blended = DMat4::ZERO;
                for influence in own.iter().filter(|influence| influence.weight != 0.0) {
                    blended += skinned.skin.joints[influence.joint as usize] * influence.weight;
                }
                blended
            }
        }
    }

    /// Whether a vertex and its surroundings are mirrored.
    pub(super) fn is_mirror(&self, vertex: usize) -> bool {
        self.of(vertex).determinant() < 0.0
    }
}

impl Skin {
    /// Skin `index` of the document.
    pub(super) fn read(accessors: &Accessors<'_>, nodes: &Nodes<'_>, index: usize) -> Result<Self> {
        let fail = |what: String| Err(Error::malformed(format!("{}: skin {index} {what}", accessors.name)));
        let Some(skin) = accessors.root.skins.get(index) else {
            return fail("does not exist; the file is damaged".into());
        };
        let inverse_binds = match skin.inverse_bind_matrices {
            Some(matrices) => Some(accessors.vectors::<16>(matrices.value())?),
            None => None,
        };
        let mut joints = Vec::with_capacity(skin.joints.len());
        for (j, joint) in skin.joints.iter().map(::gltf::json::Index::value).enumerate() {
            let Some(transform) = nodes.transform(joint) else {
                return fail(format!(
                    "has the joint {joint}, expected a node in a tree; the file is damaged"
                ));
            };
            joints.push(match &inverse_binds {
                None => transform,
                Some(matrices) => match matrices.get(j) {
                    Some(inverse_bind) => transform * DMat4::from_cols_array(inverse_bind),
                    None => {
                        return fail(format!(
                            "has {} inverse bind matrices for {} joints, expected one for each; export the mesh \
                             again",
                            matrices.len(),
                            skin.joints.len()
                        ));
                    }
                },
            });
        }
        Ok(Self { joints })
    }

    /// What the skin does to the `count` vertices of a primitive that has these sets.
    pub(super) fn place(
        self: &Rc<Self>,
        accessors: &Accessors<'_>,
        sets: &[Set],
        count: usize,
        place: &str,
    ) -> Result<Placement> {
        let name = accessors.name;
        let fail = |what: String| Err(Error::malformed(format!("{name}: {place} {what}")));
        if sets.is_empty() {
            return fail(
                "has a skin but neither JOINTS_0 nor WEIGHTS_0, expected both; export the mesh again, or \
                 without its armature"
                    .into(),
            );
        }
        let of_each = 4 * sets.len();
        let mut influences = vec![Influence { joint: 0, weight: 0.0 }; of_each * count];
        for (s, set) in sets.iter().enumerate() {
            let joints = accessors.vectors::<4>(set.joints)?;
            let weights = accessors.vectors::<4>(set.weights)?;
            if joints.len() != count || weights.len() != count {
                return fail(format!(
                    "has joints of {} vertices and weights of {}, expected {count}; export the mesh again",
                    joints.len(),
                    weights.len()
                ));
            }
            for (v, (joints, weights)) in joints.iter().zip(&weights).enumerate() {
                for (k, (&joint, &weight)) in joints.iter().zip(weights).enumerate() {
                    if !(weight.is_finite() && weight >= 0.0) {
                        return fail(format!(
                            "has the weight {weight} at vertex {v}, expected 0 or more; export the mesh again"
                        ));
                    }
                    // Joints without weight may be any number.
                    if weight > 0.0 && !(joint >= 0.0 && (joint as usize) < self.joints.len()) {
                        return fail(format!(
                            "has the joint {joint} at vertex {v}, expected 0 to {}; the file may be damaged",
                            self.joints.len().saturating_sub(1)
                        ));
                    }
                    influences[v * of_each + 4 * s + k] = Influence { joint: joint as u32, weight };
                }
            }
        }
        for (v, own) in influences.chunks_exact_mut(of_each).enumerate() {
            let sum: f64 = own.iter().map(|influence| influence.weight).sum();
            if sum == 0.0 {
                return fail(format!(
                    "has no joint with a weight at vertex {v}, expected at least one; weigh all vertices and \
                     export the mesh again"
                ));
            }
            own.iter_mut().for_each(|influence| influence.weight /= sum);
        }
        Ok(Placement::Joints(Skinned { skin: Rc::clone(self), influences, of_each }))
    }
}
