//! Regions of a face: brows, lids and so on if the names of the markers say so, and otherwise the
//! neighbourhoods of the markers.

use rhytid_core::{Error, HandleId, Result, Rig, VertexId};
use rhytid_geometry::{Topology, geodesic};
use rhytid_kernels::Real;
use rhytid_playback::region_of;

/// Named parts of the vertices; a vertex is in one at most.
#[derive(Debug, Clone, PartialEq)]
pub struct Regions {
    names: Vec<String>,
    of_vertex: Vec<Option<u32>>,
}

impl Regions {
    /// A vertex is in the region of the handle that is nearest along the mesh. A handle is in the region that
    /// its label names (`brow_l`, `LipUpper2`, `mp36`). If its label names none, it has a region of its own,
    /// `near LABEL`.
    pub fn by_handles<T: Real>(rig: &Rig<T>) -> Self {
        let of_handle: Vec<String> = rig
            .handles()
            .labels
            .iter()
            .map(|label| region_of(label).map_or_else(|| format!("near {label}"), str::to_owned))
            .collect();
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
        Self { names, of_vertex }
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
        Ok(Self { names: groups.iter().map(|(name, _)| name.clone()).collect(), of_vertex })
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
        assert!(Regions::by_groups(3, &groups).unwrap_err().to_string().contains("“b” has the vertex 3"));
    }
}
