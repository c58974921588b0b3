//! The promises of both formats, and the programs that the tests call.
use crate::animation::{Animation, UvKind, animation};
use rhytid_core::channel::{self, Channel};
use rhytid_core::{ChannelKind, Error, NoProgress};
use rhytid_formats::animation;
use rhytid_formats::animation::Format;
use rhytid_formats::export::Options;
use std::path::Path;
use std::process::Command;

pub(crate) use rhytid_test_support::{python, python_usd_24_3, root};

/// Of all formats.
pub(crate) const EXTENSIONS: [&str; 6] = ["usd", "usdc", "usda", "usdz", "glb", "gltf"];

/// Runs a checker and returns what it printed; its complaints fail the test.
pub(crate) fn run(command: &mut Command) -> String {
    let output =
        command.output().unwrap_or_else(|e| panic!("{command:?}: {e}; run `cargo xtask setup` first"));
    let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{stdout}{}", String::from_utf8_lossy(&output.stderr));
    stdout
}

/// The sentence of an error of the caller.
#[track_caller]
pub(crate) fn input_error<T>(result: rhytid_core::Result<T>) -> String {
    match result {
        Err(Error::Input(message)) => message.to_string(),
        Err(other) => panic!("expected an input error, found {other:?}"),
        Ok(_) => panic!("expected an input error, found success"),
    }
}

pub(crate) fn files_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn an_exporter_dropped_midway_leaves_nothing_and_touches_nothing() {
    for extension in EXTENSIONS {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(format!("face.{extension}"));
        let animation = animation(UvKind::PerCorner, 3, 1);
        for before in [None, Some("what stood there before")] {
            if let Some(text) = before {
                std::fs::write(&path, text).unwrap();
            }
            let mut exporter = animation::create(&path, &animation.scene(), &Options::default()).unwrap();
            exporter.frame(&animation.frame(0)).unwrap();
            drop(exporter);
            assert_eq!(std::fs::read_to_string(&path).ok().as_deref(), before, "{extension}");
            assert_eq!(files_in(folder.path()).len(), usize::from(before.is_some()), "{extension}");
        }
        animation.export(&path).unwrap();
        let files = files_in(folder.path());
        assert!(files.contains(&format!("face.{extension}")), "{files:?}");
        assert_eq!(files.len(), if extension == "gltf" { 2 } else { 1 }, "{files:?}");
        assert!(std::fs::metadata(&path).unwrap().len() > 1000, "{extension}: replaced what stood there");
    }
}

#[test]
fn frames_that_do_not_fit_the_scene_are_refused() {
    for extension in EXTENSIONS {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(format!("face.{extension}"));
        let animation = animation(UvKind::None, 2, 2);
        let frame = animation.frame(0);
        let (positions, normals) = (frame.positions(), frame.get(&channel::NORMALS).unwrap());
        let mut exporter = animation::create(&path, &animation.scene(), &Options::default()).unwrap();

        let message = input_error(exporter.frame(&frame.clone().with(&channel::POSITIONS, &positions[3..])));
        assert!(message.contains("frame 0") && message.contains("99 numbers"), "{message}");
        let mut bad = normals.to_vec();
        bad[7] = f32::NAN;
        let message = input_error(exporter.frame(&frame.clone().with(&channel::NORMALS, &bad)));
        assert!(message.contains("normals that are not finite, first at vertex 2"), "{message}");

        let message = input_error(exporter.frame(&frame.clone().without(&channel::NORMALS)));
        assert!(message.contains("frame 0 (from 0) has no normals, expected some"), "{message}");
        let message = input_error(exporter.frame(&frame.clone().with(&channel::VELOCITIES, positions)));
        assert!(message.contains("frame 0 (from 0) has velocities, expected none"), "{message}");

        exporter.frame(&frame).unwrap();
        exporter.frame(&frame).unwrap();
        let message = input_error(exporter.frame(&frame));
        assert!(message.contains("more than the 2 announced"), "{message}");
        drop(exporter);

        let mut exporter = animation::create(&path, &animation.scene(), &Options::default()).unwrap();
        exporter.frame(&frame).unwrap();
        let message = input_error(exporter.finish(&NoProgress));
        assert!(message.contains("after 1 frames of 2"), "{message}");
        assert_eq!(files_in(folder.path()), [""; 0]);
    }
}

