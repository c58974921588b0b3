//! What the mesh doctor says of faces that are broken on purpose, one way at a time.

use proptest::prelude::*;
use rhytid_core::{
    Bind, Error, Example, Face, Faces, Handles, Mesh, Method, NoProgress, Rig, Settings, StrainEdges, UpAxis,
    Uvs,
};
use rhytid_solve::{Severity, examine, solve};
use rhytid_test_support::sheet::{SIDE, add_sheet, face};

/// `face` changed by `change`.
fn with(change: impl FnOnce(&mut Face)) -> Face {
    let mut face = face();
    change(&mut face);
    face
}

/// Adds vertices; the examples keep them where they are.
fn add_vertices(face: &mut Face, positions: &[[f64; 3]]) {
    face.neutral.positions.extend(positions);
    for example in &mut face.examples {
        example.positions.extend(positions);
    }
}

/// Adds a sheet that is connected to nothing, in the examples too.
fn add_piece(face: &mut Face, columns: u32, rows: u32, at: [f64; 3]) {
    let before = face.neutral.positions.len();
    add_sheet(&mut face.neutral, columns, rows, at);
    for example in &mut face.examples {
        example.positions.extend(&face.neutral.positions[before..]);
    }
}

fn solved(face: &Face) -> Rig<f64> {
    solve(face, &NoProgress).expect("a face without errors can be solved")
}

/// Asserts that the doctor finds exactly this and nothing else, says each of `words`, and that the face can be
/// solved.
#[track_caller]
fn finds(face: &Face, severity: Severity, code: &str, words: &[&str]) {
    let report = examine(face);
    let found: Vec<(Severity, &str)> = report.findings.iter().map(|f| (f.severity, f.code)).collect();
    assert_eq!(found, [(severity, code)], "{report:#?}");
    says(&report.findings[0].message, words);
    solved(face).cast::<f32>().check().unwrap();
}

#[track_caller]
fn says(message: &str, words: &[&str]) {
    for word in words {
        assert!(message.contains(word), "{word}: {message}");
    }
    assert!(!message.contains('\n') && !message.ends_with('.') && message.len() < 300, "{message}");
}

#[test]
fn a_good_face_is_left_in_peace() {
    assert_eq!(examine(&face()).findings, []);
    solved(&face());
}

#[test]
fn without_examples_there_is_a_note() {
    let face = with(|f| f.examples.clear());
    finds(&face, Severity::Note, "no-examples", &["no examples", "large scale only"]);
    assert!(!examine(&face).has_errors());
}

#[test]
fn components_without_handles_stay_or_follow() {
    let mut face = with(|f| add_piece(f, 3, 2, [0.0, 0.0, -3.0]));
    face.settings.method = Method::Chapter;
    let code = "components-without-handles";
    let words = ["1 connected component has no handle", "6 of the 31 vertices (6 with vertex 25)"];
    finds(&face, Severity::Warning, code, &[&words[..], &["does not move", "\"nearest\""]].concat());
    let rows = |face: &Face| -> Vec<f64> {
        solved(face).basis.chunks(5).skip(25).map(|row| row.iter().sum()).collect()
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
fn triangles_without_area() {
    // Three vertices of a row, and one vertex twice: neither is blamed a second time for its edges.
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
        f.handles.vertices.push(25);
    });
    let report = examine(&face);
    let codes: Vec<_> = report.findings.iter().map(|f| (f.severity, f.code)).collect();
    assert_eq!(
        codes,
        [(Severity::Warning, "isolated-vertices"), (Severity::Warning, "handle-on-another-component")]
    );
    says(&report.findings[0].message, &["1 vertex belongs to no face: 25;", "no skin to pull (lost)"]);
    let rig = solved(&face);
    let pulled = (0..25).map(|v| rig.basis[v * 6 + 5]).all(|b| b == 0.0);
    assert!(pulled, "a handle without skin pulls nothing");
}

