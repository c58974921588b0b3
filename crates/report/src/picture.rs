//! The aligned markers on the rest mesh, from the front and from the side.

use crate::painter::Painter;
use crate::shot::{Drawn, Place, Shot};
use crate::strain::Strains;
use maud::{Markup, html};
use rhytid_capture::{Kind, Report};
use rhytid_core::{Result, Rig, Take};

const SIZE: [u32; 2] = [520, 640];

/// Names and angles of the views, in degrees.
const VIEWS: [(&str, f32); 2] = [("From the front", 0.0), ("From the face’s left", 42.0)];

/// A handle, and the positions of its marker.
struct Marker<'a> {
    label: &'a str,
    handle: [f64; 3],
    neutral: [f64; 3],
    /// The position in the frame of the largest strain.
    strained: [f64; 3],
    never_seen: bool,
}

/// The views of the face.
pub(crate) struct Views {
    /// Each a figure.
    pub markup: Markup,
    /// The first of them alone, which refers to that of `markup`.
    pub again: Markup,
}

/// The views of the face, each a figure.
///
/// # Errors
/// As [`Painter::draw`].
pub(crate) fn views(
    report: &Report,
    strains: &Strains,
    take: &Take,
    rig: &Rig,
    painter: &Painter,
) -> Result<Views> {
    let markers = markers(report, strains, take, rig);
    let worst = strains.edges.first().map(|edge| strains.handles(edge));
    let points = || markers.iter().flat_map(|marker| [marker.handle, marker.neutral, marker.strained]);
    let shot =
        |(_, turn)| Shot { turn, positions: &rig.surface().rest, heat: None, points: points().collect() };
    let drawn = painter.draw(rig, &rig.surface().triangles, SIZE, &VIEWS.map(shot))?;
    let markup = html! {
        div.views {
            @for (i, ((name, _), picture)) in VIEWS.iter().zip(&drawn).enumerate() {
                figure { (view(&format!("view-{i}"), picture, &markers, worst)) figcaption { (name) } }
            }
        }
    };
    let [width, height] = SIZE;
    let again = html! { svg viewBox={ "0 0 " (width) " " (height) } { use href="#view-0" {} } };
    Ok(Views { markup, again })
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
        handle: rig.handles().rest[handle].map(f64::from),
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

/// A picture whose points are each marker's handle, its neutral and its strained position.
fn view(id: &str, picture: &Drawn, markers: &[Marker], worst: Option<[usize; 2]>) -> Markup {
    let [width, height] = SIZE;
    let (places, _) = picture.places.as_chunks::<3>();
    let line = |class: &str, from: Place, to: Place| {
        let [[x1, y1], [x2, y2]] = [from, to].map(|place| place.words());
        html! { line class=(class) x1=(x1) y1=(y1) x2=(x2) y2=(y2) {} }
    };
    let circle = |class: &str, place: Place, radius: &str| {
        let [x, y] = place.words();
        html! { circle class=(class) cx=(x) cy=(y) r=(radius) {} }
    };
    html! {
        svg viewBox={ "0 0 " (width) " " (height) } { g id=(id) {
            image href=(picture.data()) width=(width) height=(height) {}
            @if let Some((&[_, _, from], &[_, _, to])) = worst.and_then(|[a, b]| places.get(a).zip(places.get(b))) {
                (line("worst", from, to))
            }
            @for (marker, &[handle, neutral, strained]) in markers.iter().zip(places) {
                g class=(if handle.is_behind { "marker behind" } else { "marker" }) {
                    title { (marker.label) @if marker.never_seen { " (never seen)" } }
                    (line("motion", neutral, strained))
                    (circle("handle", handle, "5"))
                    (circle(if marker.never_seen { "dot missing" } else { "dot" }, neutral, "2.6"))
                }
            }
        } }
    }
}
