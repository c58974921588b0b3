//! The time that a device takes for a rig, beside the time that its bytes take.

use rhytid::conformance::{Memory, stage_name};
use rhytid::core::numbers::median;
use rhytid::core::{DeviceInfo, DeviceKind};
use rhytid::{Animator, Result, Rig, Session, Stage, UploadOptions};
use serde::Serialize;
use std::time::{Duration, Instant};

/// Turns of a device, the measured rounds in each, and the time limit of measuring.
const TURNS: usize = 5;
const ROUNDS: usize = 5;
const LIMIT: Duration = Duration::from_secs(10);

/// A stage's time and bytes for one frame.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Measured {
    pub stage: &'static str,
    pub ms: f64,
    pub bytes: f64,
    /// The time that the processor's memory needs for the bytes, as a share of the stage's time. None for a
    /// GPU with memory of its own.
    pub share_of_bandwidth: Option<f64>,
}

/// A whole frame: from handle positions to positions and normals.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Whole {
    pub ms: f64,
    pub bytes: f64,
    /// The median bandwidth of the processor's memory, measured in turns with the device.
    pub read_bandwidth_gb_s: f64,
    pub share_of_bandwidth: Option<f64>,
    pub fps: f64,
}

/// A whole frame of a rig of the same size, by the chapter's method.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Chapter {
    pub ms: f64,
    /// Time of the measured rig divided by the time of the chapter's: the median of the turns' ratios.
    pub ratio: f64,
}

/// Milliseconds per frame of each round.
#[derive(Default)]
struct Rounds {
    wholes: Vec<f64>,
    /// The times of each stage; empty where the device does not time them.
    stages: [Vec<f64>; 6],
}

/// Median times per frame over many batches of `options.max_frames` frames.
///
/// The batches take turns with reading `memory`, and with the `chapter`'s rig if there is one. Stages are
/// left out where the device does not time them. `bytes` are what the stages of `rig` move.
///
/// # Errors
/// The device's.
pub(super) fn measure(
    info: &DeviceInfo,
    rig: &Rig,
    chapter: Option<&Rig>,
    options: UploadOptions,
    bytes: [f64; 6],
    memory: &Memory,
) -> Result<(Whole, Vec<Measured>, Option<Chapter>)> {
    let mut bandwidths = Vec::new();
    let rigs: Vec<&Rig> = std::iter::once(rig).chain(chapter).collect();
    let mut all = rounds(info, &rigs, options, ROUNDS, LIMIT, || bandwidths.push(memory.read_bandwidth()))?;
    let chapter = all.get(1).map(|chapter| Chapter::new(&all[0].wholes, &chapter.wholes));
    let mut rounds = all.swap_remove(0);
    let bandwidth = median(&mut bandwidths);
    let shares_memory = info.kind != DeviceKind::DiscreteGpu;
    let share = |bytes: f64, ms: f64| shares_memory.then_some(bytes / bandwidth * 1e3 / ms);
    let (ms, sum) = (median(&mut rounds.wholes), bytes.iter().sum());
    let whole = Whole {
        ms,
        bytes: sum,
        read_bandwidth_gb_s: bandwidth / 1e9,
        share_of_bandwidth: share(sum, ms),
        fps: 1e3 / ms,
    };
    let stages = Stage::ALL.into_iter().zip(rounds.stages).zip(bytes);
    let measured = stages.filter(|((_, times), _)| !times.is_empty()).map(|((stage, mut times), bytes)| {
        let ms = median(&mut times);
        Measured { stage: stage_name(stage), ms, bytes, share_of_bandwidth: share(bytes, ms) }
    });
    // A device may merge a stage into another one, or skip it until its result is read.
    let measured = measured.filter(|stage| stage.ms > 0.0 && stage.bytes > 0.0);
    Ok((whole, measured.collect(), chapter))
}

impl Chapter {
    /// From the rounds of the measured rig and as many of the chapter's, which were taken side by side.
    fn new(own: &[f64], chapter: &[f64]) -> Self {
        let mut ratios: Vec<f64> = own.iter().zip(chapter).map(|(own, chapter)| own / chapter).collect();
        Self { ms: median(&mut chapter.to_vec()), ratio: median(&mut ratios) }
    }
}

/// The median time of a whole frame, from fewer batches.
///
/// # Errors
/// The device's.
pub(super) fn whole_frame(info: &DeviceInfo, rig: &Rig, options: UploadOptions) -> Result<f64> {
    let rounds = rounds(info, &[rig], options, ROUNDS / 2, LIMIT / 4, || ());
    rounds.map(|mut rounds| median(&mut rounds[0].wholes))
}

