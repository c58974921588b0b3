//! What the package's JavaScript calls.
//!
//! Numbers for each frame stay in WebAssembly's memory: a function returns their address, and JavaScript
//! makes a view of them.
use crate::{DeviceInput, DevicePlan, Face, Track, basis_named, kind_of, missing_named, stage_named};
use js_sys::Error as JsError;
use rhytid_core::plan::PlanLimits;
use rhytid_live::Stream;
use serde_json::json;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use wasm_bindgen::prelude::wasm_bindgen;

type Result<T> = std::result::Result<T, JsError>;

/// The error for JavaScript: its message is the sentence, and its name the kind.
fn error(error: rhytid_core::Error) -> JsError {
    let converted = JsError::new(&error.to_string());
    converted.set_name(&kind_of(&error));
    converted
}

/// Shows panics in the browser's console, which are silent by default.
#[wasm_bindgen(start)]
pub fn start() {
    std::panic::set_hook(Box::new(|panic| web_sys::console::error_1(&panic.to_string().into())));
}

/// [`Face`] for JavaScript.
#[wasm_bindgen]
pub struct WasmFace(Face);

#[wasm_bindgen]
impl WasmFace {
    /// [`Face::open`]; `basis` is the name of a storage.
    #[wasm_bindgen(constructor)]
    pub fn new(bytes: Vec<u8>, name: &str, basis: &str) -> Result<WasmFace> {
        let basis = basis_named(basis).map_err(error)?;
        Face::open(&bytes, name, basis).map(WasmFace).map_err(error)
    }

    /// [`Face::facts`].
    pub fn facts(&self) -> String {
        self.0.facts().to_string()
    }

    /// [`Face::rest`].
    pub fn rest(&self) -> Vec<f32> {
        self.0.rest()
    }

    /// The vertices of the triangles: see [`crate::Drawing::triangles`].
    pub fn indices(&self) -> Vec<u32> {
        self.0.drawing().triangles.as_flattened().to_vec()
    }

    /// The texture coordinates: see [`crate::Drawing::uvs`].
    pub fn uvs(&self) -> Option<Vec<f32>> {
        self.0.drawing().uvs.as_ref().map(|uvs| uvs.as_flattened().to_vec())
    }

    /// The file of a texture.
    pub fn texture(&self, texture: usize) -> Option<Vec<u8>> {
        let materials = self.0.rig().surface().materials.as_ref()?;
        materials.textures.get(texture).map(|texture| texture.bytes.to_vec())
    }

    /// [`Face::check`].
    pub fn check(&self, handles: &[f32]) -> Result<()> {
        self.0.check(handles).map_err(error)
    }

    /// [`Face::evaluate`].
    pub fn evaluate(&mut self, handles: &[f32]) -> Result<()> {
        self.0.evaluate(handles).map_err(error)
    }

    /// The address of [`Face::positions`].
    pub fn positions(&self) -> *const f32 {
        self.0.positions().as_ptr()
    }

    /// The address of [`Face::normals`].
    pub fn normals(&self) -> *const f32 {
        self.0.normals().as_ptr()
    }

    /// [`Face::read`]; `stage` is a stage's name.
    pub fn read(&mut self, stage: &str) -> Result<Vec<f32>> {
        stage_named(stage).and_then(|stage| self.0.read(stage)).map_err(error)
    }

    /// [`DevicePlan::new`].
    pub fn plan(&self, max_binding_bytes: f64, max_workgroups: u32) -> Result<WasmPlan> {
        let limits = PlanLimits { max_binding_bytes: max_binding_bytes as u64, max_workgroups };
        let plan = DevicePlan::new(&self.0, limits).map_err(error)?;
        Ok(WasmPlan { plan, inputs: Vec::new() })
    }
}

/// [`DevicePlan`] for JavaScript.
#[wasm_bindgen]
pub struct WasmPlan {
    plan: DevicePlan,
    inputs: Vec<DeviceInput>,
}

#[wasm_bindgen]
impl WasmPlan {
    /// [`DevicePlan::facts`].
    pub fn facts(&self) -> String {
        self.plan.facts().to_string()
    }

