//! The CPU backend against the f64 twin, and against its own f32 twin bit for bit; and sessions that must fail.
use rhytid_backend_cpu::Cpu;
use rhytid_conformance::{Case, StageResult, cases, evaluate, run};
use rhytid_core::{Animator, Backend, DeviceInfo, HandleFrames, Result, Rig, Session, Stage};

fn cpu() -> Cpu {
    Cpu::open(&Cpu::devices().unwrap()[0]).unwrap()
}

fn frames(case: &Case) -> usize {
    case.handle_positions.len() / case.rig.handles.len() / 3
}

#[test]
fn every_stage_of_every_case_is_within_its_rounding() {
    let device = Cpu::devices().unwrap()[0].clone();
    for case in cases() {
        let mut animator = Animator::new(&cpu(), &case.rig, frames(&case)).unwrap();
        for result in run(&mut animator, &case).unwrap() {
            let name = format!("[{}/{}] {} {:?}", device.id(), device.name, case.name, result.stage);
            println!("{name}: {:.3} of the bound", result.worst);
            assert!(result.passed(), "{name}: {:.2} times the bound at {}", result.worst, result.index);
        }
    }
}

#[test]
fn every_stage_has_the_bits_of_the_f32_twin() {
    for case in cases() {
        let mut animator = Animator::new(&cpu(), &case.rig, frames(&case)).unwrap();
        animator.evaluate(&case.handle_positions).unwrap();
        let twin = evaluate(&case.rig, case.handle_positions.as_chunks().0);
        for stage in Stage::ALL {
            let mut found = Vec::new();
            animator.read(stage, &mut found).unwrap();
            let bits = |numbers: &[f32]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert!(
                bits(&found) == bits(twin.stage(stage)),
                "{}: {stage:?} differs from its twin",
                case.name
            );
        }
    }
}

#[test]
fn a_batch_gives_what_its_frames_give_one_by_one() {
    for case in cases() {
        let mut together = Animator::new(&cpu(), &case.rig, frames(&case)).unwrap();
        let mut alone = Animator::new(&cpu(), &case.rig, 1).unwrap();
        together.evaluate(&case.handle_positions).unwrap();
        for stage in Stage::ALL {
            let (mut batch, mut single, mut singles) = (Vec::new(), Vec::new(), Vec::new());
            together.read(stage, &mut batch).unwrap();
            for frame in case.handle_positions.chunks(case.rig.handles.len() * 3) {
                alone.evaluate(frame).unwrap();
                alone.read(stage, &mut single).unwrap();
                singles.extend_from_slice(&single);
            }
            assert_eq!(batch, singles, "{}: {stage:?}", case.name);
        }
    }
}

/// What a broken session does to a stage that it gives back, and the stages that the fault must show in.
type Fault = (&'static str, Stage, fn(&mut Vec<f32>, &Rig));

/// The CPU backend with one fault.
struct Broken(Fault);

struct BrokenSession {
    session: rhytid_backend_cpu::CpuSession,
    rig: Rig,
    fault: Fault,
}

impl Broken {
    fn session(&self, rig: &Rig, max_frames: usize) -> Result<BrokenSession> {
        Ok(BrokenSession { session: cpu().upload(rig, max_frames)?, rig: rig.clone(), fault: self.0 })
    }
}

impl Backend for Broken {
    const NAME: &'static str = "broken";
    type Session = BrokenSession;

    fn devices() -> Result<Vec<DeviceInfo>> {
        Ok(Vec::new())
    }

    fn open(_: &DeviceInfo) -> Result<Self> {
        unreachable!("made directly")
    }

    fn upload(&self, rig: &Rig, max_frames: usize) -> Result<BrokenSession> {
        self.session(rig, max_frames)
    }
}

impl Session for BrokenSession {
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()> {
        self.session.evaluate(frames)
    }

    fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        self.session.read(stage, out)?;
        let (_, broken, fault) = self.fault;
        if stage == broken {
            fault(out, &self.rig);
        }
        Ok(())
    }
}

const FAULTS: [Fault; 7] = [
    ("an edge too few", Stage::Strain, |out, _| {
        out.pop();
    }),
    ("strain two millionths too large", Stage::Strain, |out, _| {
        out.iter_mut().for_each(|x| *x += 2e-6 + 2e-6 * x.abs());
    }),
    ("the last tile dropped", Stage::LargeScale, |out, rig| {
        let start = out.len() - 3 * (rig.vertices() % 64);
        out[start..].fill(0.0);
    }),
    ("the first frame returned for the last", Stage::Positions, |out, rig| {
        let frame = 3 * rig.vertices();
        let last = out.len() - frame;
        out.copy_within(0..frame, last);
    }),
    ("normals turned inside out", Stage::LargeScaleNormals, |out, _| out.iter_mut().for_each(|x| *x = -*x)),
    ("detail with two axes swapped", Stage::Detail, |out, _| {
        out.chunks_exact_mut(3).for_each(|d| d.swap(0, 1));
    }),
    ("one normal that is not a number", Stage::Normals, |out, _| out[0] = f32::NAN),
];

#[test]
fn every_broken_session_fails_in_the_stage_that_is_broken() {
    let case = cases().into_iter().find(|case| case.name == "v1025-h89-f243-p6-k16-frames31").unwrap();
    for fault in FAULTS {
        let mut animator = Animator::new(&Broken(fault), &case.rig, frames(&case)).unwrap();
        let results: Vec<StageResult> = run(&mut animator, &case).unwrap();
        let failed: Vec<Stage> = results.iter().filter(|r| !r.passed()).map(|r| r.stage).collect();
        println!("{}: fails in {failed:?}", fault.0);
        assert!(failed.contains(&fault.1), "{} passes", fault.0);
        // What comes before the fault is not blamed for it, unless nothing could be compared.
        let short = results.iter().any(|r| r.worst.is_nan());
        assert!(short || failed[0] == fault.1, "{} is blamed on {:?}", fault.0, failed[0]);
    }
}
