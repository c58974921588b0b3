//! Blender, three.js, Chromium and USD: how each program is asked about files. One process gets all files.

use rhytid_test_support::installed;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// Frames of files, for the programs that show frames.
pub(super) struct Frames {
    /// Frames per second.
    pub rate: f64,
    /// The time code of the files' first frame.
    pub first: usize,
    /// The number of frames.
    pub count: usize,
}

/// What a program shows of a file.
pub(super) struct Shown {
    /// The original's vertex number of each vertex, if the file says.
    pub ids: Option<Vec<u32>>,
    /// For each frame, where each vertex is: metres, in the program's axes.
    pub positions: Vec<Vec<[f64; 3]>>,
    /// For each frame the vertices' normals, of any length, if the program was asked and the file has some.
    pub normals: Option<Vec<Vec<[f64; 3]>>>,
    /// For each frame the two strains of the vertices and the strain of the area, if the program was asked
    /// and the file has some.
    pub strains: Option<Vec<Vec<[f64; 3]>>>,
    /// The stated error of the file's strains, if the file has one and the program was asked.
    pub stated_strain: Option<f64>,
    /// The stated error of the file in millimetres, if the file has one and the program was asked.
    pub stated: Option<f64>,
    /// A PNG of the last frame, if the program was asked for it.
    pub picture: Option<Vec<u8>>,
}

/// What USD reads from a file.
pub(super) struct Read {
    /// The animated attributes: their time codes and the bytes of all samples, by name.
    pub samples: BTreeMap<String, (Vec<f64>, Vec<u8>)>,
    /// The scene as text.
    pub flattened: String,
}

/// What Blender shows, Z up.
pub(super) fn blender(files: &[PathBuf], frames: &Frames) -> Vec<Shown> {
    let python = installed("venv-blender/bin/python");
    let (report, out) = ask(Command::new(python).arg(program("blender.py")), frames.job(files));
    shown(&report, frames, out.path())
}

/// What three.js shows, Y up.
pub(super) fn three(files: &[PathBuf], frames: &Frames) -> Vec<Shown> {
    let mut job = frames.job(files);
    job["modules"] = json!(installed("node/node_modules/three"));
    let (report, out) = browser("three.html", job);
    shown(&report, frames, out.path())
}

/// What the USD of an environment under `target/` reads. Its version must be `version`.
pub(super) fn usd(environment: &str, version: [u64; 3], files: &[PathBuf]) -> Vec<Read> {
    let python = installed(&format!("{environment}/bin/python"));
    let (report, out) = ask(Command::new(python).arg(program("usd.py")), json!({ "files": files }));
    assert_eq!(report["version"], json!(version), "{environment} has another USD; run `cargo xtask setup`");
    let read = |(i, file): (usize, &Value)| {
        let attributes = file["samples"].as_object().unwrap().iter();
        let samples = attributes.map(|(name, codes)| {
            let codes = codes.as_array().unwrap().iter().map(|code| code.as_f64().unwrap()).collect();
            (name.clone(), (codes, std::fs::read(out.path().join(i.to_string()).join(name)).unwrap()))
        });
        Read { samples: samples.collect(), flattened: file["flattened"].as_str().unwrap().to_owned() }
    };
    report["files"].as_array().unwrap().iter().enumerate().map(read).collect()
}

