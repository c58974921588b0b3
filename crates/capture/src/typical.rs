//! What a take shows before anything is known about it: a typical frame, and the markers that keep their
//! distances.
use glam::DVec3;
use rhytid_core::Take;
use rhytid_core::numbers::median;

/// At most so many frames are sampled.
const SAMPLED: usize = 400;

/// At most so many distances are kept. With many markers, fewer frames are sampled.
const KEPT: usize = 4_000_000;

/// Two markers keep their distance if it is within this part of the markers' extent of its median in nine
/// frames of ten. Skin does not.
const KEEPS: f64 = 0.0012;

/// A marker of the head moves less than this part of the face's extent towards and from the stiff parts of
/// the face.
const CHANGES: f64 = 0.03;

/// A frame is good enough if it shows this part of the markers that the fullest frame shows.
const SHOWS: f64 = 0.98;

/// Distances between the markers of some frames.
struct Distances {
    frames: Vec<usize>,
    pairs: Vec<[usize; 2]>,
    /// For each pair its distance in each frame, NaN where one of the two was not seen.
    of_pair: Vec<Vec<f64>>,
    medians: Vec<f64>,
}

impl Distances {
    fn new(take: &Take) -> Self {
        let markers = take.labels.len();
        let sampled = (2 * KEPT / (markers * markers).max(1)).clamp(20, SAMPLED);
        let step = take.frames().div_ceil(sampled).max(1);
        let frames: Vec<usize> = (0..take.frames()).step_by(step).collect();
        let at = |f: usize, m: usize| DVec3::from_array(take.positions[f * markers + m]);
        let pairs: Vec<[usize; 2]> =
            (0..markers).flat_map(|a| (a + 1..markers).map(move |b| [a, b])).collect();
        let of_pair: Vec<Vec<f64>> = pairs
            .iter()
            .map(|[a, b]| frames.iter().map(|&f| at(f, *a).distance(at(f, *b))).collect())
            .collect();
        let median = |distances: &Vec<f64>| {
            median(&mut distances.iter().copied().filter(|d| !d.is_nan()).collect::<Vec<_>>())
        };
        let medians = of_pair.iter().map(median).collect();
        Self { frames, pairs, of_pair, medians }
    }
}

/// The frame in which the markers' distances are closest to their usual ones and nearly all markers are seen.
/// In most takes this frame is neutral, since a face is at rest between expressions. 0 for a take without
/// frames.
pub(crate) fn typical_frame(take: &Take) -> usize {
    let markers = take.labels.len();
    let distances = Distances::new(take);
    let seen = |f: usize| take.positions[f * markers..][..markers].iter().filter(|p| !p[0].is_nan()).count();
    let most = distances.frames.iter().map(|&f| seen(f)).max().unwrap_or(0);
    let unlike = |i: usize| {
        let off = distances.of_pair.iter().zip(&distances.medians).map(|(of, median)| (of[i] - median).abs());
        median(&mut off.filter(|off| !off.is_nan()).collect::<Vec<_>>())
    };
    let good =
        (0..distances.frames.len()).filter(|&i| seen(distances.frames[i]) as f64 >= SHOWS * most as f64);
    let best = good.map(|i| (unlike(i), i)).min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or(0, |(_, i)| distances.frames[i])
}

/// Whether marker `m` moves with the face: a quarter of the face's markers nearly keep their distance from
/// it. Those of the forehead do so from a cap, and not from the shoulders when the head turns. `extent` is
/// the face's, in the take's unit.
pub(crate) fn moves_with(take: &Take, face: &[usize], m: usize, extent: f64) -> bool {
    let count = take.labels.len();
    let at = |f: usize, m: usize| DVec3::from_array(take.positions[f * count + m]);
    let step = take.frames().div_ceil(SAMPLED).max(1);
    let mut changes = Vec::new();
    for &other in face {
        let distance = |f| at(f, other).distance(at(f, m));
        let mut distances: Vec<f64> = (0..take.frames()).step_by(step).map(distance).collect();
        distances.retain(|distance| !distance.is_nan());
        if !distances.is_empty() {
            distances.sort_by(f64::total_cmp);
            let part = |part: f64| distances[(part * (distances.len() - 1) as f64).round() as usize];
            changes.push(part(0.9) - part(0.1));
        }
    }
    changes.sort_by(f64::total_cmp);
    changes.get(changes.len() / 4).is_some_and(|change| *change < CHANGES * extent)
}

