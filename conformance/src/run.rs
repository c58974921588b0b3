//! One case on one device: evaluated, compared stage by stage, and evaluated again in other ways.
use crate::compare::compare;
use crate::driven::{AsyncDevice, AsyncSession};
use crate::expected::Expected;
use crate::outcome::{Measured, Outcome, Verdict, device_label, stage_name};
use crate::reference::{Found, reference};
use crate::{Built, Case, expectations};
use rhytid_core::{Device, DeviceErrorKind, Error, HandleFrames, Result, Stage};

/// The function that gives a stage's expected values: [`reference()`], except in tests of the suite itself.
pub type ReferenceOf = fn(&Found, Stage) -> Vec<Expected>;

/// The largest number of a batch's frames that are also evaluated one by one.
const SINGLE_FRAMES: usize = 32;

/// Runs `case` on `device`: one outcome for each stage, in the order of [`Stage::ALL`]. Known failures in
/// `expectations.toml` are taken into account.
///
/// The batch is evaluated after the largest possible other batch, so that a stale frame shows. Every stage is
/// compared with the right result of its kernel for the device's own inputs. Then the frames are evaluated
/// one by one. At the end the other batch and this one are evaluated again. Both repetitions must give the
/// same bits.
pub fn run_case(device: &Device, case: &Case) -> Vec<Outcome> {
    pollster::block_on(run_case_async(device, case))
}

/// As [`run_case`], where results are awaited.
pub(crate) async fn run_case_async(device: &impl AsyncDevice, case: &Case) -> Vec<Outcome> {
    let mut outcomes = run_case_against_async(device, case, reference).await;
    for outcome in &mut outcomes {
        expectations::embedded().apply(device.info(), outcome);
    }
    outcomes
}

/// As [`run_case`], but compared with `reference` and without expectations.
pub fn run_case_against(device: &Device, case: &Case, reference: ReferenceOf) -> Vec<Outcome> {
    pollster::block_on(run_case_against_async(device, case, reference))
}

async fn run_case_against_async(
    device: &impl AsyncDevice,
    case: &Case,
    reference: ReferenceOf,
) -> Vec<Outcome> {
    let built = case.build();
    let examined = match device.upload(&built.rig, case.options) {
        Ok(mut session) => examine(&mut session, case, built, reference).await,
        Err(error) => Err(error),
    };
    let label = device_label(device.info());
    let outcome = |stage: Stage, verdict, reason| {
        let name = format!("{}/{}", stage_name(stage), case.name);
        let mut outcome = Outcome::new(&label, name, verdict, reason);
        outcome.stage = Some(stage_name(stage));
        outcome.required = case.quick;
        outcome
    };
    match examined {
        Ok(stages) => Stage::ALL
            .into_iter()
            .zip(stages)
            .map(|(stage, examined)| {
                let Examined { measured, problems } = examined;
                let verdict = if problems.is_empty() { Verdict::Pass } else { Verdict::Fail };
                let mut outcome = outcome(stage, verdict, problems.join("; "));
                outcome.measured = measured;
                outcome
            })
            .collect(),
        Err(error) => {
            let verdict = match &error {
                Error::Device { kind: DeviceErrorKind::Unsupported, .. } => Verdict::NotSupported,
                Error::Device { kind: DeviceErrorKind::OutOfMemory, .. } if case.large => {
                    Verdict::NotSupported
                }
                _ => Verdict::Fail,
            };
            Stage::ALL.map(|stage| outcome(stage, verdict, error.to_string())).into()
        }
    }
}

/// The findings about a stage.
#[derive(Default)]
pub(crate) struct Examined {
    /// `None` where nothing was compared.
    pub measured: Option<Measured>,
    /// What is wrong; empty if nothing is.
    pub problems: Vec<String>,
}

