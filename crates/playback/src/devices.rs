//! The choice of a device: one by its id, or `auto`, the fastest that passes the quick conformance suite.
//!
//! A processor behind a GPU's API comes after all others, the CPU backend among them: the two do the same work on the same
//! cores about as fast, so that chance would choose between them, and with them between two roundings.
//!
//! `auto` tries a device once for each version of its driver and of this program, and caches the outcome in the user's cache
//! folder.

use etcetera::BaseStrategy;
use rhytid_backends::Found;
use rhytid_conformance::{COMMIT, Suite, run_device, timing_case};
use rhytid_core::{AtomicFile, Device, DeviceErrorKind, DeviceInfo, Error, Progress, Result, Stage};
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Every device present; a backend whose driver fails is a warning, since the others still work.
fn present() -> Vec<DeviceInfo> {
    let Found { devices, failed } = rhytid_backends::devices();
    for (backend, error) in failed {
        log::warn!("the backend {backend} is left out: {error}");
    }
    devices
}

/// The device with this id, or the first of a backend that is named alone.
///
/// # Errors
/// [`Error::Device`] lists those present: a device asked for and absent is never replaced by another.
pub fn find_device(id: &str) -> Result<DeviceInfo> {
    let first = format!("{id}:0");
    let id = if id.contains(':') { id } else { &first };
    if let Some(device) = rhytid_backends::find(id) {
        return Ok(device);
    }
    let present = present();
    let list: Vec<String> = present.iter().map(|d| format!("{} ({})", d.id(), d.name)).collect();
    let backend = id.split(':').next().unwrap_or_default();
    let left_out = rhytid_backends::LEFT_OUT.iter().find(|(name, _)| *name == backend);
    let hint = left_out.map(|(name, how)| format!("; this program was built without {name}: {how}"));
    Err(Error::Device {
        kind: DeviceErrorKind::NotFound,
        device: id.to_owned(),
        message: format!(
            "no such device here; expected auto or one of: {}{}",
            list.join(", "),
            hint.unwrap_or_default()
        ),
    })
}

/// Devices to evaluate on, the one to take first; those behind it are for when it fails.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// At least one.
    pub devices: Vec<DeviceInfo>,
    /// Why the first is the first, as a phrase that begins with its id; `None` where it was asked for by its id.
    pub reason: Option<String>,
}

/// The device with the id `wanted`; for `auto` those that pass the quick conformance suite, fastest first.
///
/// # Errors
/// As [`find_device`]; for `auto` [`Error::Device`] if none passes, and [`Error::Cancelled`].
pub fn choose_devices(wanted: &str, progress: &dyn Progress) -> Result<Choice> {
    if wanted == "auto" {
        return auto(progress);
    }
    Ok(Choice { devices: vec![find_device(wanted)?], reason: None })
}

/// What was found out about a device.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Trial {
    backend: String,
    name: String,
    driver: String,
    /// What failed: `kernel/case`, or the device's error. Empty where everything passed.
    failed: Vec<String>,
    /// Of a face of 65,536 vertices with positions and normals read back; 0 where something failed.
    frames_per_second: f64,
}

impl Trial {
    fn is_of(&self, device: &DeviceInfo) -> bool {
        self.backend == device.backend && self.name == device.name && self.driver == device.driver
    }
}

/// What lies in the cache folder.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Cache {
    program: String,
    devices: Vec<Trial>,
}

/// The devices that pass the quick suite, fastest first.
fn auto(progress: &dyn Progress) -> Result<Choice> {
    let cache = cache_file();
    let mut known = cache.as_deref().map(read_cache).unwrap_or_default();
    let present = present();
    let mut tried = Vec::new();
    let mut is_new = false;
    for (i, device) in present.iter().enumerate() {
        let outcome = known.devices.iter().find(|tried| tried.is_of(device)).cloned();
        let outcome = match outcome {
            Some(outcome) => outcome,
            None => {
                progress.report("try the devices", i as u64, present.len() as u64);
                is_new = true;
                let outcome = try_device(device, progress)?;
                known.devices.push(outcome.clone());
                outcome
            }
        };
        tried.push((device.clone(), outcome));
    }
    if is_new {
        progress.report("try the devices", present.len() as u64, present.len() as u64);
        if let Some(path) = &cache
            && let Err(error) = write_cache(path, &known)
        {
            log::warn!("what was found out about the devices is not cached: {error}");
        }
    }
    let (devices, reason) = rank(tried)?;
    Ok(Choice { devices, reason: Some(reason) })
}

