//! `rhytid send`

use crate::progress::Ui;
use crate::{args, inputs, output};
use rhytid::core::{human, rig_file};
use rhytid::formats::take::{self, Missing};
use rhytid::formats::{FileKind, raw_take};
use rhytid::live::Sender;
use rhytid::{Error, Progress, Result};
use std::time::Instant;

/// Sends a take, and says what was sent.
///
/// # Errors
/// [`Error::Input`] and [`Error::Io`] from reading and sending; [`Error::Cancelled`] if it was stopped before
/// the take's end.
pub(super) fn run(args: &args::Send, ui: &Ui) -> Result<()> {
    inputs::expect(&args.take, &[FileKind::Take, FileKind::RawTake], "rhytid send TAKE")?;
    if args.take.exists() && !raw_take::is_take_csv(&args.take) {
        return Err(Error::unsupported_format(format!(
            "{0}: is a raw take, expected a clean one; `rhytid prepare {0} --rig RIG -o clean.csv` makes it",
            args.take.display()
        )));
    }
    let rig = args.rig.as_deref().map(rig_file::read).transpose()?;
    let labels = rig.as_ref().map(|rig| rig.handles().labels.as_slice());
    let take = take::read(&args.take, labels, Missing::Leave)?;
    let take = take.slice(args.frames.within(take.frames())?);
    let sender = Sender::new(&take, args.rate, args.to)?;
    if !ui.is_quiet() && args.again {
        ui.line(&format!("sending to {} until Ctrl-C", args.to));
    }
    let start = Instant::now();
    let sent = sender.send((!args.again).then_some(1), ui)?;
    ui.clear();
    let time = start.elapsed();
    let summary = serde_json::json!({
        "to": args.to.to_string(),
        "frames": sent.frames,
        "markers": take.labels.len(),
        "seconds": time.as_secs_f64(),
        "largest_datagram_bytes": sent.bytes,
        "late_ms": 1e3 * sent.late,
    });
    output::done(args.json, ui, &summary, || {
        format!(
            "{}: {} of {} in {}, {} each at most, sent at most {:.2} ms behind their time",
            args.to,
            human::counted(sent.frames as usize, "frame"),
            human::counted(take.labels.len(), "marker"),
            human::duration(time),
            human::bytes(sent.bytes as u64),
            1e3 * sent.late
        )
    })?;
    if ui.cancelled() && !args.again { Err(Error::Cancelled) } else { Ok(()) }
}
