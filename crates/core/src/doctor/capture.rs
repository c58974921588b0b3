//! What looks wrong between the mesh, its handles, its examples and its unit.
use super::{Report, Severity, first_few};
use crate::Face;
use crate::solve::driven::DrivenComponents;
use glam::DVec3;

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
            format!("the neutral mesh is {metres:.3} m across, not the size of a head; {advice}"),
        );
    }

    stray_handles(face, report);

    let handles = &face.handles.vertices;
    for example in &face.examples {
        let moved = |v: usize| {
            DVec3::from_array(example.positions[v]).distance(DVec3::from_array(face.neutral.positions[v]))
        };
        let furthest = (0..example.positions.len()).map(moved).fold(0.0, f64::max);
        if furthest > 0.5 * diagonal {
            report.add(
                Severity::Warning,
                "example-far-away",
                format!(
                    "example {} moves a vertex by {furthest:.3} units, over half of the mesh's size; check that \
                     it has the neutral's unit, place and vertex order",
                    example.name
                ),
            );
        }
        if handles.iter().all(|&v| moved(v as usize) <= 1e-6 * diagonal) {
            report.add(
                Severity::Warning,
                "example-at-rest",
                format!(
                    "example {} moves no handle; its detail cannot be told from the rest pose and will be lost",
                    example.name
                ),
            );
        }
    }
    if face.examples.is_empty() {
        report.add(
            Severity::Note,
            "no-examples",
            "there are no examples; the rig has the large scale only, without wrinkles".into(),
        );
    }
}

/// Handles whose nearest neighbours all sit on other components: often a marker snapped to an eyeball or a lash.
fn stray_handles(face: &Face, report: &mut Report) {
    let mesh = &face.neutral;
    let (vertices, labels) = (&face.handles.vertices, &face.handles.labels);
    let components = DrivenComponents::new(&mesh.positions, &mesh.triangles(), vertices);
    let component = |h: usize| components.component[vertices[h] as usize];
    let position = |h: usize| DVec3::from_array(mesh.positions[vertices[h] as usize]);
    for h in 0..vertices.len() {
        let mut others: Vec<usize> = (0..vertices.len()).filter(|&o| o != h).collect();
        others.sort_by(|&a, &b| {
            position(a).distance(position(h)).total_cmp(&position(b).distance(position(h)))
        });
        others.truncate(NEIGHBORS);
        if others.len() >= 2 && others.iter().all(|&o| component(o) != component(h)) {
            let named: Vec<&String> = others.iter().map(|&o| &labels[o]).collect();
            report.add(
                Severity::Warning,
                "handle-on-another-component",
                format!(
                    "handle {} (vertex {}) is on another connected component than its nearest handles {}; \
                     check its vertex",
                    labels[h],
                    vertices[h],
                    first_few(&named)
                ),
            );
        }
    }
}
