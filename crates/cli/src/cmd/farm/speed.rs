//! How long a chunk is, by measuring some frames of a take on this machine.

use super::task;
use crate::args;
use crate::cmd::animate;
use crate::progress::Ui;
use rhytid::playback::FrameRange;
use rhytid::{Error, Result};
use serde::Serialize;
use std::fs;
use std::ops::Range;
use std::path::Path;
use std::time::Instant;

/// The frames of the short run, whose time is mostly that of the start.
const FEW: usize = 4;
/// The frames of the first long run.
const MANY: usize = 32;
/// A long run takes at least this long, unless the take ends before.
const SECONDS: f64 = 2.0;

/// What a chunk costs on this machine.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Speed {
    /// Seconds of a task besides its frames: reading the rig and the take.
    pub start_seconds: f64,
    /// Seconds of a frame that is written and verified.
    pub frame_seconds: f64,
    /// Bytes of a frame in the file.
    pub frame_bytes: f64,
}

/// A run of some frames.
struct Run {
    frames: usize,
    seconds: f64,
    bytes: u64,
}

impl Speed {
    /// Measures frames of the first take, in a folder that vanishes.
    ///
    /// # Errors
    /// As `animate` and `verify`.
    pub(super) fn measure(
        folder: &Path,
        mut options: Box<args::Animate>,
        frames: usize,
        ui: &Ui,
    ) -> Result<Self> {
        let scratch = Scratch::new(folder)?;
        let extension = options.output.extension().unwrap_or_default().to_owned();
        let mut runs = 0;
        let mut run = |frames: Range<usize>| -> Result<Run> {
            options.frames =
                args::FramesChoice::Range(FrameRange { start: Some(frames.start), end: Some(frames.end) });
            // A file that was read is never written over.
            runs += 1;
            options.output = scratch.0.join(runs.to_string()).with_extension(&extension);
            let start = Instant::now();
            animate::animate(&options, ui)?;
            task::verify(&options, ui)?;
            let seconds = start.elapsed().as_secs_f64();
            let bytes = fs::metadata(&options.output).map_err(Error::io(&options.output))?.len();
            Ok(Run { frames: frames.len(), seconds, bytes })
        };
        // The first run also brings the inputs into memory.
        run(0..frames.min(FEW))?;
        let few = run(0..frames.min(FEW))?;
        let mut many = few.frames.max(MANY.min(frames));
        loop {
            let long = run(0..many)?;
            if long.seconds - few.seconds < SECONDS && many < frames {
                many = (4 * many).min(frames);
                continue;
            }
            return Ok(Self::of(&few, &long));
        }
    }

    fn of(few: &Run, long: &Run) -> Self {
        let frames = (long.frames - few.frames) as f64;
        if frames == 0.0 {
            let of_frame = long.frames as f64;
            return Self {
                start_seconds: 0.0,
                frame_seconds: long.seconds / of_frame,
                frame_bytes: long.bytes as f64 / of_frame,
            };
        }
        // A run can be shorter than a shorter one where something else runs beside it.
        let frame_seconds = ((long.seconds - few.seconds) / frames).max(1e-6);
        Self {
            start_seconds: (few.seconds - frame_seconds * few.frames as f64).max(0.0),
            frame_seconds,
            frame_bytes: long.bytes.saturating_sub(few.bytes) as f64 / frames,
        }
    }

    /// The frames of a chunk that takes so many minutes.
    pub(super) fn chunk(&self, minutes: f64) -> usize {
        (((60.0 * minutes - self.start_seconds) / self.frame_seconds) as usize).max(1)
    }
}

/// A folder that vanishes.
struct Scratch(std::path::PathBuf);

impl Scratch {
    fn new(folder: &Path) -> Result<Self> {
        let path = folder.join(format!(".measure-{}", std::process::id()));
        fs::create_dir_all(&path).map_err(Error::io(&path))?;
        Ok(Self(path))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chunk_has_the_frames_of_its_minutes() {
        // 2 s of start, 0.1 s and 1,000 bytes for each frame.
        let run = |frames: usize| Run {
            frames,
            seconds: 2.0 + 0.1 * frames as f64,
            bytes: 500 + 1000 * frames as u64,
        };
        let speed = Speed::of(&run(4), &run(64));
        assert!((speed.start_seconds - 2.0).abs() < 1e-9 && (speed.frame_seconds - 0.1).abs() < 1e-9);
        assert_eq!(speed.frame_bytes, 1000.0);
        assert_eq!(speed.chunk(10.0), 5980);
        // A chunk that only starts has a frame.
        assert_eq!(speed.chunk(0.01), 1);
        // A take of a single frame.
        let one = Speed::of(&run(1), &run(1));
        assert!((one.frame_seconds - 2.1).abs() < 1e-9);
    }
}
