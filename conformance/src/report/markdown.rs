//! The report as a page in Markdown.
use super::contents::{Report, number, small};
use crate::outcome::Outcome;
use crate::{DeviceReport, Suite, tolerance};
use rhytid_core::{DeviceKind, Stage};
use std::fmt::Write;

/// The report as a page.
pub(super) fn write(report: &Report) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = page(report, &mut out);
    out
}

fn page(report: &Report, out: &mut String) -> std::fmt::Result {
    writeln!(out, "# Conformance report\n")?;
    let suite = match report.suite {
        Suite::Quick => "quick",
        Suite::Full => "full",
    };
    writeln!(
        out,
        "Made by Rhytid {} at commit `{}` on {}: the {suite} suite. What it does and how to read this is in\n\
         [conformance](conformance.md).\n",
        report.version, report.commit, report.system
    )?;
    writeln!(out, "| device | driver | | outcome |\n| --- | --- | --- | --- |")?;
    for device in &report.devices {
        let verdict = if device.passed() { "**passed**" } else { "**failed**" };
        let kind = if device.software_driver { "software driver" } else { "" };
        let (label, driver) = (cell(&device.label), cell(&device.device.driver));
        writeln!(out, "| `{label}` | {driver} | {kind} | {verdict}: {} |", device.counts())?;
    }
    for Outcome { device, verdict, reason, .. } in &report.without_device {
        writeln!(out, "| `{device}` | | | {verdict}: {} |", cell(reason))?;
    }
    if let Some(bandwidth) = report.memory_bandwidth {
        writeln!(out, "\nMemory, read by all cores in the same run: **{:.1} GB/s**.", bandwidth / 1e9)?;
    }
    writeln!(
        out,
        "\nHow to read the tables:\n\n\
         - `of bound` is the largest difference from the float64 reference, as a part of what rounding may do. At most 1\n  \
           passes.\n\
         - `ulp` is the largest difference in units in the last place of the stage's largest number (of 1 for normals, of\n  \
           at least 1 for strains). It is given where rounding leaves the number determined at all. `mm` is the same in\n  \
           millimetres.\n\
         - `ms` is the device's own time for one frame of the face that the benchmark measures: 530,000 vertices, 89\n  \
           handles, six examples, the learned method. `GB/s` is what the stage must move in that time.\n\
         - A *software driver* is a GPU's API with the processor behind it. It says what the kernels and the driver\n  \
           compute. It says nothing about how fast or how exact a GPU is."
    )?;
    for device in &report.devices {
        section(device, out)?;
    }
    writeln!(out, "\n## What is allowed\n\nThe bound of each stage, with ε = 2⁻²³:\n\n```text")?;
    for stage in Stage::ALL {
        writeln!(out, "{}: {}", crate::stage_name(stage), tolerance::in_words(stage))?;
    }
    writeln!(out, "```")
}

fn section(report: &DeviceReport, out: &mut String) -> std::fmt::Result {
    let info = &report.device;
    writeln!(out, "\n## {}\n", report.label)?;
    let kind = match info.kind {
        _ if report.software_driver => "**This is a software driver.**",
        DeviceKind::Cpu => "The processor.",
        DeviceKind::IntegratedGpu => "An integrated GPU.",
        DeviceKind::DiscreteGpu => "A discrete GPU.",
        DeviceKind::VirtualGpu => "A part of a GPU, given to a virtual machine.",
        _ => "The driver does not say what kind of device it is.",
    };
    let mib = |bytes: Option<u64>, none: &str| {
        bytes.map_or_else(|| none.to_owned(), |bytes| format!("{} MiB", bytes >> 20))
    };
    writeln!(
        out,
        "{}; {}. {kind}\n\nMemory: {}; largest binding: {}. {} in {:.1} s.\n",
        info.name,
        info.driver,
        mib(info.memory_bytes, "not told"),
        mib(info.max_binding_bytes, "no limit"),
        report.counts(),
        report.wall_seconds
    )?;
    writeln!(out, "| stage | kernel | cases | of bound | ulp | mm | ms | GB/s |")?;
    writeln!(out, "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |")?;
    for stage in report.summary() {
        writeln!(
            out,
            "| {} | {} | {} | {:.3} | {} | {} | {} | {} |",
            stage.stage,
            stage.kernel,
            stage.cases,
            stage.part_of_bound,
            number(stage.ulp, 2),
            small(stage.mm),
            number(stage.seconds.map(|s| s * 1e3), 3),
            number(stage.bandwidth.map(|b| b / 1e9), 1)
        )?;
    }
    let exceptions: Vec<&Outcome> = report.exceptions().collect();
    if !exceptions.is_empty() {
        writeln!(out, "\n| | case | |\n| --- | --- | --- |")?;
    }
    for Outcome { verdict, name, reason, .. } in exceptions {
        writeln!(out, "| {verdict} | {} | {} |", cell(name), cell(reason))?;
    }
    Ok(())
}

/// Text that does not end its cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}
