//! Findings that make a solve impossible.
use super::finding::{Finding, Report, Severity};
use super::points;
use super::space;
use super::words::{count, first_few, length};
use glam::DVec3;
use rhytid_core::{Example, Face, HandleId, LearnedSettings, Method, StrainEdges, VertexId};
use rhytid_geometry::laplacian::is_degenerate;
use rhytid_geometry::triangulate;
use std::collections::HashMap;

/// The largest rounding of float32, as a part of a number.
pub(super) const FLOAT32: f64 = f32::EPSILON as f64 / 2.0;
/// The largest rounding of vertices that is accepted, as a part of the mesh's size.
const BLURRED: f64 = 0.01;
/// The bending lengths for which the system can be solved, in sizes of the mesh. Outside this range, it is a
/// pure membrane or a pure plate.
const BENDING_LENGTHS: std::ops::RangeInclusive<f64> = 1e-6..=1e4;

/// One check for something that makes a solve impossible.
enum Check {
    /// Later checks rely on this one, so its finding ends the examination.
    Needed(fn(&Face) -> Option<Finding>),
    /// Finds at most one thing.
    One(fn(&Face) -> Option<Finding>),
    /// Finds faults of each handle, example or setting.
    Each(fn(&Face) -> Vec<Finding>),
}

/// All checks, in the order of the report.
const CHECKS: [Check; 23] = [
    Check::Needed(no_faces),
    Check::Needed(neutral_not_finite),
    Check::Needed(faulty_faces),
    Check::One(faulty_uvs),
    Check::One(no_area),
    Check::One(no_handles),
    Check::Needed(labels_without_points),
    Check::Each(faulty_handles),
    Check::One(points::not_on_a_face),
    Check::One(points::not_met_together),
    Check::One(points::turning),
    Check::Each(faulty_examples),
    Check::Each(space::examples_in_another_space),
    Check::One(pins_out_of_range),
    Check::One(bending_length_out_of_range),
    Check::One(far_from_origin),
    Check::One(no_influences),
    Check::Each(learned_numbers_out_of_range),
    Check::One(rotations_of_the_basis),
    Check::One(unusable_prior),
    Check::One(unit_out_of_range),
    Check::Needed(strain_edges_out_of_range),
    Check::One(strain_edges_without_length),
];

pub(super) fn examine(face: &Face, report: &mut Report) {
    for check in CHECKS {
        match check {
            Check::Needed(check) => {
                if let Some(found) = check(face) {
                    report.findings.push(found);
                    return;
                }
            }
            Check::One(check) => report.findings.extend(check(face)),
            Check::Each(check) => report.findings.extend(check(face)),
        }
    }
}

pub(super) fn error(code: &'static str, message: String) -> Finding {
    Finding::new(Severity::Error, code, message)
}

fn no_faces(face: &Face) -> Option<Finding> {
    let mesh = &face.neutral;
    (mesh.faces.is_empty() || mesh.positions.is_empty()).then(|| {
        error("no-faces", "the neutral mesh has no faces; export it as a surface, not as points".into())
    })
}

fn neutral_not_finite(face: &Face) -> Option<Finding> {
    let positions = &face.neutral.positions;
    let v = not_finite(positions)?;
    Some(
        error(
            "not-finite",
            format!("vertex {v} of the neutral mesh is at {:?}, expected finite numbers", positions[v]),
        )
        .at([VertexId::from_index(v)]),
    )
}

fn faulty_faces(face: &Face) -> Option<Finding> {
    let mesh = &face.neutral;
    let fault = mesh.faces.fault(mesh.positions.len())?;
    Some(error("faces", format!("the neutral mesh: {fault}")))
}

/// Texture coordinates that the rig could not carry.
fn faulty_uvs(face: &Face) -> Option<Finding> {
    let mesh = &face.neutral;
    let fault = mesh.uvs.as_ref()?.fault(mesh.positions.len(), &mesh.faces)?;
    Some(error("uvs", format!("the neutral mesh: {fault}")))
}

fn no_area(face: &Face) -> Option<Finding> {
    let mesh = &face.neutral;
    let position = |v: u32| DVec3::from_array(mesh.positions[v as usize]);
    triangulate(mesh).iter().all(|t| is_degenerate(t.map(position))).then(|| {
        error("no-area", "no triangle of the neutral mesh has an area; check its coordinates".into())
    })
}

fn no_handles(face: &Face) -> Option<Finding> {
    face.handles
        .is_empty()
        .then(|| error("no-handles", "the face has no handles; list at least one label and vertex".into()))
}

fn labels_without_points(face: &Face) -> Option<Finding> {
    let (labels, points) = (face.handles.labels.len(), face.handles.len());
    (labels != points).then(|| {
        error(
            "handles",
            format!("the handles have {labels} labels and {points} points; each needs one of both"),
        )
    })
}

