//! What stands for “not seen” in place of a position: numbers far outside the take, and 0, 0, 0.
//!
//! Formats have words for “not seen”, which their readers know. Many programs write a number instead. A
//! single frame does not tell that number from a position, so whole tracks are judged here.
use rayon::prelude::*;
use rhytid_core::text::listed;
use rhytid_core::{RawTake, Take};

/// A number stands for “not seen” if its magnitude is this many times that of the rest of the take.
const FAR: f64 = 3.0;

/// The same for a number that programs use for this purpose, such as 9999999, and for one that whole
/// positions consist of.
const FAR_IF_CONSPICUOUS: f64 = 1.5;

/// A number stands for “not seen” only if so many coordinates have exactly this number. A wild position that
/// a system mistook for a marker has numbers of its own.
const LEAST_REPEATED: usize = 3;

/// The share of the take's coordinates that counts as its rest. What is beyond are wild positions.
const REST: f64 = 0.99;

/// A marker that is this many of the take's steps from the origin, a frame before or after it was at the
/// origin, may have been there.
const STEPS: f64 = 3.0;

/// The most frames between two positions over which motion is expected to go on.
const LONGEST_GAP: usize = 10;

/// Replaces the positions that stand for “not seen” by [`RawTake::MISSING`].
pub(super) fn mark(take: &mut RawTake) {
    far_numbers(take);
    origins(take);
    let RawTake { tracks, .. } = take;
    if let Some(confidence) = &mut tracks.confidence {
        for (confidence, position) in confidence.iter_mut().zip(&tracks.positions) {
            if position[0].is_nan() {
                *confidence = 1.0;
            }
        }
        if confidence.iter().all(|&confidence| confidence == 1.0) {
            tracks.confidence = None;
        }
    }
}

/// A magnitude that may stand for “not seen”.
struct Candidate {
    magnitude: f64,
    is_conspicuous: bool,
    /// Whether it is as far out as an inconspicuous number must be.
    is_far: bool,
    /// The positions that have it on all three axes.
    whole: usize,
    /// Whether it is on each of the axes. A real position far away is so on one axis, or on each by another
    /// number.
    is_on: [bool; 3],
}

/// Positions with a coordinate far outside the rest of the take, where that coordinate is repeated exactly.
fn far_numbers(take: &mut RawTake) {
    let mut candidates = candidates(&take.tracks);
    let Some(least) = candidates.last().map(|least| least.magnitude) else { return };
    let m = take.tracks.labels.len();
    for position in take.tracks.positions.iter().filter(|p| p.iter().any(|x| x.abs() >= least)) {
        for candidate in &mut candidates {
            let has = position.map(|x| x.abs() == candidate.magnitude);
            candidate.whole += usize::from(has == [true; 3]);
            for (is_on, has) in candidate.is_on.iter_mut().zip(has) {
                *is_on |= has;
            }
        }
    }
    candidates.retain(|candidate| {
        let axes = candidate.is_on.iter().filter(|&&is_on| is_on).count();
        candidate.is_conspicuous || candidate.is_far && axes > 1 || candidate.whole > 1
    });
    for Candidate { magnitude, .. } in candidates {
        let mut markers = vec![false; m];
        let (mut samples, mut value) = (0_usize, magnitude);
        for (sample, position) in take.tracks.positions.iter_mut().enumerate() {
            if let Some(&x) = position.iter().find(|x| x.abs() == magnitude) {
                *position = RawTake::MISSING;
                markers[sample % m] = true;
                samples += 1;
                value = x;
            }
        }
        if samples > 0 {
            take.warnings.push(format!(
                "the coordinate {} stands far outside the rest and comes again and again, so it counts as “not \
                 seen”: {} of {m} markers, {:.2} % of all samples; export gaps as empty cells, or as residuals below \
                 0 in a C3D file",
                shown(value),
                markers.iter().filter(|&&has| has).count(),
                samples as f64 / take.tracks.positions.len() as f64 * 100.0,
            ));
        }
    }
}

/// A number in few characters.
fn shown(value: f64) -> String {
    if value.abs() < 1e12 { value.to_string() } else { format!("{:e}", value as f32) }
}

/// Magnitudes that are far above the rest and repeated, the largest first. Real takes have very few.
fn candidates(tracks: &Take) -> Vec<Candidate> {
    const MOST: usize = 16;
    let mut magnitudes: Vec<f64> =
        tracks.positions.iter().flatten().map(|x| x.abs()).filter(|&x| x > 0.0).collect();
    magnitudes.par_sort_unstable_by(f64::total_cmp);
    let mut found = Vec::new();
    let mut end = magnitudes.len();
    while end > 0 && found.len() < MOST {
        let magnitude = magnitudes[end - 1];
        let start = magnitudes[..end].partition_point(|&other| other < magnitude);
        // All that is below, without the wild positions among it.
        let rest = magnitudes[..start].get((REST * start as f64) as usize).copied().unwrap_or(0.0);
        let is_conspicuous = is_conspicuous(magnitude);
        if magnitude <= FAR_IF_CONSPICUOUS * rest {
            break;
        }
        if end - start >= LEAST_REPEATED && (start > 0 || is_conspicuous) {
            let is_far = magnitude > FAR * rest;
            found.push(Candidate { magnitude, is_conspicuous, is_far, whole: 0, is_on: [false; 3] });
        }
        end = start;
    }
    found
}

