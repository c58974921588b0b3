//! Coverage of takes whose strains are known exactly.
use rhytid_capture::coverage::{Coverage, coverage};
use rhytid_core::{
    Error, Examples, Faces, FineScale, HandleId, HandleSet, Influences, Rig, RigParts, Surface, Table, Take,
    UpAxis, VertexId,
};
use rhytid_test_support::changed;

/// Five handles on a line, 2 cm apart, with an edge between neighbours. The examples stretch the first edge,
/// and the last, by a quarter.
fn rig() -> Rig<f64> {
    let rest: Vec<[f64; 3]> = (0..5).map(|i| [2.0 * f64::from(i), 0.0, 0.0]).collect();
    let basis = (0..25).map(|i| f64::from(u8::from(i / 5 == i % 5))).collect();
    let parts = RigParts {
        handles: HandleSet {
            labels: ["a", "b", "c", "d", "e"].map(String::from).to_vec(),
            points: (0..5).map(|v| VertexId(v).into()).collect(),
            rest: rest.clone(),
            strain_edges: [[0, 1], [1, 2], [2, 3], [3, 4]].map(|pair| pair.map(HandleId)).to_vec(),
            rotations: false,
        },
        surface: Surface {
            name: "line".into(),
            metres_per_unit: 0.01,
            up_axis: UpAxis::Y,
            faces: Faces { counts: vec![3], indices: vec![0, 1, 2] },
            uvs: None,
            materials: None,
            triangles: vec![[0, 1, 2]],
            rest,
            tangent_neighbors: (0..5).map(VertexId).collect(),
            joined: None,
        },
        examples: Examples {
            names: ["first", "last"].map(String::from).to_vec(),
            handles: Table::filled(2, 5, [0.0; 3]),
        },
        bending_length: 1.0,
        basis: Table::new(5, 5, basis),
        influences: Influences {
            edges: Table::without_columns(5),
            weights: Table::without_columns(5),
            beta: 0.0,
        },
        fine_scale: of_poses(&[REST, FIRST, LAST]),
        learned: None,
    };
    Rig::new(parts).unwrap()
}

/// Poses of these strains, without wrinkles.
fn of_poses<const F: usize>(strains: &[[f64; F]]) -> FineScale<f64> {
    FineScale {
        pose_features: Table::new(strains.len(), F, strains.as_flattened().to_vec()),
        rbf_weights: Table::filled(5, strains.len(), [0.0; 3]),
    }
}

const REST: [f64; 4] = [0.0; 4];
const FIRST: [f64; 4] = [0.25, 0.0, 0.0, 0.0];
const LAST: [f64; 4] = [0.0, 0.0, 0.0, 0.25];

/// Frames with these strains, ten a second.
fn take(strains: &[[f64; 4]]) -> Take {
    let frame = |strains: &[f64; 4]| {
        let mut x = 0.0;
        let ends = strains.map(|strain| {
            x += 2.0 * (1.0 + strain);
            [x, 0.0, 0.0]
        });
        std::iter::once([0.0; 3]).chain(ends).collect::<Vec<_>>()
    };
    Take {
        labels: rig().handles().labels.clone(),
        times: (0..strains.len()).map(|i| i as f64 / 10.0).collect(),
        positions: strains.iter().flat_map(frame).collect(),
        ..Take::default()
    }
}

fn compare(strains: &[[f64; 4]]) -> Coverage {
    coverage(&rig(), &take(strains), 10).unwrap()
}

fn frames(found: &Coverage) -> Vec<usize> {
    found.expressions.iter().map(|e| e.frame).collect()
}

#[test]
fn a_take_of_the_examples_is_covered() {
    let found = compare(&[REST, FIRST, LAST, FIRST, REST]);
    assert_eq!((found.frames, found.covered), (5, 5));
    // Each example is √(0.25²/4) from rest, and that is nearer than the other example.
    assert_eq!(found.spacing, Some(0.125));
    assert_eq!(found.distances, [0.0; 5]);
    assert!(found.expressions.is_empty() && found.edges.is_empty() && found.edges_beyond == 0);
    // A frame halfway is covered too.
    let found = compare(&[[0.125, 0.0, 0.0, 0.0]]);
    assert_eq!((found.covered, found.distances.as_slice()), (1, &[0.0625][..]));
    assert!(found.expressions.is_empty());
}

#[test]
fn twice_as_far_as_an_example_is_on_top_with_its_exact_excess() {
    let found = compare(&[REST, FIRST, LAST, [0.5, 0.0, 0.0, 0.0], [0.0, -0.125, 0.0, 0.0]]);
    assert_eq!((found.covered, found.distances[3]), (4, 0.125));
    let [expression] = &found.expressions[..] else { panic!("{:?}", found.expressions) };
    assert_eq!((expression.frame, expression.time, expression.distance), (3, 0.3, 0.125));
    // As far from the nearest example as the examples are from each other.
    assert_eq!(
        (expression.relative, expression.nearest.as_str(), expression.covered),
        (Some(1.0), "first", 5)
    );
    let [edge] = &expression.edges[..] else { panic!("{:?}", expression.edges) };
    assert_eq!((edge.handles.join("–").as_str(), edge.strain, edge.difference), ("a–b", 0.5, 0.25));
    // A quarter of 2 cm.
    assert!((edge.difference_mm - 5.0).abs() < 1e-12);

    assert_eq!(found.edges_beyond, 2);
    let [longer, shorter] = &found.edges[..] else { panic!("{:?}", found.edges) };
    assert_eq!((longer.handles.join("–").as_str(), longer.frame, longer.frames_beyond), ("a–b", 3, 1));
    assert_eq!((longer.beyond, longer.examples, longer.time), (0.25, [0.0, 0.25], 0.3));
    assert!((longer.beyond_mm - 5.0).abs() < 1e-12);
    assert_eq!((shorter.handles.join("–").as_str(), shorter.frame), ("b–c", 4));
    assert_eq!((shorter.beyond, shorter.examples), (-0.125, [0.0, 0.0]));
    assert!((shorter.beyond_mm + 2.5).abs() < 1e-12);
}

