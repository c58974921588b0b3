//! The latency of frames, without a clock that both ends share.

/// The length of a window in seconds. Clocks that drift by 50 parts in a million are a millisecond apart
/// after two windows.
const WINDOW: f64 = 10.0;

/// The least recent delay, with which delays are compared.
///
/// A frame's delay is its arrival on this machine's monotonic clock, less its time on the sender's clock. The
/// zeros of the clocks differ, so a delay by itself means nothing. The latency of a frame is its delay above
/// the least delay of this window and the one before. So it is how far the frame is behind the fastest one.
#[derive(Debug, Default)]
pub(crate) struct Latency {
    /// The start of this window, and its least delay.
    window: Option<(f64, f64)>,
    /// The least delay of the window before.
    before: Option<f64>,
}

impl Latency {
    /// The latency of a frame in seconds, 0 or above. The frame came at `arrived`, and `sent` is its time on
    /// the sender's clock.
    pub(crate) fn add(&mut self, arrived: f64, sent: f64) -> f64 {
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
        assert_eq!(latency.add(105.0, 0.0), 0.0);
        assert_eq!(latency.add(106.5, 1.0), 0.5);
        assert_eq!(latency.add(106.0, 2.0), 0.0);
        assert_eq!(latency.add(108.0, 3.0), 1.0);
        // The sender's clock loses a thousandth: 3.6 s in an hour. Only the part of two windows is seen.
        let mut latency = Latency::default();
        for i in 0..36_000 {
            let arrived = f64::from(i) * 0.1;
            assert!(latency.add(arrived, arrived * 0.999) < 0.001 * 2.0 * WINDOW + 1e-3);
        }
    }
}
