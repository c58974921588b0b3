//! Playing a take: which frame is shown when.

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
    /// Whether time passes.
    pub playing: bool,
    /// Whether the take begins again at its end.
    pub looping: bool,
    /// The speed. 1 is the take's own rate.
    pub speed: f64,
}

impl Transport {
    /// For frames at these `times` in seconds. The last frame is shown as long as a frame at `rate` frames a
    /// second.
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
            playing: false,
            looping: true,
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

    /// Shows a frame. If there are fewer frames, shows the last one.
    pub fn seek(&mut self, frame: usize) {
        self.frame = frame.min(self.times.len() - 1);
        self.position = self.times[self.frame] - self.times[0];
    }

    /// Stops, and moves by this many frames, forwards or back. It does not go beyond the ends.
    pub fn step(&mut self, frames: isize) {
        self.playing = false;
        self.seek(self.frame.saturating_add_signed(frames));
    }

    /// Plays or stops. A take that has ended plays from its start.
    pub fn toggle(&mut self) {
        self.playing = !self.playing;
        if self.playing && self.frame + 1 == self.times.len() {
            self.seek(0);
        }
    }

    /// Advances the play head by `seconds` of the clock. Late frames are skipped.
    pub fn advance(&mut self, seconds: f64) {
        if !self.playing || seconds <= 0.0 {
            return;
        }
        let length = self.times[self.times.len() - 1] - self.times[0] + self.last;
        self.position += seconds * self.speed;
        if self.position >= length {
            match self.looping {
                true => self.position %= length,
                false => {
                    self.playing = false;
                    self.seek(self.times.len() - 1);
                    return;
                }
            }
        }
        // The sum of the clock's steps can be a little before the time in a file.
        let time = self.times[0] + self.position + 1e-6;
        self.frame = self.times.partition_point(|t| *t <= time).saturating_sub(1);
    }

    /// Seconds of the clock until the next frame.
    pub fn until_next(&self) -> f64 {
        let next = self.times.get(self.frame + 1).map_or(self.times[self.frame] + self.last, |time| *time);
        ((next - self.times[0] - self.position) / self.speed).max(0.0)
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
        transport.looping = false;
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
}
