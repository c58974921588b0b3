//! Sessions that are broken on purpose: a suite that does not see them fail, sees nothing.
use crate::case::canary_case;
use crate::outcome::{Outcome, Verdict, device_label, stage_name};
use crate::reference::reference;
use crate::run::{ReferenceOf, examine};
use rhytid_core::{Animator, Device, HandleFrames, Result, Session, Stage};
use std::time::Duration;

/// Spoils one number of each stage by a part in 256, on `device`; an outcome passes where its stage was found to be wrong.
pub fn run_canaries(device: &Device) -> Vec<Outcome> {
    run_canaries_against(device, reference)
}

/// As [`run_canaries`], with another reference.
pub fn run_canaries_against(device: &Device, reference: ReferenceOf) -> Vec<Outcome> {
    Stage::ALL.into_iter().map(|stage| run_canary(device, stage, reference)).collect()
}

fn run_canary(device: &Device, spoiled: Stage, reference: ReferenceOf) -> Outcome {
    let case = canary_case();
    let built = case.build();
    let examined = device.upload(&built.rig, case.options).and_then(|animator| {
        let mut session = Canary { animator, spoiled };
        examine(&mut session, &case, built, reference)
    });
    let (verdict, reason) = match examined {
        // It must be the comparison that sees it, not the repetition of the batch.
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

struct Canary {
    animator: Animator<Box<dyn Session>>,
    spoiled: Stage,
}

impl Session for Canary {
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()> {
        self.animator.evaluate(frames.positions)
    }

    fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        self.animator.read(stage, out)?;
        if stage == self.spoiled
            && let Some(largest) = out.iter_mut().max_by(|a, b| a.abs().total_cmp(&b.abs()))
        {
            *largest *= 1.0 + 1.0 / 256.0;
        }
        Ok(())
    }

    fn stage_times(&mut self) -> Result<Option<[Duration; 6]>> {
        self.animator.stage_times()
    }
}
