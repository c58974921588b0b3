//! `cargo xtask package`: packs every crate that is published, and checks that what is packed compiles by itself.
use crate::run::{Result, cargo, command, root, run};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// The members of the workspace that are not published.
const PRIVATE: [&str; 5] =
    ["rhytid-examples", "rhytid-peers", "rhytid-test-support", "xtask", "xtask-kernels"];

/// Packs as `cargo publish --workspace` would. Cargo's own check builds each package from nothing, for as long as
/// everything else together; so the packages are unpacked side by side instead, as a workspace where each stands
/// for its namesake on crates.io, and checked at once with the dependencies that are there already.
pub(crate) fn package() -> Result {
    let target = root().join("target");
    let packages = target.join("package");
    // An older version's packages would be unpacked too.
    remove(&packages)?;
    let mut pack = cargo(&["package", "--workspace", "--no-verify", "--allow-dirty"]);
    pack.args(PRIVATE.iter().flat_map(|name| ["--exclude", name])).arg("--target-dir").arg(&target);
    run(pack)?;

    let unpacked = packages.join("unpacked");
    let io = |e: std::io::Error| format!("{}: {e}", unpacked.display());
    fs::create_dir_all(&unpacked).map_err(io)?;
    for entry in fs::read_dir(&packages).map_err(io)? {
        let path = entry.map_err(io)?.path();
        if path.extension().is_some_and(|extension| extension == "crate") {
            let mut unpack = command("tar", &["--extract", "--gzip", "--directory"]);
            unpack.arg(&unpacked).arg("--file").arg(&path);
            run(unpack)?;
        }
    }
    fs::write(unpacked.join("Cargo.toml"), manifest(&unpacked)?).map_err(io)?;
    fs::copy(root().join("Cargo.lock"), unpacked.join("Cargo.lock")).map_err(io)?;
    let mut check = cargo(&["check", "--workspace", "--target-dir"]);
    check.arg(&target).current_dir(&unpacked);
    run(check)?;
    remove(&unpacked)
}

/// A workspace of all the packages in `folder`, with the repository's profiles.
fn manifest(folder: &Path) -> Result<String> {
    let io = |e: std::io::Error| format!("{}: {e}", folder.display());
    let mut text = "[workspace]\nresolver = \"3\"\nmembers = [\"*\"]\n\n[patch.crates-io]\n".to_owned();
    let folders: std::io::Result<Vec<_>> = fs::read_dir(folder).map_err(io)?.collect();
    for package in folders.map_err(io)? {
        let package = package.file_name().to_string_lossy().into_owned();
        let (name, _) = package.rsplit_once('-').ok_or_else(|| format!("{package} has no version"))?;
        writeln!(text, "{name} = {{ path = \"{package}\" }}").expect("writing to a string");
    }
    Ok(text + &profiles()?)
}

/// The repository's profiles, which its Cargo.toml ends with: with them others share what is compiled.
pub(crate) fn profiles() -> Result<String> {
    let path = root().join("Cargo.toml");
    let ours = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let profiles = ours.find("\n[profile.").ok_or("Cargo.toml has no profile")?;
    Ok(ours[profiles..].to_owned())
}

/// Removes a folder, if it is there.
fn remove(folder: &Path) -> Result {
    match fs::remove_dir_all(folder) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(format!("{}: {e}", folder.display())),
        _ => Ok(()),
    }
}
