//! The surface: pieces, triangles, edges, faces.

use super::*;
use rhytid_core::{Faces, VertexId};

#[test]
fn components_without_handles_stay_or_follow() {
    let mut face = with(|f| add_piece(f, 3, 2, [0.0, 0.0, -3.0]));
    face.settings.method = Method::Chapter;
    let code = "components-without-handles";
    let words = ["1 connected component has no handle", "6 of the 31 vertices (6 with vertex 25)"];
    finds(&face, Severity::Warning, code, &[&words[..], &["does not move", "\"nearest\""]].concat());
    let rows = |face: &Face| -> Vec<f64> {
        solved(face).basis().rows().skip(25).map(|row| row.iter().sum()).collect()
    };
    assert_eq!(rows(&face), [0.0; 6], "it does not move");

    face.settings.bind = Bind::Nearest;
    finds(&face, Severity::Note, code, &[&words[..], &["follows the closest point"]].concat());
    assert!(rows(&face).iter().all(|sum| (sum - 1.0).abs() < 1e-9), "it follows");

    face.settings.method = Method::default();
    face.settings.bind = Bind::Auto;
    finds(&face, Severity::Note, code, &[&words[..], &["moves as the examples show"]].concat());
    face.examples.clear();
    let report = examine(&face);
    let found = report.findings.iter().find(|finding| finding.code == code).unwrap();
    assert!(found.severity == Severity::Warning && found.message.contains("does not move"), "{found:?}");
}

#[test]
fn the_largest_components_are_named_first() {
    let face = with(|f| {
        for piece in 0..7 {
            add_piece(f, if piece == 4 { 4 } else { 2 }, 2, [0.0, 0.0, -2.0 - f64::from(piece)]);
        }
        f.settings.method = Method::Chapter;
    });
    let words = [
        "7 connected components have no handle",
        "32 of the 57 vertices",
        "(8 with vertex 41, 4 with vertex 25, 4 with vertex 29,",
        "and 2 more)",
    ];
    finds(&face, Severity::Warning, "components-without-handles", &words);
}

#[test]
fn findings_name_all_their_vertices() {
    let about = |face: &Face, code: &str| -> Vec<u32> {
        let report = examine(face);
        let found = report.findings.iter().find(|finding| finding.code == code).expect(code);
        found.vertices.iter().map(|v| v.0).collect()
    };
    // The sentence names the first vertex of the piece alone.
    let piece = with(|f| add_piece(f, 4, 3, [0.0, 0.0, -3.0]));
    assert_eq!(about(&piece, "components-without-handles"), (25..37).collect::<Vec<u32>>());
    // Of two triangles that share vertices, each vertex is there once.
    let flat = with(|f| {
        f.neutral.faces.push(&[8, 6, 7]);
        f.neutral.faces.push(&[3, 3, 8]);
    });
    assert_eq!(about(&flat, "degenerate-triangles"), [3, 6, 7, 8]);
    let isolated = with(|f| add_vertices(f, &[[6.0, 6.0, 5.0]; 7]));
    assert_eq!(about(&isolated, "isolated-vertices"), (25..32).collect::<Vec<u32>>());
    // What is about the whole face names no vertex.
    let alone = with(|f| f.examples.clear());
    assert_eq!(about(&alone, "no-examples"), [0; 0]);
}

#[test]
fn triangles_without_area() {
    // Three vertices of a row, and one vertex twice. The edges of neither are reported as well.
    let face = with(|f| f.neutral.faces.push(&[6, 7, 8]));
    finds(&face, Severity::Warning, "degenerate-triangles", &["1 triangle has no area, in face 17;"]);
    let face = with(|f| {
        f.neutral.faces.push(&[6, 7, 8]);
        f.neutral.faces.push(&[3, 3, 8]);
    });
    finds(&face, Severity::Warning, "degenerate-triangles", &["2 triangles have no area, in faces 17, 18;"]);
}

#[test]
fn repeated_triangles() {
    // The first quad is cut into (0, 1, 6) and (0, 6, 5).
    for triangle in [[0, 1, 6], [6, 0, 1], [1, 0, 6]] {
        let face = with(|f| f.neutral.faces.push(&triangle));
        finds(
            &face,
            Severity::Warning,
            "duplicate-triangles",
            &["1 triangle repeats another", "in face 17;"],
        );
    }
    let face = with(|f| f.neutral.faces.push(&[0, 1, 6, 5]));
    finds(&face, Severity::Warning, "duplicate-triangles", &["2 triangles repeat another", "in face 17;"]);
}

#[test]
fn edges_with_three_triangles() {
    let face = with(|f| {
        add_vertices(f, &[[6.0, 6.0, 5.0]]);
        f.neutral.faces.push(&[7, 6, 25]);
    });
    let words = ["1 edge has more than two triangles", "vertices 6–7;"];
    finds(&face, Severity::Warning, "non-manifold-edges", &words);
}

#[test]
fn faces_turned_inside_out() {
    let face = with(|f| f.neutral.faces.indices[..4].reverse());
    let words = ["2 edges join triangles that face opposite ways", "vertices 1–6, 5–6;"];
    finds(&face, Severity::Warning, "inconsistent-orientation", &words);
    let mirrored = with(|f| f.neutral.faces.indices.chunks_mut(4).for_each(<[u32]>::reverse));
    assert_eq!(examine(&mirrored).findings, [], "all of them turned is consistent");
}

