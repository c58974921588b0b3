//! Files of USD's own library.
use super::{json, make};
use rhytid_core::channel;
use rhytid_formats::animation;
use rhytid_formats::export::HeadMotion;
use rhytid_formats::usd::read;
use serde_json::Value as Json;
use std::path::Path;

/// What differs first, as a path and both sides.
fn first_difference(path: &str, found: &Json, expected: &Json) -> Option<String> {
    match (found, expected) {
        (Json::Object(a), Json::Object(b)) => {
            let keys: std::collections::BTreeSet<&String> = a.keys().chain(b.keys()).collect();
            let missing = Json::String("(missing)".into());
            keys.into_iter().find_map(|key| {
                first_difference(
                    &format!("{path}/{key}"),
                    a.get(key).unwrap_or(&missing),
                    b.get(key).unwrap_or(&missing),
                )
            })
        }
        _ => (found != expected).then(|| {
            let [found, expected] =
                [found, expected].map(|json| json.to_string().chars().take(300).collect::<String>());
            format!("{path}: found {found}, expected {expected}")
        }),
    }
}

fn check(path: &Path) {
    let expected = std::fs::read_to_string(
        path.with_extension(format!("{}.json", path.extension().unwrap().to_str().unwrap())),
    );
    let expected: Json = serde_json::from_str(&expected.unwrap()).unwrap();
    let mut opened = read::open(path).unwrap();
    let found = json::layer(&mut opened);
    assert_eq!(first_difference("", &found, &expected), None, "{}", path.display());
}

#[test]
fn crate_files_and_text_hold_what_usd_reads_from_them() {
    let folder = tempfile::tempdir().unwrap();
    for minor in 4..=14 {
        let version = format!("0.{minor}.0");
        make(folder.path(), &version, &[]);
        let crate_file = folder.path().join(format!("small-{version}.usdc"));
        assert_eq!(std::fs::read(&crate_file).unwrap()[8..11], [0, minor, 0]);
        check(&crate_file);
        check(&folder.path().join(format!("small-{version}.usda")));
    }
    // That text tells types apart as the crate file does, from their names.
    let [a, b] =
        ["usda", "usdc"].map(|extension| read::open(&folder.path().join(format!("small-0.8.0.{extension}"))));
    let [a, b] = [a, b].map(|opened| opened.unwrap().layer.metadata);
    assert_eq!(sorted(a), sorted(b));
}

fn sorted(mut fields: rhytid_formats::usd::layer::Fields) -> rhytid_formats::usd::layer::Fields {
    fields.sort_by(|a, b| a.0.cmp(&b.0));
    fields
}

#[test]
fn a_package_is_its_first_layer() {
    let folder = tempfile::tempdir().unwrap();
    make(folder.path(), "0.8.0", &["package"]);
    let [mut package, mut layer] =
        ["plain.usdz", "plain.usdc"].map(|name| read::open(&folder.path().join(name)).unwrap());
    assert_eq!(first_difference("", &json::layer(&mut package), &json::layer(&mut layer)), None);
}

#[test]
fn an_animation_is_found() {
    let folder = tempfile::tempdir().unwrap();
    make(folder.path(), "0.8.0", &[]);
    for extension in ["usda", "usdc"] {
        let path = folder.path().join(format!("small-0.8.0.{extension}"));
        let mut reader = animation::open(&path).unwrap();
        let summary = reader.summary().clone();
        assert_eq!((summary.vertices, summary.faces.len(), summary.frames), (40, 50, 5));
        assert_eq!((summary.first_time_code, summary.rate), (-2.0, 30000.0 / 1001.0));
        assert_eq!(summary.up_axis, rhytid_core::UpAxis::Z);
        assert_eq!(summary.metres_per_unit, 0.01);
        assert!(summary.has(&channel::NORMALS) && summary.has(&channel::VELOCITIES) && summary.head);
        let recipe = summary.recipe.unwrap().recipe().unwrap();
        assert_eq!(
            (recipe.rig.len(), recipe.first_frame, recipe.end_frame, recipe.fps),
            (64, 3, 8, Some(29.97))
        );
        // It was made before there was a choice.
        assert_eq!((recipe.fade_detail, recipe.head), (false, HeadMotion::Keep));
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        reader.positions(4, &mut positions).unwrap();
        reader.channel(&channel::NORMALS, 4, &mut normals).unwrap();
        assert!(positions.len() == 120 && normals.len() == 120 && positions != normals);
        let head = reader.head(4).unwrap().unwrap();
        assert_eq!([head[0][3], head[1][3], head[2][3], head[3][3]], [4.0, 0.1, -2.0, 1.0]);
        assert_eq!(head[3][..3], [0.0; 3]);
    }
}
