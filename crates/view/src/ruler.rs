//! The ruler of the time line: where frames are, and which round seconds and frames have numbers.

use eframe::egui::Rangef;

/// The least room beside a number, in points.
const ROOM: f32 = 16.0;
/// Round steps of each power of ten.
const ROUND: [u64; 3] = [1, 2, 5];
/// Round seconds: thousandths, so that they are whole numbers. Minutes follow tens of seconds.
const ROUND_SECONDS: [u64; 23] = [
    1, 2, 5, 10, 20, 50, 100, 200, 500, 1_000, 2_000, 5_000, 10_000, 20_000, 30_000, 60_000, 120_000,
    300_000, 600_000, 1_200_000, 1_800_000, 3_600_000, 7_200_000,
];

/// A number on the ruler, and its place.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Mark {
    pub x: f32,
    pub words: String,
}

/// Frames at equal distances from left to right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ruler {
    left: f32,
    width: f32,
    last: usize,
}

impl Ruler {
    /// For frames at these `times`, at least two, between both ends of `across`.
    pub(crate) fn new(across: Rangef, times: &[f64]) -> Self {
        Self { left: across.min, width: across.span().max(1.0), last: times.len().saturating_sub(1).max(1) }
    }

    /// The place of a frame.
    pub(crate) fn x(&self, frame: usize) -> f32 {
        self.between(frame as f64)
    }

    /// The place of a frame number, which may be between two frames.
    fn between(&self, frame: f64) -> f32 {
        self.left + self.width * (frame / self.last as f64) as f32
    }

    /// The frame that is nearest to a place.
    pub(crate) fn frame_at(&self, x: f32) -> usize {
        let part = ((x - self.left) / self.width).clamp(0.0, 1.0);
        (part * self.last as f32).round() as usize
    }

    /// The least step, in frames, for numbers of this width.
    fn least(&self, width: f32) -> f64 {
        f64::from((width + ROOM) / self.width) * self.last as f64
    }
}

/// The numbers of round frames, none of which touch each other. `width` measures a number.
pub(crate) fn frame_marks(ruler: &Ruler, frames: usize, width: impl Fn(&str) -> f32) -> Vec<Mark> {
    let least = ruler.least(width(&frames.to_string()));
    let powers = (0..18).map(|power| 10_u64.pow(power));
    let mut steps = powers.flat_map(|power| ROUND.map(|step| step * power));
    let Some(step) = steps.find(|step| *step as f64 >= least).and_then(|step| usize::try_from(step).ok())
    else {
        return Vec::new();
    };
    let mark = |frame: usize| Mark { x: ruler.x(frame), words: frame.to_string() };
    (0..frames).step_by(step).map(mark).collect()
}

/// The numbers of round seconds, none of which touch each other. The take's `times` rise.
pub(crate) fn second_marks(ruler: &Ruler, times: &[f64], width: impl Fn(&str) -> f32) -> Vec<Mark> {
    let (Some(&start), Some(&end)) = (times.first(), times.last()) else { return Vec::new() };
    let frames_a_second = (times.len() - 1) as f64 / (end - start);
    for step in ROUND_SECONDS {
        let seconds = step as f64 / 1e3;
        let digits = if step % 1_000 == 0 { 0 } else { (3 - trailing_zeros(step)) as usize };
        let words = |second: f64| format!("{second:.digits$} s");
        let widest = width(&words(end)).max(width(&words(start)));
        if seconds * frames_a_second < ruler.least(widest) {
            continue;
        }
        let [first, last] = [(start / seconds).ceil(), (end / seconds).floor()].map(|n| n as i64);
        let mark = |n: i64| {
            let second = n as f64 * seconds;
            Mark { x: ruler.between(frame_of(times, second)), words: words(second) }
        };
        return (first..=last).map(mark).collect();
    }
    Vec::new()
}

/// The number of zeros at the end of a decimal number.
fn trailing_zeros(mut number: u64) -> u32 {
    let mut zeros = 0;
    while number > 0 && number.is_multiple_of(10) {
        number /= 10;
        zeros += 1;
    }
    zeros
}

/// The frame number of a time, which may be between two frames.
fn frame_of(times: &[f64], time: f64) -> f64 {
    let next = times.partition_point(|at| *at <= time).clamp(1, times.len() - 1);
    let [before, after] = [times[next - 1], times[next]];
    (next - 1) as f64 + ((time - before) / (after - before)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each letter is 6 points wide.
    fn width(words: &str) -> f32 {
        6.0 * words.len() as f32
    }

    fn words(marks: &[Mark]) -> Vec<&str> {
        marks.iter().map(|mark| &*mark.words).collect()
    }

    #[test]
    fn round_frames_and_seconds_have_numbers_that_do_not_touch() {
        // Ten seconds at 60 frames a second, which begin at 3 s.
        let times: Vec<f64> = (0..=600).map(|i| 3.0 + f64::from(i) / 60.0).collect();
        for (across, frames, seconds) in [
            (
                384.0,
                vec!["0", "100", "200", "300", "400", "500", "600"],
                vec!["4 s", "6 s", "8 s", "10 s", "12 s"],
            ),
            (100.0, vec!["0", "500"], vec!["5 s", "10 s"]),
        ] {
            let ruler = Ruler::new(Rangef::new(8.0, 8.0 + across), &times);
            let of_frames = frame_marks(&ruler, times.len(), width);
            let of_seconds = second_marks(&ruler, &times, width);
            assert_eq!((words(&of_frames), words(&of_seconds)), (frames, seconds));
            for marks in [of_frames, of_seconds] {
                for pair in marks.windows(2) {
                    assert!(pair[0].x + width(&pair[0].words) < pair[1].x, "{pair:?}");
                }
            }
        }
        let ruler = Ruler::new(Rangef::new(0.0, 600.0), &times);
        let five = second_marks(&ruler, &times, width).into_iter().find(|mark| mark.words == "5 s").unwrap();
        assert!((five.x - 120.0).abs() < 0.01, "two seconds of ten: {five:?}");
        assert_eq!((ruler.frame_at(-5.0), ruler.frame_at(120.4), ruler.frame_at(9e9)), (0, 120, 600));
    }

    #[test]
    fn short_takes_have_parts_of_seconds_and_uneven_ones_their_own_times() {
        let times = [0.0, 0.1, 0.2, 0.4];
        let ruler = Ruler::new(Rangef::new(0.0, 300.0), &times);
        let marks = second_marks(&ruler, &times, width);
        assert_eq!(words(&marks), ["0.0 s", "0.1 s", "0.2 s", "0.3 s", "0.4 s"]);
        // Between the last two frames, which are 0.2 s apart.
        assert!((marks[3].x - 250.0).abs() < 0.01, "{marks:?}");
        assert_eq!(words(&frame_marks(&ruler, 4, width)), ["0", "1", "2", "3"]);
    }
}