#[test]
fn scenes_that_make_no_sense_are_refused() {
    type Damage = fn(&mut Animation);
    let damages: [(&str, Damage); 15] = [
        ("0 faces", |a| a.faces = Default::default()),
        ("33 rest normals for 34", |a| a.rest_normals.truncate(33)),
        ("vertex 34, expected 0 to 33", |a| a.faces.indices[5] = 34),
        ("has 88 corners, expected the 89 of its faces", |a| a.faces.counts[2] += 1),
        ("corner 88, expected 0 to 87", |a| a.triangle_corners[3][1] = 88),
        ("no triangles", |a| a.triangle_corners.clear()),
        ("rest position that is not finite, at vertex 4", |a| a.rest[4][1] = f32::INFINITY),
        ("rest normal that is not finite, at vertex 9", |a| a.rest_normals[9][2] = f32::NAN),
        ("unit of 0 metres", |a| a.metres_per_unit = 0.0),
        ("no frames", |a| a.frames.clear()),
        ("NaN frames per second", |a| a.rate = f64::NAN),
        ("from time code NaN", |a| a.first_time_code = f64::NAN),
        ("87 texture indices for 88 face corners", |a| {
            a.uvs.as_mut().unwrap().corners.as_mut().unwrap().truncate(87);
        }),
        ("coordinate 6, expected one of its 6", |a| a.uvs.as_mut().unwrap().corners.as_mut().unwrap()[1] = 6),
        ("6 texture coordinates for 34", |a| a.uvs.as_mut().unwrap().corners = None),
    ];
    for extension in EXTENSIONS {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(format!("face.{extension}"));
        for (expected, damage) in &damages {
            let mut animation = animation(UvKind::PerCorner, 2, 3);
            damage(&mut animation);
            let message = input_error(animation::create(&path, &animation.scene(), &Options::default()));
            assert!(message.contains(expected), "“{message}” lacks “{expected}”");
        }
        assert_eq!(files_in(folder.path()), [""; 0]);
    }
}

/// A channel without a place in the format is an error; it is not left out silently.
#[test]
fn channels_without_a_place_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut made = animation(UvKind::None, 1, 6);
    for (name, is_usd) in [("face.usd", true), ("face.glb", false), ("face.pc2", false)] {
        let path = folder.path().join(name);
        let format = Format::from_extension(&path).unwrap();
        for kind in ChannelKind::ALL {
            made.with_normals = kind == ChannelKind::Normals;
            let of_frame = |channel: Channel| {
                let frames = vec![vec![0.25; channel.width * made.rest.len()]];
                crate::animation::Other { channel, frames }
            };
            let channels = kind.channels(&["smile".to_owned()]);
            made.others =
                if made.with_normals { Vec::new() } else { channels.into_iter().map(of_frame).collect() };
            let made = made.export(&path);
            match format.carries(kind) {
                true => assert!(made.is_ok(), "{name} {kind}: {:?}", made.err()),
                false => assert!(input_error(made).contains("has no place for"), "{name} {kind}"),
            }
            assert!(format.carries(kind) || !is_usd, "USD has a place for all");
        }
    }
}

#[test]
fn names_that_cannot_be_written_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let animation = animation(UvKind::None, 1, 4);
    for (name, expected) in
        [("face.fbx", "as .usd, "), ("face", "as .usd, "), ("no/face.usd", "does not exist")]
    {
        let message = input_error(animation::create(
            &folder.path().join(name),
            &animation.scene(),
            &Options::default(),
        ));
        assert!(message.contains(expected), "{message}");
    }
    animation.export(&folder.path().join("FACE.USDA")).unwrap();
}
