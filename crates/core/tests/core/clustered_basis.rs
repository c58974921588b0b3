//! The factors of a basis in clusters: near the basis everywhere, and the basis itself where handles are.

use rhytid_core::{BasisStorage, ClusteredBasis, NoProgress, Rig, SurfacePoint, Table, VertexId};
use rhytid_solve::solve;
use rhytid_test_support::changed;

fn rig(vertices: usize) -> Rig {
    solve(&rhytid_demo::face(vertices), &NoProgress).unwrap().rounded().unwrap()
}

/// The largest sum of a row's differences, in float64, without the product of [`ClusteredBasis::product`].
fn largest_difference(rig: &Rig, clusters: &ClusteredBasis) -> f64 {
    let mut largest = 0.0_f64;
    for v in 0..rig.vertices() {
        let cluster = &clusters.clusters()[v / ClusteredBasis::VERTICES];
        let mut row: Vec<f64> = rig.basis().row(v).iter().map(|&b| f64::from(b)).collect();
        for (column, factors) in cluster.columns.iter().zip(&cluster.rows) {
            let c = f64::from(column[v % ClusteredBasis::VERTICES]);
            row.iter_mut().zip(factors).for_each(|(b, &w)| *b -= c * f64::from(w));
        }
        largest = largest.max(row.iter().map(|x| x.abs()).sum());
    }
    largest
}

#[test]
fn no_row_is_farther_from_the_basis_than_the_bound() {
    let rig = rig(5_000);
    let clusters = ClusteredBasis::new(&rig);
    let largest = largest_difference(&rig, &clusters);
    assert!(largest < ClusteredBasis::LARGEST_ERROR + 1e-6, "{largest}");
    assert!((largest - clusters.largest_error()).abs() < 1e-6, "{largest}, {}", clusters.largest_error());
    // The weights of the bands add to it.
    let of_all = BasisStorage::Clustered.largest_error(&rig) / BasisStorage::motion(&rig);
    assert!(of_all > clusters.largest_error() && of_all < 4.0 * ClusteredBasis::LARGEST_ERROR, "{of_all}");
    // Near the bound: a tenth of it would take more rows.
    assert!(largest > 0.5 * ClusteredBasis::LARGEST_ERROR, "{largest}");
    let dense = 4 * rig.vertices() * rig.handles().len();
    assert!(clusters.bytes() < dense * 6 / 10, "{} of {dense} bytes", clusters.bytes());
    assert_eq!(clusters, ClusteredBasis::new(&rig));
}

#[test]
fn vertices_of_handles_have_their_own_rows() {
    let rig = rig(5_000);
    let product = ClusteredBasis::new(&rig).product();
    for point in &rig.handles().points {
        let v = point.vertex().unwrap().index();
        assert_eq!(product.row(v), rig.basis().row(v), "vertex {v}");
    }
}

/// The corners of a handle within a triangle have rows of other sizes than 1.
#[test]
fn corners_of_handles_within_triangles_have_their_own_rows() {
    let mut face = rhytid_demo::face(5_000);
    let triangles = rig(5_000).surface().triangles.clone();
    for point in face.handles.points.iter_mut().take(10) {
        let vertex = point.vertex().unwrap().0;
        let triangle = triangles.iter().find(|t| t.contains(&vertex)).unwrap();
        *point = SurfacePoint::new(triangle.map(VertexId), [0.5, 0.3, 0.2]).unwrap();
    }
    let rig = solve(&face, &NoProgress).unwrap().rounded().unwrap();
    let product = ClusteredBasis::new(&rig).product();
    let mut inside = 0;
    for point in &rig.handles().points {
        inside += usize::from(point.vertex().is_none());
        for (v, _) in point.corners() {
            let rows = product.row(v.index()).iter().zip(rig.basis().row(v.index()));
            let difference: f32 = rows.map(|(a, b)| (a - b).abs()).sum();
            assert!(difference < 1e-6, "vertex {}: {difference}", v.0);
        }
    }
    assert_eq!(inside, 10);
}

/// Rows and columns as few as the basis needs: one for a basis of rank 1, and none too few.
#[test]
fn a_basis_of_low_rank_has_few_rows() {
    let rig = rig(1_000);
    let handles = rig.handles().len();
    let outer = |v: usize, h: usize| (1.0 + (v % 97) as f32) / 97.0 * (h as f32 - 7.0) / 100.0;
    let entries = (0..rig.vertices()).flat_map(|v| (0..handles).map(move |h| outer(v, h)));
    let basis = Table::new(rig.vertices(), handles, entries.collect());
    let rig = changed(&rig, |parts| {
        parts.basis = basis;
        parts.handles.points.truncate(handles);
    })
    .unwrap();
    let clusters = ClusteredBasis::new(&rig);
    assert!(largest_difference(&rig, &clusters) <= ClusteredBasis::LARGEST_ERROR);
    // A row for each vertex that a handle holds, since it is taken whether it is needed or not, and one for
    // the rounding.
    let held = |i: usize| {
        let of = |v: usize| v / ClusteredBasis::VERTICES == i;
        rig.handles().held().filter(|v| of(v.index())).count()
    };
    for (i, cluster) in clusters.clusters().iter().enumerate() {
        assert!(cluster.rows.len() <= held(i).max(1) + 1, "{} rows", cluster.rows.len());
    }
    assert_eq!(clusters.rows(), clusters.clusters().iter().map(|cluster| cluster.rows.len()).sum::<usize>());
}

/// Numbers that are too large for the bound in fp32 end the search, and the error is said.
#[test]
fn a_basis_of_huge_numbers_ends() {
    let rig = changed(&rig(1_000), |parts| parts.basis = parts.basis.map(|b| 5e5 * (b + 0.1))).unwrap();
    let clusters = ClusteredBasis::new(&rig);
    assert!(clusters.largest_error() > ClusteredBasis::LARGEST_ERROR);
    assert!(clusters.largest_error().is_finite());
}