/// Runs a case on a session that holds its rig.
pub(crate) async fn examine(
    session: &mut impl AsyncSession,
    case: &Case,
    built: Built,
    reference: ReferenceOf,
) -> Result<[Examined; 6]> {
    let Built { rig, handle_positions } = built;
    let batch = Batch { handles: rig.handles().len(), positions: &handle_positions };
    let other = batch.other(case.options.max_frames);
    let other = Batch { handles: rig.handles().len(), positions: &other };

    other.evaluate(session)?;
    let stages = batch.evaluate_and_read(session).await?;
    let mut examined: [Examined; 6] = Default::default();
    let mut whole = true;
    for stage in Stage::ALL {
        let (found, expected) = (stages[stage as usize].len(), batch.frames() * stage.values_per_frame(&rig));
        if found != expected {
            whole = false;
            examined[stage as usize]
                .problems
                .push(format!("the batch has {found} numbers, expected {expected}"));
        }
    }
    if !whole {
        for examined in examined.iter_mut().filter(|examined| examined.problems.is_empty()) {
            examined
                .problems
                .push("nothing was compared: another stage is not as long as it should be".into());
        }
        return Ok(examined);
    }
    repeat(session, &batch, &other, &stages, &mut examined).await?;

    let metres_per_unit = rig.surface().metres_per_unit;
    let found = Found::new(rig, case.options.basis, &handle_positions, stages)?;
    for stage in Stage::ALL {
        let comparison = compare(stage, found.stage(stage), &reference(&found, stage), metres_per_unit);
        examined[stage as usize].measured = comparison.measured;
        examined[stage as usize].problems.extend(comparison.problem);
    }
    Ok(examined)
}

/// Frames one by one, and the batch after another batch, must have the bits of the first evaluation.
async fn repeat(
    session: &mut impl AsyncSession,
    batch: &Batch<'_>,
    other: &Batch<'_>,
    stages: &[Vec<f32>; 6],
    examined: &mut [Examined; 6],
) -> Result<()> {
    let frames = batch.frames();
    let mut differs = [None; 6];
    for frame in (0..frames).step_by(frames.div_ceil(SINGLE_FRAMES)) {
        let single = batch.frame(frame).evaluate_and_read(session).await?;
        for (i, single) in single.iter().enumerate() {
            let of_frame = &stages[i][frame * (stages[i].len() / frames)..][..stages[i].len() / frames];
            if !same_bits(single, of_frame) {
                differs[i].get_or_insert(frame);
            }
        }
    }
    for (examined, differs) in examined.iter_mut().zip(differs) {
        examined.problems.extend(differs.map(|frame| {
            format!("frame {frame} of the batch has other bits when it is evaluated by itself")
        }));
    }
    other.evaluate(session)?;
    let again = batch.evaluate_and_read(session).await?;
    for (i, again) in again.iter().enumerate() {
        if !same_bits(again, &stages[i]) {
            examined[i].problems.push("the batch has other bits when it is evaluated again".into());
        }
    }
    Ok(())
}

fn same_bits(a: &[f32], b: &[f32]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

/// Handle positions of some frames.
struct Batch<'a> {
    handles: usize,
    positions: &'a [f32],
}

impl Batch<'_> {
    fn frames(&self) -> usize {
        self.positions.len() / (self.handles * 3)
    }

    fn frame(&self, frame: usize) -> Batch<'_> {
        let numbers = self.handles * 3;
        Batch { handles: self.handles, positions: &self.positions[frame * numbers..][..numbers] }
    }

    /// The positions of this many other frames.
    fn other(&self, frames: usize) -> Vec<f32> {
        let frames = (0..self.frames()).rev().cycle().take(frames);
        frames.flat_map(|frame| self.frame(frame).positions.to_vec()).map(|x| 0.75 * x).collect()
    }

    fn evaluate(&self, session: &mut impl AsyncSession) -> Result<()> {
        session.evaluate(HandleFrames { positions: self.positions, frames: self.frames() })
    }

    async fn evaluate_and_read(&self, session: &mut impl AsyncSession) -> Result<[Vec<f32>; 6]> {
        self.evaluate(session)?;
        let mut stages: [Vec<f32>; 6] = Default::default();
        for stage in Stage::ALL {
            session.read(stage, &mut stages[stage as usize]).await?;
        }
        Ok(stages)
    }
}
