//! Live positions in world space, brought onto the rig frame by frame.

use crate::live::Shown;
use rhytid_capture::{Online, Settings, Target};
use rhytid_core::{RawTake, Rig, Take, Warning};
use rhytid_live::LiveFrame;

/// How long the neutral face is held at the start, in seconds.
const NEUTRAL: f64 = 0.5;
/// The most frames of the start.
const MOST_FRAMES: usize = 10_000;

/// The actor, once the neutral face has been seen.
pub(crate) struct World {
    target: Target,
    settings: Settings,
    /// The frames until the actor is known.
    start: Take,
    rows: Vec<Vec<[f64; 3]>>,
    online: Option<Online>,
    /// What a user should read; empty where there is nothing.
    pub note: String,
}

impl World {
    pub(crate) fn new(rig: &Rig, settings: &Settings) -> Self {
        let (target, settings) = (Target::from_rig(rig), settings.clone());
        let note = "the neutral face is awaited".to_owned();
        Self { target, settings, start: Take::default(), rows: Vec::new(), online: None, note }
    }

    /// The frame on the rig; `None` until the actor is known.
    pub(crate) fn frame(&mut self, frame: &LiveFrame<'_>, labels: &[String]) -> Option<Shown> {
        // A marker that is held in the world is not where it is on the head.
        let markers: Vec<[f64; 3]> = frame
            .positions
            .iter()
            .zip(frame.confidence)
            .map(|(p, sure)| if *sure < 1.0 { RawTake::MISSING } else { p.map(f64::from) })
            .collect();
        let Some(online) = &mut self.online else {
            self.learn(frame.time, markers, labels);
            return None;
        };
        let frame = online.frame(frame.time, &markers);
        Some(Shown { positions: frame.positions.into_flattened(), confidence: frame.confidence })
    }

    /// Takes a frame of the start. When the neutral frames are there, the actor is known.
    fn learn(&mut self, time: f64, markers: Vec<[f64; 3]>, labels: &[String]) {
        self.start.times.push(time);
        self.rows.push(markers);
        let (frames, first) = (self.rows.len(), self.start.times[0]);
        let neutral = self.settings.neutral.clone().filter(|neutral| neutral.end <= MOST_FRAMES);
        let is_enough = match &neutral {
            Some(neutral) => frames >= neutral.end,
            None => time - first >= NEUTRAL || frames >= MOST_FRAMES,
        };
        if !is_enough {
            return;
        }
        let mut tracks = std::mem::take(&mut self.start);
        tracks.labels = labels.to_vec();
        for mut row in self.rows.drain(..) {
            row.resize(labels.len(), RawTake::MISSING);
            tracks.positions.extend(row);
        }
        let metres_per_unit = Some(self.target.metres_per_unit);
        let raw = RawTake { tracks, metres_per_unit, ..RawTake::default() };
        let settings = Settings { neutral, ..self.settings.clone() };
        match Online::calibrate(raw, &self.target, &settings) {
            Ok((online, warnings)) => {
                self.online = Some(online);
                self.note = warnings.iter().map(Warning::sentence).collect::<Vec<_>>().join("; ");
            }
            Err(error) => self.note = format!("{error}; the neutral face is awaited again"),
        }
    }
}
