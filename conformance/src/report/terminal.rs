//! The report as a table for the terminal.
use super::contents::{Report, number, small};
use std::fmt::Write;

/// The report in plain text.
pub(super) fn write(report: &Report) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = table(report, &mut out);
    out
}

fn table(report: &Report, out: &mut String) -> std::fmt::Result {
    for device in &report.devices {
        let info = &device.device;
        writeln!(out, "[{}] {}", device.label, if device.passed() { "PASSED" } else { "FAILED" })?;
        let software = if device.software_driver { " (a software driver)" } else { "" };
        writeln!(out, "  {}{software}, {}", info.name, info.driver)?;
        writeln!(out, "  {} in {:.1} s", device.counts(), device.wall_seconds)?;
        writeln!(
            out,
            "  {:20} {:>5} {:>9} {:>9} {:>9} {:>9} {:>7}",
            "stage", "cases", "of bound", "ulp", "mm", "ms", "GB/s"
        )?;
        for stage in device.summary() {
            writeln!(
                out,
                "  {:20} {:>5} {:>9.3} {:>9} {:>9} {:>9} {:>7}",
                stage.stage,
                stage.cases,
                stage.part_of_bound,
                number(stage.ulp, 2),
                small(stage.mm),
                number(stage.seconds.map(|s| s * 1e3), 3),
                number(stage.bandwidth.map(|b| b / 1e9), 1)
            )?;
        }
        for outcome in device.exceptions() {
            writeln!(out, "  {} {}: {}", outcome.verdict, outcome.name, outcome.reason)?;
        }
        writeln!(out)?;
    }
    for outcome in &report.without_device {
        writeln!(out, "[{}] {}: {}", outcome.device, outcome.verdict, outcome.reason)?;
    }
    if let Some(bandwidth) = report.memory_bandwidth {
        writeln!(out, "memory is read at {:.1} GB/s", bandwidth / 1e9)?;
    }
    writeln!(out, "{}", if report.passed() { "PASSED" } else { "FAILED" })
}
