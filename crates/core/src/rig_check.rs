//! The check of a rig, which everything passes that is uploaded.
use crate::{Error, Learned, Result, Rig};
use std::collections::HashSet;
use std::ops::Deref;

/// A rig that has passed [`Rig::check`]: what kernels, which do not look, may be given.
#[derive(Debug, Clone, Copy)]
pub struct CheckedRig<'a>(&'a Rig);

impl Deref for CheckedRig<'_> {
    type Target = Rig;

    fn deref(&self) -> &Rig {
        self.0
    }
}

impl Rig {
    /// The proof that the rig passes [`Rig::check`].
    ///
    /// # Errors
    /// As [`Rig::check`].
    pub fn checked(&self) -> Result<CheckedRig<'_>> {
        self.check()?;
        Ok(CheckedRig(self))
    }

    /// Whether every array has the shape, and every number the range, that [`Rig`] promises. What passes can be
    /// evaluated by any backend without a further look.
    ///
    /// # Errors
    /// [`Error::Input`] with the first array and element that does not fit.
    pub fn check(&self) -> Result<()> {
        let (v, h, f, n) = (self.vertices(), self.handles.len(), self.strain_edges.len(), self.centers());
        let fail = |message: String| Err(Error::rig_damaged(message));
        if v == 0 || h == 0 || self.faces.is_empty() {
            return fail(format!(
                "a rig has vertices, handles and faces; found {v}, {h} and {}",
                self.faces.len()
            ));
        }
        if u32::try_from(v).is_err() || u32::try_from(f).is_err() {
            return fail(format!("{v} vertices and {f} strain edges are more than 32 bits can count"));
        }
        if !(self.metres_per_unit.is_finite() && self.metres_per_unit > 0.0) {
            return fail(format!("metres_per_unit is {}, expected a number above 0", self.metres_per_unit));
        }
        if !(self.bending_length.is_finite() && self.bending_length >= 0.0) {
            return fail(format!("bending_length is {}, expected 0 or more", self.bending_length));
        }
        // β is infinite where more than K edges tie.
        if self.beta.is_nan() || self.beta < 0.0 {
            return fail(format!("beta is {}, expected 0 or more", self.beta));
        }
        let k = self.influences();
        // The names are those of the rig file's tensors: there, the tangent neighbours are called by an older one.
        for (name, found, expected) in [
            ("labels", self.labels.len(), h),
            ("basis", self.basis.len(), v.saturating_mul(h)),
            ("influence_edges", self.influence_edges.len(), v * k),
            ("influence_weights", self.influence_weights.len(), v * k),
            ("frame_neighbors", self.tangent_neighbors.len(), v),
            ("pose_features", self.pose_features.len(), n.saturating_mul(f)),
            ("rbf_weights", self.rbf_weights.len(), v.saturating_mul(n)),
            ("example_handles", self.example_handles.len(), (n - 1).saturating_mul(h)),
        ] {
            if found != expected {
                return fail(format!("{name} has {found} elements, expected {expected}"));
            }
        }
        below("handles", &self.handles, v)?;
        below("triangles", self.triangles.as_flattened(), v)?;
        self.check_faces()?;
        below("strain_edges", self.strain_edges.as_flattened(), h)?;
        below("influence_edges", &self.influence_edges, f)?;
        for (v, edges) in self.influence_edges.chunks(k.max(1)).enumerate() {
            if let Some([a, b]) = edges.array_windows().find(|[a, b]| a >= b) {
                return fail(format!(
                    "influence_edges of vertex {v} has {b} after {a}, expected ascending indices"
                ));
            }
        }
        below("frame_neighbors", &self.tangent_neighbors, v)?;
        finite("rest", self.rest.as_flattened())?;
        finite("basis", &self.basis)?;
        finite("influence_weights", &self.influence_weights)?;
        finite("pose_features", &self.pose_features)?;
        finite("rbf_weights", self.rbf_weights.as_flattened())?;
        finite("example_handles", self.example_handles.as_flattened())?;
        self.learned.as_ref().map_or(Ok(()), |learned| self.check_learned(learned))?;
        if let Some(i) = self.influence_weights.iter().position(|a| !(0.0..=1.0).contains(a)) {
            return fail(format!("influence_weights[{i}] is {}, expected 0 to 1", self.influence_weights[i]));
        }
        let mut seen = HashSet::new();
        if let Some(label) = self.labels.iter().find(|l| !seen.insert(l.as_str())) {
            return fail(format!("labels has {label} twice, expected distinct labels"));
        }
        let mut seen = HashSet::new();
        if let Some(vertex) = self.handles.iter().find(|v| !seen.insert(**v)) {
            return fail(format!("handles has vertex {vertex} twice, expected distinct vertices"));
        }
        let at = |handle: u32| self.rest[self.handles[handle as usize] as usize];
        if let Some(i) = self.strain_edges.iter().position(|&[a, b]| at(a) == at(b)) {
            return fail(format!("strain_edges[{i}] has no length at rest"));
        }
        Ok(())
    }

    fn check_learned(&self, learned: &Learned) -> Result<()> {
        let fail = |message: String| Err(Error::rig_damaged(message));
        let (v, p, a) = (self.vertices(), self.example_names.len(), learned.anchors_per_vertex());
        let c = if learned.share > 0.0 { v.saturating_mul(p) } else { 0 };
        for (name, found, expected) in [
            ("variances", learned.variances.len(), v),
            ("anchors", learned.anchors.len(), v * a),
            ("anchor_weights", learned.anchor_weights.len(), v * a),
            ("feature_gains", learned.feature_gains.len(), v * (self.influences() + a)),
            ("example_weights", learned.example_weights.len(), c),
        ] {
            if found != expected {
                return fail(format!("{name} has {found} elements, expected {expected}"));
            }
        }
        for (name, number, is_right) in [
            ("share", learned.share, (0.0..=1.0).contains(&learned.share)),
            ("ridge", learned.ridge, learned.ridge > 0.0),
            ("fold_ridge", learned.fold_ridge, learned.fold_ridge > 0.0),
            ("marker_noise", learned.marker_noise, learned.marker_noise >= 0.0),
        ] {
            if !(number.is_finite() && is_right) {
                return fail(format!("{name} is {number}, which is out of its range"));
            }
        }
        if learned.reach.is_nan() || learned.reach < 1.0 {
            return fail(format!("reach is {}, which is out of its range", learned.reach));
        }
        below("anchors", &learned.anchors, self.handles.len())?;
        finite("anchor_weights", &learned.anchor_weights)?;
        if let Some(i) = learned.anchor_weights.iter().position(|w| !(0.0..=1.0).contains(w)) {
            return fail(format!("anchor_weights[{i}] is {}, expected 0 to 1", learned.anchor_weights[i]));
        }
        finite("feature_gains", &learned.feature_gains)?;
        finite("example_weights", learned.example_weights.as_flattened())?;
        finite("variances", &learned.variances)
    }

    fn check_faces(&self) -> Result<()> {
        let fail = |message: String| Err(Error::rig_damaged(message));
        let corners = self.faces.indices.len();
        let counted: u64 = self.faces.counts.iter().map(|&n| u64::from(n)).sum();
        if let Some(f) = self.faces.counts.iter().position(|&n| n < 3) {
            return fail(format!("face_counts[{f}] is {}, expected at least 3", self.faces.counts[f]));
        }
        if counted != corners as u64 {
            return fail(format!("face_indices has {corners} elements, expected {counted}"));
        }
        below("face_indices", &self.faces.indices, self.vertices())?;
        if self.faces.triangle_corners(&self.triangles).is_none() {
            return fail("triangles is not made from the faces".into());
        }
        if let Some(fault) = self.materials.as_ref().and_then(|materials| materials.fault(&self.faces)) {
            return fail(fault);
        }
        let Some(uvs) = &self.uvs else { return Ok(()) };
        finite("uvs", uvs.values.as_flattened())?;
        match &uvs.corners {
            None if uvs.values.len() != self.vertices() => {
                fail(format!("uvs has {} elements, expected {}", uvs.values.len(), self.vertices()))
            }
            Some(indices) if indices.len() != corners => {
                fail(format!("uv_indices has {} elements, expected {corners}", indices.len()))
            }
            Some(indices) => below("uv_indices", indices, uvs.values.len()),
            None => Ok(()),
        }
    }
}

fn below(name: &str, indices: &[u32], end: usize) -> Result<()> {
    match indices.iter().position(|&i| i as usize >= end) {
        Some(at) => {
            Err(Error::rig_damaged(format!("{name}[{at}] is {}, expected an index below {end}", indices[at])))
        }
        None => Ok(()),
    }
}

fn finite(name: &str, numbers: &[f32]) -> Result<()> {
    match numbers.iter().position(|x| !x.is_finite()) {
        Some(at) => {
            Err(Error::rig_damaged(format!("{name}[{at}] is {}, expected a finite number", numbers[at])))
        }
        None => Ok(()),
    }
}