/// `count` rounds of each rig in each turn, after one that is not measured. Between turns `between` runs.
fn rounds(
    info: &DeviceInfo,
    rigs: &[&Rig],
    options: UploadOptions,
    count: usize,
    limit: Duration,
    mut between: impl FnMut(),
) -> Result<Vec<Rounds>> {
    let backend = rhytid::devices::backends::open(info)?;
    let mut animators = Vec::new();
    for rig in rigs {
        animators.push((backend.upload(rig, options)?, swaying(rig, options.max_frames), Rounds::default()));
    }
    let deadline = Instant::now() + limit * rigs.len() as u32;
    for _ in 0..TURNS {
        between();
        for (animator, handle_positions, rounds) in &mut animators {
            rounds.run(count, animator, handle_positions, options.max_frames, deadline)?;
        }
        if Instant::now() > deadline {
            break;
        }
    }
    Ok(animators.into_iter().map(|(_, _, rounds)| rounds).collect())
}

impl Rounds {
    /// Adds `count` rounds after one that is not measured; a single round if the deadline is past.
    fn run(
        &mut self,
        count: usize,
        animator: &mut Animator<impl Session>,
        handle_positions: &[f32],
        frames: usize,
        deadline: Instant,
    ) -> Result<()> {
        let mut first = Vec::new();
        for round in 0..1 + count {
            let begin = Instant::now();
            animator.evaluate(handle_positions)?;
            // Asking for the times, or for the smallest result, waits for the last kernel.
            let times = animator.stage_times()?;
            if times.is_none() {
                animator.read(Stage::Strain, &mut first)?;
            }
            let whole = begin.elapsed();
            if round > 0 {
                self.wholes.push(whole.as_secs_f64() * 1e3 / frames as f64);
                for (stage, time) in self.stages.iter_mut().zip(times.into_iter().flatten()) {
                    stage.push(time.as_secs_f64() * 1e3 / frames as f64);
                }
                if Instant::now() > deadline {
                    break;
                }
            }
        }
        Ok(())
    }
}

/// Handle positions that differ in each frame, as those of a take do: between rest and the examples, or some
/// millimetres around rest where there are none.
fn swaying(rig: &Rig, frames: usize) -> Vec<f32> {
    let size = (0.002 / rig.surface().metres_per_unit) as f32;
    let examples = rig.examples().names.len();
    let part = |p: usize, frame: usize| (p as f32 + 0.3 * frame as f32).sin() / examples as f32;
    let frame = |frame: usize| {
        let at_rest = rig.handles().rest.iter().flatten().copied();
        at_rest.enumerate().map(move |(i, x)| match examples {
            0 => x + size * (i as f32 + 0.3 * frame as f32).sin(),
            _ => {
                let moved = |p: usize| rig.examples().handles.row(p)[i / 3][i % 3] - x;
                (0..examples).fold(x, |sum, p| sum + part(p, frame) * moved(p))
            }
        })
    };
    (0..frames).flat_map(frame).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cmd::bench::bytes::Stored;
    use rhytid::core::Method;
    use rhytid_demo::{Size, sized_rig};

    #[test]
    fn times_add_up() {
        let size = Size { vertices: 20_000, handles: 20, examples: 2 };
        let [rig, chapter] = [Method::default(), Method::Chapter].map(|method| sized_rig(size, method));
        let cpu = rhytid::devices::backends::find("cpu:0").unwrap();
        let options = UploadOptions::frames(2);
        let bytes = Stored::new(&rig, options).stages;
        let (whole, stages, beside) =
            measure(&cpu, &rig, Some(&chapter), options, bytes, &Memory::new()).unwrap();
        let sum: f64 = stages.iter().map(|stage| stage.ms).sum();
        // Three stages: the strain, everything up to the positions, and the normals.
        assert!(stages.len() == 3 && sum > 0.0 && sum < 1.5 * whole.ms, "{sum} of {}", whole.ms);
        assert!((whole.fps * whole.ms - 1e3).abs() < 1e-6);
        let beside = beside.unwrap();
        assert!(beside.ms > 0.0 && beside.ratio > 0.0, "{beside:?}");
        let least_ms = whole.bytes / (whole.read_bandwidth_gb_s * 1e6);
        assert!((whole.share_of_bandwidth.unwrap() - least_ms / whole.ms).abs() < 1e-9);
    }
}
