//! Faces whose files split their vertices are solved as if they were whole.
use rhytid_core::{Example, Face, Faces, Handles, Mesh, NoProgress, Rig, Settings, UpAxis, VertexId};
use rhytid_solve::{Severity, examine, points, solve, solve_in_full};
use rhytid_test_support::split::{SplitFace, left_or_right, split};
use rhytid_test_support::{eye, lips, sheet};

/// The face with a seam down the middle, and with flat shading.
fn splits(face: &Face) -> [SplitFace; 2] {
    [split(face, left_or_right(&face.neutral)), split(face, |f, _| f)]
}

/// What the rig of the whole face says of each vertex of the split one, to the bit.
fn assert_same(whole: &Rig<f64>, found: &Rig<f64>, of_vertex: &[u32]) {
    assert_eq!(found.vertices(), of_vertex.len());
    let at = |v: u32| whole.surface().rest[v as usize];
    for (v, &of) in of_vertex.iter().enumerate() {
        let w = of as usize;
        assert_eq!(found.surface().rest[v], at(of));
        assert_eq!(found.basis().row(v), whole.basis().row(w), "vertex {v}");
        assert_eq!(found.influences().edges.row(v), whole.influences().edges.row(w));
        assert_eq!(found.influences().weights.row(v), whole.influences().weights.row(w));
        assert_eq!(found.fine_scale().rbf_weights.row(v), whole.fine_scale().rbf_weights.row(w));
        let neighbor = |rig: &Rig<f64>, v: usize| rig.surface().tangent_neighbors[v];
        assert_eq!(of_vertex[neighbor(found, v).index()], neighbor(whole, w).0);
    }
    let (Some(whole), Some(found)) = (whole.learned(), found.learned()) else {
        panic!("learned");
    };
    for (v, &of) in of_vertex.iter().enumerate() {
        let w = of as usize;
        assert_eq!(found.anchors.row(v), whole.anchors.row(w));
        assert_eq!(found.anchor_weights.row(v), whole.anchor_weights.row(w));
        assert_eq!(found.feature_gains.row(v), whole.feature_gains.row(w));
        assert_eq!(found.example_weights.row(v), whole.example_weights.row(w));
        assert_eq!(found.variances[v], whole.variances[w]);
    }
    // Every vertex of a point follows, and all else is there once.
    let of = |v: VertexId| of_vertex[v.index()];
    let [mine, theirs] = [&found.contact, &whole.contact];
    assert_eq!(mine.openings.rims.len(), theirs.openings.rims.len());
    for (a, b) in mine.openings.rims.iter().zip(&theirs.openings.rims) {
        assert_eq!(
            (of(a.vertex), a.across, a.reach, a.least_gap),
            (b.vertex.0, b.across, b.reach, b.least_gap)
        );
    }
    let copies = |v: u32| of_vertex.iter().filter(|of| **of == v).count();
    for follower in &theirs.openings.followers {
        let same: Vec<_> =
            mine.openings.followers.iter().filter(|other| of(other.vertex) == follower.vertex.0).collect();
        assert_eq!(same.len(), copies(follower.vertex.0));
        assert!(
            same.iter().all(|other| (other.leaders, other.weights) == (follower.leaders, follower.weights))
        );
    }
    assert_eq!(mine.eyeballs.len(), theirs.eyeballs.len());
    for (a, b) in mine.eyeballs.iter().zip(&theirs.eyeballs) {
        assert_eq!((a.corners.map(of), a.weights), (b.corners.map(|v| v.0), b.weights));
    }
    for lid in &theirs.lids {
        let same: Vec<_> = mine.lids.iter().filter(|other| of(other.vertex) == lid.vertex.0).collect();
        assert_eq!(same.len(), copies(lid.vertex.0));
        for other in same {
            assert_eq!(
                (other.eyeball, other.nearest, other.farthest),
                (lid.eyeball, lid.nearest, lid.farthest)
            );
            let leader = |lids: &[rhytid_core::LidVertex<f64>], leader: u32| lids[leader as usize].vertex;
            assert_eq!(of(leader(&mine.lids, other.leader)), leader(&theirs.lids, lid.leader).0);
        }
    }
}

#[test]
fn a_split_face_has_the_rig_of_the_whole_one_to_the_bit() {
    for face in [sheet::face(), lips::face(), eye::face()] {
        let whole = solve(&face, &NoProgress).unwrap();
        for SplitFace { face, of_vertex } in splits(&face) {
            let joined = points(&face).unwrap();
            assert_eq!(joined.of_vertex, of_vertex, "{}", face.name);
            let solved = solve_in_full(&face, false, &NoProgress).unwrap();
            assert_eq!(solved.report.points, whole.vertices());
            assert_same(&whole, &solved.rig, &of_vertex);
            assert_eq!(solved.rig.surface().faces, face.neutral.faces);
            // The rig in f32, as it is read from its file, is joined too.
            let rounded = solved.rig.rounded().unwrap();
            let bytes = rhytid_core::rig_file::encode(&rounded).unwrap();
            assert_eq!(rhytid_core::rig_file::decode(&bytes, "rig").unwrap(), rounded);
            assert_eq!(rounded.surface().joined.as_deref(), Some(&*joined.first_of_each()));
        }
    }
}

