//! Raw takes: the files of capture systems, read as they are, with all gaps. Cleaning them up is another
//! step.
mod c3d;
pub(crate) mod clock;
mod frames;
mod labels;
mod missing;
mod motive;
mod qualisys;
mod samples;
mod table;
mod timecode;
mod trc;
mod units;
mod vicon;

use crate::header::Table;
use crate::take::{self, Missing};
use crate::text::utf_8;
use rhytid_core::{Error, RawTake, Result, input_file};
use std::path::Path;

pub(crate) use table::is_face_mesh;
pub(crate) use units::metres;

/// The formats that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    C3d,
    Trc,
    Motive,
    Qualisys,
    Vicon,
    /// A CSV file; its header says what is in it.
    Csv,
}

/// Reads a file of C3D, TRC, Motive's CSV, Qualisys' TSV, Vicon's CSV, the take's own CSV or another table of
/// markers. The first bytes tell the format, and otherwise the extension does. `rate`, in frames per second,
/// replaces the rate of the file. (A take's CSV has times instead of a rate.)
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
        Kind::Csv => {
            let text = utf_8(bytes);
            match Table::detect(&text) {
                Table::Take => {
                    let tracks = take::decode(&text, name, None, Missing::Leave)?;
                    return Ok(RawTake { tracks, in_head_space: true, ..RawTake::default() });
                }
                Table::Wide => table::wide(&text, name, rate)?,
                Table::Long => table::long(&text, name, rate)?,
                Table::OpenFace => table::openface(&text, name, rate)?,
                Table::Curves => {
                    return Err(Error::unsupported_format(format!(
                        "{name}: holds curves, which are weights of shapes and no places of markers; a rig plays \
                         them with shapes of the same names"
                    )));
                }
            }
        }
    };
    missing::mark(&mut take);
    follow_timecode(&mut take);
    Ok(take)
}

/// Replaces what stands for “not seen”, such as 0, 0, 0 or 9999999, by [`RawTake::MISSING`], and warns of it
/// in the take.
///
/// [`read`] has done so, except for the take's own CSV. In head space such a number may be a place. In world
/// space it is what it is in the file of any other program.
pub fn mark_missing(take: &mut RawTake) {
    missing::mark(take);
}

/// Moves the take's clock so that the first frame is at the file's time code, if the file has one.
fn follow_timecode(take: &mut RawTake) {
    let RawTake { tracks, recording, .. } = take;
    let Some((timecode, &first)) = recording.timecode.zip(tracks.times.first()) else { return };
    let later = timecode.seconds(tracks.rate()) - first;
    tracks.times.iter_mut().for_each(|time| *time += later);
    recording.events.iter_mut().for_each(|event| event.time += later);
}

/// What a file of a take holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contents {
    /// The take's own CSV, which [`crate::take`] reads.
    Take,
    /// A raw take, which [`read`] reads.
    Raw,
    /// Weights of shapes, which [`crate::curves`] reads.
    Curves,
}

/// A header is not longer than this: MediaPipe's 478 landmarks with their three axes take a fifth of it.
const LONGEST_HEADER: u64 = 65_536;

/// What a file holds, by its first bytes or else by its name. Nothing else of the file is read. A file that
/// is not regular cannot be read twice, so nothing of it is read. A file that cannot be opened is judged by
/// its name.
pub fn contents(path: &Path) -> Contents {
    // An error is ignored here: the reader of the whole file finds and reports it again.
    let start = input_file::start(path, LONGEST_HEADER).unwrap_or_default();
    match Kind::detect(&start, path) {
        Kind::Csv => match Table::detect(&utf_8(&start)) {
            Table::Take => Contents::Take,
            Table::Curves => Contents::Curves,
            Table::Wide | Table::Long | Table::OpenFace => Contents::Raw,
        },
        _ => Contents::Raw,
    }
}

/// Whether a file is the take's own CSV, as [`contents`] finds it.
pub fn is_take_csv(path: &Path) -> bool {
    contents(path) == Contents::Take
}

impl Kind {
    fn detect(start: &[u8], path: &Path) -> Self {
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
            // The byte before C3D's mark is the block of its parameters, a small number that is no letter.
            _ if start.len() > 1 && (1..b' ').contains(&start[0]) && start[1] == c3d::MARK => Self::C3d,
            "c3d" => Self::C3d,
            "trc" => Self::Trc,
            "tsv" if Table::detect(text) == Table::Take => Self::Qualisys,
            _ => Self::Csv,
        }
    }
}

/// Whether the first line of a text is `words` and separators alone.
fn is_line(text: &[u8], words: &str) -> bool {
    let line = text[words.len()..].split(|byte| matches!(byte, b'\n' | b'\r')).next().unwrap_or_default();
    line.iter().all(|byte| b" ,;\t\"".contains(byte))
}
