//! Handles inside triangles: the shell against a dense solution of the same problem, and what must hold.
use faer::Mat;
use faer::linalg::solvers::Solve;
use rhytid_core::{Face, NoProgress, SurfacePoint, VertexId};
use rhytid_geometry::laplacian::laplacian;
use rhytid_geometry::triangulate;
use rhytid_solve::{Severity, System, examine, solve};
use rhytid_test_support::sheet::{SIDE, add_sheet, face};

/// A sheet of 12 × 9 vertices with some of its handles inside triangles, on edges and at vertices.
fn sheet() -> Face {
    let mut face = face();
    face.neutral = rhytid_core::Mesh::default();
    add_sheet(&mut face.neutral, 12, 9, [0.0; 3]);
    for (v, x) in face.neutral.positions.iter_mut().enumerate() {
        x[2] += 0.7 * (0.4 * x[0] + 0.01 * v as f64).sin();
    }
    face.examples.clear();
    let inside = |corners: [u32; 3], weights| SurfacePoint::new(corners.map(VertexId), weights).unwrap();
    let points = [
        ("corner", VertexId(0).into()),
        ("inside", inside([14, 15, 27], [0.2, 0.5, 0.3])),
        // A corner is shared with the last, and both are near the same vertex.
        ("beside", inside([27, 28, 40], [0.6, 0.2, 0.2])),
        ("in one", inside([60, 61, 73], [0.7, 0.2, 0.1])),
        ("triangle", inside([60, 61, 73], [0.1, 0.2, 0.7])),
        ("on an edge", inside([81, 82, 82], [0.5, 0.25, 0.25])),
        ("at its end", VertexId(82).into()),
        ("far", VertexId(107).into()),
    ];
    face.handles.labels = points.iter().map(|(label, _)| (*label).to_owned()).collect();
    face.handles.points = points.iter().map(|(_, point)| *point).collect();
    face.settings.bending_length = Some(6.0);
    face
}

/// The displacements of least energy that meet the handles, by a dense solution of `[A Wᵀ; W 0]`.
fn dense(face: &Face) -> Mat<f64> {
    let (v, h) = (face.neutral.positions.len(), face.handles.len());
    let system = System::new(laplacian(&face.neutral.positions, &triangulate(&face.neutral)), 6.0);
    let mut matrix = Mat::zeros(v + h, v + h);
    let mut values = Vec::new();
    for row in 0..v {
        system.row(row as u32, &mut values);
        for (column, value) in system.pattern().neighbors(row as u32).iter().zip(&values) {
            matrix[(row, *column as usize)] = *value;
        }
    }
    for (i, point) in face.handles.points.iter().enumerate() {
        for (corner, weight) in point.corners() {
            matrix[(v + i, corner.index())] = weight;
            matrix[(corner.index(), v + i)] = weight;
        }
    }
    let right = Mat::from_fn(v + h, h, |i, j| f64::from(u8::from(i == v + j)));
    matrix.partial_piv_lu().solve(&right)
}

#[test]
fn the_shell_is_the_one_of_least_energy() {
    let face = sheet();
    let expected = dense(&face);
    let rig = solve(&face, &NoProgress).unwrap();
    for (v, row) in rig.basis().rows().enumerate() {
        for (h, b) in row.iter().enumerate() {
            let expected = expected[(v, h)];
            assert!((b - expected).abs() < 1e-9, "vertex {v}, handle {h}: {b} instead of {expected}");
        }
    }
}

#[test]
fn a_point_that_comes_near_a_vertex_becomes_it() {
    let mut face = sheet();
    face.handles.points[1] = VertexId(15).into();
    let expected = solve(&face, &NoProgress).unwrap();
    let mut last = f64::INFINITY;
    for off in [1e-1, 1e-2, 1e-3] {
        face.handles.points[1] =
            SurfacePoint::new([14, 15, 27].map(VertexId), [off, 1.0 - 2.0 * off, off]).unwrap();
        let found = solve(&face, &NoProgress).unwrap();
        let pairs = found.basis().as_slice().iter().zip(expected.basis().as_slice());
        let apart = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 0.2 * last && apart < 3.0 * off, "{off}: {apart}");
        last = apart;
    }
}

/// Examples whose handles move anyhow.
fn with_examples(mut face: Face) -> Face {
    let rest = face.neutral.positions.clone();
    for p in 0..5 {
        let wave = |x: &[f64; 3]| {
            let (a, b) = (0.3 * x[0] + f64::from(p), 0.25 * x[1] - 0.7 * f64::from(p));
            [x[0] + 0.4 * a.sin(), x[1] + 0.3 * (a * b).cos(), x[2] + 1.2 * (a + b).sin()]
        };
        let (name, positions) = (format!("pose {p}"), rest.iter().map(wave).collect());
        face.examples.push(rhytid_core::Example { name, positions, mirror: false, noise: Some(0.0) });
    }
    face.settings.align = false;
    face
}

