//! The aligned markers on the rest mesh, from the front and from the side.

use crate::camera::Camera;
use crate::raster::Raster;
use crate::strain::Strains;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};
use rhytid_capture::{Kind, Report};
use rhytid_core::{Result, Rig, Take};

const SIZE: [usize; 2] = [520, 640];

/// Names and angles of the views.
const VIEWS: [(&str, f64); 2] = [("From the front", 0.0), ("From the face’s left", 42.0)];

/// A handle, and where its marker is.
struct Marker<'a> {
    label: &'a str,
    handle: [f64; 3],
    neutral: [f64; 3],
    /// In the frame of the largest strain.
    strained: [f64; 3],
    never_seen: bool,
}

/// The views of the face, each a figure.
///
/// # Errors
/// [`rhytid_core::Error::Internal`] if the picture can't be encoded.
pub(crate) fn views(report: &Report, strains: &Strains, take: &Take, rig: &Rig) -> Result<Markup> {
    let markers = markers(report, strains, take, rig);
    let worst = strains.edges.first().map(|edge| strains.handles(edge));
    let mut figures = Vec::new();
    for (name, degrees) in VIEWS {
        let handles = markers.iter().map(|marker| marker.handle);
        let camera = Camera::new(rig.up_axis, degrees, SIZE, handles);
        let raster = Raster::new(&camera, &rig.rest, &rig.triangles);
        figures.push((name, view(&camera, &raster, &markers, worst)?));
    }
    Ok(html! {
        div.views {
            @for (name, svg) in &figures {
                figure { (svg) figcaption { (name) } }
            }
        }
    })
}

fn markers<'a>(report: &'a Report, strains: &Strains, take: &Take, rig: &Rig) -> Vec<Marker<'a>> {
    if take.frames() == 0 {
        return Vec::new();
    }
    let neutral = neutral_frame(report, take);
    let strained = strains.edges.first().map_or(neutral, |edge| edge.frame);
    let never =
        |handle: usize| report.events.iter().any(|e| e.kind == Kind::NeverSeen && e.marker == Some(handle));
    let marker = |(handle, label): (usize, &'a String)| Marker {
        label,
        handle: rig.rest[rig.handles[handle] as usize].map(f64::from),
        neutral: strains.position(handle, neutral),
        strained: strains.position(handle, strained),
        never_seen: never(handle),
    };
    report.labels.iter().enumerate().map(marker).collect()
}

/// The clean take's frame that is nearest to the first neutral frame of the raw one. The take has frames.
fn neutral_frame(report: &Report, take: &Take) -> usize {
    let time = report.start + report.setup.neutral.start as f64 / report.rate;
    let after = take.times.partition_point(|&t| t < time).min(take.frames() - 1);
    let before = after.saturating_sub(1);
    if time - take.times[before] < take.times[after] - time { before } else { after }
}

fn view(camera: &Camera, raster: &Raster, markers: &[Marker], worst: Option<[usize; 2]>) -> Result<Markup> {
    let [width, height] = SIZE;
    let data = STANDARD.encode(raster.png()?);
    let line = |class: &str, from: [f64; 3], to: [f64; 3]| {
        let [from, to] = [from, to].map(|p| camera.project(p));
        html! { line class=(class) x1=(px(from[0])) y1=(px(from[1])) x2=(px(to[0])) y2=(px(to[1])) {} }
    };
    // A marker sits on the skin or a little before or behind it, which does not hide it.
    let slack = 0.02 * width as f64;
    let class = |marker: &Marker| match raster.shows(camera.project(marker.handle), slack) {
        true => "marker",
        false => "marker behind",
    };
    Ok(html! {
        svg viewBox={ "0 0 " (width) " " (height) } {
            image href={ "data:image/png;base64," (data) } width=(width) height=(height) {}
            @if let Some([a, b]) = worst {
                @if !markers.is_empty() { (line("worst", markers[a].strained, markers[b].strained)) }
            }
            @for marker in markers {
                g class=(class(marker)) {
                    title { (marker.label) @if marker.never_seen { " (never seen)" } }
                    (line("motion", marker.neutral, marker.strained))
                    @let p = camera.project(marker.handle);
                    circle.handle cx=(px(p[0])) cy=(px(p[1])) r="5" {}
                    @let p = camera.project(marker.neutral);
                    circle.dot.missing[marker.never_seen] cx=(px(p[0])) cy=(px(p[1])) r="2.6" {}
                }
            }
        }
    })
}

/// A coordinate with one decimal.
fn px(x: f64) -> String {
    format!("{x:.1}")
}
