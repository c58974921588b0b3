//! Coverage by the learned method: how uncertain a take's frames are, and which of them to scan.
//! `docs/coverage.md` says how to read it.

use crate::Regions;
use glam::Vec3;
use rhytid_capture::coverage::{Difference, Edge, edges_beyond, largest_strains};
use rhytid_core::{Error, Progress, Result, Rig, Take, human};
use rhytid_solve::{Confidence, EXTRAPOLATION, ScanPlan, plan_scans};
use serde::Serialize;

/// A frame is covered if its σ is at most this part of the σ of an expression without a scan.
pub const COVERED: f64 = 0.5;

/// The number of sampled vertices, which stand for all.
const SAMPLES: usize = 300;

/// The number of frames of a long take that a plan looks at: neighbouring frames are alike.
const FRAMES: usize = 400;

/// A region whose strains are less than this part of the whole face's hardly moves in the examples.
const QUIET: f64 = 0.5;

/// A scan is worth making if it takes away at least this part of the uncertainty without any example.
pub const WORTH: f64 = 0.01;

/// Frames are neighbours if they are at most so many seconds apart, and the handles move from one to the
/// other by less than this part of their way from rest (RMS).
const NEIGHBOURS: (f64, f64) = (1.0, 0.5);

/// A marker whose confidence is at most this is a guess. A frame with such a marker is not proposed for a
/// scan.
const GUESS: f32 = 0.5;

/// How uncertain a take is on a rig, and the scans that would reduce the uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coverage {
    /// Frames of the take.
    pub frames: usize,
    /// The uncertainty by the examples; `None` if the rig has none.
    pub sigma: Option<TakeSigma>,
    /// The standard deviation over the take and the face with the existing examples, as a part of that
    /// without any example: 0..1.
    pub left: f64,
    /// The scans to make, the most useful first. Of neighbouring frames that are alike, there is one.
    pub scans: Vec<Scan>,
    /// How many of the scans are worth making. Each one behind them takes away less than [`WORTH`].
    pub enough: usize,
    /// How many strain edges go beyond every example in some frame.
    pub edges_beyond: usize,
    /// The strain edges that go farthest beyond the examples.
    pub edges: Vec<Edge>,
}

/// The standard deviation σ of a take's frames: how far, RMS, a vertex may be from a scan of the frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TakeSigma {
    /// The σ of each frame, RMS over the face, in millimetres.
    pub frames_mm: Vec<f64>,
    /// The σ of an expression without a scan, in millimetres: the scale for the other values. The rig expects
    /// it, as the mean over its examples; it is not measured.
    pub left_out_mm: f64,
    /// Frames whose σ is at most [`COVERED`] times that of an expression without a scan.
    pub covered: usize,
    /// Stretches of frames that are far from the examples.
    pub far: Vec<Far>,
}

/// Consecutive frames in which a region is far outside what the examples show.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Far {
    /// The first frame, counted from 0.
    pub first: usize,
    /// The number of frames.
    pub frames: usize,
    /// The frame that is farthest.
    pub farthest: usize,
    /// Its time in seconds.
    pub time: f64,
    /// The region that is farthest in it.
    pub region: String,
    /// How far it is, as a ratio above [`EXTRAPOLATION`].
    pub times: f64,
    /// The quantity that is far.
    pub of: FarOf,
}

/// The quantity of a frame that is far from the examples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FarOf {
    /// σ, as a multiple of the σ of an expression without a scan: in the region or over the whole face,
    /// whichever is larger.
    Uncertainty,
    /// The vector strains, as a multiple of those of the example that is strained most in the region. If half
    /// of that value over the whole face is larger, it counts instead. σ does not see a motion that goes the
    /// same way as the examples, but farther.
    Strain,
}

impl std::fmt::Display for FarOf {
    /// As in “3.2 times as …”.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Uncertainty => "uncertain as an expression without a scan",
            Self::Strain => "strained as any example",
        })
    }
}

