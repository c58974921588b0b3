//! Playing a take: which frame is shown when.

/// What happens at the end of the range that plays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Repeat {
    /// It stops.
    Once,
    /// It begins again.
    #[default]
    Loop,
    /// It plays backwards, and forwards again at the beginning.
    PingPong,
}

impl Repeat {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Once, Self::Loop, Self::PingPong];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Once => "once",
            Self::Loop => "loop",
            Self::PingPong => "ping-pong",
        }
    }

    /// The next one.
    #[must_use]
    pub fn next(self) -> Self {
        match self {
            Self::Once => Self::Loop,
            Self::Loop => Self::PingPong,
            Self::PingPong => Self::Once,
        }
    }
}

/// The play head on frames that have times of their own.
#[derive(Debug, Clone, PartialEq)]
pub struct Transport {
    /// In seconds, strictly increasing; at least one.
    times: Vec<f64>,
    /// The duration of the last frame, in seconds.
    last: f64,
    frame: usize,
    /// Seconds since the first frame.
    position: f64,
    /// Whether it plays backwards, on the way back of [`Repeat::PingPong`].
    backwards: bool,
    /// The first and the last frame that play.
    range: [usize; 2],
    /// Whether time passes.
    pub playing: bool,
    /// What happens at the end.
    pub repeat: Repeat,
    /// The speed. 1 is the take's own rate.
    pub speed: f64,
}

impl Transport {
    /// For frames at these `times` in seconds. The last frame is shown as long as a frame at `rate` frames a
    /// second. All frames play.
    ///
    /// # Panics
    /// If there are none.
    pub fn new(times: &[f64], rate: f64) -> Self {
        assert!(!times.is_empty(), "a take has a frame");
        Self {
            times: times.to_vec(),
            last: 1.0 / rate,
            frame: 0,
            position: 0.0,
            backwards: false,
            range: [0, times.len() - 1],
            playing: false,
            repeat: Repeat::default(),
            speed: 1.0,
        }
    }

    /// How many frames there are.
    pub fn frames(&self) -> usize {
        self.times.len()
    }

    /// The frame that is shown.
    pub fn frame(&self) -> usize {
        self.frame
    }

    /// Its time, in seconds.
    pub fn time(&self) -> f64 {
        self.times[self.frame]
    }

    /// The times of all frames, in seconds.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Frames a second, from the duration of the last frame.
    pub fn rate(&self) -> f64 {
        1.0 / self.last
    }

    /// The first and the last frame that play.
    pub fn range(&self) -> [usize; 2] {
        self.range
    }

    /// Whether all frames play.
    pub fn plays_all(&self) -> bool {
        self.range == [0, self.times.len() - 1]
    }

    /// Plays from this frame on. Where the end is earlier, the end is the take's.
    pub fn set_begin(&mut self, frame: usize) {
        let last = self.times.len() - 1;
        let begin = frame.min(last);
        self.range = [begin, if self.range[1] < begin { last } else { self.range[1] }];
    }

    /// Plays up to this frame. Where the beginning is later, the beginning is the take's.
    pub fn set_end(&mut self, frame: usize) {
        let end = frame.min(self.times.len() - 1);
        self.range = [if self.range[0] > end { 0 } else { self.range[0] }, end];
    }

    /// Plays all frames.
    pub fn reset_range(&mut self) {
        self.range = [0, self.times.len() - 1];
    }

    /// Shows a frame. If there are fewer frames, shows the last one.
    pub fn seek(&mut self, frame: usize) {
        self.frame = frame.min(self.times.len() - 1);
        self.position = self.since_first(self.frame);
        self.backwards = false;
    }

    /// Stops, and moves by this many frames, forwards or back. It does not go beyond the take's ends.
    pub fn step(&mut self, frames: isize) {
        self.playing = false;
        self.seek(self.frame.saturating_add_signed(frames));
    }

    /// Plays or stops. Where the range has ended, or is elsewhere, it plays from its beginning.
    pub fn toggle(&mut self) {
        self.playing = !self.playing;
        let [first, last] = self.range;
        let is_at_end = self.frame == last && !self.backwards;
        if self.playing && (is_at_end || !(first..=last).contains(&self.frame)) {
            self.seek(first);
        }
    }

    /// Advances the play head by `seconds` of the clock. Late frames are skipped.
    pub fn advance(&mut self, seconds: f64) {
        if !self.playing || seconds <= 0.0 {
            return;
        }
        let [first, last] = self.range;
        let [start, end] = [self.since_first(first), self.end_of(last)];
        // On the way back, the frames at both ends are left out, as they have just been shown.
        let way_back = match self.repeat {
            Repeat::PingPong if last > first => self.since_first(last) - self.since_first(first + 1),
            _ => 0.0,
        };
        let (way, turn) = (end - start, self.since_first(last));
        let is_back = self.backwards && way_back > 0.0;
        let done = if is_back { way + turn - self.position } else { (self.position - start).max(0.0) };
        let done = done + seconds * self.speed;
        if self.repeat == Repeat::Once && done >= way {
            self.playing = false;
            self.seek(last);
            return;
        }
        let done = done % (way + way_back);
        self.backwards = done >= way;
        // The sum of the clock's steps can be a little before the time in a file.
        const ROUNDING: f64 = 1e-6;
        if self.backwards {
            self.position = turn - (done - way);
            let time = self.times[0] + self.position - ROUNDING;
            self.frame = self.times.partition_point(|t| *t < time).saturating_sub(1).clamp(first, last);
        } else {
            self.position = start + done;
            let time = self.times[0] + self.position + ROUNDING;
            self.frame = self.times.partition_point(|t| *t <= time).saturating_sub(1).clamp(first, last);
        }
    }

