//! Maps: numbers on a face, shown as colours.

use crate::painter::Painter;
use crate::shot::{Drawn, Numbers, Shot};
use maud::{Markup, html};
use rhytid_core::{Result, Rig};

const SIZE: [u32; 2] = [300, 370];

/// The angles of the camera around the face, in degrees: the front, and its left.
const VIEWS: [f32; 2] = [0.0, 42.0];

/// Numbers to draw.
pub(crate) struct Map<'a> {
    pub title: Markup,
    /// V positions.
    pub positions: &'a [[f32; 3]],
    /// V numbers. Those of `end` or more have the last colour.
    pub values: Vec<f32>,
    pub end: f32,
    /// Whether the markers are shown too.
    pub markers: bool,
}

/// Draws maps on a rig's face, each from the front and from its left, as a figure.
///
/// # Errors
/// As [`Painter::draw`].
pub(crate) fn figures(painter: &Painter, rig: &Rig, maps: &[Map<'_>]) -> Result<Vec<Markup>> {
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
    let drawn = painter.draw(rig, SIZE, &shots)?;
    let [width, height] = SIZE;
    let figure = |(map, pictures): (&Map<'_>, &[Drawn])| {
        html! {
            figure {
                @for picture in pictures {
                    svg viewBox={ "0 0 " (width) " " (height) } role="img" {
                        image href=(picture.data()) width=(width) height=(height) {}
                        @for place in picture.places.iter().filter(|place| !place.is_behind) {
                            @let [x, y] = place.words();
                            circle.dot cx=(x) cy=(y) r="2.2" {}
                        }
                    }
                }
                figcaption { (map.title) }
            }
        }
    };
    Ok(maps.iter().zip(drawn.chunks(VIEWS.len())).map(figure).collect())
}

/// The legend of the colours, with words for its ends.
pub(crate) fn scale(painter: &Painter, [first, last]: [&str; 2]) -> Markup {
    const STEPS: u8 = 16;
    let colours = (0..=STEPS).map(|step| {
        let [red, green, blue] = painter.colour(f32::from(step) / f32::from(STEPS));
        format!(",rgb({red} {green} {blue})")
    });
    let colours: String = colours.collect();
    html! { p.scale { (first) " " i style={ "background:linear-gradient(90deg" (colours) ")" } {} " " (last) } }
}

/// The end of a scale for these maps: 1 % of the numbers are larger.
pub(crate) fn end<'a>(maps: impl Iterator<Item = &'a [f32]>) -> f32 {
    let mut all: Vec<f32> = maps.flatten().copied().filter(|x| x.is_finite()).collect();
    if all.is_empty() {
        return 1.0;
    }
    let at = all.len() * 99 / 100;
    let end = *all.select_nth_unstable_by(at, f32::total_cmp).1;
    if end > 0.0 { end } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_in_a_hundred_is_beyond_the_scale() {
        let values: Vec<f32> = (0..1000).map(|i| i as f32).collect();
        assert_eq!(end([&values[..500], &values[500..]].into_iter()), 990.0);
        assert_eq!((end([].into_iter()), end([&[0.0_f32; 5][..]].into_iter())), (1.0, 1.0));
    }
}