/// A frame to scan.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scan {
    /// Counted from 0.
    pub frame: usize,
    /// In seconds.
    pub time: f64,
    /// The standard deviation over the take that remains with this scan and those before, as a part of that
    /// without any example.
    pub left: f64,
    /// The standard deviation that this scan takes away from what those before leave, in the same unit.
    pub taken: f64,
    /// The regions that the scan helps, the most helped first.
    pub regions: Vec<ScanRegion>,
    /// The strain edges that are longest or shortest in this frame.
    pub edges: Vec<Difference>,
}

/// A region that a scan is for.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScanRegion {
    /// Its name.
    pub region: String,
    /// The standard deviation in the region that the scan takes away from what those before leave, as a part
    /// of that without any example, 0..1.
    pub taken: f64,
}

/// Compares `take` with `rig`, plans `scans` scans, and lists at most `edges` strain edges that go beyond the
/// examples. `candidates` are the frames that can be scanned. Without them, every frame whose markers were
/// all seen is a candidate.
///
/// # Errors
/// [`Error::Input`] if the take lacks handles, a candidate is not in it, or the rig is not of the learned
/// method; [`Error::Cancelled`].
pub fn coverage(
    rig: &Rig,
    take: &Take,
    regions: &Regions,
    candidates: Option<&[usize]>,
    scans: usize,
    edges: usize,
    progress: &dyn Progress,
) -> Result<Coverage> {
    let positions = take.handle_positions(&rig.handles().labels)?;
    let of_take: Vec<&[[f32; 3]]> = positions.as_chunks::<3>().0.chunks_exact(rig.handles().len()).collect();
    if let Some(frame) = candidates.and_then(|frames| frames.iter().find(|frame| **frame >= take.frames())) {
        return Err(Error::out_of_range(format!(
            "frame {frame} can't be scanned, as the take has {}",
            take.frames()
        )));
    }
    // Frames evenly over the take, and the candidates among or behind them.
    let mut frames: Vec<usize> = (0..take.frames()).step_by(take.frames().div_ceil(FRAMES).max(1)).collect();
    let places: Vec<usize> = match candidates {
        Some(candidates) => {
            frames.extend(candidates);
            (frames.len() - candidates.len()..frames.len()).collect()
        }
        None => (0..frames.len()).filter(|&i| is_seen(rig, take, frames[i])).collect(),
    };
    let at = |frame: usize| of_take[frame].iter().map(|x| x.map(f64::from));
    let poses: Vec<[f64; 3]> = frames.iter().flat_map(|&frame| at(frame)).collect();
    let f64_rig = rig.widened();
    let are_alike = |a: usize, b: usize| {
        let [a, b] = [a, b].map(|i| frames[i]);
        (take.times[a] - take.times[b]).abs() <= NEIGHBOURS.0
            && are_near(of_take[a], of_take[b], &rig.handles().rest)
    };
    let plan = plan_scans(rig, &poses, &places, scans, &are_alike, progress)?;
    let mut planned: Vec<Scan> = Vec::new();
    let (mut left, mut variances) = (plan.left, plan.variances.clone());
    for scan in &plan.scans {
        let before = variances.clone();
        variances.iter_mut().zip(&scan.gains).for_each(|(variance, gain)| *variance -= gain);
        planned.push(Scan {
            frame: frames[scan.frame],
            time: take.times[frames[scan.frame]],
            left: scan.left,
            taken: left - scan.left,
            regions: taken(&plan, [&before, &variances], regions),
            edges: largest_strains(&f64_rig, &at(frames[scan.frame]).collect::<Vec<_>>()),
        });
        left = scan.left;
    }
    let enough = planned.iter().rposition(|scan| scan.taken >= WORTH).map_or(0, |last| last + 1);
    let mut beyond = edges_beyond(&f64_rig, take)?;
    let edges_beyond = beyond.len();
    beyond.truncate(edges);
    let sigma =
        (!rig.examples().names.is_empty()).then(|| take_sigma(rig, take, regions, progress)).transpose()?;
    Ok(Coverage {
        frames: take.frames(),
        sigma,
        left: plan.left,
        scans: planned,
        enough,
        edges_beyond,
        edges: beyond,
    })
}

