//! Time codes: hours, minutes, seconds and frames, as `16:21:26:06.411`.

/// Rates that time codes count in, in frames per second.
pub(crate) const RATES: [u32; 8] = [24, 25, 30, 48, 50, 60, 120, 240];

/// A day in seconds.
const DAY: f64 = 86_400.0;

/// A time code: whole seconds of the day, and frames with the part of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Timecode {
    seconds: f64,
    frames: f64,
}

impl Timecode {
    /// Reads `HH:MM:SS:FF`, `HH:MM:SS:FF.part`, `HH:MM:SS.part` or a number of seconds. A semicolon may stand
    /// before the frames. `None` for anything else.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let number =
            |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite() && *x >= 0.0 && *x < 1e9);
        let parts: Vec<&str> = text.split([':', ';']).collect();
        match parts[..] {
            [seconds] => Some(Self { seconds: number(seconds)?, frames: 0.0 }),
            [h, m, s] => Some(Self { seconds: clock(number(h)?, number(m)?, number(s)?), frames: 0.0 }),
            [h, m, s, f] => {
                Some(Self { seconds: clock(number(h)?, number(m)?, number(s)?), frames: number(f)? })
            }
            _ => None,
        }
    }
}

fn clock(hours: f64, minutes: f64, seconds: f64) -> f64 {
    hours * 3600.0 + minutes * 60.0 + seconds
}

/// The times of time codes in seconds from the first, and the rate that their frames count in. The rate is
/// `None` where the codes have no frames.
pub(crate) struct Times {
    pub(crate) times: Vec<f64>,
    pub(crate) rate: Option<u32>,
    /// Whether the codes show all frames of a second, so that the rate is sure.
    pub(crate) is_sure: bool,
}

/// Finds the rate in the largest number of a frame. Midnight may be between two codes.
pub(crate) fn times(codes: &[Timecode]) -> Times {
    let largest = codes.iter().map(|code| code.frames.floor()).fold(0.0, f64::max);
    let has_frames = codes.iter().any(|code| code.frames > 0.0);
    // The last frame before the next second has the largest number that there is.
    let is_sure = codes.windows(2).any(|pair| pair[1].seconds.floor() - pair[0].seconds.floor() == 1.0);
    let fits = |rate: &u32| f64::from(*rate) > largest && (is_sure || *rate >= 60);
    let rate = RATES.into_iter().find(fits).unwrap_or(RATES[RATES.len() - 1]).max(largest as u32 + 1);
    let mut days = 0.0;
    let mut times = Vec::with_capacity(codes.len());
    for (i, code) in codes.iter().enumerate() {
        let before = i.checked_sub(1).map_or(code.seconds, |before| codes[before].seconds);
        if before - code.seconds > DAY / 2.0 {
            days += 1.0;
        }
        times.push(days * DAY + code.seconds + code.frames / f64::from(rate));
    }
    let first = times.first().copied().unwrap_or(0.0);
    times.iter_mut().for_each(|time| *time -= first);
    Times { times, rate: has_frames.then_some(rate), is_sure: is_sure || !has_frames }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(codes: &[&str]) -> Times {
        times(&codes.iter().map(|code| Timecode::parse(code).unwrap()).collect::<Vec<_>>())
    }

    #[test]
    fn frames_are_parts_of_a_second() {
        let Times { times, rate, is_sure } =
            found(&["10:00:00:28.500", "10:00:00:29.500", "10:00:01:00.500", "10:00:02:00"]);
        assert_eq!((rate, is_sure), (Some(30), true));
        let expected = [0.0, 1.0 / 30.0, 2.0 / 30.0, 1.0 + 1.5 / 30.0];
        assert!(times.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{times:?}");
    }

    #[test]
    fn a_short_recording_counts_in_sixtieths() {
        let Times { times, rate, is_sure } = found(&["10:00:00;02", "10:00:00;05"]);
        assert_eq!((rate, is_sure), (Some(60), false));
        assert!((times[1] - 0.05).abs() < 1e-9);
    }

    #[test]
    fn the_end_of_one_second_tells_the_rate() {
        let codes: Vec<String> = (20..50).map(|i| format!("10:00:{:02}:{:02}", i / 30, i % 30)).collect();
        let codes: Vec<&str> = codes.iter().map(String::as_str).collect();
        let Times { times, rate, is_sure } = found(&codes);
        assert_eq!((rate, is_sure), (Some(30), true));
        assert!((times[29] - 29.0 / 30.0).abs() < 1e-9, "{times:?}");
        // Seconds that were left out tell nothing.
        assert!(!found(&["10:00:00:05", "10:00:03:07"]).is_sure);
    }

    #[test]
    fn midnight_and_plain_seconds() {
        assert!((found(&["23:59:59.5", "00:00:00.25"]).times[1] - 0.75).abs() < 1e-9);
        assert_eq!(found(&["0.5", "0.75"]).times, [0.0, 0.25]);
        assert_eq!(Timecode::parse("a:b:c:d"), None);
        assert_eq!(Timecode::parse("1:2"), None);
    }
}
