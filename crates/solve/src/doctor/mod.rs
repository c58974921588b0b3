//! The mesh doctor. It reports what would harm a solve before the solve starts.
mod examples;
mod finding;
mod handles;
mod impossible;
mod parts;
mod points;
mod space;
mod surface;
mod unit;
mod words;

pub use finding::{Finding, Report, Severity};
pub use space::{ExampleSpace, example_spaces};

use crate::mirror::with_mirror_images;
use rhytid_core::{Face, Result};

/// Examines a face for everything that would harm its solve. Errors make the solve impossible. With errors,
/// the finer checks are left out, because they need a whole mesh.
pub fn examine(face: &Face) -> Report {
    let mut report = Report::default();
    impossible::examine(face, &mut report);
    // The solve reports it in the same words.
    if !report.has_errors()
        && let Err(e) = with_mirror_images(face)
    {
        report.add(Severity::Error, "no-mirror-image", e.to_string());
    }
    if !report.has_errors() {
        surface::examine(face, &mut report);
        let diagonal = unit::examine(face, &mut report);
        handles::examine(face, &mut report);
        examples::examine(face, diagonal, &mut report);
    }
    report.findings.sort_by_key(|f| std::cmp::Reverse(f.severity));
    report
}

/// Fails with the first error of [`examine`], without looking for anything else.
///
/// # Errors
/// [`rhytid_core::Error::Input`].
pub fn check(face: &Face) -> Result<()> {
    let mut report = Report::default();
    impossible::examine(face, &mut report);
    report.findings.into_iter().next().map_or(Ok(()), |finding| Err(finding.error()))
}
