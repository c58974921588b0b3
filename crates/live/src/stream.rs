//! From datagrams to frames. Datagrams may have any content and come in any order.

use crate::clock::Clock;
use crate::counts::{Counts, Others};
use crate::labels::{Handles, Labels};
use crate::latency::Latency;
use crate::part::{Part, Stamp};
use crate::pattern::Pattern;
use crate::pending::Pending;
use crate::warnings::{About, Warnings};
use std::collections::{BTreeMap, HashMap};
use std::net::SocketAddr;

/// The time in which the confidence of a marker that is no longer seen falls from 1 to 0, in seconds of the
/// sender's clock.
pub const FADE: f64 = 0.5;
/// The time without a frame after which another sender is accepted, or the same one from its start, in
/// seconds.
pub const SILENCE: f64 = 1.0;
/// The time, in seconds, in which a stream of all markers learns their labels.
pub const LEARNING: f64 = 2.0;

/// The newest frame, with M markers in the order of [`Stream::labels`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveFrame<'a> {
    /// The sender's number. Without one, the number of frames before it.
    pub number: i64,
    /// Its time in seconds, which only rises. It is the sender's time. If the sender starts again, the time
    /// continues by the interval between the two arrivals. It is the time of arrival if the sender gives
    /// none, or none that can be seconds.
    pub time: f64,
    /// Its delay behind the fastest frame of the last 10 to 20 s, in seconds. Delays are measured from the
    /// frame's time to the arrival of its last datagram.
    pub latency: f64,
    /// M positions as they were sent. A marker that is not seen keeps its last position. A handle that was
    /// never seen has its rest position.
    pub positions: &'a [[f32; 3]],
    /// M: 1 where the marker is seen. It falls to 0 within [`FADE`] after the marker was last seen. 0 for a
    /// marker that was never seen.
    pub confidence: &'a [f32],
}

/// The state of one stream. Its memory depends only on the number of markers.
#[derive(Debug)]
pub struct Stream {
    pattern: Pattern,
    labels: Labels,
    /// When the first marker came.
    since: Option<f64>,
    positions: Vec<[f32; 3]>,
    confidence: Vec<f32>,
    /// M: the time of the last frame in which the marker was seen.
    seen: Vec<Option<f64>>,
    /// The sender that is heard, and when it last was.
    sender: Option<(SocketAddr, f64)>,
    /// Whether frames have numbers that tell them apart. Otherwise, a frame ends where a marker comes again.
    is_numbered: bool,
    pending: Option<Pending>,
    last: Option<Last>,
    /// The most datagrams that a numbered frame of this sender has had.
    parts: usize,
    /// The datagrams that contradicted the newest frame, whose number and time they have.
    contradictions: u32,
    /// The time between frames without numbers, in seconds.
    interval: Option<f64>,
    clock: Clock,
    latency: Latency,
    counts: Counts,
    why_bad: Option<&'static str>,
    others: Others,
    warnings: Warnings,
}

/// The last frame.
#[derive(Debug)]
struct Last {
    pending: Pending,
    number: i64,
    time: f64,
    latency: f64,
}

impl Stream {
    /// A stream of these H handles, which are at `rest` until they are seen. Other markers are ignored.
    ///
    /// # Panics
    /// If there are not as many positions as labels.
    pub fn new(labels: &[String], rest: &[[f32; 3]]) -> Self {
        assert_eq!(labels.len(), rest.len(), "a position for each label");
        Self::of(Labels::Handles(Handles::new(labels, &BTreeMap::new())), rest.to_vec())
    }

    /// A stream of all markers that come within the first [`LEARNING`] seconds, under their own labels.
    pub fn of_all_markers() -> Self {
        Self::of(Labels::All { names: Vec::new(), index: HashMap::new() }, Vec::new())
    }

    fn of(labels: Labels, positions: Vec<[f32; 3]>) -> Self {
        Self {
            pattern: Pattern::default(),
            labels,
            since: None,
            confidence: vec![0.0; positions.len()],
            seen: vec![None; positions.len()],
            positions,
            sender: None,
            is_numbered: false,
            pending: None,
            last: None,
            parts: 0,
            contradictions: 0,
            interval: None,
            clock: Clock::default(),
            latency: Latency::default(),
            counts: Counts::default(),
            why_bad: None,
            others: Others::default(),
            warnings: Warnings::default(),
        }
    }

