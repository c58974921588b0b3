//! Regions of a face: left brow, upper lip and so on from where the markers are and what their names say, and
//! otherwise the neighbourhoods of the markers.

use rhytid_core::{Error, HandleId, Result, Rig, VertexId};
use rhytid_geometry::{Topology, geodesic};
use rhytid_kernels::Real;
use rhytid_playback::region_of;
use rhytid_solve::{FacePart, FacePlaces};

/// Named parts of the vertices; a vertex is in one at most.
#[derive(Debug, Clone, PartialEq)]
pub struct Regions {
    names: Vec<String>,
    of_vertex: Vec<Option<u32>>,
    /// Whether a person named them.
    are_given: bool,
}

impl Regions {
    /// A vertex is in the region of the handle that is nearest along the mesh.
    ///
    /// A handle is in the region of its place on the face ([`FacePlaces`]), such as `left cheek`. What its
    /// label names (`brow_l`, `LipUpper2`, `mp36`) counts before its place. If the rig does not look like a
    /// face that looks ahead, a handle is in the region that its label names, and otherwise in one of its
    /// own, `near LABEL`.
    pub fn by_handles<T: Real>(rig: &Rig<T>) -> Self {
        let Some(places) = FacePlaces::of_rig(rig) else { return Self::by_labels(rig) };
        let handles = rig.handles().labels.iter().zip(&rig.handles().rest);
        Self::named(rig, handles.map(|(label, at)| places.name(at.map(T::widen), region_of(label))).collect())
    }

    /// The same by the labels of the handles alone: `brows`, `lips` and so on, and `near LABEL` if a label
    /// names no region.
    pub fn by_labels<T: Real>(rig: &Rig<T>) -> Self {
        let name = |label: &String| region_of(label).map_or_else(|| format!("near {label}"), str::to_owned);
        Self::named(rig, rig.handles().labels.iter().map(name).collect())
    }

    /// The regions of handles with these names, H.
    fn named<T: Real>(rig: &Rig<T>, of_handle: Vec<String>) -> Self {
        let mut names = of_handle.clone();
        names.sort_by_key(|name| (name.starts_with("near "), name.clone()));
        names.dedup();
        let rest: Vec<[f64; 3]> = rig.surface().rest.iter().map(|x| x.map(T::widen)).collect();
        let topology = Topology::new(rest.len(), &rig.surface().joined_triangles());
        let mut cells = geodesic::voronoi_cells(&rest, &topology, &rig.handles().points);
        rig.surface().spread(&mut cells);
        let region =
            |h: HandleId| names.iter().position(|name| *name == of_handle[h.index()]).map(|i| i as u32);
        let of_vertex = cells.into_iter().map(|handle| handle.and_then(region)).collect();
        Self { names, of_vertex, are_given: false }
    }

    /// Groups of the V vertices, as [`rhytid_formats::mesh::read_groups`] returns them. A vertex of several
    /// groups is in the last one.
    ///
    /// # Errors
    /// [`Error::Input`] if a vertex is not below V.
    pub fn by_groups(vertices: usize, groups: &[(String, Vec<u32>)]) -> Result<Self> {
        let mut of_vertex = vec![None; vertices];
        for (i, (name, group)) in groups.iter().enumerate() {
            for &v in group {
                let place = of_vertex.get_mut(v as usize).ok_or_else(|| {
                    Error::out_of_range(format!(
                        "the group “{name}” has the vertex {v}, but there are {vertices}"
                    ))
                })?;
                *place = Some(i as u32);
            }
        }
        Ok(Self { names: groups.iter().map(|(name, _)| name.clone()).collect(), of_vertex, are_given: true })
    }

    /// The same, but each part of the face that is not skin is a region of its own. `parts` has the part of
    /// each of the V vertices. Groups that a person made stay as they are.
    #[must_use]
    pub fn with_parts(mut self, parts: &[FacePart]) -> Self {
        if self.are_given {
            return self;
        }
        for part in FacePart::ALL.into_iter().filter(|part| *part != FacePart::Skin && parts.contains(part)) {
            let place = self.names.iter().position(|name| name == part.name());
            let place = place.unwrap_or_else(|| {
                self.names.push(part.name().to_owned());
                self.names.len() - 1
            });
            for (region, _) in self.of_vertex.iter_mut().zip(parts).filter(|(_, of)| **of == part) {
                *region = Some(place as u32);
            }
        }
        self
    }

    /// Their names.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The index of a vertex's region in [`Regions::names`].
    pub fn of_vertex(&self, v: VertexId) -> Option<usize> {
        self.of_vertex[v.index()].map(|region| region as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_of_the_mesh() {
        let groups = [("a".to_owned(), vec![0, 1]), ("b".to_owned(), vec![1, 3])];
        let regions = Regions::by_groups(5, &groups).unwrap();
        let found: Vec<Option<usize>> = (0..5).map(|v| regions.of_vertex(VertexId(v))).collect();
        assert_eq!(found, [Some(0), Some(1), None, Some(1), None]);
        // What a person named is kept, and other regions lose what is no skin.
        let parts = [FacePart::Skin, FacePart::Eyes, FacePart::Eyes, FacePart::Skin, FacePart::Teeth];
        assert_eq!(regions.clone().with_parts(&parts), regions);
        let apart = Regions { are_given: false, ..regions }.with_parts(&parts);
        let found: Vec<Option<&str>> =
            (0..5).map(|v| apart.of_vertex(VertexId(v)).map(|region| &*apart.names()[region])).collect();
        assert_eq!(found, [Some("a"), Some("eyes"), Some("eyes"), Some("b"), Some("teeth")]);
        assert!(Regions::by_groups(3, &groups).unwrap_err().to_string().contains("“b” has the vertex 3"));
    }
}
