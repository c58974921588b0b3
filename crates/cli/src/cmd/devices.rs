//! `rhytid devices`

use crate::{args, backends, human, output};
use rhytid_core::{DeviceInfo, Result};
use serde::Serialize;

#[derive(Serialize)]
struct Listing {
    /// What `--device auto` takes; null where there is no device.
    auto: Option<String>,
    devices: Vec<Listed>,
}

#[derive(Serialize)]
struct Listed {
    id: String,
    #[serde(flatten)]
    info: DeviceInfo,
}

/// Lists the devices.
///
/// # Errors
/// As [`output::say`].
pub fn run(args: &args::Devices) -> Result<()> {
    let devices: Vec<Listed> =
        backends::devices().into_iter().map(|info| Listed { id: info.id(), info }).collect();
    let listing = Listing { auto: devices.first().map(|device| device.id.clone()), devices };
    if args.json {
        return output::json(&listing);
    }
    let heading = ["device", "name", "driver", "memory"].map(str::to_owned);
    let rows = listing.devices.iter().map(|device| {
        let memory = device.info.memory_bytes.map_or_else(|| "unknown".to_owned(), human::bytes);
        [device.id.clone(), device.info.name.clone(), device.info.driver.clone(), memory]
    });
    output::say(&output::table(&std::iter::once(heading).chain(rows).collect::<Vec<_>>()))?;
    match &listing.auto {
        Some(id) => output::say(&format!("--device auto takes {id}")),
        None => output::say("no device was found"),
    }
}
