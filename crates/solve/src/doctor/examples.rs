//! Findings of the examples: each beside the neutral.
use super::finding::{Report, Severity};
use super::words::{count, first_few, length};
use crate::align::misplaced;
use glam::DVec3;
use rhytid_core::Face;
use rhytid_core::VertexId;
use rhytid_geometry::Topology;
use rhytid_geometry::triangulate;

/// An example is said to be in another place from so many degrees or metres on.
const MISPLACED: (f64, f64) = (0.5, 5e-4);

/// What is pinned and moves by more in an example, in metres, was meant to move.
const PINNED_MOVES: f64 = 1e-3;

/// Edges that are so many times as long as in the neutral tear no skin.
const TORN: f64 = 4.0;

/// And by at least this part of the mesh's size: small edges stretch.
const TORN_BY: f64 = 0.02;

pub(super) fn examine(face: &Face, diagonal: f64, report: &mut Report) {
    let rest: Vec<DVec3> = face.neutral.positions.iter().copied().map(DVec3::from_array).collect();
    let topology = Topology::new(rest.len(), &triangulate(&face.neutral));
    let handles = &face.handles.vertices;
    let mut warn = |code: &'static str, message: String| report.add(Severity::Warning, code, message);
    let misplaced = misplaced(face);
    for example in &face.examples {
        let name = &example.name;
        let at = |v: usize| DVec3::from_array(example.positions[v]);
        let moved = |v: usize| at(v).distance(rest[v]);
        let (furthest, vertex) = (0..rest.len())
            .map(|v| (moved(v), v))
            .fold((0.0, 0), |most, next| if next.0 > most.0 { next } else { most });
        if furthest <= 1e-6 * diagonal {
            warn(
                "example-is-neutral",
                format!("example {name} is the neutral: no vertex moves; leave it out, or check its mesh"),
            );
            continue;
        }
        // A scan in another unit is larger altogether.
        let larger = (extent(example.positions.iter().copied().map(DVec3::from_array)) / diagonal).max(1.0);
        let is_torn = |v: &usize| is_torn(*v, &topology, |v| larger * rest[v], at, diagonal);
        let torn: Vec<usize> = (0..rest.len()).filter(is_torn).collect();
        if !torn.is_empty() {
            warn(
                "vertices-in-another-order",
                format!(
                    "example {name} tears {} away from all of their neighbours: {}; its vertices are not in the \
                     neutral's order: export both from the same mesh, without reordering",
                    count(torn.len(), "vertex", "vertices"),
                    first_few(&torn)
                ),
            );
        } else if furthest > 0.5 * diagonal {
            warn(
                "example-far-away",
                format!(
                    "example {name} moves vertex {vertex} by {} mesh units, over half of the mesh's size; check that \
                     it has the neutral's unit, place and vertex order",
                    length(furthest)
                ),
            );
        }
        if let Some(found) = misplaced.iter().find(|found| found.example == *name) {
            let millimetres = found.moved * face.metres_per_unit * 1e3;
            if found.degrees >= MISPLACED.0 || millimetres >= 1e3 * MISPLACED.1 {
                let fate = match face.settings.align {
                    true => "the solve takes that out (align = false would keep it)",
                    false => "without align = false the solve would take that out",
                };
                warn(
                    "example-in-another-place",
                    format!(
                        "example {name} is turned by {}° and moved by {} mm as a whole against the neutral; {fate}",
                        length(found.degrees),
                        length(millimetres)
                    ),
                );
            }
        } else {
            let pins = face.settings.pins.vertices.iter().map(|&v| (moved(v.index()), v));
            let (most, v) =
                pins.fold((0.0, VertexId(0)), |most, next| if next.0 > most.0 { next } else { most });
            if most * face.metres_per_unit > PINNED_MOVES {
                warn(
                    "pinned-moves",
                    format!(
                        "example {name} moves vertex {v}, which is pinned, by {} mesh units; it will stay: check [pins]",
                        length(most)
                    ),
                );
            }
        }
        if handles.iter().all(|&v| moved(v.index()) <= 1e-6 * diagonal) {
            warn(
                "example-at-rest",
                format!(
                    "example {name} moves no handle, so that the rig cannot tell it from the rest pose: its detail is \
                     lost or shows at rest too; leave it out, or check its mesh"
                ),
            );
        }
    }
    if face.examples.is_empty() {
        report.add(
            Severity::Note,
            "no-examples",
            "there are no examples; the rig will have the large scale only, without wrinkles".into(),
        );
    }
}

/// The length of the bounding box's diagonal.
fn extent(positions: impl Iterator<Item = DVec3>) -> f64 {
    let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = positions.fold(nothing, |(low, high), x| (low.min(x), high.max(x)));
    low.distance(high)
}

/// Whether all edges of a vertex are much longer than at rest.
fn is_torn(
    v: usize,
    topology: &Topology,
    rest: impl Fn(usize) -> DVec3,
    at: impl Fn(usize) -> DVec3,
    diagonal: f64,
) -> bool {
    let neighbors = topology.neighbors(v);
    let is_torn = |w: usize| {
        let (before, now) = (rest(v).distance(rest(w)), at(v).distance(at(w)));
        now > TORN * before && now > before + TORN_BY * diagonal
    };
    !neighbors.is_empty() && neighbors.iter().all(|&w| is_torn(w as usize))
}
