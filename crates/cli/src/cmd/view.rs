//! `rhytid view`

use crate::guard::guard;
use crate::{args, drawing, inputs, interrupt, limits};
use rhytid::core::Backend;
use rhytid::devices::wgpu::Wgpu;
use rhytid::formats::{FileKind, Reach};
use rhytid::view::{Listen, WindowOptions};
use rhytid::{DeviceErrorKind, Error, Result};

/// Shows a window until it is closed.
///
/// # Errors
/// As [`rhytid::view::run`]. A missing file or one of another kind is reported here. Faults in a file are
/// shown in the window.
pub(super) fn run(args: &args::View) -> Result<()> {
    if let Some(rig) = &args.rig {
        let kinds = [FileKind::Rig, FileKind::Mesh, FileKind::Gltf, FileKind::Usd];
        inputs::expect(rig, &kinds, "rhytid view RIG [TAKE]")?;
    }
    if let (Some(rig), Some(take)) = (&args.rig, &args.take) {
        inputs::rig_and_take(rig, take, "rhytid view RIG TAKE")?;
    }
    let files = || args.rig.iter().chain(&args.take).chain(&args.edit).chain(&args.numbers);
    for file in files() {
        std::fs::metadata(file).map_err(Error::io(file))?;
    }
    let named = args.device.as_deref().map(inputs::named_device).transpose()?.flatten();
    let evaluates = named.as_ref().filter(|device| device.backend == Wgpu::NAME);
    let draws = match (&args.draw_on, evaluates) {
        (Some(wanted), _) => Some(drawing::device(wanted)?),
        (None, evaluates) => evaluates.cloned(),
    };
    // Frames are evaluated on the device that draws, unless it is a software driver, which the processor
    // outdoes. Without a name the window takes the first device that draws into it; GPUs come first.
    let likely = draws.clone().map_or_else(|| drawing::device(Wgpu::NAME), Ok)?;
    let device = match named {
        None if likely.is_software_driver() => Some(inputs::processor()?),
        named => named.filter(|named| draws.as_ref() != Some(named)),
    };
    let mut devices = rhytid::devices::devices(guard()).devices;
    devices.retain(|device| draws.as_ref() != Some(device));
    let files = files().cloned().collect();
    let (sender, close) = std::sync::mpsc::channel();
    interrupt::first_does(move || {
        // The receiver may be closed already.
        let _ = sender.send(());
    });
    let listen = args.listen.map(|address| {
        Ok::<_, Error>(Listen {
            address,
            pattern: args.sender.address.clone().unwrap_or_default(),
            world: args
                .sender
                .clean_up(args.setup.as_deref(), Reach::Below)?
                .map(|clean_up| clean_up.settings),
        })
    });
    let listen = listen.transpose()?;
    let options = WindowOptions { files, listen, draws, devices, device, close: Some(close) };
    let closed = limits::on_main_thread(|| rhytid::view::run(options));
    let closed = closed.unwrap_or_else(|| Err(Error::Internal("the window ended without a result".into())));
    closed.map_err(|error| match error {
        Error::Device { kind: kind @ DeviceErrorKind::Unsupported, device, message } => {
            let message = format!("{message}; `rhytid render` draws without one, and needs no display");
            Error::Device { kind, device, message }
        }
        other => other,
    })
}
