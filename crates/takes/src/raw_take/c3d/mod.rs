//! C3D, the binary format that every optical capture system writes. A file has a header block, a section of
//! named parameters, and frames. A frame has points and then analog measurements. Blocks have 512 bytes and
//! count from 1.
//!
//! The library c3dio (0.8) reads all six encodings, and the tests compare with it. This module does not use
//! it, because real files break the rules and c3dio handles such files badly:
//!
//! - It refuses files without POINT:UNITS or with two frame rates.
//! - It ignores LABELS2 and LABELS3 while it keeps their points.
//! - It trusts the header's number of frames, and returns no frames if the number is wrong.
//! - It says nothing about a file that was cut.
mod header;
mod layout;
mod outputs;
mod parameters;
mod points;
mod processor;
mod recording;

use super::{clock, labels, units};
use header::{BLOCK, Header};
use parameters::Parameters;
use processor::Processor;
use rhytid_core::{Error, RawTake, Result, Take};

/// The most blocks before the points: their place is a word.
const MOST_BLOCKS: usize = u16::MAX as usize;

/// A list of labels goes on in parameters with a number behind the name. 65535 points need 257 of them.
const MOST_PARTS: usize = 300;

/// The second byte of every C3D file.
pub(super) const MARK: u8 = 0x50;

/// Reads the points of a file of either storage and from any of the three processors.
///
/// A residual below 0, or coordinates that are not numbers, mean that a point is missing. So does a fourth
/// number that is below 0 as a 16-bit integer, such as 65535.0. A residual of 0 without a camera means that
/// the point was filled. But if no point of the file has a residual or a camera, the writer knew no
/// residuals, and no point counts as filled.
///
/// # Errors
/// [`Error::Input`].
pub(super) fn decode(bytes: &[u8], name: &str, rate: Option<f64>) -> Result<RawTake> {
    decode_points(bytes, rate).map_err(|error| error.in_file(name))
}

/// As [`decode`]; errors lack the file's name.
fn decode_points(bytes: &[u8], rate: Option<f64>) -> Result<RawTake> {
    let mut warnings = Vec::new();
    let sections = sections(bytes, &mut warnings)?;
    let Sections { header, parameters, .. } = &sections;
    let said_rate = said_rate(header, parameters);
    let layout = layout::find(bytes, &sections, said_rate.first().map(|r| r.0), &mut warnings)?;
    let rate = match rate {
        Some(rate) => rate,
        None => settle_rate(&said_rate, parameters, &mut warnings)?,
    };
    if layout.promised == 0 {
        return Err(Error::empty("has no frames; export the file anew"));
    }
    if layout.frames == 0 {
        return Err(Error::cut_short(format!(
            "is cut short: it ends before the first of its {} frames is complete; copy or export the file anew",
            layout.promised
        )));
    }
    if (layout.frames as u64) < layout.promised {
        warnings.push(format!(
            "the file is cut short: {} of its {} frames are there and are read",
            layout.frames, layout.promised
        ));
    }
    let first = layout::first_frame(header, parameters, &mut warnings);
    let before = f64::from(first.saturating_sub(1));
    let names = labels(parameters, layout.points);
    let is_marker = outputs::markers(parameters, &names, &mut warnings)?;
    let mut labels = labels::distinct(names, &mut warnings);
    let mut points = points::read(bytes, &layout, parameters.processor, &mut warnings);
    if is_marker.contains(&false) {
        keep_columns(&mut labels, &is_marker);
        keep_columns(&mut points.positions, &is_marker);
        if let Some(confidence) = &mut points.confidence {
            keep_columns(confidence, &is_marker);
        }
    }
    let unit =
        parameters.texts("POINT", "UNITS").and_then(|units| units.first().map(|unit| labels::text(unit)));
    let unit = unit.unwrap_or_default();
    let metres_per_unit = units::metres(&unit);
    if metres_per_unit.is_none() {
        warnings.push(units::unknown(&unit, "POINT:UNITS"));
    }
    let tracks = Take {
        labels,
        times: (0..layout.frames).map(|frame| (before + frame as f64) / rate).collect(),
        positions: points.positions,
        head: None,
        confidence: points.confidence,
    };
    let recording = recording::read(header, parameters, first);
    Ok(RawTake { tracks, metres_per_unit, recording, warnings, ..RawTake::default() })
}

/// The parts of a file before the points.
struct Sections<'a> {
    header: Header,
    parameters: Parameters<'a>,
    /// The byte at which the last entry of the parameters ends.
    entries_end: usize,
    /// The byte at which the parameters end by the number of their blocks.
    claimed_end: usize,
}

