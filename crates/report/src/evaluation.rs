//! The page of an evaluation: the quality of a rig, and where it is low.

use crate::document::document;
use crate::map::{self, figures};
use crate::painter::Painter;
use crate::shot::left_out;
use crate::written::write_texts;
use maud::{Markup, html};
use rhytid_core::{Error, Result, Rig, human};
use rhytid_evaluate::{Comparison, Errors, Evaluation, LeaveOneOut, Map, RegionError, Subject};
use std::path::Path;

/// The number of regions that are named for one example.
const NAMED: usize = 3;

/// The number of regions that are listed at first.
const REGIONS: usize = 10;

/// Writes `evaluation.html` and `evaluation.json` to the folder `dir`, which is created if necessary. `maps`
/// are of `rig`. Without a `painter`, the page has a sentence in place of the maps.
///
/// # Errors
/// [`Error::Io`] if a file cannot be written. [`Error::Device`] and [`Error::Input`] if the painter cannot
/// draw. [`Error::Internal`] if a map has other vertices than the rig.
pub fn write_evaluation(
    dir: &Path,
    found: &Evaluation,
    maps: &[Map],
    rig: &Rig,
    painter: Option<&Painter>,
) -> Result<()> {
    if maps.iter().any(|map| map.values.len() != rig.vertices()) {
        return Err(Error::Internal("a map of the evaluation has other vertices than the rig".into()));
    }
    let page = page(found, maps, rig, painter)?;
    let json =
        serde_json::to_string(found).map_err(|e| Error::Internal(format!("the evaluation as JSON: {e}")))?;
    write_texts(dir, [("evaluation.html", page), ("evaluation.json", json)])
}

fn page(found: &Evaluation, maps: &[Map], rig: &Rig, painter: Option<&Painter>) -> Result<String> {
    let about = html! {
        "Evaluation of the rig: " (human::count(found.vertices)) " vertices, " (human::counted(found.handles, "handle"))
        ", " (human::counted(rig.examples().len(), "example"))
    };
    let drawn = painter.map(|painter| drawn(maps, rig, painter)).transpose()?;
    let [left_out_maps, noise, truth] = drawn.unwrap_or_default();
    let main = html! {
        @if painter.is_none() { (left_out()) }
        @if let Some(comparisons) = &found.truth {
            section {
                h2 { "Distance from the truth" }
                p { "The tables cover all frames of the truth. “learned” and “chapter” are the rig by either method. “shell” is the thin "
                    "shell alone, which no example influences. “blendshapes” mixes the examples with weights from 0 to 1, and “components” "
                    "mixes their principal components with any weights. “components+shell” adds the shell, moved by what that leaves of "
                    "the markers. The wrinkle band is the RMS error without its smooth part." }
                (methods(comparisons))
                (method_regions(comparisons))
                (truth)
            }
        }
        section {
            h2 { "Error of examples that are left out" }
            @match &found.leave_one_out {
                Some(errors) => {
                    p { "Each example is left out in turn, and the others predict its smooth part. The table shows the error of this "
                        "prediction, over the skin by area. The level is pessimistic, because each example is far from the others. "
                        "Another scan helps most where the error is large." }
                    (examples(errors))
                    (left_out_maps)
                }
                None => p { "Only a rig of the learned method has these numbers, and only with examples." }
            }
        }
        section {
            h2 { "Effect of marker noise" }
            p { "Every marker gets " (found.noise.noise_mm) " mm of noise per axis, at rest and in the examples. The skin then moves by "
                (mm(found.noise.errors.rms_mm)) " mm RMS, and by " (mm(found.noise.errors.worst_mm)) " mm at most." }
            (noise)
        }
    };
    Ok(document(&found.name, &about, &main))
}

