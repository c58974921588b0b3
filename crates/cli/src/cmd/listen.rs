//! `rhytid animate --listen`: the take that arrives.

use crate::args::{Animate, FramesChoice};
use crate::progress::Ui;
use crate::{interrupt, output};
use rhytid::capture::{Target, misfit};
use rhytid::core::human;
use rhytid::formats::take;
use rhytid::live::{Counts, Receiver, Recording, record};
use rhytid::{Error, Result, Rig, Take};
use std::time::Duration;

/// How long to wait for a frame.
const PATIENCE: Duration = Duration::from_secs(30);
/// The number of labels that a warning lists.
const LABELS: usize = 8;

/// How many frames to record; `None` where there is a take.
///
/// # Errors
/// [`Error::Input`] if `--frames` is of the other kind, or out of range.
pub(super) fn count(args: &Animate) -> Result<Option<usize>> {
    let most = Take::MAX_RESAMPLED;
    match (args.live.listen, args.frames) {
        (None, FramesChoice::Range(_)) => Ok(None),
        (None, FramesChoice::Count(n)) => Err(Error::out_of_range(format!(
            "--frames {n} is for --listen; of a take, give A..B, A.. or ..B, such as ..{n}"
        ))),
        (Some(_), FramesChoice::Count(n)) if (1..=most).contains(&n) => Ok(Some(n)),
        (Some(_), _) => Err(Error::out_of_range(format!(
            "--listen needs to know how many frames to record: give --frames N, from 1 to {most}; Ctrl-C \
             ends the recording earlier"
        ))),
    }
}

/// Records a take of `rig`'s handles, and writes it if requested.
///
/// # Errors
/// [`Error::Input`] if the address cannot be listened at, or if nothing or nothing of this rig arrives;
/// [`Error::Io`]; [`Error::Cancelled`].
pub(super) fn take(args: &Animate, rig: &Rig, frames: usize, ui: &Ui) -> Result<Take> {
    let address = args.live.listen.ok_or_else(|| Error::Internal("nowhere to listen".into()))?;
    let rest: Vec<[f32; 3]> =
        rig.handles().vertices.iter().map(|&vertex| rig.surface().rest[vertex.index()]).collect();
    let mut receiver = Receiver::bind(address, &rig.handles().labels, &rest)?;
    let address = receiver.address();
    if !ui.is_quiet() {
        ui.line(&format!("listening at {address} for {}", human::counted(frames, "frame")));
    }
    let patience = args.live.timeout.unwrap_or(PATIENCE);
    let ended = interrupt::recording_ended;
    let recorded = interrupt::end_of_recording(|| {
        record(&mut receiver, &rig.handles().labels, frames, patience, &ended, ui)
    });
    ui.clear();
    let recording = recorded?;
    if recording.unseen.len() == rig.handles().labels.len() {
        return Err(Error::network(format!(
            "{address}: no frame has a marker of the rig's {}, expected labels such as {}; see `rhytid info {}`",
            human::counted(rig.handles().labels.len(), "handle"),
            rig.handles().labels.first().map_or("", String::as_str),
            args.rig.display()
        )));
    }
    if let Some(path) = &args.live.record {
        take::write(path, &recording.take)?;
    }
    let received = format!("{address}: {}", summary(&recording, receiver.counts()));
    match (args.json.wanted, ui.is_quiet()) {
        (_, true) => {}
        // Standard output has the JSON alone.
        (true, false) => ui.line(&received),
        (false, false) => output::say(&received)?,
    }
    let shortfall = frames - recording.take.frames();
    if recording.timed_out && shortfall > 0 {
        log::warn!(
            "no frame arrived for {} s: the recording lacks the last {}",
            patience.as_secs_f64(),
            human::counted(shortfall, "frame")
        );
    }
    warn(&recording, rig);
    Ok(recording.take)
}

/// Warns about positions that were never received, and about positions in another space.
fn warn(recording: &Recording, rig: &Rig) {
    if !recording.unseen.is_empty() {
        let listed = recording.unseen.iter().take(LABELS).map(String::as_str).collect::<Vec<_>>().join(", ");
        let more = if recording.unseen.len() > LABELS { ", …" } else { "" };
        log::warn!(
            "{} of the rig's {} were in no frame and stay at rest: {listed}{more}",
            recording.unseen.len(),
            human::counted(rig.handles().labels.len(), "handle")
        );
    }
    if let Some(misfit) = misfit(&recording.take, &Target::from_rig(rig)) {
        log::warn!(
            "the received positions do not fit the rig: {misfit}; send positions in the mesh's unit and \
             axes, without the head's motion"
        );
    }
}

/// What was received, in one line.
fn summary(recording: &Recording, counts: Counts) -> String {
    let mut latency = recording.latency.clone();
    latency.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let latency = latency.get(((latency.len() - 1) as f64 * share).round() as usize);
        latency.map_or(f64::NAN, |seconds| 1e3 * seconds)
    };
    let times = &recording.take.times;
    let lasted = times.last().zip(times.first()).map_or(0.0, |(last, first)| last - first);
    format!(
        "{} over {lasted:.3} s, {} lost, {} late, {} bad; latency {:.2} ms in the median, {:.2} ms in 95 %, {:.2} ms at most, beyond the fastest frame's",
        human::counted(recording.take.frames(), "frame"),
        counts.lost,
        counts.late,
        counts.bad,
        at(0.5),
        at(0.95),
        at(1.0)
    )
}
