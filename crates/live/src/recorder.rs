//! Recording of received frames into a take.

use crate::receiver::Receiver;
use crate::stream::{LiveFrame, Stream};
use rhytid_core::{Error, Progress, RawTake, Result, Take, Warning};
use std::time::{Duration, Instant};

/// The interval at which `ended` is asked.
const ASKED_EVERY: Duration = Duration::from_millis(100);

/// A recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// The take with every handle in every recorded frame. Its times are the frames', less that of the first.
    /// It has confidence if some marker was not seen. Of a stream of all markers, it has every marker where
    /// it was seen, and [`RawTake::MISSING`] elsewhere.
    pub take: Take,
    /// The latency of each frame in seconds ([`crate::LiveFrame::latency`]).
    pub latency: Vec<f64>,
    /// The handles that were seen in no frame.
    pub unseen: Vec<String>,
    /// Whether nothing came for `patience`.
    pub timed_out: bool,
}

/// Records `frames` frames. It records fewer if `ended` says so, or if nothing comes for `patience`. `seen`
/// gets each frame as it comes, and the labels of its markers. What is likely wrong with the sender goes to
/// `progress` as soon as it is found.
///
/// # Errors
/// [`Error::Input`] if no frame came within `patience`. [`Error::Cancelled`] if it was ended before the
/// first. [`Error::Io`].
pub fn record(
    receiver: &mut Receiver,
    frames: usize,
    patience: Duration,
    ended: &dyn Fn() -> bool,
    seen: &mut dyn FnMut(&LiveFrame<'_>, &[String]),
    progress: &dyn Progress,
) -> Result<Recording> {
    let mut rows: Vec<Row> = Vec::new();
    let mut start = None;
    let mut last = Instant::now();
    let (mut timed_out, mut warned) = (false, 0);
    while rows.len() < frames && !ended() {
        let came = receiver.next(ASKED_EVERY.min(patience))?.is_some();
        let stream = receiver.stream();
        for sentence in &stream.warnings()[warned..] {
            progress.warn(&Warning::from(sentence.clone()));
        }
        warned = stream.warnings().len();
        let Some(mut frame) = stream.newest().filter(|_| came) else {
            timed_out = last.elapsed() >= patience;
            if timed_out {
                break;
            }
            continue;
        };
        last = Instant::now();
        // The sender's clock has its zero anywhere, so the take begins at 0.
        frame.time -= *start.get_or_insert(frame.time);
        seen(&frame, stream.labels());
        rows.push(Row {
            time: frame.time,
            latency: frame.latency,
            positions: frame.positions.to_vec(),
            confidence: frame.confidence.to_vec(),
        });
        progress.report("record", rows.len() as u64, frames as u64);
    }
    if rows.is_empty() {
        return Err(if timed_out { nothing(receiver, patience) } else { Error::Cancelled });
    }
    Ok(recording(rows, receiver.stream(), timed_out))
}

/// A frame that came.
struct Row {
    time: f64,
    latency: f64,
    positions: Vec<[f32; 3]>,
    confidence: Vec<f32>,
}

fn recording(rows: Vec<Row>, stream: &Stream, timed_out: bool) -> Recording {
    let labels = stream.labels();
    let mut take = Take { labels: labels.to_vec(), ..Take::default() };
    let (mut confidence, mut latency) = (Vec::new(), Vec::new());
    let mut is_seen = vec![false; labels.len()];
    for row in rows {
        take.times.push(row.time);
        latency.push(row.latency);
        // Markers that came later are missing from the first frames.
        for (marker, is_seen) in is_seen.iter_mut().enumerate() {
            let sure = row.confidence.get(marker).copied().unwrap_or(0.0);
            *is_seen |= sure == 1.0;
            let position = row.positions.get(marker).map(|position| position.map(f64::from));
            let is_missing = stream.takes_all_markers() && sure < 1.0;
            take.positions.push(position.filter(|_| !is_missing).unwrap_or(RawTake::MISSING));
            confidence.push(sure);
        }
    }
    if !stream.takes_all_markers() && confidence.iter().any(|&c| c < 1.0) {
        take.confidence = Some(confidence);
    }
    let unseen = labels.iter().zip(is_seen).filter(|(_, is_seen)| !is_seen).map(|(label, _)| label.clone());
    Recording { unseen: unseen.collect(), take, latency, timed_out }
}

fn nothing(receiver: &Receiver, patience: Duration) -> Error {
    let (address, seconds) = (receiver.address(), patience.as_secs_f64());
    let stream = receiver.stream();
    let page = concat!(env!("CARGO_PKG_REPOSITORY"), "/blob/main/docs/live.md");
    let what = match (stream.other_labels(), stream.other_messages(), stream.why_bad()) {
        (Some(labels), _, _) => format!("{labels}; send these; see {page}"),
        (None, Some(others), _) => {
            format!("{others}; send these, or name the address that has the positions; see {page}")
        }
        (None, None, Some(why)) => format!(
            "none of the {} datagrams is a frame (the last {why}); {page} describes a frame",
            stream.counts().bad
        ),
        (None, None, None) if stream.counts().other > 0 => {
            format!("all markers that came are not seen: their positions are NaN; see {page}")
        }
        (None, None, None) => {
            "no datagram arrived; check that the sender sends to this address and port".to_owned()
        }
    };
    Error::network(format!("{address}: no frame came within {seconds} s: {what}"))
}
