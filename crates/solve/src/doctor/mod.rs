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
use crate::welded::{Welded, named_by_first, points};
use rhytid_core::{Face, Result, VertexId, human};

/// Examines a face for everything that would harm its solve. Errors make the solve impossible. With errors,
/// the finer checks are left out, because they need a whole mesh.
pub fn examine(face: &Face) -> Report {
    let mut report = Report::default();
    let points = points(face);
    if let Some(points) = &points {
        report.add(
            Severity::Note,
            "joined-vertices",
            format!(
                "{} vertices are {} points of the surface: those on both sides of a cut are joined for the solve",
                human::count(points.of_vertex.len()),
                human::count(points.len())
            ),
        );
    }
    let named = points.map(|points| named_by_first(face, &points));
    let joined = named.as_ref().unwrap_or(face);
    impossible::examine(joined, &mut report);
    // The solve reports it in the same words.
    if !report.has_errors()
        && let Err(e) = mirrored(face)
    {
        report.add(Severity::Error, "no-mirror-image", e.to_string());
    }
    if !report.has_errors() {
        surface::examine(joined, &face.neutral.faces, &mut report);
        let diagonal = unit::examine(joined, &mut report);
        handles::examine(joined, &mut report);
        examples::examine(joined, diagonal, &mut report);
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
    let named = points(face).map(|points| named_by_first(face, &points));
    impossible::examine(named.as_ref().unwrap_or(face), &mut report);
    report.findings.into_iter().next().map_or(Ok(()), |finding| Err(finding.error()))
}

/// Whether the examples have the mirror images that they ask for.
fn mirrored(face: &Face) -> Result<()> {
    if !face.examples.iter().any(|example| example.mirror) {
        return Ok(());
    }
    match Welded::new(face) {
        Some(welded) => with_mirror_images(&welded.face, |v| welded.points.first[v]),
        None => with_mirror_images(face, VertexId::from_index),
    }
    .map(|_| ())
}