    /// [`DevicePlan::contents`].
    pub fn contents(&self, face: &WasmFace, buffer: usize) -> Vec<u8> {
        self.plan.contents(&face.0, buffer).into_owned()
    }

    /// [`DevicePlan::inputs`]. The inputs are in memory until the next call. Of each there are three numbers:
    /// the index of its buffer, its address and its length.
    pub fn inputs(&mut self, handles: &[f32]) -> Result<Vec<u32>> {
        self.inputs = self.plan.inputs(handles).map_err(error)?;
        let place = |DeviceInput { buffer, numbers }: &DeviceInput| {
            [*buffer as u32, numbers.as_ptr() as u32, numbers.len() as u32]
        };
        Ok(self.inputs.iter().flat_map(place).collect())
    }
}

/// [`Track`] for JavaScript.
#[wasm_bindgen]
pub struct WasmTrack(Track);

#[wasm_bindgen]
impl WasmTrack {
    /// [`Track::open`]; `missing` is the name of a policy.
    #[wasm_bindgen(constructor)]
    pub fn new(bytes: Vec<u8>, name: &str, face: &WasmFace, missing: &str) -> Result<WasmTrack> {
        let missing = missing_named(missing).map_err(error)?;
        Track::open(&bytes, name, &face.0, missing).map(WasmTrack).map_err(error)
    }

    /// [`Track::facts`].
    pub fn facts(&self) -> String {
        self.0.facts().to_string()
    }

    /// The address of [`Track::at`].
    pub fn at(&mut self, seconds: f64) -> *const f32 {
        self.0.at(seconds).as_ptr()
    }

    /// [`Track::head_at`].
    #[wasm_bindgen(js_name = headAt)]
    pub fn head_at(&self, seconds: f64) -> Option<Vec<f64>> {
        self.0.head_at(seconds).map(|head| head.numbers.to_vec())
    }
}

/// A WebSocket has one sender, and the stream asks for its address.
const SENDER: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 0);

/// [`Stream`] for JavaScript.
#[wasm_bindgen]
pub struct WasmStream(Stream);

#[wasm_bindgen]
impl WasmStream {
    /// A stream of a face's handles.
    #[wasm_bindgen(constructor)]
    pub fn new(face: &WasmFace) -> WasmStream {
        let handles = face.0.rig().handles();
        WasmStream(Stream::new(&handles.labels, &handles.rest))
    }

    /// [`Stream::accept`].
    pub fn accept(&mut self, datagram: &[u8], arrived: f64) -> bool {
        self.0.accept(datagram, SENDER, arrived)
    }

    /// [`Stream::close`].
    pub fn close(&mut self, now: f64) -> bool {
        self.0.close(now)
    }

    /// The address of the newest frame's H×3 positions. 0 before the first frame.
    pub fn positions(&self) -> *const f32 {
        self.0.newest().map_or(std::ptr::null(), |frame| frame.positions.as_ptr().cast())
    }

    /// The state as JSON: `counts`, `frame` (the newest one's `number`, `time`, `latency` and `confidence`,
    /// or null) and `warnings`.
    pub fn facts(&self) -> String {
        let counts = self.0.counts();
        let words = [self.0.other_messages(), self.0.other_labels()];
        let mut warnings: Vec<String> =
            self.0.warnings().iter().cloned().chain(words.into_iter().flatten()).collect();
        if let (Some(why), true) = (self.0.why_bad(), 10 * counts.bad > counts.frames) {
            warnings.push(format!("{} of the messages are bad; the last one {why}", counts.bad));
        }
        let frame = self.0.newest().map(|frame| {
            json!({
                "number": frame.number,
                "time": frame.time,
                "latency": frame.latency,
                "confidence": frame.confidence,
            })
        });
        json!({
            "counts": {
                "frames": counts.frames,
                "late": counts.late,
                "lost": counts.lost,
                "bad": counts.bad,
                "other": counts.other,
            },
            "frame": frame,
            "warnings": warnings,
        })
        .to_string()
    }
}
