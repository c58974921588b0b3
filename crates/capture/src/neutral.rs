//! Finds the neutral frames: half a second that is still and near the rest pose.
//!
//! Actors begin and end a take with the neutral face. So the best half seconds at the start, at the end and
//! in each part of the take are compared. The distance to the rest pose alone does not decide between them:
//! the actor's face differs from the rig's by more than a slight expression does. Expressions have a
//! direction. A pose that is another pose and a blink is not neutral, but the other one may be.
use crate::Target;
use crate::non_negative::explained;
use crate::tracks::{Tracks, extent, median_point, noise, seen};
use glam::DVec3;
use rayon::prelude::*;
use rhytid_geometry::registration::fit_robustly;
use serde::Serialize;
use std::ops::Range;

/// Half a second that was found to be neutral.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Neutral {
    pub frames: Range<usize>,
    /// Other frames that may be the neutral ones instead; `None` where the choice is sure.
    pub rival: Option<Rival>,
    /// Whether even these frames seem to show an expression, or motion.
    pub is_doubtful: bool,
}

/// Frames that may be neutral instead of those that were chosen.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rival {
    /// Counted from 0.
    pub frames: Range<usize>,
    /// RMS distance between the markers of both, in millimetres on the rig.
    pub apart_mm: f64,
}

/// How long the neutral face is held, in seconds.
pub(crate) const LENGTH: f64 = 0.5;

/// A marker may be off by this part of the face's extent before its weight falls.
const TOLERANCE: f64 = 0.03;

/// Frames of a window that are sampled.
const SAMPLED: usize = 30;

/// Costs below this part of the face's extent are alike.
const LEAST: f64 = 0.001;

/// The ratio by which the cost of a window elsewhere must be lower, as a natural logarithm: than that of the
/// start, and than that of the end.
const HEAD_START: [f64; 2] = [0.15, 0.10];

/// How much the direction of the expressions counts, beside the logarithm of the ratio of the costs.
const DIRECTION: f64 = 0.5;

/// The take's middle is looked at in so many parts.
const PARTS: usize = 12;

/// A choice with a smaller margin is not sure.
const SURE: f64 = 0.15;

/// Poses that differ less than this part of the face's extent are the same. It is about half a millimetre.
const ALIKE: f64 = 0.002;

/// A neutral face moves less than this part of the face's extent.
const STILL: f64 = 0.002;

/// A neutral face shows less of the rig's examples than this part of the face's extent.
const SHOWS: f64 = 0.004;

/// No actor's neutral face differs more from the rest pose, as a part of the face's extent.
const FARTHEST: f64 = 0.02;

/// Half a second of the take.
struct Window {
    frames: Range<usize>,
    /// Markers that it shows.
    markers: usize,
    /// Its mean positions, laid on the rest pose; NaN where a marker was not seen.
    pose: Vec<DVec3>,
    /// Its distance from the rest pose, in units of the rest pose.
    unlike: f64,
    /// The RMS motion within it beyond noise, in the same units.
    moving: f64,
}

impl Window {
    fn cost(&self) -> f64 {
        self.unlike + self.moving
    }
}

