//! The page of a clean-up.

use crate::document::document;
use crate::judgement;
use crate::opening::opening;
use crate::painter::Painter;
use crate::shot::left_out;
use crate::strain::{Edge, Strains};
use crate::summary::{Spread, Summary};
use crate::{events, picture, plots, timeline};
use maud::{Markup, PreEscaped, html};
use rhytid_capture::{Kind, Mark, Report};
use rhytid_core::{Result, Rig, Take, human};

/// The number of edges whose strain is plotted.
const EDGES: usize = 6;

/// Whom a clean-up is about.
pub(crate) struct Heading<'a> {
    pub title: &'a str,
    /// The take's name.
    pub take: &'a str,
}

/// The report as HTML.
///
/// # Errors
/// [`rhytid_core::Error::Internal`] from the plots. Otherwise as [`Painter::draw`].
pub(crate) fn page(
    heading: Heading<'_>,
    summary: &Summary,
    strains: &Strains,
    report: &Report,
    take: &Take,
    rig: &Rig,
    painter: Option<&Painter>,
) -> Result<String> {
    let plots = plots(summary, strains, report)?;
    let views = painter.map(|painter| picture::views(report, strains, take, rig, painter)).transpose()?;
    let about = html! { "Clean-up of the raw take " b { (heading.take) } };
    Ok(document(
        heading.title,
        &about,
        &html! {
            (opening(&judgement::verdict(summary, report), &judgement::findings(report, strains, views.as_ref())))
            (overview(summary, report))
            section {
                h2 { "Markers over time" }
                (timeline::legend(summary))
                (timeline::timeline(report))
            }
            (plots)
            section {
                h2 { "Markers on the rest mesh" }
                @match &views {
                    Some(views) => { (picture_key(strains)) (views.markup) }
                    None => (left_out())
                }
            }
            section { h2 { "What was changed" } (events::events(report)) }
            section { h2 { "Which marker is which" } (events::mapping(report)) }
        },
    ))
}

fn overview(summary: &Summary, report: &Report) -> Markup {
    html! {
        section.overview {
            (shares(summary))
            @if !report.warnings.is_empty() {
                ul.warnings { @for warning in &report.warnings { li { (warning.sentence()) } } }
            }
            dl { @for (name, value) in facts(summary, report) { div { dt { (name) } dd { (value) } } } }
        }
    }
}

/// The measured part of the take, as a bar and in numbers.
fn shares(summary: &Summary) -> Markup {
    let states = &summary.states;
    let named = [
        ("measured", states.measured),
        ("filled", states.filled),
        ("corrected", states.corrected),
        ("lost", states.lost),
    ];
    let percent = |n: usize| 100.0 * n as f64 / summary.samples.max(1) as f64;
    html! {
        div.shares aria-hidden="true" {
            @for (name, n) in named.iter().filter(|(_, n)| *n > 0) {
                span class=(name) style={ "flex-grow:" (format!("{:.3}", percent(*n))) } {}
            }
        }
        p.states {
            @for (name, n) in named {
                span class=(name) title={ (human::count(n)) " of " (human::counted(summary.samples, "sample")) } {
                    b { (share(n, percent(n))) } " " (name)
                }
            }
        }
    }
}

/// A share in per cent. It shows 0 or 100 only if it is exactly that.
fn share(n: usize, percent: f64) -> String {
    match percent {
        p if n > 0 && p < 0.01 => "< 0.01 %".to_owned(),
        p if (99.99..100.0).contains(&p) => "> 99.99 %".to_owned(),
        p => format!("{} %", human::number((p * 100.0).round() / 100.0)),
    }
}

/// The names of moments and their frames.
fn marks(marks: &[Mark]) -> String {
    match marks {
        [] => "none".to_owned(),
        marks => {
            let of = |mark: &Mark| format!("{} (frame {})", mark.name, mark.frame);
            marks.iter().map(of).collect::<Vec<_>>().join(", ")
        }
    }
}

