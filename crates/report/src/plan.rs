//! The page of a plan: the frames of a take to scan, and the use of each.

use crate::document::document;
use crate::map::{self, Map};
use crate::painter::Painter;
use crate::shot::left_out;
use crate::written::write_texts;
use maud::{Markup, html};
use rhytid_core::{Error, Result, Rig, VertexId, human};
use rhytid_evaluate::Regions;
use rhytid_evaluate::coverage::{Coverage, Scan};
use std::path::Path;

/// The number of regions that are named as the use of a scan.
const NAMED: usize = 3;

/// Writes `plan.html` and `plan.json` to the folder `dir`, which is created if necessary.
///
/// `take` names the take, and `poses` has the V positions of each planned frame. Without a `painter`, the
/// page has a sentence in place of its pictures.
///
/// # Errors
/// [`Error::Io`] if a file cannot be written. [`Error::Device`] and [`Error::Input`] if the painter cannot
/// draw. [`Error::Internal`] if there is not a pose for each scan.
pub fn write_plan(
    dir: &Path,
    take: &str,
    found: &Coverage,
    regions: &Regions,
    poses: &[Vec<[f32; 3]>],
    rig: &Rig,
    painter: Option<&Painter>,
) -> Result<()> {
    if poses.len() != found.scans.len() || poses.iter().any(|pose| pose.len() != rig.vertices()) {
        return Err(Error::Internal("the plan's poses are not one for each scan".into()));
    }
    let mut maps = Vec::new();
    for ((i, scan), pose) in found.scans.iter().enumerate().zip(poses) {
        let largest = scan.regions.first().map_or(1.0, |region| region.taken);
        let share = |v: u32| {
            let region = regions.of_vertex(VertexId(v)).map(|region| &regions.names()[region]);
            let of_region = scan.regions.iter().find(|r| Some(&r.region) == region);
            of_region.map_or(0.0, |r| (r.taken / largest) as f32)
        };
        let values: Vec<f32> = (0..rig.vertices() as u32).map(share).collect();
        maps.push(Map { title: caption(i, scan), positions: pose, values, end: 1.0, markers: true });
    }
    let figures = painter.map(|painter| map::figures(painter, rig, &maps)).transpose()?;
    let about = html! { "Plan of scans, for the rig " b { (rig.surface().name) } };
    let main = html! {
        section {
            h2 { "Which scans to make" }
            p { "The take has " (human::counted(found.frames, "frame")) ". The rig has " (human::counted(rig.examples().names.len(), "example")) " so far. "
                "Each frame below is the one whose scan removes most of the uncertainty that the scans before it leave. "
                "100 % is the uncertainty without any example." }
            @match painter.zip(figures) {
                Some((painter, figures)) => {
                    p { "The coloured regions are those that the scan is for. Dots are the markers." }
                    (map::scale(painter, ["removes nothing there", "removes most there"]))
                    div.maps { @for figure in &figures { (figure) } }
                }
                None => { (left_out()) ol.plain { @for map in &maps { li { (map.title) } } } }
            }
        }
    };
    let json = serde_json::to_string(found).map_err(|e| Error::Internal(format!("the plan as JSON: {e}")))?;
    write_texts(dir, [("plan.html", document(take, &about, &main)), ("plan.json", json)])
}

fn caption(i: usize, scan: &Scan) -> Markup {
    let regions: Vec<&str> = scan.regions.iter().take(NAMED).map(|region| region.region.as_str()).collect();
    html! {
        b { (i + 1) ": frame " (scan.frame) ", " (format!("{:.2} s", scan.time)) } " for " (regions.join(", ")) "; then "
        (format!("{:.0} %", 100.0 * scan.left)) " of the uncertainty is left"
    }
}