/// The markers of `candidates` that keep their distances from each other, as those of a cap or a head band
/// do. The first set of three or more is returned, in the candidates' order. Empty where there is none.
pub(crate) fn rigid_set(take: &Take, candidates: &[usize]) -> Vec<usize> {
    let markers = take.labels.len();
    let distances = Distances::new(take);
    let extent = distances.medians.iter().copied().fold(0.0, f64::max);
    let mut keeps = vec![false; markers * markers];
    for ((pair, of), median) in distances.pairs.iter().zip(&distances.of_pair).zip(&distances.medians) {
        let mut off: Vec<f64> = of.iter().filter(|d| !d.is_nan()).map(|d| (d - median).abs()).collect();
        if off.len() < 2 {
            continue;
        }
        off.sort_by(f64::total_cmp);
        let both = off[(off.len() * 9).div_ceil(10) - 1] < KEEPS * extent;
        keeps[pair[0] * markers + pair[1]] = both;
        keeps[pair[1] * markers + pair[0]] = both;
    }
    let sets = candidates.iter().map(|&first| {
        let mut set = vec![first];
        for &next in candidates {
            if next != first && set.iter().all(|&other| keeps[other * markers + next]) {
                set.push(next);
            }
        }
        set
    });
    sets.into_iter().find(|set| set.len() >= 3).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten markers that move in frames 0..60 and rest from 60 to 100, and three of a band; all turn.
    fn take() -> Take {
        let positions = (0..100).flat_map(|f| {
            (0..13).map(move |m| {
                let p = DVec3::new(f64::from(m % 4), f64::from(m / 4), f64::from(m * m % 5)) * 30.0;
                let wave = |i: i32| f64::from(f * (m + 1) + i * (f + 2 * m)).sin();
                let moves =
                    if m < 10 && f < 60 { 6.0 * DVec3::new(wave(0), wave(1), wave(2)) } else { DVec3::ZERO };
                let turned = glam::DQuat::from_rotation_y(0.005 * f64::from(f)) * (p + moves);
                turned.to_array()
            })
        });
        Take {
            labels: (0..13).map(|m| format!("m{m}")).collect(),
            times: (0..100).map(|f| f64::from(f) / 50.0).collect(),
            positions: positions.collect(),
            ..Take::default()
        }
    }

    #[test]
    fn a_cap_moves_with_the_face_and_shoulders_do_not() {
        // Four stiff markers, six that talk, one of a cap and one of a shoulder. The head turns.
        let positions = (0..120).flat_map(|f| {
            let t = f64::from(f) / 20.0;
            (0..12).map(move |m| {
                let talks = if (4..10).contains(&m) { 8.0 * (t * f64::from(m)).sin() } else { 0.0 };
                let place = match m {
                    10 => DVec3::new(20.0, 180.0, 0.0),
                    _ => DVec3::new(f64::from(m % 4) * 40.0 - 60.0, f64::from(m / 4) * -40.0 + talks, 90.0),
                };
                let turned = glam::DQuat::from_rotation_y(0.3 * t.sin()) * place;
                if m == 11 { [150.0, -220.0, 0.0] } else { turned.to_array() }
            })
        });
        let take = Take {
            labels: (0..12).map(|m| format!("m{m}")).collect(),
            times: (0..120).map(|f| f64::from(f) / 20.0).collect(),
            positions: positions.collect(),
            ..Take::default()
        };
        let face: Vec<usize> = (0..10).collect();
        assert!(moves_with(&take, &face, 10, 150.0));
        assert!(!moves_with(&take, &face, 11, 150.0));
    }

    #[test]
    fn a_band_and_a_frame_at_rest_are_found() {
        let mut take = take();
        let all: Vec<usize> = (0..13).collect();
        assert_eq!(rigid_set(&take, &all), [10, 11, 12]);
        assert!(rigid_set(&take, &all[..12]).is_empty());
        assert!(typical_frame(&take) >= 60);
        // A frame that shows little is not typical.
        for f in 60..90 {
            take.positions[f * 13..][..4].fill([f64::NAN; 3]);
        }
        assert!(typical_frame(&take) >= 90);
        assert!(rigid_set(&take.slice(0..1), &all).is_empty());
    }
}
