//! A program for browsers: a crate compiled to WebAssembly, and finished by wasm-bindgen.
use crate::Result;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use wasm_bindgen_cli_support::Bindgen;

const TARGET: &str = "wasm32-unknown-unknown";

/// A crate, compiled with features.
pub(crate) struct Program {
    /// What it is called in the folder: `NAME.js` and `NAME_bg.wasm`.
    pub(crate) name: &'static str,
    /// The crate's name.
    pub(crate) package: &'static str,
    pub(crate) features: &'static str,
    /// The root manifest's profile. Cargo's folder for the programs has the same name.
    pub(crate) profile: &'static str,
}

/// What becomes of the compiler's warnings about our own crates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Warnings {
    /// They are shown.
    Show,
    /// They are errors.
    Refuse,
}

impl Program {
    /// Compiles the crate, and writes the two files into `folder`. Returns their names.
    pub(crate) fn build(&self, folder: &Path, warnings: Warnings) -> Result<[String; 2]> {
        finish(self.name, &self.compile(warnings)?, folder)?;
        Ok([format!("{}.js", self.name), format!("{}_bg.wasm", self.name)])
    }

    /// Compiles the crate; returns the program's path. The next program of the crate takes its place.
    fn compile(&self, warnings: Warnings) -> Result<PathBuf> {
        let Self { package, features, profile, .. } = self;
        let target = root().join("target");
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let mut command = Command::new(cargo);
        command.args(["build", "--package", package, "--lib", "--target", TARGET, "--profile", profile]);
        command.args(["--features", features]);
        // Flags for this machine's processor do not apply to a browser's. Every browser with WebGPU has
        // vectors of 128 bits, and so has every one with WebGL 2 since 2023.
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
                "{package} does not compile for browsers ({status}); if Rust lacks {TARGET}, run `cargo xtask setup`"
            ));
        }
        Ok(target.join(TARGET).join(profile).join(format!("{}.wasm", package.replace('-', "_"))))
    }
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

/// The repository's root.
pub(crate) fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// An error of the disk.
pub(crate) fn at(path: &Path, error: &std::io::Error) -> String {
    format!("{}: {error}", path.display())
}
