//! Handles spread over the faces of different makers: even, symmetric, and on the front of the face alone.
use super::handles::face;
use glam::DVec3;
use rhytid_core::{Face, UpAxis, VertexId};
use rhytid_geometry::triangulate;
use rhytid_solve::Skin;
use rhytid_test_support::shared;

/// Where a face's front is on a head, read off its neutral by eye, in mesh units.
struct Front {
    /// The underside of the chin, and the hairline, along y.
    height: [f64; 2],
    /// The front edge of the ears, along z.
    ears: f64,
    /// The plane between its sides, along x.
    middle: f64,
}

/// Where the handles of a spread are.
fn places(face: &Face, spread: &[VertexId]) -> Vec<DVec3> {
    spread.iter().map(|v| DVec3::from_array(face.neutral.positions[v.index()])).collect()
}

/// Whether a ray that leaves the mesh at `from` towards `to` meets no triangle.
fn is_open(from: DVec3, to: DVec3, triangles: &[[DVec3; 3]], size: f64) -> bool {
    let from = from + 1e-3 * size * to;
    triangles.iter().all(|&[a, b, c]| {
        let (ab, ac) = (b - a, c - a);
        let normal = to.cross(ac);
        let determinant = ab.dot(normal);
        if determinant.abs() < 1e-12 * size * size {
            return true;
        }
        let (along, off) = (from - a, 1.0 / determinant);
        let u = along.dot(normal) * off;
        let q = along.cross(ab);
        let v = to.dot(q) * off;
        u < 0.0 || v < 0.0 || u + v > 1.0 || ac.dot(q) * off < 0.0
    })
}

fn check(face: &Face, front: &Front, count: usize) {
    let skin = Skin::from_face(face).unwrap();
    let spread = skin.spread(count, &[]);
    let name = format!("{} with {} examples, {count} handles", face.name, face.examples.len());
    assert!((count - 1..=count).contains(&spread.len()), "{name}: {}", spread.len());
    let all = places(face, &spread);

    // Even: no two are nearer than half the median distance.
    let mut nearest: Vec<f64> = (0..all.len())
        .map(|i| {
            let others = (0..all.len()).filter(|&j| j != i);
            others.map(|j| all[i].distance(all[j])).fold(f64::INFINITY, f64::min)
        })
        .collect();
    nearest.sort_by(f64::total_cmp);
    let median = nearest[nearest.len() / 2];
    assert!(nearest[0] >= 0.5 * median, "{name}: {nearest:?}");
    // A hole in the pattern would leave some handle alone.
    assert!(nearest[nearest.len() - 1] < 2.5 * median, "{name}: {nearest:?}");

    // Symmetric, with handles in the middle.
    let millimetre = 1e-3 / face.metres_per_unit;
    for place in &all {
        let image = DVec3::new(2.0 * front.middle - place.x, place.y, place.z);
        let off = all.iter().map(|other| other.distance(image)).fold(f64::INFINITY, f64::min);
        assert!(off < millimetre, "{name}: {place} has no mirror image within {off}");
    }
    let in_middle = all.iter().filter(|place| (place.x - front.middle).abs() < millimetre).count();
    assert!(in_middle >= 3, "{name}: {in_middle} in the middle");

    // On the front alone.
    for place in &all {
        assert!((front.height[0]..front.height[1]).contains(&place.y), "{name}: {place}");
        assert!(place.z > front.ears, "{name}: {place}");
    }
    // All over it: the mean is near the middle of the front, and each quarter of its height has its share.
    let step = 0.25 * (front.height[1] - front.height[0]);
    for quarter in 0..3 {
        let low = front.height[0] + f64::from(quarter) * step;
        let share = all.iter().filter(|place| (low..low + step).contains(&place.y)).count();
        assert!(share * 10 >= all.len(), "{name}: {share} handles in quarter {quarter}");
    }

    // A marker there is seen from somewhere in front: not in the mouth, in a nostril or behind a lid.
    let [low, high] = face.neutral.bounds().unwrap().map(DVec3::from_array);
    let corners = |t: [u32; 3]| t.map(|v| DVec3::from_array(face.neutral.positions[v as usize]));
    let triangles: Vec<[DVec3; 3]> = triangulate(&face.neutral).into_iter().map(corners).collect();
    for place in &all {
        let side = (place.x - front.middle).signum();
        let mut looks =
            [[0.0, 0.0, 1.0], [side, 0.0, 1.0], [side, 0.0, 0.2], [0.0, -1.0, 1.0], [0.0, 1.0, 1.0]]
                .map(|to| DVec3::from_array(to).normalize())
                .into_iter();
        let is_seen = looks.any(|to| is_open(*place, to, &triangles, low.distance(high)));
        assert!(is_seen, "{name}: {place} is not seen");
    }

    // Left and right have one number, and every label is its own.
    let mut labels = skin.labels(&spread);
    for (label, place) in labels.iter().zip(&all) {
        let side = place.x - front.middle;
        assert!(!label.ends_with("_l") || side > 0.0, "{name}: {label}");
        assert!(!label.ends_with("_r") || side < 0.0, "{name}: {label}");
    }
    labels.sort();
    labels.dedup();
    assert_eq!(labels.len(), spread.len(), "{name}");
}

#[test]
fn handles_are_spread_over_the_front_of_every_face() {
    let Some(shared) = shared("") else { return };
    let ict = || Front { height: [-9.8, 11.0], ears: 2.0, middle: 0.0 };
    let heads = [
        ("face", 0.01, ict()),
        ("head", 0.01, ict()),
        ("aura", 0.01, Front { height: [-10.2, 11.0], ears: -6.5, middle: 0.015 }),
        ("makehuman", 0.1, Front { height: [6.05, 8.05], ears: 0.4, middle: 0.0 }),
    ];
    for (name, metres_per_unit, front) in heads {
        let mut face = face(&shared, name, metres_per_unit);
        for _ in ["with examples", "without"] {
            for count in [30, 60, 90] {
                check(&face, &front, count);
            }
            face.examples.clear();
        }
    }
}

#[test]
fn handles_are_spread_over_the_face_that_is_made_in_code() {
    let mut face = rhytid_demo::face(9000);
    let front = Front { height: [-11.5, 5.0], ears: -8.0, middle: 0.0 };
    check(&face, &front, 60);
    face.examples.clear();
    check(&face, &front, 60);

    // With another up axis, and in metres.
    let before = Skin::from_face(&face).unwrap().spread(60, &[]);
    for x in &mut face.neutral.positions {
        *x = [0.01 * x[0], -0.01 * x[2], 0.01 * x[1]];
    }
    (face.up_axis, face.metres_per_unit) = (UpAxis::Z, 1.0);
    let after = Skin::from_face(&face).unwrap().spread(60, &[]);
    let same = after.iter().filter(|v| before.contains(v)).count();
    assert!(same * 10 >= before.len() * 9, "{same} of {} are the same", before.len());

    // Kept handles stay first, and none of the others is at their places.
    let kept = [before[5], before[9]];
    let with_kept = Skin::from_face(&face).unwrap().spread(40, &kept);
    assert_eq!(with_kept[..2], kept);
    assert!(with_kept[2..].iter().all(|v| !kept.contains(v)));
}
