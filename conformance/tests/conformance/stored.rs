//! A rig with its weights in 16 bits: it rests where it rests, meets its markers, and moves no vertex further
//! than the bound says.
use rhytid_conformance::evaluate;
use rhytid_core::{BandWeights, BasisStorage, ClusteredBasis, NoProgress, Rig, SurfacePoint, VertexId};
use rhytid_kernels::tile::TILE;
use rhytid_solve::solve;

/// A rig of the learned method. Ten of its handles lie within triangles, where the weights of the corners are
/// not zero.
fn rig() -> Rig {
    let mut face = rhytid_demo::face(3_000);
    let triangles = solve(&face, &NoProgress).unwrap().surface().triangles.clone();
    for point in face.handles.points.iter_mut().take(10) {
        let vertex = point.vertex().unwrap().0;
        let triangle = triangles.iter().find(|t| t.contains(&vertex)).unwrap();
        *point = SurfacePoint::new(triangle.map(VertexId), [0.5, 0.3, 0.2]).unwrap();
    }
    let rig = solve(&face, &NoProgress).unwrap().rounded().unwrap();
    assert!(rig.vector_wrinkles() && !rig.learned().unwrap().example_weights.is_empty());
    rig
}

/// Displacements of the handles that no pose has, at most 1 long: `waves(i)` for number i.
fn moved(rig: &Rig, size: f64, waves: impl Fn(usize) -> f64) -> Vec<[f64; 3]> {
    let along = |i: usize| size / 3.0_f64.sqrt() * waves(i);
    let rest = rig.handles().rest.iter().enumerate();
    rest.map(|(h, x)| std::array::from_fn(|c| f64::from(x[c]) + along(3 * h + c))).collect()
}

fn farthest(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let along = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max);
    a.iter().zip(b).map(along).fold(0.0, f64::max)
}

#[test]
fn weights_in_16_bits_keep_rest_and_markers_and_the_bound() {
    let rig = rig();
    // Its basis is the rig's own.
    let stored = rig.clone().as_stored(BasisStorage::Clustered).unwrap();
    assert_eq!(stored.basis(), rig.basis());
    assert_eq!(stored.clone().as_stored(BasisStorage::Clustered).unwrap(), stored);
    assert_eq!(rig.clone().as_stored(BasisStorage::F32).unwrap(), rig);
    let motion = BasisStorage::motion(&rig);
    let of_basis = ClusteredBasis::new(&rig).largest_error() * motion;
    let bound = BasisStorage::Clustered.largest_error(&rig) - of_basis;
    let (exact, stored) = (rig.widened(), stored.widened());

    let at_rest = evaluate(&stored, &moved(&rig, 0.0, |_| 0.0));
    let rest: Vec<[f64; 3]> = exact.surface().rest.clone();
    assert!(farthest(&at_rest.positions, &rest) < 2e-6, "{}", farthest(&at_rest.positions, &rest));

    let mut largest = 0.0_f64;
    for k in 0..12 {
        let size = motion * [0.1, 0.5, 1.0][k % 3];
        let positions = moved(&rig, size, |i| (i as f64 * (0.7 + 0.31 * k as f64)).sin());
        let [whole, narrow] = [&exact, &stored].map(|rig| evaluate(rig, &positions));
        for (point, position) in rig.handles().points.iter().zip(&positions) {
            let at = point.at(&narrow.positions);
            assert!(farthest(&[at], &[*position]) < 2e-6, "{at:?}, {position:?}");
        }
        let off = farthest(&whole.large_scale, &narrow.large_scale);
        assert!(off <= bound + 1e-6, "{off} for a motion of {size}, a bound of {bound}");
        largest = largest.max(off);
        // A distance of the wrinkles is off by a 4096th of itself, which the bound leaves out, and w by less.
        let details = farthest(&whole.detail, &narrow.detail);
        assert!(details < bound, "{details}");
    }
    println!("weights in 16 bits: off by {largest:.1e} cm at most, a bound of {bound:.1e} cm");
    assert!(largest > bound / 300.0, "{largest}, a bound of {bound}");
    assert!(bound < 3.0 * ClusteredBasis::LARGEST_ERROR * motion, "{bound}");
    // Nearly every tile has integers.
    let narrow = BandWeights::new(&rig, BasisStorage::Clustered).narrow_part();
    assert!(narrow > 0.75, "{narrow}");
}

/// What devices keep are the numbers of the stored rig, to the bit, whether they are integers or not.
#[test]
fn tiles_have_the_numbers_of_the_stored_rig() {
    let rig = rig();
    for storage in [BasisStorage::F32, BasisStorage::Clustered] {
        let kept = BandWeights::new(&rig, storage);
        let expected = rig.clone().as_stored(storage).unwrap().band_weights();
        let (mut narrow, mut wide) = (0, 0);
        for tile in 0..rig.vertices().div_ceil(TILE) {
            let vectors = kept.tile(tile);
            let mut rows: Vec<[f32; TILE]> =
                vectors.singles().iter().map(|row| row.map(f32::from_bits)).collect();
            if let Some((units, integers)) = vectors.integers() {
                for (i, row) in integers.iter().enumerate() {
                    rows.push(row.map(|x| units[i / 3] * f32::from(x)));
                }
                narrow += 1;
            } else {
                wide += 1;
            }
            for v in tile * TILE..((tile + 1) * TILE).min(rig.vertices()) {
                let of_vertex: Vec<f32> = rows.iter().map(|row| row[v % TILE]).collect();
                assert!(of_vertex == expected.row(v).as_flattened(), "vertex {v}");
            }
        }
        println!("{storage:?}: {narrow} tiles of integers, {wide} of fp32, {} bytes", kept.bytes());
        // Corners of handles within triangles keep fp32, and most others do not.
        if storage == BasisStorage::Clustered {
            assert!(wide > 5 && narrow > wide, "{narrow}, {wide}");
            assert!((kept.narrow_part() - f64::from(narrow) / f64::from(narrow + wide)).abs() < 1e-9);
        }
    }
}
