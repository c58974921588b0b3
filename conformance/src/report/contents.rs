//! The contents of a report: devices, their outcomes, and each stage over all cases.
use crate::outcome::{Outcome, Verdict, kernel_name, stage_name};
use crate::{COMMIT, DeviceReport, Suite};
use rhytid_core::Stage;
use serde::Serialize;

/// The results of a run.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// The version of this program.
    pub version: &'static str,
    /// [`COMMIT`].
    pub commit: &'static str,
    /// What was run.
    pub suite: Suite,
    /// `linux x86_64`.
    pub system: String,
    /// Bytes a second that all cores together read from memory in this run. `None` where it was not measured,
    /// as in a browser.
    pub memory_bandwidth: Option<f64>,
    /// One for each device.
    pub devices: Vec<DeviceReport>,
    /// The outcomes of backends without a device.
    pub without_device: Vec<Outcome>,
}

/// One stage on one device, over all cases.
#[derive(Debug, Clone, PartialEq)]
pub struct StageSummary {
    /// The stage's name.
    pub stage: &'static str,
    /// The kernel that computes it.
    pub kernel: &'static str,
    /// Cases that were compared.
    pub cases: usize,
    /// The largest difference as a part of its bound.
    pub part_of_bound: f64,
    /// The largest difference, see [`crate::Measured::ulp`].
    pub ulp: Option<f64>,
    /// The largest difference in millimetres, see [`crate::Measured::mm`].
    pub mm: Option<f64>,
    /// Seconds at the chapter's size.
    pub seconds: Option<f64>,
    /// Bytes a second at the chapter's size.
    pub bandwidth: Option<f64>,
}

impl Report {
    /// Puts a run together.
    pub fn new(
        suite: Suite,
        memory_bandwidth: impl Into<Option<f64>>,
        devices: Vec<DeviceReport>,
        without_device: Vec<Outcome>,
    ) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            commit: COMMIT,
            suite,
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            memory_bandwidth: memory_bandwidth.into(),
            devices,
            without_device,
        }
    }

    /// Whether all devices may be trusted and no required backend is missing.
    pub fn passed(&self) -> bool {
        self.devices.iter().all(DeviceReport::passed)
            && self.without_device.iter().all(Outcome::is_acceptable)
            && !self.devices.is_empty()
    }
}

impl DeviceReport {
    /// Each stage over all cases except the mutants, in the order of [`Stage::ALL`].
    pub fn summary(&self) -> [StageSummary; 6] {
        Stage::ALL.map(|stage| {
            let name = stage_name(stage);
            let of_stage = || {
                let outcomes = self.outcomes.iter().filter(move |o| o.stage == Some(name));
                outcomes.filter(|o| !o.name.ends_with("/mutant"))
            };
            let measured = || of_stage().filter_map(|o| o.measured);
            let largest = |numbers: &mut dyn Iterator<Item = f64>| numbers.reduce(f64::max);
            let timed = self.times.iter().find(|time| time.stage == name);
            StageSummary {
                stage: name,
                kernel: kernel_name(stage),
                cases: measured().count(),
                part_of_bound: largest(&mut measured().map(|m| m.part_of_bound)).unwrap_or(0.0),
                ulp: largest(&mut measured().filter_map(|m| m.ulp)),
                mm: largest(&mut measured().filter_map(|m| m.mm)),
                seconds: timed.map(|time| time.seconds),
                bandwidth: timed.filter(|time| time.seconds > 0.0).map(|time| time.bytes / time.seconds),
            }
        })
    }

    /// The outcomes other than a pass.
    pub(super) fn exceptions(&self) -> impl Iterator<Item = &Outcome> {
        self.outcomes.iter().filter(|outcome| outcome.verdict != Verdict::Pass)
    }

    /// `312 Pass, 6 NotSupported`.
    pub(super) fn counts(&self) -> String {
        let verdicts = [Verdict::Pass, Verdict::Fail, Verdict::NotSupported, Verdict::Waived];
        let counts = verdicts.map(|verdict| (verdict, self.count(verdict)));
        let counts = counts.iter().filter(|(verdict, n)| *n > 0 || *verdict == Verdict::Fail);
        counts.map(|(verdict, n)| format!("{n} {verdict}")).collect::<Vec<_>>().join(", ")
    }
}

/// `0.61`, or a dash.
pub(super) fn number(x: Option<f64>, digits: usize) -> String {
    x.map_or_else(|| "–".into(), |x| format!("{x:.digits$}"))
}

/// `3.1e-6`, or a dash.
pub(super) fn small(x: Option<f64>) -> String {
    x.map_or_else(|| "–".into(), |x| if x == 0.0 { "0".into() } else { format!("{x:.1e}") })
}
