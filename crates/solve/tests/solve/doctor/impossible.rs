//! Faces that cannot be solved and are refused.

use super::*;
use rhytid_core::{Faces, HandleId, Prior, VertexId};

/// Asserts that `change` makes the solve impossible, with exactly this error. `solve` gives it in the same
/// words.
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
        Err(Error::Input(said)) => assert_eq!(said.sentence(), *message),
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
    refuses("handles", &["4 labels and 5 points"], |f| drop(f.handles.labels.pop()));
    refuses("handle-out-of-range", &["handle c is at vertex 25, expected 0 to 24", "count from 0"], |f| {
        f.handles.points[2] = VertexId(25).into();
    });
    refuses("duplicate-handle", &["handle b is listed twice"], |f| f.handles.labels[3] = "b".into());
    refuses("duplicate-handle", &["handles b and d are both vertex 4"], |f| {
        f.handles.points[3] = VertexId(4).into();
    });
    // The same line twice is reported once.
    refuses("duplicate-handle", &["handle b is listed twice"], |f| {
        f.handles.labels[3] = "b".into();
        f.handles.points[3] = VertexId(4).into();
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
    for noise in [-1.0, f64::NAN, 1e4] {
        let words = format!("the noise of example smile is {noise}, expected millimetres");
        refuses("settings", &[&words], |f| f.examples[0].noise = Some(noise));
    }
}

#[test]
fn priors_that_cannot_be() {
    let prior = |f: &Face, weight| Some(Prior { expressions: f.examples.clone(), weight });
    refuses("prior", &["the prior's weight is 1.5, expected 0 to 1"], |f| f.prior = prior(f, Some(1.5)));
    refuses("prior", &["the chapter's method learns nothing from a prior"], |f| {
        f.prior = prior(f, None);
        f.settings.method = Method::Chapter;
    });
    refuses("prior", &["rotations do not go with a prior"], |f| {
        f.prior = prior(f, None);
        f.settings.rotations = true;
    });
    refuses("example", &["the prior's smile has 24 vertices"], |f| {
        f.prior = prior(f, None);
        f.prior.as_mut().unwrap().expressions[0].positions.pop();
    });
}

#[test]
fn strain_edges_that_cannot_be() {
    let given =
        |edges: &[[u32; 2]]| StrainEdges::Given(edges.iter().map(|pair| pair.map(HandleId)).collect());
    let words = ["strain edge 1 joins the handles 2 and 5", "two of the 5"];
    refuses("strain-edges", &words, |f| f.settings.strain_edges = given(&[[0, 1], [2, 5]]));
    refuses("strain-edges", &["1 strain edge has no length at rest: d–d;"], |f| {
        f.settings.strain_edges = given(&[[0, 1], [3, 3]]);
    });
    refuses("strain-edges", &["1 strain edge has no length at rest: a–b;"], |f| {
        f.settings.strain_edges = given(&[[0, 1], [2, 3]]);
        f.neutral.positions[4] = f.neutral.positions[0];
    });
    // A fault of the handles is not reported for their strain edges too.
    refuses("handles", &["0 labels and 5 points"], |f| {
        f.settings.strain_edges = given(&[[1, 1]]);
        f.handles.labels.clear();
    });
    let face = with(|f| {
        f.settings.strain_edges = given(&[[0, 1]]);
        f.handles.points[..2].copy_from_slice(&[90, 91].map(|v| VertexId(v).into()));
    });
    assert!(examine(&face).findings.iter().all(|f| f.code == "handle-out-of-range"));
}

#[test]
fn every_error_is_told_and_the_first_one_stops_the_solve() {
    let face = with(|f| {
        f.handles.points[0] = VertexId(99).into();
        f.settings.max_influences = 0;
        f.examples[0].positions.pop();
    });
    let codes: Vec<&str> = examine(&face).findings.iter().map(|f| f.code).collect();
    assert_eq!(codes, ["handle-out-of-range", "example", "settings"]);
    assert!(matches!(solve(&face, &NoProgress), Err(Error::Input(m)) if m.sentence().contains("vertex 99")));
}

prop_compose! {
    /// Faces with all sorts of faults.
    ///
    /// Points are on a coarse grid, so many coincide or are on a line. Polygons and handles may name any
    /// points, or none.
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
        let pose = Example { name: "pose".into(), positions: example, mirror: false, noise: None };
        Face {
            name: "any".into(),
            neutral: Mesh { positions, faces, ..Mesh::default() },
            metres_per_unit: 0.05,
            up_axis: UpAxis::Z,
            handles: Handles {
                labels: (0..handles.len()).map(|h| h.to_string()).collect(),
                points: handles.into_iter().map(|v| VertexId(v).into()).collect(),
            },
            prior: nearest.then(|| Prior { expressions: vec![pose.clone()], weight: None }),
            examples: vec![pose],
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
            (Err(Error::Input(said)), Some(finding)) => prop_assert_eq!(said.sentence(), &*finding.message),
            // Only triangles that float64 cannot tell from flat ones.
            (Err(Error::Input(said)), None) => prop_assert!(said.sentence().contains("run the doctor"), "{said}"),
            (Ok(rig), None) => {
                rig.rounded().map_err(|e| TestCaseError::fail(e.to_string()))?;
            }
            (other, _) => prop_assert!(false, "{:?}: {report:?}", other.map(|rig| rig.vertices())),
        }
    }
}
