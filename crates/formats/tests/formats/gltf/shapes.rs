//! Named shapes.

use super::cases::animation;
use super::tools::{refused, unfold};
use super::validator::assert_valid;
use super::viewer::Viewer;
use crate::animation::{Random, UvKind};
use rhytid_core::{InputErrorKind, NoProgress, Remedy, UpAxis};
use rhytid_formats::animation;
use rhytid_formats::export::{Options, Shape, Shapes};

#[test]
fn each_shape_is_a_named_target_that_nothing_moves() {
    let folder = tempfile::tempdir().unwrap();
    let base = animation(UvKind::PerCorner, 1, 60);
    let mut random = Random(61);
    let mut files = Vec::new();
    for bits in 0..8 {
        let [quantize, meshopt, normals] = std::array::from_fn(|bit| bits >> bit & 1 == 1);
        let shapes: Vec<Shape> = ["smile", "Stirn hoch – ä"]
            .map(|name| Shape {
                name: name.into(),
                offsets: base.rest.iter().map(|_| random.vector(2.0)).collect(),
                normal_offsets: normals.then(|| base.rest.iter().map(|_| random.vector(0.4)).collect()),
            })
            .into();
        let scene = Shapes {
            name: "face",
            rest: &base.rest,
            rest_normals: normals.then_some(base.rest_normals.as_slice()),
            faces: &base.faces,
            triangle_corners: &base.triangle_corners,
            uvs: base.uvs.as_ref(),
            materials: None,
            metres_per_unit: 0.001,
            up_axis: UpAxis::Z,
            recipe: &base.recipe,
            shapes: &shapes,
        };
        let path = folder.path().join(format!("{bits}.{}", if meshopt { "gltf" } else { "glb" }));
        let options = Options { quantize, meshopt, ..Options::default() };
        let written = animation::write_shapes(&path, &scene, &options, &NoProgress).unwrap();
        assert_eq!((written.targets, !written.errors.is_empty()), (Some(2), quantize));

        let viewer = Viewer::open(&unfold(std::slice::from_ref(&path))[0]);
        assert!(viewer.times.is_empty() && viewer.weights.is_empty() && viewer.targets.len() == 2);
        assert_eq!(viewer.weights_at_rest, [0.0; 2]);
        let mesh = viewer.document.meshes().next().unwrap();
        let names: serde_json::Value = serde_json::from_str(mesh.extras().as_ref().unwrap().get()).unwrap();
        assert_eq!(names, serde_json::json!({ "targetNames": ["smile", "Stirn hoch – ä"] }));
        // What is stored as integers is scaled by the node.
        let [scale, rounding] = match quantize {
            true => [viewer.node[0][0] / 0.001, written.errors[0].worst],
            false => [1.0, 0.0],
        };
        for ((positions, to_normals), shape) in viewer.targets.iter().zip(&shapes) {
            assert_eq!(to_normals.is_some(), normals);
            for (w, offset) in positions.iter().enumerate() {
                let v = viewer.ids[w] as usize;
                for (axis, &given) in shape.offsets[v].iter().enumerate() {
                    // The base is rounded too.
                    let off = (offset[axis] * scale - f64::from(given)).abs();
                    assert!(off <= 2.0 * rounding, "{bits}: {off}");
                }
            }
        }
        files.push(path);
    }
    assert_valid(&files);
    assert_valid(&unfold(&files));
}

#[test]
fn more_than_256_shapes_need_force() {
    let folder = tempfile::tempdir().unwrap();
    let base = animation(UvKind::None, 1, 62);
    let shape = |k| Shape { name: format!("{k}"), offsets: base.rest.clone(), normal_offsets: None };
    let shapes: Vec<Shape> = (0..257).map(shape).collect();
    let scene = Shapes {
        name: "face",
        rest: &base.rest,
        rest_normals: None,
        faces: &base.faces,
        triangle_corners: &base.triangle_corners,
        uvs: None,
        materials: None,
        metres_per_unit: 0.001,
        up_axis: UpAxis::Y,
        recipe: &base.recipe,
        shapes: &shapes,
    };
    let path = folder.path().join("face.glb");
    let error = refused(animation::write_shapes(&path, &scene, &Options::default(), &NoProgress));
    assert!(error.sentence().contains("257 shapes"), "{error}");
    let remedies = [Remedy::MostTargets, Remedy::Force];
    assert_eq!((error.kind(), error.remedies()), (&InputErrorKind::TooLarge, &remedies[..]));
    for options in [
        Options { force: true, ..Options::default() },
        Options { most_targets: Some(257), ..Options::default() },
    ] {
        animation::write_shapes(&path, &scene, &options, &NoProgress).unwrap();
    }
    let few = Options { most_targets: Some(64), ..Options::default() };
    let error = refused(animation::write_shapes(&path, &scene, &few, &NoProgress));
    assert!(error.sentence().contains("the limit of 64 morph targets"), "{error}");
}
