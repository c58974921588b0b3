//! From datagrams to frames of a rig's handles. Datagrams may have any content and come in any order.

use crate::latency::Latency;
use crate::packet::Frame;
use std::collections::HashMap;
use std::net::SocketAddr;

/// The time in which the confidence of a marker that is no longer seen falls from 1 to 0, in seconds of the
/// sender's clock.
pub const FADE: f64 = 0.5;
/// The time without a frame after which another sender is accepted, or the same one from its start, in
/// seconds.
pub const SILENCE: f64 = 1.0;

/// The counts of datagrams.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Frames that were accepted.
    pub frames: u64,
    /// Frames that came after a newer one, or a second time, and were dropped.
    pub late: u64,
    /// Numbers that were skipped: frames that never came, or came late.
    pub lost: u64,
    /// Datagrams that are no frame, or that are another sender's while one is heard.
    pub bad: u64,
}

/// The newest frame: H handles in the stream's order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveFrame<'a> {
    /// The sender's number.
    pub number: i64,
    /// Its time in seconds, which only rises. It is the sender's time. If the sender starts again, the time
    /// continues by the interval between the two arrivals.
    pub time: f64,
    /// Its delay behind the fastest frame of the last 10 to 20 s, in seconds. Delays are measured from the
    /// sender's time to the arrival.
    pub latency: f64,
    /// H positions in mesh units and head space. A marker that is not seen keeps its last position, or its
    /// rest position if it was never seen.
    pub positions: &'a [[f32; 3]],
    /// H: 1 where the marker is seen. It falls to 0 within [`FADE`] after the marker was last seen. 0 for a
    /// marker that was never seen.
    pub confidence: &'a [f32],
}

/// The state of one stream. Its memory depends only on the number of handles.
#[derive(Debug)]
pub struct Stream {
    /// The index of the handle for each label.
    handles: HashMap<String, usize>,
    positions: Vec<[f32; 3]>,
    confidence: Vec<f32>,
    /// H: the time of the last frame in which the marker was seen.
    seen: Vec<Option<f64>>,
    last: Option<Last>,
    latency: Latency,
    counts: Counts,
    why_bad: Option<&'static str>,
}

/// The last frame.
#[derive(Debug)]
struct Last {
    from: SocketAddr,
    /// Its arrival on this machine's clock.
    arrived: f64,
    number: i64,
    /// Its time, which only rises.
    time: f64,
    /// The offset that was added to the sender's time.
    offset: f64,
    latency: f64,
}

impl Stream {
    /// A stream of these H handles, which are at `rest` until they are seen. Other labels in datagrams are
    /// ignored.
    ///
    /// # Panics
    /// If there are not as many positions as labels.
    pub fn new(labels: &[String], rest: &[[f32; 3]]) -> Self {
        assert_eq!(labels.len(), rest.len(), "a position for each label");
        Self {
            handles: labels.iter().enumerate().map(|(handle, label)| (label.clone(), handle)).collect(),
            positions: rest.to_vec(),
            confidence: vec![0.0; rest.len()],
            seen: vec![None; rest.len()],
            last: None,
            latency: Latency::default(),
            counts: Counts::default(),
            why_bad: None,
        }
    }

    /// Takes a datagram that came `from` an address at `arrived`, in seconds on a clock that only rises. The
    /// result is whether it is now the newest frame.
    pub fn accept(&mut self, datagram: &[u8], from: SocketAddr, arrived: f64) -> bool {
        let heard = self.last.as_ref().filter(|last| arrived - last.arrived < SILENCE);
        if heard.is_some_and(|last| last.from != from) {
            return self.bad("is from another sender than the frames before it");
        }
        let is_heard = heard.is_some();
        let frame = match Frame::decode(datagram) {
            Ok(frame) => frame,
            Err(why) => return self.bad(why),
        };
        let mut offset = 0.0;
        if let Some(last) = &self.last {
            offset = last.offset;
            if last.from == from && frame.number > last.number && frame.seconds + offset > last.time {
                self.counts.lost = self.counts.lost.saturating_add(last.number.abs_diff(frame.number) - 1);
            } else if !is_heard {
                offset = last.time + (arrived - last.arrived) - frame.seconds;
                self.latency = Latency::default();
            } else if frame.number <= last.number {
                self.counts.late += 1;
                return false;
            } else {
                return self.bad("has a higher number than the frame before it, but no later time");
            }
        }
        let time = frame.seconds + offset;
        self.take(&frame, time);
        let latency = self.latency.add(arrived, frame.seconds);
        self.last = Some(Last { from, arrived, number: frame.number, time, offset, latency });
        self.counts.frames += 1;
        true
    }

    fn bad(&mut self, why: &'static str) -> bool {
        self.counts.bad += 1;
        self.why_bad = Some(why);
        false
    }

    fn take(&mut self, frame: &Frame, time: f64) {
        for (label, position) in &frame.markers {
            if let Some(&handle) = self.handles.get(label) {
                self.positions[handle] = *position;
                self.seen[handle] = Some(time);
            }
        }
        for (confidence, seen) in self.confidence.iter_mut().zip(&self.seen) {
            *confidence = seen.map_or(0.0, |seen| (1.0 - (time - seen) / FADE).max(0.0) as f32);
        }
    }

    /// The newest frame; `None` before the first.
    pub fn newest(&self) -> Option<LiveFrame<'_>> {
        let last = self.last.as_ref()?;
        Some(LiveFrame {
            number: last.number,
            time: last.time,
            latency: last.latency,
            positions: &self.positions,
            confidence: &self.confidence,
        })
    }

    /// The counts of the datagrams so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// What is wrong with the last bad datagram, as the rest of a sentence that begins with "the datagram".
    pub fn why_bad(&self) -> Option<&'static str> {
        self.why_bad
    }
}
