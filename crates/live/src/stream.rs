//! From datagrams to frames of a rig's handles, whatever comes and in whatever order.

use crate::latency::Latency;
use crate::packet::Frame;
use std::collections::HashMap;
use std::net::SocketAddr;

/// Seconds of the sender's clock in which the confidence of a marker that is no longer seen falls from 1 to 0.
pub const FADE: f64 = 0.5;
/// Seconds without a frame after which another sender is listened to, or the same one from the start.
pub const SILENCE: f64 = 1.0;

/// What became of the datagrams.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Frames that were taken.
    pub frames: u64,
    /// Frames that came after a newer one, or twice, and were dropped.
    pub late: u64,
    /// Numbers that were passed over: frames that never came, or late.
    pub lost: u64,
    /// Datagrams that are no frame, or another sender's while one is heard.
    pub bad: u64,
}

/// The newest frame: H handles in the order that the stream was given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveFrame<'a> {
    /// The sender's number.
    pub number: i64,
    /// Its time in seconds: the sender's, and where that began anew, as long after the last frame as it came after it. It only rises.
    pub time: f64,
    /// How many seconds it came behind the fastest frame of the last 10 to 20 s, measured from the sender's time to its arrival.
    pub latency: f64,
    /// H positions in mesh units and head space; a marker that is not seen is where it was, and before it is ever seen at rest.
    pub positions: &'a [[f32; 3]],
    /// H: 1 where the marker is seen, else what falls to 0 within [`FADE`] after it was; 0 before it is ever seen.
    pub confidence: &'a [f32],
}

/// The state of one stream; its memory is that of H handles.
#[derive(Debug)]
pub struct Stream {
    /// From a label to its place among the handles.
    handles: HashMap<String, usize>,
    positions: Vec<[f32; 3]>,
    confidence: Vec<f32>,
    /// H: the time of the last frame that a marker was seen in.
    seen: Vec<Option<f64>>,
    last: Option<Last>,
    latency: Latency,
    counts: Counts,
    why_bad: Option<&'static str>,
}

/// What is known of the last frame.
#[derive(Debug)]
struct Last {
    from: SocketAddr,
    /// When it came, on this machine's clock.
    arrived: f64,
    number: i64,
    /// Its time, which only rises.
    time: f64,
    /// What was added to the sender's.
    offset: f64,
    latency: f64,
}

impl Stream {
    /// A stream of these H handles, which are at `rest` until they are seen. Labels that are sent and not here are passed over.
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

    /// Takes a datagram that came `from` there at `arrived`, in seconds on a clock that only rises; says whether it is the newest frame now.
    pub fn accept(&mut self, datagram: &[u8], from: SocketAddr, arrived: f64) -> bool {
        let heard = self.last.as_ref().filter(|last| arrived - last.arrived < SILENCE);
        if heard.is_some_and(|last| last.from != from) {
            return self.bad("is of another sender than the one that is heard");
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
        let latency = self.latency.of(arrived, frame.seconds);
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

    /// What became of the datagrams so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// What is wrong with the last datagram that was bad, to stand behind "the datagram".
    pub fn why_bad(&self) -> Option<&'static str> {
        self.why_bad
    }
}
