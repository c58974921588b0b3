//! The timeline: the state of each marker, frame by frame, in a row for each marker, drawn in runs.

use crate::curve;
use crate::summary::Summary;
use maud::{Markup, PreEscaped, html};
use rhytid_capture::{Event, Kind, Report};
use rhytid_core::human;

/// The width and height of a row's picture, in its own units. The page stretches it.
const WIDTH: f64 = 1000.0;
const HEIGHT: f64 = 14.0;
/// The least width of a run, so that one frame of a long take is visible.
const LEAST: f64 = 3.0;
/// With more events than this, runs have no tooltip with their frames.
const EXPLAINED: usize = 10_000;

/// The look of a kind of event.
///
/// Heights tell kinds apart without colour. Filled runs stand at the bottom, and are higher the less they can
/// be trusted. Corrected runs hang from the top.
pub(crate) struct Look {
    pub kind: Kind,
    /// The style sheet's class.
    class: &'static str,
    meaning: &'static str,
    top: f64,
    bottom: f64,
}

/// All kinds, in the order in which they are drawn over each other.
pub(crate) const LOOKS: [Look; 15] = [
    look(Kind::FilledBefore, "before", "by the capture system", 10.0, HEIGHT),
    look(Kind::Spline, "spline", "a short gap, filled by a curve", 7.0, HEIGHT),
    look(Kind::Model, "model", "a longer gap, filled from the other markers", 4.0, HEIGHT),
    look(Kind::Head, "head", "the head’s motion comes from the face, or is held", 4.0, HEIGHT),
    look(Kind::Lost, "lost", "a gap past the limit; do not trust it", 0.0, HEIGHT),
    look(Kind::NeverSeen, "never", "the marker moves with its neighbours", 0.5, HEIGHT - 0.5),
    look(Kind::Left, "left", "a gap that the setup left open", 0.0, HEIGHT),
    look(Kind::Swap, "swap", "two labels were exchanged; exchanged back", 0.5, 6.0),
    look(Kind::Shuffled, "shuffled", "labels changed places; put right, or dropped and filled", 0.5, 6.0),
    look(Kind::Slide, "slide", "the label left its marker; cut out and filled", 0.0, 6.0),
    look(Kind::Dropped, "dropped", "by hand, then filled", 0.0, 6.0),
    look(Kind::Held, "held", "by hand", 4.0, HEIGHT),
    look(Kind::Strain, "strain", "an edge longer than skin stretches; not changed", 7.0, HEIGHT),
    look(Kind::Step, "step", "faster than skin moves; not changed", 7.0, HEIGHT),
    look(Kind::Outlier, "outlier", "the marker jumped away; dropped and filled", 0.0, 6.0),
];

const fn look(kind: Kind, class: &'static str, meaning: &'static str, top: f64, bottom: f64) -> Look {
    Look { kind, class, meaning, top, bottom }
}

impl Look {
    /// A rectangle in a row's picture.
    fn bar(&self, from: f64, to: f64, title: Option<&str>) -> Markup {
        html! {
            rect class=(self.class) x=(short(from)) y=(self.top) width=(short(to - from)) height=(self.bottom - self.top) {
                @if let Some(title) = title { title { (title) } }
            }
        }
    }
}

/// The colours of the kinds that occur, with their meanings.
pub(crate) fn legend(summary: &Summary) -> Markup {
    html! {
        ul.legend {
            li { span.neutral {} b { "neutral" } ": frames with the face at rest" }
            li { (swatch(&PreEscaped(String::new()))) b { "measured" } }
            @for look in LOOKS.iter().filter(|look| summary.count(look.kind) > 0) {
                li { (swatch(&look.bar(1.0, 27.0, None))) b { (look.kind.name()) } ": " (look.meaning) }
            }
        }
    }
}

fn swatch(content: &Markup) -> Markup {
    html! { svg.swatch viewBox={ "0 0 28 " (HEIGHT) } aria-hidden="true" { (content) } }
}

/// The table: the head, and then a row for each marker in the rig's order.
pub(crate) fn timeline(report: &Report) -> Markup {
    let mut rows: Vec<Vec<&Event>> = vec![Vec::new(); report.labels.len()];
    for event in &report.events {
        for marker in event.marker.into_iter().chain(event.other) {
            rows[marker].push(event);
        }
    }
    let head: Vec<&Event> = report.events.iter().filter(|event| event.marker.is_none()).collect();
    html! {
        table.timeline {
            thead { tr {
                th scope="col" { "marker" }
                th scope="col" { (axis(report)) }
                th.number scope="col" { "not measured" }
            } }
            tbody {
                tr.rigid { (row("head", &head, report)) }
                @for (label, events) in report.labels.iter().zip(&rows) {
                    tr.marker { (row(label, events, report)) }
                }
            }
        }
    }
}