/// The half second that is most neutral; the whole take if it is shorter. `columns` has one entry per handle.
/// `None` if no half second shows at least four markers and half of those that the best one shows.
pub(crate) fn find(tracks: &Tracks, columns: &[Option<usize>], target: &Target) -> Option<Neutral> {
    let length = tracks.frames_in(LENGTH).min(tracks.frames());
    let noise = noise(tracks);
    let step = (length / 5).max(1);
    let last = tracks.frames() - length;
    let starts: Vec<usize> = (0..last).step_by(step).chain([last]).collect();
    let at = |start: usize| window(tracks, columns, &target.rest, start..start + length, noise);
    // Without the poses, which would take as much memory as the take.
    let without_pose = |start| at(start).map(|window| Window { pose: Vec::new(), ..window });
    let windows: Vec<Window> = starts.into_par_iter().filter_map(without_pose).collect();
    let most = windows.iter().map(|window| window.markers).max()?;
    let is_fit = |window: &&Window| window.markers >= 4 && 2 * window.markers >= most;
    let best = |is_there: &dyn Fn(usize) -> bool| {
        let there = windows.iter().filter(is_fit).filter(|window| is_there(window.frames.start));
        there.min_by(|a, b| a.cost().total_cmp(&b.cost())).and_then(|best| at(best.frames.start))
    };
    let is_start = |start: usize| start <= length;
    let is_end = |start: usize| start + length >= last;
    let mut candidates = vec![
        (best(&is_start), HEAD_START[0]),
        (best(&|start| is_end(start) && !is_start(start)), HEAD_START[1]),
    ];
    for part in 0..PARTS {
        let is_there =
            |start: usize| !is_start(start) && !is_end(start) && start * PARTS / tracks.frames() == part;
        candidates.push((best(&is_there), 0.0));
    }
    let candidates: Vec<(Window, f64)> =
        candidates.into_iter().filter_map(|(window, ahead)| Some((window?, ahead))).collect();
    let extent = extent(target.rest.iter().copied());
    // How much more neutral `a` is than `b`.
    let margin = |(a, a_ahead): &(Window, f64), (b, b_ahead): &(Window, f64)| {
        let cost = |window: &Window| window.cost() + LEAST * extent;
        (cost(b) / cost(a)).ln() + a_ahead - b_ahead + DIRECTION * more_of_the_examples(b, a, target)
    };
    let mut chosen = candidates.first()?;
    for candidate in &candidates[1..] {
        if margin(candidate, chosen) > 0.0 {
            chosen = candidate;
        }
    }
    let close = candidates.iter().filter(|other| other.0.frames != chosen.0.frames);
    let close = close.map(|other| (margin(chosen, other), apart(&chosen.0, &other.0), &other.0));
    let close = close.filter(|(margin, apart, _)| *margin < SURE && *apart > ALIKE * extent);
    let rival = close.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, apart, other)| Rival {
        frames: other.frames.clone(),
        apart_mm: apart * target.millimetres(),
    });
    Some(Neutral {
        frames: chosen.0.frames.clone(),
        rival,
        is_doubtful: is_doubtful(&chosen.0, target, extent),
    })
}

/// What frames show: how like the neutral face they are. `None` if they show too few markers.
fn window(
    tracks: &Tracks,
    columns: &[Option<usize>],
    rest: &[DVec3],
    frames: Range<usize>,
    noise: f64,
) -> Option<Window> {
    let step = frames.len().div_ceil(SAMPLED).max(1);
    let mut pose = vec![DVec3::NAN; rest.len()];
    let (mut squares, mut count) = (0.0, 0_usize);
    for (mean, column) in pose.iter_mut().zip(columns) {
        let Some(column) = *column else { continue };
        let points = || tracks.columns[column][frames.clone()].iter().step_by(step).filter(|p| seen(**p));
        let n = points().count();
        if 2 * n * step < frames.len() {
            continue;
        }
        *mean = points().sum::<DVec3>() / n as f64;
        squares += points().map(|p| p.distance_squared(*mean)).sum::<f64>();
        count += n;
    }
    let markers = pose.iter().filter(|p| seen(**p)).count();
    // A handle that is misplaced on the rig is off in all frames, and says nothing of any of them.
    let tolerance = TOLERANCE * extent(rest.iter().copied());
    let (fitted, _) = fit_robustly(&pose, rest, true, tolerance)?;
    pose.iter_mut().for_each(|p| *p = fitted.apply(*p));
    let left = pose.iter().zip(rest).filter(|(p, _)| seen(**p)).map(|(p, q)| p.distance(*q));
    let unlike =
        tolerance * (left.map(|d| (d / tolerance).powi(2).ln_1p()).sum::<f64>() / markers as f64).sqrt();
    let moving = fitted.scale * (squares / count as f64 - 3.0 * noise * noise).max(0.0).sqrt();
    Some(Window { frames, markers, pose, unlike, moving })
}

/// The differences of those positions that both have.
fn differences(a: &[DVec3], b: &[DVec3]) -> Vec<DVec3> {
    a.iter().zip(b).map(|(a, b)| *a - *b).map(|d| if seen(d) { d } else { DVec3::ZERO }).collect()
}

/// RMS distance of two windows' markers, in units of the rest pose.
fn apart(a: &Window, b: &Window) -> f64 {
    let both = a.pose.iter().zip(&b.pose).filter(|(a, b)| seen(**a) && seen(**b)).count();
    let squares: f64 = differences(&a.pose, &b.pose).iter().map(|d| d.length_squared()).sum();
    (squares / both.max(1) as f64).sqrt()
}

/// From −1 to 1: how much better the examples explain `a` as `b` with expressions than `b` as `a` with
/// expressions. 0 without examples.
fn more_of_the_examples(a: &Window, b: &Window, target: &Target) -> f64 {
    let on = |a: &Window, b: &Window| explained(&differences(&a.pose, &b.pose), &target.examples);
    on(a, b) - on(b, a)
}

