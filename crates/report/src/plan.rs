//! The page of a plan: the frames of a take to scan, and the use of each.

use crate::document::document;
use crate::map::{self, Figure, Map};
use crate::opening::{Finding, opening};
use crate::painter::Painter;
use crate::shot::left_out;
use crate::skin::Skin;
use crate::written::{Page, write_texts};
use maud::{Markup, html};
use rhytid_core::{Error, Result, Rig, VertexId, human, scale};
use rhytid_evaluate::Regions;
use rhytid_evaluate::coverage::{Coverage, Scan, share};

/// The number of regions that are named as the use of a scan.
const NAMED: usize = 3;

/// Writes `plan.html` and `plan.json` to the folder of `page`.
///
/// `take` names the take, and `poses` has the V positions of each planned frame. Without a `painter`, the
/// page has a sentence in place of its pictures.
///
/// # Errors
/// [`Error::Io`] if a file cannot be written. [`Error::Device`] and [`Error::Input`] if the painter cannot
/// draw. [`Error::Internal`] if there is not a pose for each scan.
pub fn write_plan(
    page: Page<'_>,
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
    let skin = Skin::new(rig);
    let shares: Vec<Vec<f32>> =
        found.scans.iter().map(|scan| skin.only(&per_cent(scan, regions, rig))).collect();
    // One scale for all scans, so that a scan that helps little is pale.
    let end = scale::end(std::iter::once(largest(found).as_slice()));
    let mut maps = Vec::new();
    for ((i, scan), (pose, values)) in found.scans.iter().enumerate().zip(poses.iter().zip(&shares)) {
        maps.push(Map {
            id: format!("scan-{}", i + 1),
            title: html! { b { (i + 1) ": " (frame(scan)) } ", takes away " (share(scan.taken)) },
            positions: pose,
            values: values.clone(),
            end,
            markers: true,
        });
    }
    let figures = painter.map(|painter| map::figures(painter, rig, &skin.triangles(), &maps)).transpose()?;
    let about = html! {
        "Plan of scans from the take " b { (take) } ": " (human::counted(found.frames, "frame")) ". The rig has "
        (human::counted(rig.examples().names.len(), "example")) " so far."
    };
    let main = html! {
        (opening(&found.verdict(), &findings(found, figures.as_deref())))
        section {
            h2 { "Which scans to make" }
            p { "Each frame below is the one whose scan takes away most of the uncertainty that the scans before it leave. "
                "Of neighbouring frames that are alike, there is one. "
                "All numbers are parts of the uncertainty without any example, which is 100 %. Now, " (share(found.left)) " is left." }
            (table(found))
        }
        section {
            h2 { "Where each scan helps" }
            @match painter.zip(figures) {
                Some((painter, figures)) => {
                    p { "The colours show what a scan takes away in each region of the face, on one scale for all scans. Dots are the markers." }
                    (map::scale(painter, end, "%", "not skin", shares.iter().map(Vec::as_slice)))
                    div.maps { @for figure in &figures { (figure.markup) } }
                }
                None => { (left_out()) }
            }
        }
    };
    let json = serde_json::to_string(found).map_err(|e| Error::Internal(format!("the plan as JSON: {e}")))?;
    write_texts(page.folder, [("plan.html", document(page.title, &about, &main)), ("plan.json", json)])
}

/// What a scan takes away in the region of each vertex, in per cent. It is NaN outside of the regions.
fn per_cent(scan: &Scan, regions: &Regions, rig: &Rig) -> Vec<f32> {
    let of_region = |name: &String| scan.regions.iter().find(|of_scan| of_scan.region == *name);
    let by_region: Vec<f32> = regions
        .names()
        .iter()
        .map(|name| of_region(name).map_or(f32::NAN, |r| 100.0 * r.taken as f32))
        .collect();
    let of_vertex = |v| regions.of_vertex(VertexId(v)).map_or(f32::NAN, |region| by_region[region]);
    (0..rig.vertices() as u32).map(of_vertex).collect()
}

/// What each scan takes away at most in a region, in per cent.
fn largest(found: &Coverage) -> Vec<f32> {
    let first = |scan: &Scan| scan.regions.first().map(|region| 100.0 * region.taken as f32);
    found.scans.iter().filter_map(first).collect()
}

fn findings(found: &Coverage, figures: Option<&[Figure]>) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (i, scan) in found.scans.iter().enumerate().take(found.enough) {
        findings.push(Finding {
            words: html! { b { "Scan " (frame(scan)) "." } " It takes away " (share(scan.taken)) ", mostly in " (places(scan)) "." },
            picture: figures.map(|figures| figures[i].again.clone()),
        });
    }
    findings
}

fn frame(scan: &Scan) -> String {
    format!("frame {}, {:.2} s", scan.frame, scan.time)
}

/// The regions that a scan helps most.
fn places(scan: &Scan) -> String {
    let named = scan.regions.iter().take(NAMED);
    named.map(|region| format!("{} {}", region.region, share(region.taken))).collect::<Vec<_>>().join(", ")
}

/// All scans, with bars on one scale.
fn table(found: &Coverage) -> Markup {
    let most = found.scans.iter().map(|scan| scan.taken).fold(f64::MIN_POSITIVE, f64::max);
    html! {
        table.plan {
            thead { tr {
                th.number { "" } th { "frame" } th.number { "takes away" } th {} th.number { "left then" } th { "mostly in" }
            } }
            tbody {
                @for (i, scan) in found.scans.iter().enumerate() {
                    tr.needless[i >= found.enough] {
                        td.number { (i + 1) }
                        td.frame { (frame(scan)) }
                        td.number { (share(scan.taken)) }
                        td.bar { i style={ "width:" (format!("{:.1}%", 100.0 * (scan.taken / most).max(0.0))) } {} }
                        td.number { (share(scan.left)) }
                        td { (places(scan)) }
                    }
                }
            }
        }
        @if found.enough < found.scans.len() { p.note { "Scans in grey take away less than 1 %. They are not needed." } }
    }
}