/// The Alembic file beside `usd` that Blender writes with the script in docs/export.md.
pub(super) fn blender_alembic(usd: &Path, rate: f64) -> PathBuf {
    let page = include_str!("../../../../../docs/export.md");
    let (_, section) = page.split_once("\n## Alembic\n").expect("the section Alembic");
    let (_, script) = section.split_once("```python\n").expect("a script");
    let (script, _) = script.split_once("```").expect("the script's end");
    let [file, alembic] = ["py", "abc"].map(|extension| usd.with_extension(extension));
    std::fs::write(&file, script).unwrap();
    let mut python = Command::new(installed("venv-blender/bin/python"));
    let output = python.arg(file).arg(usd).arg(&alembic).arg(rate.to_string()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    alembic
}

/// Where Blender shows the vertices of a mesh with a point cache, in Blender's own space: frames × 3V.
pub(super) fn blender_point_cache(mesh: &Path, cache: &Path, frames: &Frames) -> Vec<f32> {
    let python = installed("venv-blender/bin/python");
    let mut job = frames.job(&[]);
    (job["mesh"], job["cache"]) = (json!(mesh), json!(cache));
    let (_report, out) = ask(Command::new(python).arg(program("point_cache.py")), job);
    let bytes = std::fs::read(out.path().join("positions")).unwrap();
    bytes.as_chunks().0.iter().map(|x| f32::from_le_bytes(*x)).collect()
}

/// The errors that an independent script finds in strains: for each case, the distance from those of the
/// triangles.
pub(super) fn strain(cases: Vec<Value>) -> Vec<Value> {
    let python = installed("venv/bin/python");
    let (report, _out) = ask(Command::new(python).arg(program("strain.py")), json!({ "cases": cases }));
    report.as_array().unwrap().clone()
}

/// The errors that an independent script finds in wrinkles: for each case, the distance of activations from
/// the formula's.
pub(super) fn wrinkles(cases: Vec<Value>) -> Vec<Value> {
    let python = installed("venv/bin/python");
    let (report, _out) = ask(Command::new(python).arg(program("wrinkles.py")), json!({ "cases": cases }));
    report.as_array().unwrap().clone()
}

impl Frames {
    fn job(&self, files: &[PathBuf]) -> Value {
        let frames: Vec<usize> = (0..self.count).collect();
        json!({ "files": files, "rate": self.rate, "first": self.first, "frames": frames })
    }
}

/// Chromium's findings in moving pictures, of which each file has a given number: the report of
/// `moving.html`.
#[cfg(feature = "film")]
pub(super) fn chromium(files: &[PathBuf], pictures: usize) -> Value {
    browser("moving.html", json!({ "files": files, "pictures": pictures })).0
}

/// Opens a page beside this file in Chromium.
fn browser(page: &str, mut job: Value) -> (Value, TempDir) {
    job["page"] = json!(page);
    ask(Command::new("node").arg(program("browser.mjs")), job)
}

/// A program beside this file.
fn program(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/program/oracles").join(name)
}

/// Runs `command` on a job, which must succeed. Returns the JSON in the last line that it prints, and the
/// folder with its files.
fn ask(command: &mut Command, mut job: Value) -> (Value, TempDir) {
    let out = TempDir::new().unwrap();
    job["out"] = json!(out.path());
    let path = out.path().join("job.json");
    std::fs::write(&path, job.to_string()).unwrap();
    let output = command.arg(path).output();
    let output = output.unwrap_or_else(|e| panic!("{command:?}: {e}; run `cargo xtask setup`"));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?} failed ({}):\n{said}", output.status);
    let stdout = String::from_utf8(output.stdout).unwrap();
    let report = stdout.lines().last().unwrap_or_else(|| panic!("{command:?} printed nothing:\n{said}"));
    (serde_json::from_str(report).unwrap(), out)
}

fn shown(report: &Value, frames: &Frames, out: &Path) -> Vec<Shown> {
    let files = report.as_array().unwrap().iter().enumerate();
    let shown = files.map(|(i, file)| {
        let vertices = file["vertices"].as_u64().unwrap() as usize;
        let triples =
            |name: String| Some(triples(&std::fs::read(out.join(name)).ok()?, vertices, frames.count));
        Shown {
            ids: serde_json::from_value(file["ids"].clone()).unwrap(),
            positions: triples(format!("{i}.f64")).expect("a file with positions"),
            normals: triples(format!("{i}.normals.f64")),
            strains: triples(format!("{i}.strains.f64")),
            stated_strain: file["statedStrain"].as_f64(),
            stated: file["stated"].as_f64(),
            picture: std::fs::read(out.join(format!("{i}.png"))).ok(),
        }
    });
    shown.collect()
}

/// frames × vertices × 3 numbers from their bytes.
fn triples(bytes: &[u8], vertices: usize, frames: usize) -> Vec<Vec<[f64; 3]>> {
    assert_eq!(bytes.len(), frames * vertices * 24);
    let number = |bytes: &[u8; 8]| f64::from_le_bytes(*bytes);
    let numbers: Vec<f64> = bytes.as_chunks().0.iter().map(number).collect();
    numbers.as_chunks().0.chunks(vertices).map(<[_]>::to_vec).collect()
}