/// Handles without a vertex of the mesh, and labels and vertices that are listed twice.
fn faulty_handles(face: &Face) -> Vec<Finding> {
    let vertices = face.neutral.positions.len();
    let mut found = Vec::new();
    let mut by_label = HashMap::new();
    let mut by_vertex = HashMap::new();
    for (label, &point) in face.handles.labels.iter().zip(&face.handles.points) {
        if let Some(v) = point.triangle().into_iter().find(|v| v.index() >= vertices) {
            found.push(error(
                "handle-out-of-range",
                format!(
                    "handle {label} is at vertex {v}, expected 0 to {}; vertices count from 0",
                    vertices - 1
                ),
            ));
        }
        if by_label.insert(label, point).is_some() {
            found.push(error(
                "duplicate-handle",
                format!("handle {label} is listed twice; each label is one marker"),
            ));
        }
        // A label that is listed twice with the same vertex is reported above.
        if let Some(v) = point.vertex()
            && let Some(other) = by_vertex.insert(v, label)
            && other != label
        {
            found.push(
                error(
                    "duplicate-handle",
                    format!(
                        "handles {other} and {label} are both vertex {v}; each needs a vertex of its own"
                    ),
                )
                .at([v]),
            );
        }
    }
    found
}

/// Examples of another mesh than the neutral's, and examples that are not finite. So too the expressions of a
/// prior.
fn faulty_examples(face: &Face) -> Vec<Finding> {
    let vertices = face.neutral.positions.len();
    let mut found = Vec::new();
    let expressions = face.prior.iter().flat_map(|prior| &prior.expressions);
    let meshes = face.examples.iter().map(|example| ("example", example));
    for (what, Example { name, positions, noise, .. }) in
        meshes.chain(expressions.map(|e| ("the prior's", e)))
    {
        if positions.len() != vertices {
            found.push(error(
                "example",
                format!(
                    "{what} {name} has {} vertices where the neutral mesh has {vertices}; every mesh needs the \
                     same vertices in the same order",
                    positions.len()
                ),
            ));
        } else if let Some(v) = not_finite(positions) {
            found.push(
                error(
                    "not-finite",
                    format!("vertex {v} of {what} {name} is at {:?}, expected finite numbers", positions[v]),
                )
                .at([VertexId::from_index(v)]),
            );
        }
        let is_right = |noise: &f64| (0.0..=LearnedSettings::LARGEST_NOISE).contains(noise);
        if let Some(noise) = noise.filter(|noise| !is_right(noise)) {
            found.push(error(
                "settings",
                format!("the noise of {what} {name} is {noise}, expected millimetres, from 0 to 1000"),
            ));
        }
    }
    found
}

fn pins_out_of_range(face: &Face) -> Option<Finding> {
    let vertices = face.neutral.positions.len();
    let v = face.settings.pins.vertices.iter().find(|v| v.index() >= vertices)?;
    Some(error(
        "pins",
        format!("vertex {v} is pinned, expected 0 to {}; vertices count from 0", vertices - 1),
    ))
}

fn bending_length_out_of_range(face: &Face) -> Option<Finding> {
    let [low, high] = bounds(face);
    let size = high.distance(low);
    let bends = |length: f64| is_positive(length) && BENDING_LENGTHS.contains(&(length / size));
    let found = face.settings.bending_length.filter(|l| !bends(*l))?;
    let [least, most] = [BENDING_LENGTHS.start(), BENDING_LENGTHS.end()].map(|ratio| length(ratio * size));
    Some(error(
        "settings",
        format!("bending_length is {found:?}, expected a length from {least} to {most} in mesh units"),
    ))
}

/// A mesh too far from the origin for float32, in which the rig and its animations have the vertices.
fn far_from_origin(face: &Face) -> Option<Finding> {
    let [low, high] = bounds(face);
    let size = high.distance(low);
    let farthest = low.abs().max(high.abs()).max_element();
    (farthest * FLOAT32 > BLURRED * size).then(|| {
        error(
            "far-from-origin",
            format!(
                "the neutral mesh is {} mesh units from the origin and {} across: float32 cannot tell its \
                 vertices apart; move all meshes to the origin, by the same offset",
                length(farthest),
                length(size)
            ),
        )
    })
}

fn no_influences(face: &Face) -> Option<Finding> {
    (face.settings.max_influences == 0)
        .then(|| error("settings", "max_influences is 0, expected at least 1".into()))
}

