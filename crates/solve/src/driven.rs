//! The connected components that the handles drive (section 2).
use glam::DVec3;
use rhytid_core::{Surface, SurfacePoint, VertexId};
use rhytid_geometry::components;
use rhytid_geometry::laplacian::is_degenerate;
use rhytid_kernels::Real;

/// The connected components of a mesh. Triangles without area connect nothing, as in the Laplacian.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DrivenComponents {
    /// The component of each vertex, counted from 0 in the order of their lowest vertices.
    pub component: Vec<u32>,
    /// Whether each vertex is in a component with a handle.
    pub driven: Vec<bool>,
}

impl DrivenComponents {
    /// For V positions, triangles and handles, all in range.
    pub fn new(rest: &[[f64; 3]], triangles: &[[u32; 3]], handles: &[SurfacePoint]) -> Self {
        let with_area =
            triangles.iter().filter(|t| !is_degenerate(t.map(|v| DVec3::from_array(rest[v as usize]))));
        let (component, count) = components(rest.len(), with_area);
        let mut has_handle = vec![false; count];
        let held = handles.iter().flat_map(SurfacePoint::corners);
        held.for_each(|(v, _)| has_handle[component[v.index()] as usize] = true);
        let driven = component.iter().map(|&c| has_handle[c as usize]).collect();
        Self { component, driven }
    }

    /// For the surface of a rig and handles on it. All vertices of a point are in its component. A number may
    /// belong to no component.
    pub fn of_surface<T: Real>(surface: &Surface<T>, handles: &[SurfacePoint]) -> Self {
        let rest: Vec<[f64; 3]> = surface.rest.iter().map(|x| x.map(T::widen)).collect();
        let first = |v: VertexId| VertexId(surface.first(v.0));
        let handles: Vec<SurfacePoint> = handles.iter().map(|point| point.renamed(first)).collect();
        let mut components = Self::new(&rest, &surface.joined_triangles(), &handles);
        surface.spread(&mut components.component);
        surface.spread(&mut components.driven);
        components
    }

    /// The vertices of each component that has no handle, ascending, by the component's number. Those of the
    /// others are left out.
    pub(crate) fn without_handle(&self) -> Vec<Vec<VertexId>> {
        let count = self.component.iter().max().map_or(0, |last| *last as usize + 1);
        let mut members = vec![Vec::new(); count];
        for (v, &component) in self.component.iter().enumerate().filter(|(v, _)| !self.driven[*v]) {
            members[component as usize].push(VertexId::from_index(v));
        }
        members
    }
}
