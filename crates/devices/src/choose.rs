//! The choice of a device: one by its id, or `auto`, the fastest that passes the quick conformance suite.
//!
//! A processor behind a GPU's API is not tried if the processor itself passes. Both do the same work on the
//! same cores about equally fast. So chance would choose between them, and between their different roundings.

use crate::backends;
use crate::guard::Guard;
use crate::trial::{Broken, Cache, Trial, cache_file, read_cache, try_guarded, write_cache};
use crate::{listing, manifests};
use rhytid_conformance::TIMED_VERTICES;
use rhytid_core::human;
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

/// Devices for evaluation. The first is to be used; the others are for the case that it fails.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// At least one.
    pub devices: Vec<DeviceInfo>,
    /// Why the first device was chosen. `None` if it was requested by its id.
    pub reason: Option<Reason>,
}

/// Why `auto` chose a device.
#[derive(Debug, Clone, PartialEq)]
pub struct Reason {
    /// The device and its speed: `cpu:0 (AMD EPYC), 364 frames/s at 65,536 vertices`.
    pub device: String,
    /// Sentences about the devices with which it was compared.
    pub details: String,
}

/// The device with the id `wanted`. For `auto`, the devices that pass the quick conformance suite, fastest
/// first. A device is tried once for each version of its driver and of this program. The result is kept in
/// the user's cache folder.
///
/// # Errors
/// As [`find_device`]. For `auto`, [`Error::Device`] if none passes, and [`Error::Cancelled`].
pub fn choose_devices(wanted: &str, guard: Guard, progress: &dyn Progress) -> Result<Choice> {
    if wanted == "auto" {
        return auto(guard, progress);
    }
    Ok(Choice { devices: vec![find_device(wanted, guard)?], reason: None })
}

/// Looks for every device of this machine again. All that `auto` remembers of failed devices and drivers is
/// forgotten.
pub fn devices(guard: Guard) -> backends::Found {
    if let Some(path) = cache_file() {
        let mut known = read_cache(&path);
        let before = known.clone();
        known.broken.clear();
        known.devices.retain(|trial| trial.failed.is_empty());
        // If the cache cannot be written, nothing was remembered either.
        let _ = if known == before { Ok(()) } else { write_cache(&path, &known) };
    }
    listing::devices_but(guard, &[])
}

/// Warns of backends whose driver fails. It is no error, since the others still work.
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
    // The processor comes first: if it passes, software drivers are not tried.
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
            log::warn!("the results of trying the devices could not be cached: {error}");
        }
    }
    rank(tried, untried, progress)
}

/// The devices of this machine. Backends that failed before with the same installed drivers are left out.
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
            let why = format!("{why} (so it was before; listing all devices tries it again)");
            found.failed.push((name, listing::failure(name, why)));
        }
    }
    found
}

/// The devices that passed, fastest first, with software drivers last. `untried` is the number of software
/// drivers that were not tried.
fn rank(mut tried: Vec<(DeviceInfo, Trial)>, untried: usize, progress: &dyn Progress) -> Result<Choice> {
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
    // Software drivers are compared with each other if there are no other devices.
    let compared = if software < tried.len() { tried.len() - software } else { software };
    let mut details = format!(
        "{} is the fastest of {compared} devices that pass the quick conformance suite. {total} devices were \
         found.",
        first.id()
    );
    if untried > 0 {
        details += &format!(" {untried} software drivers were not tried: they run on the processor too.");
    } else if software > 0 && software < tried.len() {
        details += &format!(" {software} software drivers come last.");
    }
    let device = format!(
        "{} ({}), {:.0} frames/s at {} vertices",
        first.id(),
        first.name,
        best.frames_per_second,
        human::count(TIMED_VERTICES)
    );
    let devices = tried.into_iter().map(|(device, _)| device).collect();
    Ok(Choice { devices, reason: Some(Reason { device, details }) })
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

    fn names(choice: &Choice) -> Vec<&str> {
        choice.devices.iter().map(|device| device.name.as_str()).collect()
    }

    #[test]
    fn the_fastest_that_passes_comes_first() {
        let all = vec![
            tried("slow", 10.0, &[]),
            tried("fast", 900.0, &[]),
            tried("wrong", 5000.0, &["normals/holes"]),
            tried("middling", 200.0, &[]),
        ];
        let choice = rank(all, 0, &NoProgress).unwrap();
        assert_eq!(names(&choice), ["fast", "middling", "slow"]);
        let Reason { device, details } = choice.reason.unwrap();
        assert!(device.ends_with("(fast), 900 frames/s at 65,536 vertices"), "{device}");
        assert!(
            details.contains("fastest of 3 devices") && details.contains("4 devices were found"),
            "{details}"
        );
    }

    /// A software driver that appears as a GPU computes on the same cores as the CPU backend. Which of them
    /// is faster by chance must not decide about the bits.
    #[test]
    fn software_drivers_come_after_the_cpu_backend_and_gpus() {
        let [mut pocl, mut lavapipe] = [tried("pocl", 900.0, &[]), tried("lavapipe", 950.0, &[])];
        pocl.0.kind = DeviceKind::Cpu;
        lavapipe.0.kind = DeviceKind::Cpu;
        let mut cpu = tried("processor", 800.0, &[]);
        (cpu.0.backend, cpu.0.kind) = ("cpu", DeviceKind::Cpu);
        let gpu = tried("gpu", 100.0, &[]);

        let choice = rank(vec![pocl.clone(), gpu, lavapipe.clone(), cpu], 0, &NoProgress).unwrap();
        assert_eq!(names(&choice), ["processor", "gpu", "lavapipe", "pocl"]);
        let details = choice.reason.unwrap().details;
        assert!(
            details.contains("fastest of 2") && details.ends_with("2 software drivers come last."),
            "{details}"
        );

        let choice = rank(vec![pocl, lavapipe], 0, &NoProgress).unwrap();
        assert_eq!(names(&choice), ["lavapipe", "pocl"]);
        let details = choice.reason.unwrap().details;
        assert!(details.contains("fastest of 2") && !details.contains("come last"), "{details}");
    }

    #[test]
    fn devices_that_all_fail_are_an_error_that_says_why() {
        let error =
            rank(vec![tried("wrong", 0.0, &["normals/holes"])], 0, &NoProgress).unwrap_err().to_string();
        assert!(error.contains("normals/holes"), "{error}");
        assert!(rank(Vec::new(), 0, &NoProgress).unwrap_err().to_string().contains("no device was found"));
    }
}
