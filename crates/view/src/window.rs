//! The window of the desktop.

use crate::app::ViewApp;
use crate::live::Listen;
use crate::recent::Recent;
use eframe::egui;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use rhytid_backend_wgpu::Wgpu;
use rhytid_core::{DeviceErrorKind, DeviceInfo, Error, Result};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::Receiver;

/// The options of a window.
#[derive(Debug, Default)]
pub struct WindowOptions {
    /// A rig, and a take for it. They are read when the window is open.
    pub files: Vec<PathBuf>,
    /// Where to listen for live frames.
    pub listen: Option<Listen>,
    /// The device that draws, of the backend wgpu. `None` for the one that wgpu prefers.
    pub draws: Option<DeviceInfo>,
    /// Further devices that can evaluate a frame.
    pub devices: Vec<DeviceInfo>,
    /// The one of these that evaluates at first. `None` for the device that draws.
    pub device: Option<DeviceInfo>,
    /// A message on this channel closes the window.
    pub close: Option<Receiver<()>>,
}

/// Shows a window until it is closed.
///
/// # Errors
/// [`Error::Device`] if there is no display, or no device can draw to it.
pub fn run(options: WindowOptions) -> Result<()> {
    let draws = options.draws.clone();
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.device_descriptor = Arc::new(Wgpu::device_descriptor);
    setup.native_adapter_selector = Some(Arc::new(move |adapters, surface| {
        let is_wanted = |adapter: &&wgpu::Adapter| draws.as_ref().is_none_or(|info| Wgpu::is(adapter, info));
        let mut adapters: Vec<&wgpu::Adapter> = adapters.iter().filter(is_wanted).collect();
        adapters.sort_by_key(|adapter| Wgpu::rank(adapter));
        // Devices are asked one after the other, since some drivers end a program that asks them.
        let fits =
            |adapter: &&wgpu::Adapter| surface.is_none_or(|surface| adapter.is_surface_supported(surface));
        let first = adapters.into_iter().find(fits).cloned();
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
        let mut app = ViewApp::new(context)?.with_devices(options.devices).with_device(options.device);
        if let Some(file) = Recent::of_user() {
            app = app.with_recent_files(file);
        }
        app.open_paths(&options.files);
        if let Some(listen) = options.listen {
            app.listen_for(listen);
        }
        if let Some(close) = options.close {
            close_when(close, context.egui_ctx.clone());
        }
        Ok(Box::new(app))
    });
    eframe::run_native("rhytid", native, create).map_err(|error| Error::Device {
        kind: DeviceErrorKind::Unsupported,
        device: "window".to_owned(),
        message: format!("it did not open: {}", reason(&error)),
    })
}

/// Closes the window when a message is sent. The thread then ends. It also ends when all senders are gone.
fn close_when(sent: Receiver<()>, context: egui::Context) {
    std::thread::spawn(move || {
        if sent.recv().is_ok() {
            context.send_viewport_cmd_to(egui::ViewportId::ROOT, egui::ViewportCommand::Close);
            // The window may have woken before the command arrived.
            context.request_repaint_of(egui::ViewportId::ROOT);
        }
    });
}

/// The reason why there is no window. winit's own message names only lines of its source.
fn reason(error: &eframe::Error) -> String {
    if !matches!(error, eframe::Error::WinitEventLoop(_)) {
        return error.to_string();
    }
    let named = ["WAYLAND_DISPLAY", "DISPLAY"]
        .iter()
        .filter_map(|name| Some(format!("{name}={}", std::env::var(name).ok().filter(|at| !at.is_empty())?)))
        .collect::<Vec<_>>();
    match (&named[..], cfg!(target_os = "linux")) {
        ([], true) => "there is no display, as neither WAYLAND_DISPLAY nor DISPLAY names one".to_owned(),
        (named, true) => format!("the display does not answer ({})", named.join(", ")),
        _ => "the system has no display for this process".to_owned(),
    }
}
