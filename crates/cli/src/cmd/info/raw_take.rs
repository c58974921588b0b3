//! `rhytid info` of a raw take: what is in the file, before any clean-up.

use super::shape::{Bounds, list, row};
use rhytid::Result;
use rhytid::core::human;
use rhytid::core::{Mesh, RawTake, TakeEvent};
use rhytid::formats::raw_take;
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
pub(super) struct RawTakeInfo {
    frames: usize,
    rate: f64,
    start: f64,
    end: f64,
    markers: usize,
    labels: Vec<String>,
    /// For each marker, the number of frames in which it is missing.
    missing: Vec<usize>,
    metres_per_unit: Option<f64>,
    bounds: Option<Bounds>,
    /// The time code of the first frame, `hh:mm:ss:ff`.
    timecode: Option<String>,
    /// Frames of the time code in a second.
    timecode_rate: Option<f64>,
    /// When the recording began, in the words of the file.
    started: Option<String>,
    /// The number of the first frame in the recording that the take was cut from.
    first_frame: Option<i64>,
    events: Vec<EventInfo>,
    warnings: Vec<String>,
}

/// A named moment.
#[derive(Serialize)]
struct EventInfo {
    name: String,
    /// Seconds, as the times of the frames count.
    time: f64,
}

impl RawTakeInfo {
    pub(super) fn read(path: &Path) -> Result<Self> {
        let RawTake { tracks, metres_per_unit, recording, warnings, .. } = raw_take::read(path, None)?;
        let mut missing = vec![0; tracks.labels.len()];
        let is_missing = |p: &[f64; 3]| p[0].is_nan();
        for frame in tracks.positions.chunks(missing.len().max(1)) {
            missing.iter_mut().zip(frame).for_each(|(n, p)| *n += usize::from(is_missing(p)));
        }
        let seen = tracks.positions.iter().copied().filter(|p| !is_missing(p)).collect();
        Ok(Self {
            frames: tracks.frames(),
            rate: tracks.rate(),
            start: tracks.times.first().copied().unwrap_or_default(),
            end: tracks.times.last().copied().unwrap_or_default(),
            markers: tracks.labels.len(),
            bounds: Mesh { positions: seen, ..Mesh::default() }.bounds().map(Bounds::from),
            labels: tracks.labels,
            missing,
            metres_per_unit,
            timecode: recording.timecode.map(|timecode| timecode.to_string()),
            timecode_rate: recording.timecode.and_then(|timecode| timecode.rate),
            started: recording.started,
            first_frame: recording.first_frame,
            events: recording
                .events
                .into_iter()
                .map(|TakeEvent { name, time }| EventInfo { name, time })
                .collect(),
            warnings,
        })
    }

    pub(super) fn rows(&self) -> Vec<[String; 2]> {
        let missing: usize = self.missing.iter().sum();
        let share = missing as f64 / (self.frames * self.markers).max(1) as f64 * 100.0;
        let with_gaps = self.missing.iter().filter(|&&n| n > 0).count();
        let mut rows = vec![
            row("frames", human::count(self.frames)),
            row("rate", format!("{} frames per second", human::number(self.rate))),
            row("time", format!("{} s to {} s", human::number(self.start), human::number(self.end))),
            row("markers", list(&self.labels)),
            row(
                "missing",
                format!("{share:.2} % of all samples, of {}", human::counted(with_gaps, "marker")),
            ),
            row("unit", self.metres_per_unit.map_or_else(|| "not said".to_owned(), human::unit)),
        ];
        rows.extend(self.bounds.as_ref().map(|b| row("bounds", b.text("units of the file"))));
        rows.extend(self.started.iter().map(|started| row("recorded", started.clone())));
        rows.extend(self.timecode.iter().map(|timecode| row("time code", timecode.clone())));
        let first = self.first_frame.filter(|&first| first > 1);
        rows.extend(first.map(|first| row("first frame", first.to_string())));
        if !self.events.is_empty() {
            let events: Vec<String> = self
                .events
                .iter()
                .map(|event| format!("{} at {} s", event.name, human::number(event.time)))
                .collect();
            rows.push(row("events", list(&events)));
        }
        rows.extend(self.warnings.iter().map(|warning| row("note", warning.clone())));
        rows
    }
}