/// Whether programs use a number to say “none”: all nines, a power of ten, or the end of a number's range.
fn is_conspicuous(magnitude: f64) -> bool {
    let power = |x: f64| x >= 1e3 && (x.log10() - x.log10().round()).abs() < 1e-9;
    let nines = (0..4).any(|digits| {
        let shifted = magnitude * 10f64.powi(digits);
        // Single precision rounds 9999.99.
        let whole = shifted.round();
        (shifted - whole).abs() <= 1e-7 * whole && power(whole + 1.0) && whole >= 9e2
    });
    let is_end = magnitude >= 32767.0 && [magnitude, magnitude + 1.0].iter().any(|x| x.log2().fract() == 0.0);
    nines || magnitude >= 1e4 && power((magnitude as f32).into()) || is_end || magnitude >= 1e18
}

/// Positions of exactly 0, 0, 0 from which a marker jumps, and markers that are nowhere else.
fn origins(take: &mut RawTake) {
    let m = take.tracks.labels.len();
    let is_origin = |position: &[f64; 3]| position == &[0.0; 3];
    let mut at_origin = vec![0_usize; m];
    let mut elsewhere = vec![0_usize; m];
    for (sample, position) in take.tracks.positions.iter().enumerate() {
        at_origin[sample % m] += usize::from(is_origin(position));
        elsewhere[sample % m] += usize::from(!is_origin(position) && !position[0].is_nan());
    }
    if at_origin.iter().all(|&frames| frames == 0) {
        return;
    }
    let step = usual_step(&take.tracks);
    let (mut never, mut kept) = (Vec::new(), Vec::new());
    for marker in (0..m).filter(|&marker| at_origin[marker] > 0) {
        let label = take.tracks.labels[marker].clone();
        if elsewhere[marker] == 0 {
            never.push(label);
            take.tracks.positions.iter_mut().skip(marker).step_by(m).for_each(|p| *p = RawTake::MISSING);
        } else if unsee_jumps(&mut take.tracks.positions, marker, m, step) {
            kept.push(label);
        }
    }
    let listed = |labels: &[String]| listed(labels.iter().map(String::as_str));
    if !never.is_empty() {
        take.warnings.push(format!(
            "{} of {m} markers are at 0, 0, 0 in every frame and count as never seen: {}",
            never.len(),
            listed(&never)
        ));
    }
    if !kept.is_empty() {
        take.warnings.push(format!(
            "{} of {m} markers come to rest at exactly 0, 0, 0 or pass it, which is kept as a position: {}; was such a \
             marker really there? If not, delete these samples in the capture system, and export again",
            kept.len(),
            listed(&kept)
        ));
    }
}

/// Takes away a marker's stays at the origin that begin or end with a jump. Whether a stay is kept.
fn unsee_jumps(positions: &mut [[f64; 3]], marker: usize, m: usize, step: f64) -> bool {
    let frames = positions.len() / m;
    let mut is_kept = false;
    // The last frame with another position.
    let mut before: Option<usize> = None;
    let mut frame = 0;
    while frame < frames {
        let position = positions[frame * m + marker];
        if position != [0.0; 3] {
            if !position[0].is_nan() {
                before = Some(frame);
            }
            frame += 1;
            continue;
        }
        let first = frame;
        let mut last = frame;
        let mut after = None;
        while frame < frames {
            let position = positions[frame * m + marker];
            if position == [0.0; 3] {
                last = frame;
            } else if !position[0].is_nan() {
                after = Some(frame);
                break;
            }
            frame += 1;
        }
        let is_near = |beside: usize, gap: usize| {
            let p = positions[beside * m + marker];
            p.iter().map(|x| x * x).sum::<f64>().sqrt() <= STEPS * step * gap.min(LONGEST_GAP) as f64
        };
        let is_motion = before.is_none_or(|before| is_near(before, first - before))
            && after.is_none_or(|after| is_near(after, after - last));
        is_kept |= is_motion;
        if !is_motion {
            for frame in first..=last {
                positions[frame * m + marker] = RawTake::MISSING;
            }
        }
    }
    is_kept
}

/// The length that few steps of the take's markers exceed, from a frame to the next one.
fn usual_step(tracks: &Take) -> f64 {
    let m = tracks.labels.len();
    let frames: Vec<&[[f64; 3]]> = tracks.positions.chunks_exact(m).collect();
    let is_elsewhere = |p: &[f64; 3]| p != &[0.0; 3];
    let mut steps: Vec<f64> = Vec::new();
    for pair in frames.windows(2) {
        let both = pair[0].iter().zip(pair[1]).filter(|(p, q)| is_elsewhere(p) && is_elsewhere(q));
        steps.extend(
            both.map(|(p, q)| (0..3).map(|axis| (p[axis] - q[axis]).powi(2)).sum::<f64>().sqrt())
                .filter(|length| length.is_finite()),
        );
    }
    if steps.is_empty() {
        return 0.0;
    }
    let place = (REST * (steps.len() - 1) as f64) as usize;
    *steps.select_nth_unstable_by(place, f64::total_cmp).1
}
