//! The npm package `@rhytid/player` with three.js in a browser.
mod faces;
mod limits;
mod live;
mod package;
mod pictures;
mod playing;
mod positions;

use super::{floats, visited};
use faces::Files;
use rhytid_core::{Rig, Stage};
use rhytid_test_support::root;
use serde_json::{Value, json};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use xtask_web::{Server, Size, Warnings, build_player};

/// The package's files, and a server of a page that uses them.
struct Package {
    folder: PathBuf,
    files: Vec<Size>,
    address: SocketAddr,
    faces: Files,
}

/// three.js as it is installed.
fn three() -> PathBuf {
    root().join("target/node/node_modules/three")
}

/// Builds the package, and serves it with three.js and the files of the tests, once.
fn package() -> &'static Package {
    static PACKAGE: OnceLock<Package> = OnceLock::new();
    PACKAGE.get_or_init(|| {
        let folder = root().join("target/player");
        let files = build_player(&folder, Warnings::Refuse).unwrap();
        let pages = root().join("target/player-pages");
        std::fs::create_dir_all(&pages).unwrap();
        let copy = |from: &Path| {
            std::fs::copy(from, pages.join(from.file_name().unwrap()))
                .unwrap_or_else(|e| panic!("{} ({e}); run `cargo xtask setup`", from.display()))
        };
        for file in files.iter().filter(|file| file.name.ends_with(".js") || file.name.ends_with(".wasm")) {
            copy(&folder.join(&file.name));
        }
        for name in ["webgpu", "core", "tsl", "module"] {
            copy(&three().join(format!("build/three.{name}.js")));
        }
        copy(&three().join("examples/jsm/controls/OrbitControls.js"));
        let write = |name: &str, text: &str| std::fs::write(pages.join(name), text).unwrap();
        write("page.js", include_str!("page.js"));
        for (name, three) in [("gpu.html", "three.webgpu.js"), ("gl.html", "three.module.js")] {
            write(name, &include_str!("page.html").replace("THREE", three));
        }
        write("example.html", &package::example());
        let faces = Files::write(&pages);
        let server = Server::new((Ipv4Addr::LOCALHOST, 0).into(), &pages).unwrap();
        let address = server.address().unwrap();
        std::thread::spawn(move || server.run());
        Package { folder, files, address, faces }
    })
}

/// Opens a page, and evaluates the body of an asynchronous function there. Nothing may go wrong, and there
/// may be no warning.
fn run(page: &str, body: &str) -> Value {
    ran(page, body, json!({}))
}

/// As [`run`], with more for the visit, such as a picture and its width.
fn ran(page: &str, body: &str, more: Value) -> Value {
    let (found, said) = heard(page, body, more);
    assert_eq!(said, json!([]), "{page}");
    found
}

/// As [`ran`], with the warnings and errors that the page has printed.
fn heard(page: &str, body: &str, more: Value) -> (Value, Value) {
    let mut visited = visited(visit_of(page, body, more));
    let mut take = |name: &str| visited["found"][name].take();
    (take("found"), take("said"))
}

fn visit_of(page: &str, body: &str, more: Value) -> Value {
    let mut visit = json!({
        "url": format!("http://{}/{page}", package().address),
        "before": "",
        "until": "window.ready",
        "steps": [{ "evaluate": { "found": format!("(async () => {{ {body} }})()") } }],
        "evaluate": { "said": "window.said" },
    });
    for (name, value) in more.as_object().into_iter().flatten() {
        visit[name] = value.clone();
    }
    visit
}

/// What the processor computes of `rig` for one frame of handle positions: all stages.
fn expected(rig: &Rig, basis: rhytid_core::BasisStorage, handles: &[f32]) -> Vec<Vec<f32>> {
    use rhytid_backend_cpu::Cpu;
    use rhytid_core::{Animator, UploadOptions};
    let options = UploadOptions { max_frames: 1, basis };
    let mut animator = Animator::new(&Cpu, rig, options).unwrap();
    animator.evaluate(handles).unwrap();
    let read = |stage| {
        let mut out = Vec::new();
        animator.read(stage, &mut out).unwrap();
        out
    };
    Stage::ALL.map(read).into()
}

/// How many mesh units the face is high.
fn height(rig: &Rig) -> f32 {
    let of_axis = rig.surface().rest.iter().map(|p| p[1]);
    of_axis.clone().fold(f32::MIN, f32::max) - of_axis.fold(f32::MAX, f32::min)
}

/// The largest difference of two lists of numbers.
fn off(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, |most, x| if x > most || x.is_nan() { x } else { most })
}
