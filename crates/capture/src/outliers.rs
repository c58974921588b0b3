//! Outliers: positions at which a marker cannot have been, such as reflections that were taken for it.
//!
//! A marker is compared with its neighbours on the face, which a real motion takes along. If a marker jumps
//! away from them faster than skin moves, and back within a tenth of a second, the positions between are not
//! its own.
use crate::neighbours::nearest;
use crate::tracks::{Tracks, extent, median_point, seen};
use glam::DVec3;
use rayon::prelude::*;

/// Positions of one marker that were dropped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Outlier {
    /// The column.
    pub marker: usize,
    /// First frame.
    pub first: usize,
    /// Number of frames, those without a position included.
    pub frames: usize,
    /// How far it jumped, in the tracks' unit.
    pub distance: f64,
}

/// The smallest jump, as a part of the face's extent.
const SMALLEST_JUMP: f64 = 0.02;

/// Skin does not move faster against the skin around it, in extents of the face a second.
const FASTEST: f64 = 2.0;

/// Outliers last this many seconds at most.
const LONGEST: f64 = 0.1;

/// Finds outliers and makes them NaN. `rest` holds the markers' positions at neutral, `extent` is the face's.
pub(crate) fn drop(tracks: &mut Tracks, rest: &[DVec3], extent: f64) -> Vec<Outlier> {
    let found = of_each(tracks, &nearest(rest, 5), rest, |j, against| of_marker(j, against, tracks, extent));
    for outlier in &found {
        tracks.columns[outlier.marker][outlier.first..outlier.first + outlier.frames].fill(DVec3::NAN);
    }
    found
}

/// Jumps that remain in displacements without gaps: markers that jump and do not return. `rest` holds the
/// markers' positions at neutral.
pub(crate) fn steps(displacements: &Tracks, rest: &[DVec3]) -> Vec<Outlier> {
    let (rate, extent) = (displacements.rate, extent(rest.iter().copied()));
    of_each(displacements, &nearest(rest, 5), &vec![DVec3::ZERO; rest.len()], |marker, against| {
        let jumps = against.windows(2).filter(|pair| is_jump(pair[0], pair[1], rate, extent));
        jumps
            .map(|pair| Outlier {
                marker,
                first: pair[1].0,
                frames: 1,
                distance: pair[0].1.distance(pair[1].1),
            })
            .collect()
    })
}

/// A frame in which a marker was seen, and where it was against its neighbours.
type Against = (usize, DVec3);

/// What `find` finds of each marker.
fn of_each(
    tracks: &Tracks,
    neighbours: &[Vec<usize>],
    rest: &[DVec3],
    find: impl Fn(usize, &[Against]) -> Vec<Outlier> + Sync,
) -> Vec<Outlier> {
    let columns = &tracks.columns;
    let of_marker = |j: usize| {
        let against: Vec<Against> = (0..tracks.frames())
            .filter(|&f| seen(columns[j][f]))
            .map(|f| {
                let others = neighbours[j].iter().map(|&n| columns[n][f] - rest[n]).filter(|p| seen(*p));
                let moved = median_point(others);
                (f, columns[j][f] - if seen(moved) { moved } else { DVec3::ZERO })
            })
            .collect();
        find(j, &against)
    };
    (0..columns.len()).into_par_iter().flat_map_iter(of_marker).collect()
}

fn is_jump(a: Against, b: Against, rate: f64, extent: f64) -> bool {
    is_jump_within(a.1, b.1, (b.0 - a.0) as f64 / rate, extent)
}

/// Whether no skin moves from `a` to `b`, both against its neighbours, in so many seconds.
pub(crate) fn is_jump_within(a: DVec3, b: DVec3, seconds: f64, extent: f64) -> bool {
    // After a longer gap a marker may be anywhere on its way.
    seconds <= 2.0 * LONGEST && a.distance(b) > extent * (FASTEST * seconds).max(SMALLEST_JUMP)
}

fn of_marker(j: usize, against: &[Against], tracks: &Tracks, extent: f64) -> Vec<Outlier> {
    let longest = tracks.frames_in(LONGEST);
    let is_jump = |a: Against, b: Against| is_jump(a, b, tracks.rate, extent);
    let mut found = Vec::new();
    let mut i = 1;
    while i < against.len() {
        let before = against[i - 1];
        if is_jump(before, against[i]) {
            let away = against[i].1.distance(before.1);
            let end = (i + 1..against.len()).take_while(|&k| against[k - 1].0 < against[i].0 + longest).find(
                |&k| is_jump(against[k - 1], against[k]) && against[k].1.distance(before.1) < 0.5 * away,
            );
            if let Some(end) = end {
                let (first, last) = (against[i].0, against[end - 1].0);
                found.push(Outlier { marker: j, first, frames: last + 1 - first, distance: away });
                i = end + 1;
                continue;
            }
        }
        i += 1;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn face() -> (Tracks, Vec<DVec3>) {
        let rest: Vec<DVec3> =
            (0..25).map(|i| DVec3::new(f64::from(i % 5) * 3.0, f64::from(i / 5) * 3.0, 0.0)).collect();
        // A fast nod of the lower half that all of it makes, as of a jaw.
        let columns = rest
            .iter()
            .map(|r| {
                let reach = (9.0 - r.y).max(0.0) / 4.0;
                (0..400).map(|f| *r + DVec3::Y * (reach * (f64::from(f) * 0.3).sin().max(0.0))).collect()
            })
            .collect();
        (Tracks { columns, rate: 120.0 }, rest)
    }

    #[test]
    fn ghosts_are_dropped_and_nothing_else() {
        let (mut tracks, rest) = face();
        let truth = tracks.clone();
        let extent = 17.0;
        let ghosts = [(3, 50, 1, 4.0), (3, 60, 1, 1.0), (7, 51, 3, 2.0), (24, 200, 10, 5.0), (8, 51, 1, 4.0)];
        for (marker, first, frames, height) in ghosts {
            for f in first..first + frames {
                tracks.columns[marker][f] += DVec3::Z * height;
            }
        }
        tracks.columns[11][100..140].fill(DVec3::NAN);
        let found = drop(&mut tracks, &rest, extent);
        let places: Vec<_> = found.iter().map(|o| (o.marker, o.first, o.frames)).collect();
        assert_eq!(places, [(3, 50, 1), (3, 60, 1), (7, 51, 3), (8, 51, 1), (24, 200, 10)]);
        assert!((found[0].distance - 4.0).abs() < 0.5, "{found:?}");
        for (found, truth) in tracks.columns.iter().zip(&truth.columns) {
            assert!(found.iter().zip(truth).all(|(a, b)| a.is_nan() || a == b));
        }
        let dropped = tracks.columns.iter().flatten().filter(|p| p.is_nan()).count();
        assert_eq!(dropped, 40 + 1 + 1 + 3 + 10 + 1);
    }

    #[test]
    fn what_stays_where_it_jumped_to_is_no_outlier() {
        let (mut tracks, rest) = face();
        tracks.columns[12][200..].iter_mut().for_each(|p| *p += DVec3::Z * 4.0);
        assert!(drop(&mut tracks, &rest, 17.0).is_empty());
        for (column, rest) in tracks.columns.iter_mut().zip(&rest) {
            column.iter_mut().for_each(|p| *p -= *rest);
        }
        let found = steps(&tracks, &rest);
        assert!(found.len() == 1 && (found[0].marker, found[0].first) == (12, 200), "{found:?}");
    }
}
