//! The place of the points in a C3D file, and their number.
//!
//! Header and parameters both state them, and in real files either may be wrong. So each statement is a
//! claim. The first combination of claims that fits the size of the file is taken.
use super::Sections;
use super::header::{BLOCK, Header};
use super::parameters::Parameters;
use rhytid_core::{Error, Result};
use std::fmt;

/// The place and shape of the points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    /// The byte at which the first frame begins.
    pub(super) start: usize,
    /// M, the points of a frame.
    pub(super) points: usize,
    /// Analog measurements behind the points of a frame.
    analog: usize,
    pub(super) storage: Storage,
    /// The whole frames that are there.
    pub(super) frames: usize,
    /// The frames that should be there.
    pub(super) promised: u64,
}

/// The storage of a coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Storage {
    /// 16 bits each, times `scale`.
    Integer { scale: f64 },
    /// 32 bits each.
    Float,
}

impl Storage {
    /// The bytes of a point: three coordinates, and a word for its residual and the cameras that saw it.
    pub(super) fn point_bytes(self) -> usize {
        4 * self.number_bytes()
    }

    fn number_bytes(self) -> usize {
        match self {
            Self::Integer { .. } => 2,
            Self::Float => 4,
        }
    }
}

impl fmt::Display for Storage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer { scale } => write!(f, "whole numbers times {scale}"),
            Self::Float => f.write_str("floats"),
        }
    }
}

impl Layout {
    pub(super) fn frame_bytes(&self) -> usize {
        self.points * self.storage.point_bytes() + self.analog * self.storage.number_bytes()
    }

    /// Whether the file has nothing but zeros behind the promised frames, which are there.
    fn is_padded(&self, file: &[u8]) -> bool {
        let frames = usize::try_from(self.promised).unwrap_or(usize::MAX);
        let behind = file.get(self.start.saturating_add(frames.saturating_mul(self.frame_bytes()))..);
        behind.is_some_and(|bytes| bytes.iter().all(|byte| *byte == 0))
    }

