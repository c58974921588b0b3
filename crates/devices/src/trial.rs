//! The trial of a device: whether it passes the quick conformance suite, and how fast it is. The result is
//! kept in the user's cache folder for each version of its driver and of this program.

use crate::guard::{Guard, Heartbeat, PATIENCE};
use crate::listing::message_of;
use etcetera::BaseStrategy;
use rhytid_conformance::{COMMIT, Suite, run_device, timing_case};
use rhytid_core::{AtomicFile, Device, DeviceInfo, Error, NoProgress, Progress, Result, Stage};
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The result of the trial of a device.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Trial {
    pub(crate) backend: String,
    pub(crate) name: String,
    pub(crate) driver: String,
    /// What failed: `kernel/case`, or the device's error without its name. Empty where everything passed.
    pub(crate) failed: Vec<String>,
    /// Frames per second of the conformance suite's timing case, with positions and normals read back. 0 if
    /// the trial failed.
    pub(crate) frames_per_second: f64,
}

impl Trial {
    /// From the frames per second of a device that passes, or from its failures.
    fn new(info: &DeviceInfo, outcome: Result<f64, Vec<String>>) -> Self {
        let (failed, frames_per_second) = match outcome {
            Ok(speed) => (Vec::new(), speed),
            Err(failed) => (failed, 0.0),
        };
        Self {
            backend: info.backend.to_owned(),
            name: info.name.clone(),
            driver: info.driver.clone(),
            failed,
            frames_per_second,
        }
    }

    pub(crate) fn is_of(&self, device: &DeviceInfo) -> bool {
        self.backend == device.backend && self.name == device.name && self.driver == device.driver
    }
}

/// A backend whose drivers could not even be listed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Broken {
    pub(crate) backend: String,
    /// As [`crate::manifests::drivers`] has them.
    pub(crate) installed: String,
    /// The reason.
    pub(crate) why: String,
}

/// The contents of the file in the cache folder.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Cache {
    program: String,
    pub(crate) devices: Vec<Trial>,
    #[serde(default)]
    pub(crate) broken: Vec<Broken>,
}

/// Tries a device behind `guard`, which the processor does not need. A driver that ends its process has
/// failed.
///
/// # Errors
/// [`Error::Cancelled`].
pub(crate) fn try_guarded(info: &DeviceInfo, guard: Guard, progress: &dyn Progress) -> Result<Trial> {
    if !guard.is_on() || info.backend == "cpu" {
        return try_device(info, || (), progress);
    }
    let answer = guard.ask(&["try", &info.id()], &info.id(), &[], progress, |_| PATIENCE);
    let unreadable = |error| Error::Internal(format!("the trial of {}: {error}", info.id()));
    match answer.and_then(|answer| serde_json::from_str(&answer).map_err(unreadable)) {
        Err(Error::Cancelled) => Err(Error::Cancelled),
        Err(error) => Ok(Trial::new(info, Err(vec![message_of(&error)]))),
        Ok(trial) => Ok(trial),
    }
}

/// Tries a device in a child, and sends the result to the parent.
///
/// # Errors
/// [`Error::Io`] if the parent no longer listens.
pub(crate) fn answer(info: &DeviceInfo) -> Result<()> {
    let trial = try_device(info, || Heartbeat.tell("trying"), &NoProgress)?;
    Heartbeat.answer(&serde_json::to_string(&trial).map_err(|error| Error::Internal(error.to_string()))?)
}

/// Runs the quick suite on a device, and measures its speed if it passes. `before` is called before each
/// case.
fn try_device(info: &DeviceInfo, before: impl Fn(), progress: &dyn Progress) -> Result<Trial> {
    let outcome = match crate::backends::open(info) {
        Ok(device) => {
            let report = run_device(&device, Suite::Quick, |_, _, _| {
                before();
                !progress.cancelled()
            });
            if progress.cancelled() {
                return Err(Error::Cancelled);
            }
            let failed = report.outcomes.iter().filter(|outcome| !outcome.is_acceptable());
            let failed: Vec<String> = failed.map(|outcome| outcome.name.clone()).collect();
            if failed.is_empty() {
                measure(&device).map_err(|error| vec![message_of(&error)])
            } else {
                Err(failed)
            }
        }
        Err(error) => Err(vec![message_of(&error)]),
    };
    Ok(Trial::new(info, outcome))
}

/// The frames per second of playback: frames are evaluated in batches, and positions and normals are read
/// back.
fn measure(device: &Device) -> Result<f64> {
    let case = timing_case();
    let built = case.build();
    let frames = built.handle_positions.len() / (3 * built.rig.handles().len());
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

pub(crate) fn cache_file() -> Option<PathBuf> {
    let strategy = etcetera::choose_base_strategy().ok()?;
    Some(strategy.cache_dir().join("rhytid").join("devices.json"))
}

/// The version of the program. Results of another version are not used, nor those of a build for debugging,
/// which is a hundred times slower.
fn program() -> String {
    let build = if cfg!(debug_assertions) { " debug" } else { "" };
    format!("{} {COMMIT}{build}", env!("CARGO_PKG_VERSION"))
}

/// The remembered results of this program. Without a readable file, there are none.
pub(crate) fn read_cache(path: &Path) -> Cache {
    // Opening a pipe would wait for its other end.
    let bytes = path.is_file().then(|| std::fs::read(path).ok()).flatten();
    let memory: Option<Cache> = bytes.and_then(|bytes| serde_json::from_slice(&bytes).ok());
    let memory = memory.filter(|memory| memory.program == program());
    memory.unwrap_or_else(|| Cache { program: program(), ..Cache::default() })
}

pub(crate) fn write_cache(path: &Path, memory: &Cache) -> Result<()> {
    let json = serde_json::to_vec_pretty(memory).map_err(|e| Error::Internal(e.to_string()))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
    let mut file = AtomicFile::create(path)?;
    file.write_all(&json).map_err(Error::io(path))?;
    file.finish()
}
