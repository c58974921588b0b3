//! Recording of received frames into a take.

use crate::receiver::Receiver;
use crate::stream::LiveFrame;
use rhytid_core::{Error, Progress, Result, Take};
use std::time::{Duration, Instant};

/// The interval at which `ended` is asked.
const ASKED_EVERY: Duration = Duration::from_millis(100);

/// A recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// The take with every handle in every recorded frame, at the sender's times. It has confidence if some
    /// marker was not seen.
    pub take: Take,
    /// The latency of each frame in seconds ([`crate::LiveFrame::latency`]).
    pub latency: Vec<f64>,
    /// The labels that were seen in no frame.
    pub unseen: Vec<String>,
    /// Whether nothing came for `patience`.
    pub timed_out: bool,
}

/// Records `frames` frames of `labels`, which are those of the receiver. It records fewer if `ended` says so,
/// or if nothing comes for `patience`. `seen` gets each frame as it comes.
///
/// # Errors
/// [`Error::Input`] if no frame came within `patience`. [`Error::Cancelled`] if it was ended before the
/// first. [`Error::Io`].
pub fn record(
    receiver: &mut Receiver,
    labels: &[String],
    frames: usize,
    patience: Duration,
    ended: &dyn Fn() -> bool,
    seen: &mut dyn FnMut(&LiveFrame<'_>),
    progress: &dyn Progress,
) -> Result<Recording> {
    let mut take = Take { labels: labels.to_vec(), ..Take::default() };
    let (mut confidence, mut latency) = (Vec::new(), Vec::new());
    let mut is_seen = vec![false; labels.len()];
    let mut last = Instant::now();
    let mut timed_out = false;
    while take.frames() < frames && !ended() {
        let Some(frame) = receiver.next(ASKED_EVERY.min(patience))? else {
            timed_out = last.elapsed() >= patience;
            if timed_out {
                break;
            }
            continue;
        };
        last = Instant::now();
        seen(&frame);
        take.times.push(frame.time);
        take.positions.extend(frame.positions.iter().map(|position| position.map(f64::from)));
        confidence.extend_from_slice(frame.confidence);
        latency.push(frame.latency);
        for (is_seen, &confidence) in is_seen.iter_mut().zip(frame.confidence) {
            *is_seen |= confidence == 1.0;
        }
        progress.report("record", take.frames() as u64, frames as u64);
    }
    if take.frames() == 0 {
        return Err(if timed_out { nothing(receiver, patience) } else { Error::Cancelled });
    }
    if confidence.iter().any(|&c| c < 1.0) {
        take.confidence = Some(confidence);
    }
    let unseen = labels.iter().zip(is_seen).filter(|(_, is_seen)| !is_seen).map(|(label, _)| label.clone());
    Ok(Recording { unseen: unseen.collect(), take, latency, timed_out })
}

fn nothing(receiver: &Receiver, patience: Duration) -> Error {
    let (address, seconds) = (receiver.address(), patience.as_secs_f64());
    let what = match (receiver.counts().bad, receiver.why_bad()) {
        (bad @ 1.., Some(why)) => {
            format!(
                "none of the {bad} datagrams is a frame (the last {why}); {}/blob/main/docs/live.md describes a frame",
                env!("CARGO_PKG_REPOSITORY")
            )
        }
        _ => "no datagram arrived; check that the sender sends to this address and port".to_owned(),
    };
    Error::network(format!("{address}: no frame came within {seconds} s: {what}"))
}
