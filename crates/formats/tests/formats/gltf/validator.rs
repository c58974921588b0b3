//! Khronos' validator.

use super::cases::{animation, cases};
use super::tools::{node, unfold};
use crate::animation::{Animation, UvKind};
use rhytid_formats::export::Options;
use serde_json::Value;
use std::path::PathBuf;

/// Some notes of the validator are expected. Texture coordinates without a texture are meant for a later one.
/// One of the sheet's vertices has no face. The validator does not know the compression, so it also checks
/// the decompressed files.
const HARMLESS: [&str; 7] = [
    "UNUSED_OBJECT /meshes/0/primitives/0/attributes/TEXCOORD_0",
    "UNUSED_OBJECT /meshes/0/primitives/0/attributes/_VERTEX_ID",
    "UNUSED_OBJECT /meshes/0/primitives/0/attributes/_STRAIN",
    "UNSUPPORTED_EXTENSION /extensionsUsed",
    "UNSUPPORTED_EXTENSION /extensionsRequired",
    "UNUSED_OBJECT /buffers/0",
    // Textures beside a GLB are there because they were asked for.
    "URI_GLB /images/",
];

/// The issues of each file: errors, warnings and infos.
pub(super) fn validate(files: &[PathBuf]) -> Vec<[Vec<String>; 3]> {
    let issues = |report: &Value| {
        ["errors", "warnings", "infos"].map(|kind| serde_json::from_value(report[kind].clone()).unwrap())
    };
    node("validate.mjs", files).iter().map(issues).collect()
}

/// Fails if the validator has found anything in one of `files`.
pub(crate) fn assert_valid(files: &[PathBuf]) {
    for (file, [errors, warnings, infos]) in files.iter().zip(validate(files)) {
        assert_eq!((&errors, &warnings), (&vec![], &vec![]), "{}", file.display());
        // Every primitive has what the first one has.
        let of_first = |info: &str| {
            (1..4)
                .fold(info.to_owned(), |info, i| info.replace(&format!("/primitives/{i}/"), "/primitives/0/"))
        };
        let is_harmless = |info: &str| HARMLESS.iter().any(|known| of_first(info).starts_with(known));
        let infos: Vec<&String> = infos.iter().filter(|info| !is_harmless(info)).collect();
        assert!(infos.is_empty(), "{}: {infos:?}", file.display());
    }
}

#[test]
fn khronos_validator_finds_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut files: Vec<PathBuf> = cases().iter().map(|case| case.export(folder.path()).0).collect();
    let base = animation(UvKind::PerVertex, 5, 20);
    let odd = [
        Animation { name: "1st scan \"Zoë\"\n\\ 100 %".into(), metres_per_unit: 1.0, ..base.clone() },
        Animation { rate: 120.0, first_time_code: -2.5, name: String::new(), ..base },
    ];
    for (i, animation) in odd.iter().enumerate() {
        files.push(folder.path().join(format!("odd {i}.gltf")));
        animation.export_with(&files[files.len() - 1], &Options::default()).unwrap();
    }
    assert_valid(&files);
    assert_valid(&unfold(&files));
}

#[test]
fn khronos_validator_would_find_something() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.glb");
    animation(UvKind::None, 2, 28).export_with(&path, &Options::default()).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    // Behind the targets come two times and four weights. Before them, the last number is the z of the last
    // target's last normal; and 34 normals earlier is one of its positions, whose bounds are told.
    let end = bytes.len() - 24;
    bytes[end - 4..end].copy_from_slice(&f32::NAN.to_le_bytes());
    bytes[end - 34 * 12 - 4..end - 34 * 12].copy_from_slice(&1e3_f32.to_le_bytes());
    std::fs::write(&path, bytes).unwrap();
    let [errors, ..] = &validate(&[path])[0];
    for expected in ["ACCESSOR_INVALID_FLOAT", "ACCESSOR_MAX_MISMATCH"] {
        assert!(errors.iter().any(|error| error.starts_with(expected)), "{expected}: {errors:?}");
    }
}
