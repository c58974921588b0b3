//! How late frames come, without a clock that both ends share.

/// A window's length in seconds: clocks that run apart by 50 parts in a million are a millisecond apart after two.
const WINDOW: f64 = 10.0;

/// The least delay of late, of which all others are told.
///
/// A frame's delay is when it came, on this machine's monotonic clock, less its time on the sender's. The clocks' zeros differ, so a delay by itself says
/// nothing; its latency is what it is above the least delay of this window and the one before it: how far a frame is behind the fastest.
#[derive(Debug, Default)]
pub(crate) struct Latency {
    /// When this window began, and its least delay.
    window: Option<(f64, f64)>,
    /// The least delay of the window before.
    before: Option<f64>,
}

impl Latency {
    /// The latency in seconds, 0 or above, of a frame that came at `arrived` with this time of the sender's.
    pub(crate) fn of(&mut self, arrived: f64, sent: f64) -> f64 {
        let delay = arrived - sent;
        match &mut self.window {
            Some((since, least)) if arrived - *since < WINDOW => *least = least.min(delay),
            window => self.before = window.replace((arrived, delay)).map(|(_, least)| least),
        }
        let least = self.window.map_or(delay, |(_, least)| least);
        delay - self.before.map_or(least, |before| before.min(least))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_above_the_fastest_frame_and_follows_a_clock_that_runs_apart() {
        let mut latency = Latency::default();
        assert_eq!(latency.of(105.0, 0.0), 0.0);
        assert_eq!(latency.of(106.5, 1.0), 0.5);
        assert_eq!(latency.of(106.0, 2.0), 0.0);
        assert_eq!(latency.of(108.0, 3.0), 1.0);
        // The sender's clock loses a thousandth: in an hour 3.6 s, of which two windows' are seen.
        let mut latency = Latency::default();
        for i in 0..36_000 {
            let arrived = f64::from(i) * 0.1;
            assert!(latency.of(arrived, arrived * 0.999) < 0.001 * 2.0 * WINDOW + 1e-3);
        }
    }
}
