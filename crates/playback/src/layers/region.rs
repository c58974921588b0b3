//! Regions of edits on a rig, as weights of handles and of vertices.

use crate::fade::of_vertices;
use crate::regions::region_of;
use rhytid_core::{Error, InputErrorKind, Mesh, Result, Rig, VertexId};
use rhytid_formats::edits::{Edits, Region};
use rhytid_formats::mesh;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// Regions, each of which is read once. The caller has checked where their files are.
pub(super) struct Regions<'a> {
    path: &'a Path,
    edits: &'a Edits,
    rig: &'a Rig,
    /// The rig's rest pose.
    rest: &'a Mesh,
    known: HashMap<String, Parts>,
}

/// The weights of a region.
#[derive(Clone)]
enum Parts {
    /// H, from 0 to 1.
    Handles(Vec<f64>),
    /// V, from 0 to 1.
    Vertices(Vec<f32>),
}

impl<'a> Regions<'a> {
    pub(super) fn new(path: &'a Path, edits: &'a Edits, rig: &'a Rig, rest: &'a Mesh) -> Self {
        Self { path, edits, rig, rest, known: HashMap::new() }
    }

    /// H weights; all of them 1 where no region is named. In a region of vertices, a handle has the weight of
    /// its point.
    pub(super) fn handles(&mut self, name: Option<&str>) -> Result<Vec<f64>> {
        let rig = self.rig;
        Ok(match name.map(|name| self.parts(name)).transpose()? {
            None => vec![1.0; rig.handles().len()],
            Some(Parts::Handles(weights)) => weights.clone(),
            Some(Parts::Vertices(weights)) => {
                let of_vertex = |v: VertexId| f64::from(weights[v.index()]);
                rig.handles()
                    .points
                    .iter()
                    .map(|point| point.corners().map(|(v, w)| w * of_vertex(v)).sum())
                    .collect()
            }
        })
    }

    /// V weights; all of them 1 where no region is named. In a region of handles, a vertex has the mean
    /// weight of the handles that drive its wrinkles.
    pub(super) fn vertices(&mut self, name: Option<&str>) -> Result<Vec<f32>> {
        let rig = self.rig;
        Ok(match name.map(|name| self.parts(name)).transpose()? {
            None => vec![1.0; rig.vertices()],
            Some(Parts::Vertices(weights)) => weights.clone(),
            Some(Parts::Handles(weights)) => of_vertices(rig, weights),
        })
    }

    /// H vectors, given by the labels of handles; 0 for the other handles.
    pub(super) fn each(&self, vectors: &BTreeMap<String, [f64; 3]>) -> Result<Vec<[f64; 3]>> {
        if let Some(label) = vectors.keys().find(|label| !self.rig.handles().labels.contains(label)) {
            return Err(self
                .fault(format!("[[offset]] markers has “{label}”, which is no handle of the rig"))
                .of_kind(InputErrorKind::UnknownMarkers { labels: vec![label.clone()] }));
        }
        let of = |label: &String| vectors.get(label).copied().unwrap_or_default();
        Ok(self.rig.handles().labels.iter().map(of).collect())
    }

    fn parts(&mut self, name: &str) -> Result<&Parts> {
        if !self.known.contains_key(name) {
            let parts = match self.edits.regions.get(name) {
                Some(region) => self.read(name, region)?,
                None => Parts::Handles(self.labelled(&[name.to_owned()], "a region")?),
            };
            self.known.insert(name.to_owned(), parts);
        }
        Ok(&self.known[name])
    }

    fn read(&self, name: &str, region: &Region) -> Result<Parts> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        if let (Some(weights), Some(property)) = (&region.weights, &region.property) {
            let weights = folder.join(weights);
            let weights = mesh::read_weights(&weights, property, self.rig.vertices())?;
            return Ok(self.of_points(weights));
        }
        let Some(of) = &region.of else {
            return self.labelled(&region.markers, &format!("[region.{name}] markers")).map(Parts::Handles);
        };
        let of = folder.join(of);
        let groups = mesh::read_groups(self.rest, Path::new("the rig"), &of)?;
        let mut weights = vec![0.0; self.rig.vertices()];
        for wanted in &region.groups {
            let Some((_, vertices)) = groups.iter().find(|(name, _)| name == wanted) else {
                let known: Vec<&str> = groups.iter().map(|(name, _)| name.as_str()).collect();
                return Err(self
                    .fault(format!(
                        "[region.{name}] groups has “{wanted}”, expected some of those in {}: {}",
                        of.display(),
                        known.join(", ")
                    ))
                    .of_kind(InputErrorKind::UnknownName { name: wanted.clone() }));
            };
            vertices.iter().for_each(|&v| weights[v as usize] = 1.0);
        }
        Ok(self.of_points(weights))
    }

    /// V weights in which a point of the surface has the largest weight of its vertices, so that nothing
    /// tears where a region ends at a seam.
    fn of_points(&self, mut weights: Vec<f32>) -> Parts {
        let surface = self.rig.surface();
        for (v, first) in surface.copies() {
            weights[first.index()] = weights[first.index()].max(weights[v.index()]);
        }
        surface.spread(&mut weights);
        Parts::Vertices(weights)
    }

    /// H weights: 1 for handles that a pattern names, else 0.
    ///
    /// A pattern is a label, in which `*` stands for any letters, or the region that labels name.
    fn labelled(&self, patterns: &[String], what: &str) -> Result<Vec<f64>> {
        let labels = &self.rig.handles().labels;
        let mut weights = vec![0.0; labels.len()];
        for pattern in patterns {
            let is_meant = |label: &String| is_like(label, pattern) || region_of(label) == Some(pattern);
            let mut found = false;
            for (label, weight) in labels.iter().zip(&mut weights).filter(|(label, _)| is_meant(label)) {
                found = true;
                *weight = 1.0;
                log::debug!("{what}: “{pattern}” is {label}");
            }
            if !found {
                let mut known: Vec<&str> = self.edits.regions.keys().map(String::as_str).collect();
                known.extend(labels.iter().filter_map(|label| region_of(label)));
                known.sort_unstable();
                known.dedup();
                return Err(self.fault(format!(
                    "{what} is “{pattern}”, which is no handle of the rig and no region; the regions in this \
                     file and in the names of handles are {}",
                    if known.is_empty() { "none".to_owned() } else { known.join(", ") }
                )).of_kind(InputErrorKind::UnknownName { name: pattern.clone() }));
            }
        }
        Ok(weights)
    }

    fn fault(&self, what: String) -> Error {
        Error::input(format!("{}: {what}", self.path.display()))
    }
}

/// Whether a label is like a pattern in which `*` stands for any letters, or none.
fn is_like(label: &str, pattern: &str) -> bool {
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or_default();
    let Some(mut left) = label.strip_prefix(first) else { return false };
    let rest: Vec<&str> = parts.collect();
    let Some((last, between)) = rest.split_last() else { return left.is_empty() };
    for part in between {
        match left.find(part) {
            Some(at) => left = &left[at + part.len()..],
            None => return false,
        }
    }
    left.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::is_like;

    #[test]
    fn stars_stand_for_letters() {
        for (label, pattern, expected) in [
            ("chin", "chin", true),
            ("chin2", "chin", false),
            ("chin2", "chin*", true),
            ("lip_l_3", "lip_*_3", true),
            ("lip_l_33", "lip_*_3", false),
            ("lip_3_3", "*_3", true),
            ("aba", "*b*a", true),
            ("ab", "ab*b", false),
            ("x", "*", true),
        ] {
            assert_eq!(is_like(label, pattern), expected, "{label} {pattern}");
        }
    }
}
