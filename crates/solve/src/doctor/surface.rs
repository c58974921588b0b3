//! Findings about the surface of the neutral mesh.
use super::finding::{Report, Severity};
use super::words::{count, first_few};
use crate::driven::DrivenComponents;
use glam::DVec3;
use rhytid_core::{Bind, Face, Faces, Method, VertexId};
use rhytid_geometry::laplacian::is_degenerate;
use rhytid_geometry::triangulate;
use std::collections::{HashMap, HashSet};

/// `of_file` are the faces before vertices were joined.
pub(super) fn examine(face: &Face, of_file: &Faces, report: &mut Report) {
    let mesh = &face.neutral;
    let triangles = triangulate(mesh);
    let face_of: Vec<usize> =
        (0..).zip(&mesh.faces.counts).flat_map(|(f, &n)| vec![f; n as usize - 2]).collect();
    // Faces are numbered from 1, as modelling programs and editors of OBJ files do.
    let named = |ts: &[usize]| {
        let mut faces: Vec<usize> = ts.iter().map(|&t| face_of[t] + 1).collect();
        faces.dedup();
        format!("{} {}", if faces.len() == 1 { "face" } else { "faces" }, first_few(&faces))
    };
    let corners =
        |ts: &[usize]| -> Vec<VertexId> { ts.iter().flat_map(|&t| triangles[t]).map(VertexId).collect() };
    let components = DrivenComponents::new(&mesh.positions, &triangles, &face.handles.points);

    undriven(face, of_file, &components, report);

    let position = |v: u32| DVec3::from_array(mesh.positions[v as usize]);
    let degenerate: Vec<usize> =
        (0..triangles.len()).filter(|&t| is_degenerate(triangles[t].map(position))).collect();
    if !degenerate.is_empty() {
        report.add_at(
            Severity::Warning,
            "degenerate-triangles",
            corners(&degenerate),
            format!(
                "{} no area, in {}; the skin is not held together there: mend or remove it if that shows",
                count(degenerate.len(), "triangle has", "triangles have"),
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
        report.add_at(
            Severity::Warning,
            "duplicate-triangles",
            corners(&duplicate),
            format!(
                "{} another one with the same three vertices, in {}; the skin is stiffer there: remove doubled \
                 faces",
                count(duplicate.len(), "triangle repeats", "triangles repeat"),
                named(&duplicate)
            ),
        );
    }

    // Triangles that were reported already are left out.
    let left_out: HashSet<usize> = degenerate.into_iter().chain(duplicate).collect();
    let uses = edge_uses((0..triangles.len()).filter(|t| !left_out.contains(t)).map(|t| triangles[t]));
    edges(&uses, report);
    seams(face, &components, &uses, report);
}

fn undriven(face: &Face, of_file: &Faces, components: &DrivenComponents, report: &mut Report) {
    let mesh = &face.neutral;
    let in_faces = |faces: &Faces| {
        let mut used = vec![false; mesh.positions.len()];
        faces.indices.iter().for_each(|&v| used[v as usize] = true);
        used
    };
    let used_of_file = in_faces(of_file);
    let isolated: Vec<usize> = (0..used_of_file.len()).filter(|&v| !used_of_file[v]).collect();
    if !isolated.is_empty() {
        let handles = &face.handles;
        let stray: Vec<&String> = handles
            .labels
            .iter()
            .zip(&handles.points)
            .filter(|(_, point)| !used_of_file[point.nearest_vertex().index()])
            .map(|(label, _)| label)
            .collect();
        let (severity, then) = if stray.is_empty() {
            (Severity::Note, "they are kept, but are not visible".to_owned())
        } else {
            let named = first_few(&stray);
            (
                Severity::Warning,
                format!("handles among them have no skin to pull ({named}): check their vertices"),
            )
        };
        report.add_at(
            severity,
            "isolated-vertices",
            isolated.iter().map(|&v| VertexId::from_index(v)),
            format!(
                "{} to no face: {}; {then}",
                count(isolated.len(), "vertex belongs", "vertices belong"),
                first_few(&isolated)
            ),
        );
    }

    let used = in_faces(&mesh.faces);
    let joined = used.iter().zip(&used_of_file).filter(|(named, of_file)| **of_file && !**named).count();
    let mut size: HashMap<u32, (usize, usize)> = HashMap::new();
    let is_undriven = (0..used.len()).filter(|&v| !components.driven[v] && used[v]);
    for v in is_undriven.clone() {
        size.entry(components.component[v]).or_insert((0, v)).0 += 1;
    }
    let mut undriven: Vec<(usize, usize)> = size.into_values().collect();
    undriven.sort_by_key(|&(n, v)| (std::cmp::Reverse(n), v));
    if !undriven.is_empty() {
        let total: usize = undriven.iter().map(|c| c.0).sum();
        let listed: Vec<String> = undriven.iter().map(|(n, v)| format!("{n} with vertex {v}")).collect();
        let learned = matches!(face.settings.method, Method::Learned(_)) && !face.examples.is_empty();
        let (severity, fate) = match face.settings.bind {
            Bind::Auto if learned => (
                Severity::Note,
                "moves as the examples show: as a solid, or in part with the closest point of the skin",
            ),
            Bind::Auto | Bind::Rigid => {
                (Severity::Warning, "does not move (bind = \"nearest\" would let it follow the skin)")
            }
            Bind::Nearest => (Severity::Note, "follows the closest point of the skin (bind = \"nearest\")"),
        };
        report.add_at(
            severity,
            "components-without-handles",
            is_undriven.map(VertexId::from_index),
            format!(
                "{}, {total} of the {} vertices ({}); such a component {fate}",
                count(
                    undriven.len(),
                    "connected component has no handle",
                    "connected components have no handle"
                ),
                mesh.positions.len() - joined,
                first_few(&listed)
            ),
        );
    }
}

/// For each edge (lower vertex first), the number of triangles that run along it upwards and downwards.
type EdgeUses = HashMap<(u32, u32), [u32; 2]>;

fn edge_uses(triangles: impl Iterator<Item = [u32; 3]>) -> EdgeUses {
    let mut uses = EdgeUses::new();
    for [a, b, c] in triangles {
        for (i, j) in [(a, b), (b, c), (c, a)] {
            uses.entry((i.min(j), i.max(j))).or_default()[usize::from(i > j)] += 1;
        }
    }
    uses
}

fn edges(uses: &EdgeUses, report: &mut Report) {
    let select = |bad: fn(&[u32; 2]) -> bool| {
        let mut edges: Vec<(u32, u32)> = uses.iter().filter(|(_, n)| bad(n)).map(|(e, _)| *e).collect();
        edges.sort_unstable();
        let named: Vec<String> = edges.iter().map(|(a, b)| format!("{a}–{b}")).collect();
        let vertices: Vec<VertexId> = edges.iter().flat_map(|&(a, b)| [a, b]).map(VertexId).collect();
        (!edges.is_empty()).then(|| (edges.len(), first_few(&named), vertices))
    };
    if let Some((n, named, vertices)) = select(|[up, down]| up + down > 2) {
        report.add_at(
            Severity::Warning,
            "non-manifold-edges",
            vertices,
            format!(
                "{} more than two triangles, between vertices {named}; the skin is stiffer there and its normals \
                 are a mixture: separate the sheets",
                count(n, "edge has", "edges have")
            ),
        );
    }
    if let Some((n, named, vertices)) = select(|[up, down]| up + down == 2 && up != down) {
        report.add_at(
            Severity::Warning,
            "inconsistent-orientation",
            vertices,
            format!(
                "{} triangles that face opposite ways, between vertices {named}; their normals cancel there: \
                 recalculate the mesh's normals to the outside",
                count(n, "edge joins", "edges join")
            ),
        );
    }
}

/// Boundary vertices that coincide are usually one vertex that the file format split at a texture seam. Where
/// no handle drives them, they stay together anyway.
fn seams(face: &Face, components: &DrivenComponents, uses: &EdgeUses, report: &mut Report) {
    let mut boundary: Vec<u32> =
        uses.iter().filter(|(_, [up, down])| up + down == 1).flat_map(|(&(a, b), _)| [a, b]).collect();
    boundary.sort_unstable();
    boundary.dedup();
    let mut at: HashMap<[u64; 3], Vec<u32>> = HashMap::new();
    for v in boundary {
        // Adding zero makes −0 and 0 the same.
        let key = face.neutral.positions[v as usize].map(|c| (c + 0.0).to_bits());
        at.entry(key).or_default().push(v);
    }
    let mut split: Vec<(u32, u32)> = at
        .into_values()
        .filter(|same| same.iter().any(|&v| components.driven[v as usize]))
        .flat_map(|same| same[1..].iter().map(|&v| (v, same[0])).collect::<Vec<_>>())
        .collect();
    split.sort_unstable();
    if !split.is_empty() {
        let named: Vec<String> = split.iter().map(|(v, first)| format!("{v} on {first}")).collect();
        let cure = match face.settings.weld {
            true => {
                "they are not joined where an example moves them apart, where faces next to each other look \
                 opposite ways, or where edges do not fit together: mend that, or merge them and export again"
            }
            false => "set weld = true in [mesh] to join them for the solve, or merge them and export again",
        };
        report.add_at(
            Severity::Warning,
            "coincident-boundary-vertices",
            split.iter().flat_map(|&(v, first)| [v, first]).map(VertexId),
            format!(
                "{} exactly on another one: {}; if they are one point of the skin (glTF splits vertices at texture \
                 seams), the surface is cut open there: {cure}",
                count(split.len(), "boundary vertex lies", "boundary vertices lie"),
                first_few(&named)
            ),
        );
    }
}
