//! The raw take: marker tracks before the clean-up.
use crate::Take;

/// Marker tracks as a file gives them. The clean-up makes a [`Take`] for a rig from them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RawTake {
    /// All markers of the file under distinct labels, in the file's unit and axes. A marker that was not seen
    /// has NaN for all three coordinates. The confidence is below 1 where the capture system says that it
    /// filled a gap.
    pub tracks: Take,
    /// Metres in one unit of the positions; `None` where the file does not say.
    pub metres_per_unit: Option<f64>,
    /// Whether the format promises positions in mesh units and head space, as the take's CSV does.
    pub in_head_space: bool,
    /// The take's place in the recording session.
    pub recording: Recording,
    /// What the reader had to assume or to repair, one sentence each.
    pub warnings: Vec<String>,
}

/// What a file says of the take's place in the recording session. The take's times count in the same session,
/// if the file numbers its frames so.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recording {
    /// The time code of the first frame.
    pub timecode: Option<Timecode>,
    /// The date and time of day at which the recording began, in the words of the file.
    pub started: Option<String>,
    /// The number of the take's first frame in the recording that the take was cut from.
    pub first_frame: Option<i64>,
    /// The events, in the order of the file.
    pub events: Vec<TakeEvent>,
}

/// A time code of SMPTE: the hours, minutes, seconds and frames of the studio's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timecode {
    /// Hours, from 0.
    pub hours: u32,
    /// Minutes, from 0 to 59.
    pub minutes: u32,
    /// Seconds, from 0 to 59.
    pub seconds: u32,
    /// Frames of the time code, from 0.
    pub frames: u32,
    /// Frames of the take since the time code's frame began, from 0.
    pub subframes: u32,
    /// Frames of the time code in a second; `None` where the file does not say.
    pub rate: Option<f64>,
    /// Whether the time code skips numbers to stay with the clock, as 29.97 frames per second need.
    pub drop_frame: bool,
}

impl std::fmt::Display for Timecode {
    /// `01:02:03:04`, or `01:02:03;04` if the time code skips numbers, and `.2` behind it for subframes.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { hours, minutes, seconds, frames, .. } = self;
        let mark = if self.drop_frame { ';' } else { ':' };
        write!(f, "{hours:02}:{minutes:02}:{seconds:02}{mark}{frames:02}")?;
        if self.subframes > 0 {
            write!(f, ".{}", self.subframes)?;
        }
        Ok(())
    }
}

/// A named moment of a take.
#[derive(Debug, Clone, PartialEq)]
pub struct TakeEvent {
    /// The name, with the context before it where the file has one.
    pub name: String,
    /// Seconds in the time of the file, as [`Take::times`] count.
    pub time: f64,
}

impl RawTake {
    /// The position of a marker that was not seen.
    pub const MISSING: [f64; 3] = [f64::NAN; 3];

    /// The confidence of a position that the capture system filled in: it is plausible, but was not seen.
    pub const FILLED: f32 = 0.5;
}
