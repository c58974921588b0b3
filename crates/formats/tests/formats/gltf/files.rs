//! The files and their names.

use super::cases::{animation, cases};
use super::tools::{bin_beside, unfold};
use crate::animation::UvKind;
use rhytid_core::{NoProgress, Progress};
use rhytid_formats::animation;
use rhytid_formats::export::Options;
use std::path::{Path, PathBuf};

fn files_in(folder: &Path) -> Vec<String> {
    let names = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        names.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

fn options() -> [Options; 3] {
    let none = Options::default();
    [Options { quantize: true, ..none.clone() }, Options { max_error: Some(0.05), ..none.clone() }, none]
}

#[test]
fn an_exporter_dropped_midway_leaves_nothing_and_touches_nothing() {
    for extension in ["glb", "gltf"] {
        for options in options() {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("face").with_extension(extension);
            let animation = animation(UvKind::PerCorner, 3, 1);
            for before in [&[][..], &["face.bin", "face.glb", "face.gltf"]] {
                for name in before {
                    std::fs::write(folder.path().join(name), "what stood there before").unwrap();
                }
                let mut exporter = animation::create(&path, &animation.scene(), &options).unwrap();
                exporter.frame(&animation.frame(0)).unwrap();
                drop(exporter);
                assert_eq!(files_in(folder.path()), before, "{extension}");

                let mut exporter = animation::create(&path, &animation.scene(), &options).unwrap();
                (0..3).for_each(|k| exporter.frame(&animation.frame(k)).unwrap());
                let stopped = exporter.finish(&Stopped);
                assert!(
                    matches!(stopped, Err(rhytid_core::Error::Cancelled)) || extension == "gltf",
                    "{options:?}"
                );
                if stopped.is_err() {
                    assert_eq!(files_in(folder.path()), before, "{extension}");
                    for name in before {
                        let text = std::fs::read_to_string(folder.path().join(name)).unwrap();
                        assert_eq!(text, "what stood there before", "{name}");
                    }
                }
                for name in files_in(folder.path()) {
                    std::fs::remove_file(folder.path().join(name)).unwrap();
                }
            }
        }
    }
}

struct Stopped;

impl Progress for Stopped {
    fn report(&self, _: &'static str, _: u64, _: u64) {}

    fn cancelled(&self) -> bool {
        true
    }
}

#[test]
fn a_gltf_that_cannot_be_finished_leaves_no_bin() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.gltf");
    let animation = animation(UvKind::None, 1, 2);
    let mut exporter = animation::create(&path, &animation.scene(), &Options::default()).unwrap();
    exporter.frame(&animation.frame(0)).unwrap();
    // A folder in the place of one of two files.
    std::fs::create_dir(&path).unwrap();
    assert!(exporter.finish(&NoProgress).is_err());
    assert_eq!(files_in(folder.path()), ["face.gltf"]);

    std::fs::remove_dir(&path).unwrap();
    let long = folder.path().join(format!("{}.gltf", "face".repeat(60)));
    assert!(matches!(animation.export_with(&long, &Options::default()), Err(rhytid_core::Error::Io { .. })));
    assert_eq!(files_in(folder.path()), [""; 0]);
}

#[test]
fn a_gltf_finds_its_bin_whatever_it_is_called() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["face.gltf", "Zoë's 1st scan? 100% #2.v2.GLTF"] {
        let path = folder.path().join(name);
        let written = animation(UvKind::None, 2, 3).export_with(&path, &Options::default()).unwrap();
        let bin = bin_beside(&path);
        let bytes = std::fs::metadata(&path).unwrap().len() + std::fs::metadata(&bin).unwrap().len();
        assert_eq!(written.bytes, bytes);
        // As a browser would find it.
        unfold(&[path]);
    }
}

#[test]
fn the_same_input_gives_the_same_bytes_and_compression_keeps_all() {
    let folder = tempfile::tempdir().unwrap();
    let again = tempfile::tempdir().unwrap();
    let cases = cases();
    let written: Vec<(PathBuf, u64)> = cases
        .iter()
        .map(|case| {
            let (path, written) = case.export(folder.path());
            (path, written.bytes)
        })
        .collect();
    let files: Vec<PathBuf> = written.iter().map(|(path, _)| path.clone()).collect();
    let unfolded = unfold(&files);
    for ((case, (path, size)), unfolded) in cases.iter().zip(&written).zip(&unfolded) {
        let label = &case.label;
        let bytes = |path: &Path| std::fs::read(path).unwrap();
        let (copy, _) = case.export(again.path());
        assert!(bytes(&copy) == bytes(path), "{label}");
        if case.extension == "glb" {
            assert_eq!(bytes(path).len() as u64, *size, "{label}");
        }
        if case.options.meshopt {
            // The views are the same without compression, in the same order, and so is the binary part.
            let plain = Options { meshopt: false, ..case.options.clone() };
            let path = again.path().join("plain.glb");
            case.animation.export_with(&path, &plain).unwrap();
            let bin = |path: &Path| super::viewer::Viewer::open(path).bin;
            assert!(bin(&path) == bin(unfolded), "{label}");
        }
    }
}

#[test]
fn plain_files_need_nothing_that_the_gltf_crate_lacks() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("face.glb");
    let animation = animation(UvKind::PerCorner, 3, 5);
    for (quantize, meshopt, max_error) in
        [(false, false, None), (false, false, Some(0.05)), (true, false, None), (false, true, None)]
    {
        let options = Options { quantize, meshopt, max_error, ..Options::default() };
        animation.export_with(&path, &options).unwrap();
        // As docs/export.md says. The crate validates what it opens.
        assert_eq!(gltf::Gltf::open(&path).is_ok(), !quantize && !meshopt, "{options:?}");
    }
}

#[test]
fn compression_makes_files_smaller() {
    let folder = tempfile::tempdir().unwrap();
    let animation = animation(UvKind::None, 20, 4);
    let size = |quantize, meshopt| {
        let options = Options { quantize, meshopt, ..Options::default() };
        let path = folder.path().join("face.gltf");
        animation.export_with(&path, &options).unwrap();
        std::fs::metadata(bin_beside(&path)).unwrap().len()
    };
    // The weights of the frames are floats in both. Normals turn far here, so that they have 16 bits.
    assert!(size(true, false) * 16 < size(false, false) * 12);
    assert!(size(true, true) < size(true, false));
}
