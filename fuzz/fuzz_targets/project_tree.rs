//! A folder with a project, whatever files and whatever links: a face or an error, and never what is in the folder beside it.
#![no_main]
use libfuzzer_sys::arbitrary::{self, Arbitrary};
use libfuzzer_sys::fuzz_target;
use rhytid_core::Error;
use rhytid_formats::Reach;
use rhytid_formats::project;
use std::os::unix::fs::symlink;
use std::path::Path;

#[derive(Arbitrary, Debug)]
struct Tree<'a> {
    project: &'a str,
    files: Vec<(Name, &'a [u8])>,
    links: Vec<(Name, Target)>,
}

#[derive(Arbitrary, Debug, Clone, Copy)]
enum Name {
    Neutral,
    Example,
    Gltf,
    Buffer,
    Handles,
    Edges,
    Below,
}

#[derive(Arbitrary, Debug, Clone, Copy)]
enum Target {
    Secret,
    Above,
    Itself,
    Device,
    Other(Name),
}

impl Name {
    fn path(self) -> &'static str {
        match self {
            Self::Neutral => "neutral.obj",
            Self::Example => "below/example.ply",
            Self::Gltf => "mesh.gltf",
            Self::Buffer => "mesh.bin",
            Self::Handles => "markers.csv",
            Self::Edges => "edges.csv",
            Self::Below => "below",
        }
    }
}

/// Where nobody's vertex is.
const SECRET: f64 = 12_345.678;

fuzz_target!(|tree: Tree<'_>| {
    let folder = std::env::temp_dir().join(format!("rhytid-fuzz-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    let inside = folder.join("in");
    std::fs::create_dir_all(inside.join("below")).unwrap();
    let secret = format!("v {SECRET} 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    std::fs::write(folder.join("secret.obj"), secret).unwrap();
    for (name, bytes) in &tree.files {
        let _ = std::fs::write(inside.join(name.path()), bytes);
    }
    for (name, target) in &tree.links {
        let target = match target {
            Target::Secret => "../secret.obj",
            Target::Above => "..",
            Target::Itself => name.path(),
            Target::Device => "/dev/zero",
            Target::Other(other) => other.path(),
        };
        let _ = symlink(Path::new(target), inside.join(name.path()));
    }
    let path = inside.join("face.toml");
    std::fs::write(&path, tree.project).unwrap();
    match project::read(&path, Reach::Below) {
        Ok(face) => {
            let examples = face.examples.iter().flat_map(|example| &example.positions);
            assert!(face.neutral.positions.iter().chain(examples).all(|x| x[0] != SECRET));
        }
        Err(error) => assert!(matches!(error, Error::Input(_) | Error::Io { .. }), "{error:?}"),
    }
});
