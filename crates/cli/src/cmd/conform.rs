//! `rhytid conform`

use crate::device_choice::{Missing, Presence};
use crate::progress::Ui;
use crate::{args, device_choice, exit, output};
use rhytid_conformance::{
    DeviceReport, Outcome, Report, Suite, no_device, read_bandwidth, required_backends, run_device,
    unknown_backends,
};
use rhytid_core::{DeviceInfo, Error, Progress, Result};
use std::process::ExitCode;

/// Runs the suite and reports. The exit code says whether every device passed and none that `REQUIRE_BACKENDS` names is
/// missing.
///
/// # Errors
/// [`Error::Device`] if the device that was asked for is absent; [`Error::Io`] from writing; [`Error::Cancelled`].
pub fn run(args: &args::Conform, ui: &Ui) -> Result<ExitCode> {
    let suite = if args.quick { Suite::Quick } else { Suite::Full };
    let (devices, without_device) = match &args.device {
        Some(id) => (vec![device_choice::find(id)?], Vec::new()),
        None => {
            let Presence { devices, missing } = device_choice::presence();
            (devices, without_device(&missing)?)
        }
    };
    let bandwidth = ui.timed("measure the memory", read_bandwidth).0;
    let reports = devices.iter().map(|info| examine(info, suite, ui)).collect::<Result<_>>()?;
    ui.clear();
    let report = Report::new(suite, bandwidth, reports, without_device);
    output::say(&report.to_terminal())?;
    if let Some(folder) = &args.report {
        report.write(folder)?;
    }
    Ok(if report.passed() { ExitCode::SUCCESS } else { ExitCode::from(exit::OURS) })
}

fn examine(info: &DeviceInfo, suite: Suite, ui: &Ui) -> Result<DeviceReport> {
    let device = match rhytid_backends::open(info) {
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

/// The outcomes of the backends that have no device here.
fn without_device(missing: &[Missing]) -> Result<Vec<Outcome>> {
    let required = required_backends();
    let names = rhytid_backends::BACKENDS.iter().map(|backend| backend.name);
    let names: Vec<&str> = names.chain(rhytid_backends::LEFT_OUT.iter().map(|(name, _)| *name)).collect();
    let unknown = unknown_backends(&required, &names);
    if !unknown.is_empty() {
        return Err(Error::input(format!(
            "REQUIRE_BACKENDS names {}, expected a comma-separated list of {}",
            unknown.join(", "),
            names.join(", ")
        )));
    }
    Ok(missing.iter().map(|missing| no_device(missing.backend, &missing.why, &required)).collect())
}