fn learned_numbers_out_of_range(face: &Face) -> Vec<Finding> {
    let Method::Learned(learned) = face.settings.method else { return Vec::new() };
    let LearnedSettings { share, ridge, wrinkle_ridge, marker_noise, reach, fade: _, wrinkle_strains: _ } =
        learned;
    let mut found = Vec::new();
    let is_ridge = |ridge| ridge > 0.0 && ridge <= LearnedSettings::LARGEST_RIDGE;
    for (name, number, is_right, expected) in [
        ("share", share, share.is_none_or(|s| (0.0..=1.0).contains(&s)), "0 to 1"),
        ("ridge", ridge, ridge.is_none_or(is_ridge), "a number above 0, at most 1000000"),
        ("wrinkle_ridge", Some(wrinkle_ridge), is_ridge(wrinkle_ridge), "a number above 0, at most 1000000"),
        (
            "marker_noise",
            Some(marker_noise),
            (0.0..=LearnedSettings::LARGEST_NOISE).contains(&marker_noise),
            "millimetres, from 0 to 1000",
        ),
        ("reach", reach, reach.is_none_or(|reach| reach >= 1.0), "a number from 1, inf for no bound"),
    ] {
        if let Some(number) = number.filter(|_| !is_right) {
            found.push(error("settings", format!("{name} is {number}, expected {expected}")));
        }
    }
    found
}

fn rotations_of_the_basis(face: &Face) -> Option<Finding> {
    let Method::Learned(LearnedSettings { share, .. }) = face.settings.method else { return None };
    let is_in_the_basis = share.is_some_and(|share| share < 1.0);
    (face.settings.rotations && is_in_the_basis).then(|| {
        error(
            "settings",
            "rotations go with share = 1 alone: with a smaller share, a part of the linear band is in the \
             basis, which also says how far vertices turn with the handles; leave share out, or do without \
             rotations"
                .into(),
        )
    })
}

/// A prior is in the basis, which only the learned method learns.
fn unusable_prior(face: &Face) -> Option<Finding> {
    let prior = face.prior.as_ref()?;
    let wrong = |message: String| Some(error("prior", message));
    match (face.settings.method, prior.weight) {
        (_, Some(weight)) if !(0.0..=1.0).contains(&weight) => {
            wrong(format!("the prior's weight is {weight}, expected 0 to 1"))
        }
        (Method::Chapter, _) => wrong(
            "the chapter's method learns nothing from a prior; choose method = \"learned\", or leave the \
             prior out"
                .into(),
        ),
        (Method::Learned(_), _) if face.settings.rotations => wrong(
            "rotations do not go with a prior: it is in the basis, which also says how far vertices turn with \
             the handles; leave one of them out"
                .into(),
        ),
        _ => None,
    }
}

fn unit_out_of_range(face: &Face) -> Option<Finding> {
    let metres = face.metres_per_unit;
    (!is_positive(metres))
        .then(|| error("settings", format!("a unit is {metres} metres, expected a number above 0")))
}

fn strain_edges_out_of_range(face: &Face) -> Option<Finding> {
    let StrainEdges::Given(edges) = &face.settings.strain_edges else { return None };
    let h = face.handles.len();
    let i = edges.iter().position(|e| e.iter().any(|&end| end.index() >= h))?;
    let [a, b] = edges[i];
    Some(error(
        "strain-edges",
        format!("strain edge {i} joins the handles {a} and {b}, expected two of the {h}, counted from 0"),
    ))
}

fn strain_edges_without_length(face: &Face) -> Option<Finding> {
    let StrainEdges::Given(edges) = &face.settings.strain_edges else { return None };
    let handles = &face.handles;
    let at = |h: HandleId| {
        let point = handles.points[h.index()];
        let exists = point.triangle().iter().all(|v| v.index() < face.neutral.positions.len());
        exists.then(|| point.at(&face.neutral.positions))
    };
    let flat: Vec<String> = edges
        .iter()
        .filter(|&&[a, b]| at(a).is_some() && at(a) == at(b))
        .map(|&[a, b]| format!("{}–{}", handles.labels[a.index()], handles.labels[b.index()]))
        .collect();
    (!flat.is_empty()).then(|| {
        error(
            "strain-edges",
            format!(
                "{} no length at rest: {}; leave out edges that join a place to itself",
                count(flat.len(), "strain edge has", "strain edges have"),
                first_few(&flat)
            ),
        )
    })
}

/// The lowest and the highest corner of the neutral's bounding box.
fn bounds(face: &Face) -> [DVec3; 2] {
    face.neutral.bounds().unwrap_or_default().map(DVec3::from_array)
}

fn is_positive(x: f64) -> bool {
    x.is_finite() && x > 0.0
}

fn not_finite(positions: &[[f64; 3]]) -> Option<usize> {
    positions.iter().position(|p| p.iter().any(|c| !c.is_finite()))
}
