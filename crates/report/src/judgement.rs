//! Whether a clean take can be used, and what a person should look at first.

use crate::opening::Finding;
use crate::picture::Views;
use crate::strain::Strains;
use crate::summary::Summary;
use maud::html;
use rhytid_capture::{Event, Kind, Report};
use rhytid_core::human;

/// With a larger part of lost samples, a take is not to be used as it is.
const MOST_LOST: f64 = 0.05;

/// Whether the take can be used, and what to do otherwise.
pub(crate) fn verdict(summary: &Summary, report: &Report) -> String {
    let part = |n: usize| n as f64 / summary.samples.max(1) as f64;
    let lost = part(summary.states.lost);
    let measured = percent(part(summary.states.measured));
    let doubtful = doubtful(report).len();
    if summary.samples == 0 {
        return "The take is empty.".to_owned();
    }
    if lost > MOST_LOST {
        return format!(
            "Do not use the take as it is: {} of its samples are lost. Label or fill the markers below in the capture system.",
            percent(lost)
        );
    }
    match doubtful {
        0 => format!("The take can be used: {measured} of its samples are as measured, and none is lost."),
        n => format!(
            "The take can be used, but look at {} first. {measured} of its samples are as measured, and {} are lost.",
            human::counted(n, "marker"),
            if lost > 0.0 { percent(lost) } else { "none".to_owned() }
        ),
    }
}

/// A share that is 0 or 100 only if it is exactly that.
fn percent(part: f64) -> String {
    match 100.0 * part {
        p if p > 0.0 && p < 0.1 => "under 0.1 %".to_owned(),
        p if p > 99.9 && p < 100.0 => "over 99.9 %".to_owned(),
        p => format!("{} %", human::number((10.0 * p).round() / 10.0)),
    }
}

/// A marker that is lost or moves as no skin does.
struct Doubtful<'a> {
    label: &'a str,
    /// The longest of its events.
    worst: &'a Event,
    /// The frames of all of them.
    frames: usize,
}

/// The markers that a person should look at, those with the most such frames first.
fn doubtful(report: &Report) -> Vec<Doubtful<'_>> {
    let mut found: Vec<Option<Doubtful<'_>>> = report.labels.iter().map(|_| None).collect();
    let is_doubtful =
        |kind| matches!(kind, Kind::Lost | Kind::NeverSeen | Kind::Left | Kind::Strain | Kind::Step);
    for event in report.events.iter().filter(|event| is_doubtful(event.kind)) {
        let Some(marker) = event.marker else { continue };
        let of_marker =
            found[marker].get_or_insert(Doubtful { label: &report.labels[marker], worst: event, frames: 0 });
        of_marker.frames += event.frames;
        if event.frames > of_marker.worst.frames {
            of_marker.worst = event;
        }
    }
    let mut found: Vec<Doubtful<'_>> = found.into_iter().flatten().collect();
    found.sort_by_key(|found| std::cmp::Reverse(found.frames));
    found
}

/// What matters most: doubtful markers, then what was assumed, then the largest strain.
pub(crate) fn findings(report: &Report, strains: &Strains, views: Option<&Views>) -> Vec<Finding> {
    let mut findings = Vec::new();
    for Doubtful { label, worst, frames } in doubtful(report).into_iter().take(2) {
        let time = |frame: usize| report.start + frame as f64 / report.rate;
        let what = match worst.kind {
            Kind::NeverSeen => "is never seen, and goes with its neighbours",
            Kind::Strain => "is farther from a neighbour than skin stretches",
            Kind::Step => "moves faster than skin does",
            _ => "is lost",
        };
        findings.push(Finding {
            words: html! {
                b { "Marker " (label) " " (what) "." }
                @if worst.kind != Kind::NeverSeen {
                    " It concerns " (human::counted(frames, "frame")) ", the longest stretch from frame " (worst.first) ", "
                    (format!("{:.2} s", time(worst.first))) "."
                }
            },
            picture: None,
        });
    }
    findings.extend(
        report
            .warnings
            .iter()
            .map(|warning| Finding { words: html! { (warning.sentence()) }, picture: None }),
    );
    // The largest strain has a picture, and one place of the three.
    findings.truncate(2);
    if let Some(edge) = strains.edges.first().filter(|edge| edge.peak() != 0.0) {
        let strain = format!("{:+.0} %", 100.0 * edge.peak()).replace('-', "−");
        findings.push(Finding {
            words: html! {
                b { "Largest strain: " (edge.a) " – " (edge.b) ", " (strain) }
                " in frame " (edge.frame) " of the clean take, " (format!("{:.2} s", edge.time)) ". Check that the actor did that."
            },
            picture: views.map(|views| views.again.clone()),
        });
    }
    findings
}