/// Fastest first, without those that failed and with software drivers last, and a sentence that says why the first is the first.
fn rank(mut tried: Vec<(DeviceInfo, Trial)>) -> Result<(Vec<DeviceInfo>, String)> {
    let total = tried.len();
    let failed: Vec<String> = tried
        .iter()
        .filter(|(_, tried)| !tried.failed.is_empty())
        .map(|(device, tried)| format!("{} fails {}", device.id(), tried.failed.join(", ")))
        .collect();
    for sentence in &failed {
        log::warn!("auto leaves a device out: {sentence}; see `rhytid conform`");
    }
    tried.retain(|(_, tried)| tried.failed.is_empty());
    tried.sort_by(|(a_device, a), (b_device, b)| {
        let slower = b.frames_per_second.total_cmp(&a.frames_per_second);
        a_device.is_software_driver().cmp(&b_device.is_software_driver()).then(slower)
    });
    let Some((first, best)) = tried.first() else {
        return Err(Error::Device {
            kind: DeviceErrorKind::NotFound,
            device: "auto".into(),
            message: match failed.as_slice() {
                [] => "no device was found here".into(),
                failed => format!("no device passes the quick conformance suite: {}", failed.join("; ")),
            },
        });
    };
    let software = tried.iter().filter(|(device, _)| device.is_software_driver()).count();
    let (peers, last) = match (tried.len() - software, software) {
        (0, software) => (software, String::new()),
        (peers, 0) => (peers, String::new()),
        (peers, software) => (peers, format!("; software drivers come last: {software}")),
    };
    let why = format!(
        "{} ({}): the fastest of {peers} that pass the quick conformance suite ({total} found{last}), {:.0} frames/s of 65,536 vertices",
        first.id(),
        first.name,
        best.frames_per_second
    );
    Ok((tried.into_iter().map(|(device, _)| device).collect(), why))
}

/// Runs the quick suite on a device, and measures its speed if it passes.
fn try_device(info: &DeviceInfo, progress: &dyn Progress) -> Result<Trial> {
    let outcome = match rhytid_backends::open(info) {
        Ok(device) => {
            let report = run_device(&device, Suite::Quick, |_, _, _| !progress.cancelled());
            if progress.cancelled() {
                return Err(Error::Cancelled);
            }
            let failed = report.outcomes.iter().filter(|outcome| !outcome.is_acceptable());
            let failed: Vec<String> = failed.map(|outcome| outcome.name.clone()).collect();
            if failed.is_empty() { measure(&device).map_err(|e| vec![e.to_string()]) } else { Err(failed) }
        }
        Err(error) => Err(vec![error.to_string()]),
    };
    let (failed, frames_per_second) = match outcome {
        Ok(speed) => (Vec::new(), speed),
        Err(failed) => (failed, 0.0),
    };
    Ok(Trial {
        backend: info.backend.to_owned(),
        name: info.name.clone(),
        driver: info.driver.clone(),
        failed,
        frames_per_second,
    })
}

/// Frames per second as `animate` needs them: evaluated in batches, positions and normals read back.
fn measure(device: &Device) -> Result<f64> {
    let case = timing_case();
    let built = case.build();
    let frames = built.handle_positions.len() / (3 * built.rig.handles.len());
    let mut animator = device.upload(&built.rig, case.options)?;
    let mut out = Vec::new();
    let mut best = f64::MAX;
    for _ in 0..2 {
        let start = Instant::now();
        animator.evaluate(&built.handle_positions)?;
        animator.read(Stage::Positions, &mut out)?;
        animator.read(Stage::Normals, &mut out)?;
        best = best.min(start.elapsed().as_secs_f64());
    }
    Ok(frames as f64 / best)
}