    /// The same stream of messages with another address. Frames then need no `/rhytid/frame`.
    #[must_use]
    pub fn with_pattern(self, pattern: Pattern) -> Self {
        Self { pattern, ..self }
    }

    /// The same stream, in which some handles have markers of other labels: handle → label.
    #[must_use]
    pub fn with_map(self, map: &BTreeMap<String, String>) -> Self {
        match self.labels {
            Labels::Handles(_) => {
                let labels = Labels::Handles(Handles::new(self.labels.names(), map));
                Self { labels, ..self }
            }
            Labels::All { .. } => self,
        }
    }

    /// M labels: the handles', or those of all markers so far.
    pub fn labels(&self) -> &[String] {
        self.labels.names()
    }

    /// Whether it takes all markers.
    pub fn takes_all_markers(&self) -> bool {
        matches!(self.labels, Labels::All { .. })
    }

    /// Takes a datagram that came `from` an address at `arrived`, in seconds on a clock that only rises. The
    /// result is whether there is a new newest frame. The datagram may also have completed a frame that
    /// [`close`](Self::close) gives.
    pub fn accept(&mut self, datagram: &[u8], from: SocketAddr, arrived: f64) -> bool {
        let heard = self.sender.filter(|(_, last)| arrived - last < SILENCE);
        let part = match heard {
            Some((sender, _)) if sender != from => Err("is from another sender than the frames before it"),
            _ => Part::decode(datagram, &self.pattern),
        };
        // A frame whose time has come while nobody looked can still become whole.
        let is_of_pending = heard.is_some() && part.as_ref().is_ok_and(|part| self.is_of_pending(part));
        let is_new = !is_of_pending && self.close(arrived);
        let part = match part {
            Ok(part) => part,
            Err(why) => {
                self.bad(why);
                return is_new;
            }
        };
        if let Some(other) = &part.other {
            self.others.add(other);
        }
        if part.stamp.is_none() && part.markers.is_empty() {
            match part.other.is_some() || part.has_unseen {
                true => self.counts.other += 1,
                false => self.bad("has no message that is read"),
            }
            return is_new;
        }
        if part.stamp.is_none() && self.pattern.is_foreign() {
            self.learn(&part, arrived);
        }
        let is_anew = heard.is_none();
        if is_anew {
            self.is_numbered = false;
        }
        match self.place(&part, from, is_anew) {
            Place::Late => self.counts.late += 1,
            Place::Bad(why) => self.bad(why),
            Place::Nowhere => self.counts.other += 1,
            Place::Joins => {
                self.sender = Some((from, arrived));
                self.join(part, arrived);
            }
            Place::Begins { is_anew } => {
                let gave = self.give();
                self.contradictions = 0;
                self.sender = Some((from, arrived));
                if is_anew {
                    (self.parts, self.interval) = (0, None);
                }
                self.pending = Some(Pending::new(part.stamp, from, is_anew, arrived));
                self.join(part, arrived);
                // One call gives one frame.
                return gave || is_new || self.close(arrived);
            }
        }
        is_new || self.close(arrived)
    }

    /// What a datagram is to the frames so far.
    fn place(&mut self, part: &Part, from: SocketAddr, is_anew: bool) -> Place {
        match part.stamp {
            Some(stamp) => self.place_of_stamped(stamp, part, from, is_anew),
            None if !is_anew && self.newest_part().is_some_and(|newest| newest.stamp.is_some()) => {
                if self.pending.is_some() { self.join_or_bad(part) } else { self.late(part) }
            }
            None if !self.pattern.is_foreign() => Place::Bad("has no /rhytid/frame, and none came before it"),
            None => {
                let placed = self.placed(part);
                match &self.pending {
                    // A marker of no handle must not hold a frame back.
                    _ if placed.is_empty() => Place::Nowhere,
                    Some(pending) if !pending.repeats(&placed) => Place::Joins,
                    _ => Place::Begins { is_anew },
                }
            }
        }
    }

    /// Whether a datagram says, or goes without saying, that it is of the frame that is not whole yet.
    fn is_of_pending(&self, part: &Part) -> bool {
        let pending = self.pending.as_ref().and_then(|pending| pending.stamp);
        self.is_numbered
            && match (pending, part.stamp) {
                (Some(known), Some(stamp)) => known.number == stamp.number,
                (Some(_), None) => true,
                (None, _) => false,
            }
    }