#[test]
fn vertices_of_no_face() {
    let face = with(|f| add_vertices(f, &[[1.0, 2.0, 3.0], [3.0, 2.0, 1.0]]));
    finds(&face, Severity::Note, "isolated-vertices", &["2 vertices belong to no face: 25, 26;"]);

    let face = with(|f| {
        add_vertices(f, &[[1.0, 2.0, 3.0]]);
        f.handles.labels.push("lost".into());
        f.handles.points.push(VertexId(25).into());
    });
    let report = examine(&face);
    let codes: Vec<_> = report.findings.iter().map(|f| (f.severity, f.code)).collect();
    assert_eq!(
        codes,
        [(Severity::Warning, "isolated-vertices"), (Severity::Warning, "handle-on-another-component")]
    );
    says(&report.findings[0].message, &["1 vertex belongs to no face: 25;", "no skin to pull (lost)"]);
    let rig = solved(&face);
    let pulled = (0..25).map(|v| rig.basis().row(v)[5]).all(|b| b == 0.0);
    assert!(pulled, "a handle without skin pulls nothing");
}

/// The corner of two quads moves almost onto the line between its neighbours.
#[test]
fn triangles_that_are_almost_lines() {
    let thin = |part: f64| {
        let mut face = face();
        let quads: Vec<Vec<u32>> = face.neutral.faces.iter().map(<[u32]>::to_vec).collect();
        let mut faces = Faces::default();
        for (k, quad) in quads.iter().enumerate() {
            let [a, b, c, d] = quad[..] else { panic!("a sheet of quads") };
            if k % 7 != 3 {
                faces.push(quad);
                continue;
            }
            let new = face.neutral.positions.len() as u32;
            for positions in std::iter::once(&mut face.neutral.positions)
                .chain(face.examples.iter_mut().map(|e| &mut e.positions))
            {
                let [a, b, c] = [a, b, c].map(|v| positions[v as usize]);
                positions.push(std::array::from_fn(|i| (a[i] + b[i]) / 2.0 * (1.0 - part) + c[i] * part));
            }
            for corners in [[a, b, new], [b, c, new], [c, a, new], [a, c, d]] {
                faces.push(&corners);
            }
        }
        face.neutral.faces = faces;
        face
    };
    for exponent in 2..16 {
        let face = thin(0.1_f64.powi(exponent));
        let report = examine(&face);
        assert!(!report.has_errors(), "{report:#?}");
        if exponent > 6 {
            assert_eq!(report.findings[0].code, "degenerate-triangles", "{exponent}: {report:#?}");
        }
        let rig = solved(&face);
        rig.rounded().unwrap();
        // Each handle's column is one at its handle, and all of them together are one everywhere.
        for row in rig.shell().unwrap().basis().rows() {
            assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-3, "{exponent}: {}", row.iter().sum::<f64>());
        }
    }
}

/// The sheet, cut open along its middle column as glTF does at a texture seam; the cut vertices come twice.
fn cut_sheet() -> Face {
    with(|f| {
        let middle: Vec<[f64; 3]> =
            (0..SIDE).map(|row| f.neutral.positions[(row * SIDE + 2) as usize]).collect();
        add_vertices(f, &middle);
        for face in f.neutral.faces.indices.chunks_mut(4) {
            if face.iter().any(|v| v % SIDE > 2 && *v < 25) {
                face.iter_mut().filter(|v| **v % SIDE == 2).for_each(|v| *v = 25 + *v / SIDE);
            }
        }
        // Minus zero is the same place as zero.
        f.neutral.positions[25][1] = -0.0;
    })
}

#[test]
fn seams_that_cut_the_skin() {
    let mut face = cut_sheet();
    let words =
        ["5 boundary vertices lie exactly on another one", "25 on 2, 26 on 7, 27 on 12,", "merge them"];
    finds(&face, Severity::Warning, "coincident-boundary-vertices", &words);

    // Without a handle the two halves stay together, so the seam is not reported.
    let sheet = face.neutral.positions.len();
    add_piece(&mut face, SIDE, SIDE, [100.0, 0.0, 0.0]);
    let moved = |v: VertexId| VertexId(v.0 + sheet as u32);
    face.handles.points.iter_mut().for_each(|point| *point = point.renamed(moved));
    face.metres_per_unit = 0.002;
    face.examples[0].positions[sheet + 12][2] += 1.0;
    finds(&face, Severity::Note, "components-without-handles", &["2 connected components", "30 of the 55"]);
}

#[test]
fn a_face_that_looks_up() {
    let face = with(|f| {
        for x in f.neutral.positions.iter_mut().chain(&mut f.examples[0].positions) {
            *x = [x[0], x[2], -x[1]];
        }
    });
    finds(&face, Severity::Warning, "up", &["up = \"y\", but the face looks along that axis", "up = \"z\""]);
    assert_eq!(examine(&Face { up_axis: UpAxis::Z, ..face }).findings, []);
}