fn sections<'a>(bytes: &'a [u8], warnings: &mut Vec<String>) -> Result<Sections<'a>> {
    let header = match bytes.first_chunk::<BLOCK>() {
        Some(header) if header[1] == MARK => header,
        Some(header) => {
            return Err(Error::unsupported_format(format!(
                "is no C3D file: its second byte is {:#04x}, expected {MARK:#04x}",
                header[1]
            )));
        }
        None => {
            return Err(Error::cut_short(format!(
                "is cut short: it has {} bytes, and the header of a C3D file {BLOCK}; copy or export the file anew",
                bytes.len()
            )));
        }
    };
    let start = usize::from(header[0]).saturating_sub(1) * BLOCK;
    if start == 0 {
        return Err(Error::malformed(format!(
            "its parameters begin in block {}, expected 2 or more",
            header[0]
        )));
    }
    let cut = || {
        Error::cut_short(format!(
            "is cut short: it has {} bytes and ends in its parameters; copy or export the file anew",
            bytes.len()
        ))
    };
    let preface: &[u8; 4] = bytes.get(start..).and_then(|section| section.first_chunk()).ok_or_else(cut)?;
    let processor = Processor::from_code(preface[3]).unwrap_or_else(|| {
        warnings.push(format!("the processor's code is {}, expected 84, 85 or 86; 84 is used", preface[3]));
        Processor::Intel
    });
    let header = Header::read(header, processor);
    let claimed_end = start + usize::from(preface[2]).max(1) * BLOCK;
    // The length of a section of more than 255 blocks cannot be stated. Then the place of the points bounds
    // it.
    let bound = claimed_end.max(usize::from(header.data_block).saturating_sub(1) * BLOCK).min(bytes.len());
    let mut parameters = Parameters::read(&bytes[start + 4..bound], processor);
    if parameters.is_damaged && bound < bytes.len() {
        // Both bounds may be wrong. The entries say themselves where the last one is.
        let most = (start + MOST_BLOCKS * BLOCK).min(bytes.len());
        let unbounded = Parameters::read(&bytes[start + 4..most], processor);
        if !unbounded.is_damaged {
            parameters = unbounded;
        }
    }
    if parameters.is_damaged {
        if claimed_end > bytes.len() {
            return Err(cut());
        }
        warnings.push("the parameters are damaged; those before the damage are read".into());
    }
    let entries_end = start + 4 + if parameters.is_damaged { 0 } else { parameters.end };
    Ok(Sections { header, parameters, entries_end, claimed_end })
}

/// The frames per second that the file states, if they make sense, the more trusted first.
fn said_rate(header: &Header, parameters: &Parameters<'_>) -> Vec<(f64, &'static str)> {
    [
        (parameters.number("POINT", "RATE"), "POINT:RATE"),
        (Some(header.rate), "the header"),
        (parameters.number("TRIAL", "CAMERA_RATE"), "TRIAL:CAMERA_RATE"),
    ]
    .into_iter()
    .filter_map(|(rate, place)| Some((rate.filter(|&rate| clock::is_rate(rate))?, place)))
    .collect()
}

fn settle_rate(
    said: &[(f64, &'static str)],
    parameters: &Parameters<'_>,
    warnings: &mut Vec<String>,
) -> Result<f64> {
    let &(rate, place) = said.first().ok_or_else(clock::no_rate)?;
    let others: Vec<String> = said[1..]
        .iter()
        .filter(|(other, _)| (other / rate - 1.0).abs() > 1e-3)
        .map(|(other, place)| format!("{other} by {place}"))
        .collect();
    let absent = parameters.number("POINT", "RATE").filter(|_| place != "POINT:RATE");
    if let Some(absent) = absent {
        warnings
            .push(format!("POINT:RATE is {absent}, which is no frame rate; the {rate} of {place} is used"));
    }
    if !others.is_empty() {
        warnings.push(format!(
            "the frame rate is {rate} by {place} and {}; {rate} is used",
            others.join(" and ")
        ));
    }
    Ok(rate)
}

/// The labels of the points: LABELS, and LABELS2, LABELS3 … for those beyond 255.
fn labels(parameters: &Parameters<'_>, points: usize) -> Vec<String> {
    let mut labels = Vec::new();
    for part in 1..=MOST_PARTS {
        let name = if part == 1 { "LABELS".to_owned() } else { format!("LABELS{part}") };
        let Some(texts) = parameters.texts("POINT", &name) else { break };
        labels.extend(texts.into_iter().map(labels::text));
        if labels.len() >= points {
            break;
        }
    }
    labels.resize(points, String::new());
    labels
}

/// Keeps some columns of a table.
fn keep_columns<T>(cells: &mut Vec<T>, is_kept: &[bool]) {
    let mut kept = is_kept.iter().copied().cycle();
    cells.retain(|_| kept.next().unwrap_or(true));
}