/// Whether every marker of a frame was seen.
fn is_seen(rig: &Rig, take: &Take, frame: usize) -> bool {
    let Some(confidence) = &take.confidence else { return true };
    let mut frames = confidence.chunks_exact(take.labels.len());
    let of_frame = frames.nth(frame).unwrap_or_default();
    take.labels.iter().zip(of_frame).all(|(label, c)| *c > GUESS || !rig.handles().labels.contains(label))
}

/// Whether handles at `a` are nearer to those at `b` than a part of their way from rest.
fn are_near(a: &[[f32; 3]], b: &[[f32; 3]], rest: &[[f32; 3]]) -> bool {
    let squared = |a: &[[f32; 3]], b: &[[f32; 3]]| -> f64 {
        a.iter().zip(b).map(|(a, b)| f64::from(Vec3::from(*a).distance_squared(Vec3::from(*b)))).sum()
    };
    squared(a, b) < NEIGHBOURS.1.powi(2) * squared(a, rest).max(squared(b, rest))
}

/// The standard deviation that a scan takes away in each region, the largest first. The variances before and
/// after it are those of the plan's vertices.
fn taken(plan: &ScanPlan, [before, after]: [&[f64]; 2], regions: &Regions) -> Vec<ScanRegion> {
    let mut sums = vec![([0.0, 0.0], 0); regions.names().len()];
    for (i, &v) in plan.vertices.iter().enumerate() {
        if let Some(region) = regions.of_vertex(v) {
            let (sum, count) = &mut sums[region];
            *sum = [sum[0] + before[i], sum[1] + after[i]];
            *count += 1;
        }
    }
    let mut found: Vec<ScanRegion> = Vec::new();
    for (region, (sum, count)) in regions.names().iter().zip(sums).filter(|(_, (_, count))| *count > 0) {
        let [before, after] = sum.map(|sum: f64| (sum / f64::from(count)).max(0.0).sqrt());
        found.push(ScanRegion { region: region.clone(), taken: before - after });
    }
    found.sort_by(|a, b| b.taken.total_cmp(&a.taken));
    found
}

impl Coverage {
    /// Which scans to make, and where to stop, in a sentence.
    pub fn verdict(&self) -> String {
        let named: Vec<String> = self.scans[..self.enough].iter().map(|scan| share(scan.taken)).collect();
        let named = match &named[..] {
            [others @ .., last] if !others.is_empty() => format!("{} and {last}", others.join(", ")),
            _ => named.join(""),
        };
        let more = self.scans.len() - self.enough;
        let least = share(WORTH);
        match (self.enough, more) {
            (0, 0) => "No frame can be scanned.".to_owned(),
            (0, _) => format!("No further scan is needed: the most useful one takes away less than {least}."),
            (1, 0) => {
                format!("One scan takes away {named} of the uncertainty. Plan more: others may help, too.")
            }
            (_, 0) => format!(
                "All {} scans help: they take away {named} of the uncertainty. Plan more: others may help, too.",
                self.enough
            ),
            (1, _) => format!(
                "One scan is enough: it takes away {named} of the uncertainty, and each further one less than {least}."
            ),
            _ => format!(
                "{} scans are enough: they take away {named} of the uncertainty, and each further one less than {least}.",
                self.enough
            ),
        }
    }
}

/// A part of the uncertainty in per cent: `58 %`, `9.6 %`, `0.4 %`.
pub fn share(part: f64) -> String {
    match 100.0 * part {
        small if small > 0.0 && small < 0.05 => "under 0.1 %".to_owned(),
        small if small < 9.95 => format!("{} %", human::number((10.0 * small).round() / 10.0)),
        percent => format!("{percent:.0} %"),
    }
}

