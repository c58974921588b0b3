//! The file that a recording grows in.

use rhytid::core::RawTake;
use rhytid::formats::take::TakeStream;
use rhytid::live::{LEARNING, LiveFrame};
use rhytid::{Error, Result};
use std::path::{Path, PathBuf};

/// A file that has each frame as it comes. A full disk does not end the recording: the frames are in memory,
/// too.
pub(super) struct RecordingFile {
    path: PathBuf,
    /// `None` until the labels are known.
    stream: Option<TakeStream>,
    /// The number of columns with markers.
    markers: usize,
    /// The first frames, until the labels are known.
    first: Vec<(f64, Vec<[f32; 3]>)>,
    has_all_markers: bool,
    is_whole: bool,
}

impl RecordingFile {
    /// A file of a rig's handles.
    ///
    /// # Errors
    /// As [`TakeStream::create`].
    pub(super) fn of_handles(path: &Path, labels: &[String]) -> Result<Self> {
        let stream = Some(TakeStream::create(path, labels)?);
        Ok(Self { stream, markers: labels.len(), has_all_markers: false, ..Self::new(path) })
    }

    /// A file of all markers that come in the first seconds.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be made.
    pub(super) fn of_all_markers(path: &Path) -> Result<Self> {
        // What cannot be written is an error before the recording.
        std::fs::File::create_new(path).and_then(|_| std::fs::remove_file(path)).map_err(Error::io(path))?;
        Ok(Self::new(path))
    }

    fn new(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            stream: None,
            markers: 0,
            first: Vec::new(),
            has_all_markers: true,
            is_whole: true,
        }
    }

    /// Adds a frame.
    pub(super) fn frame(&mut self, frame: &LiveFrame<'_>, labels: &[String]) {
        if !self.has_all_markers {
            self.write(frame.time, frame.positions, Some(frame.confidence));
            return;
        }
        let missing = RawTake::MISSING.map(|x| x as f32);
        let seen = frame.positions.iter().zip(frame.confidence);
        let seen: Vec<[f32; 3]> = seen.map(|(p, sure)| if *sure < 1.0 { missing } else { *p }).collect();
        let since = self.first.first().map_or(frame.time, |(time, _)| *time);
        if self.stream.is_some() {
            self.write(frame.time, &seen, None);
        } else {
            self.first.push((frame.time, seen));
            if frame.time - since >= LEARNING {
                self.begin(labels);
            }
        }
    }

    /// The end of the recording. The result is whether the file has all of it.
    pub(super) fn finish(mut self, labels: &[String]) -> bool {
        if self.stream.is_none() {
            self.begin(labels);
        }
        self.is_whole && self.markers == labels.len()
    }

    /// Makes the file with these labels, and writes the first frames.
    fn begin(&mut self, labels: &[String]) {
        self.markers = labels.len();
        match TakeStream::create(&self.path, labels) {
            Ok(stream) => self.stream = Some(stream),
            Err(error) => self.fail(&error),
        }
        for (time, positions) in std::mem::take(&mut self.first) {
            self.write(time, &positions, None);
        }
    }

    /// Writes a row. Without confidence, all that is there was seen.
    fn write(&mut self, time: f64, positions: &[[f32; 3]], confidence: Option<&[f32]>) {
        let Some(stream) = self.stream.as_mut().filter(|_| self.is_whole) else { return };
        let mut row = positions.to_vec();
        row.resize(self.markers, RawTake::MISSING.map(|x| x as f32));
        let all_seen = vec![1.0; self.markers];
        if let Err(error) = stream.frame(time, &row, confidence.unwrap_or(&all_seen)) {
            self.fail(&error);
        }
    }

    fn fail(&mut self, error: &Error) {
        log::warn!("{error}: the recording goes on in memory alone");
        self.is_whole = false;
    }
}
