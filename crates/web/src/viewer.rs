//! The viewer for its page.

use eframe::WebRunner;
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use js_sys::Uint8Array;
use rhytid_backend_wgpu::Wgpu;
use rhytid_view::ViewApp;
use serde_json::json;
use std::sync::Arc;
use wasm_bindgen::prelude::{JsError, JsValue, wasm_bindgen};
use web_sys::HtmlCanvasElement;

/// A viewer on a canvas.
#[wasm_bindgen]
pub struct Viewer {
    runner: WebRunner,
}

/// Shows the viewer on a canvas, with nothing open.
///
/// # Errors
/// The reason why the browser's device is refused, in one sentence.
#[wasm_bindgen]
pub async fn view(canvas: HtmlCanvasElement) -> Result<Viewer, JsValue> {
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    if cfg!(feature = "webgl") {
        setup.instance_descriptor.backends = wgpu::Backends::GL;
        setup.device_descriptor = Arc::new(of_webgl);
    } else {
        setup.instance_descriptor.backends = wgpu::Backends::BROWSER_WEBGPU;
        setup.device_descriptor = Arc::new(Wgpu::device_descriptor);
    }
    let options = eframe::WebOptions {
        wgpu_options: WgpuConfiguration {
            wgpu_setup: WgpuSetup::CreateNew(setup),
            ..WgpuConfiguration::default()
        },
        ..eframe::WebOptions::default()
    };
    let runner = WebRunner::new();
    let create: eframe::AppCreator<'static> = Box::new(|context| Ok(Box::new(ViewApp::new(context)?)));
    runner.start(canvas, options, create).await?;
    Ok(Viewer { runner })
}

/// What WebGL 2 has, and textures as large as the browser has them.
fn of_webgl(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    let limits = wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits());
    wgpu::DeviceDescriptor { label: Some("rhytid"), required_limits: limits, ..Default::default() }
}

#[wasm_bindgen]
impl Viewer {
    /// Opens a rig and takes for it. There are as many names as files, and a file's name tells what it is.
    pub fn open(&self, names: Vec<String>, files: Vec<Uint8Array>) {
        let files = names.into_iter().zip(files.iter().map(Uint8Array::to_vec));
        self.with(|app| app.inbox().put(files.map(|(name, bytes)| (name, Ok(bytes))).collect()));
    }

    /// Names the device that draws. The page knows more of WebGPU's adapter than the program.
    #[wasm_bindgen(js_name = nameDevice)]
    pub fn name_device(&self, name: String) {
        self.with(|app| app.name_device(name));
    }

    /// The state of the viewer, as JSON.
    ///
    /// `open` is the name of the rig or the mesh, or null. `mesh` says whether it is a mesh. The other keys
    /// are `vertices`, `frames`, `frame`, `playing`, `handles` (H × 3), `selected`, `vertex`, `pictures`,
    /// `note`, and `error`, which says whether the note is an error. `device` is what draws.
    #[wasm_bindgen(getter)]
    pub fn status(&self) -> String {
        let status = self.with(|app| {
            let document = app.document();
            let (note, error) =
                app.note().map_or((None, false), |(note, error)| (Some(note.to_owned()), error));
            json!({
                "open": document.map(|document| &document.name),
                "vertices": document.map(|document| document.rig.vertices()),
                "mesh": document.map(rhytid_view::Document::is_mesh),
                "frames": document.map(|document| document.transport.frames()),
                "frame": document.map(|document| document.transport.frame()),
                "playing": document.map(|document| document.transport.playing),
                "handles": document.map(|document| document.handles(true)),
                "selected": app.selected(),
                "vertex": app.vertex(),
                "pictures": app.times().map(|(_, pictures)| pictures),
                "note": note,
                "error": error,
                "device": app.device_name(),
            })
        });
        status.map_or_else(String::new, |status| status.to_string())
    }

    /// Shows a frame, and stops there. Beyond the last frame it is the last.
    pub fn seek(&self, frame: usize) {
        self.with(|app| app.seek(frame));
    }

    /// The place of a handle on the canvas, in CSS pixels from its upper left corner.
    pub fn handle(&self, handle: usize) -> Option<Vec<f32>> {
        self.with(|app| app.handle_in_window(handle))?.map(|at| at.to_vec())
    }

    /// V × 3 positions of the frame that is shown, read back from the device.
    ///
    /// # Errors
    /// If nothing is shown, or if the device fails.
    pub async fn positions(&self) -> Result<Vec<f32>, JsError> {
        let reading = self.with(|app| app.read_positions()).flatten();
        Ok(reading.ok_or_else(|| JsError::new("nothing is shown"))?.await?)
    }

    /// The picture of the face, as PNG, read from the texture that it was drawn into.
    ///
    /// # Errors
    /// As [`Viewer::positions`].
    pub async fn picture(&self) -> Result<Vec<u8>, JsError> {
        let reading = self.with(|app| app.read_picture()).flatten();
        Ok(reading.ok_or_else(|| JsError::new("nothing is shown"))?.await?.png()?)
    }
}

impl Viewer {
    /// Calls `what` with the app. `None` while the viewer is busy, which cannot be so in a call from the
    /// page.
    fn with<T>(&self, what: impl FnOnce(&mut ViewApp) -> T) -> Option<T> {
        self.runner.app_mut::<ViewApp>().map(|mut app| what(&mut app))
    }
}
