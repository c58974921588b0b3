//! `rhytid pack`

use super::solve::check_output;
use crate::progress::Ui;
use crate::{args, inputs, output};
use rhytid::core::human;
use rhytid::core::rig_file::{self, Packing};
use rhytid::formats::refuse_inputs;
use rhytid::playback::{self, Packed};
use rhytid::{Error, Result, Rig};
use serde::Serialize;
use std::path::{Path, PathBuf};

const USAGE: &str = "rhytid pack RIG [TAKE] -o SMALL.safetensors";

/// Makes a rig file small.
///
/// # Errors
/// As reading and writing. [`Error::Input`] for a rig that is packed already, and for a bound that is too
/// small.
pub(super) fn run(args: &args::Pack, ui: &Ui) -> Result<()> {
    let args::Pack { rig: path, take, output, max_error, reading, json } = args;
    inputs::rig_and_any_take(path, take.as_deref(), reading, USAGE)?;
    check_output(output)?;
    let read = [path].into_iter().chain(take).chain(&reading.setup);
    refuse_inputs(&[output], read.map(PathBuf::as_path))?;
    if rig_file::read_packing(path)?.is_some() {
        return Err(Error::conflict(format!(
            "{}: is packed already, and would be rounded twice; pack the rig that it was made from",
            path.display()
        )));
    }
    let rig = ui.timed("read the rig", || rig_file::read(path)).0?;
    let frames = match take {
        Some(take) => inputs::take(take, &rig, reading, ui)?.handle_positions(&rig.handles().labels)?,
        None => Vec::new(),
    };
    let summary = write(&rig, frames.as_chunks().0, *max_error, output, ui)?;
    output::done(*json, ui, &summary, || {
        let name = output::word(output);
        let next = output::next(&[
            format!("rhytid view {name}"),
            format!("rhytid animate {name} TAKE.csv -o {}", output::word(&output.with_extension("usd"))),
        ]);
        summary.text() + &next
    })
}

/// What was written; docs/cli.md documents every key.
#[derive(Serialize)]
pub(super) struct Summary<'a> {
    file: &'a Path,
    bytes: usize,
    bytes_before: usize,
    bytes_per_vertex: f64,
    #[serde(flatten)]
    nearness: Nearness,
}

/// How near a packed rig is to the whole one.
#[derive(Serialize)]
pub(super) struct Nearness {
    poses: usize,
    worst_mm: f64,
    rms_mm: f64,
    normals_rms_degrees: f64,
    finished_worst_mm: f64,
    finished_beyond: usize,
}

impl Nearness {
    /// As a packed rig states it.
    pub(super) fn new(packing: &Packing, metres_per_unit: f64) -> Self {
        let millimetres = 1e3 * metres_per_unit;
        Self {
            poses: packing.poses,
            worst_mm: packing.worst * millimetres,
            rms_mm: packing.rms * millimetres,
            normals_rms_degrees: packing.normals,
            finished_worst_mm: packing.finished * millimetres,
            finished_beyond: packing.finished_beyond,
        }
    }

    /// One line, or two.
    pub(super) fn text(&self) -> String {
        let rounded = |x: f64| human::number((x * 1e4).round() / 1e4);
        let mut text = format!(
            "in {} no vertex is off by more than {} mm; RMS {} mm, normals {}°",
            human::counted(self.poses, "pose"),
            rounded(self.worst_mm),
            rounded(self.rms_mm),
            human::number((self.normals_rms_degrees * 100.0).round() / 100.0),
        );
        if self.finished_beyond > 0 {
            text += &format!(
                "\nwhere triangles are turned back or parts touch, {} off by up to {} mm",
                match self.finished_beyond {
                    1 => "1 vertex is".to_owned(),
                    n => format!("{} vertices are", human::count(n)),
                },
                rounded(self.finished_worst_mm)
            );
        }
        text
    }
}

/// Packs a rig into a file. `take` has frames × H positions of handles.
///
/// # Errors
/// As [`playback::pack`] and writing.
pub(super) fn write<'a>(
    rig: &Rig,
    take: &[[f32; 3]],
    max_error_mm: f64,
    output: &'a Path,
    ui: &Ui,
) -> Result<Summary<'a>> {
    let millimetres = 1e3 * rig.surface().metres_per_unit;
    let devices = [inputs::processor()?];
    let packed = playback::pack(rig, take, max_error_mm / millimetres, &devices, ui);
    let Packed { bytes, packing } = packed?;
    output::file(output, &bytes)?;
    ui.clear();
    Ok(Summary {
        file: output,
        bytes: bytes.len(),
        bytes_before: rig_file::encode(rig)?.len(),
        bytes_per_vertex: bytes.len() as f64 / rig.vertices() as f64,
        nearness: Nearness::new(&packing, rig.surface().metres_per_unit),
    })
}

impl Summary<'_> {
    /// What was written, in two or three lines.
    pub(super) fn text(&self) -> String {
        format!(
            "{}: {} instead of {}, {:.0} bytes a vertex\n{}",
            self.file.display(),
            human::bytes(self.bytes as u64),
            human::bytes(self.bytes_before as u64),
            self.bytes_per_vertex,
            self.nearness.text()
        )
    }
}
