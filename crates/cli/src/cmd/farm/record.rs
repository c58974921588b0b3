//! What is known of a file that a task has written. A task whose record fits is done.

use super::job::{Film, Job};
use crate::args::StepName;
use crate::output;
use rhytid::{Error, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// The folder of the records, which has the folders of the files.
const FOLDER: &str = "records";

/// What a task writes.
#[derive(Debug)]
pub(super) struct Target {
    /// The take's number in the job.
    pub take: usize,
    /// The file, relative to the output's folder.
    pub file: String,
    /// All that decides the file.
    pub made_from: String,
}

impl Target {
    /// What the task with this number writes. The number is in range.
    pub(super) fn of(job: &Job, step: StepName, number: usize) -> Self {
        match step {
            StepName::Animate => {
                let chunk = &job.chunks[number];
                let made_from = job.takes[chunk.take].made_from.clone();
                Self { take: chunk.take, file: chunk.file.clone(), made_from }
            }
            StepName::Stitch => {
                let parts: Vec<&str> =
                    job.chunks_of(number).into_iter().map(|(_, chunk)| chunk.file.as_str()).collect();
                let made_from = format!("{} {}", job.takes[number].made_from, parts.join(" "));
                Self { take: number, file: format!("{}.{}", job.takes[number].name, job.kind), made_from }
            }
            StepName::Film => {
                let extension = if cfg!(feature = "film") { "mp4" } else { "webp" };
                let mut made_from = job.takes[number].made_from.clone();
                if let Some(Film { size, fps }) = &job.film {
                    made_from.push_str(&format!(" {size} {}", fps.unwrap_or_default()));
                }
                Self {
                    take: number,
                    file: format!("films/{}.{extension}", job.takes[number].name),
                    made_from,
                }
            }
        }
    }

    /// The file of the record.
    fn record(&self, output: &Path) -> PathBuf {
        output.join(FOLDER).join(format!("{}.json", self.file))
    }

    /// The record, if the file is there and was made from the same.
    pub(super) fn done(&self, output: &Path) -> Option<Record> {
        let record: Record = serde_json::from_str(&fs::read_to_string(self.record(output)).ok()?).ok()?;
        let bytes = fs::metadata(output.join(&self.file)).ok()?.len();
        (record.made_from == self.made_from && record.bytes == bytes).then_some(record)
    }

    /// Makes the file's folder, and removes the record of a file that is about to change. So no record is
    /// ever beside a file that it does not describe.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub(super) fn begin(&self, output: &Path) -> Result<()> {
        make_folder_of(&output.join(&self.file))?;
        let record = self.record(output);
        match fs::remove_file(&record) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(Error::io(&record)(error)),
            _ => Ok(()),
        }
    }

    /// Keeps that the file is done.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub(super) fn finish(
        &self,
        output: &Path,
        frames: usize,
        seconds: f64,
        verified: Value,
    ) -> Result<Record> {
        let file = output.join(&self.file);
        let bytes = fs::metadata(&file).map_err(Error::io(&file))?.len();
        let record = Record { made_from: self.made_from.clone(), bytes, frames, seconds, verified };
        let text =
            serde_json::to_string_pretty(&record).map_err(|error| Error::Internal(error.to_string()))?;
        let path = self.record(output);
        make_folder_of(&path)?;
        output::file(&path, text.as_bytes())?;
        Ok(record)
    }
}

/// A file that is done. It is written behind the file.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Record {
    /// All that decided the file.
    pub made_from: String,
    pub bytes: u64,
    pub frames: usize,
    /// Seconds of the task without its start.
    pub seconds: f64,
    /// What `verify --json` prints; null where nothing was verified.
    pub verified: Value,
}

fn make_folder_of(file: &Path) -> Result<()> {
    let folder = file.parent().unwrap_or(Path::new(""));
    fs::create_dir_all(folder).map_err(Error::io(folder))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn target(made_from: &str) -> Target {
        Target { take: 0, file: "parts/a.usd".to_owned(), made_from: made_from.to_owned() }
    }

    #[test]
    fn a_record_is_of_its_file_and_of_what_made_it() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path();
        let one = target("one");
        assert!(one.done(output).is_none());
        one.begin(output).unwrap();
        fs::write(output.join("parts/a.usd"), "12345").unwrap();
        one.finish(output, 3, 0.5, Value::Null).unwrap();
        assert_eq!(one.done(output).map(|record| (record.frames, record.bytes)), Some((3, 5)));
        assert!(target("two").done(output).is_none());
        // Another job begins the file, and ends before its end. The file may be that of either.
        target("two").begin(output).unwrap();
        assert!(one.done(output).is_none() && target("two").done(output).is_none());
        one.finish(output, 3, 0.5, Value::Null).unwrap();
        fs::write(output.join("parts/a.usd"), "1234").unwrap();
        assert!(one.done(output).is_none(), "a file that was cut short");
    }
}
