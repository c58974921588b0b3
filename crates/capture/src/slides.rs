//! Slides: labels that leave their marker, for another one or for none.
//!
//! Skin moves together, so the low-rank model of the take tells where each marker is from all the others. A label that goes somewhere else for a
//! while is off by far more than its marker ever is; what makes it a slide rather than an expression of its own is that it ends at another
//! marker, or in a jump, or farther away than skin goes alone. One that lasts for more than about a tenth of the take is part of what the model
//! learns, and not found.
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

/// A marker may be off by this part of the face's extent from where the others would have it …
const OFF: f64 = 0.02;

/// … and by so many times its own median, whichever is more.
const OFF_ITS_OWN: f64 = 8.0;

/// A slide begins and ends where the marker is off by these parts of both.
const BEGINS: [f64; 2] = [0.1, 3.0];

/// … and by this part of what it comes to.
const ON_THE_WAY: f64 = 0.1;

/// Farther no skin goes alone, as a part of the face's extent.
const ALONE: f64 = 0.12;

/// Skin does not move faster against the skin around it: extents of the face a second; and a smaller step is no jump.
const FASTEST: f64 = 2.0;

/// A label is at another marker if it is nearer than this part of their distance at rest …
const AT: f64 = 0.25;

/// … and otherwise never nearer than this part: lips and lids meet.
const APART: f64 = 0.5;

/// What is briefer, in seconds, is an outlier.
const BRIEF: f64 = 0.1;

/// A label that is not seen for longer, in seconds, has ended its slide.
const UNSEEN: f64 = 0.25;

/// Frames that the model learns from, and rounds of filling gaps.
const EFFORT: Effort = Effort { frames: 1200, iterations: 4 };

/// Fewer frames tell too little of how the markers go together.
const FEWEST: usize = 60;

/// A slide that the model has learned hides others.
const ROUNDS: usize = 4;

/// Finds slides and makes them NaN. `rest` is where the markers are at neutral, `extent` the face's, `noise` the standard deviation of a coordinate.
pub(crate) fn cut(tracks: &mut Tracks, rest: &[DVec3], extent: f64, noise: f64) -> Vec<Slide> {
    let mut slides = Vec::new();
    if tracks.frames() < FEWEST {
        return slides;
    }
    let scale = Scale { extent, noise };
    for _ in 0..ROUNDS {
        let Some(off) = off(tracks, &scale) else { break };
        // Without it the model tells how far each slide goes.
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

/// What is large and what is small.
struct Scale {
    extent: f64,
    noise: f64,
}

/// For each frame by how much each marker is off from where all the others have it; NaN where it is not seen.
fn off(tracks: &Tracks, scale: &Scale) -> Option<Vec<Vec<DVec3>>> {
    let known: Vec<usize> =
        (0..tracks.columns.len()).filter(|&j| tracks.columns[j].iter().any(|p| seen(*p))).collect();
    let columns: Vec<Vec<DVec3>> = known.iter().map(|&j| tracks.columns[j].clone()).collect();
    let part = Tracks { columns, rate: tracks.rate };
    let model = Model::learn(&part, scale.noise, EFFORT)?;
    let alone = LeaveOneOut::of(&model);
    let frame = |f: usize| {
        let mut all = vec![DVec3::NAN; tracks.columns.len()];
        known.iter().zip(alone.errors(&part, f)).for_each(|(&j, error)| all[j] = error);
        all
    };
    let mut off: Vec<Vec<DVec3>> = (0..part.frames()).into_par_iter().map(frame).collect();
    // A label that stays where it slid to moves the model's mean, and all its other frames are off by as much.
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

/// By how much marker `j` may be off, and by how much a slide's beginning is.
fn limits(off: &[Vec<DVec3>], j: usize, scale: &Scale) -> [f64; 2] {
    let mut own: Vec<f64> = off.iter().map(|frame| frame[j].length()).filter(|e| !e.is_nan()).collect();
    let own = median(&mut own);
    let most = (OFF * scale.extent).max(OFF_ITS_OWN * own);
    [most, (BEGINS[0] * most).max(BEGINS[1] * own)]
}

/// Up to where the marker is where it should be, on either side.
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

/// The stretches in which marker `j` is off by more than it should.
fn candidates(off: &[Vec<DVec3>], j: usize, tracks: &Tracks, scale: &Scale) -> Vec<Range<usize>> {
    let [most, begins] = limits(off, j, scale);
    let unseen = tracks.frames_in(UNSEEN);
    let mut runs: Vec<(Range<usize>, bool)> = Vec::new();
    for (f, frame) in off.iter().enumerate() {
        let e = frame[j].length();
        if e.is_nan() {
            continue;
        }
        // A run goes on as long as every frame in which the marker is seen is off, up to a jump.
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
    // What a marker is off by besides is no part of the way.
    let trimmed = far.map(|run| {
        let length = |f: usize| off[f][j].length();
        let farthest = run.clone().map(length).fold(0.0, f64::max);
        let on_the_way = |f: &usize| length(*f) > ON_THE_WAY * farthest;
        let first = run.clone().find(on_the_way).unwrap_or(run.start);
        first..run.clone().rev().find(on_the_way).unwrap_or(first) + 1
    });
    trimmed.filter(|run| run.len() > brief).collect()
}

/// Whether marker `j` jumps into a stretch, or out of it.
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

/// Whether what a marker is off by jumps, away or back: neighbours that are hidden and seen again make it jump too.
fn jumps(a: DVec3, b: DVec3, frames: usize, tracks: &Tracks, scale: &Scale) -> bool {
    let (less, more) = (a.length().min(b.length()), a.length().max(b.length()));
    2.0 * less < more && a.distance(b) > scale.extent * (FASTEST * frames as f64 / tracks.rate).max(OFF)
}

/// The marker that label `j` comes to in a stretch, though the two never meet elsewhere.
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

    /// Thirty markers on a face of 17 units, three motions, and one marker that moves alone now and then, as a lid does.
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
