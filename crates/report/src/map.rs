//! Maps: numbers on the rest mesh, as colours.

use crate::camera::Camera;
use crate::raster::Raster;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};
use rhytid_core::{Result, Rig};

const SIZE: [usize; 2] = [300, 370];

/// How far the camera goes around the face, in degrees: the front, and its left.
const VIEWS: [f64; 2] = [0.0, 42.0];

/// Colours of the scale from 0 to its end, at equal steps; the style sheet's `.scale i` has the same.
const SCALE: [[f32; 3]; 4] = [[0.86, 0.88, 0.9], [1.0, 0.83, 0.35], [0.93, 0.33, 0.16], [0.5, 0.0, 0.28]];

/// Draws V numbers on the face from the front and from its left; `end` and what is more has the last colour.
///
/// # Errors
/// [`rhytid_core::Error::Internal`] if the picture can't be encoded.
pub(crate) fn map(rig: &Rig, title: &str, values: &[f32], end: f32) -> Result<Markup> {
    let title = html! { (title) };
    posed(rig, &rig.rest, &title, values, end, false)
}

/// The same on the face with its V vertices at `positions`, and with its markers.
///
/// # Errors
/// As [`map`].
pub(crate) fn posed(
    rig: &Rig,
    positions: &[[f32; 3]],
    title: &Markup,
    values: &[f32],
    end: f32,
    markers: bool,
) -> Result<Markup> {
    let colours: Vec<[f32; 3]> = values.iter().map(|value| colour(value / end)).collect();
    let [width, height] = SIZE;
    let mut pictures = Vec::new();
    for degrees in VIEWS {
        let handles = rig.handles.iter().map(|&v| rig.rest[v as usize].map(f64::from));
        let camera = Camera::new(rig.up_axis, degrees, SIZE, handles);
        let raster = Raster::coloured(&camera, positions, &rig.triangles, &colours);
        let seen = rig.handles.iter().map(|&v| camera.project(positions[v as usize].map(f64::from)));
        let dots = seen.filter(|place| markers && raster.shows(*place, 0.02 * width as f64));
        let dots: Vec<[String; 2]> = dots.map(|[x, y, _]| [x, y].map(|c| format!("{c:.1}"))).collect();
        pictures.push((STANDARD.encode(raster.png()?), dots));
    }
    Ok(html! {
        figure {
            @for (picture, dots) in &pictures {
                svg viewBox={ "0 0 " (width) " " (height) } role="img" {
                    image href={ "data:image/png;base64," (picture) } width=(width) height=(height) {}
                    @for [x, y] in dots { circle.dot cx=(x) cy=(y) r="2.2" {} }
                }
            }
            figcaption { (title) }
        }
    })
}

/// The scale with its end in millimetres.
pub(crate) fn scale(end: f32) -> Markup {
    html! { p.scale { "0 " i {} " " (format!("{end:.2}")) " mm and more" } }
}

/// Where a scale should end for these maps: 1 % of the numbers are more.
pub(crate) fn end<'a>(maps: impl Iterator<Item = &'a [f32]>) -> f32 {
    let mut all: Vec<f32> = maps.flatten().copied().filter(|x| x.is_finite()).collect();
    if all.is_empty() {
        return 1.0;
    }
    let at = all.len() * 99 / 100;
    let end = *all.select_nth_unstable_by(at, f32::total_cmp).1;
    if end > 0.0 { end } else { 1.0 }
}

/// The colour at a part of the scale.
fn colour(part: f32) -> [f32; 3] {
    // What is no number is the worst.
    let at = if part.is_nan() { 1.0 } else { part.clamp(0.0, 1.0) } * (SCALE.len() - 1) as f32;
    let first = (at as usize).min(SCALE.len() - 2);
    let t = at - first as f32;
    [0, 1, 2].map(|c| SCALE[first][c] + t * (SCALE[first + 1][c] - SCALE[first][c]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_go_along_the_scale() {
        assert_eq!((colour(0.0), colour(-1.0)), (SCALE[0], SCALE[0]));
        assert_eq!((colour(1.0), colour(9.0), colour(f32::NAN)), (SCALE[3], SCALE[3], SCALE[3]));
        let middle = colour(0.5);
        assert!((0..3).all(|c| (middle[c] - (SCALE[1][c] + SCALE[2][c]) / 2.0).abs() < 1e-6), "{middle:?}");
    }

    #[test]
    fn one_in_a_hundred_is_beyond_the_scale() {
        let values: Vec<f32> = (0..1000).map(|i| i as f32).collect();
        assert_eq!(end([&values[..500], &values[500..]].into_iter()), 990.0);
        assert_eq!((end([].into_iter()), end([&[0.0_f32; 5][..]].into_iter())), (1.0, 1.0));
    }
}