    /// Seconds of the clock until the next frame.
    pub fn until_next(&self) -> f64 {
        let next = match self.backwards {
            true => self.position - self.since_first(self.frame),
            false => self.end_of(self.frame) - self.position,
        };
        (next / self.speed).max(0.0)
    }

    /// Seconds from the first frame to this one.
    fn since_first(&self, frame: usize) -> f64 {
        self.times[frame] - self.times[0]
    }

    /// Seconds from the first frame to the end of this one.
    fn end_of(&self, frame: usize) -> f64 {
        match self.times.get(frame + 1) {
            Some(next) => next - self.times[0],
            None => self.since_first(frame) + self.last,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_25(frames: usize) -> Transport {
        let times: Vec<f64> = (0..frames).map(|i| 3.0 + i as f64 / 25.0).collect();
        Transport::new(&times, 25.0)
    }

    #[test]
    fn it_plays_at_the_takes_own_rate_whatever_the_screens() {
        for screen in [24.0, 59.94, 60.0, 144.0] {
            let mut transport = at_25(250);
            transport.toggle();
            let steps = (4.0 * screen) as usize;
            (0..steps).for_each(|_| transport.advance(1.0 / screen));
            let expected = (steps as f64 / screen * 25.0 + 1e-3) as usize;
            assert_eq!(transport.frame(), expected, "{screen} Hz");
        }
    }

    #[test]
    fn it_loops_or_stops_at_the_end() {
        let mut transport = at_25(10);
        transport.toggle();
        transport.advance(0.4 + 2.0 / 25.0);
        assert_eq!((transport.frame(), transport.playing), (2, true));
        transport.repeat = Repeat::Once;
        transport.advance(5.0);
        assert_eq!((transport.frame(), transport.playing), (9, false));
        transport.toggle();
        assert_eq!((transport.frame(), transport.playing), (0, true), "it begins again");
        transport.step(-1);
        assert_eq!((transport.frame(), transport.playing), (0, false));
        transport.step(100);
        assert_eq!(transport.frame(), 9);
    }

    #[test]
    fn frames_are_shown_as_long_as_their_times_say() {
        let mut transport = Transport::new(&[0.0, 1.0, 1.1], 10.0);
        transport.toggle();
        transport.advance(0.9);
        assert_eq!(transport.frame(), 0);
        assert!((transport.until_next() - 0.1).abs() < 1e-9);
        transport.advance(0.15);
        assert_eq!(transport.frame(), 1);
        let mut one = Transport::new(&[7.0], 30.0);
        one.toggle();
        one.advance(100.0);
        assert_eq!(one.frame(), 0);
    }

    /// The frames that a screen of 100 pictures a second shows, each once.
    fn shown(transport: &mut Transport, seconds: f64) -> Vec<usize> {
        let mut shown = vec![transport.frame()];
        for _ in 0..(seconds * 100.0).round() as usize {
            transport.advance(0.01);
            if shown.last() != Some(&transport.frame()) {
                shown.push(transport.frame());
            }
        }
        shown
    }

    #[test]
    fn ping_pong_shows_each_frame_once_on_each_way() {
        let mut transport = at_25(10);
        transport.set_begin(2);
        transport.set_end(5);
        transport.repeat = Repeat::PingPong;
        transport.toggle();
        // Two frames back for four forwards: a round takes six frames of 0.04 s.
        assert_eq!(shown(&mut transport, 0.47), [2, 3, 4, 5, 4, 3, 2, 3, 4, 5, 4, 3]);
        // It wakes in time on the way back, too.
        assert!(transport.until_next() < 0.0401, "{}", transport.until_next());
    }

    #[test]
    fn only_the_range_plays() {
        let mut transport = at_25(10);
        transport.set_begin(3);
        transport.set_end(5);
        transport.toggle();
        assert_eq!(transport.frame(), 3, "the play head was outside");
        assert_eq!(shown(&mut transport, 0.23), [3, 4, 5, 3, 4, 5]);
        transport.repeat = Repeat::Once;
        assert_eq!(shown(&mut transport, 0.3).last(), Some(&5));
        assert!(!transport.playing);
        // The play head can leave the range by hand.
        transport.step(3);
        assert_eq!(transport.frame(), 8);
        // Both ends stay in order, and in the take.
        transport.set_end(1);
        assert_eq!(transport.range(), [0, 1]);
        transport.set_begin(7);
        assert_eq!(transport.range(), [7, 9]);
        transport.set_end(99);
        assert_eq!(transport.range(), [7, 9]);
        assert!(!transport.plays_all());
        transport.reset_range();
        assert!(transport.plays_all());
    }
}