#[test]
fn handles_that_snapped_to_another_piece() {
    let code = "handle-on-another-component";
    let piece = |f: &mut Face| add_piece(f, 3, 2, [4.0, 4.0, -1.0]);
    let face = with(|f| {
        piece(f);
        f.handles.labels.push("lid".into());
        f.handles.vertices.push(27);
    });
    finds(&face, Severity::Warning, code, &["1 handle is on another connected component", "lid (vertex 27)"]);
    let face = with(|f| {
        piece(f);
        add_piece(f, 2, 2, [4.0, 8.0, -3.0]);
        f.handles.labels.extend(["lid".into(), "lash".into()]);
        f.handles.vertices.extend([27, 31]);
    });
    let words = ["2 handles are each on another connected component", "lid (vertex 27), lash (vertex 31)"];
    finds(&face, Severity::Warning, code, &words);
    // A piece with enough handles of its own is meant so.
    let face = with(|f| {
        add_piece(f, 3, 2, [40.0, 0.0, 0.0]);
        f.handles.labels.extend(["l0".into(), "l1".into()]);
        f.handles.vertices.extend([25, 30]);
    });
    assert_eq!(examine(&face).findings, []);
}

#[test]
fn faces_far_from_the_origin() {
    let moved = |by: f64| {
        with(|f| {
            let all = f.neutral.positions.iter_mut().chain(&mut f.examples[0].positions);
            all.for_each(|p| p[0] += by);
        })
    };
    assert_eq!(examine(&moved(1e4)).findings, []);
    let words = ["is 10000 m from the origin", "rounds by up to 0.596 mm", "move all meshes"];
    finds(&moved(1e6), Severity::Warning, "far-from-origin", &words);
    let report = examine(&moved(1e9));
    assert_eq!(report.findings[0].code, "far-from-origin");
    assert!(report.has_errors());
}

/// The corner of two quads moves onto the line between its neighbours, but for a part of the way.
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
        rig.cast::<f32>().check().unwrap();
        // Each handle's column is one at its handle, and all of them together are one everywhere.
        let handles = rig.handles.len();
        for row in rig.basis.chunks(handles) {
            assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-3, "{exponent}: {}", row.iter().sum::<f64>());
        }
    }
}

#[test]
fn sizes_that_are_no_head() {
    // The sheet is 16 × 16 × 12.8 units: 26 across.
    for (unit, words) in [
        (1.0, ["is 26 m across", "units = \"cm\" or \"in\" would"]),
        (0.001, ["is 0.026 m across", "units = \"cm\" or \"in\" would"]),
        (1e-9, ["is 2.60e-8 m across", "units = \"cm\" or \"in\" would"]),
        (1e5, ["is 2599692 m across", "units = \"cm\" or \"in\" would"]),
    ] {
        finds(&with(|f| f.metres_per_unit = unit), Severity::Warning, "units", &words);
    }
    let scaled = |scale: f64| {
        with(|f| {
            let all = f.neutral.positions.iter_mut().chain(&mut f.examples[0].positions);
            all.flatten().for_each(|c| *c *= scale);
        })
    };
    let words = ["is 260 m across", "check the scan's scale"];
    finds(&scaled(1000.0), Severity::Warning, "units", &words);
    finds(&scaled(10.0), Severity::Warning, "units", &["is 2.6 m across", "units = \"mm\" would"]);
    for unit in [0.005, 0.01, 0.0254] {
        assert_eq!(examine(&with(|f| f.metres_per_unit = unit)).findings, [], "{unit}");
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
        // Minus zero is where zero is.
        f.neutral.positions[25][1] = -0.0;
    })
}

#[test]
fn seams_that_cut_the_skin() {
    let mut face = cut_sheet();
    let words =
        ["5 boundary vertices lie exactly on another one", "25 on 2, 26 on 7, 27 on 12,", "merge them"];
    finds(&face, Severity::Warning, "coincident-boundary-vertices", &words);

    // Without a handle the two halves stay together: nothing to say of the seam.
    let sheet = face.neutral.positions.len();
    add_piece(&mut face, SIDE, SIDE, [100.0, 0.0, 0.0]);
    face.handles.vertices = face.handles.vertices.iter().map(|v| v + sheet as u32).collect();
    face.metres_per_unit = 0.002;
    face.examples[0].positions[sheet + 12][2] += 1.0;
    finds(&face, Severity::Note, "components-without-handles", &["2 connected components", "30 of the 55"]);
}

