//! `rhytid conform`

use super::bench;
use crate::progress::Ui;
use crate::{args, exit, output};
use rhytid::backends::Found;
use rhytid::conformance::{
    DeviceReport, Memory, Outcome, Report, Suite, missing_devices, no_device, read_bandwidth,
    required_backends, run_device, unknown_backends,
};
use rhytid::playback::find_device;
use rhytid::{DeviceInfo, Error, Method, Progress, Result};
use rhytid_demo::{Size, sized_rig};
use std::process::ExitCode;

/// Runs the suite and reports. The exit code says whether every device passed and none that `REQUIRE_BACKENDS` or
/// `REQUIRE_DEVICES` name is missing.
///
/// # Errors
/// [`Error::Device`] if the device that was asked for is absent; [`Error::Io`] from writing; [`Error::Cancelled`].
pub(super) fn run(args: &args::Conform, ui: &Ui) -> Result<ExitCode> {
    let suite = if args.quick { Suite::Quick } else { Suite::Full };
    let (devices, without_device) = match &args.device {
        Some(id) => (vec![find_device(id)?], Vec::new()),
        None => {
            let found = rhytid::backends::devices();
            let without_device = without_device(&found)?;
            (found.devices, without_device)
        }
    };
    let bandwidth = ui.timed("measure the memory", read_bandwidth).0;
    let mut reports = devices.iter().map(|info| examine(info, suite, ui)).collect::<Result<Vec<_>>>()?;
    if suite == Suite::Full {
        let rig = ui.timed("make a rig", || sized_rig(Size::CHAPTER, Method::default())).0;
        let memory = Memory::new();
        for (report, info) in reports.iter_mut().zip(&devices).filter(|(report, _)| report.passed()) {
            ui.report("time the stages", 0, 1);
            // A device that cannot hold the face has no times.
            let times = bench::stage_times(info, &rig, &memory).unwrap_or_default();
            *report = report.clone().with_times(times);
            if ui.cancelled() {
                return Err(Error::Cancelled);
            }
        }
    }
    ui.clear();
    let report = Report::new(suite, bandwidth, reports, without_device);
    output::say(&report.to_terminal())?;
    if let Some(folder) = &args.report {
        report.write(folder)?;
    }
    Ok(if report.passed() { ExitCode::SUCCESS } else { ExitCode::from(exit::OURS) })
}

fn examine(info: &DeviceInfo, suite: Suite, ui: &Ui) -> Result<DeviceReport> {
    let device = match rhytid::backends::open(info) {
        Ok(device) => device,
        Err(error) => return Ok(DeviceReport::not_opened(info, &error)),
    };
    ui.clear();
    if !ui.is_quiet() {
        ui.line(&format!("{} ({})", info.id(), info.name));
    }
    let report = run_device(&device, suite, |_, done, total| {
        ui.report("conform", done as u64, total as u64);
        !ui.cancelled()
    });
    if ui.cancelled() { Err(Error::Cancelled) } else { Ok(report) }
}

/// The outcomes of the backends, and of the devices that are required, that are not here.
fn without_device(found: &Found) -> Result<Vec<Outcome>> {
    let (required, names) = (required_backends(), rhytid::backends::names());
    let unknown = unknown_backends(&required, &names);
    if !unknown.is_empty() {
        return Err(Error::input(format!(
            "REQUIRE_BACKENDS names {}, expected a comma-separated list of {}",
            unknown.join(", "),
            names.join(", ")
        )));
    }
    let missing = found.missing();
    let backends = missing.iter().map(|missing| no_device(missing.backend, &missing.why, &required));
    Ok(backends.chain(missing_devices(&found.devices)).collect())
}
