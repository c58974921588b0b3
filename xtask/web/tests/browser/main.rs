//! The pages in a browser: Chromium, whose WebGPU runs on SwiftShader, opens what `cargo xtask web` builds
//! from a server on this machine. `player` does the same with what `cargo xtask player` builds.
mod conformance;
mod files;
mod pages;
mod player;
mod touch;
mod viewer;

use flate2::read::GzDecoder;
use rhytid_core::{Rig, Take, rig_file};
use rhytid_formats::take::{self, Missing};
use rhytid_test_support::root;
use serde_json::{Value, json};
use std::io::Read;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use xtask_web::{Server, Size, Warnings, build};

/// The folder, its files, and the address of its server.
struct Pages {
    folder: PathBuf,
    files: Vec<Size>,
    address: SocketAddr,
}

/// Builds and serves the pages, once.
fn pages() -> &'static Pages {
    static PAGES: OnceLock<Pages> = OnceLock::new();
    PAGES.get_or_init(|| {
        let folder = root().join("target/pages");
        let files = build(&folder, Warnings::Refuse).unwrap();
        let server = Server::new((Ipv4Addr::LOCALHOST, 0).into(), &folder).unwrap();
        let address = server.address().unwrap();
        std::thread::spawn(move || server.run());
        Pages { folder, files, address }
    })
}

/// The rig and the take that lie beside the pages.
fn demo() -> &'static (Rig, Take) {
    static DEMO: OnceLock<(Rig, Take)> = OnceLock::new();
    DEMO.get_or_init(|| {
        let unpacked = |name: &str| {
            let mut bytes = Vec::new();
            let file = std::fs::File::open(pages().folder.join(name)).unwrap();
            GzDecoder::new(file).read_to_end(&mut bytes).unwrap();
            bytes
        };
        let rig = rig_file::decode(&unpacked("demo.safetensors.gz"), "demo").unwrap();
        let take =
            take::decode(&unpacked("demo.csv.gz"), "demo", Some(&rig.handles().labels), Missing::Error)
                .unwrap();
        (rig, take)
    })
}

/// The condition that the page has reported its end.
const ENDED: &str = "window.rhytid && window.rhytid.state !== 'running'";

/// The change that makes a browser one without WebGPU.
const NO_WEBGPU: &str = "Object.defineProperty(Navigator.prototype, 'gpu', { value: undefined });";

/// The change that takes away every context of canvases, WebGL 2 among them.
const NO_WEBGL: &str = "HTMLCanvasElement.prototype.getContext = () => null;";

/// A page, the changes to the browser before it, and the queries after it.
fn visit(page: &str, before: &str, until: &str, evaluate: &[(&str, &str)]) -> Value {
    let evaluate: serde_json::Map<String, Value> =
        evaluate.iter().map(|(name, expression)| ((*name).to_owned(), json!(expression))).collect();
    let url = format!("http://{}/{page}", pages().address);
    json!({ "url": url, "before": before, "until": until, "evaluate": evaluate })
}

/// Opens a page in a Chromium of its own.
fn visited(visit: Value) -> Value {
    visited_with_downloads(visit, tempfile::tempdir().unwrap().path())
}

/// As [`visited`]. Downloads of the page are saved in `downloads`.
fn visited_with_downloads(visit: Value, downloads: &Path) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let job = folder.path().join("job.json");
    std::fs::write(&job, json!({ "visits": [visit], "downloads": downloads }).to_string()).unwrap();
    let driver = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/chromium.mjs");
    let output = Command::new("node").arg(driver).arg(&job).output();
    let output = output.unwrap_or_else(|e| panic!("node does not start ({e}); run `cargo xtask setup`"));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice::<Value>(&output.stdout).unwrap()[0].take()
}

/// Everything that the page tells programs; of the face only its error.
const RESULT: [(&str, &str); 4] = [
    ("state", "rhytid.state"),
    ("message", "rhytid.message"),
    ("report", "rhytid.report"),
    ("off", "rhytid.off"),
];

fn floats(numbers: &Value) -> Vec<f32> {
    numbers.as_array().unwrap().iter().map(|x| x.as_f64().unwrap() as f32).collect()
}
