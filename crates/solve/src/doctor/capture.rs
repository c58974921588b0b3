//! Findings between the mesh, its handles, its examples and its unit.
use super::finding::{Report, Severity};
use super::words::{count, first_few, length};
use crate::driven::DrivenComponents;
use crate::triangulate::triangulate;
use glam::DVec3;
use rhytid_core::Face;

/// Nearest handles that a handle is compared with.
const NEIGHBORS: usize = 4;

/// A head or face scan is about this large, in metres: the diagonal of its bounding box.
const PLAUSIBLE_DIAGONAL: std::ops::Range<f64> = 0.08..1.2;

pub(super) fn examine(face: &Face, report: &mut Report) {
    let [low, high] = face.neutral.bounds().unwrap_or_default().map(DVec3::from_array);
    let diagonal = high.distance(low);
    let metres = diagonal * face.metres_per_unit;
    if !PLAUSIBLE_DIAGONAL.contains(&metres) {
        let fitting: Vec<&str> = [("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("in", 0.0254)]
            .into_iter()
            .filter(|(_, unit)| PLAUSIBLE_DIAGONAL.contains(&(diagonal * unit)))
            .map(|(name, _)| name)
            .collect();
        let advice = match fitting.as_slice() {
            [] => "check the scan's scale".to_owned(),
            units => format!("units = \"{}\" would make it the size of a head", units.join("\" or \"")),
        };
        report.add(
            Severity::Warning,
            "units",
            format!("the neutral mesh is {} m across, not the size of a head; {advice}", length(metres)),
        );
    }

    stray_handles(face, report);

    let handles = &face.handles.vertices;
    for example in &face.examples {
        let moved = |v: usize| {
            DVec3::from_array(example.positions[v]).distance(DVec3::from_array(face.neutral.positions[v]))
        };
        let (furthest, vertex) = (0..example.positions.len())
            .map(|v| (moved(v), v))
            .fold((0.0, 0), |most, next| if next.0 > most.0 { next } else { most });
        if furthest > 0.5 * diagonal {
            report.add(
                Severity::Warning,
                "example-far-away",
                format!(
                    "example {} moves vertex {vertex} by {} mesh units, over half of the mesh's size; check that \
                     it has the neutral's unit, place and vertex order",
                    example.name,
                    length(furthest)
                ),
            );
        }
        if handles.iter().all(|&v| moved(v as usize) <= 1e-6 * diagonal) {
            report.add(
                Severity::Warning,
                "example-at-rest",
                format!(
                    "example {} moves no handle, so that the rig cannot tell it from the rest pose: its detail is \
                     lost or shows at rest too; leave it out, or check its mesh",
                    example.name
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

/// Handles whose nearest neighbours all sit on other components: often a marker snapped to an eyeball or a lash.
fn stray_handles(face: &Face, report: &mut Report) {
    let mesh = &face.neutral;
    let (vertices, labels) = (&face.handles.vertices, &face.handles.labels);
    let components = DrivenComponents::new(&mesh.positions, &triangulate(mesh), vertices);
    let component = |h: usize| components.component[vertices[h] as usize];
    let position = |h: usize| DVec3::from_array(mesh.positions[vertices[h] as usize]);
    let mut stray = Vec::new();
    for h in 0..vertices.len() {
        let mut others: Vec<usize> = (0..vertices.len()).filter(|&o| o != h).collect();
        others.sort_by(|&a, &b| {
            position(a).distance(position(h)).total_cmp(&position(b).distance(position(h)))
        });
        others.truncate(NEIGHBORS);
        if others.len() >= 2 && others.iter().all(|&o| component(o) != component(h)) {
            stray.push(format!("{} (vertex {})", labels[h], vertices[h]));
        }
    }
    if !stray.is_empty() {
        report.add(
            Severity::Warning,
            "handle-on-another-component",
            format!(
                "{} another connected component than all of the nearest handles: {}; check the vertex in the table \
                 of handles",
                count(stray.len(), "handle is on", "handles are each on"),
                first_few(&stray)
            ),
        );
    }
}