/// The maps of left-out examples, of noise and of the truth. Each kind has one scale.
fn drawn(maps: &[Map], rig: &Rig, painter: &Painter) -> Result<[Markup; 3]> {
    let subjects = [Subject::LeaveOneOut, Subject::Noise, Subject::Truth];
    let of = |subject| maps.iter().filter(move |map| map.subject == subject);
    let end_of = |subject| map::end(of(subject).map(|map| map.values.as_slice()));
    let all = subjects.into_iter().flat_map(|subject| {
        let end = end_of(subject);
        of(subject).map(move |map| map::Map {
            title: html! { (map.title) },
            positions: &rig.surface().rest,
            values: map.values.clone(),
            end,
            markers: false,
        })
    });
    let mut figures = figures(painter, rig, &all.collect::<Vec<_>>())?.into_iter();
    Ok(subjects.map(|subject| {
        let figures: Vec<Markup> = figures.by_ref().take(of(subject).count()).collect();
        let end = format!("{:.2} mm and more", end_of(subject));
        html! {
            (map::scale(painter, ["0", &end]))
            div.maps { @for figure in &figures { (figure) } }
        }
    }))
}

fn methods(comparisons: &[Comparison]) -> Markup {
    html! {
        table {
            thead { tr {
                th { "method" } @for name in ["RMS", "95 %", "99.9 %", "worst", "wrinkle band"] { th.number { (name) } }
            } }
            tbody {
                @for Comparison { method, errors, wrinkle_band_rms_mm } in comparisons {
                    tr {
                        th { (method) }
                        @for value in [errors.rms_mm, errors.p95_mm, errors.p99_9_mm, errors.worst_mm, *wrinkle_band_rms_mm] {
                            td.number { (mm(value)) }
                        }
                    }
                }
            }
        }
        p { "All numbers are in millimetres." }
    }
}

/// The RMS error of each region by each method. The regions are in the order of the first method's.
fn method_regions(comparisons: &[Comparison]) -> Markup {
    let Some(first) = comparisons.first() else { return html! {} };
    let of = |errors: &Errors, region: &str| {
        errors.regions.iter().find(|r| r.region == region).map_or("–".to_owned(), |r| mm(r.rms_mm))
    };
    let (shown, others) = first.errors.regions.split_at(first.errors.regions.len().min(REGIONS));
    let rows = |regions: &[RegionError]| {
        html! {
            table {
                thead { tr { th { "region (RMS)" } @for c in comparisons { th.number { (c.method) } } } }
                tbody {
                    @for region in regions {
                        tr {
                            th { (region.region) }
                            @for c in comparisons { td.number { (of(&c.errors, &region.region)) } }
                        }
                    }
                }
            }
        }
    };
    html! {
        (rows(shown))
        @if !others.is_empty() {
            details { summary { (human::counted(others.len(), "more region")) } (rows(others)) }
        }
    }
}

fn examples(left_out: &LeaveOneOut) -> Markup {
    let row = |name: &str, errors: &Errors, shell: f64| {
        let worst = errors.regions.iter().take(NAMED);
        let worst: Vec<String> = worst.map(|r| format!("{} {}", r.region, mm(r.rms_mm))).collect();
        html! { tr {
            th { (name) } td.number { (mm(errors.rms_mm)) } td.number { (mm(shell)) } td.number { (mm(errors.p95_mm)) }
            td.number { (mm(errors.worst_mm)) } td { (worst.join(", ")) }
        } }
    };
    html! {
        table {
            thead { tr { th { "left-out example" } th.number { "RMS" } th.number { "of the shell" } th.number { "95 %" } th.number { "worst" }
                th { "worst regions" } } }
            tbody {
                (row("any of them", &left_out.all, left_out.shell_rms_mm))
                @for example in &left_out.examples { (row(&example.example, &example.errors, example.shell_rms_mm)) }
            }
        }
        @if !left_out.faded.is_empty() {
            p { "The linear band is faded to the shell around these handles: left-out examples are hardly better with it there. "
                "The list says how much of it is kept." }
            ul.plain { @for faded in &left_out.faded { li { (faded.handle) ", " (format!("{:.0} %", 100.0 * faded.kept)) } } }
        }
        p { "All numbers are in millimetres." }
    }
}

fn mm(value: f64) -> String {
    format!("{value:.3}")
}
