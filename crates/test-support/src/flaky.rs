//! A backend that fails on request.
use rhytid_backend_cpu::{Cpu, CpuSession};
use rhytid_core::{
    Backend, DeviceErrorKind, DeviceInfo, Error, HandleFrames, Result, Rig, Session, Stage, UploadOptions,
};
use std::time::Duration;

/// The CPU backend, which fails in a batch that its name tells.
///
/// - `evaluate:2` fails in the third batch.
/// - `read:2` fails in the second stage read of the third batch.
/// - `upload` fails at once.
/// - `nothing` computes nothing.
/// - `dark:2` has no normals from the third batch on.
/// - `flipped:2` has normals inside out from the third batch on.
/// - `late:2` has the normals of the frame before from the third batch on.
pub struct Flaky(String);

/// Its session.
pub struct FlakySession {
    session: CpuSession,
    fails: String,
    frames: usize,
    batches: usize,
    reads: usize,
}

fn lost(device: &str) -> Error {
    Error::Device { kind: DeviceErrorKind::Lost, device: device.into(), message: "unplugged".into() }
}

impl Backend for Flaky {
    const NAME: &'static str = "flaky";
    type Session = FlakySession;

    fn devices() -> Result<Vec<DeviceInfo>> {
        Ok(Vec::new())
    }

    fn open(device: &DeviceInfo) -> Result<Self> {
        Ok(Self(device.name.clone()))
    }

    fn upload(&self, rig: &Rig, options: UploadOptions) -> Result<FlakySession> {
        if self.0 == "upload" {
            let kind = DeviceErrorKind::OutOfMemory;
            return Err(Error::Device { kind, device: self.0.clone(), message: "full".into() });
        }
        let session = Cpu.upload(rig, options)?;
        Ok(FlakySession { session, fails: self.0.clone(), frames: 0, batches: 0, reads: 0 })
    }
}

impl Session for FlakySession {
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()> {
        if self.fails == format!("evaluate:{}", self.batches) {
            return Err(lost(&self.fails));
        }
        self.frames = frames.frames;
        self.batches += 1;
        self.reads = 0;
        self.session.evaluate(frames)
    }

    fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        self.reads += 1;
        if self.fails == format!("read:{}", self.batches - 1) && self.reads == 2 {
            out.clear();
            return Err(lost(&self.fails));
        }
        self.session.read(stage, out)?;
        if self.fails == "nothing" {
            out.fill(0.0);
        }
        if let (Stage::Normals, Some((fault, from))) = (stage, self.fails.split_once(':'))
            && self.batches > from.parse().unwrap()
        {
            let frame = out.len() / self.frames;
            match fault {
                "dark" => out.fill(0.0),
                "flipped" => out.iter_mut().for_each(|x| *x = -*x),
                "late" => out.rotate_right(frame),
                _ => {}
            }
        }
        Ok(())
    }

    fn stage_times(&mut self) -> Result<Option<[Duration; 6]>> {
        Ok(None)
    }
}

/// A device of the name, for [`Flaky`].
pub fn info(name: &str) -> DeviceInfo {
    let mut info = Cpu::devices().unwrap().remove(0);
    info.name = name.into();
    info
}

/// The same, but not reported as the CPU, so that it is watched.
pub fn watched(name: &str) -> DeviceInfo {
    DeviceInfo { backend: "flaky", ..info(name) }
}
