//! A suite on a device.
use crate::mutant::run_mutants_async;
use crate::outcome::{Outcome, Verdict, device_label};
use crate::outcome::{StageName, read_stage_name};
use crate::reference::reference;
use crate::run::run_case_async;
use crate::{AsyncDevice, Case, Suite, cases, check_must_pass};
use rhytid_core::{Device, DeviceInfo};
use serde::{Deserialize, Serialize};
use web_time::Instant;
use wildmatch::WildMatch;

/// The results of a suite on one device.
#[derive(Debug, Clone, Serialize)]
pub struct DeviceReport {
    /// The device's [`device_label`].
    pub label: String,
    /// The device.
    pub device: DeviceInfo,
    /// Whether it is a GPU's API that runs on the processor alone.
    pub software_driver: bool,
    /// Everything that reported, including the mutants and the must-pass list.
    pub outcomes: Vec<Outcome>,
    /// How long the suite took, in seconds.
    pub wall_seconds: f64,
    /// The time of each stage, if it was measured; see [`DeviceReport::with_times`].
    pub times: Vec<StageTime>,
}

/// The time of a stage for one frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StageTime {
    /// The stage's [`crate::stage_name`].
    #[serde(deserialize_with = "read_stage_name")]
    pub stage: StageName,
    /// Seconds per frame.
    pub seconds: f64,
    /// The least number of bytes that it has to move.
    pub bytes: f64,
}

impl DeviceReport {
    /// A report of outcomes that were not collected by [`run_device`].
    pub fn new(device: &DeviceInfo, outcomes: Vec<Outcome>, wall_seconds: f64) -> Self {
        Self {
            label: device_label(device),
            device: device.clone(),
            software_driver: device.is_software_driver(),
            outcomes,
            wall_seconds,
            times: Vec::new(),
        }
    }

    /// Adds times of the chapter's face: 530,000 vertices, 89 handles and six examples.
    /// They are measured on a rig whose neighbours on the face are neighbours in memory. The suite's made-up
    /// rigs are not like that.
    #[must_use]
    pub fn with_times(self, times: Vec<StageTime>) -> Self {
        Self { times, ..self }
    }

    /// The report of a device that does not even open.
    pub fn not_opened(device: &DeviceInfo, reason: &rhytid_core::Error) -> Self {
        let label = device_label(device);
        let outcome = Outcome::new(&label, "open".into(), Verdict::Fail, reason.to_string());
        Self::new(device, vec![outcome], 0.0)
    }

    /// Whether the device may be trusted.
    pub fn passed(&self) -> bool {
        !self.outcomes.is_empty() && self.outcomes.iter().all(Outcome::is_acceptable)
    }

    /// How many outcomes have this verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.outcomes.iter().filter(|outcome| outcome.verdict == verdict).count()
    }
}

/// Runs a suite on `device`: every case, the mutants, and the must-pass list over all of them.
/// `before` gets each case before it runs, the number of cases before it and the total. If it returns
/// `false`, the run stops, and the must-pass list reports the missing cases.
pub fn run_device(
    device: &Device,
    suite: Suite,
    before: impl FnMut(&Case, usize, usize) -> bool,
) -> DeviceReport {
    pollster::block_on(run_device_async(device, suite, before))
}

/// As [`run_device`], where results are awaited.
pub async fn run_device_async(
    device: &impl AsyncDevice,
    suite: Suite,
    mut before: impl FnMut(&Case, usize, usize) -> bool,
) -> DeviceReport {
    let start = Instant::now();
    let mut outcomes = run_mutants_async(device, reference).await;
    let cases = cases(suite);
    for (i, case) in cases.iter().enumerate() {
        if !before(case, i, cases.len()) {
            break;
        }
        outcomes.extend(run_case_async(device, case).await);
    }
    outcomes.push(check_must_pass(&device_label(device.info()), suite, &outcomes));
    DeviceReport::new(device.info(), outcomes, start.elapsed().as_secs_f64())
}

/// The backends in `REQUIRE_BACKENDS`, a comma-separated list. Their absence is a failure.
pub fn required_backends() -> Vec<String> {
    let list = std::env::var("REQUIRE_BACKENDS").unwrap_or_default();
    list.split(',').map(|name| name.trim().to_owned()).filter(|name| !name.is_empty()).collect()
}

/// The outcomes of required devices that are missing.
/// `REQUIRE_DEVICES` is a comma-separated list of patterns such as `vulkan/llvmpipe*,wgpu/*OpenGL*`. A
/// pattern that matches no device's label and driver gives an outcome, and none of these is acceptable.
pub fn missing_devices(present: &[DeviceInfo]) -> Vec<Outcome> {
    let list = std::env::var("REQUIRE_DEVICES").unwrap_or_default();
    let names: Vec<String> = present.iter().map(|d| format!("{} ({})", device_label(d), d.driver)).collect();
    let patterns = list.split(',').map(str::trim).filter(|pattern| !pattern.is_empty());
    let is_missing = |pattern: &&str| !names.iter().any(|name| WildMatch::new(pattern).matches(name));
    let outcome = |pattern: &str| {
        let why = "no device here is that, and REQUIRE_DEVICES asks for it";
        Outcome::new(pattern, "device".into(), Verdict::NoDevice, why.into())
    };
    patterns.filter(is_missing).map(outcome).collect()
}

/// The names in `required` that no backend has, so that a typing error does not switch a check off.
pub fn unknown_backends(required: &[String], known: &[&str]) -> Vec<String> {
    required.iter().filter(|name| !known.contains(&name.as_str())).cloned().collect()
}

/// The outcome of a backend without a device; acceptable unless the backend is required.
pub fn no_device(backend: &str, why: &str, required: &[String]) -> Outcome {
    let mut outcome = Outcome::new(backend, "device".into(), Verdict::NoDevice, why.to_owned());
    outcome.required = required.iter().any(|name| name == backend);
    if outcome.required {
        outcome.reason = format!("{why}, and REQUIRE_BACKENDS asks for it");
    }
    outcome
}
