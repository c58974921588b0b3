//! Slides: labels that leave their marker, for another one or for none.
//!
//! Skin moves together, so the low-rank model of the take tells where each marker is from all the others. A
//! label that goes somewhere else for a while is off by far more than its marker ever is. It is a slide, and
//! not an expression, if it ends at another marker, ends in a jump, or goes farther than skin goes alone. A
//! slide that lasts for more than about a tenth of the take is learned by the model and not found.
use crate::low_rank::{Effort, LeaveOneOut, Model};
use crate::tracks::{Tracks, median_point, seen};
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::numbers::median;
use std::ops::Range;

/// One label's slide.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Slide {
    /// The column.
    pub marker: usize,
    /// The marker that it slid to, if it came to one.
    pub to: Option<usize>,
    /// First frame.
    pub first: usize,
    /// Frame behind the last one.
    pub end: usize,
}

/// A marker may be off its expected position by this part of the face's extent …
const OFF: f64 = 0.02;

/// … or by so many times its own median error, if that is more.
const OFF_ITS_OWN: f64 = 8.0;

/// A slide begins and ends where the marker is off by the larger of two: this part of the limit, and this
/// many times its median error …
const BEGINS: [f64; 2] = [0.1, 3.0];

/// … and by this part of the slide's largest error.
const ON_THE_WAY: f64 = 0.1;

/// No skin goes farther alone, as a part of the face's extent.
const ALONE: f64 = 0.12;

/// Skin does not move faster against the skin around it, in extents of the face a second. A slower step is no
/// jump.
const FASTEST: f64 = 2.0;

/// A label is at another marker if it is nearer than this part of their distance at rest …
const AT: f64 = 0.25;

/// … and never gets nearer than this part outside of slides. (Lips and lids do meet.)
const APART: f64 = 0.5;

/// A briefer stretch, in seconds, is an outlier.
const BRIEF: f64 = 0.1;

/// A label that is not seen for longer, in seconds, has ended its slide.
const UNSEEN: f64 = 0.25;

/// Frames that the model learns from, and rounds in which it fills gaps.
const EFFORT: Effort = Effort { frames: 1200, iterations: 4 };

/// Fewer frames say too little about how the markers move together.
const FEWEST: usize = 60;

/// Rounds of finding slides. A slide that the model has learned can hide others.
const ROUNDS: usize = 4;

/// Finds slides and makes them NaN. `rest` holds the markers' positions at neutral, `extent` is the face's,
/// `noise` the standard deviation of a coordinate.
pub(crate) fn cut(tracks: &mut Tracks, rest: &[DVec3], extent: f64, noise: f64) -> Vec<Slide> {
    let mut slides = Vec::new();
    if tracks.frames() < FEWEST {
        return slides;
    }
    let scale = Scale { extent, noise };
    for _ in 0..ROUNDS {
        let Some(off) = off(tracks, &scale) else { break };
        // The model has now learned without the slides, so it tells how far each of them goes.
        slides.iter_mut().for_each(|slide| grow(slide, &off, tracks, &scale));
        let found = find(&off, tracks, rest, &scale);
        let is_done = found.is_empty();
        slides.extend(found);
        for slide in &slides {
            tracks.columns[slide.marker][slide.first..slide.end].fill(DVec3::NAN);
        }
        if is_done {
            break;
        }
    }
    slides.sort_by_key(|slide| (slide.first, slide.marker));
    slides
}

/// The face's extent and the standard deviation of a coordinate.
struct Scale {
    extent: f64,
    noise: f64,
}

/// The error of each marker against all others' expectation, for each frame; NaN where it is not seen.
fn off(tracks: &Tracks, scale: &Scale) -> Option<Vec<Vec<DVec3>>> {
    let known: Vec<usize> =
        (0..tracks.columns.len()).filter(|&j| tracks.columns[j].iter().any(|p| seen(*p))).collect();
    let columns: Vec<Vec<DVec3>> = known.iter().map(|&j| tracks.columns[j].clone()).collect();
    let part = Tracks { columns, rate: tracks.rate };
    let model = Model::learn(&part, scale.noise, EFFORT)?;
    let alone = LeaveOneOut::new(&model);
    let frame = |f: usize| {
        let mut all = vec![DVec3::NAN; tracks.columns.len()];
        known.iter().zip(alone.errors(&part, f)).for_each(|(&j, error)| all[j] = error);
        all
    };
    let mut off: Vec<Vec<DVec3>> = (0..part.frames()).into_par_iter().map(frame).collect();
    // A label that stays where it slid to moves the model's mean. All its other frames are then off by the
    // same vector, which is taken out.
    for &j in &known {
        let usual = median_point(off.iter().map(|frame| frame[j]).filter(|e| seen(*e)));
        off.iter_mut().for_each(|frame| frame[j] -= usual);
    }
    Some(off)
}

