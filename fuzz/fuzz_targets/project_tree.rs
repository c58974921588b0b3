//! A folder with a project, with any files and any links. The result is a face or an error. It never contains
//! anything of the folder beside it. The input is one text: `--- NAME` begins a file, `--- NAME -> TARGET` is
//! a link.
#![no_main]
use libfuzzer_sys::fuzz_target;
use rhytid_core::Error;
use rhytid_formats::{Reach, project};
use std::os::unix::fs::symlink;
use std::path::{Component, Path};

/// A coordinate that no other vertex has.
const SECRET: f64 = 12_345.678;

fuzz_target!(|text: &str| {
    let folder = std::env::temp_dir().join(format!("rhytid-fuzz-tree-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    let inside = folder.join("in");
    std::fs::create_dir_all(&inside).unwrap();
    let secret = format!("v {SECRET} 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    std::fs::write(folder.join("secret.obj"), secret).unwrap();
    let mut links = Vec::new();
    for entry in text.split("--- ").skip(1) {
        let (name, content) = entry.split_once('\n').unwrap_or((entry, ""));
        let (name, target) =
            name.split_once(" -> ").map_or((name, None), |(name, target)| (name, Some(target)));
        if !Path::new(name).components().all(|part| matches!(part, Component::Normal(_))) {
            continue;
        }
        let path = inside.join(name);
        let _ = std::fs::create_dir_all(path.parent().unwrap());
        match target {
            Some(target) => links.push((path, target)),
            None => drop(std::fs::write(&path, content)),
        }
    }
    // Links come after the files, which would otherwise be written through them.
    for (path, target) in links {
        let _ = symlink(target, path);
    }
    match project::read(&inside.join("face.toml"), Reach::Below) {
        Ok(face) => {
            let examples = face.examples.iter().flat_map(|example| &example.positions);
            assert!(face.neutral.positions.iter().chain(examples).all(|x| x[0] != SECRET));
        }
        Err(error) => assert!(matches!(error, Error::Input(_) | Error::Io { .. }), "{error:?}"),
    }
});
