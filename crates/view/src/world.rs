//! Live positions in world space, brought onto the rig frame by frame.

use crate::live::Shown;
use rhytid_capture::{Online, Settings, Target};
use rhytid_core::{Error, RawTake, Result, Rig, Take, Warning};
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
    /// A world in which nothing has been seen.
    ///
    /// # Errors
    /// [`Error::Input`] if the neutral frames of the settings are too far from the start.
    pub(crate) fn new(rig: &Rig, settings: &Settings) -> Result<Self> {
        if let Some(neutral) = settings.neutral.as_ref().filter(|neutral| neutral.end > MOST_FRAMES) {
            return Err(Error::out_of_range(format!(
                "the neutral frames are {}..{}, expected an end of {MOST_FRAMES} at most: nothing is shown before \
                 them; name frames near the start",
                neutral.start, neutral.end
            )));
        }
        let (target, settings) = (Target::from_rig(rig), settings.clone());
        let note = "the neutral face is awaited".to_owned();
        Ok(Self { target, settings, start: Take::default(), rows: Vec::new(), online: None, note })
    }

    /// The frame on the rig; `None` until the actor is known.
    pub(crate) fn frame(&mut self, frame: &LiveFrame<'_>, labels: &[String]) -> Option<Shown> {
        let mut markers = Vec::with_capacity(frame.positions.len());
        for (position, sure) in frame.positions.iter().zip(frame.confidence) {
            // A marker that is held in the world is not where it is on the head. Many programs send 0, 0, 0
            // for what no camera sees, and no face is at the room's origin.
            let is_seen = *sure == 1.0 && *position != [0.0; 3];
            markers.push(if is_seen { position.map(f64::from) } else { RawTake::MISSING });
        }
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
        let is_enough = match &self.settings.neutral {
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
        match Online::calibrate(raw, &self.target, &self.settings) {
            Ok((online, warnings)) => {
                self.online = Some(online);
                self.note = warnings.iter().map(Warning::sentence).collect::<Vec<_>>().join("; ");
            }
            Err(error) => self.note = format!("{error}; the neutral face is awaited again"),
        }
    }
}
