//! The folder of the npm package `@rhytid/player`.
use crate::Result;
use crate::build::{Size, size};
use crate::program::{Program, Warnings, at, root};
use std::fs;
use std::path::Path;

const PROGRAM: Program =
    Program { name: "rhytid_player", package: "rhytid-player", features: "", profile: "player" };

/// The licences, which are files of the repository's root.
const LICENCES: [&str; 2] = ["LICENSE-APACHE", "LICENSE-MIT"];

/// What stands for the version in `package.json` and in the package's page.
const VERSION: &str = "0.0.0-workspace";

/// Builds the package into `folder`, which is made if it is not there. `npm publish` takes the folder as it
/// is. Returns the files, by name.
///
/// # Errors
/// The errors of cargo, wasm-bindgen or the disk.
pub fn build_player(folder: &Path, warnings: Warnings) -> Result<Vec<Size>> {
    fs::create_dir_all(folder).map_err(|e| at(folder, &e))?;
    let mut names: Vec<String> = PROGRAM.build(folder, warnings)?.into();
    let mut put = |name: &str, text: &str| {
        let path = folder.join(name);
        names.push(name.to_owned());
        fs::write(&path, text).map_err(|e| at(&path, &e))
    };
    let sources = root().join("crates/player/npm");
    for entry in fs::read_dir(&sources).map_err(|e| at(&sources, &e))? {
        let from = entry.map_err(|e| at(&sources, &e))?.path();
        let text = fs::read_to_string(&from).map_err(|e| at(&from, &e))?;
        put(
            &from.file_name().unwrap_or_default().to_string_lossy(),
            &text.replace(VERSION, env!("CARGO_PKG_VERSION")),
        )?;
    }
    for name in LICENCES {
        let from = root().join(name);
        put(name, &fs::read_to_string(&from).map_err(|e| at(&from, &e))?)?;
    }
    put("names.js", &rhytid_player::javascript())?;
    put("names.d.ts", &rhytid_player::types())?;
    names.sort();
    names.into_iter().map(|name| size(folder, name, false)).collect()
}
