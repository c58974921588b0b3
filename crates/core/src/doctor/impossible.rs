//! What makes a solve impossible.
use super::{Report, Severity, first_few};
use crate::triangulate::is_degenerate;
use crate::{Face, StrainEdges};
use glam::DVec3;
use std::collections::HashMap;

pub(super) fn examine(face: &Face, report: &mut Report) {
    let mut error = |code: &'static str, message: String| report.add(Severity::Error, code, message);
    let mesh = &face.neutral;
    let vertices = mesh.positions.len();
    if mesh.faces.is_empty() || vertices == 0 {
        return error(
            "no-faces",
            "the neutral mesh has no faces; export it as a surface, not as points".into(),
        );
    }
    if let Some(v) = not_finite(&mesh.positions) {
        error(
            "not-finite",
            format!("vertex {v} of the neutral mesh is at {:?}, expected finite numbers", mesh.positions[v]),
        );
    }
    let corners: u64 = mesh.faces.counts.iter().map(|&n| u64::from(n)).sum();
    if corners != mesh.faces.indices.len() as u64 || mesh.faces.counts.iter().any(|&n| n < 3) {
        return error(
            "faces",
            format!(
                "the neutral mesh has {} corners where its faces ask for {corners}, each at least 3",
                mesh.faces.indices.len()
            ),
        );
    }
    if let Some(v) = mesh.faces.indices.iter().find(|&&v| v as usize >= vertices) {
        return error(
            "faces",
            format!("a face of the neutral mesh names vertex {v}, expected 0 to {}", vertices - 1),
        );
    }
    let position = |v: u32| DVec3::from_array(mesh.positions[v as usize]);
    if mesh.triangles().iter().all(|t| is_degenerate(t.map(position))) {
        error("no-area", "no triangle of the neutral mesh has an area; check its coordinates".into());
    }

    let handles = &face.handles;
    if handles.vertices.is_empty() {
        error("no-handles", "the face has no handles; list at least one label and vertex".into());
    }
    if handles.labels.len() != handles.vertices.len() {
        return error(
            "handles",
            format!("{} labels for {} handle vertices", handles.labels.len(), handles.vertices.len()),
        );
    }
    let mut by_label = HashMap::new();
    let mut by_vertex = HashMap::new();
    for (label, &v) in handles.labels.iter().zip(&handles.vertices) {
        if v as usize >= vertices {
            error(
                "handle-out-of-range",
                format!(
                    "handle {label} is vertex {v}, expected 0 to {}; vertices count from 0",
                    vertices - 1
                ),
            );
        }
        if by_label.insert(label, v).is_some() {
            error("duplicate-handle", format!("handle {label} is listed twice; each label is one marker"));
        }
        if let Some(other) = by_vertex.insert(v, label) {
            error(
                "duplicate-handle",
                format!("handles {other} and {label} are both vertex {v}; each needs a vertex of its own"),
            );
        }
    }
    for example in &face.examples {
        if example.positions.len() != vertices {
            error(
                "example",
                format!(
                    "example {} has {} vertices where the neutral mesh has {vertices}; all scans need one topology",
                    example.name,
                    example.positions.len()
                ),
            );
        } else if let Some(v) = not_finite(&example.positions) {
            error(
                "not-finite",
                format!("vertex {v} of example {} is at {:?}", example.name, example.positions[v]),
            );
        }
    }

    let settings = &face.settings;
    let positive = |x: f64| x.is_finite() && x > 0.0;
    if let Some(length) = settings.bending_length.filter(|l| !positive(*l)) {
        error("settings", format!("bending_length is {length}, expected a length above 0 in mesh units"));
    }
    if settings.max_influences == 0 {
        error("settings", "max_influences is 0, expected at least 1".into());
    }
    if !positive(face.metres_per_unit) {
        error("settings", format!("a unit is {} metres, expected a number above 0", face.metres_per_unit));
    }
    if let StrainEdges::Given(edges) = &settings.strain_edges {
        let h = handles.vertices.len();
        if edges.iter().flatten().any(|&i| i as usize >= h) || edges.iter().any(|[a, b]| a == b) {
            return error("strain-edges", format!("a strain edge must join two of the {h} handles"));
        }
        let at = |i: u32| mesh.positions.get(handles.vertices[i as usize] as usize);
        let flat: Vec<String> = edges
            .iter()
            .filter(|&&[a, b]| at(a) == at(b))
            .map(|&[a, b]| format!("{}–{}", handles.labels[a as usize], handles.labels[b as usize]))
            .collect();
        if !flat.is_empty() {
            error(
                "strain-edges",
                format!("strain edges without a length at rest: {}; leave them out", first_few(&flat)),
            );
        }
    }
}

fn not_finite(positions: &[[f64; 3]]) -> Option<usize> {
    positions.iter().position(|p| p.iter().any(|c| !c.is_finite()))
}
