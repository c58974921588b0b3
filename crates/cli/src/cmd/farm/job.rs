//! A job: all that the tasks on all machines need to know, in one file.

use super::words;
use crate::cmd::animate::options;
use crate::{args, call, output};
use rhytid::formats::animation::Format;
use rhytid::formats::export::StatedRecipe;
use rhytid::{Error, Result};
use serde::{Deserialize, Serialize};
use std::ffi::OsString;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// The job's file in its folder.
pub(super) const JOB: &str = "job.json";
/// The version of the program, which must be the same on all machines.
pub(super) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// What a job's file holds. Its paths have slashes, so that a machine of another system reads it.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Job {
    /// The version of the program that wrote the job.
    pub version: String,
    pub rig: InputFile,
    /// The folder that holds all takes, and all files that the options name. Relative to the job's folder.
    pub takes_folder: String,
    /// The extension of the animations.
    pub kind: String,
    /// The device of all machines.
    pub device: String,
    /// The words of `animate`. Files in them are relative to the takes' folder.
    pub options: Vec<String>,
    /// None without films.
    pub film: Option<Film>,
    pub takes: Vec<Take>,
    pub chunks: Vec<Chunk>,
}

/// What the films of a job are like.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Film {
    /// Width and height in pixels, as `render --size` has it.
    pub size: String,
    /// Frames per second; none for those of the animation.
    pub fps: Option<f64>,
}

/// A file that tasks read.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct InputFile {
    /// Relative to the job's folder.
    pub file: String,
    pub hash: String,
}

/// A take of a job.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Take {
    /// Relative to the takes' folder.
    pub file: String,
    /// The name of its animation, different from those of the other takes.
    pub name: String,
    pub hash: String,
    /// The take's own frames.
    pub frames: usize,
    /// The hash of all that decides its animation.
    pub made_from: String,
}

/// The frames that a task evaluates.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Chunk {
    /// The take's number in the job.
    pub take: usize,
    /// The first frame.
    pub first: usize,
    /// The frame behind the last.
    pub end: usize,
    /// The file that is written, relative to the output's folder.
    pub file: String,
}

/// Where a task finds its inputs, and where it writes.
#[derive(Debug)]
pub(super) struct Places {
    pub rig: PathBuf,
    pub takes: PathBuf,
    pub output: PathBuf,
}

impl Job {
    /// Reads a job that this version has written.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Input`] if the file is no job, or one of another version.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let text = fs::read_to_string(path).map_err(Error::io(path))?;
        let wrong = |what: String| Error::input(format!("{}: {what}", path.display()));
        let value: serde_json::Value = serde_json::from_str(&text).map_err(|error| {
            wrong(format!("is no job ({error}); expected the {JOB} that `rhytid farm` wrote"))
        })?;
        // Before the rest, because another version may have other keys.
        if let Some(version) = value["version"].as_str().filter(|version| *version != VERSION) {
            return Err(wrong(format!(
                "is of Rhytid {version}, and this is {VERSION}; install one version on all machines, or write the \
                 job again with `rhytid farm`"
            )));
        }
        let job: Self = serde_json::from_value(value).map_err(|error| {
            wrong(format!("is no job ({error}); expected the {JOB} that `rhytid farm` wrote"))
        })?;
        match job.chunks.iter().find(|chunk| chunk.take >= job.takes.len()) {
            Some(chunk) => Err(wrong(format!("has no take {}; write the job again", chunk.take))),
            None => Ok(job),
        }
    }

    /// Writes the job into its folder.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self).map_err(|error| Error::Internal(error.to_string()))?;
        output::file(&folder.join(JOB), (text + "\n").as_bytes())
    }

    /// Where this job has its files, seen from its folder.
    pub(super) fn places(&self, folder: &Path) -> Places {
        Places {
            rig: folder.join(&self.rig.file),
            takes: folder.join(&self.takes_folder),
            output: folder.to_owned(),
        }
    }

    /// Whether the animations are put together from parts.
    pub(super) fn has_parts(&self) -> bool {
        in_parts(&self.kind, &self.options)
    }

    /// The chunks of a take with their numbers.
    pub(super) fn chunks_of(&self, take: usize) -> Vec<(usize, &Chunk)> {
        self.chunks.iter().enumerate().filter(|(_, chunk)| chunk.take == take).collect()
    }

    /// The command line of `animate` for a take.
    ///
    /// # Errors
    /// [`Error::Input`] for words that are no options.
    pub(super) fn animate(
        &self,
        places: &Places,
        take: usize,
        output: &Path,
        frames: &str,
        device: &str,
    ) -> Result<Box<args::Animate>> {
        let take = places.takes.join(&self.takes[take].file);
        animate(&places.rig, &take, output, frames, device, &words::from_folder(&self.options, &places.takes))
    }
}

/// Whether files with this extension can be stitched.
fn in_parts(kind: &str, options: &[String]) -> bool {
    let format = Format::from_extension(&Path::new("x").with_extension(kind));
    matches!(format, Ok(Format::Usdc | Format::Usda)) && !options.iter().any(|word| word == "--over")
}