/// Whether even the most neutral frames seem to be none.
fn is_doubtful(chosen: &Window, target: &Target, extent: f64) -> bool {
    let shown = explained(&differences(&chosen.pose, &target.rest), &target.examples).sqrt() * chosen.unlike;
    chosen.moving > STILL * extent || chosen.unlike > FARTHEST * extent || shown > SHOWS * extent
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

    /// A take of 400 frames of a face of twelve markers, seen from another place. `amount` says how much of
    /// an expression each frame shows.
    fn found(examples: bool, amount: impl Fn(usize) -> f64) -> Neutral {
        let rest: Vec<DVec3> =
            (0..12).map(|i| DVec3::new(f64::from(i % 4), f64::from(i / 4), f64::from(i * i % 5))).collect();
        let expression: Vec<DVec3> =
            (0..12).map(|i| DVec3::new(0.0, f64::from(i % 2), f64::from(i % 3))).collect();
        let seen_at = |i: usize, f: usize| {
            // The actor's face is not the rig's.
            let p = rest[i] + 0.06 * DVec3::new((i as f64).sin(), (3.0 * i as f64).cos(), 0.0);
            let p = p + expression[i] * amount(f);
            DVec3::new(-p.z, p.y, p.x) * 10.0 + DVec3::new(1.0, 2.0, 3.0)
        };
        let columns = (0..12).map(|i| (0..400).map(|f| seen_at(i, f)).collect()).collect();
        let columns_of: Vec<Option<usize>> = (0..12).map(Some).collect();
        let shown = if examples { vec![("smile".to_owned(), expression.clone())] } else { vec![] };
        let target = Target {
            labels: (0..12).map(|i| format!("m{i}")).collect(),
            rest,
            metres_per_unit: 0.01,
            strains: vec![],
            examples: shown,
        };
        find(&Tracks { columns, rate: 100.0 }, &columns_of, &target).unwrap()
    }

    #[test]
    fn the_still_neutral_second_is_found() {
        // Frames 0 to 100 hold an expression, and frames 160 to 230 the neutral face. In between and after
        // that the face moves. It passes through the neutral shape at 300.
        let amount = |f: usize| match f {
            0..100 => 0.3,
            100..160 => 0.3 + 0.01 * (f - 100) as f64,
            160..230 => 0.0,
            _ => (f as f64 - 300.0) * 0.02,
        };
        let found = found(false, amount);
        assert!(
            found.frames.len() == 50 && found.frames.start >= 160 && found.frames.end <= 230,
            "{found:?}"
        );
        assert!(found.rival.is_none() && !found.is_doubtful, "{found:?}");
    }

    #[test]
    fn the_start_and_the_end_are_neutral_rather_than_a_slight_expression() {
        let speech = |f: usize| 0.4 + 0.3 * (f as f64 * 0.2).sin();
        // The held pose in the middle is nearer to rest than the neutral face, as it is if the handles were
        // placed with a frame of it.
        let middle = |f: usize| if (180..260).contains(&f) { 0.02 } else { speech(f) };
        let start = found(false, |f| if f < 60 { 0.0 } else { middle(f) });
        assert!(start.frames.start <= 10 && !start.is_doubtful, "{start:?}");
        let end = found(false, |f| if f >= 340 { 0.0 } else { middle(f) });
        assert!(end.frames.end >= 390 && !end.is_doubtful, "{end:?}");
    }

    #[test]
    fn an_expression_that_is_held_first_is_not_neutral() {
        // It is so slight that the distance to rest does not tell.
        let slight = |f: usize| if f < 120 { 0.04 } else { 0.0 };
        let chosen = found(true, slight);
        assert!(chosen.frames.start >= 120, "{chosen:?}");
        let unsure = found(false, slight);
        assert!(unsure.frames.start >= 120 || unsure.rival.is_some(), "{unsure:?}");
        // The examples are one-sided: nothing is the neutral face and half an expression less.
        let other = found(true, |f| if f < 120 { 0.0 } else { 0.04 });
        assert!(other.frames.start < 60, "{other:?}");
    }

    #[test]
    fn a_take_without_a_neutral_face_is_doubted() {
        assert!(found(true, |f| 0.5 + 0.2 * (f as f64 * 0.2).sin()).is_doubtful);
        assert!(found(true, |_| 0.5).is_doubtful && !found(true, |_| 0.0).is_doubtful);
        // A face that trembles about the neutral one is not still.
        assert!(found(false, |f| 0.03 * (f as f64 * 0.5).sin()).is_doubtful);
        assert!(!found(false, |_| 0.0).is_doubtful);
    }
}