fn facts(summary: &Summary, report: &Report) -> Vec<(&'static str, String)> {
    let found = &report.setup;
    let rate = human::number(report.rate);
    let clean_rate = human::number(summary.clean_rate);
    let guess = |is: bool| if is { " (guessed)" } else { "" };
    let mm = |spread: Option<Spread>| {
        spread.map_or("–".to_owned(), |s| format!("{:.2} mm RMS, {:.2} mm at most", s.rms, s.max))
    };
    let neutral = match &found.neutral {
        range if range.is_empty() => "none".to_owned(),
        range => {
            let seconds = report.start + range.start as f64 / report.rate;
            let how = if found.neutral_is_found { "found" } else { "given" };
            format!("frames {} to {}, from {seconds:.2} s ({how})", range.start, range.end - 1)
        }
    };
    let space = found.in_head_space;
    let mut facts = vec![
        (
            "Take",
            format!("{}, {} at {rate} Hz", duration(summary.seconds), human::counted(report.frames, "frame")),
        ),
        ("Markers", format!("{} of {}", summary.markers, human::counted(summary.handles, "handle"))),
        (
            "Corrected",
            format!(
                "{}, {}, {}",
                human::counted(summary.count(Kind::Swap), "label swap"),
                human::counted(summary.count(Kind::Outlier), "outlier"),
                human::counted(summary.count(Kind::Slide), "slide")
            ),
        ),
        (
            "Filled",
            format!(
                "{}, {}, {} by the capture system",
                human::counted(summary.count(Kind::Spline), "short gap"),
                human::counted(summary.count(Kind::Model), "longer gap"),
                human::counted(summary.count(Kind::FilledBefore), "gap")
            ),
        ),
        (
            "Lost",
            format!(
                "{} past the limit, {} never seen",
                human::counted(summary.count(Kind::Lost), "gap"),
                human::counted(summary.count(Kind::NeverSeen), "marker")
            ),
        ),
        ("Unit", format!("{}{}", human::unit(found.metres_per_unit), guess(found.unit_is_guessed))),
        (
            "File’s axes for x, y, z",
            format!("{}{}", found.axes.replace('-', "−"), guess(found.axes_are_guessed)),
        ),
        ("Actor’s size", format!("{:.2} % of the rig’s", 100.0 * found.scale)),
        ("Neutral", neutral),
        ("Time code of the first frame", report.timecode.clone().unwrap_or_else(|| "none".to_owned())),
        ("Marks in the file", marks(&report.marks)),
        ("Head fit", if space { "in head space already".to_owned() } else { mm(summary.head_residual_mm) }),
        ("Offsets at neutral", mm(summary.offset_mm)),
        ("Noise", format!("{:.3} mm RMS", report.noise_mm)),
        (
            "Low-pass filter",
            report.low_pass_hz.map_or("none".to_owned(), |hz| format!("{} Hz", human::number(hz))),
        ),
    ];
    if summary.clean_frames != report.frames || clean_rate != rate {
        let resampled = format!("{} at {clean_rate} Hz", human::counted(summary.clean_frames, "frame"));
        facts.insert(1, ("Resampled to", resampled));
    }
    facts
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{s:.2} s"),
        s => format!("{} min {:04.1} s", (s / 60.0).floor(), s % 60.0),
    }
}

fn plots(summary: &Summary, strains: &Strains, report: &Report) -> Result<Markup> {
    let head = plots::head(report)?;
    let offsets = plots::offsets(report)?;
    let worst = &strains.edges[..strains.edges.len().min(EDGES)];
    let worst: Vec<(&Edge, String)> =
        worst.iter().map(|edge| Ok((edge, plots::strain(strains, edge, worst)?))).collect::<Result<_>>()?;
    Ok(html! {
        section {
            h2 { "Fit of the head" }
            @match (&head, summary.head_residual_mm) {
                (Some(svg), Some(spread)) => {
                    p { "The curve is the RMS distance of the markers from where the head’s motion puts them. It is at most "
                        (format!("{:.2}", spread.max)) " mm." }
                    (plot(svg, "residual of the head fit in millimetres over time"))
                }
                _ => p { "The head’s motion was not fitted." }
            }
        }
        section {
            h2 { "Alignment with the rig" }
            @match &offsets {
                Some(svg) => {
                    p { "Each bar is the distance of a marker from its handle at neutral, before this offset was taken out. "
                        "If several neighbours stand out together, these markers are worn at other places than the handle "
                        "table says. A marker that stands out alone may be mislabelled." }
                    (plot(svg, "offset of each marker in millimetres, largest first"))
                }
                None => p { "No offset was measured." }
            }
        }
        section {
            h2 { "Largest strains" }
            @if worst.is_empty() {
                p { "The rig has no strain edges." }
            } @else {
                p { "The curves show the " (human::counted(worst.len(), "strain edge")) " with the largest change of length, in per cent of the length at rest. "
                    span.shaded { "Shaded" } " parts are those in which a marker of the edge was filled, corrected or lost." }
                @for (edge, svg) in &worst {
                    figure {
                        figcaption {
                            b { (edge.a) } " – " b { (edge.b) } ": "
                            (percent(edge.peak())) " at " (format!("{:.2} s", edge.time))
                        }
                        (plot(svg, "strain in per cent over time"))
                    }
                }
            }
        }
    })
}

fn plot(svg: &str, label: &str) -> Markup {
    html! { div.plot role="img" aria-label=(label) { (PreEscaped(svg)) } }
}

fn picture_key(strains: &Strains) -> Markup {
    html! {
        p {
            "Rings are the handles. Dots are the clean markers in the first neutral frame, so each dot belongs in its ring."
            @if let Some(edge) = strains.edges.first() {
                " Thin lines lead to where the markers are at " (format!("{:.2} s", edge.time)) ", the frame of the largest strain. That strain is "
                (percent(edge.peak())) ". The thick line is its edge, from " b { (edge.a) } " to " b { (edge.b) } "."
            }
        }
    }
}

/// A strain with its sign, in per cent.
fn percent(strain: f64) -> String {
    format!("{:+.1} %", 100.0 * strain).replace('-', "−")
}
