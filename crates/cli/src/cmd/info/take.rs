//! `rhytid info` of a take.

use super::shape::{Bounds, list, row};
use rhytid::core::Mesh;
use rhytid::core::human;
use rhytid::formats::take;
use rhytid::playback::uneven_step;
use rhytid::{Result, Take};
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
pub(super) struct TakeInfo {
    frames: usize,
    rate: f64,
    even: bool,
    start: f64,
    end: f64,
    markers: usize,
    labels: Vec<String>,
    bounds: Option<Bounds>,
    /// Whether markers are missing from frames; then `bounds` is as with `--missing hold`.
    gaps: bool,
}

impl TakeInfo {
    pub(super) fn read(path: &Path) -> Result<Self> {
        let whole = take::read(path, None, take::Missing::Error);
        let gaps = whole.is_err();
        // An error other than gaps appears again here.
        let take: Take = whole.or_else(|_| take::read(path, None, take::Missing::Hold))?;
        let rate = take.rate();
        Ok(Self {
            frames: take.frames(),
            rate,
            even: uneven_step(&take, rate).is_none(),
            start: take.times.first().copied().unwrap_or_default(),
            end: take.times.last().copied().unwrap_or_default(),
            markers: take.labels.len(),
            bounds: Mesh { positions: take.positions, ..Mesh::default() }.bounds().map(Bounds::from),
            labels: take.labels,
            gaps,
        })
    }

    pub(super) fn rows(&self) -> Vec<[String; 2]> {
        let even = if self.even { "" } else { " on average, uneven: it is resampled when animated" };
        let mut rows = vec![
            row("frames", human::count(self.frames)),
            row("rate", format!("{} frames per second{even}", human::number(self.rate))),
            row("time", format!("{} s to {} s", human::number(self.start), human::number(self.end))),
            row("markers", list(&self.labels)),
        ];
        rows.extend(self.bounds.as_ref().map(|b| row("bounds", b.text("mesh units"))));
        if self.gaps {
            rows.push(row("gaps", "yes: animate it with --missing hold".to_owned()));
        }
        rows
    }
}