#[test]
fn examples_in_another_unit() {
    let face = with(|f| f.examples[0].positions.iter_mut().flatten().for_each(|c| *c *= 10.0));
    let words = ["example smile", "vertex 24 by 234 mesh units", "over half of the mesh's size"];
    finds(&face, Severity::Warning, "example-far-away", &words);
}

#[test]
fn examples_that_move_no_handle() {
    let face = with(|f| {
        f.settings.method = Method::Chapter;
        let mut positions = f.neutral.positions.clone();
        positions[17][2] += 0.6;
        f.examples.push(Example { name: "twitch".into(), positions, mirror: false });
    });
    let words = ["example twitch moves no handle", "lost or shows at rest too"];
    finds(&face, Severity::Warning, "example-at-rest", &words);

    // It does show at rest: half of it, since the rest pose and the example share their mean.
    let rig = solved(&face);
    let (k, edges) = (rig.influences(), rig.strain_edges.len());
    let mut detail = [0.0; 3];
    for center in 0..rig.centers() {
        let squares = (0..k).map(|i| {
            let at = 17 * k + i;
            let strain = rig.pose_features[center * edges + rig.influence_edges[at] as usize];
            rig.influence_weights[at] * strain * strain
        });
        let distance = squares.sum::<f64>().sqrt();
        let weight = rig.rbf_weights[17 * rig.centers() + center];
        (0..3).for_each(|c| detail[c] += weight[c] * distance);
    }
    let length = detail.iter().map(|c| c * c).sum::<f64>().sqrt();
    assert!((length - 0.3).abs() < 1e-6, "{detail:?}");
}

#[test]
fn the_worst_comes_first() {
    let report = examine(&with(|f| {
        f.examples.clear();
        f.metres_per_unit = 1.0;
    }));
    let severities: Vec<Severity> = report.findings.iter().map(|f| f.severity).collect();
    assert_eq!(severities, [Severity::Warning, Severity::Note]);
}

/// Asserts that `change` makes the solve impossible, by this one error, which `solve` gives in the same words.
#[track_caller]
fn refuses(code: &str, words: &[&str], change: impl FnOnce(&mut Face)) {
    let face = with(change);
    let report = examine(&face);
    let found: Vec<(Severity, &str)> = report.findings.iter().map(|f| (f.severity, f.code)).collect();
    assert_eq!(found, [(Severity::Error, code)], "{report:#?}");
    assert!(report.has_errors());
    let message = &report.findings[0].message;
    says(message, words);
    match solve(&face, &NoProgress) {
        Err(Error::Input(said)) => assert_eq!(said, *message),
        other => panic!("{code}: {:?}", other.map(|rig| rig.vertices())),
    }
}

#[test]
fn meshes_that_are_no_surface() {
    refuses("no-faces", &["has no faces"], |f| f.neutral.faces = Faces::default());
    refuses("no-faces", &["has no faces"], |f| f.neutral = Mesh::default());
    for bad in [f64::NAN, f64::INFINITY] {
        refuses("not-finite", &["vertex 7 of the neutral mesh", "expected finite"], |f| {
            f.neutral.positions[7][1] = bad;
        });
    }
    refuses("no-area", &["no triangle", "has an area"], |f| {
        f.neutral.positions.iter_mut().for_each(|p| *p = [p[0], 0.0, 0.0]);
    });
    refuses("faces", &["the neutral mesh: face 3 has 2 corners, expected at least 3"], |f| {
        f.neutral.faces.counts[2] = 2;
    });
    refuses("faces", &["has 64 corners, expected the 65 of its faces"], |f| {
        f.neutral.faces.counts[2] = 5;
    });
    refuses("faces", &["the neutral mesh: face 2 refers to vertex 25, expected 0 to 24"], |f| {
        f.neutral.faces.indices[6] = 25;
    });
}

