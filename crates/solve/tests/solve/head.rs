//! The head of avatars that are made of simple parts: a body, trousers, shoes, and hair.
use glam::DVec3;
use rhytid_core::{Example, Face, Materials, Settings, UpAxis};
use rhytid_core::{Handles, Mesh};
use rhytid_solve::Skin;
use rhytid_solve::head::{Part, find};
use std::f64::consts::TAU;

/// The underside of the chin, in metres above the ground.
const CHIN: f64 = 1.52;

/// A mesh in named parts.
#[derive(Default)]
struct Avatar {
    mesh: Mesh,
    parts: Vec<Part>,
}

impl Avatar {
    /// Adds a tube of `around` × `along` vertices; `place` gets the angle from the front, and 0 at the top to
    /// 1.
    fn add(&mut self, name: &str, around: u32, along: u32, place: impl Fn(f64, f64) -> DVec3) {
        let first = self.mesh.positions.len() as u32;
        for j in 0..along {
            for i in 0..around {
                let place =
                    place(TAU * f64::from(i) / f64::from(around), f64::from(j) / f64::from(along - 1));
                self.mesh.positions.push(place.to_array());
            }
        }
        let at = |i: u32, j: u32| first + j * around + i % around;
        for j in 0..along - 1 {
            for i in 0..around {
                self.mesh.faces.push(&[at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
            }
        }
        let vertices = (first..self.mesh.positions.len() as u32).collect();
        self.parts.push(Part { name: name.into(), vertices });
    }

    fn vertices(&self, name: &str) -> &[u32] {
        &self.parts.iter().find(|part| part.name == name).unwrap().vertices
    }

    /// The avatar as a face, with an example that moves some of its vertices.
    fn face(&self, moves: impl Fn(DVec3) -> f64) -> Face {
        let moved =
            |x: &[f64; 3]| (DVec3::from_array(*x) - DVec3::Y * moves(DVec3::from_array(*x))).to_array();
        let positions: Vec<[f64; 3]> = self.mesh.positions.iter().map(moved).collect();
        let example = Example { name: "open".into(), positions, mirror: false, noise: None };
        let examples = if example.positions == self.mesh.positions { Vec::new() } else { vec![example] };
        Face {
            name: "avatar".into(),
            neutral: self.mesh.clone(),
            metres_per_unit: 1.0,
            up_axis: UpAxis::Y,
            handles: Handles::default(),
            examples,
            prior: None,
            settings: Settings { align: false, ..Settings::default() },
        }
    }
}

/// The outline of a head and a body at a height: half its width, half its depth, and where its middle is.
fn outline(y: f64) -> [f64; 3] {
    // Crown, temples, cheeks, chin, throat, shoulders, hips.
    let rows = [
        [1.76, 0.002, 0.002, 0.0],
        [1.74, 0.05, 0.06, 0.0],
        [1.70, 0.075, 0.095, 0.0],
        [1.60, 0.075, 0.095, 0.0],
        [CHIN, 0.045, 0.08, 0.015],
        [1.50, 0.05, 0.055, -0.02],
        [1.46, 0.055, 0.06, -0.03],
        [1.40, 0.2, 0.09, -0.02],
        [0.95, 0.17, 0.11, 0.0],
    ];
    let below = rows.iter().position(|row| row[0] <= y).unwrap_or(rows.len() - 1).max(1);
    let ([top, a @ ..], [bottom, b @ ..]) = (rows[below - 1], rows[below]);
    let share = ((top - y) / (top - bottom)).clamp(0.0, 1.0);
    std::array::from_fn(|i| a[i] + share * (b[i] - a[i]))
}

/// An avatar whose trousers have most of the vertices.
fn avatar(head_is_alone: bool, with_hair: bool) -> Avatar {
    let mut avatar = Avatar::default();
    let skin = |from: f64, to: f64| {
        move |angle: f64, along: f64| {
            let y = from + along * (to - from);
            let [width, depth, middle] = outline(y);
            let x = width * angle.sin();
            let bump =
                |at: f64, [wide, high]: [f64; 2]| (-(x / wide).powi(2) - ((y - at) / high).powi(2)).exp();
            // Nose, and sockets of the eyes.
            let eyes =
                [-0.032, 0.032].map(|at| (-((x - at) / 0.014).powi(2) - ((y - 1.66) / 0.012).powi(2)).exp());
            let front = 0.028 * bump(1.61, [0.012, 0.022]) - 0.008 * (eyes[0] + eyes[1]);
            DVec3::new(x, y, middle + depth * angle.cos() + if angle.cos() > 0.0 { front } else { 0.0 })
        }
    };
    for (name, side) in [("shoe_l", 1.0), ("shoe_r", -1.0)] {
        avatar.add(name, 24, 16, |angle, along| {
            let round = (along * 0.5 * TAU).sin();
            let x = 0.05 * round * angle.sin();
            DVec3::new(0.12 * side + x, 0.1 - 0.1 * along, 0.05 + (0.1 + 0.05 * along) * round * angle.cos())
        });
    }
    for (name, side) in [("trousers_l", 1.0), ("trousers_r", -1.0)] {
        avatar.add(name, 96, 160, |angle, along| {
            let fold = 0.003 * (40.0 * along).sin();
            let r = 0.1 - 0.03 * along + fold;
            DVec3::new(0.1 * side + r * angle.sin(), 0.95 - 0.85 * along, r * angle.cos())
        });
    }
    if head_is_alone {
        avatar.add("torso", 48, 40, skin(1.45, 0.95));
        avatar.add("Mesh_Head", 64, 60, skin(1.76, 1.46));
    } else {
        avatar.add("body", 64, 140, skin(1.76, 0.95));
    }
    if with_hair {
        avatar.add("hair", 64, 40, |angle, along| {
            let y = 1.78 - 0.3 * along;
            let [width, depth, middle] = outline(y.clamp(1.6, 1.735));
            // Open in front of the face.
            let angle = if along > 0.2 { 0.9 + angle * (TAU - 1.8) / TAU } else { angle };
            DVec3::new((width + 0.02) * angle.sin(), y, middle + (depth + 0.02) * angle.cos())
        });
    }
    avatar
}

/// The lower half of the face, which the jaw moves. Hair at its sides stays.
fn jaw(x: DVec3) -> f64 {
    if x.z > 0.03 && x.x.abs() < 0.05 && (CHIN - 0.02..1.6).contains(&x.y) { 0.01 } else { 0.0 }
}

fn check(face: &Face, head: &[u32], parts: &[Part], why: &str) {
    let found = find(face, parts, None).unwrap();
    assert!(found.why.contains(why), "{}", found.why);
    let to_y = |x: [f64; 3]| if face.up_axis == UpAxis::Y { x } else { [x[0], x[2], -x[1]] };
    let metres = face.metres_per_unit;
    let mut of_head = vec![false; face.neutral.positions.len()];
    head.iter().for_each(|&v| of_head[v as usize] = true);
    for (v, is_in) in found.vertices.iter().enumerate() {
        let [_, y, _] = to_y(face.neutral.positions[v]);
        assert!(!is_in || (of_head[v] && y * metres > 1.3), "vertex {v} at {y}");
        // All of the head above its chin is found.
        assert!(*is_in || !of_head[v] || y * metres < CHIN, "vertex {v} at {y}");
    }
    let [width, height, depth] = to_y(found.size).map(|size| size.abs() * metres);
    assert!((0.14..0.19).contains(&width) && (0.2..0.3).contains(&height) && (0.15..0.3).contains(&depth));
    let skin = Skin::from_region(face, &found).unwrap();
    let spread = skin.spread(30, &[]);
    assert!(spread.len() >= 25, "{}", spread.len());
    for v in spread {
        let [_, y, z] = to_y(face.neutral.positions[v.index()]).map(|x| x * metres);
        assert!((CHIN - 0.02..1.73).contains(&y) && z > 0.0, "{y} {z}");
    }
}

#[test]
fn the_head_of_an_avatar_is_found_and_not_a_trouser_leg() {
    for (alone, hair) in [(true, true), (true, false), (false, true), (false, false)] {
        let avatar = avatar(alone, hair);
        let head = avatar.vertices(if alone { "Mesh_Head" } else { "body" });
        check(&avatar.face(jaw), head, &avatar.parts, "the examples move");
        check(&avatar.face(|_| 0.0), head, &[], "the shape of a face");
        if alone {
            check(&avatar.face(|_| 0.0), head, &avatar.parts, "\"Mesh_Head\"");
        }
        // Cloth that moves by a hair's breadth.
        let noise = |x: DVec3| jaw(x) + if x.y < 0.95 { 1e-6 } else { 0.0 };
        check(&avatar.face(noise), head, &[], "the examples move");
    }
}

#[test]
fn units_and_axes_do_not_matter() {
    let avatar = avatar(true, true);
    for with_examples in [true, false] {
        let mut face = avatar.face(|x| if with_examples { jaw(x) } else { 0.0 });
        let examples = face.examples.iter_mut().flat_map(|example| &mut example.positions);
        for x in face.neutral.positions.iter_mut().chain(examples) {
            *x = [100.0 * x[0], -100.0 * x[2], 100.0 * x[1]];
        }
        (face.up_axis, face.metres_per_unit) = (UpAxis::Z, 0.01);
        let why = if with_examples { "the examples move" } else { "the shape of a face" };
        check(&face, avatar.vertices("Mesh_Head"), &[], why);
    }
}

#[test]
fn a_part_that_is_named_is_the_head() {
    let avatar = avatar(true, true);
    let mut face = avatar.face(jaw);
    let found = find(&face, &avatar.parts, Some("mesh_head")).unwrap();
    let members: Vec<u32> = (0..).zip(&found.vertices).filter(|(_, is)| **is).map(|(v, _)| v).collect();
    assert_eq!(members, avatar.vertices("Mesh_Head"));
    let said = find(&face, &avatar.parts[..2], Some("kopf")).unwrap_err().to_string();
    assert_eq!(said, "no part of the mesh is called \"kopf\"; it has \"shoe_l\", \"shoe_r\"");

    // Materials are parts too: the hair's faces are the last ones.
    let faces = face.neutral.faces.len();
    let of_face = (0..faces).map(|f| u32::from(f >= faces - 64 * 39)).collect();
    face.neutral.materials = Some(Materials::named(["all", "strands"], of_face));
    let found = find(&face, &[], Some("strands")).unwrap();
    let members: Vec<u32> = (0..).zip(&found.vertices).filter(|(_, is)| **is).map(|(v, _)| v).collect();
    assert_eq!(members, avatar.vertices("hair"));
}

#[test]
fn clothes_without_a_head_are_an_error() {
    let mut avatar = avatar(true, true);
    let head: Vec<u32> = [avatar.vertices("Mesh_Head"), avatar.vertices("torso")].concat();
    let faces = std::mem::take(&mut avatar.mesh.faces);
    for corners in faces.iter().filter(|corners| corners.iter().all(|v| !head.contains(v))) {
        avatar.mesh.faces.push(corners);
    }
    let said = find(&avatar.face(|_| 0.0), &avatar.parts, None).unwrap_err().to_string();
    assert!(said.contains("none of them is certainly the head") && said.contains("name its part"), "{said}");
}