    /// The frame that is not whole yet, else the last one.
    fn newest_part(&self) -> Option<&Pending> {
        self.pending.as_ref().or(self.last.as_ref().map(|last| &last.pending))
    }

    fn place_of_stamped(&mut self, stamp: Stamp, part: &Part, from: SocketAddr, is_anew: bool) -> Place {
        let Some(newest) = self.newest_part() else {
            self.is_numbered = true;
            return Place::Begins { is_anew: true };
        };
        let Some(known) = newest.stamp else {
            // The frames before had no number. The new ones have.
            self.is_numbered = true;
            self.pending = None;
            return Place::Begins { is_anew: true };
        };
        let is_later = stamp.seconds >= known.seconds;
        if from == newest.from && stamp.number > known.number && is_later && (self.is_numbered || is_anew) {
            self.is_numbered = true;
            return Place::Begins { is_anew: false };
        }
        if is_anew {
            self.is_numbered = true;
            return Place::Begins { is_anew: true };
        }
        let placed = self.placed(part);
        // Where each message is a datagram, each frame begins with its number and time.
        let begins_again = part.markers.is_empty() && newest.parts > 0;
        let comes_again = newest.repeats(&placed) || begins_again;
        let contradicts = newest.differs(&placed) || begins_again;
        if !self.is_numbered {
            // The numbers stand still: a frame ends where a marker comes again.
            return match (&self.pending, is_later) {
                (_, false) => Place::Late,
                (Some(_), _) if !comes_again => Place::Joins,
                _ => Place::Begins { is_anew: false },
            };
        }
        if stamp.number == known.number && contradicts {
            self.contradictions += 1;
        }
        let is_still = stamp.seconds > known.seconds || self.contradictions >= ENOUGH;
        if stamp.number == known.number && comes_again && is_still {
            self.is_numbered = false;
            self.warnings.say(About::StillNumbers, || {
                format!(
                    "the number of the frames stays {} from one frame to the next, so frames are numbered as \
                     they come, and lost ones cannot be counted; send a number that rises from frame to \
                     frame in /rhytid/frame NUMBER SECONDS",
                    stamp.number
                )
            });
            return Place::Begins { is_anew: false };
        }
        match (stamp.number > known.number, stamp.number == known.number && self.pending.is_some()) {
            (true, _) => Place::Bad("has a higher number than the frame before it, but an earlier time"),
            (_, true) => self.join_or_bad(part),
            _ if stamp.number == known.number => self.late(part),
            _ => Place::Late,
        }
    }

    fn join_or_bad(&self, part: &Part) -> Place {
        let differs = self.pending.as_ref().is_some_and(|pending| pending.differs(&self.placed(part)));
        if differs { Place::Bad("has another position of a marker of the same frame") } else { Place::Joins }
    }

    /// A part of the last frame that came after the frame was given. The next frames wait for such a part.
    fn late(&mut self, part: &Part) -> Place {
        self.learn(part, self.sender.map_or(0.0, |(_, arrived)| arrived));
        let placed = self.placed(part);
        if let Some(last) = &mut self.last {
            last.pending.add(&placed);
            self.parts = self.parts.max(last.pending.parts);
        }
        Place::Late
    }

    /// The places and positions of a part's markers. Others are left out.
    fn placed(&self, part: &Part) -> Vec<(usize, [f32; 3])> {
        let place = |(label, position): &(String, [f32; 3])| Some((self.labels.place(label)?, *position));
        part.markers.iter().filter_map(place).collect()
    }

    /// Learns the labels of a part.
    fn learn(&mut self, part: &Part, arrived: f64) {
        let since = arrived - *self.since.get_or_insert(arrived);
        for (label, _) in &part.markers {
            self.labels.learn(label, since < LEARNING, &mut self.warnings);
        }
        let markers = self.labels.names().len();
        self.positions.resize(markers, [0.0; 3]);
        self.confidence.resize(markers, 0.0);
        self.seen.resize(markers, None);
    }

