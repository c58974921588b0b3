//! The findings of the mesh doctor for faces that are broken on purpose, in one way at a time.

mod examples;
mod handles;
mod impossible;
mod parts;
mod space;
mod surface;

use proptest::prelude::*;
use rhytid_core::{
    Bind, Error, Example, Face, Handles, Mesh, Method, NoProgress, Rig, Settings, StrainEdges, UpAxis, Uvs,
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

/// Asserts that the doctor finds exactly this, that the message has each of `words`, and that the face can be
/// solved.
#[track_caller]
fn finds(face: &Face, severity: Severity, code: &str, words: &[&str]) {
    let report = examine(face);
    let found: Vec<(Severity, &str)> = report.findings.iter().map(|f| (f.severity, f.code)).collect();
    assert_eq!(found, [(severity, code)], "{report:#?}");
    says(&report.findings[0].message, words);
    solved(face).rounded().unwrap();
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

#[test]
fn the_worst_comes_first() {
    let report = examine(&with(|f| {
        f.examples.clear();
        f.metres_per_unit = 1.0;
    }));
    let severities: Vec<Severity> = report.findings.iter().map(|f| f.severity).collect();
    assert_eq!(severities, [Severity::Warning, Severity::Note]);
}
