//! `rhytid stitch`

use crate::progress::{Ui, timed};
use crate::{args, output};
use rhytid::Result;
use rhytid::core::human;
use rhytid::formats::usd;

/// Writes the file that plays the parts one after the other, and prints a summary.
///
/// # Errors
/// As [`usd::stitch`].
pub(super) fn run(args: &args::Stitch, ui: &Ui) -> Result<()> {
    let (stitched, time) = timed(|| usd::stitch(&args.parts, &args.output));
    let stitched = stitched?;
    let [start, end] = stitched.time_codes;
    let summary = serde_json::json!({
        "file": args.output,
        "bytes": stitched.bytes,
        "frames": stitched.frames,
        "parts": stitched.parts,
        "time_codes": stitched.time_codes,
        "manifest": stitched.manifest,
        "seconds": time.as_secs_f64(),
    });
    output::done(args.json, ui, &summary, || {
        format!(
            "{}: {} in {}, time codes {start} to {end}, {}, stitched in {}\n\
             Keep the parts and {} where they are: the file refers to them.",
            args.output.display(),
            human::counted(stitched.frames, "frame"),
            human::counted(stitched.parts, "part"),
            human::bytes(stitched.bytes),
            human::duration(time),
            stitched.manifest.display()
        )
    })
}
