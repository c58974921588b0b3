//! What a take shows of up and down, before anything is known about the face: where its head is above the
//! floor and above the body, and which markers move most.
use crate::tracks::{extent, median_point, seen};
use glam::{DMat3, DVec3};
use rhytid_core::Take;
use rhytid_core::numbers::median;
use rhytid_geometry::registration::fit_robustly;

/// Frames that are sampled.
const SAMPLED: usize = 150;

/// Markers that are off by this part of the face's extent move by themselves, and not with the head.
const TOLERANCE: f64 = 0.02;

/// The posture of an actor, in the take's unit and axes.
pub(crate) struct Posture {
    /// The mean turn of the head from the frame to the others.
    pub turn: DMat3,
    /// The mean place of the face.
    pub place: DVec3,
    /// From the middle of the markers elsewhere on the body to the face; zero without such markers.
    pub from_body: DVec3,
    /// M: how far each marker moves on the head; NaN where that is not known.
    pub motion: Vec<f64>,
}

impl Posture {
    /// The posture in a take. `face` are the columns of the face, of which `frame` shows the reference, and
    /// `body` are other columns.
    pub(crate) fn new(take: &Take, face: &[usize], body: &[usize], frame: usize) -> Self {
        let count = take.labels.len();
        let at = |f: usize, m: usize| DVec3::from_array(take.positions[f * count + m]);
        let of = |f: usize, columns: &[usize]| -> Vec<DVec3> { columns.iter().map(|&m| at(f, m)).collect() };
        let reference = of(frame, face);
        let tolerance = TOLERANCE * extent(reference.iter().copied());
        let step = take.frames().div_ceil(SAMPLED).max(1);
        let (mut turn, mut places, mut offsets) = (DMat3::ZERO, Vec::new(), Vec::new());
        let mut moved: Vec<Vec<f64>> = vec![Vec::new(); count];
        for f in (0..take.frames()).step_by(step) {
            let now = of(f, face);
            let place = median_point(now.iter().copied().filter(|p| seen(*p)));
            let of_body = median_point(of(f, body).into_iter().filter(|p| seen(*p)));
            if seen(place) {
                places.push(place);
            }
            if seen(place - of_body) {
                offsets.push(place - of_body);
            }
            if let Some((motion, _)) = fit_robustly(&reference, &now, false, tolerance) {
                turn += DMat3::from_quat(motion.rotation);
                for ((before, now), &m) in reference.iter().zip(&now).zip(face) {
                    moved[m].push(motion.apply(*before).distance(*now));
                }
            }
        }
        let mean = |points: &[DVec3]| points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        // Most of what a marker does is rest, so the median says little.
        let most = |mut moved: Vec<f64>| {
            moved.retain(|x| !x.is_nan());
            moved.sort_by(f64::total_cmp);
            moved.get(moved.len() * 9 / 10).copied().unwrap_or(f64::NAN)
        };
        Self {
            turn: if turn == DMat3::ZERO { DMat3::IDENTITY } else { turn },
            place: mean(&places),
            from_body: mean(&offsets),
            motion: moved.into_iter().map(most).collect(),
        }
    }

    /// How much more the markers move where they are higher, from −1 to 1, and how far those move that move
    /// most. `heights` are those of the `columns`, in any unit. Zero for fewer than eight markers.
    pub(crate) fn motion_above(&self, columns: &[usize], heights: &[f64]) -> (f64, f64) {
        let pairs: Vec<(f64, f64)> = columns
            .iter()
            .map(|&m| self.motion[m])
            .zip(heights.iter().copied())
            .filter(|(m, _)| !m.is_nan())
            .collect();
        if pairs.len() < 8 {
            return (0.0, 0.0);
        }
        let count = pairs.len() as f64;
        let (motion, height) =
            pairs.iter().fold((0.0, 0.0), |(m, h), pair| (m + pair.0 / count, h + pair.1 / count));
        let (mut both, mut motions, mut heights) = (0.0, 0.0, 0.0);
        for (m, h) in &pairs {
            both += (m - motion) * (h - height);
            motions += (m - motion).powi(2);
            heights += (h - height).powi(2);
        }
        let correlation = both / (motions * heights).sqrt().max(f64::MIN_POSITIVE);
        let mut moved: Vec<f64> = pairs.iter().map(|(m, _)| *m).collect();
        moved.sort_by(f64::total_cmp);
        (correlation.clamp(-1.0, 1.0), median(&mut moved[pairs.len() * 3 / 4..].to_vec()))
    }
}