    /// How well the file's `bytes` fit the claim.
    fn fit(&self, bytes: usize) -> Fit {
        let available = (bytes - self.start) as u64;
        match available.checked_sub(self.promised.saturating_mul(self.frame_bytes() as u64)) {
            // The last block is usually padded.
            Some(rest) if rest < BLOCK as u64 => Fit::Exact,
            Some(_) => Fit::Inside,
            None => Fit::Beyond,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Fit {
    Exact,
    Inside,
    Beyond,
}

/// The values that a file gives for one thing, each with the place that gives it; the more trusted first.
struct Claims<T>(Vec<(T, &'static str)>);

impl<T: Copy + PartialEq + fmt::Display> Claims<T> {
    /// Those that are given, each value once.
    fn new<const N: usize>(given: [(Option<T>, &'static str); N]) -> Self {
        let mut claims: Vec<(T, &'static str)> = Vec::with_capacity(N);
        for (value, place) in given {
            if let Some(value) = value.filter(|value| claims.iter().all(|(other, _)| other != value)) {
                claims.push((value, place));
            }
        }
        Self(claims)
    }

    fn values(&self) -> impl Iterator<Item = T> {
        self.0.iter().map(|(value, _)| *value)
    }

    /// Warns where there is more than one value.
    fn settle(&self, what: &str, chosen: T, warnings: &mut Vec<String>) {
        if self.0.len() > 1 {
            let said: Vec<String> =
                self.0.iter().map(|(value, place)| format!("{value} by {place}")).collect();
            warnings.push(format!("{what} is {}; {chosen} is used", said.join(" and ")));
        }
    }
}

/// The most that a 16-bit word counts. Files with more frames leave nonsense in such words.
const WORD: u64 = u16::MAX as u64;

/// Finds the layout of a file; `rate` is its frames per second, if any is known.
///
/// # Errors
/// What is wrong, without the file's name.
pub(super) fn find(
    file: &[u8],
    sections: &Sections<'_>,
    rate: Option<f64>,
    warnings: &mut Vec<String>,
) -> Result<Layout> {
    let bytes = file.len();
    let Sections { header, parameters, .. } = sections;
    let starts = starts(bytes, sections);
    let points = Claims::new([
        (parameters.number("POINT", "USED").and_then(whole), "POINT:USED"),
        (Some(usize::from(header.points)), "the header"),
    ]);
    let scale = |scale: Option<f64>| scale.filter(|scale| scale.is_finite() && *scale != 0.0).map(storage);
    let storages = Claims::new([
        (scale(parameters.number("POINT", "SCALE")), "POINT:SCALE"),
        (scale(Some(header.scale)), "the header"),
    ]);
    if storages.0.is_empty() {
        return Err(Error::malformed(
            "neither POINT:SCALE nor the header gives the scale of the coordinates, so the points cannot be \
             read; export the file anew",
        ));
    }
    let analogs = analogs(header, parameters, rate);
    let claimed_frames = frames(header, parameters);
    let most = claimed_frames.values().max().unwrap_or(0);

    let mut shapes = Vec::new();
    for points in points.values() {
        for storage in storages.values() {
            for analog in analogs.values() {
                for promised in claimed_frames.values() {
                    shapes.push(Layout { start: 0, points, analog, storage, frames: 0, promised });
                }
            }
        }
    }
    let mut best: Option<(Fit, Layout)> = None;
    for start in starts.values() {
        for layout in shapes.iter().map(|shape| Layout { start, ..*shape }) {
            let fit = layout.fit(bytes);
            let outgrown = layout.promised <= WORD && most > WORD && fit != Fit::Exact;
            if !outgrown && best.as_ref().is_none_or(|(best, _)| fit < *best) {
                best = Some((fit, layout));
            }
        }
    }
    if shapes.is_empty() {
        return Err(Error::malformed("neither the header nor a parameter says how many frames there are"));
    }
    let by_size = match best {
        Some((Fit::Exact, _)) => None,
        Some((Fit::Inside, stated)) if stated.is_padded(file) => None,
        _ => by_size(file, sections, best.map(|(_, stated)| stated.start), &shapes),
    };
    let mut layout = match (by_size, best) {
        (Some(found), _) => {
            let said = starts.0.first().map(|(start, place)| format!(" (byte {start} by {place})"));
            warnings.push(format!(
                "no statement of where the points begin fits the size of the file{}; byte {}, which fits, is used",
                said.unwrap_or_default(),
                found.start
            ));
            found
        }
        (None, Some((_, stated))) => {
            starts.settle("the byte at which the points begin", stated.start, warnings);
            stated
        }
        (None, None) => {
            return Err(Error::cut_short(format!(
                "is cut short: it has {bytes} bytes, and its points begin beyond its end; copy or export the file anew"
            )));
        }
    };
    points.settle("the number of points", layout.points, warnings);
    storages.settle("the storage of the coordinates", layout.storage, warnings);
    if analogs.values().next() != Some(layout.analog) {
        analogs.settle("the number of analog measurements in a frame", layout.analog, warnings);
    }
    if layout.points == 0 {
        return Err(Error::empty(
            "has no markers: its number of points is 0; export the labelled trajectories too",
        ));
    }
    let mut there = (bytes - layout.start) / layout.frame_bytes();
    if layout.promised == WORD && there as u64 > WORD {
        // The padding of the last block is no frame.
        let frames = file[layout.start..].chunks_exact(layout.frame_bytes());
        there -= frames.rev().take_while(|frame| frame.iter().all(|byte| *byte == 0)).count();
        warnings.push(format!(
            "the number of frames is given as {WORD}, the largest possible number; {there}, which the size \
             of the file says, is used"
        ));
        layout.promised = there as u64;
    } else if layout.promised <= WORD {
        claimed_frames.settle("the number of frames", layout.promised, warnings);
    }
    layout.frames = usize::try_from(layout.promised).unwrap_or(usize::MAX).min(there);
    Ok(layout)
}

/// The numbers of the first frame that are given; frames count from 1.
pub(super) fn first_frame(header: &Header, parameters: &Parameters<'_>, warnings: &mut Vec<String>) -> u32 {
    let first = parameters.count("TRIAL", "ACTUAL_START_FIELD");
    let header = u32::from(header.first);
    match first {
        Some(first) if first != header && first <= u32::from(u16::MAX) => {
            warnings.push(format!(
                "the first frame is {first} by TRIAL:ACTUAL_START_FIELD and {header} by the header; {first} \
                 is used"
            ));
            first
        }
        Some(first) => first,
        None => header,
    }
}

/// The layout that begins where the size of the file says, though no statement does. Between the parameters
/// and that place, or between the byte that is `stated` and that place, there may be nothing but zeros.
///
/// So the spare blocks of the parameters are not taken for points if the file was cut, and bytes that follow
/// the last frame do not move the first one.
fn by_size(file: &[u8], sections: &Sections<'_>, stated: Option<usize>, shapes: &[Layout]) -> Option<Layout> {
    let is_zero = |bytes: &[u8]| bytes.iter().all(|&byte| byte == 0);
    for shape in shapes {
        let bytes = usize::try_from(shape.promised).ok()?.checked_mul(shape.frame_bytes())?;
        let Some(before) = file.len().checked_sub(bytes).filter(|_| bytes > 0) else { continue };
        let start = before / BLOCK * BLOCK;
        // The last entry's description may follow it in its block.
        let entries_end = sections.entries_end.next_multiple_of(BLOCK);
        let free_from = stated.filter(|&stated| stated < start).unwrap_or(entries_end);
        let is_free = file.get(free_from..start).is_some_and(is_zero);
        let begins = file.get(start..).is_some_and(|data| !is_zero(&data[..data.len().min(BLOCK)]));
        if Some(start) != stated && is_free && begins {
            return Some(Layout { start, ..*shape });
        }
    }
    None
}

/// The bytes at which the points may begin: inside the file, and not before the parameters' last entry ends.
///
/// Places before the end that the parameter section claims come last.
fn starts(bytes: usize, sections: &Sections<'_>) -> Claims<usize> {
    let Sections { header, parameters, entries_end, claimed_end: section_end } = sections;
    let section_end = *section_end;
    let byte = |block: f64| {
        let byte = (block as usize).saturating_sub(1).saturating_mul(BLOCK);
        (byte >= *entries_end && byte >= 2 * BLOCK).then_some(byte)
    };
    let mut claims = Claims::new([
        (byte(f64::from(header.data_block)), "the header"),
        (parameters.number("POINT", "DATA_START").and_then(byte), "POINT:DATA_START"),
    ]);
    if claims.values().all(|start| start < section_end) {
        claims.0.insert(0, (section_end, "the end of the parameters"));
    }
    claims.0.sort_by_key(|(start, _)| *start < section_end);
    claims.0.retain(|(start, _)| *start <= bytes);
    claims
}

/// A number that a word could hold.
fn whole(number: f64) -> Option<usize> {
    (number.fract() == 0.0 && (0.0..=WORD as f64).contains(&number)).then_some(number as usize)
}

fn storage(scale: f64) -> Storage {
    if scale < 0.0 { Storage::Float } else { Storage::Integer { scale } }
}

/// The analog measurements in a frame: as the header has them, or the channels times their measurements in a
/// frame.
fn analogs(header: &Header, parameters: &Parameters<'_>, rate: Option<f64>) -> Claims<usize> {
    let used = parameters.number("ANALOG", "USED").and_then(whole);
    let by_rate = parameters
        .number("ANALOG", "RATE")
        .zip(rate)
        .map(|(analog, rate)| (analog / rate).round())
        .and_then(whole)
        .filter(|&samples| samples > 0);
    let channels = |samples: usize| used.map(|used| used * samples);
    Claims::new([
        (Some(usize::from(header.analog)), "the header"),
        (channels(usize::from(header.analog_samples)), "ANALOG:USED and the header"),
        (by_rate.and_then(channels), "ANALOG:USED and ANALOG:RATE"),
    ])
}

fn frames(header: &Header, parameters: &Parameters<'_>) -> Claims<u64> {
    let trial = parameters
        .count("TRIAL", "ACTUAL_START_FIELD")
        .zip(parameters.count("TRIAL", "ACTUAL_END_FIELD"))
        .and_then(|(first, last)| (u64::from(last) + 1).checked_sub(u64::from(first)));
    Claims::new([
        (trial, "TRIAL:ACTUAL_START_FIELD and ACTUAL_END_FIELD"),
        (parameters.count("POINT", "LONG_FRAMES").map(u64::from), "POINT:LONG_FRAMES"),
        (parameters.count("POINT", "FRAMES").map(u64::from), "POINT:FRAMES"),
        (header.frames().map(u64::from), "the header"),
    ])
}
