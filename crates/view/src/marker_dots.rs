//! The dots of the markers in the picture, and the lines between them.

use crate::order::Order;
use crate::problems::ProblemKind;
use rhytid_core::HandleId;
use rhytid_render::Mark;

// Linear red, green and blue.
const MARKER: [f32; 3] = [0.02, 0.02, 0.02];
const HELD: [f32; 3] = [1.0, 0.35, 0.0];
const PINNED: [f32; 3] = [0.05, 0.2, 0.9];
const RIM: [f32; 3] = [1.0, 1.0, 1.0];

/// Diameters in points.
const SMALL: f32 = 7.0;
const LARGE: f32 = 11.0;
const RIMS: f32 = 3.0;
/// The width of a line in points.
const LINE: f32 = 2.0;

/// The marks of the markers at `handles`, with widths in points.
///
/// - Selected markers and the one under the pointer are large. Pinned ones are blue.
/// - The more a marker would follow a drag, the more it has the colour of the selected ones. Lines lead from
///   the held markers to their neighbours on strain edges.
/// - Markers with a problem have a rim of the problem's colour. Skin that is stretched too far has a line.
/// - Live markers that are not seen fade into their rims.
pub(crate) fn marks(order: &Order, handles: &[[f32; 3]], edges: &[[HandleId; 2]]) -> Vec<Mark> {
    let mut marks = Vec::with_capacity(2 * handles.len());
    let follows = |handle: usize| order.follows.get(handle).copied().unwrap_or(0.0);
    let is_held = |handle: usize| order.selected.contains(&handle) || order.under == Some(handle);
    for edge in edges {
        let [a, b] = edge.map(HandleId::index);
        if !order.follows.is_empty() && (is_held(a) != is_held(b)) {
            marks.push(Mark { ends: [handles[a], handles[b]], colour: HELD, width: 0.5 * LINE });
        }
    }
    for problem in &order.problems {
        if let (ProblemKind::Strain, &[a, b]) = (problem.kind, &problem.handles[..]) {
            let (ends, colour) = ([handles[a], handles[b]], problem.kind.linear());
            marks.push(Mark { ends, colour, width: 1.5 * LINE });
        }
    }
    for (handle, &at) in handles.iter().enumerate() {
        let is_selected = order.selected.contains(&handle);
        let width = if is_held(handle) { LARGE } else { SMALL + 2.0 * follows(handle) };
        let own = if order.pinned[handle] { PINNED } else { MARKER };
        let colour = if is_selected { HELD } else { mixed(own, HELD, follows(handle)) };
        let problem = order.problems.iter().find(|problem| problem.handles.contains(&handle));
        let (rim, rims) = problem.map_or((RIM, RIMS), |problem| (problem.kind.linear(), 2.0 * RIMS));
        marks.push(Mark::dot(at, rim, width + rims));
        let faded = 1.0 - order.confidence.get(handle).copied().unwrap_or(1.0);
        marks.push(Mark::dot(at, mixed(colour, RIM, faded), width));
    }
    marks
}

/// From `a` for 0 to `b` for 1.
fn mixed(a: [f32; 3], b: [f32; 3], part: f32) -> [f32; 3] {
    std::array::from_fn(|c| a[c] + part * (b[c] - a[c]))
}
