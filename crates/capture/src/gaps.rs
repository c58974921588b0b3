//! Gaps: splines fill short gaps, and the low-rank model of the take fills longer ones. Positions that cannot
//! be known are held and flagged.
use crate::low_rank::{Model, WHOLE};
use crate::neighbours::nearest;
use crate::report::Kind;
use crate::tracks::{Tracks, gaps, seen};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// One gap of one marker, filled.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Filled {
    /// The column.
    pub marker: usize,
    /// Its frames.
    pub frames: Range<usize>,
    /// [`Kind::Spline`], [`Kind::Model`], [`Kind::Lost`] or [`Kind::NeverSeen`].
    pub kind: Kind,
}

/// Gaps of at most this many seconds are filled by a spline.
const SHORT: f64 = 0.1;

/// A held marker returns to where it is seen again in this many seconds.
const RETURN: f64 = 0.25;

/// Holds a marker's displacement over these frames.
pub(crate) fn hold(tracks: &mut Tracks, marker: Option<usize>, frames: Range<usize>) {
    let Some(marker) = marker else { return };
    let held = held(&tracks.columns[marker], &frames, tracks.frames_in(RETURN));
    tracks.columns[marker][frames].copy_from_slice(&held);
}

/// Fills the displacements' gaps. A gap of more than `limit` seconds, or with a frame in which no marker is
/// seen, is [`Kind::Lost`]. `rest` holds the markers' positions at neutral; `noise` is the standard deviation
/// of a coordinate.
pub(crate) fn fill(tracks: &mut Tracks, rest: &[DVec3], limit: f64, noise: f64) -> Vec<Filled> {
    let [short, limit] = [SHORT, limit].map(|seconds| (seconds * tracks.rate).round() as usize);
    let is_empty: Vec<bool> =
        (0..tracks.frames()).into_par_iter().map(|f| tracks.columns.iter().all(|c| !seen(c[f]))).collect();
    let mut filled = Vec::new();
    for (marker, column) in tracks.columns.iter().enumerate() {
        for frames in gaps(column) {
            let is_lost = || frames.len() > limit || is_empty[frames.clone()].iter().any(|empty| *empty);
            let at_an_end = frames.start == 0 || frames.end == column.len();
            let kind = match () {
                () if frames.len() == column.len() => Kind::NeverSeen,
                () if is_lost() => Kind::Lost,
                () if frames.len() <= short && !at_an_end => Kind::Spline,
                () => Kind::Model,
            };
            filled.push(Filled { marker, frames, kind });
        }
    }
    let needs_model = filled.iter().any(|gap| matches!(gap.kind, Kind::Model | Kind::Lost));
    let model = needs_model.then(|| Model::learn(tracks, noise, WHOLE)).flatten();
    let expected = model.map(|model| (expectations(tracks, &model, &filled), model));
    let values: Vec<Vec<DVec3>> = filled
        .par_iter()
        .map(|gap| {
            let column = &tracks.columns[gap.marker];
            match (gap.kind, &expected) {
                (Kind::NeverSeen, _) => Vec::new(),
                (Kind::Spline, _) => spline(column, &gap.frames),
                (_, Some((expected, model))) => {
                    let ends = ends(tracks, gap, model);
                    bridged(column, gap, expected, ends, &is_empty, tracks.frames_in(RETURN))
                }
                (_, None) => held(column, &gap.frames, tracks.frames_in(RETURN)),
            }
        })
        .collect();
    for (gap, values) in filled.iter().zip(values).filter(|(gap, _)| gap.kind != Kind::NeverSeen) {
        tracks.columns[gap.marker][gap.frames.clone()].copy_from_slice(&values);
    }
    with_neighbours(tracks, rest, &filled);
    filled
}

/// A cubic between the ends. The velocity at each end is that of the line through the last few positions
/// there.
fn spline(column: &[DVec3], gap: &Range<usize>) -> Vec<DVec3> {
    const REACH: usize = 4;
    let before: Vec<usize> =
        (gap.start.saturating_sub(REACH)..gap.start).rev().take_while(|&f| seen(column[f])).collect();
    let after: Vec<usize> =
        (gap.end..column.len().min(gap.end + REACH)).take_while(|&f| seen(column[f])).collect();
    let velocity = |frames: &[usize]| {
        let n = frames.len() as f64;
        let middle = frames.iter().sum::<usize>() as f64 / n;
        let (mut along, mut total) = (DVec3::ZERO, 0.0);
        for &f in frames {
            let t = f as f64 - middle;
            along += column[f] * t;
            total += t * t;
        }
        if total > 0.0 { along / total } else { DVec3::ZERO }
    };
    let (a, b) = (column[gap.start - 1], column[gap.end]);
    let length = (gap.len() + 1) as f64;
    let (va, vb) = (velocity(&before) * length, velocity(&after) * length);
    gap.clone()
        .map(|f| {
            let t = (f + 1 - gap.start) as f64 / length;
            let (t2, t3) = (t * t, t * t * t);
            a * (2.0 * t3 - 3.0 * t2 + 1.0)
                + va * (t3 - 2.0 * t2 + t)
                + b * (3.0 * t2 - 2.0 * t3)
                + vb * (t3 - t2)
        })
        .collect()
}