#[test]
fn without_the_join_each_side_is_by_itself() {
    let face = sheet::face();
    let whole = solve(&face, &NoProgress).unwrap();
    let SplitFace { mut face, of_vertex } = split(&face, left_or_right(&face.neutral));
    face.settings.weld = false;
    let rig = solve(&face, &NoProgress).unwrap();
    let worst = of_vertex.iter().enumerate().flat_map(|(v, &of)| {
        rig.basis().row(v).iter().zip(whole.basis().row(of as usize)).map(|(a, b)| (a - b).abs())
    });
    assert!(worst.fold(0.0, f64::max) > 0.1);
    let seam = |face: &Face| {
        let findings = examine(face).findings;
        findings.into_iter().find(|finding| finding.code == "coincident-boundary-vertices")
    };
    let found = seam(&face).unwrap();
    assert!(
        found.severity == Severity::Warning && found.message.contains("weld = true in [mesh]"),
        "{found:?}"
    );
    face.settings.weld = true;
    assert_eq!(seam(&face), None);
    let notes = examine(&face).findings;
    let joined = notes.iter().find(|finding| finding.code == "joined-vertices").unwrap();
    let expected = format!("{} vertices are {} points of the surface", of_vertex.len(), whole.vertices());
    assert!(joined.message.replace(',', "").starts_with(&expected), "{joined:?}");
}

/// Two strips of quads whose edges meet along y = 0, the upper one numbered first.
fn touching() -> Face {
    let mut mesh = Mesh::default();
    for (y, up) in [(0.0, 1.0), (-1.0, 1.0)] {
        let first = mesh.positions.len() as u32;
        for row in [y, y + up] {
            mesh.positions.extend((0..4).map(|x| [f64::from(x), row, 0.0]));
        }
        for x in 0..3 {
            mesh.faces.push(&[x, x + 1, x + 5, x + 4].map(|v| first + v));
        }
    }
    Face {
        name: "strips".into(),
        neutral: mesh,
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        handles: Handles { labels: vec!["a".into()], points: vec![VertexId(4).into()] },
        examples: Vec::new(),
        prior: None,
        settings: Settings { weld: true, ..Settings::default() },
    }
}

#[test]
fn vertices_that_an_example_moves_apart_are_two_points() {
    let face = touching();
    // The upper strip has its edge at 0 to 3, and the lower one at 12 to 15.
    let joined = points(&face).unwrap();
    assert_eq!(joined.of_vertex, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 0, 1, 2, 3]);
    let opened = |vertices: &[usize]| {
        let mut positions = face.neutral.positions.clone();
        vertices.iter().for_each(|&v| positions[v][1] -= 0.5);
        let example = Example { name: "open".into(), positions, mirror: false, noise: None };
        Face { examples: vec![example], ..face.clone() }
    };
    // A mouth that opens at all its vertices, and one whose corners stay together.
    assert_eq!(points(&opened(&[12, 13, 14, 15])), None);
    let corner = points(&opened(&[14, 15])).unwrap();
    assert_eq!(corner.of_vertex, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 0, 1, 12, 13]);
}

#[test]
fn only_edges_on_which_the_surface_goes_on_are_joined() {
    // A strip whose faces look the other way.
    let mut turned = touching();
    let faces: Vec<Vec<u32>> = turned.neutral.faces.iter().map(<[u32]>::to_vec).collect();
    turned.neutral.faces = Faces::default();
    for (f, mut corners) in faces.into_iter().enumerate() {
        if f >= 3 {
            corners.reverse();
        }
        turned.neutral.faces.push(&corners);
    }
    assert_eq!(points(&turned), None);
    // Equal places inside a surface are no seam.
    let mut inside = sheet::face();
    inside.settings.weld = true;
    assert_eq!(points(&inside), None);
}

#[test]
fn handles_at_one_point_are_refused_by_the_numbers_of_the_file() {
    let mut face = touching();
    face.handles = Handles {
        labels: vec!["upper".into(), "lower".into()],
        points: [2, 14].map(|v| VertexId(v).into()).to_vec(),
    };
    let error = solve(&face, &NoProgress).unwrap_err().to_string();
    assert!(error.contains("handles upper and lower are both vertex 2"), "{error}");
}

#[test]
fn a_hostile_pile_of_triangles_is_no_matter() {
    // Twenty thousand triangles at one place, and as many that share an edge there.
    let mut face = touching();
    for i in 0..20_000 {
        let first = face.neutral.positions.len() as u32;
        let away = if i % 2 == 0 { 5.0 } else { 5.0 + f64::from(i) };
        face.neutral.positions.extend([[0.0, 0.0, 9.0], [1.0, 0.0, 9.0], [0.0, away, 9.0]]);
        face.neutral.faces.push(&[0, 1, 2].map(|v| first + v));
    }
    let found = points(&face).unwrap();
    assert_eq!(found.len(), face.neutral.positions.len() - 4);
    // A fan of corners around one point is joined up to 256 triangles, and stays apart beyond.
    for (count, is_joined) in [(256u32, true), (257, false)] {
        let mut mesh = Mesh::default();
        let rim = |i: u32| {
            let angle = f64::from(i % count) / f64::from(count) * std::f64::consts::TAU;
            [angle.cos(), angle.sin(), 0.0]
        };
        for i in 0..count {
            mesh.positions.extend([[0.0; 3], rim(i), rim(i + 1)]);
            mesh.faces.push(&[0, 1, 2].map(|v| 3 * i + v));
        }
        let found = points(&Face { neutral: mesh, ..touching() }).unwrap();
        let hubs = (0..count as usize).map(|i| found.of_vertex[3 * i]);
        assert_eq!(hubs.clone().min() == hubs.max(), is_joined, "{count}");
    }
}
