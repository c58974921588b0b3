//! Playing of a take to a receiver.

use crate::packet::Frame;
use crate::receiver::io;
use rhytid_core::{Error, Progress, Result, Take};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::thread;
use std::time::{Duration, Instant};

/// The longest sleep, after which a sender checks whether it was cancelled.
const NAP: Duration = Duration::from_millis(100);

/// A take that is sent to an address.
#[derive(Debug)]
pub struct Sender<'a> {
    take: &'a Take,
    /// The time at which each frame is due, in seconds after the first.
    due: Vec<f64>,
    /// The duration of the take, from its first frame to the start of its repetition.
    length: f64,
    socket: UdpSocket,
    to: SocketAddr,
}

/// The totals of what was sent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sent {
    /// The number of datagrams, one for each frame.
    pub frames: u64,
    /// The bytes of the longest datagram.
    pub bytes: usize,
    /// The largest delay of a frame behind its time, in seconds.
    pub late: f64,
}

impl<'a> Sender<'a> {
    /// A sender of `take` at `rate` frames per second, or at the take's own times.
    ///
    /// # Errors
    /// [`Error::Input`] if the take has no frame, if a frame is no datagram ([`Frame::encode`]), or if the
    /// rate is not above 0. [`Error::Io`].
    pub fn new(take: &'a Take, rate: Option<f64>, to: SocketAddr) -> Result<Self> {
        let Some(&first) = take.times.first() else {
            return Err(Error::empty("the take has no frame to send"));
        };
        if let Some(rate) = rate.filter(|rate| !(rate.is_finite() && *rate > 0.0)) {
            return Err(Error::out_of_range(format!("the rate is {rate}, expected a number above 0")));
        }
        let due: Vec<f64> = match rate {
            Some(rate) => (0..take.frames()).map(|frame| frame as f64 / rate).collect(),
            None => take.times.iter().map(|time| time - first).collect(),
        };
        let length = due.last().copied().unwrap_or_default() + 1.0 / rate.unwrap_or_else(|| take.rate());
        let any =
            if to.is_ipv4() { (Ipv4Addr::UNSPECIFIED, 0).into() } else { (Ipv6Addr::UNSPECIFIED, 0).into() };
        let any: SocketAddr = any;
        let socket = UdpSocket::bind(any).map_err(io(any))?;
        let sender = Self { take, due, length, socket, to };
        sender.frame(0, 0).encode()?;
        Ok(sender)
    }

    /// Sends the take `times` times, one after another. With `None`, sends until it is cancelled.
    ///
    /// Each frame is sent at its own time after the start, so a late frame does not delay the next ones.
    /// Numbers and times continue from one repetition to the next. The sender does not know whether anybody
    /// listens.
    ///
    /// A marker that is missing from a frame ([`rhytid_core::RawTake::MISSING`]) is not sent in it.
    ///
    /// # Errors
    /// [`Error::Input`] if a frame is no datagram. [`Error::Io`] if the address cannot be sent to. Cancelling
    /// is no error: the result has what was sent.
    pub fn send(&self, times: Option<u64>, progress: &dyn Progress) -> Result<Sent> {
        let start = Instant::now();
        let mut sent = Sent::default();
        let frames = self.take.frames();
        let total = times.map_or(u64::MAX, |times| times.saturating_mul(frames as u64));
        for turn in 0..times.unwrap_or(u64::MAX) {
            for frame in 0..frames {
                let frame = self.frame(turn, frame);
                let datagram = frame.encode()?;
                if !sleep_until(start, frame.seconds, progress) {
                    return Ok(sent);
                }
                let late = start.elapsed().as_secs_f64() - frame.seconds;
                self.socket.send_to(&datagram, self.to).map_err(io(self.to))?;
                sent.late = sent.late.max(late);
                sent.bytes = sent.bytes.max(datagram.len());
                sent.frames += 1;
                if times.is_some() {
                    progress.report("send", sent.frames, total);
                }
            }
        }
        Ok(sent)
    }

    fn frame(&self, turn: u64, frame: usize) -> Frame {
        let markers = self.take.labels.len();
        let positions = &self.take.positions[frame * markers..][..markers];
        let is_seen = |position: &[f64; 3]| position.iter().all(|x| !x.is_nan());
        Frame {
            number: turn as i64 * self.take.frames() as i64 + frame as i64,
            seconds: turn as f64 * self.length + self.due[frame],
            markers: self
                .take
                .labels
                .iter()
                .zip(positions)
                .filter(|(_, position)| is_seen(position))
                .map(|(label, position)| (label.clone(), position.map(|x| x as f32)))
                .collect(),
        }
    }
}

/// Sleeps until a time after `start`. False if it was cancelled meanwhile.
fn sleep_until(start: Instant, seconds: f64, progress: &dyn Progress) -> bool {
    loop {
        if progress.cancelled() {
            return false;
        }
        let left = seconds - start.elapsed().as_secs_f64();
        if left <= 0.0 {
            return true;
        }
        thread::sleep(NAP.min(Duration::from_secs_f64(left.min(1.0))));
    }
}
