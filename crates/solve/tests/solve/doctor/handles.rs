//! Handles and strain edges where no marker would be.

use super::*;
use rhytid_core::{HandleId, SurfacePoint, VertexId};

#[test]
fn handles_that_snapped_to_another_piece() {
    let code = "handle-on-another-component";
    let piece = |f: &mut Face| add_piece(f, 3, 2, [4.0, 4.0, -1.0]);
    let face = with(|f| {
        piece(f);
        f.handles.labels.push("lid".into());
        f.handles.points.push(VertexId(27).into());
    });
    finds(&face, Severity::Warning, code, &["1 handle is on another connected component", "lid (vertex 27)"]);
    let face = with(|f| {
        piece(f);
        add_piece(f, 2, 2, [4.0, 8.0, -3.0]);
        f.handles.labels.extend(["lid".into(), "lash".into()]);
        f.handles.points.extend([27, 31].map(|v| SurfacePoint::from(VertexId(v))));
    });
    let words = ["2 handles are each on another connected component", "lid (vertex 27), lash (vertex 31)"];
    finds(&face, Severity::Warning, code, &words);
    // A piece with enough handles of its own is no fault.
    let face = with(|f| {
        add_piece(f, 3, 2, [40.0, 0.0, 0.0]);
        f.handles.labels.extend(["l0".into(), "l1".into()]);
        f.handles.points.extend([25, 30].map(|v| SurfacePoint::from(VertexId(v))));
    });
    assert_eq!(examine(&face).findings, []);
}

#[test]
fn a_handle_that_nobody_sees() {
    // A sheet that is bent to a pipe with a lid at its far end. A handle is inside.
    let mut mesh = Mesh::default();
    let sides = 12;
    for ring in 0..6 {
        for side in 0..sides {
            let (sin, cos) = (f64::from(side) / f64::from(sides) * std::f64::consts::TAU).sin_cos();
            // Two skins: outside down, inside up again, joined at the mouth.
            let radius = if ring < 3 { 6.0 } else { 2.0 };
            let depth = [-45.0, -20.0, 0.0, 0.0, -20.0, -40.0][ring as usize];
            mesh.positions.push([radius * cos, radius * sin, depth]);
        }
    }
    for ring in 0..5 {
        for side in 0..sides {
            let next = (side + 1) % sides;
            mesh.faces.push(&[
                ring * sides + side,
                ring * sides + next,
                (ring + 1) * sides + next,
                (ring + 1) * sides + side,
            ]);
        }
    }
    let lid = |ring: u32| (0..sides).map(|side| ring * sides + side).collect::<Vec<u32>>();
    mesh.faces.push(&lid(5));
    mesh.faces.push(&lid(0).into_iter().rev().collect::<Vec<u32>>());
    let face = Face {
        neutral: mesh,
        handles: Handles {
            labels: ["a", "b", "c", "inside"].map(String::from).to_vec(),
            points: [12, 16, 20, 61].map(|v| VertexId(v).into()).to_vec(),
        },
        examples: Vec::new(),
        ..face()
    };
    let report = examine(&face);
    let found = report.findings.iter().find(|f| f.code == "handle-inside");
    says(
        &found.expect("a handle at the bottom of a pipe").message,
        &["1 handle is not seen from outside", "inside (vertex 61)"],
    );
}

#[test]
fn a_strain_edge_across_an_opening() {
    // A strip that is bent to an open ring. Its ends are near each other, but far along the strip.
    let face = with(|f| {
        for positions in [&mut f.neutral.positions, &mut f.examples[0].positions] {
            for x in positions.iter_mut() {
                let (sin, cos) = (x[0] / 16.0 * 5.8).sin_cos();
                *x = [(2.6 + 0.1 * x[2]) * sin, x[1], (2.6 + 0.1 * x[2]) * cos];
            }
        }
        f.settings.strain_edges =
            StrainEdges::Given([[0, 1], [0, 2]].map(|pair| pair.map(HandleId)).to_vec());
    });
    let report = examine(&face);
    let found = report.findings.iter().find(|f| f.code == "strain-edge-around").expect("the ends of a ring");
    says(&found.message, &["1 strain edge joins", "more than 3 times as far along the skin", ": a–b;"]);
    assert_eq!(found.severity, Severity::Warning);
}
