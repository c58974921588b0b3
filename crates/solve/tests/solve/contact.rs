//! Eyeballs are recognised, and the vertices around them know how near they may come.
use rhytid_core::{Contact, Face, Method, NoProgress, SurfacePoint, VertexId};
use rhytid_solve::{FoundEyeball, FreeMotion, solve_in_full};
use rhytid_test_support::eye::{self, EYEBALL, LASH, RADIUS};

fn recognised(face: &Face) -> (Contact<f64>, Vec<FoundEyeball>) {
    let solved = solve_in_full(face, false, &NoProgress).unwrap();
    (solved.rig.learned().map(|learned| learned.contact.clone()).unwrap_or_default(), solved.report.eyeballs)
}

fn length(x: [f64; 3]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[test]
fn an_eyeball_and_its_lids_are_recognised() {
    let face = eye::face();
    let (contact, found) = recognised(&face);
    let [FoundEyeball { first_vertex, radius, lid_vertices }] = found[..] else { panic!("{found:?}") };
    assert_eq!((first_vertex.index(), lid_vertices), (EYEBALL.start, contact.lids.len()));
    assert!((radius - RADIUS).abs() < 1e-9, "{radius}");
    let poses = [&face.neutral.positions, &face.examples[0].positions];
    // The centre is the origin, also where the eyeball is turned.
    assert!(poses.iter().all(|pose| length(contact.eyeballs[0].center(pose)) < 1e-9));
    let handles: Vec<VertexId> = face.handles.points.iter().filter_map(SurfacePoint::vertex).collect();
    let mut lashes = 0;
    for (i, lid) in contact.lids.iter().enumerate() {
        let v = lid.vertex.index();
        assert!(!handles.contains(&lid.vertex) && !EYEBALL.contains(&v));
        if LASH.contains(&v) {
            let leader = &contact.lids[lid.leader as usize];
            let apart = |w: VertexId| {
                let rest = &face.neutral.positions;
                length([0, 1, 2].map(|c| rest[w.index()][c] - rest[v][c]))
            };
            assert!(contact.lids.iter().all(|other| {
                LASH.contains(&other.vertex.index()) || apart(other.vertex) >= apart(leader.vertex)
            }));
            lashes += 1;
            continue;
        }
        assert_eq!(lid.leader as usize, i);
        let [at_rest, wide] = poses.map(|pose| length(pose[v]));
        assert!((lid.nearest - at_rest.min(wide).min(RADIUS)).abs() < 2e-3, "{lid:?}");
        assert!(lid.farthest > at_rest.max(wide) && lid.farthest < at_rest.max(wide) + 1.2, "{lid:?}");
    }
    assert_eq!(lashes, LASH.len());
}

#[test]
fn what_is_no_eyeball_is_left_alone() {
    let without = |change: fn(&mut Face)| {
        let mut face = eye::face();
        change(&mut face);
        assert_eq!(recognised(&face), (Contact::default(), Vec::new()));
    };
    without(|face| face.settings.contact.eyes = false);
    without(|face| face.settings.method = Method::Chapter);
    // A flat stone.
    without(|face| {
        for pose in [&mut face.neutral.positions, &mut face.examples[0].positions] {
            pose[EYEBALL].iter_mut().for_each(|x| x[0] *= 0.5);
        }
    });
    // A balloon: the examples change its size.
    without(|face| face.examples[0].positions[EYEBALL].iter_mut().flatten().for_each(|x| *x *= 1.2));
    // A ball that is far from all skin.
    without(|face| {
        for pose in [&mut face.neutral.positions, &mut face.examples[0].positions] {
            pose[EYEBALL].iter_mut().for_each(|x| x[2] -= 5.0);
        }
    });
    let report = solve_in_full(&eye::face(), false, &NoProgress).unwrap().report;
    let motions: Vec<FreeMotion> = report.parts.iter().map(|part| part.motion).collect();
    assert_eq!(motions[0], FreeMotion::Solid);
}

#[test]
fn a_cornea_is_part_of_its_eyeball() {
    let mut face = eye::face();
    // The front bulges by up to a tenth. It does not turn here.
    let bulge = |[x, y, z]: [f64; 3]| {
        let out = 1.0 + 0.5 * (z - 0.8 * RADIUS).max(0.0);
        [out * x, out * y, out * z]
    };
    for v in EYEBALL {
        face.neutral.positions[v] = bulge(face.neutral.positions[v]);
        face.examples[0].positions[v] = face.neutral.positions[v];
    }
    let (contact, found) = recognised(&face);
    assert_eq!(found.len(), 1);
    assert!((found[0].radius - RADIUS).abs() < 0.02, "{found:?}");
    let skin = contact.lids.iter().filter(|lid| !LASH.contains(&lid.vertex.index()));
    // A vertex that comes from outside stays clear of the bulge.
    assert!(skin.map(|lid| lid.nearest).fold(0.0, f64::max) > 1.05 * RADIUS);
}