fn find(off: &[Vec<DVec3>], tracks: &Tracks, rest: &[DVec3], scale: &Scale) -> Vec<Slide> {
    let candidates: Vec<Vec<Range<usize>>> =
        (0..rest.len()).into_par_iter().map(|j| candidates(off, j, tracks, scale)).collect();
    let mut slides = Vec::new();
    for (marker, runs) in candidates.iter().enumerate() {
        for run in runs {
            let to = arrives(off, marker, run, &candidates, tracks, rest);
            let jumps = || jumps_away(off, marker, run, tracks, scale);
            let farthest = run.clone().map(|f| off[f][marker].length()).fold(0.0, f64::max);
            if to.is_some() || jumps() || farthest > ALONE * scale.extent {
                slides.push(Slide { marker, to, first: run.start, end: run.end });
            }
        }
    }
    slides
}

/// The error that marker `j` may have, and the error at which a slide begins.
fn limits(off: &[Vec<DVec3>], j: usize, scale: &Scale) -> [f64; 2] {
    let mut own: Vec<f64> = off.iter().map(|frame| frame[j].length()).filter(|e| !e.is_nan()).collect();
    let own = median(&mut own);
    let most = (OFF * scale.extent).max(OFF_ITS_OWN * own);
    [most, (BEGINS[0] * most).max(BEGINS[1] * own)]
}

/// Grows a slide on both sides, up to where the marker is as expected.
fn grow(slide: &mut Slide, off: &[Vec<DVec3>], tracks: &Tracks, scale: &Scale) {
    let [_, begins] = limits(off, slide.marker, scale);
    let (length, unseen) = (slide.end - slide.first, tracks.frames_in(UNSEEN));
    let reach = |frames: &mut dyn Iterator<Item = usize>| {
        let mut last = None;
        for (i, f) in frames.take(length).enumerate() {
            let e = off[f][slide.marker].length();
            if e > begins {
                last = Some((i, f));
            } else if !e.is_nan() || i - last.map_or(0, |(i, _)| i) > unseen {
                break;
            }
        }
        last.map(|(_, f)| f)
    };
    let first = reach(&mut (0..slide.first).rev());
    let last = reach(&mut (slide.end..off.len()));
    slide.first = first.unwrap_or(slide.first);
    slide.end = last.map_or(slide.end, |f| f + 1);
}

/// The stretches in which marker `j` is off by more than its limit.
fn candidates(off: &[Vec<DVec3>], j: usize, tracks: &Tracks, scale: &Scale) -> Vec<Range<usize>> {
    let [most, begins] = limits(off, j, scale);
    let unseen = tracks.frames_in(UNSEEN);
    let mut runs: Vec<(Range<usize>, bool)> = Vec::new();
    for (f, frame) in off.iter().enumerate() {
        let e = frame[j].length();
        if e.is_nan() {
            continue;
        }
        // A run goes on while the marker is off in every frame that shows it. A jump ends the run.
        let goes_on = |run: &Range<usize>| {
            f - run.end <= unseen
                && off[run.end..f].iter().all(|frame| !seen(frame[j]))
                && !jumps(off[run.end - 1][j], off[f][j], f + 1 - run.end, tracks, scale)
        };
        match runs.last_mut() {
            Some((run, is_far)) if e > begins && goes_on(run) => {
                run.end = f + 1;
                *is_far |= e > most;
            }
            _ if e > begins => runs.push((f..f + 1, e > most)),
            _ => (),
        }
    }
    let brief = tracks.frames_in(BRIEF);
    let far = runs.into_iter().filter(|(_, is_far)| *is_far).map(|(run, _)| run);
    // Ends with a small error are not part of the slide.
    let trimmed = far.map(|run| {
        let length = |f: usize| off[f][j].length();
        let farthest = run.clone().map(length).fold(0.0, f64::max);
        let on_the_way = |f: &usize| length(*f) > ON_THE_WAY * farthest;
        let first = run.clone().find(on_the_way).unwrap_or(run.start);
        first..run.clone().rev().find(on_the_way).unwrap_or(first) + 1
    });
    trimmed.filter(|run| run.len() > brief).collect()
}

/// Whether marker `j` jumps into or out of a stretch.
fn jumps_away(off: &[Vec<DVec3>], j: usize, run: &Range<usize>, tracks: &Tracks, scale: &Scale) -> bool {
    let at = |f: usize| off[f][j];
    let before = (0..run.start).rev().find(|&f| seen(at(f)));
    let behind = (run.end..off.len()).find(|&f| seen(at(f)));
    let is_jump = |inside: usize, outside: usize| {
        let frames = inside.abs_diff(outside);
        frames <= tracks.frames_in(UNSEEN)
            && at(inside).length() > at(outside).length()
            && jumps(at(inside), at(outside), frames, tracks, scale)
    };
    before.is_some_and(|f| is_jump(run.start, f)) || behind.is_some_and(|f| is_jump(run.end - 1, f))
}

/// Whether a marker's error jumps, up or down. The error must at least double: hidden neighbours that
/// reappear make it jump a little too.
fn jumps(a: DVec3, b: DVec3, frames: usize, tracks: &Tracks, scale: &Scale) -> bool {
    let (less, more) = (a.length().min(b.length()), a.length().max(b.length()));
    2.0 * less < more && a.distance(b) > scale.extent * (FASTEST * frames as f64 / tracks.rate).max(OFF)
}

