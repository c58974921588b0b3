//! Findings about the examples, each compared with the neutral.
use super::finding::{Finding, Report, Severity};
use super::parts::Parts;
use super::words::{count, first_few, length};
use crate::align::{Misplaced, misplaced};
use glam::DVec3;
use rhytid_core::{Example, Face, VertexId};
use rhytid_geometry::{Topology, triangulate};

/// The degrees and the metres from which on an example is reported as being in another place.
const MISPLACED: (f64, f64) = (0.5, 5e-4);

/// A pinned vertex that moves by more than this in an example, in metres, was meant to move.
const PINNED_MOVES: f64 = 1e-3;

/// An edge is torn only if it is more than this many times as long as in the neutral.
const TORN: f64 = 4.0;

/// A torn edge is also longer by this part of the mesh's size, because small edges may stretch.
const TORN_BY: f64 = 0.02;

/// A movement within this part of the mesh's size counts as none.
const STILL: f64 = 1e-6;

pub(super) fn examine(face: &Face, diagonal: f64, report: &mut Report) {
    let rest: Vec<DVec3> = face.neutral.positions.iter().copied().map(DVec3::from_array).collect();
    let neutral =
        Neutral { topology: Topology::new(rest.len(), &triangulate(&face.neutral)), rest, diagonal };
    let misplaced = misplaced(face);
    let parts = Parts::new(&face.neutral);
    for example in &face.examples {
        let beside = BesideNeutral::new(example, face, &neutral);
        if beside.is_neutral() {
            report.findings.push(beside.nothing_moves());
            continue;
        }
        report.findings.extend(beside.torn_or_far_away());
        report.findings.extend(parts.exchanged(example, &neutral.rest, diagonal));
        // If the whole head has moved, its pins move without a fault of their own.
        report.findings.extend(match misplaced.iter().find(|found| found.example == example.name) {
            Some(found) => beside.in_another_place(found),
            None => beside.pinned_moves(),
        });
        report.findings.extend(beside.no_handle_moves());
    }
    match &face.prior {
        _ if !face.examples.is_empty() => {}
        Some(prior) if prior.weight.is_none() => report.add(
            Severity::Warning,
            "prior-alone",
            "there is a prior and no example, so nothing says how well the prior fits this face; add one \
             expression scan, or look at the result and set the prior's weight"
                .into(),
        ),
        _ => report.add(
            Severity::Note,
            "no-examples",
            "there are no examples; the rig will have the large scale only, without wrinkles".into(),
        ),
    }
}

fn warning(code: &'static str, message: String) -> Finding {
    Finding::new(Severity::Warning, code, message)
}

/// The neutral, with the data that comparisons of examples need.
struct Neutral {
    rest: Vec<DVec3>,
    topology: Topology,
    /// The diagonal of its bounding box.
    diagonal: f64,
}

/// An example, compared with the neutral.
struct BesideNeutral<'a> {
    example: &'a Example,
    face: &'a Face,
    neutral: &'a Neutral,
    /// The largest movement of a vertex.
    furthest: f64,
    /// The vertex with the largest movement.
    vertex: usize,
}

impl<'a> BesideNeutral<'a> {
    fn new(example: &'a Example, face: &'a Face, neutral: &'a Neutral) -> Self {
        let mut beside = Self { example, face, neutral, furthest: 0.0, vertex: 0 };
        for v in 0..neutral.rest.len() {
            let moved = beside.moved(v);
            if moved > beside.furthest {
                (beside.furthest, beside.vertex) = (moved, v);
            }
        }
        beside
    }

    fn at(&self, v: usize) -> DVec3 {
        DVec3::from_array(self.example.positions[v])
    }

    /// The distance that a vertex moves.
    fn moved(&self, v: usize) -> f64 {
        self.at(v).distance(self.neutral.rest[v])
    }

    fn is_neutral(&self) -> bool {
        self.furthest <= STILL * self.neutral.diagonal
    }

    fn nothing_moves(&self) -> Finding {
        let name = &self.example.name;
        warning(
            "example-is-neutral",
            format!("example {name} is the neutral: no vertex moves; leave it out, or check its mesh"),
        )
    }

    fn torn_or_far_away(&self) -> Option<Finding> {
        let name = &self.example.name;
        let torn = self.torn();
        if !torn.is_empty() {
            let message = format!(
                "example {name} tears {} away from all of their neighbours: {}; its vertices are not in the \
                 neutral's order: export both from the same mesh, without reordering",
                count(torn.len(), "vertex", "vertices"),
                first_few(&torn)
            );
            Some(warning("vertices-in-another-order", message).at(torn.into_iter().map(VertexId::from_index)))
        } else if self.furthest > 0.5 * self.neutral.diagonal {
            Some(warning(
                "example-far-away",
                format!(
                    "example {name} moves vertex {} by {} mesh units, over half of the mesh's size; check that \
                     it has the neutral's unit, place and vertex order",
                    self.vertex,
                    length(self.furthest)
                ),
            )
            .at([VertexId::from_index(self.vertex)]))
        } else {
            None
        }
    }

    /// The vertices whose edges are all much longer than at rest.
    fn torn(&self) -> Vec<usize> {
        let Neutral { rest, topology, diagonal } = self.neutral;
        // A scan in another unit is larger as a whole.
        let positions = self.example.positions.iter().copied().map(DVec3::from_array);
        let larger = (extent(positions) / diagonal).max(1.0);
        let is_torn = |v: &usize| is_torn(*v, topology, |v| larger * rest[v], |v| self.at(v), *diagonal);
        (0..rest.len()).filter(is_torn).collect()
    }

    fn in_another_place(&self, found: &Misplaced) -> Option<Finding> {
        let name = &self.example.name;
        let millimetres = found.moved * self.face.metres_per_unit * 1e3;
        let fate = match self.face.settings.align {
            true => "the solve removes this motion (align = false would keep it)",
            false => "without align = false the solve would remove this motion",
        };
        (found.degrees >= MISPLACED.0 || millimetres >= 1e3 * MISPLACED.1).then(|| {
            warning(
                "example-in-another-place",
                format!(
                    "example {name} is turned by {}° and moved by {} mm as a whole against the neutral; {fate}",
                    length(found.degrees),
                    length(millimetres)
                ),
            )
        })
    }

    fn pinned_moves(&self) -> Option<Finding> {
        let name = &self.example.name;
        let pins = self.face.settings.pins.vertices.iter().map(|&v| (self.moved(v.index()), v));
        let (most, v) = pins.fold((0.0, VertexId(0)), |most, next| if next.0 > most.0 { next } else { most });
        (most * self.face.metres_per_unit > PINNED_MOVES).then(|| {
            warning(
                "pinned-moves",
                format!(
                    "example {name} moves vertex {v}, which is pinned, by {} mesh units; the vertex will not \
                     move: check [pins]",
                    length(most)
                ),
            )
            .at([v])
        })
    }

    fn no_handle_moves(&self) -> Option<Finding> {
        let name = &self.example.name;
        let still = STILL * self.neutral.diagonal;
        self.face.handles.points.iter().all(|point| self.moved(point.nearest_vertex().index()) <= still).then(|| {
            warning(
                "example-at-rest",
                format!(
                    "example {name} moves no handle, so that the rig cannot tell it from the rest pose: its detail is \
                     lost or shows at rest too; leave it out, or check its mesh"
                ),
            )
        })
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
