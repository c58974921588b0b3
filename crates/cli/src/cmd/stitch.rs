//! `rhytid stitch`

use crate::progress::{Ui, timed};
use crate::{args, output};
use rhytid::Result;
use rhytid::core::human;
use rhytid::formats::usd;

/// Writes the file that plays the parts one after the other, and prints a summary.
///
/// # Errors
/// As [`usd::stitch()`] and [`usd::levels()`].
pub(super) fn run(args: &args::Stitch, ui: &Ui) -> Result<()> {
    if args.levels {
        return levels(args, ui);
    }
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

/// Writes the file with a variant for each level.
fn levels(args: &args::Stitch, ui: &Ui) -> Result<()> {
    let (levels, time) = timed(|| usd::levels(&args.parts, &args.output));
    let levels = levels?;
    let [start, end] = levels.time_codes;
    let summary = serde_json::json!({
        "file": args.output,
        "bytes": levels.bytes,
        "frames": levels.frames,
        "variants": levels.variants,
        "time_codes": levels.time_codes,
        "seconds": time.as_secs_f64(),
    });
    output::done(args.json, ui, &summary, || {
        format!(
            "{}: variants {}, {}, time codes {start} to {end}, {}, put together in {}\n\
             Keep the files where they are: this one refers to them.",
            args.output.display(),
            levels.variants.join(", "),
            human::counted(levels.frames, "frame"),
            human::bytes(levels.bytes),
            human::duration(time)
        )
    })
}
