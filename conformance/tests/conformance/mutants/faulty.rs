//! The toy backend with one fault.
use crate::toy::ToySession;
use rhytid_conformance::reference::{Found, reference};
use rhytid_core::plan::{Dispatch, PlanLimits};
use rhytid_core::{
    Backend, BasisStorage, DeviceErrorKind, DeviceInfo, Error, HandleFrames, Result, Rig, Session, Stage,
    UploadOptions,
};
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

/// A change of a batch's dispatches.
type Change = dyn Fn(&mut Vec<Dispatch>) + Send + Sync;

/// The fault.
#[derive(Clone)]
pub(super) enum Fault {
    /// Other dispatches are run.
    Run(Arc<Change>),
    /// Other numbers are read.
    Read(fn(&mut ToySession, Stage, &mut Vec<f32>)),
    /// Each batch gives the results of the one before, if that one has as many frames.
    Late,
    /// Only the first batch is computed.
    OnlyFirst,
    /// Each third batch is not computed.
    EveryThird,
    /// A stage keeps its result of the batch before.
    StaleStage(Stage),
    /// Every number of a stage differs from its right value by this part of its bound.
    Off(Stage, f64),
}

impl fmt::Debug for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Fault::Run(_) => "other things run",
            Fault::Read(_) => "other numbers read",
            Fault::Late => "a batch late",
            Fault::OnlyFirst => "only the first batch computed",
            Fault::EveryThird => "each third batch not computed",
            Fault::StaleStage(_) => "a stale stage",
            Fault::Off(..) => "a stage off by a part of its bound",
        })
    }
}

/// The backend.
pub(super) struct Faulty {
    pub limits: PlanLimits,
    pub fault: Fault,
}

/// Its session.
pub(super) struct FaultySession {
    toy: ToySession,
    rig: Rig,
    basis: BasisStorage,
    fault: Fault,
    batches: usize,
    positions: Vec<f32>,
    before: Vec<f32>,
}

impl Backend for Faulty {
    const NAME: &'static str = "faulty";
    type Session = FaultySession;

    fn devices() -> Result<Vec<DeviceInfo>> {
        Ok(Vec::new())
    }

    fn open(_: &DeviceInfo) -> Result<Self> {
        unreachable!("made directly")
    }

    fn upload(&self, rig: &Rig, options: UploadOptions) -> Result<FaultySession> {
        Ok(FaultySession {
            toy: ToySession::new(rig, options, self.limits)?,
            rig: (*rig).clone(),
            basis: options.basis,
            fault: self.fault.clone(),
            batches: 0,
            positions: Vec::new(),
            before: Vec::new(),
        })
    }
}

/// Reads a stage of the toy.
pub(super) fn read(session: &mut ToySession, stage: Stage, out: &mut Vec<f32>) {
    session.read(stage, out).unwrap_or_else(|e| unreachable!("the toy does not fail: {e}"));
}

impl FaultySession {
    fn compute(&mut self, frames: HandleFrames<'_>) {
        let computed = match self.fault {
            Fault::Late if self.before.len() == frames.positions.len() => {
                HandleFrames { positions: &self.before, frames: frames.frames }
            }
            _ => frames,
        };
        self.toy.write(computed);
        let mut dispatches = self.toy.dispatches(frames.frames);
        match &self.fault {
            Fault::Run(change) => change(&mut dispatches),
            Fault::OnlyFirst if self.batches > 1 => dispatches.clear(),
            Fault::EveryThird if self.batches.is_multiple_of(3) => dispatches.clear(),
            Fault::StaleStage(stage) if self.batches > 1 => dispatches.retain(|d| d.stage != *stage),
            _ => {}
        }
        self.toy.run(&dispatches);
    }
}

impl Session for FaultySession {
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()> {
        self.batches += 1;
        // Kernels with the wrong buffers read beyond their ends.
        let computed = catch_unwind(AssertUnwindSafe(|| self.compute(frames)));
        self.before = std::mem::replace(&mut self.positions, frames.positions.to_vec());
        computed.map_err(|_| Error::Device {
            kind: DeviceErrorKind::Driver,
            device: "faulty:0".into(),
            message: "a kernel read past the end of a buffer".into(),
        })
    }

    fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        self.toy.read(stage, out)?;
        match self.fault {
            Fault::Read(change) => change(&mut self.toy, stage, out),
            Fault::Off(off, part) if off == stage => {
                let mut stages: [Vec<f32>; 6] = Default::default();
                for stage in Stage::ALL {
                    self.toy.read(stage, &mut stages[stage as usize])?;
                }
                let found = Found::new(self.rig.clone(), self.basis, &self.positions, stages)?;
                let expected = reference(&found, stage);
                *out = expected.iter().map(|e| (e.value + part * e.bound) as f32).collect();
            }
            _ => {}
        }
        Ok(())
    }

    fn stage_times(&mut self) -> Result<Option<[Duration; 6]>> {
        Ok(None)
    }
}
