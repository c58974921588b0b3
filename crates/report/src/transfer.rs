//! The page of a transfer: which places of two faces correspond, how well, and where there is no counterpart.

use crate::document::document;
use crate::map::{self, Map};
use crate::painter::Painter;
use crate::shot::left_out;
use crate::written::write_texts;
use maud::{Markup, html};
use rhytid_core::{Error, Result, Rig, human};
use rhytid_transfer::{Maps, Missing, Spread, TransferReport};
use std::path::Path;

/// Writes `transfer.html` and `transfer.json` to the folder `dir`, which is created if necessary.
///
/// `maps` are of the second face, which `rig` animates. Without a `painter`, the page has a sentence in place
/// of the maps.
///
/// # Errors
/// [`Error::Io`] if a file cannot be written. [`Error::Device`] and [`Error::Input`] if the painter cannot
/// draw. [`Error::Internal`] if a map has other vertices than the rig.
pub fn write_transfer(
    dir: &Path,
    found: &TransferReport,
    maps: &Maps,
    rig: &Rig,
    painter: Option<&Painter>,
) -> Result<()> {
    if [&maps.distance_mm, &maps.stretch].iter().any(|map| map.len() != rig.vertices()) {
        return Err(Error::Internal("a map of the transfer has other vertices than the rig".into()));
    }
    let about = html! {
        "Transfer of examples from " b { (found.from) }
    };
    let per_cent: Vec<f32> = maps.stretch.iter().map(|x| 100.0 * x).collect();
    let [distance, stretch] = [
        section("mm", &maps.distance_mm, found.distance_mm, rig, painter)?,
        section("%", &per_cent, times(found.stretch, 100.0), rig, painter)?,
    ];
    let main = html! {
        section {
            h2 { "Summary" }
            @if !found.warnings.is_empty() { ul.warnings { @for warning in &found.warnings { li { (warning) } } } }
            dl { @for (name, value) in facts(found) { div { dt { (name) } dd { (value) } } } }
        }
        section {
            h2 { "Distance between the faces" }
            p { "The first face is laid over this one. The map shows how far each vertex of this face is then from its place on the first. "
                "A vertex without such a place has the last colour. What is transferred beside it continues there and fades out." }
            (distance)
        }
        section {
            h2 { "Stretch of the first face" }
            p { "The map shows how much longer or shorter the surface became, in its worst direction. The difference of the faces’ sizes is "
                "taken out. Where a few vertices stand out, a landmark may be at the wrong place." }
            (stretch)
        }
    };
    let json =
        serde_json::to_string(found).map_err(|e| Error::Internal(format!("the transfer as JSON: {e}")))?;
    write_texts(dir, [("transfer.html", document(&found.to, &about, &main)), ("transfer.json", json)])
}

fn times(spread: Spread, factor: f64) -> Spread {
    Spread { median: factor * spread.median, p95: factor * spread.p95, worst: factor * spread.worst }
}

/// A map, with its numbers in words.
fn section(
    unit: &str,
    values: &[f32],
    spread: Spread,
    rig: &Rig,
    painter: Option<&Painter>,
) -> Result<Markup> {
    let number = |x: f64| human::number((x * 100.0).round() / 100.0);
    let words = html! {
        p { "The median is " (number(spread.median)) " " (unit) ". 95 % are below " (number(spread.p95)) " " (unit) ". The largest is " (number(spread.worst)) " " (unit) "." }
    };
    let Some(painter) = painter else { return Ok(html! { (words) (left_out()) }) };
    let end = map::end(std::iter::once(values));
    let map = Map {
        title: html! { "dots are the handles" },
        positions: &rig.surface().rest,
        values: values.to_vec(),
        end,
        markers: true,
    };
    let figures = map::figures(painter, rig, &[map])?;
    let last = format!("{} {unit} and more", number(end.into()));
    Ok(
        html! { (words) (map::scale(painter, ["0", &last])) div.maps { @for figure in &figures { (figure) } } },
    )
}

fn facts(found: &TransferReport) -> Vec<(&'static str, String)> {
    let mut facts = vec![
        ("Examples", found.examples.join(", ")),
        ("What was transferred", if found.linear_band { "all motion" } else { "the wrinkles" }.to_owned()),
        ("Landmarks", found.landmarks.len().to_string()),
        ("Size", format!("{} % of the first face’s", human::number((1000.0 * found.scale).round() / 10.0))),
        ("Skin with a counterpart", format!("{} %", human::number((1000.0 * found.covered).round() / 10.0))),
        ("Triangles turned over", found.turned_over.to_string()),
    ];
    if found.same_topology {
        facts.push(("Correspondence", "vertex by vertex, as both meshes have the same faces".to_owned()));
    }
    if !found.own.is_empty() {
        facts.push(("Own examples, kept", found.own.join(", ")));
    }
    for bare in &found.bare {
        let why = match bare.why {
            Missing::OtherPart => "Parts without a landmark",
            Missing::BeyondTheBorder => "Beyond the border of the first face",
            Missing::FacesAway => "Near what faces away",
            Missing::TooFar => "Far from the first face",
            Missing::Elsewhere => "Near what moves otherwise",
        };
        let vertices = if bare.vertices == 1 { "vertex" } else { "vertices" };
        facts.push((why, format!("{} {vertices}", human::count(bare.vertices))));
    }
    if !found.bare_handles.is_empty() {
        facts.push(("Handles without a counterpart", found.bare_handles.join(", ")));
    }
    facts
}