/// What the model expects in the gaps that it fills, by frame.
fn expectations(tracks: &Tracks, model: &Model, filled: &[Filled]) -> Vec<Option<Vec<DVec3>>> {
    let mut needed = vec![false; tracks.frames()];
    for gap in filled.iter().filter(|gap| matches!(gap.kind, Kind::Model | Kind::Lost)) {
        needed[gap.frames.clone()].fill(true);
    }
    let frames = needed.into_par_iter().enumerate();
    frames.map(|(f, needed)| needed.then(|| model.frame(tracks, f))).collect()
}

/// Number of positions on either side of a gap from which the model's error there is measured.
const ENDS: usize = 3;

/// The model's error right before and right after a gap, when the model does not see the marker there either.
fn ends(tracks: &Tracks, gap: &Filled, model: &Model) -> [DVec3; 2] {
    let Range { start, end } = gap.frames;
    let off = |frames: Range<usize>| {
        let off = frames
            .map(|f| tracks.columns[gap.marker][f] - model.without(tracks, f, gap.marker))
            .filter(|p| seen(*p));
        let (sum, n) = off.fold((DVec3::ZERO, 0), |(sum, n), p| (sum + p, n + 1));
        (n > 0).then(|| sum / f64::from(n))
    };
    let (a, b) = (off(start.saturating_sub(ENDS)..start), off(end..(end + ENDS).min(tracks.frames())));
    [a.or(b).unwrap_or(DVec3::ZERO), b.or(a).unwrap_or(DVec3::ZERO)]
}

/// The model's positions, moved so that they meet the seen positions at both ends. Where no marker was seen,
/// the last position is held.
fn bridged(
    column: &[DVec3],
    gap: &Filled,
    expected: &[Option<Vec<DVec3>>],
    ends: [DVec3; 2],
    is_empty: &[bool],
    back: usize,
) -> Vec<DVec3> {
    let at = |f: usize| expected[f].as_ref().map_or(DVec3::NAN, |frame| frame[gap.marker]);
    let Range { start, end } = gap.frames;
    let [a, b] = ends;
    let mut values: Vec<DVec3> = gap
        .frames
        .clone()
        .map(|f| {
            let s = (f + 1 - start) as f64 / (end - start + 1) as f64;
            if is_empty[f] { DVec3::NAN } else { at(f) + a.lerp(b, s) }
        })
        .collect();
    let mut whole = Vec::with_capacity(values.len() + 2);
    whole.push(if start > 0 { column[start - 1] } else { DVec3::NAN });
    whole.append(&mut values);
    whole.push(column.get(end).copied().unwrap_or(DVec3::NAN));
    for empty in gaps(&whole) {
        let held = held(&whole, &empty, back);
        whole[empty].copy_from_slice(&held);
    }
    whole[1..=gap.frames.len()].to_vec()
}

/// The position before the gap, which moves to the position behind the gap in the last `back` frames. At an
/// end of the take the only position there is is held. Without any position the result is 0.
fn held(column: &[DVec3], gap: &Range<usize>, back: usize) -> Vec<DVec3> {
    let before = gap.start.checked_sub(1).map(|f| column[f]).filter(|p| seen(*p));
    let behind = column.get(gap.end).copied().filter(|p| seen(*p));
    let (Some(a), Some(b)) = (before.or(behind), behind.or(before)) else {
        return vec![DVec3::ZERO; gap.len()];
    };
    gap.clone()
        .map(|f| {
            let left = (gap.end - f) as f64 / (back.min(gap.len()) + 1) as f64;
            let s = (1.0 - left).max(0.0);
            a.lerp(b, s * s * (3.0 - 2.0 * s))
        })
        .collect()
}

