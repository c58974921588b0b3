//! The choice of a device: one by its id, or `auto`, the fastest that passes the quick conformance suite.
//!
//! A processor behind a GPU's API is not even tried where the processor itself passes: the two do the same work on the same
//! cores about as fast, so that chance would choose between them, and with them between two roundings.

use crate::backends;
use crate::guard::Guard;
use crate::trial::{Broken, Cache, Trial, cache_file, read_cache, try_guarded, write_cache};
use crate::{listing, manifests};
use rhytid_core::{DeviceErrorKind, DeviceInfo, Error, NoProgress, Progress, Remedy, Result, Warning};

/// The device with this id, or the first of a backend that is named alone.
///
/// # Errors
/// [`Error::Device`] lists those present: a device asked for and absent is never replaced by another.
pub fn find_device(id: &str, guard: Guard) -> Result<DeviceInfo> {
    let backend = id.split(':').next().unwrap_or_default();
    if let Some(found) = listing::list(backend, guard) {
        let found = found.map_err(|error| Error::Device {
            kind: DeviceErrorKind::Driver,
            device: id.to_owned(),
            message: listing::message_of(&error),
        })?;
        if let Some(device) = found.into_iter().find(|device| device.id() == id || device.backend == id) {
            return Ok(device);
        }
    }
    let found = listing::devices_but(guard, &[]);
    warn(&found, &NoProgress);
    Err(backends::absent(id, &found.devices))
}

/// Devices to evaluate on, the one to take first; those behind it are for when it fails.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// At least one.
    pub devices: Vec<DeviceInfo>,
    /// Why the first is the first, as a phrase that begins with its id; `None` where it was asked for by its id.
    pub reason: Option<String>,
}

/// The device with the id `wanted`; for `auto` those that pass the quick conformance suite, fastest first. A device is tried once
/// for each version of its driver and of this program; the outcome is kept in the user's cache folder.
///
/// # Errors
/// As [`find_device`]; for `auto` [`Error::Device`] if none passes, and [`Error::Cancelled`].
pub fn choose_devices(wanted: &str, guard: Guard, progress: &dyn Progress) -> Result<Choice> {
    if wanted == "auto" {
        return auto(guard, progress);
    }
    Ok(Choice { devices: vec![find_device(wanted, guard)?], reason: None })
}

/// Every device here, looked at anew: what `auto` remembers of devices and drivers that failed is forgotten.
pub fn devices(guard: Guard) -> backends::Found {
    if let Some(path) = cache_file() {
        let mut known = read_cache(&path);
        let before = known.clone();
        known.broken.clear();
        known.devices.retain(|trial| trial.failed.is_empty());
        // Where it cannot be forgotten, it could not have been remembered.
        let _ = if known == before { Ok(()) } else { write_cache(&path, &known) };
    }
    listing::devices_but(guard, &[])
}

/// A backend whose driver fails is a warning, since the others still work.
fn warn(found: &backends::Found, progress: &dyn Progress) {
    for (backend, error) in &found.failed {
        let warning = Warning::from(format!("the backend {backend} is left out: {error}"));
        progress.warn(&warning.with_remedies(&[Remedy::ListDevices]));
    }
}

/// The devices that pass the quick suite, fastest first.
fn auto(guard: Guard, progress: &dyn Progress) -> Result<Choice> {
    let cache = cache_file();
    let mut known = cache.as_deref().map(read_cache).unwrap_or_default();
    let before = known.clone();
    let mut found = remembering(&mut known, guard);
    warn(&found, progress);
    // The processor first: where it passes, software drivers are not tried.
    found.devices.sort_by_key(|device| (device.is_software_driver(), device.backend != "cpu"));
    let (total, mut tried) = (found.devices.len(), Vec::<(DeviceInfo, Trial)>::new());
    let mut untried = 0;
    for (i, device) in found.devices.into_iter().enumerate() {
        if device.is_software_driver() && tried.iter().any(|(_, trial)| trial.failed.is_empty()) {
            untried += 1;
            continue;
        }
        let trial = match known.devices.iter().find(|tried| tried.is_of(&device)) {
            Some(trial) => trial.clone(),
            None => {
                progress.report("try the devices", i as u64, total as u64);
                let trial = try_guarded(&device, guard, progress)?;
                known.devices.push(trial.clone());
                trial
            }
        };
        tried.push((device, trial));
    }
    if known != before {
        progress.report("try the devices", total as u64, total as u64);
        if let Some(path) = &cache
            && let Err(error) = write_cache(path, &known)
        {
            log::warn!("what was found out about the devices is not cached: {error}");
        }
    }
    let (devices, reason) = rank(tried, untried, progress)?;
    Ok(Choice { devices, reason: Some(reason) })
}

