//! The folder with the pages.
use crate::program::{Program, Warnings, at, root};
use crate::{Result, film};
use flate2::Compression;
use flate2::write::GzEncoder;
use rhytid_core::{NoProgress, rig_file};
use rhytid_formats::take;
use std::fs;
use std::io::Write;
use std::path::Path;

/// A program of `crates/web`.
const fn program(name: &'static str, features: &'static str) -> Program {
    Program { name, package: "rhytid-web", features, profile: "web" }
}

/// The program for WebGPU, and the larger one for browsers without it.
const PROGRAMS: [Program; 2] = [program("rhytid_web", ""), program("rhytid_webgl", "webgl")];

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

/// Builds the pages into `folder`, which is made if it is not there. Returns the files, by name.
///
/// # Errors
/// The errors of cargo, wasm-bindgen or the disk.
pub fn build(folder: &Path, warnings: Warnings) -> Result<Vec<Size>> {
    fs::create_dir_all(folder).map_err(|e| at(folder, &e))?;
    let mut names = Vec::new();
    for program in &PROGRAMS {
        names.extend(program.build(folder, warnings)?);
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
    names
        .into_iter()
        .map(|name| {
            let is_data = DATA.contains(&&*name);
            size(folder, name, is_data)
        })
        .collect()
}

/// The size of a file of the folder.
pub(crate) fn size(folder: &Path, name: String, is_data: bool) -> Result<Size> {
    let path = folder.join(&name);
    let bytes = fs::metadata(&path).map_err(|e| at(&path, &e))?.len();
    Ok(Size { name, bytes, is_data })
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
