//! Sessions that are broken on purpose. A suite that does not see them fail is blind.
use crate::case::mutant_case;
use crate::driven::{AsyncDevice, AsyncSession};
use crate::outcome::{Outcome, Verdict, device_label, stage_name};
use crate::reference::reference;
use crate::run::{ReferenceOf, examine};
use rhytid_core::{Device, HandleFrames, Result, Stage};

/// Changes one number of each stage by a part in 256, on `device`. An outcome passes if the suite finds its
/// stage to be wrong.
pub fn run_mutants(device: &Device) -> Vec<Outcome> {
    run_mutants_against(device, reference)
}

/// As [`run_mutants`], with another reference.
pub fn run_mutants_against(device: &Device, reference: ReferenceOf) -> Vec<Outcome> {
    pollster::block_on(run_mutants_async(device, reference))
}

/// As [`run_mutants_against`], where results are awaited.
pub(crate) async fn run_mutants_async(device: &impl AsyncDevice, reference: ReferenceOf) -> Vec<Outcome> {
    let mut outcomes = Vec::new();
    for stage in Stage::ALL {
        outcomes.push(run_mutant(device, stage, reference).await);
    }
    outcomes
}

async fn run_mutant(device: &impl AsyncDevice, spoiled: Stage, reference: ReferenceOf) -> Outcome {
    let case = mutant_case();
    let built = case.build();
    let examined = match device.upload(&built.rig, case.options) {
        Ok(session) => examine(&mut Mutant { session, spoiled }, &case, built, reference).await,
        Err(error) => Err(error),
    };
    let (verdict, reason) = match examined {
        // The comparison must see the fault, not the repetition of the batch.
        Ok(stages) if stages[spoiled as usize].measured.is_some_and(|m| m.part_of_bound > 1.0) => {
            (Verdict::Pass, String::new())
        }
        Ok(_) => (Verdict::Fail, "a number was spoiled and nobody saw it: this suite proves nothing".into()),
        Err(error) => (Verdict::Fail, error.to_string()),
    };
    let name = format!("{}/{}", stage_name(spoiled), case.name);
    let mut outcome = Outcome::new(&device_label(device.info()), name, verdict, reason);
    outcome.stage = Some(stage_name(spoiled));
    outcome
}

struct Mutant<S> {
    session: S,
    spoiled: Stage,
}

impl<S: AsyncSession> AsyncSession for Mutant<S> {
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()> {
        self.session.evaluate(frames)
    }

    async fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        self.session.read(stage, out).await?;
        if stage == self.spoiled
            && let Some(largest) = out.iter_mut().max_by(|a, b| a.abs().total_cmp(&b.abs()))
        {
            *largest *= 1.0 + 1.0 / 256.0;
        }
        Ok(())
    }
}