/// How uncertain each frame of a take is.
///
/// # Errors
/// As [`Confidence::new`]; [`Error::Input`] if the take lacks handles; [`Error::Cancelled`].
pub fn take_sigma(rig: &Rig, take: &Take, regions: &Regions, progress: &dyn Progress) -> Result<TakeSigma> {
    let confidence = Confidence::sampled(rig, SAMPLES)?;
    let positions = take.handle_positions(&rig.handles().labels)?;
    let positions = positions.as_chunks::<3>().0;
    let of_sample: Vec<Option<usize>> = confidence.vertices().iter().map(|&v| regions.of_vertex(v)).collect();
    let sums = RegionSums { of_sample: &of_sample, regions: regions.names().len() };
    let left_out: Vec<f64> = confidence.left_out().collect();
    let left_out = sums.at_least(sums.over_samples(&left_out), confidence.typical_left_out());
    let samples = of_sample.len().max(1);
    let of_examples = confidence.squared_strains(rig.examples().handles.as_slice());
    let examples: Vec<Vec<f64>> =
        of_examples.chunks(samples).map(|example| sums.over_samples(example)).collect();
    let most = |region: usize| examples.iter().map(|example| example[region]).fold(0.0, f64::max);
    let strained: Vec<f64> = (0..=sums.regions).map(most).collect();
    let typical = strained[sums.regions] / samples as f64;
    let strained = sums.at_least(strained, QUIET.powi(2) * typical);
    let millimetres = 1e3 * rig.surface().metres_per_unit;
    let mut frames_mm = Vec::with_capacity(take.frames());
    // For each frame, the region that is farthest, its ratio, and its quantity.
    let mut farthest: Vec<(usize, f64, FarOf)> = Vec::with_capacity(take.frames());
    const AT_ONCE: usize = 64;
    for chunk in positions.chunks(AT_ONCE * rig.handles().len()) {
        progress.step("confidence", frames_mm.len() as u64, take.frames() as u64)?;
        let (variances, strains) = (confidence.variances(chunk), confidence.squared_strains(chunk));
        for (variances, strains) in variances.chunks(samples).zip(strains.chunks(samples)) {
            let (variances, strains) = (sums.over_samples(variances), sums.over_samples(strains));
            frames_mm.push(millimetres * (variances[sums.regions] / samples as f64).sqrt());
            let times = |found: f64, scale: f64| if scale > 0.0 { (found / scale).sqrt() } else { 0.0 };
            let of_region = |region: usize| {
                [
                    (region, times(variances[region], left_out[region]), FarOf::Uncertainty),
                    (region, times(strains[region], strained[region]), FarOf::Strain),
                ]
            };
            let all = (0..=sums.regions).rev().flat_map(of_region);
            farthest.extend(all.reduce(|a, b| if b.1 > a.1 { b } else { a }));
        }
    }
    progress.step("confidence", take.frames() as u64, take.frames() as u64)?;
    let typical_variance = confidence.left_out().sum::<f64>() / samples as f64;
    let left_out_mm = millimetres * typical_variance.sqrt();
    let covered = frames_mm.iter().filter(|sigma| **sigma <= COVERED * left_out_mm).count();
    let name =
        |region: usize| regions.names().get(region).map_or("the whole face", String::as_str).to_owned();
    let mut far: Vec<Far> = Vec::new();
    for (frame, &(region, times, of)) in
        farthest.iter().enumerate().filter(|(_, (_, times, _))| *times > EXTRAPOLATION)
    {
        let time = take.times[frame];
        let here = Far { first: frame, frames: 1, farthest: frame, time, region: name(region), times, of };
        match far.last_mut().filter(|last| last.first + last.frames == frame) {
            Some(last) if times > last.times => {
                *last = Far { first: last.first, frames: last.frames + 1, ..here };
            }
            Some(last) => last.frames += 1,
            None => far.push(here),
        }
    }
    Ok(TakeSigma { frames_mm, left_out_mm, covered, far })
}

/// Sums over the samples of each region, and after them the sum over all.
struct RegionSums<'a> {
    of_sample: &'a [Option<usize>],
    regions: usize,
}

