//! Raw takes: the files of capture systems, read as they are, with all gaps. Cleaning them up is another
//! step.
mod c3d;
mod clock;
mod frames;
mod labels;
mod missing;
mod motive;
mod qualisys;
mod samples;
mod timecode;
mod trc;
mod units;
mod vicon;

use crate::take::{self, Missing};
use crate::text::utf_8;
use rhytid_core::{Error, RawTake, Result, input_file};
use std::io::Read;
use std::path::Path;

/// The formats that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    C3d,
    Trc,
    Motive,
    Qualisys,
    Vicon,
    TakeCsv,
}

/// Reads a file of C3D, TRC, Motive's CSV, Qualisys' TSV, Vicon's CSV or the take's own CSV. The first bytes
/// tell the format, and otherwise the extension does. `rate`, in frames per second, replaces the rate of the
/// file. (A take's CSV has times instead of a rate.)
///
/// # Errors
/// [`Error::Input`]: a file that is damaged or cut short before its first frame, has no frames or no markers,
/// or does not state its rate. Also a `rate` that is not valid. [`Error::Io`].
pub fn read(path: &Path, rate: Option<f64>) -> Result<RawTake> {
    let bytes = input_file::read(path, input_file::LARGEST_MESH_OR_TAKE)?;
    decode(&bytes, &path.display().to_string(), rate)
}

/// As [`read`], from the bytes of the file `name`.
///
/// # Errors
/// [`Error::Input`].
pub fn decode(bytes: &[u8], name: &str, rate: Option<f64>) -> Result<RawTake> {
    if let Some(rate) = rate.filter(|&rate| !clock::is_rate(rate)) {
        return Err(Error::out_of_range(format!(
            "{name}: the given frame rate is {rate}, expected a number from 0.001 to 1000000"
        )));
    }
    let mut take = match Kind::detect(bytes, Path::new(name)) {
        Kind::C3d => c3d::decode(bytes, name, rate)?,
        Kind::Trc => trc::decode(bytes, name, rate)?,
        Kind::Motive => motive::decode(bytes, name, rate)?,
        Kind::Qualisys => qualisys::decode(bytes, name, rate)?,
        Kind::Vicon => vicon::decode(bytes, name, rate)?,
        Kind::TakeCsv => {
            let tracks = take::decode(&utf_8(bytes), name, None, Missing::Leave)?;
            return Ok(RawTake { tracks, in_head_space: true, ..RawTake::default() });
        }
    };
    missing::mark(&mut take);
    Ok(take)
}

/// Whether a file is the take's own CSV, which [`crate::take`] reads, and not a raw take. Only the first
/// bytes of a regular file are read. A file that is not regular cannot be read twice, so nothing of it is
/// read. A file that cannot be opened is judged by its name.
pub fn is_take_csv(path: &Path) -> bool {
    let mut start = Vec::new();
    if std::fs::metadata(path).is_ok_and(|found| found.is_file())
        && let Ok(file) = std::fs::File::open(path)
    {
        // An error is ignored here: the reader of the whole file finds and reports it again.
        let _ = file.take(64).read_to_end(&mut start);
    }
    Kind::detect(&start, path) == Kind::TakeCsv
}

impl Kind {
    fn detect(start: &[u8], path: &Path) -> Self {
        // The byte before C3D's mark is the block of its parameters, a small number that is no letter.
        if start.len() > 1 && (1..b' ').contains(&start[0]) && start[1] == c3d::MARK {
            return Self::C3d;
        }
        let text = utf_8(start);
        let text = text.trim_ascii_start();
        let text = text.strip_prefix(b"\"").unwrap_or(text);
        let begins =
            |words: &str| text.get(..words.len()).is_some_and(|s| s.eq_ignore_ascii_case(words.as_bytes()));
        let ending =
            path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase();
        match ending.as_str() {
            _ if begins("PathFileType") || begins("DataRate") => Self::Trc,
            _ if begins("Format Version") => Self::Motive,
            _ if begins("NO_OF_FRAMES") => Self::Qualisys,
            _ if vicon::SECTIONS.iter().any(|section| begins(section) && is_line(text, section)) => {
                Self::Vicon
            }
            "c3d" => Self::C3d,
            "trc" => Self::Trc,
            "tsv" => Self::Qualisys,
            _ => Self::TakeCsv,
        }
    }
}

/// Whether the first line of a text is `words` and separators alone.
fn is_line(text: &[u8], words: &str) -> bool {
    let line = text[words.len()..].split(|byte| matches!(byte, b'\n' | b'\r')).next().unwrap_or_default();
    line.iter().all(|byte| b" ,;\t\"".contains(byte))
}
