//! The page of a transfer: which places of two faces correspond, how well, and where there is no counterpart.

use crate::document::document;
use crate::map::{self, Map};
use crate::opening::{Finding, opening};
use crate::painter::Painter;
use crate::shot::left_out;
use crate::skin::Skin;
use crate::written::{Page, write_texts};
use maud::{Markup, html};
use rhytid_core::{Error, Result, Rig, VertexId, human, scale};
use rhytid_evaluate::Regions;
use rhytid_transfer::{Maps, Missing, Spread, TransferReport};

/// The number of regions that are named as bare.
const NAMED: usize = 3;

/// A region is named as bare if at least this part of its vertices has no counterpart.
const LEAST_BARE: f64 = 0.05;

/// Writes `transfer.html` and `transfer.json` to the folder of `page`.
///
/// `maps` are of the second face, which `rig` animates. Without a `painter`, the page has a sentence in place
/// of the maps.
///
/// # Errors
/// [`Error::Io`] if a file cannot be written. [`Error::Device`] and [`Error::Input`] if the painter cannot
/// draw. [`Error::Internal`] if a map has other vertices than the rig.
pub fn write_transfer(
    page: Page<'_>,
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
    let triangles = Skin::new(rig).triangles();
    let draw = |id: &'static str, unit: &'static str, values: &[f32], spread: Spread| {
        Section::new(id, unit, values, spread, rig, &triangles, painter)
    };
    let distance = draw("distance", "mm", &maps.distance_mm, found.distance_mm)?;
    let stretch = draw("stretch", "%", &per_cent, times(found.stretch, 100.0))?;
    let main = html! {
        (opening(&verdict(found), &findings(found, &maps.distance_mm, &per_cent, [&distance, &stretch], rig)))
        section {
            h2 { "Summary" }
            @if !found.warnings.is_empty() { ul.warnings { @for warning in &found.warnings { li { (warning) } } } }
            dl { @for (name, value) in facts(found) { div { dt { (name) } dd { (value) } } } }
        }
        section {
            h2 { "Distance between the faces" }
            p { "The first face is laid over this one. The map shows how far each vertex of this face is then from its place on the first. "
                "A vertex without such a place is grey. What is transferred beside it continues there and fades out." }
            (distance.markup)
        }
        section {
            h2 { "Stretch of the first face" }
            p { "The map shows how much longer or shorter the surface became, in its worst direction. The difference of the faces’ sizes is "
                "taken out. Where a few vertices stand out, a landmark may be at the wrong place." }
            (stretch.markup)
        }
    };
    let json =
        serde_json::to_string(found).map_err(|e| Error::Internal(format!("the transfer as JSON: {e}")))?;
    write_texts(
        page.folder,
        [("transfer.html", document(page.title, &about, &main)), ("transfer.json", json)],
    )
}

/// Whether the transfer can be used, and what to correct otherwise.
fn verdict(found: &TransferReport) -> String {
    let what = if found.linear_band { "motion" } else { "wrinkles" };
    let covered = format!("{} % of the skin", human::number((1000.0 * found.covered).round() / 10.0));
    match found.warnings.len() {
        0 => format!(
            "The {what} of {} can be used on {}: {covered} has a counterpart, and nothing needs to be corrected.",
            found.from, found.to
        ),
        1 => format!(
            "Correct one thing before you use the {what} of {} on {}; {covered} has a counterpart.",
            found.from, found.to
        ),
        n => format!(
            "Correct {n} things before you use the {what} of {} on {}; {covered} has a counterpart.",
            found.from, found.to
        ),
    }
}