fn cache_file() -> Option<PathBuf> {
    let strategy = etcetera::choose_base_strategy().ok()?;
    Some(strategy.cache_dir().join("rhytid").join("devices.json"))
}

/// What makes outcomes of an older program worthless.
fn program() -> String {
    format!("{} {COMMIT}", env!("CARGO_PKG_VERSION"))
}

/// What is remembered of this program; a file that is not there or not readable is nothing.
fn read_cache(path: &Path) -> Cache {
    let memory: Option<Cache> =
        std::fs::read(path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok());
    let memory = memory.filter(|memory| memory.program == program());
    memory.unwrap_or_else(|| Cache { program: program(), devices: Vec::new() })
}

fn write_cache(path: &Path, memory: &Cache) -> Result<()> {
    let json = serde_json::to_vec_pretty(memory).map_err(|e| Error::Internal(e.to_string()))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
    let mut file = AtomicFile::create(path)?;
    file.write_all(&json).map_err(Error::io(path))?;
    file.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::DeviceKind;

    fn tried(name: &str, frames_per_second: f64, failed: &[&str]) -> (DeviceInfo, Trial) {
        let device = DeviceInfo {
            backend: "vulkan",
            index: 0,
            name: name.into(),
            driver: "1.0".into(),
            kind: DeviceKind::DiscreteGpu,
            memory_bytes: None,
            max_binding_bytes: None,
        };
        let tried = Trial {
            backend: "vulkan".into(),
            name: name.into(),
            driver: "1.0".into(),
            failed: failed.iter().map(|&name| name.into()).collect(),
            frames_per_second,
        };
        (device, tried)
    }

    #[test]
    fn the_fastest_that_passes_comes_first() {
        let all = vec![
            tried("slow", 10.0, &[]),
            tried("fast", 900.0, &[]),
            tried("wrong", 5000.0, &["normals/holes"]),
            tried("middling", 200.0, &[]),
        ];
        let (devices, why) = rank(all).unwrap();
        let names: Vec<&str> = devices.iter().map(|device| device.name.as_str()).collect();
        assert_eq!(names, ["fast", "middling", "slow"]);
        assert!(why.contains("fast") && why.contains("fastest of 3") && why.contains("4 found"), "{why}");
    }

    /// What a software driver shows as a GPU computes on the same cores as the CPU backend: which of them is faster today must
    /// not decide about the bits.
    #[test]
    fn software_drivers_come_after_the_cpu_backend_and_gpus() {
        let [mut pocl, mut lavapipe] = [tried("pocl", 900.0, &[]), tried("lavapipe", 950.0, &[])];
        pocl.0.kind = DeviceKind::Cpu;
        lavapipe.0.kind = DeviceKind::Cpu;
        let mut cpu = tried("processor", 800.0, &[]);
        (cpu.0.backend, cpu.0.kind) = ("cpu", DeviceKind::Cpu);
        let gpu = tried("gpu", 100.0, &[]);

        let (devices, why) = rank(vec![pocl.clone(), gpu, lavapipe.clone(), cpu]).unwrap();
        let names: Vec<&str> = devices.iter().map(|device| device.name.as_str()).collect();
        assert_eq!(names, ["processor", "gpu", "lavapipe", "pocl"]);
        assert!(
            why.contains("fastest of 2") && why.contains("4 found; software drivers come last: 2"),
            "{why}"
        );

        let (devices, why) = rank(vec![pocl, lavapipe]).unwrap();
        assert_eq!(devices[0].name, "lavapipe");
        assert!(why.contains("fastest of 2") && !why.contains("come last"), "{why}");
    }

    #[test]
    fn devices_that_all_fail_are_an_error_that_says_why() {
        let error = rank(vec![tried("wrong", 0.0, &["normals/holes"])]).unwrap_err().to_string();
        assert!(error.contains("normals/holes"), "{error}");
        assert!(rank(Vec::new()).unwrap_err().to_string().contains("no device was found"));
    }
}
