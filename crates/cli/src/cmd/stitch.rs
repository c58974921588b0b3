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
    if ui.is_quiet() {
        return Ok(());
    }
    let [start, end] = stitched.time_codes;
    output::say(&format!(
        "{}: {} in {}, time codes {start} to {end}, {}, stitched in {}; the parts and {} have to stay where they are",
        args.output.display(),
        human::counted(stitched.frames, "frame"),
        human::counted(stitched.parts, "part"),
        human::bytes(stitched.bytes),
        human::duration(time),
        stitched.manifest.display()
    ))
}