/// The devices that are here; what failed before with the drivers that are installed now is not looked at again.
fn remembering(known: &mut Cache, guard: Guard) -> backends::Found {
    let installed = manifests::installed();
    known.broken.retain(|broken| broken.installed == installed);
    let broken: Vec<String> = known.broken.iter().map(|broken| broken.backend.clone()).collect();
    let mut found = listing::devices_but(guard, &broken);
    for (backend, error) in &found.failed {
        let why = listing::message_of(error);
        known.broken.push(Broken { backend: (*backend).to_owned(), installed: installed.clone(), why });
    }
    for Broken { backend, why, .. } in known.broken.iter().filter(|known| broken.contains(&known.backend)) {
        if let Some(&name) = backends::names().iter().find(|name| *name == backend) {
            let why = format!("{why} (so it was before; whoever lists all devices looks again)");
            found.failed.push((name, listing::failure(name, why)));
        }
    }
    found
}

/// Fastest first, without those that failed and with software drivers last, and a sentence that says why the first is the first;
/// `untried` of them were not looked at.
fn rank(
    mut tried: Vec<(DeviceInfo, Trial)>,
    untried: usize,
    progress: &dyn Progress,
) -> Result<(Vec<DeviceInfo>, String)> {
    let total = tried.len() + untried;
    let failed: Vec<String> = tried
        .iter()
        .filter(|(_, tried)| !tried.failed.is_empty())
        .map(|(device, tried)| format!("{} fails: {}", device.id(), tried.failed.join(", ")))
        .collect();
    for sentence in &failed {
        let warning = Warning::from(format!("auto leaves a device out: {sentence}"));
        progress.warn(&warning.with_remedies(&[Remedy::Conform]));
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
    let last = if untried > 0 {
        format!("; {untried} behind which is the processor too are not tried")
    } else {
        last
    };
    let why = format!(
        "{} ({}): the fastest of {peers} that pass the quick conformance suite ({total} found{last}), {:.0} frames/s of 65,536 vertices",
        first.id(),
        first.name,
        best.frames_per_second
    );
    Ok((tried.into_iter().map(|(device, _)| device).collect(), why))
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
        let (devices, why) = rank(all, 0, &NoProgress).unwrap();
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

        let (devices, why) = rank(vec![pocl.clone(), gpu, lavapipe.clone(), cpu], 0, &NoProgress).unwrap();
        let names: Vec<&str> = devices.iter().map(|device| device.name.as_str()).collect();
        assert_eq!(names, ["processor", "gpu", "lavapipe", "pocl"]);
        assert!(
            why.contains("fastest of 2") && why.contains("4 found; software drivers come last: 2"),
            "{why}"
        );

        let (devices, why) = rank(vec![pocl, lavapipe], 0, &NoProgress).unwrap();
        assert_eq!(devices[0].name, "lavapipe");
        assert!(why.contains("fastest of 2") && !why.contains("come last"), "{why}");
    }

    #[test]
    fn devices_that_all_fail_are_an_error_that_says_why() {
        let error =
            rank(vec![tried("wrong", 0.0, &["normals/holes"])], 0, &NoProgress).unwrap_err().to_string();
        assert!(error.contains("normals/holes"), "{error}");
        assert!(rank(Vec::new(), 0, &NoProgress).unwrap_err().to_string().contains("no device was found"));
    }
}
