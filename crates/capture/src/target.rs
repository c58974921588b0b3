//! The target of a clean-up: a rig's handles and what is known about them.
use glam::DVec3;
use rhytid_core::{Face, HandleId, Rig};

/// How much larger a strain may be than in any example: with examples, and without any.
const BEYOND: [f64; 2] = [1.0, 2.0];

/// The handles of the rig that a take is cleaned for.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// H labels.
    pub labels: Vec<String>,
    /// H positions on the rest pose.
    pub rest: Vec<DVec3>,
    /// Metres in one mesh unit.
    pub metres_per_unit: f64,
    /// How far skin stretches, where that is known.
    pub strains: Vec<StrainLimit>,
    /// The examples: their names, and H displacements of the handles in each.
    pub examples: Vec<(String, Vec<DVec3>)>,
}

impl Target {
    /// The handles of a rig.
    pub fn from_rig(rig: &Rig) -> Self {
        let rest: Vec<DVec3> =
            rig.handles().rest.iter().map(|x| DVec3::from_array(x.map(f64::from))).collect();
        let strains = strain_limits(rig);
        let (labels, metres_per_unit) = (rig.handles().labels.clone(), rig.surface().metres_per_unit);
        let shown = rig.examples().handles.rows();
        let moved = |shown: &[[f32; 3]]| {
            shown.iter().zip(&rest).map(|(p, rest)| DVec3::from_array(p.map(f64::from)) - *rest).collect()
        };
        let examples = rig.examples().names.iter().cloned().zip(shown.map(moved)).collect();
        Self { labels, rest, metres_per_unit, strains, examples }
    }

    /// The handles of a face that is not solved yet: where they are at rest, and nothing else.
    pub fn from_neutral(face: &Face) -> Self {
        let rest = face.handles.at(&face.neutral.positions).into_iter().map(DVec3::from_array);
        Self {
            labels: face.handles.labels.clone(),
            rest: rest.collect(),
            metres_per_unit: face.metres_per_unit,
            strains: Vec::new(),
            examples: Vec::new(),
        }
    }

    /// Millimetres in one mesh unit.
    pub(crate) fn millimetres(&self) -> f64 {
        1e3 * self.metres_per_unit
    }
}

/// How far the skin between two handles can be believed to stretch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrainLimit {
    /// The two handles.
    pub handles: [usize; 2],
    /// Their greatest strain, 1 for twice the length at rest.
    pub most: f64,
}

/// The limits of a rig's strain edges: the examples' largest strain plus 100 %, or 200 % without examples.
fn strain_limits(rig: &Rig) -> Vec<StrainLimit> {
    let shown =
        |e: usize| rig.fine_scale().pose_features.rows().fold(0.0_f32, |most, center| most.max(center[e]));
    let beyond = if rig.examples().names.is_empty() { BEYOND[1] } else { BEYOND[0] };
    let limit = |(e, pair): (usize, &[HandleId; 2])| StrainLimit {
        handles: pair.map(HandleId::index),
        most: f64::from(shown(e)) + beyond,
    };
    rig.handles().strain_edges.iter().enumerate().map(limit).collect()
}
