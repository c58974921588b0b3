//! Finds the neutral frames: half a second that is still and near the rest pose.
use crate::tracks::{Tracks, extent, median_point, seen};
use glam::DVec3;
use rayon::prelude::*;
use rhytid_geometry::registration::fit_robustly;
use std::ops::Range;

/// How long the neutral face is held, in seconds.
const LENGTH: f64 = 0.5;

/// A marker may be off by this part of the face's extent before its weight falls.
const TOLERANCE: f64 = 0.03;

/// Frames of a window that are sampled.
const SAMPLED: usize = 30;

/// The window of half a second that is most neutral; the whole take if it is shorter. `columns` has one entry
/// per point of `rest`. The score of a window is the sum of two RMS distances: the distance to the rest pose
/// up to a similarity, and the motion within the window. The lowest score wins. `None` if no window shows at
/// least four markers and half of those that the best one shows.
pub(crate) fn find(tracks: &Tracks, columns: &[Option<usize>], rest: &[DVec3]) -> Option<Range<usize>> {
    let length = tracks.frames_in(LENGTH).min(tracks.frames());
    let step = (length / 5).max(1);
    let starts: Vec<usize> = (0..=tracks.frames() - length).step_by(step).collect();
    let windows: Vec<(usize, usize, f64)> = starts
        .into_par_iter()
        .filter_map(|start| {
            let (markers, score) = score(tracks, columns, rest, start..start + length)?;
            Some((start, markers, score))
        })
        .collect();
    let most = windows.iter().map(|(_, markers, _)| *markers).max()?;
    let fit_ones = windows.iter().filter(|(_, markers, _)| *markers >= 4 && 2 * *markers >= most);
    let (start, _, _) = fit_ones.min_by(|a, b| a.2.total_cmp(&b.2))?;
    Some(*start..start + length)
}

/// How many markers the window shows, and how unlike the neutral face it is, in units of `rest`.
fn score(
    tracks: &Tracks,
    columns: &[Option<usize>],
    rest: &[DVec3],
    window: Range<usize>,
) -> Option<(usize, f64)> {
    let step = window.len().div_ceil(SAMPLED).max(1);
    let mut means = vec![DVec3::NAN; rest.len()];
    let (mut squares, mut count) = (0.0, 0_usize);
    for (mean, column) in means.iter_mut().zip(columns) {
        let Some(column) = *column else { continue };
        let points = || tracks.columns[column][window.clone()].iter().step_by(step).filter(|p| seen(**p));
        let n = points().count();
        if 2 * n * step < window.len() {
            continue;
        }
        *mean = points().sum::<DVec3>() / n as f64;
        squares += points().map(|p| p.distance_squared(*mean)).sum::<f64>();
        count += n;
    }
    let shown = means.iter().filter(|p| seen(**p)).count();
    // A handle that is misplaced on the rig is off in all frames, and says nothing of any of them.
    let tolerance = TOLERANCE * extent(rest.iter().copied());
    let (fitted, _) = fit_robustly(&means, rest, true, tolerance)?;
    let left = means.iter().zip(rest).filter(|(p, _)| seen(**p)).map(|(p, q)| fitted.apply(*p).distance(*q));
    let unlike =
        tolerance * (left.map(|d| (d / tolerance).powi(2).ln_1p()).sum::<f64>() / shown as f64).sqrt();
    let moving = fitted.scale * (squares / count as f64).sqrt();
    Some((shown, unlike + moving))
}

/// Where each column is in the frames `neutral`: the median; NaN where it was not seen.
pub(crate) fn pose(tracks: &Tracks, columns: &[Option<usize>], neutral: &Range<usize>) -> Vec<DVec3> {
    let at = |column: &Option<usize>| {
        let column = column.map(|c| &tracks.columns[c][neutral.clone()]);
        median_point(column.unwrap_or_default().iter().copied().filter(|p| seen(*p)))
    };
    columns.iter().map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_still_neutral_second_is_found() {
        let rest: Vec<DVec3> =
            (0..12).map(|i| DVec3::new(f64::from(i % 4), f64::from(i / 4), f64::from(i * i % 5))).collect();
        // Frames 0 to 100 hold a slightly different shape, and frames 160 to 230 the neutral one. In between
        // and after that the shape moves. It passes through the neutral shape at 300.
        let amount = |f: usize| match f {
            0..100 => 0.3,
            100..160 => 0.3 + 0.01 * (f - 100) as f64,
            160..230 => 0.0,
            _ => (f as f64 - 300.0) * 0.02,
        };
        let columns: Vec<Vec<DVec3>> = (0..12)
            .map(|i| {
                (0..400)
                    .map(|f| {
                        let p = rest[i] + DVec3::new(0.0, 0.0, (i % 3) as f64) * amount(f);
                        DVec3::new(-p.z, p.y, p.x) * 10.0 + DVec3::new(1.0, 2.0, 3.0)
                    })
                    .collect()
            })
            .collect();
        let tracks = Tracks { columns, rate: 100.0 };
        let columns: Vec<Option<usize>> = (0..12).map(Some).collect();
        let found = find(&tracks, &columns, &rest).unwrap();
        assert!(found.len() == 50 && found.start >= 160 && found.end <= 230, "{found:?}");
    }
}
