//! `rhytid devices`

use crate::guard::guard;
use crate::{args, output};
use rhytid::Result;
use rhytid::core::human;
use rhytid::core::{DeviceInfo, DeviceKind};
use rhytid::devices::backends::Missing;
use serde::Serialize;

#[derive(Serialize)]
struct Listing {
    devices: Vec<Listed>,
    left_out: Vec<Missing>,
}

#[derive(Serialize)]
struct Listed {
    id: String,
    #[serde(flatten)]
    info: DeviceInfo,
    software_driver: bool,
}

/// Lists the devices, and the backends that have none.
///
/// # Errors
/// As [`output::say`].
pub(super) fn run(args: &args::Devices) -> Result<()> {
    let listing = listing();
    if args.json.wanted {
        return output::json(&listing);
    }
    let heading = ["device", "name", "kind", "driver", "memory", "largest array"].map(str::to_owned);
    let rows = listing.devices.iter().map(|device| {
        let bytes = |n: Option<u64>, none: &str| n.map_or_else(|| none.to_owned(), human::bytes);
        [
            device.id.clone(),
            device.info.name.clone(),
            kind(device).to_owned(),
            device.info.driver.clone(),
            bytes(device.info.memory_bytes, "unknown"),
            bytes(device.info.max_binding_bytes, "no limit"),
        ]
    });
    output::say(&output::table(&std::iter::once(heading).chain(rows).collect::<Vec<_>>()))?;
    for Missing { backend, why } in &listing.left_out {
        output::say(&format!("no {backend}: {why}"))?;
    }
    Ok(())
}

fn listing() -> Listing {
    let found = rhytid::devices::devices(guard());
    let left_out = found.missing();
    let devices = found.devices.into_iter().map(|info| Listed {
        id: info.id(),
        software_driver: info.is_software_driver(),
        info,
    });
    Listing { devices: devices.collect(), left_out }
}

fn kind(device: &Listed) -> &'static str {
    match device.info.kind {
        DeviceKind::Cpu if device.software_driver => "software driver",
        DeviceKind::Cpu => "processor",
        DeviceKind::IntegratedGpu => "integrated GPU",
        DeviceKind::DiscreteGpu => "GPU",
        DeviceKind::VirtualGpu => "virtual GPU",
        _ => "unknown",
    }
}
