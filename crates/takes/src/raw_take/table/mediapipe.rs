//! The 468 or 478 landmarks of MediaPipe's face mesh, in coordinates of an image.
use super::Found;
use rhytid_core::RawTake;
use rhytid_core::numbers::median;
use std::collections::{BTreeMap, HashMap};

/// The landmarks of the face, without and with those of the irises.
const LANDMARKS: [usize; 2] = [468, 478];

/// Coordinates beyond this are pixels and not parts of the image.
const NORMALISED: f64 = 4.0;

/// A face with less depth than this part of its width has lost its depth.
const FLAT: f64 = 0.05;

/// The height of MediaPipe's own face in millimetres, from the highest landmark to the lowest.
const HEIGHT: f64 = 176.7;

/// MediaPipe's own face: the height from landmark 10 to 152, as a part of the width from 234 to 454.
const PROPORTION: f64 = 17.67 / 15.33;

/// The usual images, width by height.
const IMAGES: [[f64; 2]; 7] =
    [[16.0, 9.0], [4.0, 3.0], [3.0, 2.0], [1.0, 1.0], [2.0, 3.0], [3.0, 4.0], [9.0, 16.0]];

/// Whether these labels have MediaPipe's landmarks of a face among them.
pub(crate) fn is_face_mesh<'a>(labels: impl Iterator<Item = &'a str>) -> bool {
    mesh(&labels.map(str::to_owned).collect::<Vec<_>>()).is_some()
}

/// Whether MediaPipe's landmarks are among the labels. If they are, they become `mesh0` and so on, and the
/// others are left out, such as those of the body. The positions get equal axes: x to the right of the image,
/// y up and z to the camera. The face gets a usual height, in millimetres.
pub(super) fn recognise(found: &mut Found) -> bool {
    let Some(mesh) = mesh(&found.labels) else { return false };
    let others = found.labels.len() - mesh.len();
    if others > 0 {
        found.warnings.push(format!(
            "{others} markers are none of the face mesh of {} landmarks and are left out",
            mesh.len()
        ));
        let m = found.labels.len();
        let places =
            || (0..found.positions.len() / m).flat_map(|frame| mesh.iter().map(move |l| frame * m + l.place));
        (found.positions, found.confidence) =
            (places().map(|i| found.positions[i]).collect(), places().map(|i| found.confidence[i]).collect());
    }
    let numbers: Vec<usize> = mesh.iter().map(|landmark| landmark.number).collect();
    found.labels = numbers.iter().map(|number| format!("mesh{number}")).collect();
    // No landmark is exactly in the image's corner.
    for position in found.positions.iter_mut().filter(|position| **position == [0.0; 3]) {
        *position = RawTake::MISSING;
    }
    let seen = || found.positions.iter().filter(|p| !p[0].is_nan());
    let largest = seen().map(|[x, y, _]| x.abs().max(y.abs())).fold(0.0, f64::max);
    let m = found.labels.len();
    let scales: Vec<[f64; 3]> = if largest > NORMALISED {
        vec![[1.0; 3]; found.positions.len() / m]
    } else {
        of_images(found, &numbers)
    };
    for (frame, [x, y, z]) in found.positions.chunks_exact_mut(m).zip(scales) {
        frame.iter_mut().for_each(|p| *p = [p[0] * x, -p[1] * y, -p[2] * z]);
    }
    if let Some(height) = height(found, m).filter(|height| *height > 0.0) {
        found.positions.as_flattened_mut().iter_mut().for_each(|x| *x *= HEIGHT / height);
        found.unit = "mm".into();
    }
    if let Some(depth) = depth(found, &numbers).filter(|depth| *depth < FLAT) {
        found.warnings.push(format!(
            "the face is flat: its depth is {depth:.3} of its width; write z in the same unit as x, as MediaPipe gives \
             it"
        ));
    }
    true
}

/// A landmark of the face.
struct Landmark {
    /// Its place among the labels.
    place: usize,
    /// Its number after MediaPipe, from 0.
    number: usize,
}

