//! Examples that do not show what they should.

use super::*;
use rhytid_core::VertexId;

#[test]
fn without_examples_there_is_a_note() {
    let face = with(|f| f.examples.clear());
    finds(&face, Severity::Note, "no-examples", &["no examples", "large scale only"]);
    assert!(!examine(&face).has_errors());
}

#[test]
fn examples_far_away() {
    let face = with(|f| f.examples[0].positions[20..].iter_mut().for_each(|x| x[1] += 20.0));
    let words = ["example smile", "vertex 20 by 20 mesh units", "over half of the mesh's size"];
    finds(&face, Severity::Warning, "example-far-away", &words);
}

#[test]
fn examples_that_move_no_handle() {
    let face = with(|f| {
        f.settings.method = Method::Chapter;
        let mut positions = f.neutral.positions.clone();
        positions[17][2] += 0.6;
        f.examples.push(Example { name: "twitch".into(), positions, mirror: false, noise: None });
    });
    let words = ["example twitch moves no handle", "lost or shows at rest too"];
    finds(&face, Severity::Warning, "example-at-rest", &words);

    // Half of the detail shows at rest, because the rest pose and the example share their mean.
    let rig = solved(&face);
    let mut detail = [0.0; 3];
    for center in 0..rig.centers() {
        let strains = rig.fine_scale().pose_features.row(center);
        let squares = rig.influences().at(17).map(|(edge, alpha)| {
            let strain = strains[edge.index()];
            alpha * strain * strain
        });
        let distance = squares.sum::<f64>().sqrt();
        let weight = rig.fine_scale().rbf_weights.row(17)[center];
        (0..3).for_each(|c| detail[c] += weight[c] * distance);
    }
    let length = detail.iter().map(|c| c * c).sum::<f64>().sqrt();
    assert!((length - 0.3).abs() < 1e-6, "{detail:?}");
}

#[test]
fn vertices_in_another_order() {
    let mut mesh = Mesh::default();
    add_sheet(&mut mesh, 15, 15, [0.0; 3]);
    // The same surface with its vertices in the order of another export.
    let shuffled = (0..225).map(|v| mesh.positions[(67 * v) % 225]).collect();
    let examples = vec![Example { name: "smile".into(), positions: shuffled, mirror: false, noise: None }];
    let face = Face { neutral: mesh, examples, ..face() };
    let report = examine(&face);
    let found =
        report.findings.iter().find(|f| f.code == "vertices-in-another-order").expect("most edges are torn");
    says(&found.message, &["example smile tears", "not in the neutral's order"]);
    says(&found.message, &[&format!("tears {} vertices", found.vertices.len())]);
}

#[test]
fn an_example_that_is_the_neutral() {
    let face = with(|f| f.examples[0].positions = f.neutral.positions.clone());
    finds(&face, Severity::Warning, "example-is-neutral", &["example smile is the neutral"]);
}

#[test]
fn a_scan_in_another_place_and_what_is_pinned_and_moves() {
    let turned = with(|f| {
        let (sin, cos) = 4.0_f64.to_radians().sin_cos();
        for [x, y, z] in &mut f.examples[0].positions {
            [*x, *y, *z] = [cos * *x - sin * *y + 0.3, sin * *x + cos * *y, *z];
        }
    });
    let words =
        ["example smile is turned by 4°", "the solve removes this motion (align = false would keep it)"];
    finds(&turned, Severity::Warning, "example-in-another-place", &words);
    let kept = Face { settings: Settings { align: false, ..turned.settings.clone() }, ..turned };
    finds(
        &kept,
        Severity::Warning,
        "example-in-another-place",
        &["without align = false the solve would remove this motion"],
    );
    let pinned = with(|f| f.settings.pins.vertices = vec![VertexId(11), VertexId(13)]);
    finds(
        &pinned,
        Severity::Warning,
        "pinned-moves",
        &["example smile moves vertex 13, which is pinned, by 0.4 mesh units"],
    );
    let face = with(|f| f.settings.pins.vertices = vec![VertexId(25)]);
    assert_eq!(examine(&face).findings[0].code, "pins");
}
