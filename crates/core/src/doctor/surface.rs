//! What is wrong with the neutral mesh as a surface.
use super::{Report, Severity, count, first_few};
use crate::solve::driven::DrivenComponents;
use crate::triangulate::is_degenerate;
use crate::{Bind, Face};
use glam::DVec3;
use std::collections::{HashMap, HashSet};

pub(super) fn examine(face: &Face, report: &mut Report) {
    let mesh = &face.neutral;
    let triangles = mesh.triangles();
    let face_of: Vec<usize> =
        (0..).zip(&mesh.faces.counts).flat_map(|(f, &n)| vec![f; n as usize - 2]).collect();
    // Faces are numbered from 1, as modelling programs and editors of OBJ files do.
    let named = |ts: &[usize]| {
        let mut faces: Vec<usize> = ts.iter().map(|&t| face_of[t] + 1).collect();
        faces.dedup();
        first_few(&faces)
    };

    components(face, &triangles, report);

    let position = |v: u32| DVec3::from_array(mesh.positions[v as usize]);
    let degenerate: Vec<usize> =
        (0..triangles.len()).filter(|&t| is_degenerate(triangles[t].map(position))).collect();
    if !degenerate.is_empty() {
        report.add(
            Severity::Warning,
            "degenerate-triangles",
            format!(
                "{} without area, in faces {}; they add nothing to the solve and hold nothing together",
                count(degenerate.len(), "triangle", "triangles"),
                named(&degenerate)
            ),
        );
    }

    let mut seen = HashSet::new();
    let duplicate: Vec<usize> = (0..triangles.len())
        .filter(|&t| {
            let mut sorted = triangles[t];
            sorted.sort_unstable();
            !seen.insert(sorted)
        })
        .collect();
    if !duplicate.is_empty() {
        report.add(
            Severity::Warning,
            "duplicate-triangles",
            format!(
                "{} another one with the same three vertices, in faces {}; the skin is twice as stiff there: \
                 remove doubled faces",
                count(duplicate.len(), "triangle repeats", "triangles repeat"),
                named(&duplicate)
            ),
        );
    }
    edges(&triangles, report);
    seams(face, &triangles, report);
}

fn components(face: &Face, triangles: &[[u32; 3]], report: &mut Report) {
    let mesh = &face.neutral;
    let components = DrivenComponents::new(&mesh.positions, triangles, &face.handles.vertices);
    let mut used = vec![false; mesh.positions.len()];
    mesh.faces.indices.iter().for_each(|&v| used[v as usize] = true);
    let isolated: Vec<usize> = (0..used.len()).filter(|&v| !used[v]).collect();
    let fate = match face.settings.bind {
        Bind::Rigid => "do not move (bind = \"rigid\"; bind = \"nearest\" lets them follow the skin)",
        Bind::Nearest => "follow the closest point of the driven surface (bind = \"nearest\")",
    };
    if !isolated.is_empty() {
        report.add(
            Severity::Warning,
            "isolated-vertices",
            format!(
                "{} to no face: {}; those that are no handles {fate}",
                count(isolated.len(), "vertex belongs", "vertices belong"),
                first_few(&isolated)
            ),
        );
    }

    let mut size: HashMap<u32, (usize, usize)> = HashMap::new();
    for (v, &c) in components.component.iter().enumerate() {
        if !components.driven[v] && used[v] {
            size.entry(c).or_insert((0, v)).0 += 1;
        }
    }
    let mut undriven: Vec<(usize, usize)> = size.into_values().collect();
    undriven.sort_by_key(|&(n, v)| (std::cmp::Reverse(n), v));
    if !undriven.is_empty() {
        let total: usize = undriven.iter().map(|c| c.0).sum();
        let listed: Vec<String> = undriven
            .iter()
            .map(|(n, v)| format!("{} from vertex {v}", count(*n, "vertex", "vertices")))
            .collect();
        report.add(
            Severity::Warning,
            "components-without-handles",
            format!(
                "{} no handle ({} of {} vertices: {}); they {fate}",
                count(undriven.len(), "connected component has", "connected components have"),
                total,
                mesh.positions.len(),
                first_few(&listed)
            ),
        );
    }
}

fn edges(triangles: &[[u32; 3]], report: &mut Report) {
    // For each edge, how many triangles run along it upwards and downwards.
    let mut uses: HashMap<(u32, u32), [u32; 2]> = HashMap::with_capacity(triangles.len() * 2);
    for [a, b, c] in triangles {
        for (i, j) in [(a, b), (b, c), (c, a)] {
            uses.entry((*i.min(j), *i.max(j))).or_default()[usize::from(i > j)] += 1;
        }
    }
    let select = |bad: fn(&[u32; 2]) -> bool| {
        let mut edges: Vec<(u32, u32)> = uses.iter().filter(|(_, n)| bad(n)).map(|(e, _)| *e).collect();
        edges.sort_unstable();
        let named: Vec<String> = edges.iter().map(|(a, b)| format!("{a}–{b}")).collect();
        (!edges.is_empty()).then(|| (edges.len(), first_few(&named)))
    };
    if let Some((n, named)) = select(|[up, down]| up + down > 2) {
        report.add(
            Severity::Warning,
            "non-manifold-edges",
            format!(
                "{} more than two triangles, between vertices {named}; the surface is stiffer there and its \
                 normals are mixed: separate the sheets",
                count(n, "edge has", "edges have")
            ),
        );
    }
    if let Some((n, named)) = select(|[up, down]| up + down == 2 && up != down) {
        report.add(
            Severity::Warning,
            "inconsistent-orientation",
            format!(
                "{} triangles that face opposite ways, between vertices {named}; normals cancel there: \
                 recalculate the mesh's normals to the outside",
                count(n, "edge joins", "edges join")
            ),
        );
    }
}

/// Boundary vertices that coincide are usually one vertex, split at a texture seam by the file format.
fn seams(face: &Face, triangles: &[[u32; 3]], report: &mut Report) {
    let mut open: HashMap<(u32, u32), u32> = HashMap::with_capacity(triangles.len() * 2);
    for [a, b, c] in triangles {
        for (i, j) in [(a, b), (b, c), (c, a)] {
            *open.entry((*i.min(j), *i.max(j))).or_default() += 1;
        }
    }
    let mut boundary: Vec<u32> =
        open.iter().filter(|(_, n)| **n == 1).flat_map(|(&(a, b), _)| [a, b]).collect();
    boundary.sort_unstable();
    boundary.dedup();
    let mut at: HashMap<[u64; 3], u32> = HashMap::new();
    let split: Vec<u32> = boundary
        .into_iter()
        .filter(|&v| {
            // Adding zero makes −0 and 0 the same.
            let key = face.neutral.positions[v as usize].map(|c| (c + 0.0).to_bits());
            at.insert(key, v).is_some()
        })
        .collect();
    if !split.is_empty() {
        report.add(
            Severity::Warning,
            "coincident-boundary-vertices",
            format!(
                "{} exactly on another one of the boundary: {}; if they are one point of the skin (glTF splits \
                 vertices at texture seams), the surface is cut open there: merge them, or export as OBJ",
                count(split.len(), "boundary vertex lies", "boundary vertices lie"),
                first_few(&split)
            ),
        );
    }
}
