//! Pins: vertices that stay where they are (section 2). Without pins, a head whose back has no marker would
//! swing with the face.
use glam::DVec3;
use rhytid_core::{Example, Face, Method, SurfacePoint, VertexId};
use rhytid_geometry::geodesic::Cell;

/// A vertex stays if no example moves it by more than this, in metres, beside the example's noise. The bound
/// covers the rounding of files and of scans that were aligned with the neutral.
const STAYS: f64 = 2e-5;

/// Noise moves one vertex of a thousand by more than so many standard deviations.
const MOST_NOISE: f64 = 4.0;

/// An example shows a handle if it moves the handle by more than this, in metres.
const MOVES: f64 = 1e-3;

/// V: whether a vertex is pinned. The pins are the vertices that the face names and, if it asks for this,
/// vertices that no example moves.
///
/// A vertex that no example moves is pinned under two conditions. First, some example moves the handle that
/// is nearest along the mesh, so the examples show the handle's effect on its surroundings. Second, that
/// handle is farther away than `spacing`, the mean rest length of the strain edges, because the markers
/// decide between them. A handle is never a pin.
///
/// `noise` is σ_p of the examples, P in mesh units.
pub(crate) fn pins(face: &Face, noise: &[f64], cells: &[Option<Cell>], spacing: f64) -> Vec<bool> {
    let mut pinned = vec![false; cells.len()];
    let auto = face.settings.pins.auto.unwrap_or(matches!(face.settings.method, Method::Learned(_)));
    let expressions = face.prior.iter().flat_map(|prior| &prior.expressions);
    // Those of the prior are as good as their own neutral.
    let examples = face.examples.iter().zip(noise.iter().copied());
    let shown: Vec<(&Example, f64)> = examples.chain(expressions.map(|e| (e, 0.0))).collect();
    if auto && !shown.is_empty() {
        let moves = |v: usize, most: f64| {
            let rest = DVec3::from_array(face.neutral.positions[v]);
            let moved = |example: &Example| DVec3::from_array(example.positions[v]).distance(rest);
            let most = most / face.metres_per_unit;
            shown.iter().any(|(example, noise)| moved(example) > most + MOST_NOISE * noise)
        };
        let moving: Vec<bool> =
            face.handles.points.iter().map(|point| moves(point.nearest_vertex().index(), MOVES)).collect();
        for (v, (pinned, cell)) in pinned.iter_mut().zip(cells).enumerate() {
            *pinned = cell.is_some_and(|cell| cell.distance > spacing && moving[cell.handle.index()])
                && !moves(v, STAYS);
        }
    }
    face.settings.pins.vertices.iter().for_each(|&v| pinned[v.index()] = true);
    held(face).for_each(|v| pinned[v.index()] = false);
    pinned
}

/// The vertices that handles hold.
fn held(face: &Face) -> impl Iterator<Item = VertexId> {
    face.handles.points.iter().flat_map(SurfacePoint::corners).map(|(vertex, _)| vertex)
}

/// The face with the named pins at rest in its examples. `None` if it names none.
pub(crate) fn with_pins_at_rest(face: &Face) -> Option<Face> {
    if face.settings.pins.vertices.is_empty() {
        return None;
    }
    let mut pinned = face.clone();
    let handles: std::collections::BTreeSet<VertexId> = held(face).collect();
    for example in &mut pinned.examples {
        for v in face.settings.pins.vertices.iter().filter(|v| !handles.contains(v)) {
            example.positions[v.index()] = face.neutral.positions[v.index()];
        }
    }
    Some(pinned)
}