/// The marker that label `j` comes to in a stretch. The two must not meet elsewhere in the take.
fn arrives(
    off: &[Vec<DVec3>],
    j: usize,
    run: &Range<usize>,
    candidates: &[Vec<Range<usize>>],
    tracks: &Tracks,
    rest: &[DVec3],
) -> Option<usize> {
    let at = |j: usize, f: usize| tracks.columns[j][f];
    let is_sound = |j: usize, f: usize| !candidates[j].iter().any(|run| run.contains(&f));
    let nearest = |b: usize, f: usize| at(j, f).distance(at(b, f)) / rest[j].distance(rest[b]);
    let comes = |b: usize| {
        let most = AT * rest[j].distance(rest[b]);
        let there = run.clone().filter(|&f| {
            off[f][j].length() > 2.0 * most && at(j, f).distance(at(b, f)) < most && is_sound(b, f)
        });
        there.count() >= 2
    };
    let meets = |b: usize| (0..off.len()).any(|f| nearest(b, f) < APART && is_sound(j, f) && is_sound(b, f));
    (0..rest.len()).find(|&b| b != j && comes(b) && !meets(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thirty markers on a face of 17 units, three motions, and one marker that moves alone now and then, as
    /// a lid does.
    fn face() -> (Tracks, Vec<DVec3>) {
        let rest: Vec<DVec3> = (0..30)
            .map(|i| DVec3::new(f64::from(i % 6) * 2.2, f64::from(i / 6) * 2.8, f64::from(i * i % 7) * 0.2))
            .collect();
        let at = |r: &DVec3, i: usize, f: usize| {
            let t = f as f64 / 120.0;
            let together =
                DVec3::new(0.3 * (3.0 * t).sin() * r.y, 0.4 * (1.7 * t).cos() * r.x, (0.9 * t).sin());
            let lid = if i == 8 && (600..640).contains(&f) { -1.4 * DVec3::Y } else { DVec3::ZERO };
            let s = ((f as f64 - 600.0) / 40.0 * std::f64::consts::PI).sin().max(0.0);
            let random = |k: usize| (((f * 31 + i * 7 + k) as f64 * 12.9898).sin() * 43_758.545_3).fract();
            *r + 0.3 * together + lid * s * s + 0.004 * DVec3::from_array([0, 1, 2].map(random))
        };
        let columns =
            rest.iter().enumerate().map(|(i, r)| (0..1000).map(|f| at(r, i, f)).collect()).collect();
        (Tracks { columns, rate: 120.0 }, rest)
    }

    fn slid(a: usize, b: usize, way: impl Fn(usize) -> f64) -> (Tracks, Vec<Slide>) {
        let (mut tracks, rest) = face();
        for f in 0..tracks.frames() {
            tracks.columns[a][f] = tracks.columns[a][f].lerp(tracks.columns[b][f], way(f));
        }
        let found = cut(&mut tracks, &rest, 17.0, 0.004);
        (tracks, found)
    }

    #[test]
    fn a_label_that_slides_to_another_marker_is_cut_out_however_it_comes_back() {
        let ramp = |f: usize, from: usize| ((f as f64 - from as f64) / 48.0).clamp(0.0, 1.0);
        let snaps = |f: usize| if f < 348 { ramp(f, 300) } else { 0.0 };
        let returns = |f: usize| ramp(f, 300) - ramp(f, 400);
        let stays = |f: usize| ramp(f, 900);
        for (way, cut, margin) in [
            (&snaps as &dyn Fn(usize) -> f64, 300..348, 8),
            (&returns, 300..448, 20),
            (&stays, 900..1000, 20),
        ] {
            for (a, b) in [(14, 15), (9, 3), (21, 28)] {
                let (_, found) = slid(a, b, way);
                assert_eq!(found.len(), 1, "{found:?}");
                let Slide { marker, to, first, end } = found[0];
                assert_eq!((marker, to), (a, Some(b)));
                assert!(
                    first.abs_diff(cut.start) <= margin && end.abs_diff(cut.end) <= margin,
                    "{found:?} {cut:?}"
                );
            }
        }
    }

    #[test]
    fn what_a_marker_does_alone_stays() {
        let (mut tracks, rest) = face();
        let before = tracks.clone();
        assert_eq!(cut(&mut tracks, &rest, 17.0, 0.004), []);
        assert_eq!(tracks, before);
        // Neither does anything happen to a take of a few frames, nor to one without positions.
        let few = |column: &Vec<DVec3>| column[..30].to_vec();
        let mut short = Tracks { columns: before.columns.iter().map(few).collect(), rate: 120.0 };
        assert_eq!(cut(&mut short, &rest, 17.0, 0.004), []);
        let mut nothing = Tracks { columns: vec![vec![DVec3::NAN; 100]; 30], rate: 120.0 };
        assert_eq!(cut(&mut nothing, &rest, 17.0, 0.004), []);
    }
}