#[test]
fn texture_coordinates_that_do_not_fit() {
    let uvs =
        |values: usize, corners: Option<Vec<u32>>| Some(Uvs { values: vec![[0.5; 2]; values], corners });
    refuses("uvs", &["24 texture coordinates for 25 vertices"], |f| f.neutral.uvs = uvs(24, None));
    refuses("uvs", &["has 3 texture indices for 64 face corners"], |f| {
        f.neutral.uvs = uvs(25, Some(vec![0; 3]));
    });
    refuses("uvs", &["face 16 refers to texture coordinate 9, expected one of its 9"], |f| {
        let mut corners = vec![8; 64];
        corners[63] = 9;
        f.neutral.uvs = uvs(9, Some(corners));
    });
    refuses("uvs", &["texture coordinate 4", "[0.5, NaN]"], |f| {
        f.neutral.uvs = uvs(25, None);
        f.neutral.uvs.as_mut().unwrap().values[4][1] = f32::NAN;
    });
    solved(&with(|f| f.neutral.uvs = uvs(9, Some(vec![8; 64]))));
}

#[test]
fn handles_that_cannot_be() {
    refuses("no-handles", &["has no handles"], |f| f.handles = Handles::default());
    refuses("handles", &["4 labels and 5 vertices"], |f| drop(f.handles.labels.pop()));
    refuses("handle-out-of-range", &["handle c is vertex 25, expected 0 to 24", "count from 0"], |f| {
        f.handles.vertices[2] = 25;
    });
    refuses("duplicate-handle", &["handle b is listed twice"], |f| f.handles.labels[3] = "b".into());
    refuses("duplicate-handle", &["handles b and d are both vertex 4"], |f| f.handles.vertices[3] = 4);
    // The same line twice is said once.
    refuses("duplicate-handle", &["handle b is listed twice"], |f| {
        f.handles.labels[3] = "b".into();
        f.handles.vertices[3] = 4;
    });
}

#[test]
fn examples_that_do_not_fit() {
    refuses("example", &["example smile has 24 vertices", "neutral mesh has 25"], |f| {
        f.examples[0].positions.pop();
    });
    refuses("not-finite", &["vertex 3 of example smile", "inf", "expected finite"], |f| {
        f.examples[0].positions[3][0] = f64::INFINITY;
    });
}

#[test]
fn settings_that_cannot_be() {
    for length in [0.0, -1.0, 1e-154, 1e154, f64::NAN, f64::INFINITY] {
        refuses("settings", &[&format!("bending_length is {length:?}, expected a length from")], |f| {
            f.settings.bending_length = Some(length);
        });
    }
    for unit in [0.0, -0.01, f64::NAN] {
        refuses("settings", &[&format!("a unit is {unit} metres")], |f| f.metres_per_unit = unit);
    }
    refuses("settings", &["max_influences is 0"], |f| f.settings.max_influences = 0);
}

#[test]
fn strain_edges_that_cannot_be() {
    let given = |edges: &[[u32; 2]]| StrainEdges::Given(edges.to_vec());
    let words = ["strain edge 1 joins the handles 2 and 5", "two of the 5"];
    refuses("strain-edges", &words, |f| f.settings.strain_edges = given(&[[0, 1], [2, 5]]));
    refuses("strain-edges", &["1 strain edge has no length at rest: d–d;"], |f| {
        f.settings.strain_edges = given(&[[0, 1], [3, 3]]);
    });
    refuses("strain-edges", &["1 strain edge has no length at rest: a–b;"], |f| {
        f.settings.strain_edges = given(&[[0, 1], [2, 3]]);
        f.neutral.positions[4] = f.neutral.positions[0];
    });
    // What is wrong with the handles is not said of their strain edges as well.
    refuses("handles", &["0 labels and 5 vertices"], |f| {
        f.settings.strain_edges = given(&[[1, 1]]);
        f.handles.labels.clear();
    });
    let face = with(|f| {
        f.settings.strain_edges = given(&[[0, 1]]);
        f.handles.vertices[..2].copy_from_slice(&[90, 91]);
    });
    assert!(examine(&face).findings.iter().all(|f| f.code == "handle-out-of-range"));
}