/// The options of `animate` with these words.
///
/// # Errors
/// [`Error::Input`] for words that are no options.
pub(super) fn animate(
    rig: &Path,
    take: &Path,
    output: &Path,
    frames: &str,
    device: &str,
    words: &[String],
) -> Result<Box<args::Animate>> {
    let mut line: Vec<OsString> = vec!["animate".into(), rig.into(), take.into()];
    line.extend([OsString::from("-o"), output.into(), "--device".into(), device.into()]);
    line.push(format!("--frames={frames}").into());
    line.extend(words.iter().map(OsString::from));
    call::parse_animate(line)
}

/// The hash of all that decides the animation of a take with these options, which are those of `job`.
///
/// # Errors
/// As reading a setup.
pub(super) fn made_from(args: &args::Animate, job: &Job, take: &str) -> Result<String> {
    let format = Format::from_extension(&args.output)?;
    let recipe = options::recipe(args, job.rig.hash.clone(), format, None)?;
    let recipe = StatedRecipe::from(&recipe).0;
    let text = serde_json::to_string(&(VERSION, take, recipe, &job.options, &job.kind, &job.device));
    let text = text.map_err(|error| Error::Internal(error.to_string()))?;
    Ok(blake3::hash(text.as_bytes()).to_hex().to_string())
}

/// The whole path of a file that is there. A link stays a link.
///
/// # Errors
/// [`Error::Io`].
pub(super) fn whole(path: &Path) -> Result<PathBuf> {
    let at = std::path::absolute(path).map_err(Error::io(path))?;
    fs::metadata(&at).map_err(Error::io(path))?;
    match (at.parent(), at.file_name()) {
        (Some(folder), Some(name)) => Ok(folder.canonicalize().map_err(Error::io(path))?.join(name)),
        _ => at.canonicalize().map_err(Error::io(path)),
    }
}

/// The path of a file that is there, relative to `folder`, with slashes. `folder` is a whole path. On another
/// drive it is the whole path.
///
/// # Errors
/// [`Error::Io`]; [`Error::Input`] for a name that is no text.
pub(super) fn relative(path: &Path, folder: &Path) -> Result<String> {
    let at = whole(path)?;
    let [to, from] = [&*at, folder].map(|path| path.components().collect::<Vec<_>>());
    let shared = to.iter().zip(&from).take_while(|(a, b)| a == b).count();
    let mut words = vec![".."; from.len() - shared];
    for component in &to[shared..] {
        let text = component.as_os_str().to_str().ok_or_else(|| {
            Error::bad_path(format!(
                "{}: its name is no text, so that no job can hold it; rename it",
                path.display()
            ))
        })?;
        if matches!(component, Component::Prefix(_)) {
            return Ok(at.display().to_string().replace('\\', "/"));
        }
        words.push(text);
    }
    Ok(if words.is_empty() { ".".to_owned() } else { words.join("/") })
}

/// The innermost folder that holds all of these files, which are whole paths; none if only the root does.
pub(super) fn folder_of_all(files: &[PathBuf]) -> Option<PathBuf> {
    let mut folder = files.first()?.parent()?.to_owned();
    while !files.iter().all(|file| file.starts_with(&folder)) {
        folder = folder.parent()?.to_owned();
    }
    folder.parent().is_some().then_some(folder)
}

/// A take's name as the name of a file on any system, and in USD.
pub(super) fn file_name(take: &str) -> String {
    let is_special = |c: char| c.is_control() || r#"<>:"/\|?*@"#.contains(c);
    take.chars().map(|c| if is_special(c) { '_' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative_with_slashes() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path().canonicalize().unwrap();
        fs::create_dir_all(at.join("a/ü b")).unwrap();
        fs::create_dir_all(at.join("job")).unwrap();
        fs::write(at.join("a/ü b/take 1.csv"), "").unwrap();
        assert_eq!(relative(&at.join("a/ü b/take 1.csv"), &at.join("job")).unwrap(), "../a/ü b/take 1.csv");
        assert_eq!(relative(&at.join("job/../a/ü b/take 1.csv"), &at.join("a")).unwrap(), "ü b/take 1.csv");
        assert_eq!(relative(&at.join("job"), &at.join("job")).unwrap(), ".");
        assert!(relative(&at.join("gone"), &at).is_err());
    }

    #[test]
    fn the_folder_of_all_files_is_the_innermost() {
        let folder = |files: &[&str]| folder_of_all(&files.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(folder(&["/s/t/a.csv"]), Some("/s/t".into()));
        assert_eq!(folder(&["/s/t/a.csv", "/s/t/u/b.csv"]), Some("/s/t".into()));
        assert_eq!(folder(&["/s/t/a.csv", "/s/tu/b.csv"]), Some("/s".into()));
        assert_eq!(folder(&["/s/a.csv", "/t/b.csv"]), None);
    }

    #[test]
    fn names_are_names_of_files_everywhere() {
        assert_eq!(file_name("Ännchen 1"), "Ännchen 1");
        assert_eq!(file_name("a@b<c>:\"/\\|?*d"), "a_b_c________d");
    }
}
