//! Tables as people write them: a row for each frame, or for each frame and marker.
mod long;
mod mediapipe;
mod openface;
mod wide;

pub(super) use long::decode as long;
pub(crate) use mediapipe::is_face_mesh;
pub(super) use openface::decode as openface;
pub(super) use wide::decode as wide;

use super::samples::coordinate;
use super::{labels, units};
use crate::stamps::Times;
use crate::tables::rows::Rows;
use rhytid_core::text::quoted;
use rhytid_core::{Error, RawTake, Result, Take};

/// The positions of a table, frame after frame, before they become a take.
struct Found {
    labels: Vec<String>,
    /// frames × M.
    positions: Vec<[f64; 3]>,
    /// frames × M.
    confidence: Vec<f32>,
    /// The unit of length that the header names; empty where it names none.
    unit: String,
    /// The image's width and height in each frame; empty where the table does not say.
    images: Vec<[f64; 2]>,
    warnings: Vec<String>,
}

impl Found {
    /// No frames yet of markers with these labels.
    fn new(labels: Vec<String>, unit: String) -> Self {
        let (positions, confidence, images, warnings) = Default::default();
        Self { labels, positions, confidence, unit, images, warnings }
    }

    /// The raw take of the rows `times.kept`. Landmarks of MediaPipe are brought into a space of equal axes.
    fn into_take(mut self, times: Times) -> RawTake {
        let m = self.labels.len();
        let frames = || times.kept.iter().flat_map(|&row| row * m..(row + 1) * m);
        self.positions = frames().map(|i| self.positions[i]).collect();
        self.confidence = frames().map(|i| self.confidence[i]).collect();
        if !self.images.is_empty() {
            self.images = times.kept.iter().map(|&row| self.images[row]).collect();
        }
        let is_video = mediapipe::recognise(&mut self);
        let metres_per_unit = units::metres(&self.unit);
        if metres_per_unit.is_none() && !is_video {
            self.warnings.push(units::unknown(&self.unit, "the table"));
        }
        let confidence = self.confidence.iter().any(|c| *c < 1.0).then_some(self.confidence);
        let labels = labels::distinct(self.labels, &mut self.warnings);
        let tracks =
            Take { labels, times: times.times, positions: self.positions, confidence, ..Take::default() };
        RawTake { tracks, metres_per_unit, is_video, warnings: self.warnings, ..RawTake::default() }
    }
}

/// The position in three cells. It is missing where one of them is empty or says that it is no number.
///
/// # Errors
/// [`Error::Input`] for a cell that is neither.
fn position(rows: &Rows<'_>, columns: [usize; 3]) -> Result<[f64; 3]> {
    let mut position = [0.0; 3];
    for (value, column) in position.iter_mut().zip(columns) {
        *value = coordinate(rows.cell(column), rows.number(column)).ok_or_else(|| {
            rows.error(&format!(
                "{} is {}, expected a coordinate, or nothing where a marker was not seen",
                quoted(&rows.header()[column]),
                quoted(&String::from_utf8_lossy(rows.cell(column)))
            ))
        })?;
    }
    Ok(if position.iter().any(|x| x.is_nan()) { RawTake::MISSING } else { position })
}

/// The confidence in a cell from 0 to 1; 1 where there is none. Numbers outside are cut off.
fn confidence(rows: &Rows<'_>, column: Option<usize>) -> f32 {
    let found = column.and_then(|column| rows.number(column)).filter(|number| !number.is_nan());
    found.map_or(1.0, |number| number.clamp(0.0, 1.0) as f32)
}

/// Refuses a table that would take far more room than its file.
fn check_room(rows: &Rows<'_>, positions: usize, bytes: usize) -> Result<()> {
    if positions <= bytes / 2 {
        return Ok(());
    }
    Err(rows.error("the rows are far shorter than the header; the file may be damaged"))
}

fn no_frames(name: &str) -> Error {
    Error::empty(format!("{name}: has no frames, expected rows under the header"))
}