/// Gives a marker that was never seen the mean motion of its neighbours, weighted by 1 / distance² at rest.
fn with_neighbours(tracks: &mut Tracks, rest: &[DVec3], filled: &[Filled]) {
    let never: Vec<usize> =
        filled.iter().filter(|gap| gap.kind == Kind::NeverSeen).map(|gap| gap.marker).collect();
    let known: Vec<usize> = (0..rest.len()).filter(|j| !never.contains(j)).collect();
    for &j in &never {
        let mut points = vec![rest[j]];
        points.extend(known.iter().map(|&k| rest[k]));
        let near: Vec<(usize, f64)> = nearest(&points, 6)[0]
            .iter()
            .map(|&i| (known[i - 1], 1.0 / rest[j].distance_squared(points[i]).max(f64::MIN_POSITIVE)))
            .collect();
        let total: f64 = near.iter().map(|(_, w)| w).sum();
        let column = (0..tracks.frames())
            .map(|f| near.iter().map(|(k, w)| tracks.columns[*k][f] * (w / total)).sum())
            .collect();
        tracks.columns[j] = column;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tracks() -> (Tracks, Vec<DVec3>) {
        let rest: Vec<DVec3> = (0..9).map(|i| DVec3::new(f64::from(i % 3), f64::from(i / 3), 0.0)).collect();
        let at = |r: &DVec3, f: usize| {
            let t = f as f64 / 120.0;
            DVec3::new((3.0 * t).sin() * r.y, (5.0 * t).cos() * (1.0 + r.x), 0.3 * (2.0 * t).sin())
        };
        let columns = rest.iter().map(|r| (0..600).map(|f| at(r, f)).collect()).collect();
        (Tracks { columns, rate: 120.0 }, rest)
    }

    fn check(gap: (usize, Range<usize>), kind: Kind, tolerance: f64) {
        let (truth, rest) = tracks();
        let mut tracks = truth.clone();
        tracks.columns[gap.0][gap.1.clone()].fill(DVec3::NAN);
        let filled = fill(&mut tracks, &rest, 2.0, 1e-4);
        assert_eq!(filled, [Filled { marker: gap.0, frames: gap.1, kind }]);
        for (found, truth) in tracks.columns.iter().flatten().zip(truth.columns.iter().flatten()) {
            assert!(found.distance(*truth) < tolerance, "{found} {truth}");
        }
    }

    #[test]
    fn each_kind_of_gap() {
        check((4, 100..110), Kind::Spline, 2e-2);
        check((4, 100..101), Kind::Spline, 2e-3);
        check((4, 100..300), Kind::Model, 2e-2);
        check((4, 0..5), Kind::Model, 2e-2);
        check((4, 595..600), Kind::Model, 2e-2);
        check((4, 100..400), Kind::Lost, 2e-2);
        // Its neighbours move about as the marker does.
        check((4, 0..600), Kind::NeverSeen, 0.2);
    }

    #[test]
    fn what_is_filled_meets_both_ends_where_a_marker_moves_alone() {
        let (mut truth, rest) = tracks();
        for (f, p) in truth.columns[4].iter_mut().enumerate() {
            *p += DVec3::X * 0.8 * (f as f64 / 110.0).sin();
        }
        let mut tracks = truth.clone();
        tracks.columns[4][200..300].fill(DVec3::NAN);
        fill(&mut tracks, &rest, 2.0, 0.05);
        for f in [200, 299] {
            let off = tracks.columns[4][f].distance(truth.columns[4][f]);
            assert!(off < 0.05, "frame {f}: {off}");
        }
    }

    #[test]
    fn when_all_is_lost_the_face_is_held() {
        let (truth, rest) = tracks();
        let mut tracks = truth.clone();
        tracks.columns.iter_mut().for_each(|column| column[200..320].fill(DVec3::NAN));
        let filled = fill(&mut tracks, &rest, 2.0, 1e-4);
        assert_eq!(filled.len(), 9);
        assert!(filled.iter().all(|gap| gap.kind == Kind::Lost && gap.frames == (200..320)));
        for (column, truth) in tracks.columns.iter().zip(&truth.columns) {
            assert!(column[200..280].iter().all(|p| p.distance(truth[199]) < 1e-9));
            assert!(column[319].distance(truth[320]) < 0.05);
            assert!(column.iter().all(|p| p.is_finite()));
        }
    }

    #[test]
    fn a_limit_of_nothing_flags_everything() {
        let (mut tracks, rest) = tracks();
        tracks.columns[0][10..13].fill(DVec3::NAN);
        assert_eq!(fill(&mut tracks, &rest, 0.0, 1e-4)[0].kind, Kind::Lost);
    }
}
