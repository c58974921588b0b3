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
    /// Whether the markers are landmarks that a program found in a video, with z pointing to the camera. Such
    /// frames have no common scale, and their depth is less sure than their place in the image.
    pub is_video: bool,
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

impl Timecode {
    /// Seconds from the time code 00:00:00:00 on. They are frames of the time code by its rate, or by
    /// `take_rate`, in frames per second, where the time code has none.
    pub fn seconds(&self, take_rate: f64) -> f64 {
        let rate = self.rate.unwrap_or(take_rate);
        // 29.97 frames per second count to 30. A measured rate may be a little above its whole number.
        let nominal = rate.round().max(1.0);
        let minutes = 60.0 * f64::from(self.hours) + f64::from(self.minutes);
        // Of every minute but each tenth, the first two numbers are left out, or four at 59.94.
        let dropped = match self.drop_frame {
            true => (nominal / 15.0).round() * (minutes - (minutes / 10.0).floor()),
            false => 0.0,
        };
        let frames = nominal * (60.0 * minutes + f64::from(self.seconds)) + f64::from(self.frames) - dropped;
        frames / rate + f64::from(self.subframes) / take_rate
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// By the rules of SMPTE 12M, worked out by hand.
    #[test]
    fn seconds_of_time_codes() {
        let at = |hours, minutes, seconds, frames, rate, drop_frame| {
            Timecode { hours, minutes, seconds, frames, subframes: 0, rate, drop_frame }.seconds(120.0)
        };
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        let ntsc = Some(30000.0 / 1001.0);
        near(at(1, 2, 3, 12, Some(24.0), false), 3723.5);
        // 10 minutes are 17,982 frames if numbers are dropped, and 18,000 if not.
        near(at(0, 10, 0, 0, ntsc, true), 17_982.0 * 1.001 / 30.0);
        near(at(0, 10, 0, 0, ntsc, false), 18_000.0 * 1.001 / 30.0);
        // The number after 00:00:59;29 is 00:01:00;02.
        near(at(0, 1, 0, 2, ntsc, true), 1800.0 * 1.001 / 30.0);
        near(at(0, 1, 0, 4, Some(60000.0 / 1001.0), true), 3600.0 * 1.001 / 60.0);
        // Without a rate, frames are those of the take.
        near(at(0, 0, 1, 60, None, false), 1.5);
        // A hair above 25 frames per second does not count to 26.
        near(at(1, 0, 0, 0, Some(25.0 + 1e-12), false), 3600.0);
        // No hour is too late to be counted.
        near(at(u32::MAX, 0, 0, 0, Some(1.0), false), 3600.0 * f64::from(u32::MAX));
        let subframes = Timecode {
            hours: 0,
            minutes: 0,
            seconds: 0,
            frames: 1,
            subframes: 2,
            rate: Some(30.0),
            drop_frame: false,
        };
        assert_eq!(subframes.seconds(120.0), 1.0 / 30.0 + 2.0 / 120.0);
    }
}