#[test]
fn every_error_is_told_and_the_first_one_stops_the_solve() {
    let face = with(|f| {
        f.handles.vertices[0] = 99;
        f.settings.max_influences = 0;
        f.examples[0].positions.pop();
    });
    let codes: Vec<&str> = examine(&face).findings.iter().map(|f| f.code).collect();
    assert_eq!(codes, ["handle-out-of-range", "example", "settings"]);
    assert!(matches!(solve(&face, &NoProgress), Err(Error::Input(m)) if m.contains("vertex 99")));
}

prop_compose! {
    /// Faces with all sorts of faults: points on a coarse grid, so that many coincide or are on a line, and
    /// polygons and handles that may name any of them, or none.
    fn any_face()(
        points in prop::collection::vec(prop::array::uniform3(-2i8..3), 1..14),
        polygons in prop::collection::vec(prop::collection::vec(0u32..14, 2..7), 0..12),
        handles in prop::collection::vec(0u32..14, 0..5),
        moved in prop::collection::vec(prop::array::uniform3(-1i8..2), 0..14),
        nearest in any::<bool>(),
        sound in prop::bool::weighted(0.8),
    ) -> Face {
        let n = points.len() as u32;
        let positions: Vec<[f64; 3]> = points.iter().map(|p| p.map(f64::from)).collect();
        let mut faces = Faces::default();
        let mut handles = handles;
        for mut polygon in polygons {
            if sound {
                polygon.iter_mut().for_each(|v| *v %= n);
                polygon.resize(polygon.len().max(3), 0);
            }
            faces.push(&polygon);
        }
        if sound {
            handles.iter_mut().for_each(|v| *v %= n);
            handles.sort_unstable();
            handles.dedup();
        }
        let mut example = positions.clone();
        for (p, by) in example.iter_mut().zip(moved) {
            (0..3).for_each(|c| p[c] += 0.3 * f64::from(by[c]));
        }
        Face {
            name: "any".into(),
            neutral: Mesh { positions, faces, ..Mesh::default() },
            metres_per_unit: 0.05,
            up_axis: UpAxis::Z,
            handles: Handles { labels: (0..handles.len()).map(|h| h.to_string()).collect(), vertices: handles },
            examples: vec![Example { name: "pose".into(), positions: example, mirror: false }],
            settings: Settings {
                bind: if nearest { Bind::Nearest } else { Bind::Rigid },
                max_influences: 2,
                ..Settings::default()
            },
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn any_face_is_refused_or_gives_a_sound_rig(face in any_face()) {
        let report = examine(&face);
        let first = report.findings.first().filter(|_| report.has_errors());
        match (solve(&face, &NoProgress), first) {
            (Err(Error::Input(said)), Some(finding)) => prop_assert_eq!(said, &*finding.message),
            // Only such triangles that float64 cannot tell from flat ones.
            (Err(Error::Input(said)), None) => prop_assert!(said.contains("run the doctor"), "{said}"),
            (Ok(rig), None) => rig.cast::<f32>().check().map_err(|e| TestCaseError::fail(e.to_string()))?,
            (other, _) => prop_assert!(false, "{:?}: {report:?}", other.map(|rig| rig.vertices())),
        }
    }
}

#[test]
fn vertices_in_another_order() {
    let mut mesh = Mesh::default();
    add_sheet(&mut mesh, 15, 15, [0.0; 3]);
    // The same surface, its vertices in the order of another export.
    let shuffled = (0..225).map(|v| mesh.positions[(67 * v) % 225]).collect();
    let examples = vec![Example { name: "smile".into(), positions: shuffled, mirror: false }];
    let face = Face { neutral: mesh, examples, ..face() };
    let report = examine(&face);
    let found =
        report.findings.iter().find(|f| f.code == "vertices-in-another-order").expect("most edges are torn");
    says(&found.message, &["example smile tears", "not in the neutral's order"]);
}

#[test]
fn an_example_that_is_the_neutral() {
    let face = with(|f| f.examples[0].positions = f.neutral.positions.clone());
    finds(&face, Severity::Warning, "example-is-neutral", &["example smile is the neutral"]);
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

#[test]
fn a_handle_that_nobody_sees() {
    // A sheet bent around to a pipe with a lid at its far end, and a handle in it.
    let mut mesh = Mesh::default();
    let sides = 12;
    for ring in 0..6 {
        for side in 0..sides {
            let (sin, cos) = (f64::from(side) / f64::from(sides) * std::f64::consts::TAU).sin_cos();
            // Two skins: outside down, inside up again, joined at the mouth.
            let radius = if ring < 3 { 6.0 } else { 2.0 };
            let depth = [-45.0, -20.0, 0.0, 0.0, -20.0, -40.0][ring as usize];
            mesh.positions.push([radius * cos, radius * sin, depth]);
        }
    }
    for ring in 0..5 {
        for side in 0..sides {
            let next = (side + 1) % sides;
            mesh.faces.push(&[
                ring * sides + side,
                ring * sides + next,
                (ring + 1) * sides + next,
                (ring + 1) * sides + side,
            ]);
        }
    }
    let lid = |ring: u32| (0..sides).map(|side| ring * sides + side).collect::<Vec<u32>>();
    mesh.faces.push(&lid(5));
    mesh.faces.push(&lid(0).into_iter().rev().collect::<Vec<u32>>());
    let face = Face {
        neutral: mesh,
        handles: Handles {
            labels: ["a", "b", "c", "inside"].map(String::from).to_vec(),
            vertices: vec![12, 16, 20, 61],
        },
        examples: Vec::new(),
        ..face()
    };
    let report = examine(&face);
    let found = report.findings.iter().find(|f| f.code == "handle-inside");
    says(
        &found.expect("a handle at the bottom of a pipe").message,
        &["1 handle is not seen from outside", "inside (vertex 61)"],
    );
}

#[test]
fn a_strain_edge_across_an_opening() {
    // A strip bent to a ring that is not closed: its ends are near, the way along it is long.
    let face = with(|f| {
        for positions in [&mut f.neutral.positions, &mut f.examples[0].positions] {
            for x in positions.iter_mut() {
                let (sin, cos) = (x[0] / 16.0 * 5.8).sin_cos();
                *x = [(2.6 + 0.1 * x[2]) * sin, x[1], (2.6 + 0.1 * x[2]) * cos];
            }
        }
        f.settings.strain_edges = StrainEdges::Given(vec![[0, 1], [0, 2]]);
    });
    let report = examine(&face);
    let found = report.findings.iter().find(|f| f.code == "strain-edge-around").expect("the ends of a ring");
    says(&found.message, &["1 strain edge joins", "more than 3 times as far along the skin", ": a–b;"]);
    assert_eq!(found.severity, Severity::Warning);
}

#[test]
fn a_scan_in_another_place_and_what_is_pinned_and_moves() {
    let turned = with(|f| {
        let (sin, cos) = 4.0_f64.to_radians().sin_cos();
        for [x, y, z] in &mut f.examples[0].positions {
            [*x, *y, *z] = [cos * *x - sin * *y + 0.3, sin * *x + cos * *y, *z];
        }
    });
    let words = ["example smile is turned by 4°", "the solve takes that out (align = false would keep it)"];
    finds(&turned, Severity::Warning, "example-in-another-place", &words);
    let kept = Face { settings: Settings { align: false, ..turned.settings.clone() }, ..turned };
    finds(
        &kept,
        Severity::Warning,
        "example-in-another-place",
        &["without align = false the solve would take that out"],
    );
    let pinned = with(|f| f.settings.pins.vertices = vec![11, 13]);
    finds(
        &pinned,
        Severity::Warning,
        "pinned-moves",
        &["example smile moves vertex 13, which is pinned, by 0.4 mesh units"],
    );
    let face = with(|f| f.settings.pins.vertices = vec![25]);
    assert_eq!(examine(&face).findings[0].code, "pins");
}