    /// Adds a part to the pending frame.
    fn join(&mut self, part: Part, arrived: f64) {
        self.learn(&part, arrived);
        let placed = self.placed(&part);
        if let Some(pending) = &mut self.pending {
            pending.last_arrived = arrived;
            pending.add(&placed);
        }
    }

    /// When the frame that is not whole yet counts as whole, unless more of it comes: a time as those of
    /// [`accept`](Self::accept). `None` where no frame waits.
    pub fn due(&self) -> Option<f64> {
        let pending = self.pending.as_ref()?;
        if self.is_numbered && pending.parts >= self.parts && self.parts > 0 {
            return Some(pending.last_arrived);
        }
        let has_all = self.last.as_ref().is_some_and(|last| pending.has_all_of(&last.pending));
        let pause = self.interval.filter(|_| has_all && !self.is_numbered).map(|interval| interval / 4.0);
        Some(pending.last_arrived + pause.unwrap_or(PAUSE).min(PAUSE))
    }

    /// Takes a frame as whole whose time has come at `now`. The result is whether there is a new newest
    /// frame.
    pub fn close(&mut self, now: f64) -> bool {
        self.due().is_some_and(|due| due <= now) && self.give()
    }

    /// Makes the pending frame the newest one.
    fn give(&mut self) -> bool {
        let Some(pending) = self.pending.take() else { return false };
        if pending.is_anew {
            self.latency = Latency::default();
        }
        let time = self.clock.time(pending.stamp, pending.first_arrived, pending.is_anew, &mut self.warnings);
        let number = match (pending.stamp, &self.last) {
            (Some(stamp), _) if self.is_numbered || self.last.is_none() => stamp.number,
            (_, Some(last)) => last.number.saturating_add(1),
            (_, None) => 0,
        };
        if let (Some(last), Some(stamp), false) = (&self.last, pending.stamp, pending.is_anew)
            && let Some(known) = last.pending.stamp
            && stamp.number > known.number
        {
            self.counts.lost = self.counts.lost.saturating_add(known.number.abs_diff(stamp.number) - 1);
        }
        if let (Some(last), false) = (&self.last, pending.is_anew) {
            let step = pending.first_arrived - last.pending.first_arrived;
            self.interval = Some(self.interval.map_or(step, |interval| interval + 0.1 * (step - interval)));
        }
        for (place, position) in pending.positions() {
            (self.positions[place], self.seen[place]) = (position, Some(time));
        }
        for (confidence, seen) in self.confidence.iter_mut().zip(&self.seen) {
            *confidence = seen.map_or(0.0, |seen| (1.0 - (time - seen) / FADE).max(0.0) as f32);
        }
        self.counts.frames += 1;
        self.parts = self.parts.max(pending.parts);
        let latency = self.latency.add(pending.last_arrived, time);
        self.last = Some(Last { pending, number, time, latency });
        true
    }

    fn bad(&mut self, why: &'static str) {
        self.counts.bad += 1;
        self.why_bad = Some(why);
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

    /// The counts so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// What is wrong with the last bad datagram, as the rest of a sentence that begins with "the datagram".
    pub fn why_bad(&self) -> Option<&'static str> {
        self.why_bad
    }

    /// What came under other addresses, and what was expected, as a sentence without its full stop. `None`
    /// where nothing else came.
    pub fn other_messages(&self) -> Option<String> {
        self.others.words(&self.pattern)
    }

    /// The labels that came, and what was expected, as a sentence without its full stop. `None` where some
    /// marker is a handle's, or where none came.
    pub fn other_labels(&self) -> Option<String> {
        self.labels.unknown_words()
    }

    /// What is likely wrong with the sender, in the order in which it was found: a sentence each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings.sentences
    }
}

/// How long a frame waits for more of it, in seconds. A frame of which all has come does not wait, and the
/// next frame ends the wait, too.
const PAUSE: f64 = 0.1;

/// So many contradictions show that number and time stand still.
const ENOUGH: u32 = 8;

/// What a datagram is to the frames so far.
enum Place {
    /// It begins a frame. `is_anew` says whether it is the first of a sender.
    Begins { is_anew: bool },
    /// It belongs to the frame that is not whole yet.
    Joins,
    /// It belongs to a frame that was given, or to an older one.
    Late,
    /// It has nothing for the stream.
    Nowhere,
    /// It fits nowhere.
    Bad(&'static str),
}