/// The landmarks of the face, in the order of the labels: all labels that are one word with the numbers of a
/// whole face. `None` if there are none. People count from 0 or 1.
fn mesh(labels: &[String]) -> Option<Vec<Landmark>> {
    if labels.len() < LANDMARKS[0] {
        return None;
    }
    let mut by_word: BTreeMap<&str, Vec<Landmark>> = BTreeMap::new();
    for (place, label) in labels.iter().enumerate() {
        let word = label.trim_end_matches(|c: char| c.is_ascii_digit());
        if let Ok(number) = label[word.len()..].parse() {
            by_word.entry(word).or_default().push(Landmark { place, number });
        }
    }
    by_word.into_values().find_map(|mut landmarks| {
        let mut sorted: Vec<usize> = landmarks.iter().map(|landmark| landmark.number).collect();
        sorted.sort_unstable();
        let first = sorted[0];
        let is_all = LANDMARKS.contains(&sorted.len())
            && first <= 1
            && sorted.iter().enumerate().all(|(i, &number)| number == first + i);
        landmarks.iter_mut().for_each(|landmark| landmark.number -= first);
        is_all.then_some(landmarks)
    })
}

/// The factors of x, y and z in each frame that give equal axes, by the image's width and height.
fn of_images(found: &mut Found, numbers: &[usize]) -> Vec<[f64; 3]> {
    let m = numbers.len();
    let frames = found.positions.len() / m;
    let is_said = found.images.len() == frames
        && found.images.iter().all(|[w, h]| w.is_finite() && h.is_finite() && *w > 0.0 && *h > 0.0);
    if is_said {
        return found.images.iter().map(|[w, h]| [*w, *h, *w]).collect();
    }
    let [w, h] = fitting(found, numbers);
    found.warnings.push(format!(
        "the table has parts of an image and does not say its width and height; {w} by {h} fits the face best and is \
         taken: add the columns width and height if the image has other proportions"
    ));
    vec![[w, h, w]; frames]
}

/// The usual image in which the face has the proportions of a face.
fn fitting(found: &Found, numbers: &[usize]) -> [f64; 2] {
    let place: HashMap<usize, usize> = numbers.iter().enumerate().map(|(i, &number)| (number, i)).collect();
    let m = numbers.len();
    let mut aspects: Vec<f64> = Vec::new();
    for frame in found.positions.chunks_exact(m) {
        let between = |a: usize, b: usize| -> [f64; 2] {
            let [a, b] = [frame[place[&a]], frame[place[&b]]];
            let d: [f64; 3] = std::array::from_fn(|c| a[c] - b[c]);
            [d[0] * d[0] + d[2] * d[2], d[1] * d[1]]
        };
        let ([across_h, down_h], [across_w, down_w]) = (between(10, 152), between(234, 454));
        // (down_h + a² across_h) = PROPORTION² (down_w + a² across_w), with a the width by the height.
        let squared = PROPORTION * PROPORTION;
        let aspect = ((down_h - squared * down_w) / (squared * across_w - across_h)).sqrt();
        if aspect.is_finite() {
            aspects.push(aspect);
        }
    }
    let aspect = if aspects.is_empty() { 16.0 / 9.0 } else { median(&mut aspects) };
    let off = |[w, h]: &[f64; 2]| (w / h / aspect).ln().abs();
    IMAGES.into_iter().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or([1.0, 1.0])
}

/// The median height of the face; `None` where no frame shows all landmarks.
fn height(found: &Found, m: usize) -> Option<f64> {
    let height = |frame: &[[f64; 3]]| {
        let bound = |of: fn(f64, f64) -> f64, from: f64| frame.iter().map(|p| p[1]).fold(from, of);
        bound(f64::max, f64::NEG_INFINITY) - bound(f64::min, f64::INFINITY)
    };
    let whole = found.positions.chunks_exact(m).filter(|frame| frame.iter().all(|p| p[1].is_finite()));
    let mut heights: Vec<f64> = whole.map(height).collect();
    if heights.is_empty() { None } else { Some(median(&mut heights)) }
}

/// The depth from the nose's tip to the ears, as a part of the face's width; `None` where they are not seen.
fn depth(found: &Found, numbers: &[usize]) -> Option<f64> {
    let place = |number: usize| numbers.iter().position(|n| *n == number);
    let (nose, left, right) = (place(1)?, place(234)?, place(454)?);
    let mut depths: Vec<f64> = Vec::new();
    for frame in found.positions.chunks_exact(numbers.len()) {
        let width = (0..3).map(|c| (frame[left][c] - frame[right][c]).powi(2)).sum::<f64>().sqrt();
        let depth = (frame[nose][2] - (frame[left][2] + frame[right][2]) / 2.0).abs() / width;
        if depth.is_finite() {
            depths.push(depth);
        }
    }
    if depths.is_empty() { None } else { Some(median(&mut depths)) }
}