#[test]
fn the_band_is_learned_at_the_corners_too_and_its_mean_is_nothing() {
    let rig = solve(&with_examples(sheet()), &NoProgress).unwrap();
    let learned = rig.learned().unwrap();
    for (label, point) in rig.handles().labels.iter().zip(&rig.handles().points) {
        let mut largest = 0.0_f64;
        let mut means = [0.0_f64; 2];
        for i in 0..learned.feature_gains.columns() {
            let gains: Vec<f64> =
                point.corners().map(|(v, w)| w * learned.feature_gains.row(v.index())[i]).collect();
            largest = gains.iter().fold(largest, |most, gain| most.max(gain.abs()));
            means[0] = means[0].max(gains.iter().sum::<f64>().abs());
        }
        for i in 0..rig.centers() {
            let mean = point.mean(|v| rig.fine_scale().rbf_weights.row(v.index())[i]);
            means[1] = mean.iter().fold(means[1], |most, x| most.max(x.abs()));
        }
        assert!(means.iter().all(|mean| *mean < 1e-10), "{point}: {means:?}");
        // The other end of the edge is a handle, so both of its ends are held.
        let is_free = point.vertex().is_none() && label != "on an edge";
        assert_eq!(largest > 1e-3, is_free, "{label}: {largest}");
    }
}

#[test]
fn a_corner_that_moves_where_its_handle_hardly_does_has_no_wrinkles() {
    let mut face = sheet();
    face.handles.points[1] = SurfacePoint::new([14, 15, 27].map(VertexId), [4e-6, 0.7, 0.3 - 4e-6]).unwrap();
    let mut positions = face.neutral.positions.clone();
    positions[14][2] += 1.0;
    face.examples.push(rhytid_core::Example {
        name: "bump".into(),
        positions,
        mirror: false,
        noise: Some(0.0),
    });
    face.settings.align = false;
    let rig = solve(&face, &NoProgress).unwrap();
    let weights = rig.fine_scale().rbf_weights.as_slice().as_flattened();
    let largest = weights.iter().fold(0.0_f64, |most, w| most.max(w.abs()));
    assert!(largest < 1e3, "{largest}");
    rig.rounded().unwrap();
}

#[test]
fn handles_that_cannot_be_met_are_told() {
    let inside = |corners: [u32; 3], weights| SurfacePoint::new(corners.map(VertexId), weights).unwrap();
    let refused = |code: &str, words: &[&str], change: &dyn Fn(&mut Face)| {
        let mut face = face();
        change(&mut face);
        let report = examine(&face);
        let found: Vec<_> = report.findings.iter().filter(|f| f.severity == Severity::Error).collect();
        assert!(found.len() == 1 && found[0].code == code, "{report:?}");
        assert!(words.iter().all(|word| found[0].message.contains(word)), "{}", found[0].message);
        assert!(solve(&face, &NoProgress).is_err());
    };
    refused("handle-on-no-face", &["b (vertices 0, 1 and 12)", "one face"], &|face| {
        face.handles.points[1] = inside([0, 1, 12], [0.3, 0.3, 0.4]);
    });
    refused("handle-out-of-range", &["handle b is at vertex 25"], &|face| {
        face.handles.points[1] = inside([0, 1, 25], [0.3, 0.3, 0.4]);
    });
    refused("handles-too-near", &["c (vertices 6, 7 and 12)"], &|face| {
        face.handles.points[1] = inside([6, 7, 12], [0.3, 0.3, 0.4]);
        face.handles.points[2] = inside([6, 7, 12], [0.301, 0.3, 0.399]);
    });
    // Four in one triangle.
    refused("handles-too-near", &["1 handle is"], &|face| {
        for (h, weights) in
            [[0.6, 0.2, 0.2], [0.2, 0.6, 0.2], [0.2, 0.2, 0.6], [0.4, 0.4, 0.2]].iter().enumerate()
        {
            face.handles.points[h] = inside([6, 7, 12], *weights);
        }
    });
    refused("rotations", &["rotations = true", "inside a triangle: b"], &|face| {
        face.settings.rotations = true;
        face.handles.points[1] = inside([6, 7, 12], [0.3, 0.3, 0.4]);
    });
    // The corners of a quad need not be those of one of its triangles.
    let mut across = face();
    across.handles.points[1] = inside([1, 2, 1 + SIDE], [0.3, 0.3, 0.4]);
    assert!(solve(&across, &NoProgress).is_ok());
}
