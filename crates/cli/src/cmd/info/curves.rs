//! `rhytid info` of curves.

use super::shape::{list, row};
use rhytid::core::human;
use rhytid::formats::curves;
use rhytid::{Result, Take};
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
pub(super) struct CurvesInfo {
    frames: usize,
    rate: f64,
    start: f64,
    end: f64,
    curves: Vec<CurveInfo>,
    warnings: Vec<String>,
}

/// A curve and its largest weight by magnitude.
#[derive(Serialize)]
struct CurveInfo {
    name: String,
    largest: f32,
}

impl CurvesInfo {
    pub(super) fn read(path: &Path) -> Result<Self> {
        let found = curves::read(path, None)?;
        let named = found.names.iter().enumerate();
        let curves = named.map(|(i, name)| CurveInfo { name: name.clone(), largest: found.largest(i) });
        Ok(Self {
            frames: found.frames(),
            curves: curves.collect(),
            start: found.times.first().copied().unwrap_or_default(),
            end: found.times.last().copied().unwrap_or_default(),
            rate: Take { times: found.times, ..Take::default() }.rate(),
            warnings: found.warnings,
        })
    }

    pub(super) fn rows(&self) -> Vec<[String; 2]> {
        let is_moved = |curve: &&CurveInfo| curve.largest > 0.0;
        let moved: Vec<String> =
            self.curves.iter().filter(is_moved).map(|curve| curve.name.clone()).collect();
        let mut rows = vec![
            row("frames", human::count(self.frames)),
            row("rate", format!("{} frames per second", human::number(self.rate))),
            row("time", format!("{} s to {} s", human::number(self.start), human::number(self.end))),
            row("curves", human::count(self.curves.len())),
            row("moved", list(&moved)),
        ];
        rows.extend(self.warnings.iter().map(|warning| row("note", warning.clone())));
        rows
    }
}
