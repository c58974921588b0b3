//! The tables of changes, and of the marker of each handle.

use maud::{Markup, html};
use rhytid_capture::{Event, Kind, Report};
use rhytid_core::human;
use std::collections::BTreeMap;

/// The most rows of one kind of event: a browser is slow with more, and nobody reads them.
const SHOWN: usize = 1000;

/// Every event, in the report's order.
pub(crate) fn events(report: &Report) -> Markup {
    let mut counts: BTreeMap<Kind, usize> = BTreeMap::new();
    let mut first_of_its_kind = |event: &&Event| {
        let count = counts.entry(event.kind).or_default();
        *count += 1;
        *count <= SHOWN
    };
    let shown: Vec<&Event> = report.events.iter().filter(&mut first_of_its_kind).collect();
    let left_out = report.events.len() - shown.len();
    html! {
        @if shown.is_empty() {
            p { "Nothing was changed. Every sample is as it was measured." }
        } @else {
            div.scroll {
                table.events {
                    thead { tr {
                        th scope="col" { "event" }
                        th scope="col" { "marker" }
                        th.number scope="col" { "first frame" }
                        th.number scope="col" { "frames" }
                        th.number scope="col" { "time" }
                        th.number scope="col" { "duration" }
                        th.number scope="col" { "confidence" }
                        th.number scope="col" { "distance" }
                    } }
                    tbody { @for event in shown { (row(event, report)) } }
                }
            }
            @if left_out > 0 {
                p.note {
                    (human::count(left_out)) " more are in report.json: the table has the first "
                    (human::count(SHOWN)) " of each kind."
                }
            }
        }
    }
}

fn row(event: &Event, report: &Report) -> Markup {
    let time = report.start + event.first as f64 / report.rate;
    html! {
        tr {
            td { (event.kind.name()) }
            td {
                @match event.marker { Some(marker) => (report.labels[marker]), None => i { "head" } }
                @if let Some(other) = event.other { " ↔ " (report.labels[other]) }
            }
            td.number { (event.first) }
            td.number { (event.frames) }
            td.number { (format!("{time:.3} s")) }
            td.number { (format!("{:.3} s", event.frames as f64 / report.rate)) }
            td.number { (format!("{:.2}", event.confidence)) }
            td.number { @if let Some(mm) = event.distance_mm { (format!("{mm:.1} mm")) } }
        }
    }
}

/// The marker of each handle, and the unused labels.
pub(crate) fn mapping(report: &Report) -> Markup {
    let found = &report.setup;
    html! {
        div.scroll {
            table.mapping {
                thead { tr {
                    th scope="col" { "handle" }
                    th scope="col" { "label in the file" }
                    th.number scope="col" { "offset at neutral" }
                } }
                tbody {
                    @for ((label, marker), offset) in report.labels.iter().zip(&found.markers).zip(&found.offsets_mm) {
                        tr {
                            td { (label) }
                            td { @match marker { Some(marker) => (marker), None => strong { "none" } } }
                            td.number { @if let Some(mm) = offset { (format!("{mm:.2} mm")) } }
                        }
                    }
                }
            }
        }
        (labels("The head’s motion was fitted to", &found.rigid))
        (labels("Unused labels", &found.unused))
    }
}

fn labels(what: &str, labels: &[String]) -> Markup {
    html! {
        @if !labels.is_empty() {
            p { (what) ": " @for (i, label) in labels.iter().enumerate() { @if i > 0 { ", " } code { (label) } } "." }
        }
    }
}