/// What to correct, and then where the faces differ most.
fn findings(
    found: &TransferReport,
    distance_mm: &[f32],
    stretch: &[f32],
    [of_distance, of_stretch]: [&Section; 2],
    rig: &Rig,
) -> Vec<Finding> {
    let mut findings: Vec<Finding> = Vec::new();
    for warning in &found.warnings {
        // A warning names the map that shows it.
        let section = [(of_distance, "map of distances"), (of_stretch, "map of stretches")];
        let shown = section.into_iter().find(|(_, name)| warning.contains(name));
        findings.push(Finding {
            words: html! { (capital(warning)) "." },
            picture: shown.and_then(|(section, _)| section.again.clone()),
        });
    }
    let regions = Regions::by_handles(rig);
    let bare = bare_regions(distance_mm, &regions);
    if !bare.is_empty() {
        findings.push(Finding {
            words: html! { b { "Without a counterpart: " } (bare.join(", ")) ". The skin there moves by the shell alone." },
            picture: of_distance.again.clone(),
        });
    }
    let of_maps = [
        ("Farthest apart: ", of_distance, distance_mm, "mm", found.same_topology),
        ("Most stretched: ", of_stretch, stretch, "%", false),
    ];
    for (name, section, values, unit, is_exact) in of_maps {
        if let Some((region, value)) = worst_region(values, &regions).filter(|_| !is_exact) {
            findings.push(Finding {
                words: html! { b { (name) } (region) ", " (rounded(value)) " " (unit) " (RMS)." },
                picture: section.again.clone(),
            });
        }
    }
    findings
}

fn capital(sentence: &str) -> String {
    let mut letters = sentence.chars();
    letters.next().into_iter().flat_map(char::to_uppercase).chain(letters).collect()
}

/// The region with the largest RMS.
fn worst_region(values: &[f32], regions: &Regions) -> Option<(String, f64)> {
    let mut sums = vec![(0.0, 0); regions.names().len()];
    for (v, value) in values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
        if let Some(region) = regions.of_vertex(VertexId::from_index(v)) {
            sums[region].0 += f64::from(*value).powi(2);
            sums[region].1 += 1;
        }
    }
    let known = regions.names().iter().zip(sums).filter(|(_, (_, count))| *count > 0);
    let rms = known.map(|(name, (sum, count))| (name.clone(), (sum / f64::from(count)).sqrt()));
    rms.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The regions of which a part has no counterpart, with this part. The largest is first.
fn bare_regions(values: &[f32], regions: &Regions) -> Vec<String> {
    let mut counts = vec![[0_usize; 2]; regions.names().len()];
    for (v, value) in values.iter().enumerate() {
        if let Some(region) = regions.of_vertex(VertexId::from_index(v)) {
            counts[region][0] += 1;
            counts[region][1] += usize::from(value.is_nan());
        }
    }
    let part = |[all, bare]: [usize; 2]| bare as f64 / all.max(1) as f64;
    let known = regions.names().iter().zip(counts).map(|(name, count)| (name, part(count)));
    let mut bare: Vec<(&String, f64)> = known.filter(|(_, part)| *part >= LEAST_BARE).collect();
    bare.sort_by(|a, b| b.1.total_cmp(&a.1));
    bare.into_iter().take(NAMED).map(|(name, part)| format!("{:.0} % of the {name}", 100.0 * part)).collect()
}

fn rounded(x: f64) -> String {
    human::number((x * 100.0).round() / 100.0)
}

fn times(spread: Spread, factor: f64) -> Spread {
    Spread { median: factor * spread.median, p95: factor * spread.p95, worst: factor * spread.worst }
}

/// A map, with its numbers in words.
struct Section {
    markup: Markup,
    /// Its first picture once more.
    again: Option<Markup>,
}

impl Section {
    fn new(
        id: &str,
        unit: &str,
        values: &[f32],
        spread: Spread,
        rig: &Rig,
        triangles: &[[u32; 3]],
        painter: Option<&Painter>,
    ) -> Result<Self> {
        let words = html! {
            p { "The median is " (rounded(spread.median)) " " (unit) ". 95 % are below " (rounded(spread.p95)) " " (unit) ". The largest is " (rounded(spread.worst)) " " (unit) "." }
        };
        let Some(painter) = painter else {
            return Ok(Self { markup: html! { (words) (left_out()) }, again: None });
        };
        let end = scale::end(std::iter::once(values));
        let map = Map {
            id: id.to_owned(),
            title: html! { "dots are the handles" },
            positions: &rig.surface().rest,
            values: values.to_vec(),
            end,
            markers: true,
        };
        let figures = map::figures(painter, rig, triangles, &[map])?;
        let legend = map::scale(painter, end, unit, "no counterpart", std::iter::once(values));
        Ok(Self {
            markup: html! { (words) (legend) div.maps { @for figure in &figures { (figure.markup) } } },
            again: figures.first().map(|figure| figure.again.clone()),
        })
    }
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
