//! `rhytid conform`

use super::bench;
use crate::guard::guard;
use crate::progress::Ui;
use crate::{args, exit_code, output};
use rhytid::conformance::{
    DeviceReport, Memory, Outcome, Report, StageTime, Suite, missing_devices, no_device, read_bandwidth,
    required_backends, run_device, unknown_backends,
};
use rhytid::core::DeviceInfo;
use rhytid::core::Method;
use rhytid::devices::Guard;
use rhytid::devices::Heartbeat;
use rhytid::devices::PATIENCE;
use rhytid::devices::answer;
use rhytid::devices::backends::Found;
use rhytid::devices::devices;
use rhytid::devices::find_device;
use rhytid::{Error, InputErrorKind, Progress, Result};
use rhytid_demo::{Size, sized_rig};
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// Runs the suite and reports.
///
/// The exit code says whether every device passed and no device is missing that `REQUIRE_BACKENDS` or
/// `REQUIRE_DEVICES` names.
///
/// # Errors
/// [`Error::Device`] if the requested device is absent; [`Error::Io`] from writing; [`Error::Cancelled`].
pub(super) fn run(args: &args::Conform, ui: &Ui) -> Result<u8> {
    let suite = if args.quick { Suite::Quick } else { Suite::Full };
    let (devices, without_device) = match &args.device {
        Some(id) => (vec![find_device(id, guard())?], Vec::new()),
        None => {
            let found = devices(guard());
            let without_device = without_device(&found)?;
            (found.devices, without_device)
        }
    };
    let bandwidth = ui.timed("measure the memory", read_bandwidth).0;
    let reports = devices.iter().map(|info| examine(info, suite, ui)).collect::<Result<Vec<_>>>()?;
    ui.clear();
    let report = Report::new(suite, bandwidth, reports, without_device);
    match args.json.wanted {
        true => output::json(&report)?,
        false => output::say(&report.to_terminal())?,
    }
    if let Some(folder) = &args.report {
        report.write(folder)?;
    }
    Ok(if report.passed() { exit_code::DONE } else { exit_code::OURS })
}

/// The time limit of a case, also on a busy machine.
const CASE: Duration = PATIENCE.saturating_mul(2);

/// The time limit of a large case. The chapter's face takes SwiftShader 19 s on two cores.
const LARGE_CASE: Duration = PATIENCE.saturating_mul(20);

/// The time limit of the times. A device that got there has passed every case.
const TIMES: Duration = Duration::from_secs(600);

/// Runs the suite on a device behind the guard, so that a driver that crashes or hangs is an outcome.
fn examine(info: &DeviceInfo, suite: Suite, ui: &Ui) -> Result<DeviceReport> {
    ui.clear();
    if !ui.is_quiet() {
        ui.line(&format!("{} ({})", info.id(), info.name));
    }
    if !guard().is_on() {
        let found = found(info, suite, |_, done, total| ui.report("conform", done as u64, total as u64));
        return Ok(found.report(info));
    }
    let name = if suite == Suite::Quick { QUICK } else { FULL };
    let answer = guard().ask(&[CONFORM, &info.id(), name], &info.id(), &[], ui, |sign| {
        let &[size, done, total] = &sign.split(' ').collect::<Vec<_>>()[..] else {
            ui.report("time the stages", 0, 1);
            return TIMES;
        };
        ui.report("conform", done.parse().unwrap_or_default(), total.parse().unwrap_or(1));
        if size == LARGE { LARGE_CASE } else { CASE }
    });
    let unreadable = |error| Error::Internal(format!("what was found of {}: {error}", info.id()));
    match answer.and_then(|answer| toml::from_str::<Conformance>(&answer).map_err(unreadable)) {
        Ok(found) => Ok(found.report(info)),
        Err(Error::Cancelled) => Err(Error::Cancelled),
        Err(error) => Ok(DeviceReport::not_opened(info, &error)),
    }
}

const CONFORM: &str = "conform";
const QUICK: &str = "quick";
const FULL: &str = "full";
const LARGE: &str = "large";
const USUAL: &str = "usual";

/// A child's findings: the parts of a [`DeviceReport`] that the parent does not know.
#[derive(Serialize, Deserialize)]
struct Conformance {
    wall_seconds: f64,
    outcomes: Vec<Outcome>,
    times: Vec<StageTime>,
}

impl Conformance {
    fn report(self, info: &DeviceInfo) -> DeviceReport {
        DeviceReport::new(info, self.outcomes, self.wall_seconds).with_times(self.times)
    }
}

/// `rhytid look`, the guard's child.
///
/// # Errors
/// As [`answer`].
pub(super) fn look(request: &[String]) -> Result<()> {
    let [what, id, suite] = request else { return answer(request) };
    if what != CONFORM {
        return answer(request);
    }
    let info = find_device(id, Guard::NONE)?;
    let suite = if suite == QUICK { Suite::Quick } else { Suite::Full };
    let found = found(&info, suite, |is_large, done, total| {
        let size = if is_large { LARGE } else { USUAL };
        Heartbeat.tell(&if done < total { format!("{size} {done} {total}") } else { "times".to_owned() });
    });
    Heartbeat.answer(&toml::to_string(&found).map_err(|error| Error::Internal(error.to_string()))?)
}

/// Runs the suite, and times the stages of a device that passes the full one.
///
/// `before` is told whether the next case is large, the number of finished cases and their total. Before the
/// times both numbers are equal.
fn found(info: &DeviceInfo, suite: Suite, before: impl Fn(bool, usize, usize)) -> Conformance {
    let device = match rhytid::devices::backends::open(info) {
        Ok(device) => device,
        Err(error) => {
            let DeviceReport { outcomes, wall_seconds, .. } = DeviceReport::not_opened(info, &error);
            return Conformance { wall_seconds, outcomes, times: Vec::new() };
        }
    };
    let report = run_device(&device, suite, |case, done, total| {
        before(case.large, done, total);
        true
    });
    let mut times = Vec::new();
    if suite == Suite::Full && report.passed() {
        before(false, 1, 1);
        let rig = sized_rig(Size::CHAPTER, Method::default());
        // A device that is too small for the face has no times.
        times = bench::stage_times(info, &rig, &Memory::new()).unwrap_or_default();
    }
    Conformance { wall_seconds: report.wall_seconds, outcomes: report.outcomes, times }
}

/// The outcomes of required backends and devices that are missing.
fn without_device(found: &Found) -> Result<Vec<Outcome>> {
    let (required, names) = (required_backends(), rhytid::devices::backends::names());
    let unknown = unknown_backends(&required, &names);
    if !unknown.is_empty() {
        return Err(Error::input(format!(
            "REQUIRE_BACKENDS names {}, expected a comma-separated list of {}",
            unknown.join(", "),
            names.join(", ")
        ))
        .of_kind(InputErrorKind::UnknownName { name: unknown.join(", ") }));
    }
    let missing = found.missing();
    let backends = missing.iter().map(|missing| no_device(missing.backend, &missing.why, &required));
    Ok(backends.chain(missing_devices(&found.devices)).collect())
}
