//! The functions that the page calls.
use crate::face::{Face, poses};
use crate::page::page;
use js_sys::Function;
use rhytid_backend_wgpu::{Wgpu, WgpuSession};
use rhytid_conformance::{AsyncDevice, AsyncSession, Report, Suite, run_device_async};
use rhytid_core::{Animator, DeviceInfo, HandleFrames, Result, Rig, Session, Stage, UploadOptions, rig_file};
use wasm_bindgen::prelude::{JsError, JsValue, wasm_bindgen};

/// The results for the page.
#[wasm_bindgen]
pub struct Findings {
    report: Report,
    face: Face,
}

#[wasm_bindgen]
impl Findings {
    /// Whether everything passed.
    #[wasm_bindgen(getter)]
    pub fn passed(&self) -> bool {
        self.report.passed() && self.face.passed()
    }

    /// A piece of HTML for the page.
    #[wasm_bindgen(getter)]
    pub fn html(&self) -> String {
        page(&self.report, &self.face)
    }

    /// `report.md` of the report, as [`Report`] has it.
    #[wasm_bindgen(getter)]
    pub fn markdown(&self) -> String {
        self.report.to_markdown()
    }

    /// `report.json` of the report, as [`Report`] has it.
    ///
    /// # Errors
    /// As [`Report::to_json`].
    #[wasm_bindgen(getter)]
    pub fn json(&self) -> std::result::Result<String, JsError> {
        Ok(self.report.to_json()?)
    }

    /// `junit.xml` of the report, as [`Report`] has it.
    ///
    /// # Errors
    /// As [`Report::to_junit`].
    #[wasm_bindgen(getter)]
    pub fn junit(&self) -> std::result::Result<String, JsError> {
        Ok(self.report.to_junit()?)
    }

    /// [`Face::off`].
    #[wasm_bindgen(getter, js_name = faceOff)]
    pub fn face_off(&self) -> f64 {
        self.face.off
    }

    /// [`Face::handle_positions`].
    #[wasm_bindgen(getter, js_name = handlePositions)]
    pub fn handle_positions(&self) -> Vec<f32> {
        self.face.handle_positions.clone()
    }

    /// [`Face::positions`].
    #[wasm_bindgen(getter)]
    pub fn positions(&self) -> Vec<f32> {
        self.face.positions.clone()
    }
}

/// Runs the quick suite on the browser's device, and then a face.
///
/// `device` and `system` are the names of the device and the browser in the report. `largest_binding`, in
/// bytes, makes the backend split arrays more than the device needs. `rig` is the content of a rig file.
/// `progress` is called with the number of cases that are done, and the number of all.
///
/// # Errors
/// The reason why the device or the rig's file is refused, in one sentence.
#[wasm_bindgen]
pub async fn conform(
    device: String,
    system: String,
    largest_binding: Option<f64>,
    rig: Vec<u8>,
    progress: Function,
) -> std::result::Result<Findings, JsError> {
    let rig = rig_file::decode(&rig, "the page's rig")?;
    let mut wgpu = Wgpu::request().await?;
    if let Some(bytes) = largest_binding {
        wgpu = wgpu.with_bindings_of_at_most(bytes as u64);
    }
    let device = Browser { info: DeviceInfo { name: device, ..wgpu.info() }, wgpu };
    let found = run_device_async(&device, Suite::Quick, |_, done, total| {
        // A fault of the page's callback is no reason to stop.
        let _ = progress.call2(&JsValue::NULL, &JsValue::from(done), &JsValue::from(total));
        true
    })
    .await;
    let poses = poses(&rig);
    let frames = poses.len() / (3 * rig.handles().len());
    let mut animator = Animator::new(&device.wgpu, &rig, UploadOptions::frames(frames))?;
    animator.evaluate(&poses)?;
    let mut positions = Vec::new();
    animator.session_mut().read_async(Stage::Positions, &mut positions).await?;
    let report = Report { system, ..Report::new(Suite::Quick, None, vec![found], Vec::new()) };
    Ok(Findings { report, face: Face::new(&rig, poses, positions) })
}

/// Shows panics in the browser's console, which are silent by default.
#[wasm_bindgen(start)]
pub fn start() {
    std::panic::set_hook(Box::new(|panic| web_sys::console::error_1(&panic.to_string().into())));
}

/// The browser's device, for the suite.
struct Browser {
    info: DeviceInfo,
    wgpu: Wgpu,
}

struct BrowserSession(Animator<WgpuSession>);

impl AsyncDevice for Browser {
    type Session = BrowserSession;

    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn upload(&self, rig: &Rig, options: UploadOptions) -> Result<BrowserSession> {
        Animator::new(&self.wgpu, rig, options).map(BrowserSession)
    }
}

impl AsyncSession for BrowserSession {
    fn evaluate(&mut self, frames: HandleFrames<'_>) -> Result<()> {
        self.0.session_mut().evaluate(frames)
    }

    async fn read(&mut self, stage: Stage, out: &mut Vec<f32>) -> Result<()> {
        self.0.session_mut().read_async(stage, out).await
    }
}
