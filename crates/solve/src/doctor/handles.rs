//! Findings about the handles: their places on the mesh, and the ways between them.
use super::finding::{Report, Severity};
use super::words::{count, first_few, length};
use crate::driven::DrivenComponents;
use crate::exposure::exposure;
use crate::head;
use crate::placement::seen_of_head;
use glam::DVec3;
use rhytid_core::{Face, HandleId, Method, StrainEdges, UpAxis, VertexId};
use rhytid_geometry::geodesic::EdgeGraph;
use rhytid_geometry::geodesic::nearest_handles;
use rhytid_geometry::triangulate;
use rhytid_geometry::{Topology, geodesic};
use rhytid_kernels::normals;

/// The number of nearest handles that a handle is compared with.
const NEIGHBORS: usize = 4;

/// A way along the skin goes around something if it is this many times as long as the straight way.
const AROUND: f64 = 3.0;

/// It is also longer by at least this, in metres: a lip is no detour.
const AROUND_BY: f64 = 0.01;

/// A handle is in a hole if its exposure is below this.
const HIDDEN: f64 = 0.05;

/// The handles face along the up axis if the cosine between their mean direction and the axis is beyond this.
const UPWARDS: f64 = 0.8;

pub(super) fn examine(face: &Face, report: &mut Report) {
    let mesh = &face.neutral;
    let triangles = triangulate(mesh);
    let topology = Topology::new(mesh.positions.len(), &triangles);
    stray(face, &triangles, report);
    hidden(face, &triangles, &topology, report);
    detours(face, &topology, report);
    up(face, &triangles, &topology, report);
}

fn named(face: &Face, h: usize) -> String {
    format!("{} ({})", face.handles.labels[h], face.handles.points[h])
}

/// The vertices at or nearest to handles.
fn nearest(face: &Face, handles: &[usize]) -> Vec<VertexId> {
    handles.iter().map(|&h| face.handles.points[h].nearest_vertex()).collect()
}

/// Handles whose nearest neighbours are all on other components. Often such a marker has snapped to an
/// eyeball or a lash.
fn stray(face: &Face, triangles: &[[u32; 3]], report: &mut Report) {
    let points = &face.handles.points;
    let components = DrivenComponents::new(&face.neutral.positions, triangles, points);
    let component = |h: usize| components.component[points[h].nearest_vertex().index()];
    let position = |h: usize| DVec3::from_array(points[h].at(&face.neutral.positions));
    let mut stray = Vec::new();
    for h in 0..points.len() {
        let mut others: Vec<usize> = (0..points.len()).filter(|&o| o != h).collect();
        others.sort_by(|&a, &b| {
            position(a).distance(position(h)).total_cmp(&position(b).distance(position(h)))
        });
        others.truncate(NEIGHBORS);
        if others.len() >= 2 && others.iter().all(|&o| component(o) != component(h)) {
            stray.push(h);
        }
    }
    if !stray.is_empty() {
        let vertices = nearest(face, &stray);
        let stray: Vec<String> = stray.into_iter().map(|h| named(face, h)).collect();
        report.add_at(
            Severity::Warning,
            "handle-on-another-component",
            vertices,
            format!(
                "{} another connected component than all of the nearest handles: {}; check the vertex in the table \
                 of handles",
                count(stray.len(), "handle is on", "handles are each on"),
                first_few(&stray)
            ),
        );
    }
}

/// Handles that cannot be seen from outside: in the mouth, behind the lids.
fn hidden(face: &Face, triangles: &[[u32; 3]], topology: &Topology, report: &mut Report) {
    let is_hidden = |seen: &[f64], h: usize| {
        let v = face.handles.points[h].nearest_vertex().index();
        seen[v] < HIDDEN && !topology.neighbors(v).is_empty()
    };
    let seen = exposure(&face.neutral.positions, triangles, topology);
    let mut hidden: Vec<usize> = (0..face.handles.len()).filter(|&h| is_hidden(&seen, h)).collect();
    if !hidden.is_empty()
        && let Ok(head) = head::find(face, &[], None)
    {
        // A handle may lie under hair.
        let seen = seen_of_head(&face.neutral.positions, triangles, &head);
        hidden.retain(|&h| is_hidden(&seen, h));
    }
    if !hidden.is_empty() {
        let vertices = nearest(face, &hidden);
        let hidden: Vec<String> = hidden.into_iter().map(|h| named(face, h)).collect();
        report.add_at(
            Severity::Warning,
            "handle-inside",
            vertices,
            format!(
                "{} not seen from outside, perhaps in the mouth, in a nostril or behind a lid: {}; choose \
                 the vertex of the skin above",
                count(hidden.len(), "handle is", "handles are"),
                first_few(&hidden)
            ),
        );
    }
}

