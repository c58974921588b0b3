//! Skin that is opposite other skin is recognised, and knows how near it may come.
use rhytid_core::{Face, Method, NoProgress, Openings, SurfacePoint, VertexId};
use rhytid_kernels::vec3;
use rhytid_solve::solve;
use rhytid_test_support::lips::{self, COLUMNS, HANDLES, ROWS, UPPER, at, opposite};
use std::collections::BTreeSet;

fn recognised(face: &Face) -> Openings<f64> {
    let rig = solve(face, &NoProgress).unwrap();
    rig.learned().map(|learned| learned.contact.openings.clone()).unwrap_or_default()
}

fn row(v: VertexId) -> usize {
    v.index() / COLUMNS
}

#[test]
fn lips_are_opposite_each_other() {
    let face = lips::face();
    let openings = recognised(&face);
    let rims: BTreeSet<usize> = openings.rims.iter().map(|rim| rim.vertex.index()).collect();
    for (row, column) in UPPER.flat_map(|row| (0..COLUMNS).map(move |column| (row, column))) {
        for v in [at(row, column), at(opposite(row), column)] {
            assert!(rims.contains(&v), "row {row}, column {column}");
        }
    }
    for (i, rim) in openings.rims.iter().enumerate() {
        // The front of a lip is opposite nothing, nor are the sides of its groove: the way around is short.
        assert!((HANDLES + 1..ROWS - HANDLES - 1).contains(&row(rim.vertex)), "{rim:?}");
        let across = rim.across.iter().filter(|other| **other as usize != i);
        let across: Vec<usize> = across.map(|other| row(openings.rims[*other as usize].vertex)).collect();
        assert!(!across.is_empty());
        let is_upper = |row: usize| row < ROWS / 2;
        let own = row(rim.vertex);
        assert!(across.iter().all(|other| is_upper(*other) != is_upper(own)), "{own} to {across:?}");
        assert!((-0.015..0.0).contains(&rim.least_gap) && rim.reach > 0.2 && rim.reach < 1.0, "{rim:?}");
        // Those across are not all from one place. The reach is 2.5 edges long.
        let place = |i: u32| face.neutral.positions[openings.rims[i as usize].vertex.index()];
        let across: BTreeSet<u32> = rim.across.into_iter().filter(|other| *other as usize != i).collect();
        for (a, b) in across.iter().flat_map(|a| across.range(..a).map(move |b| (*a, *b))) {
            let apart = vec3::length(vec3::sub(place(a), place(b)));
            assert!(apart > 0.7 * rim.reach / 2.5, "{rim:?}: {apart}");
        }
    }
}

#[test]
fn followers_are_the_skin_around_without_handles() {
    let face = lips::face();
    let openings = recognised(&face);
    let held: Vec<VertexId> = face.handles.points.iter().filter_map(SurfacePoint::vertex).collect();
    let rims: BTreeSet<VertexId> = openings.rims.iter().map(|rim| rim.vertex).collect();
    let mut followed = BTreeSet::new();
    for follower in &openings.followers {
        assert!(!held.contains(&follower.vertex));
        assert!(followed.insert(follower.vertex), "{follower:?} is there twice");
        let sum: f64 = follower.weights.iter().sum();
        assert!(sum > 0.0 && sum <= 1.0 + 1e-9, "{follower:?}");
        if rims.contains(&follower.vertex) {
            assert_eq!(openings.rims[follower.leaders[0] as usize].vertex, follower.vertex);
            // It takes all of its own step, but less near a handle.
            let is_near_handle = (follower.vertex.index() % COLUMNS).is_multiple_of(3);
            assert!(is_near_handle || sum > 0.85, "{follower:?}");
        }
    }
    assert!(rims.iter().all(|rim| followed.contains(rim)));
    // The front of a lip follows a little.
    assert!(followed.contains(&VertexId::from_index(at(HANDLES + 1, 5))));
}

#[test]
fn nothing_is_recognised_where_nothing_is_opposite() {
    let without = |change: fn(&mut Face)| {
        let mut face = lips::face();
        change(&mut face);
        assert_eq!(recognised(&face), Openings::default());
    };
    without(|face| face.settings.contact.openings = false);
    without(|face| face.settings.method = Method::Chapter);
    // The outside turned in: skin that is back to back.
    without(|face| {
        for pose in [&mut face.neutral.positions, &mut face.examples[0].positions] {
            pose.iter_mut().for_each(|x| x[0] = -x[0]);
        }
    });
    // An open mouth.
    without(|face| face.neutral.positions = face.examples[0].positions.clone());
    // Lips that an example draws through each other.
    without(|face| {
        for v in opposite(UPPER.end - 1) * COLUMNS..ROWS * COLUMNS {
            face.examples[0].positions[v][1] = face.neutral.positions[v][1] + 0.4;
        }
    });
}

#[test]
fn the_unit_does_not_matter() {
    let face = lips::face();
    let mut large = face.clone();
    large.metres_per_unit *= 0.125;
    for pose in [&mut large.neutral.positions, &mut large.examples[0].positions] {
        pose.iter_mut().flatten().for_each(|x| *x *= 8.0);
    }
    let [small, large] = [&face, &large].map(recognised);
    assert_eq!(small.followers, large.followers);
    assert_eq!(small.rims.len(), large.rims.len());
    for (small, large) in small.rims.iter().zip(&large.rims) {
        assert_eq!((small.vertex, small.across), (large.vertex, large.across));
        assert_eq!((8.0 * small.reach, 8.0 * small.least_gap), (large.reach, large.least_gap));
    }
}