impl RegionSums<'_> {
    fn over_samples(&self, numbers: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.regions + 1];
        for (number, region) in numbers.iter().zip(self.of_sample) {
            sums[self.regions] += number;
            if let Some(region) = region {
                sums[*region] += number;
            }
        }
        sums
    }

    /// The `sums`, each raised to at least `each` for every sample in it. A value that is small beside the
    /// whole face is then no reason to worry.
    fn at_least(&self, sums: Vec<f64>, each: f64) -> Vec<f64> {
        let typical = self.over_samples(&vec![each; self.of_sample.len()]);
        sums.into_iter().zip(typical).map(|(sum, typical)| sum.max(typical)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Regions;
    use rhytid_core::NoProgress;

    fn planned(parts: &[f64]) -> Coverage {
        let scan = |taken: &f64| Scan {
            frame: 0,
            time: 0.0,
            left: 0.0,
            taken: *taken,
            regions: Vec::new(),
            edges: Vec::new(),
        };
        let enough = parts.iter().rposition(|taken| *taken >= WORTH).map_or(0, |last| last + 1);
        let scans = parts.iter().map(scan).collect();
        Coverage { frames: 9, sigma: None, left: 1.0, scans, enough, edges_beyond: 0, edges: Vec::new() }
    }

    #[test]
    fn the_verdict_says_where_to_stop() {
        for (parts, expected) in [
            (
                &[0.096, 0.03, 0.008, 0.0][..],
                "2 scans are enough: they take away 9.6 % and 3 % of the uncertainty, and each further one less than 1 %.",
            ),
            (
                &[0.42, 0.005],
                "One scan is enough: it takes away 42 % of the uncertainty, and each further one less than 1 %.",
            ),
            (
                &[0.5, 0.2, 0.1],
                "All 3 scans help: they take away 50 %, 20 % and 10 % of the uncertainty. Plan more: others may help, too.",
            ),
            (&[0.5], "One scan takes away 50 % of the uncertainty. Plan more: others may help, too."),
            (&[0.004], "No further scan is needed: the most useful one takes away less than 1 %."),
            (&[], "No frame can be scanned."),
        ] {
            assert_eq!(planned(parts).verdict(), expected);
        }
        assert_eq!(
            [0.0, 0.0001, 0.00951, 0.0996, 0.586].map(share),
            ["0 %", "under 0.1 %", "1 %", "10 %", "59 %"]
        );
    }

    #[test]
    fn of_neighbouring_frames_one_is_planned_and_what_is_taken_adds_up() {
        let face = rhytid_demo::face(2_000);
        let rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let take = rhytid_demo::performance(&face);
        let found = coverage(&rig, &take, &Regions::by_handles(&rig), None, 30, 3, &NoProgress).unwrap();
        assert!(found.scans.len() > 5, "{}", found.scans.len());
        let handles = rig.handles();
        let column = |label: &String| take.labels.iter().position(|l| l == label).unwrap();
        let columns: Vec<usize> = handles.labels.iter().map(column).collect();
        let at = |frame: usize| columns.iter().map(move |c| (frame, *c));
        let rms = |a: usize, b: Option<usize>| {
            let of_handle = |(h, (frame, c)): (usize, (usize, usize))| {
                let width = take.labels.len();
                let from = take.positions[frame * width + c];
                let to = b.map_or(handles.rest[h].map(f64::from), |b| take.positions[b * width + c]);
                (0..3).map(|i| (from[i] - to[i]).powi(2)).sum::<f64>()
            };
            at(a).enumerate().map(of_handle).sum::<f64>().sqrt()
        };
        for (i, a) in found.scans.iter().enumerate() {
            for b in &found.scans[..i] {
                let from_rest = rms(a.frame, None).max(rms(b.frame, None));
                let is_apart =
                    (a.time - b.time).abs() > 1.0 || rms(a.frame, Some(b.frame)) >= 0.499 * from_rest;
                assert!(is_apart, "frames {} and {} are neighbours", a.frame, b.frame);
            }
        }
        let taken: f64 = found.scans.iter().map(|scan| scan.taken).sum();
        assert!((found.left - taken - found.scans.last().unwrap().left).abs() < 1e-9);
        // No region loses more than it had.
        assert!(found.scans.iter().flat_map(|scan| &scan.regions).all(|r| r.taken > -1e-9 && r.taken < 1.0));
    }
}
