//! Bent sheets and tubes made in code: how far the shell is from the exact shape, with turning handles and
//! refined.
use rhytid_conformance::{Numbers, evaluate};
use rhytid_core::{Example, Face, Faces, Handles, Mesh, NoProgress, Rig, Settings, UpAxis, VertexId};
use rhytid_kernels::vec3;
use rhytid_solve::{Refine, solve};
use std::f64::consts::{PI, TAU};

/// A body at rest, 8 long, and the function that bends its positions.
struct Body {
    name: &'static str,
    face: Face,
    bent: Vec<[f64; 3]>,
}

fn face(positions: Vec<[f64; 3]>, triangles: &[[u32; 3]], vertices: Vec<u32>) -> Face {
    let mut faces = Faces::default();
    triangles.iter().for_each(|triangle| faces.push(triangle));
    Face {
        name: "body".into(),
        neutral: Mesh { positions, faces, ..Mesh::default() },
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        handles: Handles {
            labels: (0..vertices.len()).map(|i| format!("h{i}")).collect(),
            points: vertices.into_iter().map(|v| VertexId(v).into()).collect(),
        },
        examples: Vec::new(),
        prior: None,
        settings: Settings::default(),
    }
}

/// An 8 × 4 sheet of 49 × 25 vertices with 20 handles, rolled over an angle. No length on it changes.
fn sheet(angle: f64) -> Body {
    let at = |i: u32, j: u32| i * 25 + j;
    let grid = (0..49).flat_map(|i| (0..25).map(move |j| (i, j)));
    let positions: Vec<[f64; 3]> = grid
        .map(|(i, j)| [8.0 * (f64::from(i) / 48.0 - 0.5), 4.0 * (f64::from(j) / 24.0 - 0.5), 0.0])
        .collect();
    let quads = (0..48).flat_map(|i| (0..24).map(move |j| (i, j)));
    let triangles: Vec<[u32; 3]> = quads
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            [[a, d, c], [a, c, b]]
        })
        .collect();
    let handles = (0..5).flat_map(|i| (0..4).map(move |j| at(12 * i, 8 * j))).collect();
    let k = angle / 8.0;
    let bent = positions.iter().map(|x| [(k * x[0]).sin() / k, x[1], (1.0 - (k * x[0]).cos()) / k]).collect();
    Body { name: "sheet", face: face(positions, &triangles, handles), bent }
}

/// A tube of radius 1: 33 rings of 48 vertices with 20 handles. Its middle line is bent to an arc.
fn cylinder(angle: f64) -> Body {
    let at = |i: u32, j: u32| i * 48 + j % 48;
    let grid = (0..33).flat_map(|i| (0..48).map(move |j| (i, TAU * f64::from(j) / 48.0)));
    let positions: Vec<[f64; 3]> =
        grid.map(|(i, a)| [a.cos(), a.sin(), 8.0 * (f64::from(i) / 32.0 - 0.5)]).collect();
    let quads = (0..32).flat_map(|i| (0..48).map(move |j| (i, j)));
    let triangles: Vec<[u32; 3]> = quads
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let handles = (0..5).flat_map(|i| (0..4).map(move |j| at(8 * i, 12 * j + 6 * (i % 2)))).collect();
    let r = 8.0 / angle;
    let bend = |x: &[f64; 3]| [r - (r - x[0]) * (x[2] / r).cos(), x[1], (r - x[0]) * (x[2] / r).sin()];
    let bent = positions.iter().map(bend).collect();
    Body { name: "cylinder", face: face(positions, &triangles, handles), bent }
}

impl Body {
    fn rig(&self, rotations: bool) -> Rig<f64> {
        let settings = Settings { rotations, ..Settings::default() };
        solve(&Face { settings, ..self.face.clone() }, &NoProgress).unwrap()
    }

    fn handles(&self) -> Vec<[f64; 3]> {
        self.face.handles.points.iter().map(|point| point.at(&self.bent)).collect()
    }

    /// RMS and largest distance from the exact shape, and the mean and largest change of an area and of an
    /// edge, in percent.
    fn errors(&self, rig: &Rig<f64>, found: &[[f64; 3]]) -> [f64; 6] {
        let off: Vec<f64> =
            found.iter().zip(&self.bent).map(|(x, y)| vec3::length(vec3::sub(*x, *y))).collect();
        let area = |x: &[[f64; 3]], t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| x[v as usize]);
            vec3::length(vec3::cross(vec3::sub(b, a), vec3::sub(c, a)))
        };
        let edge = |x: &[[f64; 3]], [a, b]: [u32; 2]| vec3::length(vec3::sub(x[a as usize], x[b as usize]));
        let areas: Vec<f64> = rig
            .surface()
            .triangles
            .iter()
            .map(|t| (area(found, t) / area(&rig.surface().rest, t) - 1.0).abs())
            .collect();
        let sides = rig.surface().triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let edges: Vec<f64> =
            sides.map(|e| (edge(found, e) / edge(&rig.surface().rest, e) - 1.0).abs()).collect();
        let worst = |x: &[f64]| x.iter().copied().fold(0.0, f64::max);
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let squares: Vec<f64> = off.iter().map(|x| x * x).collect();
        [
            mean(&squares).sqrt(),
            worst(&off),
            100.0 * mean(&areas),
            100.0 * worst(&areas),
            100.0 * mean(&edges),
            100.0 * worst(&edges),
        ]
    }
}

