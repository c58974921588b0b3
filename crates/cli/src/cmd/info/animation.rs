//! `rhytid info` of an animation.

use super::shape::{row, up};
use rhytid::formats::export::Provenance;
use rhytid::formats::{Reach, animation};
use rhytid::human;
use rhytid::{Result, UpAxis};
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
pub(super) struct AnimationInfo {
    pub name: String,
    metres_per_unit: f64,
    up: UpAxis,
    vertices: usize,
    faces: usize,
    frames: usize,
    first_time_code: f64,
    rate: f64,
    normals: bool,
    velocities: bool,
    strain: bool,
    head: bool,
    /// In mesh units; null where the file is exact.
    stated_error: Option<f64>,
    /// Null where the file does not say how it was made.
    provenance: Option<Provenance>,
}

impl AnimationInfo {
    pub(super) fn read(path: &Path, reach: Reach) -> Result<Self> {
        let reader = animation::open_within(path, reach)?;
        let summary = reader.summary();
        Ok(Self {
            name: summary.name.clone(),
            metres_per_unit: summary.metres_per_unit,
            up: summary.up_axis,
            vertices: summary.vertices,
            faces: summary.faces.len(),
            frames: summary.frames,
            first_time_code: summary.first_time_code,
            rate: summary.rate,
            normals: summary.normals,
            velocities: summary.velocities,
            strain: summary.strain,
            head: summary.head,
            stated_error: summary.stated_error,
            provenance: summary.provenance.clone(),
        })
    }

    pub(super) fn rows(&self) -> Vec<[String; 2]> {
        let unit = human::unit(self.metres_per_unit);
        let lacks = |what: &str, is_there: bool| if is_there { None } else { Some(what.to_owned()) };
        let lacking: Vec<String> = [
            lacks("normals", self.normals),
            lacks("velocities", self.velocities),
            lacks("the head's motion", self.head),
        ]
        .into_iter()
        .flatten()
        .collect();
        let mut rows = vec![
            row("units", format!("{unit}, {} up", up(self.up))),
            row("vertices", human::count(self.vertices)),
            row("faces", human::count(self.faces)),
            row(
                "frames",
                format!(
                    "{} from time code {} on, {} per second",
                    human::count(self.frames),
                    human::number(self.first_time_code),
                    human::number(self.rate)
                ),
            ),
        ];
        if let Some(error) = self.stated_error {
            let millimetres = human::number((error * self.metres_per_unit * 1e6).round() / 1e3);
            rows.push(row("compressed", format!("each vertex is within {millimetres} mm")));
        }
        if !lacking.is_empty() {
            rows.push(row("has no", lacking.join(", ")));
        }
        rows.push(row(
            "made by",
            self.provenance.as_ref().map_or_else(
                || "it does not say: `rhytid verify` cannot compare it".to_owned(),
                |made| {
                    format!("Rhytid {} of the frames {}..{}", made.version, made.first_frame, made.end_frame)
                },
            ),
        ));
        let edit = self.provenance.as_ref().and_then(|made| made.edit.as_ref());
        rows.extend(edit.map(|text| {
            row(
                "edited by",
                text.lines()
                    .filter(|line| !line.trim().is_empty() && !line.starts_with('#'))
                    .collect::<Vec<_>>()
                    .join(" | "),
            )
        }));
        rows
    }
}
