//! An animator for a program that draws the face itself.
use rhytid_core::{Animator, Result, Rig, Session, UploadOptions};
use rhytid_devices::backends;

/// The device of an [`Animator`], and its number of frames at once.
#[derive(Debug, Clone, Copy)]
pub struct AnimatorOptions<'a> {
    /// A device such as `wgpu:0`. `None` for the first GPU, or for the CPU if there is none
    /// ([`backends::first`]).
    pub device: Option<&'a str>,
    /// The largest batch, and how the basis is kept.
    pub upload: UploadOptions,
}

impl Default for AnimatorOptions<'_> {
    fn default() -> Self {
        Self { device: None, upload: UploadOptions::frames(1) }
    }
}

/// Uploads a rig to a device. After that, only handle positions are sent to the device.
///
/// A host with a device of its own can pass it to a backend instead: see [`devices`](crate::devices).
///
/// # Errors
/// [`Error::Device`](crate::Error::Device) if there is no such device, or if the rig does not fit on it.
/// [`Error::Input`](crate::Error::Input) if the options do not fit the rig.
pub fn animator(rig: &Rig, options: &AnimatorOptions<'_>) -> Result<Animator<Box<dyn Session>>> {
    let device = match options.device {
        Some(id) => backends::named(id)?,
        None => backends::first()?,
    };
    backends::open(&device)?.upload(rig, options.upload)
}
