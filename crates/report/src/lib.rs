//! Self-contained HTML pages, each with its data as JSON.
//!
//! - The page of a clean-up describes a raw take and its changes ([`write()`], `docs/report.md`).
//! - The page of an evaluation describes the quality of a rig ([`write_evaluation`], `docs/evaluate.md`).
//! - The page of a plan lists the frames to scan ([`write_plan`], `docs/coverage.md`).
//! - The page of a folder of takes ranks them by what is wrong with them ([`write_takes`], `docs/export.md`).
//! - The page of a transfer describes the correspondence of two faces ([`write_transfer`],
//!   `docs/transfer.md`).
//!
//! ```
//! use rhytid_capture::{Cleaned, Settings, Target, clean};
//! use rhytid_core::{NoProgress, RawTake};
//!
//! # let face = rhytid_demo::face(1_000);
//! # let rig = rhytid_solve::solve(&face, &NoProgress)?.rounded()?;
//! # let raw = RawTake { tracks: rhytid_demo::performance(&face), in_head_space: true, ..RawTake::default() };
//! # let folder = tempfile::tempdir().unwrap();
//! # let folder = folder.path();
//! // `rig` from rhytid_core::rig_file, `raw` from rhytid_formats::raw_take.
//! let Cleaned { take, report } = clean(raw, &Target::from_rig(&rig), &Settings::default(), &NoProgress)?;
//! // Without pictures; a `Painter` draws them.
//! let page = rhytid_report::Page { folder, title: "Anna" };
//! rhytid_report::write(page, "session.c3d", &report, &take, &rig, None)?;
//! assert!(folder.join("report.html").is_file() && folder.join("report.json").is_file());
//! # Ok::<(), rhytid_core::Error>(())
//! ```
#![forbid(unsafe_code)]

#[cfg(feature = "render")]
mod behind;
mod curve;
mod document;
mod evaluation;
mod events;
#[cfg(feature = "render")]
mod handles;
mod judgement;
mod map;
#[cfg(feature = "render")]
mod names;
mod opening;
mod page;
#[cfg_attr(not(feature = "render"), path = "no_painter.rs")]
mod painter;
mod picture;
mod plan;
mod plots;
mod shot;
mod skin;
mod strain;
mod summary;
mod takes;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_evaluation;
#[cfg(all(test, feature = "render"))]
mod tests_pictures;
#[cfg(test)]
mod tests_takes;
mod timeline;
mod transfer;
mod written;

pub use evaluation::write_evaluation;
#[cfg(feature = "render")]
pub use handles::write_handles;
pub use painter::Painter;
#[cfg(not(feature = "render"))]
pub use painter::write_handles;
pub use plan::write_plan;
use rhytid_capture::Report;
use rhytid_core::{Error, Result, Rig, Take};
use serde::Serialize;
use strain::Strains;
use summary::Summary;
pub use takes::{MadeFrom, Outcome, Run, TakeOutcome, Takes, write_takes};
pub use transfer::write_transfer;
pub use written::Page;
use written::write_texts;

/// `report.json`: the keys of [`Report`], and those that the page adds.
#[derive(Serialize)]
struct Document<'a> {
    title: &'a str,
    summary: &'a Summary,
    strains: &'a [strain::Edge],
    #[serde(flatten)]
    report: &'a Report,
}

/// Writes `report.html` and `report.json` to the folder of `page`.
///
/// `name` is that of the take. `take` is the result of the clean-up, at any rate. Without a `painter`, the
/// page has a sentence in place of its pictures.
///
/// # Errors
/// [`Error::Io`] if a file cannot be written. [`Error::Device`] and [`Error::Input`] if the painter cannot
/// draw. [`Error::Internal`] if report, take and rig do not belong together.
pub fn write(
    page: Page<'_>,
    name: &str,
    report: &Report,
    take: &Take,
    rig: &Rig,
    painter: Option<&Painter>,
) -> Result<()> {
    check(report, rig)?;
    let strains = Strains::new(take, rig)?;
    let summary = Summary::new(report, take);
    let heading = page::Heading { title: page.title, take: name };
    let html = page::page(heading, &summary, &strains, report, take, rig, painter)?;
    let document = Document { title: name, summary: &summary, strains: &strains.edges, report };
    let json =
        serde_json::to_string(&document).map_err(|e| Error::Internal(format!("the report as JSON: {e}")))?;
    write_texts(page.folder, [("report.html", html), ("report.json", json)])
}

/// Checks that the report's frames have times, and that every index in the report is in range.
fn check(report: &Report, rig: &Rig) -> Result<()> {
    let handles = rig.handles().labels.len();
    let markers = |event: &rhytid_capture::Event| event.marker.into_iter().chain(event.other);
    let fault = if !(report.rate.is_finite() && report.rate > 0.0 && report.start.is_finite()) {
        "its frames have no times"
    } else if report.labels != rig.handles().labels {
        "its labels are not the rig's"
    } else if report.setup.markers.len() != handles || report.setup.offsets_mm.len() != handles {
        "its set-up has not one entry a handle"
    } else if report.events.iter().any(|event| markers(event).any(|marker| marker >= handles)) {
        "an event is of no handle"
    } else if report
        .events
        .iter()
        .any(|e| e.first.checked_add(e.frames).is_none_or(|end| end > report.frames))
    {
        "an event ends after the take"
    } else {
        return Ok(());
    };
    Err(Error::Internal(format!("the report of the clean-up: {fault}")))
}