#[test]
fn the_second_expression_is_not_the_frame_beside_the_first() {
    let b = |s| [0.0, s, 0.0, 0.0];
    let c = |s| [0.0, 0.0, s, 0.0];
    // The second edge goes farther in each of its frames than the third ever does.
    let strains =
        [REST, b(0.6875), b(0.75), b(0.6875), REST, c(-0.25), c(-0.375), REST, [0.0, 0.75, 0.0, 0.25]];
    let found = compare(&strains);
    // Frame 8 is as far from LAST as frame 2 is from rest. Once frame 2 is known, frame 8 is near it.
    assert_eq!(frames(&found), [2, 6, 8]);
    let nearest: Vec<&str> = found.expressions.iter().map(|e| e.nearest.as_str()).collect();
    assert_eq!(nearest, ["rest", "rest", "expression 1"]);
    // The first scan covers its two neighbours, the second its one. Each distance is at most the one before.
    let covered: Vec<usize> = found.expressions.iter().map(|e| e.covered).collect();
    assert_eq!((found.covered, covered), (3, vec![6, 8, 9]));
    assert!(found.expressions.windows(2).all(|pair| pair[0].distance >= pair[1].distance));
    assert_eq!(coverage(&rig(), &take(&strains), 1).unwrap().expressions.len(), 1);
}

#[test]
fn an_expression_that_was_scanned_is_suggested_no_more() {
    let strains = [REST, [0.0, 0.75, 0.0, 0.0], [0.0, 0.0, -0.375, 0.0]];
    let scanned = changed(&rig(), |r| {
        r.examples.names.push("scan".into());
        r.examples.handles = Table::filled(3, 5, [0.0; 3]);
        r.fine_scale = of_poses(&[REST, FIRST, LAST, strains[1]]);
    })
    .unwrap();
    assert_eq!(frames(&compare(&strains)), [1, 2]);
    let found = coverage(&scanned, &take(&strains), 10).unwrap();
    assert_eq!((frames(&found), found.distances[1]), (vec![2], 0.0));
}

#[test]
fn what_is_guessed_is_nobodys_expression() {
    let strains = [REST, [0.5, 0.0, 0.0, 0.5]];
    let with = |confidence: [f32; 5]| {
        let all = [1.0; 5].into_iter().chain(confidence).collect();
        coverage(&rig(), &Take { confidence: Some(all), ..take(&strains) }, 10).unwrap()
    };
    assert_eq!(with([1.0; 5]), compare(&strains));
    assert_eq!(with([1.0, 1.0, 1.0, 1.0, 0.51]), compare(&strains));
    // Without its last edge, this frame is one where the first is twice as far as in the example.
    let found = with([1.0, 1.0, 1.0, 1.0, 0.5]);
    assert_eq!((found.distances[1], found.edges.len()), (0.125, 1));
    assert_eq!(found.expressions[0].nearest, "first");
    assert_eq!(with([0.0; 5]).distances, [0.0, 0.0]);
}

#[test]
fn the_noise_of_markers_is_beyond_nothing() {
    // 0.4 mm and 0.6 mm of 2 cm.
    let found = compare(&[[0.0, 0.02, 0.0, 0.0], [0.0, 0.0, 0.03, 0.0], [0.0, 0.0, 0.02, 0.0]]);
    assert_eq!(found.edges_beyond, 1);
    assert_eq!((found.edges[0].handles.join("–").as_str(), found.edges[0].frames_beyond), ("c–d", 1));
}

#[test]
fn rigs_without_what_is_compared() {
    let alone = changed(&rig(), |r| {
        r.examples = Examples { names: Vec::new(), handles: Table::filled(0, 5, [0.0; 3]) };
        r.fine_scale = of_poses(&[REST]);
    })
    .unwrap();
    let found = coverage(&alone, &take(&[REST, FIRST]), 10).unwrap();
    assert_eq!((found.spacing, found.covered, frames(&found)), (None, 1, vec![1]));
    assert_eq!((found.expressions[0].relative, found.expressions[0].distance), (None, 0.125));

    let edgeless = changed(&rig(), |r| {
        r.handles.strain_edges.clear();
        r.fine_scale = of_poses(&[[]; 3]);
    })
    .unwrap();
    let error = coverage(&edgeless, &take(&[REST]), 10);
    assert!(matches!(error, Err(Error::Input(what)) if what.sentence().contains("no strain edges")));
    let other = Take { labels: ["a", "b", "c", "d", "x"].map(String::from).to_vec(), ..take(&[REST]) };
    assert!(
        matches!(coverage(&rig(), &other, 10), Err(Error::Input(what)) if what.sentence().contains("lacks 1 of"))
    );
}