fn row(label: &str, events: &[&Event], report: &Report) -> Markup {
    let share = unmeasured(events) as f64 / report.frames.max(1) as f64;
    html! {
        th scope="row" title=(label) { (label) }
        td {
            svg viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } preserveAspectRatio="none" {
                @for look in &LOOKS {
                    @for run in runs(events, look.kind, report) { (run.bar(look, report)) }
                }
            }
        }
        td.number { (percent(share)) }
    }
}

/// A share in per cent; empty where it is 0.
fn percent(share: f64) -> String {
    match 100.0 * share {
        0.0 => String::new(),
        small if small < 0.1 => "< 0.1 %".to_owned(),
        percent => format!("{percent:.1} %"),
    }
}

/// The number of frames in which a marker was not measured, or was not where the file says.
fn unmeasured(events: &[&Event]) -> usize {
    let mut spans: Vec<(usize, usize)> = events.iter().map(|e| (e.first, e.first + e.frames)).collect();
    spans.sort_unstable();
    let (mut frames, mut seen) = (0, 0);
    for (first, end) in spans {
        frames += end.saturating_sub(first.max(seen));
        seen = seen.max(end);
    }
    frames
}

/// Events of one kind that are one bar, because they touch at the picture's width.
struct Run {
    first: usize,
    end: usize,
    events: usize,
}

fn runs(events: &[&Event], kind: Kind, report: &Report) -> Vec<Run> {
    let mut spans: Vec<(usize, usize)> =
        events.iter().filter(|e| e.kind == kind).map(|e| (e.first, e.first + e.frames)).collect();
    spans.sort_unstable();
    let frame = report.frames.max(1) as f64 / WIDTH;
    let mut runs: Vec<Run> = Vec::new();
    for (first, end) in spans {
        match runs.last_mut() {
            Some(run)
                if (first as f64) < (run.end as f64).max(run.first as f64 + LEAST * frame) + 0.5 * frame =>
            {
                run.end = run.end.max(end);
                run.events += 1;
            }
            _ => runs.push(Run { first, end, events: 1 }),
        }
    }
    runs
}

impl Run {
    fn bar(&self, look: &Look, report: &Report) -> Markup {
        let x = |frame: usize| frame as f64 * WIDTH / report.frames.max(1) as f64;
        let to = x(self.end).max(x(self.first) + LEAST);
        // At the end of the take, a widened bar would be cut off.
        let from = x(self.first).min(WIDTH - LEAST);
        let title = (report.events.len() <= EXPLAINED).then(|| self.title(look, report));
        look.bar(from, to.min(WIDTH), title.as_deref())
    }

    fn title(&self, look: &Look, report: &Report) -> String {
        let times = self.events;
        let often = if times == 1 { String::new() } else { format!(", {times} times") };
        let frames = match self.end.saturating_sub(1) {
            last if last > self.first => format!("frames {} to {last}", self.first),
            last => format!("frame {last}"),
        };
        let seconds = report.start + self.first as f64 / report.rate;
        format!("{}{often}: {frames}, from {seconds:.3} s", look.kind.name())
    }
}

/// The scale of seconds above the rows, with the neutral frames.
fn axis(report: &Report) -> Markup {
    let end = report.start + report.frames as f64 / report.rate;
    let percent = |time: f64| short(100.0 * (time - report.start) / (end - report.start));
    let at = |frame: usize| short(100.0 * frame as f64 / report.frames.max(1) as f64);
    let neutral = &report.setup.neutral;
    html! {
        div.axis {
            @if !neutral.is_empty() {
                span.neutral title={ "neutral: frames " (neutral.start) " to " (neutral.end - 1) }
                    style={ "left:" (at(neutral.start)) "%;width:" (at(neutral.len())) "%" } {}
            }
            // At the right end there is no room for a number.
            @for time in curve::ticks([report.start, end], 10).into_iter().filter(|time| end - time > 0.05 * (end - report.start)) {
                span.tick style={ "left:" (percent(time)) "%" } { (human::number(time)) " s" }
            }
        }
    }
}

/// A coordinate with two decimals at most.
fn short(x: f64) -> String {
    let text = format!("{x:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
