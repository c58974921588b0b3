//! Refused exports, and the advice in the messages.

use super::cases::animation;
use super::tools::{input_error, refused};
use crate::animation::{Animation, UvKind};
use rhytid_core::{InputErrorKind, Remedy};
use rhytid_formats::animation;
use rhytid_formats::export::{Exporter, Options, Scene};
use std::path::Path;

/// What `create` says to `frames` frames of `vertices` vertices.
fn create(
    folder: &Path,
    [vertices, frames]: [usize; 2],
    extension: &str,
    options: Options,
) -> rhytid_core::Result<Box<dyn Exporter>> {
    let mut big: Animation = animation(UvKind::None, 1, 29);
    big.rest.resize(vertices, [0.0; 3]);
    big.rest_normals.resize(vertices, [0.0; 3]);
    animation::create(
        &folder.join("face").with_extension(extension),
        &Scene { frames, ..big.scene() },
        &options,
    )
}

#[test]
fn more_than_256_targets_need_force() {
    let folder = tempfile::tempdir().unwrap();
    let force = || Options { force: true, ..Options::default() };
    for extension in ["glb", "gltf"] {
        create(folder.path(), [40, 256], extension, Options::default()).unwrap();
        let error = refused(create(folder.path(), [40, 257], extension, Options::default()));
        for advice in ["257 frames", "256", ".usd", "fewer frames", "compress to", "lift the limit"] {
            assert!(error.sentence().contains(advice), "“{error}” lacks “{advice}”");
        }
        assert_eq!(error.kind(), &InputErrorKind::TooLarge);
        let remedies = [Remedy::FewerFrames, Remedy::Compress, Remedy::MostTargets, Remedy::Force];
        assert_eq!(error.remedies(), remedies);
        create(folder.path(), [40, 257], extension, force()).unwrap();
        // A program's own limit, larger or smaller.
        let most = |most_targets| Options { most_targets: Some(most_targets), ..Options::default() };
        create(folder.path(), [40, 257], extension, most(257)).unwrap();
        create(folder.path(), [40, 64], extension, most(64)).unwrap();
        let error = refused(create(folder.path(), [40, 65], extension, most(64)));
        assert!(error.sentence().contains("the limit of 64 morph targets"), "{error}");
        // Each frame has a weight for each target, and a GLB ends at 4 GiB.
        let many = if extension == "glb" { 30_000 } else { 65_535 };
        create(folder.path(), [40, many], extension, force()).unwrap();
        let error = refused(create(folder.path(), [40, 65_536], extension, force()));
        assert!(error.sentence().contains("65535"), "{error}");
        assert_eq!(error.remedies(), [Remedy::FewerFrames, Remedy::Compress]);
    }
}

#[test]
fn more_than_1_gib_needs_force_and_a_glb_ends_at_4() {
    let folder = tempfile::tempdir().unwrap();
    let with = |quantize, force| Options { quantize, force, ..Options::default() };
    // 24 bytes for each, or 12.
    for (vertices, quantize, force, extension, accepted) in [
        (170_000, false, false, "glb", true),
        (180_000, false, false, "glb", false),
        (180_000, false, false, "gltf", false),
        (180_000, true, false, "glb", true),
        (360_000, true, false, "glb", false),
        (180_000, false, true, "glb", true),
        (690_000, false, true, "glb", true),
        (720_000, false, true, "glb", false),
        (720_000, true, true, "glb", true),
        (720_000, false, true, "gltf", true),
    ] {
        let found = create(folder.path(), [vertices, 256], extension, with(quantize, force));
        if accepted {
            found.unwrap();
            continue;
        }
        let error = refused(found);
        let message = error.sentence();
        for advice in [if force { "4 GiB" } else { "1 GiB" }, ".usd", "fewer frames", "quantised", "meshopt"]
        {
            assert!(message.contains(advice), "“{message}” lacks “{advice}”");
        }
        for remedy in [Remedy::FewerFrames, Remedy::Compress, Remedy::Quantize, Remedy::Meshopt] {
            assert!(error.remedies().contains(&remedy), "{remedy:?}");
        }
        assert_eq!(error.remedies().contains(&Remedy::Force), !force, "{message}");
        let fit =
            message.split("about ").nth(1).unwrap().split(' ').next().unwrap().parse::<usize>().unwrap();
        assert!((200..256).contains(&fit), "{message}");
    }
    create(folder.path(), [720_000, 256], "glb", Options { meshopt: true, ..Options::default() }).unwrap();
}

#[test]
fn more_vertices_than_floats_can_number_are_not_numbered() {
    let folder = tempfile::tempdir().unwrap();
    let numbered = Options { vertex_ids: true, ..Options::default() };
    let message = input_error(create(folder.path(), [(1 << 24) + 1, 1], "glb", numbered));
    assert!(message.contains("16777216") && message.contains(".usd"), "{message}");
}

#[test]
fn offsets_that_overflow_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.glb");
    let mut animation = animation(UvKind::None, 2, 31);
    animation.frames[0][0][16] = -3e38;
    animation.frames[1][0][16] = 3e38;
    let message = input_error(animation.export_with(&path, &Options::default()));
    assert!(message.contains("frame 1 (from 0), vertex 5"), "{message}");
    let quantize = Options { quantize: true, ..Options::default() };
    let error = refused(animation.export_with(&path, &quantize));
    assert!(error.sentence().contains("without quantising"), "{error}");
    assert_eq!(error.remedies(), [Remedy::DoNotQuantize]);
}
