//! `rhytid info` of an animation.

use super::shape::{row, up};
use rhytid::Result;
use rhytid::core::human;
use rhytid::core::{ChannelKind, UpAxis};
use rhytid::formats::export::StatedRecipe;
use rhytid::formats::{Reach, animation};
use serde::Serialize;
use std::collections::BTreeMap;
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
    /// For each kind, whether the file has any of it.
    #[serde(flatten)]
    kinds: BTreeMap<&'static str, bool>,
    /// The names of all channels.
    channels: Vec<String>,
    head: bool,
    /// In mesh units; null where the file is exact.
    stated_error: Option<f64>,
    /// Null where the file does not say how it was made.
    #[serde(rename = "provenance")]
    recipe: Option<StatedRecipe>,
    /// The clips of a file of several takes. The fields above are those of the first.
    clips: Vec<ClipInfo>,
}

/// One of several clips.
#[derive(Serialize)]
struct ClipInfo {
    name: String,
    frames: usize,
    first_time_code: f64,
    rate: f64,
    stated_error: Option<f64>,
    #[serde(rename = "provenance")]
    recipe: Option<StatedRecipe>,
}

impl AnimationInfo {
    pub(super) fn read(path: &Path, reach: Reach) -> Result<Self> {
        let reader = animation::open_within(path, reach)?;
        let summary = reader.summary();
        let has = |kind| summary.channels.iter().any(|channel| channel.kind == Some(kind));
        Ok(Self {
            name: summary.name.clone(),
            metres_per_unit: summary.metres_per_unit,
            up: summary.up_axis,
            vertices: summary.vertices,
            faces: summary.faces.len(),
            frames: summary.frames,
            first_time_code: summary.first_time_code,
            rate: summary.rate,
            kinds: ChannelKind::ALL.into_iter().map(|kind| (kind.name(), has(kind))).collect(),
            channels: summary.channels.iter().map(|channel| channel.name.clone().into_owned()).collect(),
            head: summary.head,
            stated_error: summary.stated_error.map(|error| error.worst),
            recipe: summary.recipe.clone(),
            clips: summary
                .clips
                .iter()
                .map(|clip| ClipInfo::read(path, reach, clip))
                .collect::<Result<_>>()?,
        })
    }

    /// An error in mesh units, in millimetres.
    fn millimetres(&self, error: f64) -> String {
        human::number((error * self.metres_per_unit * 1e6).round() / 1e3)
    }

    pub(super) fn rows(&self) -> Vec<[String; 2]> {
        let unit = human::unit(self.metres_per_unit);
        let has = |kind: ChannelKind| self.kinds.get(kind.name()) == Some(&true);
        let mut lacking: Vec<&str> = Vec::new();
        // Rare channels are listed only where the file has them.
        let usual = [ChannelKind::Normals, ChannelKind::Velocities].into_iter();
        lacking.extend(usual.filter(|kind| !has(*kind)).map(ChannelKind::name));
        lacking.extend((!self.head).then_some("the head's motion"));
        let mut rows = vec![
            row("units", format!("{unit}, {} up", up(self.up))),
            row("vertices", human::count(self.vertices)),
            row("faces", human::count(self.faces)),
        ];
        let frames = |frames: usize, first: f64, rate: f64| {
            let [first, rate] = [first, rate].map(human::number);
            format!("{} from time code {first} on, {rate} per second", human::count(frames))
        };
        if self.clips.is_empty() {
            rows.push(row("frames", frames(self.frames, self.first_time_code, self.rate)));
            let within = |error| format!("each vertex is within {} mm", self.millimetres(error));
            rows.extend(self.stated_error.map(|error| row("compressed", within(error))));
        }
        for clip in &self.clips {
            let within = |error| format!("; each vertex is within {} mm", self.millimetres(error));
            let within = clip.stated_error.map_or_else(String::new, within);
            let frames = frames(clip.frames, clip.first_time_code, clip.rate);
            rows.push(row("clip", format!("{}: {frames}{within}", clip.name)));
        }
        if !lacking.is_empty() {
            rows.push(row("has no", lacking.join(", ")));
        }
        let further: Vec<&str> = self.channels.iter().skip(1).map(String::as_str).collect();
        if !further.is_empty() {
            rows.push(row("channels", further.join(", ")));
        }
        rows.push(row(
            "made by",
            self.recipe.as_ref().map_or_else(
                || "it does not say: `rhytid verify` cannot compare it".to_owned(),
                |made| {
                    let number = |name| made.get(name).map_or_else(String::new, ToString::to_string);
                    let version = made.text("version").unwrap_or_default();
                    format!(
                        "Rhytid {version} of the frames {}..{}",
                        number("first_frame"),
                        number("end_frame")
                    )
                },
            ),
        ));
        let edit = self.recipe.as_ref().and_then(|made| made.text("edit"));
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

impl ClipInfo {
    fn read(path: &Path, reach: Reach, clip: &str) -> Result<Self> {
        let reader = animation::open_clip(path, reach, Some(clip))?;
        let summary = reader.summary();
        Ok(Self {
            name: clip.to_owned(),
            frames: summary.frames,
            first_time_code: summary.first_time_code,
            rate: summary.rate,
            stated_error: summary.stated_error.map(|error| error.worst),
            recipe: summary.recipe.clone(),
        })
    }
}
