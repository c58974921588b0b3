//! Devices that draw: those of the backend wgpu, found from behind the guard.

use rhytid::report::Painter;
use rhytid::{Error, Result};
#[cfg(feature = "wgpu")]
use {
    crate::guard::guard,
    rhytid::core::{Backend, DeviceErrorKind, DeviceInfo, InputErrorKind},
    rhytid::devices::find_device,
    rhytid::devices::wgpu::Wgpu,
};

/// The device with the id `wanted`, or the first one if `wanted` is the backend's name.
///
/// # Errors
/// As [`find_device`]; [`Error::Input`] for a device that does not draw.
#[cfg(feature = "wgpu")]
pub(crate) fn device(wanted: &str) -> Result<DeviceInfo> {
    let info = find_device(wanted, guard()).map_err(|error| match error {
        Error::Device { kind: DeviceErrorKind::NotFound, device, .. } => Error::Device {
            kind: DeviceErrorKind::NotFound,
            device,
            message: "there is no device to draw with; `rhytid devices` lists those of the backend wgpu, \
                      which needs a driver for Vulkan, Metal, Direct3D 12 or OpenGL ES 3.1"
                .to_owned(),
        },
        other => other,
    })?;
    match info.backend == Wgpu::NAME {
        true => Ok(info),
        false => Err(Error::input(format!(
            "--draw-on {wanted}: expected a device of the backend wgpu, as `rhytid devices` lists them"
        ))
        .of_kind(InputErrorKind::UnknownName { name: wanted.to_owned() })),
    }
}

/// Lets `write` write a page with pictures, and returns whether it has them.
///
/// Without a device that draws, or if drawing fails, the page is written without pictures. A warning then
/// says that `what` is left out; `what` includes its verb.
///
/// # Errors
/// As `write`.
pub(crate) fn with_pictures(what: &str, write: impl Fn(Option<&Painter>) -> Result<()>) -> Result<bool> {
    let failed = match painter().and_then(|painter| write(Some(&painter))) {
        Err(Error::Device { message, .. }) => message,
        Err(Error::Input(error)) => error.sentence().to_owned(),
        done => return done.map(|()| true),
    };
    // If the page itself cannot be written, that is the error.
    write(None)?;
    log::warn!("{what} left out: {failed}");
    Ok(false)
}

#[cfg(feature = "wgpu")]
fn painter() -> Result<Painter> {
    let (device, queue) = Wgpu::open_to_draw(&device(Wgpu::NAME)?)?;
    Ok(Painter::new(&device, &queue))
}

#[cfg(not(feature = "wgpu"))]
fn painter() -> Result<Painter> {
    Err(Error::input(
        "this program was built without wgpu, which draws pictures; build it with the feature wgpu",
    ))
}
