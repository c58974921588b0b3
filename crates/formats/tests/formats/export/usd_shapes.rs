//! Shapes as USD, as USD's own skeleton library applies them.
use super::common::{EXTENSIONS, files_in, input_error, python, python_usd_24_3, root, run};
use crate::animation::{Random, UvKind, with_everything};
use rhytid_core::NoProgress;
use rhytid_formats::animation;
use rhytid_formats::export::{Options, Shape, Shapes};
use serde_json::json;
use std::path::Path;
use std::process::Command;

/// A dense shape, one of few vertices, and one that moves nothing; two of them with names that are alike.
fn shapes(vertices: usize, with_normals: bool) -> Vec<Shape> {
    let mut random = Random(40);
    let mut offsets = |every: usize| -> Vec<[f32; 3]> {
        (0..vertices)
            .map(|v| match v % every {
                0 => std::array::from_fn(|_| random.below(1000) as f32 / 77.0 - 6.0),
                _ => [0.0; 3],
            })
            .collect()
    };
    [("smile left", 1), ("smile-left", 5), ("Zähne \"weit\"", 1000)]
        .map(|(name, every)| Shape {
            name: name.into(),
            offsets: offsets(every),
            normal_offsets: with_normals.then(|| offsets(every)),
        })
        .to_vec()
}

fn check(python: &Path) {
    for with_normals in [true, false] {
        let folder = tempfile::tempdir().unwrap();
        let mut animation = with_everything(UvKind::PerCorner, 1, 41);
        animation.with_normals = with_normals;
        let shapes = shapes(animation.rest.len(), with_normals);
        let described = described(&animation, &shapes);
        let mut sizes = Vec::new();
        for extension in ["usd", "usdc", "usda", "usdz"] {
            let path = folder.path().join(format!("shapes.{extension}"));
            let written =
                animation::write_shapes(&path, &described, &Options::default(), &NoProgress).unwrap();
            assert_eq!(written.bytes, std::fs::metadata(&path).unwrap().len());
            sizes.push(written.bytes);
        }
        assert!(sizes[0] == sizes[1] && sizes[3] > sizes[1], "{sizes:?}");
        let expected = json!({
            "rest": animation.rest,
            "rest_normals": with_normals.then_some(&animation.rest_normals),
            "recipe": animation.recipe,
            "shapes": shapes.iter().map(|shape| json!([shape.name, shape.offsets, shape.normal_offsets]))
                .collect::<Vec<_>>(),
        });
        std::fs::write(folder.path().join("expected.json"), expected.to_string()).unwrap();
        let script = root().join("crates/formats/tests/formats/export/usd_shapes_check.py");
        let printed = run(Command::new(python).arg(script).arg(folder.path()));
        assert!(printed.contains("4 files hold 3 shapes"), "{printed}");
    }
}

/// Shapes of the mesh of an animation.
pub(super) fn described<'a>(animation: &'a crate::animation::Animation, shapes: &'a [Shape]) -> Shapes<'a> {
    let scene = animation.scene();
    Shapes {
        name: scene.name,
        rest: scene.rest,
        rest_normals: scene.rest_normals,
        faces: scene.faces,
        triangle_corners: scene.triangle_corners,
        uvs: scene.uvs,
        materials: scene.materials,
        metres_per_unit: scene.metres_per_unit,
        up_axis: scene.up_axis,
        recipe: scene.recipe,
        shapes,
    }
}

#[test]
fn usd_applies_the_shapes_and_its_validators_report_nothing() {
    check(&python());
}

#[test]
fn the_oldest_usd_applies_the_shapes_too() {
    check(&python_usd_24_3());
}

#[test]
fn shapes_that_make_no_sense_are_refused() {
    let mut animation = with_everything(UvKind::None, 1, 42);
    type Damage = fn(&mut Vec<Shape>);
    let damages: [(&str, Damage); 7] = [
        ("has no shapes", Vec::clear),
        ("“smile-left” has 33 offsets for 34 vertices", |s| s[1].offsets.truncate(33)),
        ("has offsets that are not finite, first at vertex 5", |s| s[0].offsets[5][1] = f32::NAN),
        ("has 35 normal offsets", |s| s[0].normal_offsets.as_mut().unwrap().push([0.0; 3])),
        ("normal offsets that are not finite, first at vertex 0", |s| {
            s[2].normal_offsets.as_mut().unwrap()[0][0] = f32::INFINITY;
        }),
        ("“smile-left” differs from the first shape", |s| s[1].normal_offsets = None),
        ("“smile left” has the name of another shape", |s| s[1].name = "smile left".into()),
    ];
    let folder = tempfile::tempdir().unwrap();
    let refused = |animation: &crate::animation::Animation, shapes: &[Shape], extension: &str| {
        let path = folder.path().join(format!("shapes.{extension}"));
        let described = described(animation, shapes);
        input_error(animation::write_shapes(&path, &described, &Options::default(), &NoProgress))
    };
    for extension in EXTENSIONS {
        for (expected, damage) in &damages {
            let mut shapes = shapes(animation.rest.len(), true);
            damage(&mut shapes);
            let message = refused(&animation, &shapes, extension);
            assert!(message.contains(expected), "“{message}” lacks “{expected}”");
        }
    }
    animation.with_normals = false;
    let message = refused(&animation, &shapes(animation.rest.len(), true), "usd");
    assert!(message.contains("expected none where there are no rest normals"), "{message}");
    animation.rest[3][0] = f32::NAN;
    let message = refused(&animation, &shapes(animation.rest.len(), false), "usd");
    assert!(message.contains("the shapes of “face”: has a rest position that is not finite"), "{message}");
    assert_eq!(files_in(folder.path()), [""; 0]);
}