/// The figures about bends in `docs/method.md`.
#[test]
fn handles_that_turn_bend_several_times_as_well_and_refined_still_better() {
    for (body, angle) in [(cylinder as fn(f64) -> Body, 90.0f64), (sheet, 90.0), (sheet, 180.0)] {
        let body = body(angle.to_radians());
        let (plain, turning) = (body.rig(false), body.rig(true));
        let of = |rig: &Rig<f64>| evaluate(rig, &body.handles()).positions;
        let mut refined = of(&turning);
        let steps = Refine::new(&turning, &NoProgress).unwrap().frame(&body.handles(), &mut refined);
        let found = [of(&plain), of(&turning), refined].map(|x| body.errors(&plain, &x));
        for (name, errors) in ["plain", "turning", "refined"].iter().zip(&found) {
            println!("{} {angle}°, {name}: {errors:.3?}", body.name);
        }
        println!("{steps} steps");
        assert!(steps < 60);
        let [plain, turning, refined] = found;
        assert!(turning[0] < 0.45 * plain[0] && turning[1] < 0.45 * plain[1]);
        assert!(refined[0] < 0.9 * turning[0] && refined[1] < 0.9 * turning[1]);
        if body.name == "sheet" {
            // The exact shape has no stretch.
            assert!((2..6).all(|i| turning[i] < 0.8 * plain[i] && refined[i] < 0.5 * turning[i]));
        }
    }
}

/// Without resistance to bending the method is Sorkine's and Alexa's. The values are libigl's for five
/// vertices (`ARAP_ENERGY_TYPE_SPOKES`, 3000 steps).
#[test]
fn without_bending_it_is_as_rigid_as_libigls() {
    let body = sheet(PI);
    let rig = body.rig(true);
    let refine = Refine::with_bending_length(&rig, 0.0, &NoProgress).unwrap();
    let mut positions = evaluate(&rig, &body.handles()).positions;
    // At least one step at a time, since it converges slowly at the end.
    for _ in 0..2000 {
        refine.frame(&body.handles(), &mut positions);
    }
    for (v, expected) in [
        (3, [-2.5849978, -1.5001054, 2.5457754]),
        (160, [-2.3177642, -0.3331525, 1.5845519]),
        (404, [-1.2745899, -1.3335483, 0.3353834]),
        (610, [0.0000000, -0.3333389, -0.0001551]),
        (1100, [2.4262892, -1.9988840, 1.8984517]),
    ] {
        let off = vec3::length(vec3::sub(positions[v], expected));
        println!("{v}: {off:.1e}");
        assert!(off < 2e-4, "{v}: {:?}", positions[v]);
    }
}

#[test]
fn what_is_rigid_already_is_not_changed_and_markers_are_met() {
    let body = cylinder(1.0);
    let rig = body.rig(true);
    let refine = Refine::new(&rig, &NoProgress).unwrap();
    let (sine, cosine) = 2.5f64.sin_cos();
    let turn = |x: &[f64; 3]| [cosine * x[0] - sine * x[1] + 3.0, sine * x[0] + cosine * x[1], x[2]];
    let turned: Vec<[f64; 3]> = rig.surface().rest.iter().map(turn).collect();
    let at = |positions: &[[f64; 3]]| -> Vec<[f64; 3]> {
        rig.handles().points.iter().map(|point| point.at(positions)).collect()
    };
    let mut found = turned.clone();
    assert_eq!(refine.frame(&at(&turned), &mut found), 1);
    for (found, expected) in found.iter().zip(&turned) {
        assert!(vec3::length(vec3::sub(*found, *expected)) < 1e-9);
    }
    let mut numbers = Numbers::new(7);
    let pose: Vec<[f64; 3]> =
        at(&rig.surface().rest).iter().map(|x| x.map(|x| x + 0.3 * numbers.signed())).collect();
    let mut found = evaluate(&rig, &pose).positions;
    refine.frame(&pose, &mut found);
    assert_eq!(at(&found), pose);
}

#[test]
fn a_rig_with_examples_is_not_refined() {
    let mut body = cylinder(1.0);
    body.face.examples =
        vec![Example { name: "bent".into(), positions: body.bent.clone(), mirror: false, noise: None }];
    let error = Refine::new(&body.rig(true), &NoProgress).err().unwrap().to_string();
    assert!(error.contains("the rig has 1 example"), "{error}");
}
