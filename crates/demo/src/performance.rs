//! A short performance: the examples' handle positions, blended over time.
use crate::curve::ramp;
use rhytid_core::{Face, Take};

/// Frames per second.
const RATE: f64 = 30.0;
/// Seconds.
const LENGTH: f64 = 7.2;

/// How one example comes and goes: times in seconds and weights, with eased transitions. Before and after is
/// the rest pose.
struct Track {
    example: &'static str,
    /// The delay of the face's right side behind its left, in seconds.
    lag: f64,
    keys: &'static [[f64; 2]],
}

const TRACKS: [Track; 6] = [
    Track {
        example: "brow_raise",
        lag: 0.03,
        keys: &[
            [0.3, 0.0],
            [0.8, 1.06],
            [0.95, 1.0],
            [1.25, 1.0],
            [1.85, 0.12],
            [2.15, 0.0],
            [4.8, 0.0],
            [5.05, 0.6],
            [5.25, 0.5],
            [5.45, 0.0],
            [6.0, 0.0],
            [6.3, 1.0],
            [6.5, 1.0],
            [6.85, 0.0],
        ],
    },
    Track {
        example: "frown",
        lag: -0.02,
        keys: &[[3.35, 0.0], [3.75, 0.92], [3.95, 0.86], [4.2, 0.9], [4.75, 0.0]],
    },
    Track {
        example: "smile",
        lag: 0.07,
        keys: &[
            [1.55, 0.0],
            [2.35, 1.03],
            [2.5, 1.0],
            [2.85, 1.0],
            [3.4, 0.35],
            [3.9, 0.1],
            [4.2, 0.0],
            [5.9, 0.0],
            [6.3, 1.0],
            [6.5, 1.0],
            [6.85, 0.0],
        ],
    },
    Track {
        example: "squint",
        lag: 0.01,
        keys: &[
            [1.35, 0.0],
            [1.45, 0.8],
            [1.5, 0.7],
            [1.66, 0.0],
            [2.95, 0.0],
            [3.2, 0.55],
            [3.5, 0.5],
            [3.9, 0.1],
            [4.15, 0.0],
            [5.85, 0.0],
            [5.94, 0.85],
            [6.0, 0.75],
            [6.16, 0.0],
        ],
    },
    Track {
        example: "pucker",
        lag: 0.02,
        keys: &[[3.75, 0.0], [4.0, 0.45], [4.12, 0.2], [4.45, 0.95], [4.6, 0.85], [4.95, 0.0]],
    },
    Track {
        example: "jaw_open",
        lag: 0.0,
        keys: &[
            [3.0, 0.0],
            [3.15, 0.25],
            [3.28, 0.08],
            [3.42, 0.34],
            [3.6, 0.1],
            [3.78, 0.28],
            [3.95, 0.05],
            [4.3, 0.12],
            [4.7, 0.06],
            [4.9, 0.1],
            [5.35, 1.04],
            [5.5, 1.0],
            [5.7, 1.0],
            [6.1, 0.12],
            [6.4, 0.0],
        ],
    },
];

impl Track {
    fn weight(&self, time: f64) -> f64 {
        let after = self.keys.partition_point(|k| k[0] <= time);
        if after == 0 || after == self.keys.len() {
            return 0.0;
        }
        let ([from, start], [to, end]) = (self.keys[after - 1], self.keys[after]);
        start + (end - start) * ramp(time, from, to)
    }
}

/// A performance of 7 s at 30 frames per second for a face made by [`crate::face`]. Its expressions overlap
/// and overshoot, and one side is a little later. It begins and ends at rest. It is the same on every
/// machine.
pub fn performance(face: &Face) -> Take {
    let rest: Vec<[f64; 3]> =
        face.handles.points.iter().map(|point| point.at(&face.neutral.positions)).collect();
    let tracks: Vec<(&Track, Vec<[f64; 3]>)> = face
        .examples
        .iter()
        .filter_map(|example| {
            let track = TRACKS.iter().find(|t| t.example == example.name)?;
            let apex = face.handles.points.iter().map(|point| point.at(&example.positions)).collect();
            Some((track, apex))
        })
        .collect();
    let mut take = Take { labels: face.handles.labels.clone(), ..Take::default() };
    for frame in 0..=(LENGTH * RATE) as usize {
        let time = frame as f64 / RATE;
        take.times.push(time);
        for (h, &at_rest) in rest.iter().enumerate() {
            let right = ramp(at_rest[0], 1.0, -1.0);
            let mut p = at_rest;
            for (track, apex) in &tracks {
                let weight = track.weight(time - track.lag * right);
                for c in 0..3 {
                    p[c] += weight * (apex[h][c] - at_rest[c]);
                }
            }
            take.positions.push(p);
        }
    }
    take
}
