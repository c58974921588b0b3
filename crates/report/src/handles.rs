//! A picture of handles on a mesh.

use crate::behind::behind;
use crate::names::{Name, place_names};
use crate::painter::{Canvas, LIFT, Painter, camera};
use rhytid_core::{AtomicFile, Face, Result, human};
use rhytid_render::{Anchor, Mark, Picture, Sheet, Sphere, to_srgb};
use std::io::Write;
use std::path::Path;

const SIZE: [u32; 2] = [860, 1060];

/// Pixels of the legend below the views.
const FOOT: u32 = 44;

/// The views from the face's right, the front and its left, in degrees.
const VIEWS: [f32; 3] = [-50.0, 0.0, 50.0];

/// The colours of good handles, of doubtful handles, and of places of markers: linear red, green and blue.
const COLOURS: [[f32; 3]; 3] = [[0.01, 0.16, 0.72], [0.72, 0.02, 0.01], [0.96, 0.51, 0.01]];

/// The colours of names and of their rims, in 8 bits of sRGB.
const NAME: [u8; 3] = [10, 10, 10];
const RIM: [u8; 3] = [255, 255, 255];

/// Writes a PNG of the neutral from three sides, with its handles as dots and their names beside them.
///
/// Handles are red where `doubtful` says so, and blue elsewhere. The places of markers, if there are any, are
/// yellow. Dots that the face hides are not shown, and neither are names without room. A legend at the foot
/// says so, with the number of handles.
///
/// # Errors
/// [`rhytid_core::Error::Io`]; [`rhytid_core::Error::Device`]; [`rhytid_core::Error::Input`] if the mesh is
/// too large for the device.
pub fn write_handles(
    path: &Path,
    face: &Face,
    doubtful: &[bool],
    markers: &[[f64; 3]],
    painter: &Painter,
) -> Result<()> {
    let single = |p: &[f64; 3]| p.map(|x| x as f32);
    let rest: Vec<[f32; 3]> = face.neutral.positions.iter().map(single).collect();
    let triangles = rhytid_geometry::triangulate(&face.neutral);
    let handles: Vec<[f32; 3]> = face.handles.points.iter().map(|point| point.at(&rest)).collect();
    let lift = LIFT * Sphere::around(&handles).radius;
    let of_handles = handles.iter().enumerate().map(|(i, &at)| {
        let is_doubtful = doubtful.get(i).is_some_and(|doubtful| *doubtful);
        (at, COLOURS[usize::from(is_doubtful)], 9.0)
    });
    let of_markers = markers.iter().map(|marker| (single(marker), COLOURS[2], 6.0));
    // A dark rim makes dots visible on light and on dark skin.
    let dot = |(at, colour, width): ([f32; 3], [f32; 3], f32)| {
        [Mark::dot(at, colour.map(|x| 0.1 * x), width), Mark::dot(at, colour, width - 2.5)]
    };
    let marks: Vec<Mark> = of_markers.chain(of_handles).flat_map(dot).collect();

    let mut canvas = Canvas::new(painter, &face.neutral.faces, &triangles, rest.len(), SIZE)?;
    let [width, height] = SIZE;
    let mut picture = Picture::filled([VIEWS.len() as u32 * width, height + FOOT], [0; 4]);
    let mut is_named = vec![false; handles.len()];
    for (i, turn) in (0..).zip(VIEWS) {
        let camera = camera(&handles, &rest, face.up_axis, turn, SIZE);
        let mut drawn = canvas.draw(&camera, &rest, None, lift, &marks)?;
        let is_behind = behind(&camera, SIZE, &rest, &triangles, lift, &handles);
        let shown: Vec<usize> = (0..handles.len()).filter(|&h| !is_behind[h]).collect();
        let dots: Vec<[f32; 2]> =
            shown.iter().map(|&h| camera.project(SIZE, handles[h])).map(|[x, y, _]| [x, y]).collect();
        let words: Vec<&str> = shown.iter().map(|&h| face.handles.labels[h].as_str()).collect();
        for Name { words, at } in place_names(&dots, &words, SIZE) {
            drawn.write_small(words, at, NAME, RIM);
            for &h in shown.iter().filter(|&&h| face.handles.labels[h].starts_with(words)) {
                is_named[h] = true;
            }
        }
        picture.put(&drawn, [i * width, 0]);
    }
    let nameless = is_named.iter().filter(|is_named| !**is_named).count();
    let doubtful = doubtful.iter().filter(|doubtful| **doubtful).count();
    let entries = legend(handles.len(), doubtful, markers.len(), nameless);
    picture.put(&foot(&entries, picture.size[0]), [0, height]);
    let mut file = AtomicFile::create(path)?;
    file.write_all(&picture.png()?).map_err(file.error())?;
    file.finish()
}

/// An entry of the legend: its colour, if it has one, and its words.
struct Entry {
    colour: Option<[f32; 3]>,
    words: String,
}

fn legend(handles: usize, doubtful: usize, markers: usize, nameless: usize) -> Vec<Entry> {
    let entry = |colour: Option<usize>, words: String| Entry { colour: colour.map(|i| COLOURS[i]), words };
    let mut entries = vec![entry(Some(0), human::counted(handles - doubtful, "handle"))];
    if doubtful > 0 {
        entries.push(entry(Some(1), format!("{doubtful} far from their markers")));
    }
    if markers > 0 {
        entries.push(entry(Some(2), "where the markers were".to_owned()));
    }
    if nameless > 0 {
        entries.push(entry(None, format!("{} without room for a name", human::count(nameless))));
    }
    entries
}

/// The legend as a strip of `width` pixels.
fn foot(entries: &[Entry], width: u32) -> Picture {
    const DOT: u32 = 14;
    let [r, g, b, _] = Sheet::PAPER;
    let mut strip = Picture::filled([width, FOOT], [r, g, b, 255]);
    let mut x = 24;
    for Entry { colour, words } in entries {
        if let Some(colour) = colour {
            let [r, g, b] = colour.map(to_srgb);
            strip.put(&Picture::filled([DOT, DOT], [r, g, b, 255]), [x, (FOOT - DOT) / 2]);
            x += DOT + 10;
        }
        strip.write(words, [x as i32, (FOOT as i32 - 20) / 2], Anchor::Left, RIM, 1);
        x += 10 * words.chars().count() as u32 + 40;
    }
    strip
}