/// Strain edges whose way along the skin is much longer than the edge.
fn detours(face: &Face, topology: &Topology, report: &mut Report) {
    let rest = &face.neutral.positions;
    let points = &face.handles.points;
    let graph = EdgeGraph::new(rest, topology);
    let at = |h: HandleId| DVec3::from_array(points[h.index()].at(rest));
    let is_detour = |straight: f64, along: f64| {
        along > AROUND * straight && (along - straight) * face.metres_per_unit > AROUND_BY
    };
    let mut detours = Vec::new();
    match &face.settings.strain_edges {
        StrainEdges::Given(edges) => {
            let mut along = vec![0.0; rest.len()];
            for &[a, b] in edges {
                let straight = at(a).distance(at(b));
                let limit = (AROUND * straight).max(straight + AROUND_BY / face.metres_per_unit);
                let [from, to] = [a, b].map(|h| &points[h.index()]);
                graph.distances(from, |_| limit, &mut along);
                if is_detour(straight, graph.between(from, to, &along)) {
                    detours.push([a, b]);
                }
            }
        }
        StrainEdges::Auto => {
            // The way over the place where the two cells touch stands for the shortest one.
            let cells = nearest_handles(&graph, points);
            let of: Vec<Option<HandleId>> = cells.iter().map(|cell| cell.map(|cell| cell.handle)).collect();
            let mut edges = geodesic::touching_cells(topology, &of);
            if matches!(face.settings.method, Method::Learned(_)) {
                geodesic::drop_far_pairs(&graph, &cells, |h| at(h).to_array(), &mut edges);
            }
            let along = geodesic::ways(&graph, &cells, &edges);
            let far = edges
                .iter()
                .zip(&along)
                .filter(|([a, b], along)| is_detour(at(*a).distance(at(*b)), **along));
            detours.extend(far.map(|(edge, _)| *edge));
        }
    }
    if !detours.is_empty() {
        let labels = &face.handles.labels;
        let named: Vec<String> =
            detours.iter().map(|[a, b]| format!("{}–{}", labels[a.index()], labels[b.index()])).collect();
        // The solve makes such edges because cells touch somewhere, as at a corner of the mouth without a
        // marker.
        let severity = match face.settings.strain_edges {
            StrainEdges::Auto => Severity::Note,
            StrainEdges::Given(_) => Severity::Warning,
        };
        let ends: Vec<usize> = detours.iter().flatten().map(|h| h.index()).collect();
        report.add_at(
            severity,
            "strain-edge-around",
            nearest(face, &ends),
            format!(
                "{} handles that are near in space and more than {} times as far along the skin, across an opening or \
                 through the head: {}; check their vertices, or give strain edges without these pairs",
                count(detours.len(), "strain edge joins", "strain edges join"),
                length(AROUND),
                first_few(&named)
            ),
        );
    }
}

/// Finds an up axis along which the face looks.
fn up(face: &Face, triangles: &[[u32; 3]], topology: &Topology, report: &mut Report) {
    let normal = |v: VertexId| {
        let triangles_at = topology.vertex_triangles.at(v.index());
        DVec3::from_array(normals::vertex_normal(&face.neutral.positions, triangles, triangles_at))
    };
    let sum: DVec3 = face.handles.points.iter().map(|point| normal(point.nearest_vertex())).sum();
    let (axis, said, other) = match face.up_axis {
        UpAxis::Y => (DVec3::Y, "y", "z"),
        UpAxis::Z => (DVec3::Z, "z", "y"),
    };
    let count = face.handles.len() as f64;
    // Most handles of a face look ahead. Handles all around a mesh say nothing.
    if count >= 4.0 && sum.length() > 0.5 * count && sum.normalize().dot(axis).abs() > UPWARDS {
        report.add(
            Severity::Warning,
            "up",
            format!(
                "up = \"{said}\", but the face looks along that axis, judging by its handles; up = \
                 \"{other}\" would let it look ahead"
            ),
        );
    }
}
