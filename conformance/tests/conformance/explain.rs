//! An explanation of a vertex is complete: its parts add up to what the reference evaluates.

use rhytid_conformance::evaluate;
use rhytid_core::{Face, HandleId, HandleShare, LearnedSettings, Method, NoProgress, Rig, WrinkleStrains};

/// The demo's rig by each method with another function for its wrinkles.
fn rigs() -> (Face, Vec<(&'static str, Rig)>) {
    let face = rhytid_demo::face(1_500);
    let lengths = LearnedSettings { wrinkle_strains: WrinkleStrains::Lengths, ..LearnedSettings::default() };
    let methods =
        [("vectors", Method::default()), ("lengths", Method::Learned(lengths)), ("chapter", Method::Chapter)];
    let solve = |(name, method)| {
        let mut face = face.clone();
        face.settings.method = method;
        (name, rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap())
    };
    let rigs = methods.map(solve).into();
    (face, rigs)
}

fn size(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[test]
fn the_examples_parts_are_the_detail() {
    let (face, rigs) = rigs();
    let take = rhytid_demo::performance(&face);
    for (name, rig) in rigs {
        let wide_rig: Rig<f64> = rig.widened();
        let positions = take.handle_positions(&rig.handles().labels).unwrap();
        let frames = positions.chunks_exact(3 * rig.handles().len());
        let mut largest = 0.0_f64;
        for frame in frames.step_by(60) {
            let (handles, _) = frame.as_chunks::<3>();
            let widened: Vec<[f64; 3]> = handles.iter().map(|p| p.map(f64::from)).collect();
            let detail = evaluate(&wide_rig, &widened).detail;
            for v in (0..rig.vertices()).step_by(7) {
                let wrinkle = rig.explain(v, handles).unwrap().wrinkle();
                let off = size([0, 1, 2].map(|c| wrinkle[c] - detail[v][c]));
                assert!(off < 1e-5, "{name}, vertex {v}: {wrinkle:?} instead of {:?}", detail[v]);
                largest = largest.max(size(detail[v]));
            }
        }
        assert!(largest > 0.02, "{name}: there are no wrinkles here, {largest}");
    }
}

#[test]
fn an_example_is_no_distance_from_itself_and_rest_from_rest() {
    for (name, rig) in rigs().1 {
        let v = rig.vertices() / 2;
        for p in 0..rig.examples().names.len() {
            let explanation = rig.explain(v, rig.examples().handles.row(p)).unwrap();
            let distance = explanation.examples[p].distance;
            assert!(distance < 1e-5, "{name}: example {p} is {distance} from itself");
        }
        let rest: Vec<[f32; 3]> = rig.handles().rest.clone();
        let explanation = rig.explain(v, &rest).unwrap();
        // The chapter's weights cancel there, up to their ridge.
        let wrinkle = size(explanation.wrinkle());
        let most = if name == "chapter" { 1e-3 } else { 1e-6 };
        assert!(explanation.from_rest < 1e-6 && wrinkle < most, "{name}: {wrinkle}, {explanation:?}");
        assert!(explanation.edges.iter().all(|edge| edge.strain.abs() < 1e-6));
        assert!(explanation.edges.windows(2).all(|pair| pair[0].weight >= pair[1].weight));
        // A handle follows itself alone.
        let own = rig.explain(rig.handles().points[3].nearest_vertex().index(), &rest).unwrap();
        assert_eq!(own.handles, [HandleShare { handle: HandleId(3), weight: 1.0 }], "{name}");
    }
}

#[test]
fn what_is_not_there_is_a_sentence() {
    let rig = rigs().1.remove(0).1;
    let rest: Vec<[f32; 3]> = rig.handles().rest.clone();
    let error = rig.explain(rig.vertices(), &rest).unwrap_err().to_string();
    assert!(error.contains("the rig's vertices are 0 to"), "{error}");
    let error = rig.explain(0, &rest[1..]).unwrap_err().to_string();
    assert!(error.contains("expected those of"), "{error}");
}
