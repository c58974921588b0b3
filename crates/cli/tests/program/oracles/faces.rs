//! The faces whose files are opened.

use super::animation::Animation;
use crate::common;
use rhytid::Face;
use rhytid::core::{Example, RigidMotion, Settings, UpAxis, Uvs};
use rhytid::formats::{mesh, tables, take};
use rhytid_test_support::shared;
use std::path::Path;
use std::sync::OnceLock;

/// The demo's face unchanged: Y up, in centimetres, a texture coordinate per vertex. Its brows rise.
pub(super) fn demo() -> &'static Animation {
    static DEMO: OnceLock<Animation> = OnceLock::new();
    DEMO.get_or_init(|| {
        let face = rhytid_demo::face(2000);
        Animation::new(&face, &rhytid_demo::performance(&face), 176..206)
    })
}

/// The demo's face with Z up and in millimetres, on a head that turns and moves. A cut in its texture runs
/// down the middle, where glTF doubles vertices.
pub(super) fn other_axes_and_units() -> &'static Animation {
    static OTHER: OnceLock<Animation> = OnceLock::new();
    OTHER.get_or_init(make_other)
}

fn make_other() -> Animation {
    let mut face = rhytid_demo::face(2000);
    face.name = "z_up".into();
    let turn = |[x, y, z]: [f64; 3]| [10.0 * x, -10.0 * z, 10.0 * y];
    face.up_axis = UpAxis::Z;
    face.metres_per_unit = 0.001;
    let meshes = face.examples.iter_mut().map(|e| &mut e.positions);
    for position in meshes.chain([&mut face.neutral.positions]).flatten() {
        *position = turn(*position);
    }
    let neutral = &mut face.neutral;
    let uvs = neutral.uvs.as_mut().expect("the demo has texture coordinates");
    let right_half: Vec<bool> = neutral
        .faces
        .iter()
        .flat_map(|corners| {
            let right = corners.iter().all(|&v| neutral.positions[v as usize][0] >= 0.0);
            corners.iter().map(move |_| right)
        })
        .collect();
    *uvs = cut(uvs, &neutral.faces.indices, &right_half);
    let mut take = rhytid_demo::performance(&face);
    take.head = Some((0..take.frames()).map(|frame| head(frame as f64)).collect());
    Animation::new(&face, &take, 0..20)
}

/// Turned about an axis along none of the mesh's, and moved.
fn head(frame: f64) -> RigidMotion {
    let (sine, cosine) = (0.01 * frame + 0.1).sin_cos();
    RigidMotion {
        rotation: [sine * 2.0 / 7.0, sine * 3.0 / 7.0, sine * 6.0 / 7.0, cosine],
        translation: [frame, 20.0 - 0.5 * frame, 0.3 * frame],
    }
}

/// Texture coordinates per corner. The chosen corners have coordinates of their own, moved aside.
fn cut(uvs: &Uvs, vertices: &[u32], chosen: &[bool]) -> Uvs {
    let own: Vec<u32> = uvs.corners.clone().unwrap_or_else(|| vertices.to_vec());
    let count = uvs.values.len() as u32;
    let moved = uvs.values.iter().map(|[u, v]| [u + 1.0, *v]);
    let corners = own.iter().zip(chosen).map(|(i, chosen)| if *chosen { i + count } else { *i });
    Uvs { values: uvs.values.iter().copied().chain(moved).collect(), corners: Some(corners.collect()) }
}

/// The real head, if the test data is there: many parts, seams, quads among triangles. It has the first
/// seconds of its take.
pub(super) fn real_head() -> Option<&'static Animation> {
    static HEAD: OnceLock<Animation> = OnceLock::new();
    let data = shared("data")?;
    Some(HEAD.get_or_init(|| make_head(&data)))
}

fn make_head(data: &Path) -> Animation {
    let neutral_path = data.join("head/neutral.obj");
    let neutral = mesh::read(&neutral_path).unwrap();
    let poses = common::list(&data.join("head/poses")).into_iter().filter(|name| name.ends_with(".obj"));
    let examples = poses.map(|name| Example {
        mirror: false,
        positions: mesh::read_like(&neutral, &neutral_path, &data.join("head/poses").join(&name)).unwrap(),
        name,
        noise: None,
    });
    let face = Face {
        name: "head".into(),
        examples: examples.collect(),
        metres_per_unit: 0.01,
        up_axis: UpAxis::Y,
        handles: tables::read_handles(&data.join("markers.csv")).unwrap(),
        prior: None,
        settings: Settings { bending_length: Some(3.0), ..Settings::default() },
        neutral,
    };
    let labels = &face.handles.labels;
    let take = take::read(&data.join("takes/rom_3_clean.csv"), Some(labels), take::Missing::Error).unwrap();
    // To the middle of a blink.
    Animation::new(&face, &take, 0..41)
}
