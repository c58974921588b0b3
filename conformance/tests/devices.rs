//! Every device of this machine against the f64 reference. There is one test for each device, stage and case,
//! named `[vulkan/llvmpipe/0] normals/holes`. (This is a process of its own: its tests are known only once
//! the devices are.)
mod support;

use libtest_mimic::{Arguments, Completion, Failed, Trial};
use rhytid_conformance::{
    Case, Outcome, Suite, Verdict, cases, check_must_pass, device_label, missing_devices, no_device,
    required_backends, run_case, run_mutants, stage_name, unknown_backends,
};
use rhytid_core::{Device, DeviceInfo, Stage};
use std::io::Write;
use std::process::ExitCode;
use std::sync::{Arc, OnceLock};
use support::golden_learned;
use support::head::Head;

fn main() -> ExitCode {
    let mut arguments = Arguments::from_args();
    // The six stages of a case wait for one evaluation; devices and references use all cores themselves.
    arguments.test_threads.get_or_insert(1);
    let found = rhytid_devices::backends::devices();
    let head = Arc::new(OnceLock::new());
    let mut trials: Vec<Trial> = found.devices.iter().flat_map(|info| of_device(info, &head)).collect();

    let (required, names) = (required_backends(), rhytid_devices::backends::names());
    for unknown in unknown_backends(&required, &names) {
        let reason = format!("REQUIRE_BACKENDS asks for {unknown}, which is none of {}", names.join(", "));
        trials.push(Trial::test(format!("[{unknown}] device"), move || Err(Failed::from(reason))));
    }
    let missing = found.missing();
    let backends = missing.iter().map(|missing| no_device(missing.backend, &missing.why, &required));
    for outcome in backends.chain(missing_devices(&found.devices)) {
        let _ = writeln!(std::io::stderr(), "\n*** NOT TESTED: {}: {} ***\n", outcome.device, outcome.reason);
        trials.push(trial(outcome.full_name(), move || Ok(outcome)));
    }
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// What the tests of a device share. The first test that asks computes it, once.
struct Tested {
    info: DeviceInfo,
    device: OnceLock<Result<Device, String>>,
    cases: Vec<Case>,
    outcomes: Vec<OnceLock<Vec<Outcome>>>,
    mutants: OnceLock<Vec<Outcome>>,
}

impl Tested {
    fn device(&self) -> Result<&Device, String> {
        let open = || rhytid_devices::backends::open(&self.info).map_err(|e| e.to_string());
        self.device.get_or_init(open).as_ref().map_err(Clone::clone)
    }

    fn case(&self, i: usize) -> Result<&[Outcome], String> {
        let device = self.device()?;
        Ok(self.outcomes[i].get_or_init(|| run_case(device, &self.cases[i])))
    }

    fn mutants(&self) -> Result<&[Outcome], String> {
        let device = self.device()?;
        Ok(self.mutants.get_or_init(|| run_mutants(device)))
    }

    fn must_pass(&self) -> Result<Outcome, String> {
        let mut outcomes = self.mutants()?.to_vec();
        for i in 0..self.cases.len() {
            outcomes.extend_from_slice(self.case(i)?);
        }
        Ok(check_must_pass(&device_label(&self.info), Suite::Full, &outcomes))
    }
}

fn of_device(info: &DeviceInfo, head: &Arc<OnceLock<Option<Head>>>) -> Vec<Trial> {
    let cases = cases(Suite::Full);
    let tested = Arc::new(Tested {
        info: info.clone(),
        device: OnceLock::new(),
        outcomes: cases.iter().map(|_| OnceLock::new()).collect(),
        mutants: OnceLock::new(),
        cases,
    });
    let label = device_label(info);
    let mut trials = Vec::new();
    for stage in Stage::ALL {
        let tested = tested.clone();
        trials.push(trial(format!("[{label}] {}/mutant", stage_name(stage)), move || {
            tested.mutants().map(|outcomes| outcomes[stage as usize].clone())
        }));
    }
    for (i, case) in tested.cases.iter().enumerate() {
        for stage in Stage::ALL {
            let tested = tested.clone();
            let name = format!("[{label}] {}/{}", stage_name(stage), case.name);
            trials.push(trial(name, move || tested.case(i).map(|outcomes| outcomes[stage as usize].clone())));
        }
    }
    let (of_head, head) = (tested.clone(), head.clone());
    trials.push(Trial::ignorable_test(format!("[{label}] positions/head-rom_3_clean"), move || {
        match head.get_or_init(Head::new) {
            Some(head) => Ok(head.check(of_head.device()?).map(|()| Completion::Completed)?),
            None => Ok(Completion::ignored_with("../shared is not there")),
        }
    }));
    let of_golden = tested.clone();
    trials.push(Trial::ignorable_test(format!("[{label}] positions/golden-learned"), move || {
        match &golden_learned::cases()[..] {
            [] => Ok(Completion::ignored_with("../shared is not there")),
            cases => Ok(golden_learned::check(of_golden.device()?, cases).map(|()| Completion::Completed)?),
        }
    }));
    trials.push(trial(format!("[{label}] must-pass"), move || tested.must_pass()));
    trials
}

/// The outcome for `cargo test`. Its word is in the output unless it is a pass.
fn trial(name: String, outcome: impl FnOnce() -> Result<Outcome, String> + Send + 'static) -> Trial {
    Trial::ignorable_test(name, move || {
        let outcome = outcome()?;
        let said = format!("{}: {}", outcome.verdict, outcome.reason);
        match outcome.verdict {
            Verdict::Pass => Ok(Completion::Completed),
            _ if outcome.is_acceptable() => Ok(Completion::ignored_with(said)),
            _ => Err(Failed::from(said)),
        }
    })
}
