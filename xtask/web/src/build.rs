//! The folder with the pages.
use crate::{Result, film};
use flate2::Compression;
use flate2::write::GzEncoder;
use rhytid_core::{NoProgress, rig_file};
use rhytid_formats::take;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use wasm_bindgen_cli_support::Bindgen;

const TARGET: &str = "wasm32-unknown-unknown";

/// The root manifest's profile for pages. Cargo's folder for the programs has the same name.
const PROFILE: &str = "web";

/// What cargo calls the program.
const LIBRARY: &str = "rhytid_web";

/// `crates/web`, compiled with features.
struct Program {
    /// What it is called in the folder: `NAME.js` and `NAME_bg.wasm`.
    name: &'static str,
    features: &'static str,
}

/// The program for WebGPU, and the larger one for browsers without it.
const PROGRAMS: [Program; 2] =
    [Program { name: "rhytid_web", features: "" }, Program { name: "rhytid_webgl", features: "webgl" }];

/// About how many vertices the demo rig beside the pages has. Fewer would not show wrinkles.
const DEMO_VERTICES: usize = 4_000;

/// The demo's files beside the pages: its take and rig as gzip, and a film of them with its first picture.
const DATA: [&str; 4] = ["demo.csv.gz", "demo.safetensors.gz", "film.mp4", "film.png"];

/// The size of a file of the folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Size {
    /// Its name.
    pub name: String,
    /// Its length.
    pub bytes: u64,
    /// Whether it is data, rather than a part of the program or the pages.
    pub is_data: bool,
}

/// What becomes of the compiler's warnings about our own crates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Warnings {
    /// They are shown.
    Show,
    /// They are errors.
    Refuse,
}

/// Builds the pages into `folder`, which is made if it is not there. Returns the files, by name.
///
/// # Errors
/// The errors of cargo, wasm-bindgen or the disk.
pub fn build(folder: &Path, warnings: Warnings) -> Result<Vec<Size>> {
    fs::create_dir_all(folder).map_err(|e| at(folder, &e))?;
    let mut names = Vec::new();
    for program in &PROGRAMS {
        finish(program.name, &compile(program.features, warnings)?, folder)?;
        names.extend([format!("{}.js", program.name), format!("{}_bg.wasm", program.name)]);
    }
    let pages = root().join("crates/web/pages");
    for entry in fs::read_dir(&pages).map_err(|e| at(&pages, &e))? {
        let from = entry.map_err(|e| at(&pages, &e))?.path();
        let name = from.file_name().unwrap_or_default().to_string_lossy().into_owned();
        fs::copy(&from, folder.join(&name)).map_err(|e| at(&from, &e))?;
        names.push(name);
    }
    demo(folder)?;
    names.extend(DATA.map(str::to_owned));
    names.sort();
    let size = |name: String| {
        let path = folder.join(&name);
        let bytes = fs::metadata(&path).map_err(|e| at(&path, &e))?.len();
        Ok(Size { is_data: DATA.contains(&&*name), name, bytes })
    };
    names.into_iter().map(size).collect()
}

/// Compiles `crates/web` for browsers; returns the program's path. The next program takes its place.
fn compile(features: &str, warnings: Warnings) -> Result<PathBuf> {
    let target = root().join("target");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.args(["build", "--package", "rhytid-web", "--lib", "--target", TARGET, "--profile", PROFILE]);
    command.args(["--features", features]);
    // Flags for this machine's processor do not apply to a browser's. Every browser with WebGPU has vectors
    // of 128 bits, and so has every one with WebGL 2 since 2023.
    let mut flags = "-Ctarget-feature=+simd128".to_owned();
    if warnings == Warnings::Refuse {
        // Cargo lets the crates of others warn of nothing.
        flags += "\x1f-Dwarnings";
    }
    for folder in package_folders() {
        // Cargo separates flags by this character.
        flags += &format!("\x1f--remap-path-prefix={}=", folder.display());
    }
    command
        .arg("--target-dir")
        .arg(&target)
        .current_dir(root())
        .env_remove("RUSTFLAGS")
        .env("CARGO_ENCODED_RUSTFLAGS", flags);
    let status = command.status().map_err(|e| format!("cargo could not be run: {e}"))?;
    if !status.success() {
        return Err(format!(
            "crates/web does not compile for browsers ({status}); if Rust lacks {TARGET}, run `cargo xtask setup`"
        ));
    }
    Ok(target.join(TARGET).join(PROFILE).join(format!("{LIBRARY}.wasm")))
}

/// The folders into which cargo unpacks packages.
///
/// The names of sources in a page do not begin with them. So a page has the same bytes on every machine, and
/// 18 kB less.
fn package_folders() -> Vec<PathBuf> {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| std::env::home_dir().map(|home| home.join(".cargo")));
    let folders = home.and_then(|home| fs::read_dir(home.join("registry/src")).ok());
    let mut folders: Vec<PathBuf> =
        folders.into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    folders.sort();
    folders
}

/// Lets wasm-bindgen convert a program to files that a page can load.
fn finish(name: &str, program: &Path, folder: &Path) -> Result {
    let mut bindgen = Bindgen::new();
    let web = bindgen.input_path(program).out_name(name).web(true);
    let finished = web.and_then(|bindgen| {
        bindgen
            .typescript(false)
            .omit_default_module_path(false)
            .remove_name_section(true)
            .remove_producers_section(true)
            .generate(folder)
    });
    finished.map_err(|e| format!("wasm-bindgen refuses {}: {e:#}", program.display()))
}

/// Solves the demo face, whose rig the pages evaluate, and writes its performance and a film of it.
fn demo(folder: &Path) -> Result {
    let face = rhytid_demo::face(DEMO_VERTICES);
    let failed = |e: rhytid_core::Error| format!("the demo: {e}");
    let rig = rhytid_solve::solve(&face, &NoProgress).and_then(|rig| rig.rounded()).map_err(failed)?;
    let encoded = rig_file::encode(&rig).map_err(failed)?;
    let plain = folder.join("demo.csv");
    let performance = rhytid_demo::performance(&face);
    take::write(&plain, &performance).map_err(failed)?;
    let table = fs::read(&plain).map_err(|e| at(&plain, &e))?;
    fs::remove_file(&plain).map_err(|e| at(&plain, &e))?;
    let [table_name, rig_name, film_name, picture_name] = DATA;
    let film = film::of(&rig, &performance).map_err(failed)?;
    for (name, bytes) in [(film_name, film.bytes), (picture_name, film.first)] {
        fs::write(folder.join(name), bytes).map_err(|e| at(&folder.join(name), &e))?;
    }
    for (name, bytes) in [(table_name, table), (rig_name, encoded)] {
        let path = folder.join(name);
        let file = fs::File::create(&path).map_err(|e| at(&path, &e))?;
        let mut packed = GzEncoder::new(file, Compression::best());
        packed.write_all(&bytes).and_then(|()| packed.finish()).map_err(|e| at(&path, &e))?;
    }
    Ok(())
}

/// The repository's root.
fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

fn at(path: &Path, error: &std::io::Error) -> String {
    format!("{}: {error}", path.display())
}
