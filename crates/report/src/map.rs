//! Maps: numbers on a face, shown as colours.

use crate::painter::Painter;
use crate::shot::{Drawn, Numbers, Shot};
use maud::{Markup, html};
use rhytid_core::{Result, Rig, human};

const SIZE: [u32; 2] = [300, 370];

/// The angles of the camera around the face, in degrees: the front, and its left.
const VIEWS: [f32; 2] = [0.0, 42.0];

/// Numbers to draw.
pub(crate) struct Map<'a> {
    /// The name of its pictures in the page, which no other map has.
    pub id: String,
    pub title: Markup,
    /// V positions.
    pub positions: &'a [[f32; 3]],
    /// V numbers. Those of `end` or more have the last colour, and NaN is grey.
    pub values: Vec<f32>,
    pub end: f32,
    /// Whether the markers are shown too.
    pub markers: bool,
}

/// A map as a figure of the page.
pub(crate) struct Figure {
    pub markup: Markup,
    /// The first of the pictures alone. It refers to that of `markup`, which has to be in the page.
    pub again: Markup,
}

/// Draws maps on a rig's face, each from the front and from its left, as a figure. `triangles` are those of
/// the rig that are shown.
///
/// # Errors
/// As [`Painter::draw`].
pub(crate) fn figures(
    painter: &Painter,
    rig: &Rig,
    triangles: &[[u32; 3]],
    maps: &[Map<'_>],
) -> Result<Vec<Figure>> {
    let shots: Vec<Shot<'_>> = maps
        .iter()
        .flat_map(|map| VIEWS.map(|turn| (map, turn)))
        .map(|(map, turn)| {
            let markers = rig.handles().points.iter().filter(|_| map.markers);
            Shot {
                turn,
                positions: map.positions,
                heat: Some(Numbers { values: &map.values, end: map.end }),
                points: markers.map(|point| point.at(map.positions).map(f64::from)).collect(),
            }
        })
        .collect();
    let drawn = painter.draw(rig, triangles, SIZE, &shots)?;
    Ok(maps.iter().zip(drawn.chunks(VIEWS.len())).map(|(map, pictures)| figure(map, pictures)).collect())
}

fn figure(map: &Map<'_>, pictures: &[Drawn]) -> Figure {
    let [width, height] = SIZE;
    let view_box = format!("0 0 {width} {height}");
    let name = |i: usize| format!("{}-{i}", map.id);
    Figure {
        markup: html! {
            figure {
                @for (i, picture) in pictures.iter().enumerate() {
                    svg viewBox=(view_box) role="img" {
                        g id=(name(i)) {
                            image href=(picture.data()) width=(width) height=(height) {}
                            @for place in picture.places.iter().filter(|place| !place.is_behind) {
                                @let [x, y] = place.words();
                                circle.dot.of-map cx=(x) cy=(y) r="2.2" {}
                            }
                        }
                    }
                }
                figcaption { (map.title) }
            }
        },
        again: html! {
            svg viewBox=(view_box) role="img" { use href={ "#" (name(0)) } {} }
        },
    }
}

/// The legend of the colours from 0 to `end` of a unit, with three ticks. It says if some of the numbers are
/// larger than its end, and what is grey if some have no number.
pub(crate) fn scale<'a>(
    painter: &Painter,
    end: f32,
    unit: &str,
    grey: &str,
    maps: impl Iterator<Item = &'a [f32]>,
) -> Markup {
    const STEPS: u8 = 16;
    let colours = (0..=STEPS).map(|step| {
        let [red, green, blue] = painter.colour(f32::from(step) / f32::from(STEPS));
        format!(",rgb({red} {green} {blue})")
    });
    let colours: String = colours.collect();
    let (mut is_clipped, mut has_grey) = (false, false);
    for number in maps.flatten() {
        is_clipped |= *number > end;
        has_grey |= number.is_nan();
    }
    let tick = |part: f32| human::number(f64::from((part * end * 1e4).round()) / 1e4);
    let [red, green, blue] = painter.grey();
    html! {
        div.scale {
            div.colours {
                i style={ "background:linear-gradient(90deg" (colours) ")" } {}
                span { "0" } span { (tick(0.5)) }
                span { (tick(1.0)) " " (unit) @if is_clipped { " and more" } }
            }
            @if has_grey { div.grey { i style={ "background:rgb(" (red) " " (green) " " (blue) ")" } {} (grey) } }
        }
    }
}
