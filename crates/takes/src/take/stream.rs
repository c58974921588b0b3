//! A take that is written while it is recorded.

use super::columns::AXES;
use super::confidence;
use rhytid_core::{Error, Result};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A take's CSV that grows by a row for each frame.
///
/// Each row is one write to the file. So the file is a sound take after every frame, even if the process is
/// killed then. A row for which the disk has no room leaves nothing behind.
#[derive(Debug)]
pub struct TakeStream {
    file: File,
    path: PathBuf,
    /// Bytes of the header and of the rows so far.
    length: u64,
}

impl TakeStream {
    /// Begins a file with the columns of these labels. A file that is there already stays.
    ///
    /// # Errors
    /// [`Error::Io`], also if the file exists.
    pub fn create(path: &Path, labels: &[String]) -> Result<Self> {
        let mut options = File::options();
        options.append(true).create_new(true);
        let file = options.open(path).map_err(Error::io(path))?;
        let mut stream = Self { file, path: path.to_owned(), length: 0 };
        let mut row = crate::tables::csv_of(labels.iter().map(String::as_str));
        let mut encode = || -> csv::Result<()> {
            row.write_field("time")?;
            for label in labels {
                for suffix in AXES {
                    row.write_field(format!("{label}{suffix}"))?;
                }
            }
            for label in labels {
                row.write_field(confidence::column(label))?;
            }
            row.write_record(None::<&[u8]>)
        };
        encode().map_err(|e| Error::Internal(e.to_string()))?;
        stream.write(&row.into_inner().map_err(|e| Error::Internal(e.to_string()))?)?;
        Ok(stream)
    }

    /// Adds a frame: its time in seconds, a position and a confidence (0 to 1) for each label. A position
    /// that is NaN is missing.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn frame(&mut self, time: f64, positions: &[[f32; 3]], confidence: &[f32]) -> Result<()> {
        let mut digits = ryu::Buffer::new();
        let mut row = digits.format(time).to_owned();
        for x in positions.as_flattened() {
            row.push(',');
            if !x.is_nan() {
                row.push_str(digits.format(f64::from(*x)));
            }
        }
        for x in confidence {
            row.push(',');
            row.push_str(digits.format(*x));
        }
        row.push('\n');
        self.write(row.as_bytes())
    }

    fn write(&mut self, bytes: &[u8]) -> Result<()> {
        if let Err(e) = self.file.write_all(bytes) {
            // The error that is told is the one of the write.
            let _ = self.file.set_len(self.length);
            return Err(Error::io(&self.path)(e));
        }
        self.length += bytes.len() as u64;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::take::{Missing, read};

    #[test]
    fn it_is_a_sound_take_after_every_frame() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("take.csv");
        let labels = ["a".to_owned(), "=b".to_owned()];
        let mut stream = TakeStream::create(&path, &labels).unwrap();
        for frame in 0..3_u8 {
            let x = f32::from(frame) + 0.1;
            let time = f64::from(frame) / 3.0;
            stream.frame(time, &[[x, 3e38, -1.0], [1.0, 2.0, 3.0]], &[1.0, 0.25]).unwrap();
            let take = read(&path, None, Missing::Leave).unwrap();
            assert_eq!((take.frames(), &*take.labels), (usize::from(frame) + 1, &labels[..]));
            assert_eq!(take.times[usize::from(frame)], time);
            assert_eq!(take.positions[2 * usize::from(frame)], [x, 3e38, -1.0].map(f64::from));
            assert_eq!(take.confidence.unwrap(), [1.0, 0.25].repeat(usize::from(frame) + 1));
        }
        assert!(TakeStream::create(&path, &labels).is_err(), "it stays");
    }
}
