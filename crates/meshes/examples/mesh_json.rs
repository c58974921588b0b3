//! Reads the meshes that standard input lists, one path a line, and prints one line of JSON for each.
//!
//! ```sh
//! find . -name '*.ply' | cargo run -p rhytid-meshes --example mesh_json
//! ```
//!
//! `cargo xtask collections` compares these lines with what other programs read. A mesh has `positions`,
//! `counts` and `corners` of its faces, `uvs` of its corners (or null), and `shapes`. A file that is refused
//! has `refused`, and one that lets the reader panic has `panicked`. `warnings` are those of the file.

use log::{LevelFilter, Log, Metadata, Record};
use rhytid_core::Mesh;
use rhytid_meshes::{Selection, Shapes, read_file};
use serde_json::{Value, json};
use std::io::{BufRead, Write};
use std::panic::catch_unwind;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Keeps the warnings until they are printed.
struct Warnings(Mutex<Vec<String>>);

static WARNINGS: Warnings = Warnings(Mutex::new(Vec::new()));

impl Log for Warnings {
    fn enabled(&self, _: &Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &Record<'_>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(record.args().to_string());
    }

    fn flush(&self) {}
}

fn main() -> std::io::Result<()> {
    log::set_logger(&WARNINGS).expect("no other logger is set");
    log::set_max_level(LevelFilter::Warn);
    let mut out = std::io::stdout().lock();
    for path in std::io::stdin().lock().lines() {
        let path = path?;
        let started = Instant::now();
        let read = catch_unwind(|| read_file(Path::new(&path), &Selection::default(), true));
        let seconds = started.elapsed().as_secs_f64();
        let mut line = match read {
            Ok(Ok(shapes)) => of_mesh(&shapes),
            Ok(Err(error)) => json!({"refused": error.to_string()}),
            Err(_) => json!({"panicked": true}),
        };
        line["path"] = path.into();
        line["seconds"] = seconds.into();
        line["warnings"] =
            std::mem::take(&mut *WARNINGS.0.lock().unwrap_or_else(PoisonError::into_inner)).into();
        writeln!(out, "{line}")?;
        out.flush()?;
    }
    Ok(())
}

fn of_mesh(read: &Shapes) -> Value {
    let Mesh { positions, faces, .. } = &read.neutral;
    let shapes: Vec<Value> =
        read.shapes.iter().map(|shape| json!({"name": shape.name, "moved": shape.moved})).collect();
    json!({
        "positions": positions,
        "counts": faces.counts,
        "corners": faces.indices,
        "uvs": corner_uvs(&read.neutral),
        "shapes": shapes,
    })
}

/// The texture coordinates of every corner, whichever way they are stored.
fn corner_uvs(mesh: &Mesh) -> Option<Vec<[f32; 2]>> {
    let uvs = mesh.uvs.as_ref()?;
    let entries = uvs.corners.as_ref().unwrap_or(&mesh.faces.indices);
    Some(entries.iter().map(|&entry| uvs.values[entry as usize]).collect())
}
