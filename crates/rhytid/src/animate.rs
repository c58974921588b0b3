//! Playing of a take into a file.
use rhytid_core::{NoProgress, Progress, Result, Rig, Take, rig_file};
use rhytid_devices::{Guard, choose_devices};
use rhytid_export::{Options, Recipe, Written};
use rhytid_playback::{Layers, Performance};
use std::path::Path;

/// How a take is animated.
#[derive(Clone)]
pub struct AnimateOptions<'a> {
    /// The recipe of the frames: which of them, at which rate, with which channels. If it names no rig, the
    /// file names the given one.
    pub recipe: Recipe,
    /// Edits of the take, read for the rig.
    pub edits: Option<Layers>,
    /// A device such as `vulkan:0`; `auto` for the fastest one whose results agree with the reference.
    pub device: &'a str,
    /// Whether devices are tried in a child process, so that a crash of a driver does not end this process.
    pub guard: Guard,
    /// Options of the file: compressed, in few shapes, quantised.
    pub file: Options,
    /// The receiver of progress, which can cancel the work.
    pub progress: &'a dyn Progress,
}

impl Default for AnimateOptions<'_> {
    fn default() -> Self {
        Self {
            recipe: Recipe::default(),
            edits: None,
            device: "auto",
            guard: Guard::NONE,
            file: Options::default(),
            progress: &NoProgress,
        }
    }
}

/// Plays a take on a rig into the file `path`: USD (`.usd`, `.usda`, `.usdc`, `.usdz`), glTF (`.glb`,
/// `.gltf`) or a point cache (`.pc2`). If a device fails on the way, the next one takes over, and no frame is
/// lost. A failed export leaves no partial file.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if the take lacks a handle of the rig, if the format cannot carry
/// what the recipe asks for, or if the path has another extension. [`Error::Device`](crate::Error::Device) if
/// no device is left. [`Error::Io`](crate::Error::Io).
pub fn animate(
    rig: Rig,
    take: Take,
    path: impl AsRef<Path>,
    options: &AnimateOptions<'_>,
) -> Result<Written> {
    let progress = options.progress;
    let mut recipe = options.recipe.clone();
    if recipe.rig.is_empty() {
        recipe.rig = rig_file::hash_of(&rig)?;
    }
    let performance = Performance::new(recipe, rig, take, options.edits.clone())?;
    let devices = choose_devices(options.device, options.guard, progress)?.devices;
    let mut playback = performance.playback(&devices, progress)?;
    playback.export(&performance, path.as_ref(), &options.file, progress)
}
