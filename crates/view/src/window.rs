//! The window of the desktop.

use crate::app::ViewApp;
use eframe::egui;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use rhytid_backend_wgpu::Wgpu;
use rhytid_core::{DeviceErrorKind, DeviceInfo, Error, Result};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;

/// What a window begins with.
#[derive(Debug, Clone, Default)]
pub struct WindowOptions {
    /// A rig, and a take for it: read when the window is there.
    pub files: Vec<PathBuf>,
    /// Where to listen for live frames.
    pub listen: Option<SocketAddr>,
    /// The device to draw with, one of the backend wgpu; `None` for the one that wgpu prefers.
    pub draws: Option<DeviceInfo>,
    /// The devices that a frame can be evaluated on besides.
    pub devices: Vec<DeviceInfo>,
    /// That of them which it is evaluated on at first; `None` for the one that draws.
    pub device: Option<DeviceInfo>,
}

/// Shows a window until it is closed.
///
/// # Errors
/// [`Error::Device`] if there is no display, or none of its devices draws.
pub fn run(options: WindowOptions) -> Result<()> {
    let draws = options.draws.clone();
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.device_descriptor = Arc::new(Wgpu::device_descriptor);
    setup.native_adapter_selector = Some(Arc::new(move |adapters, surface| {
        let fits =
            |adapter: &&wgpu::Adapter| surface.is_none_or(|surface| adapter.is_surface_supported(surface));
        let is_wanted = |adapter: &&wgpu::Adapter| draws.as_ref().is_none_or(|info| Wgpu::is(adapter, info));
        let mut adapters: Vec<&wgpu::Adapter> = adapters.iter().filter(fits).filter(is_wanted).collect();
        adapters.sort_by_key(|adapter| Wgpu::rank(adapter));
        let first = adapters.first().map(|adapter| (*adapter).clone());
        first.ok_or_else(|| match &draws {
            Some(info) => format!("{} ({}) cannot draw into this window", info.id(), info.name),
            None => "no device can draw into this window".to_owned(),
        })
    }));
    let native = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("Rhytid")
            .with_app_id("rhytid")
            .with_inner_size([1200.0, 860.0])
            .with_min_inner_size([320.0, 320.0])
            .with_drag_and_drop(true),
        wgpu_options: WgpuConfiguration {
            wgpu_setup: WgpuSetup::CreateNew(setup),
            ..WgpuConfiguration::default()
        },
        ..eframe::NativeOptions::default()
    };
    let create: eframe::AppCreator<'_> = Box::new(move |context| {
        let mut app = ViewApp::new(context)?.with_devices(options.devices);
        app.device = options.device;
        app.open_paths(&options.files);
        if let Some(address) = options.listen {
            app.listen(address);
        }
        Ok(Box::new(app))
    });
    eframe::run_native("rhytid", native, create).map_err(|error| Error::Device {
        kind: DeviceErrorKind::Unsupported,
        device: "window".to_owned(),
        message: format!("it did not open: {error}; `rhytid render` draws without one, and needs no display"),
    })
}
