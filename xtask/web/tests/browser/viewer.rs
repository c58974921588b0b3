//! The viewer as a page: its keys, mouse and touch, and its picture.

use super::*;
use base64::Engine;
use rhytid_backend_cpu::Cpu;
use rhytid_backend_wgpu::Wgpu;
use rhytid_core::rig_file::{Packing, Step};
use rhytid_core::{Animator, Backend, NoProgress, Stage, UploadOptions};
use rhytid_render::{FrameBuffers, Look, Offscreen, Renderer};
use rhytid_view::Orbit;

const OPEN: &str = "window.rhytid && ['open', 'unsupported', 'broken'].includes(window.rhytid.state)";
pub(crate) const STATUS: &str = "JSON.parse(rhytid.viewer.status)";
pub(crate) const POSITIONS: &str = "rhytid.viewer.positions().then((positions) => Array.from(positions))";
pub(crate) const PICTURE: &str = "rhytid.viewer.picture().then((png) => btoa(Array.from(png, (byte) => String.fromCharCode(byte)).join('')))";

/// Presses and releases a key.
pub(crate) fn key(key: &str, code: &str, modifiers: u8) -> [Value; 2] {
    // Chromium uses character codes for letters, and its own codes for other keys.
    let number = match code {
        "Space" => 32,
        "Home" => 36,
        "F1" => 112,
        "F2" => 113,
        "F8" => 119,
        _ => u32::from(key.to_ascii_uppercase().bytes().next().unwrap_or_default()),
    };
    ["keyDown", "keyUp"].map(|kind| {
        let params = json!({ "type": kind, "key": key, "code": code, "modifiers": modifiers,
            "windowsVirtualKeyCode": number });
        json!({ "method": "Input.dispatchKeyEvent", "params": params })
    })
}

pub(crate) fn until(what: &str) -> Value {
    json!({ "until": what })
}

pub(crate) fn evaluate(name: &str, what: &str) -> Value {
    json!({ "evaluate": { name: what } })
}

/// Waits for two pictures, after which all changes are visible.
pub(crate) fn shown() -> Value {
    json!({ "evaluate": { "_": "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(() => done(0)))))" } })
}

/// The place of a handle on the page, moved by some pixels.
pub(crate) fn place(handle: usize, by: f64, axis: usize) -> String {
    let edge = ["left", "top"][axis];
    format!(
        "rhytid.viewer.handle({handle})[{axis}] + document.getElementById('canvas').getBoundingClientRect().{edge} + {by}"
    )
}

/// Stops the page at the first frame.
fn stand() -> Vec<Value> {
    let mut steps = vec![until(&format!("{STATUS}.frames > 1"))];
    steps.extend(key(" ", "Space", 0));
    steps.push(until(&format!("!{STATUS}.playing")));
    steps.extend(key("Home", "Home", 0));
    steps.extend([until(&format!("{STATUS}.frame === 0")), shown()]);
    steps
}

/// The viewer in a browser that was changed by the script `before`, after some steps.
pub(crate) fn opened(before: &str, steps: &[Value], extra: Value) -> Value {
    let mut visit =
        visit("view.html", before, OPEN, &[("state", "rhytid.state"), ("message", "rhytid.message")]);
    visit["steps"] = Value::from([&stand()[..], steps].concat());
    visit["width"] = json!(900);
    for (name, value) in extra.as_object().into_iter().flatten() {
        visit[name] = value.clone();
    }
    let visited = visited(visit);
    assert_eq!(visited["found"]["state"], "open", "{}", visited["found"]["message"]);
    assert_eq!(visited["errors"], json!([]));
    visited["found"].clone()
}

/// A handle in the middle of the face, far from others.
pub(crate) fn handle() -> usize {
    let (rig, _) = demo();
    let at = |h: usize| rig.handles().rest[h];
    let apart = |h: usize| {
        let others = (0..rig.handles().len()).filter(|other| *other != h);
        others.map(|other| distance(at(h), at(other))).fold(f32::MAX, f32::min)
    };
    let front = (0..rig.handles().len()).filter(|&h| at(h)[2] > 0.6 * at_most(rig, 2));
    front.max_by(|&a, &b| apart(a).total_cmp(&apart(b))).unwrap()
}

fn at_most(rig: &Rig, axis: usize) -> f32 {
    rig.surface().rest.iter().map(|p| p[axis]).fold(f32::MIN, f32::max)
}

pub(crate) fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt()
}

pub(crate) fn handles(status: &Value) -> Vec<[f32; 3]> {
    let handles = status["handles"].as_array().unwrap().iter();
    handles.map(|p| [0, 1, 2].map(|c| p[c].as_f64().unwrap() as f32)).collect()
}

fn picture(found: &Value) -> (u32, u32, Vec<u8>) {
    decoded(&base64::prelude::BASE64_STANDARD.decode(found.as_str().unwrap()).unwrap())
}

/// Width, height and bytes of a PNG.
pub(crate) fn decoded(png: &[u8]) -> (u32, u32, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    (info.width, info.height, pixels)
}

/// Whether a tenth of a picture of the page has the colour of skin: red over green over blue.
pub(crate) fn shows_face(png: &[u8]) -> bool {
    let (width, height, bytes) = decoded(png);
    let pixels = bytes.chunks_exact(bytes.len() / (width * height) as usize);
    let is_skin = |pixel: &&[u8]| pixel[0] > pixel[1].saturating_add(10) && pixel[1] > pixel[2];
    pixels.filter(is_skin).count() * 10 > (width * height) as usize
}

/// The share of the pixels that differ by more than a little.
pub(crate) fn differ(a: &[u8], b: &[u8]) -> f64 {
    let pairs = a.as_chunks::<4>().0.iter().zip(b.as_chunks::<4>().0);
    let off = pairs.filter(|(a, b)| (0..3).any(|c| a[c].abs_diff(b[c]) > 6)).count();
    off as f64 / (a.len() / 4) as f64
}

#[test]
fn a_marker_is_dragged_with_the_mouse_and_the_face_follows() {
    let device = drag("");
    // As Chromium names its GPU, which is SwiftShader in the tests.
    assert!(device.to_lowercase().contains("swiftshader"), "{device} draws");
}

#[test]
fn the_same_by_webgl_where_there_is_no_webgpu() {
    let device = drag(NO_WEBGPU);
    assert!(device.contains("ANGLE"), "{device} draws");
}

/// Drags a marker in a browser that was changed by a `script`, and compares what the page has with what the
/// processor computes. Gives the name of the device that draws.
fn drag(script: &str) -> String {
    let handle = handle();
    let mouse = |kind: &str, x: f64, y: f64| {
        json!({ "method": "Input.dispatchMouseEvent",
            "params": { "type": kind, "button": "left", "buttons": 1, "clickCount": 1 },
            "computed": { "x": format!("window.at[0] + {x}"), "y": format!("window.at[1] + {y}") } })
    };
    let at = format!("window.at = [{}, {}]", place(handle, 0.0, 0), place(handle, 0.0, 1));
    let mut steps = vec![
        evaluate("before", STATUS),
        evaluate("rest", PICTURE),
        evaluate("at", &at),
        mouse("mouseMoved", 0.0, 0.0),
        shown(),
        mouse("mousePressed", 0.0, 0.0),
        shown(),
        mouse("mouseMoved", 12.0, -9.0),
        shown(),
        mouse("mouseMoved", 24.0, -20.0),
        shown(),
        evaluate("there", &format!("[{}, {}]", place(handle, 0.0, 0), place(handle, 0.0, 1))),
        mouse("mouseReleased", 24.0, -20.0),
        shown(),
        evaluate("after", STATUS),
        evaluate("positions", POSITIONS),
        evaluate("picture", PICTURE),
    ];
    steps.extend(key("z", "KeyZ", 2));
    steps.extend([shown(), evaluate("undone", STATUS)]);
    for (name, code) in [("F2", "F2"), ("F8", "F8")] {
        steps.extend(key(name, code, 0));
        steps.extend([shown(), evaluate(code, PICTURE), evaluate(&format!("status {code}"), STATUS)]);
    }
    steps.extend(key("F1", "F1", 0));
    steps.push(shown());
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.png");
    let found = opened(script, &steps, json!({ "picture": page }));
    assert!(shows_face(&std::fs::read(&page).unwrap()), "the page does not show the face");
    let (rig, take) = demo();
    let [before, after] = ["before", "after"].map(|name| handles(&found[name]));
    assert_eq!(
        before.as_flattened(),
        &take.handle_positions(&rig.handles().labels).unwrap()[..3 * rig.handles().len()]
    );
    assert_eq!(found["after"]["selected"], json!([handle]));
    let [at, there] = ["at", "there"].map(|name| [0, 1].map(|c| found[name][c].as_f64().unwrap()));
    assert!(
        (there[0] - at[0] - 24.0).abs() < 1.0 && (there[1] - at[1] + 20.0).abs() < 1.0,
        "{at:?} {there:?}"
    );
    let moved = (0..rig.handles().len()).filter(|&h| distance(before[h], after[h]) > 1e-4).count();
    assert!(moved > 1, "its neighbours come with it");
    assert_eq!(handles(&found["undone"]), before);

    // The page shows what the processor computes for the same handles.
    let cpu = Cpu::open(&Cpu::devices().unwrap()[0]).unwrap();
    let mut animator = Animator::new(&cpu, rig, UploadOptions::frames(1)).unwrap();
    animator.evaluate(after.as_flattened()).unwrap();
    let (mut expected, mut normals) = (Vec::new(), Vec::new());
    animator.read(Stage::Positions, &mut expected).unwrap();
    animator.read(Stage::Normals, &mut normals).unwrap();
    let positions = floats(&found["positions"]);
    assert_eq!(positions.len(), expected.len());
    let off = positions.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let height = at_most(rig, 1) - rig.surface().rest.iter().map(|p| p[1]).fold(f32::MAX, f32::min);
    println!("{:e} of the face's height off the processor's", off / height);
    assert!(off < 2e-5 * height, "{off}");

    // Its picture equals the one drawn without a browser, except for the dots.
    let (width, rows, pixels) = picture(&found["picture"]);
    let wgpu = Wgpu::open(&Wgpu::devices().unwrap()[0]).unwrap();
    let buffers = FrameBuffers::new(wgpu.device(), wgpu.queue(), rig.vertices()).unwrap();
    buffers.set(&expected, &normals, &[]);
    let (device, queue) = (wgpu.device(), wgpu.queue());
    let mut renderer =
        Renderer::new(device, queue, &rig.surface().faces, &rig.surface().triangles, Offscreen::TARGET)
            .unwrap();
    let page = Offscreen::new(device, queue, [width, rows]).unwrap();
    renderer.show(&Orbit::new(rig, page.aspect()).camera(), page.aspect(), Look::Smooth);
    let background: [u8; 4] = pixels[..4].try_into().unwrap();
    let drawn = page.draw(background, |pass| renderer.draw(pass, buffers.vertices())).unwrap();
    let places = (0..rows).flat_map(|y| (0..width).map(move |x| [x, y]));
    let drawn: Vec<u8> = places.flat_map(|at| drawn.pixel(at)).collect();
    let off = differ(&pixels, &drawn);
    println!("{off} of the pixels are others");
    assert!(off < 0.05, "{off}");
    let (_, _, rest) = picture(&found["rest"]);
    assert!(differ(&pixels, &rest) > 1e-3, "the picture of the face that follows is another");
    // Light spreads in skin by kernels. The sentence that says so stays until it is closed.
    let has_skin = script != NO_WEBGPU;
    for look in ["F2", "F8"] {
        match &found[&*format!("status {look}")]["note"] {
            Value::String(said) => assert!(!has_skin && said.contains("draw without skin"), "{said}"),
            note => assert!(has_skin && note.is_null(), "{look}: {note}"),
        }
        let off = differ(&picture(&found[look]).2, &rest);
        assert!(off > 0.05 || (look == "F2" && !has_skin), "{look} looks as shaded");
    }
    found["after"]["device"].as_str().unwrap().to_owned()
}

#[test]
fn a_page_whose_device_dies_says_so() {
    let mut visit = visit("view.html", "", OPEN, &[("state", "rhytid.state"), ("message", "rhytid.message")]);
    let status = "document.getElementById('status')";
    visit["steps"] = json!([
        evaluate("gone", "(rhytid.device.destroy(), 0)"),
        until("rhytid.state === 'broken'"),
        evaluate("shown", &format!("[{status}.textContent, {status}.hidden]")),
    ]);
    let found = visited(visit)["found"].clone();
    assert_eq!(found["state"], "broken");
    assert!(found["message"].as_str().unwrap().starts_with("The GPU was lost"), "{found}");
    assert_eq!(found["shown"], json!([found["message"], false]));
}

#[test]
fn a_lost_context_of_webgl_is_said_too() {
    let mut visit =
        visit("view.html", NO_WEBGPU, OPEN, &[("state", "rhytid.state"), ("message", "rhytid.message")]);
    visit["steps"] = json!([
        evaluate(
            "gone",
            "(document.getElementById('canvas').getContext('webgl2').getExtension('WEBGL_lose_context').loseContext(), 0)"
        ),
        until("rhytid.state === 'broken'"),
    ]);
    let found = visited(visit)["found"].clone();
    assert!(found["message"].as_str().unwrap().starts_with("The GPU was lost"), "{found}");
}

#[test]
fn files_of_ones_own_are_opened_and_broken_ones_said() {
    let folder = tempfile::tempdir().unwrap();
    let face = rhytid_demo::face(1_500);
    let rig: Rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
    let own = folder.path().join("own.safetensors");
    let cut = folder.path().join("cut.safetensors");
    let small = folder.path().join("small.safetensors");
    rig_file::write(&own, &rig).unwrap();
    std::fs::write(&small, packed(&rig)).unwrap();
    std::fs::write(&cut, &std::fs::read(&own).unwrap()[..9_000]).unwrap();
    let choose = |path: &Path| json!({ "method": "DOM.setFileInputFiles", "params": { "files": [path] }, "node": "#files" });
    let steps = [
        choose(&own),
        until(&format!("{STATUS}.vertices === {}", rig.vertices())),
        shown(),
        evaluate("opened", STATUS),
        choose(&small),
        until(&format!("{STATUS}.open === 'small.safetensors'")),
        shown(),
        evaluate("packed", STATUS),
        evaluate("positions", POSITIONS),
        choose(&cut),
        until(&format!("{STATUS}.error")),
        evaluate("refused", STATUS),
    ];
    let found = opened("", &steps, json!({}));
    assert_eq!(found["opened"]["open"], "own.safetensors");
    assert_eq!(found["opened"]["note"], Value::Null);
    let refused = &found["refused"];
    assert!(refused["note"].as_str().unwrap().contains("cut.safetensors"), "{refused}");
    assert_eq!(refused["vertices"], rig.vertices(), "what was open stays");
    // The page has the packed rig's vertices, and not the whole rig's.
    let (positions, handles) = (floats(&found["positions"]), handles(&found["packed"]));
    let [off, off_whole] = [&rig_file::read(&small).unwrap(), &rig].map(|rig| {
        let expected = rhytid_conformance::evaluate(rig, &handles).positions;
        let pairs = positions.as_chunks::<3>().0.iter().zip(&expected);
        pairs.map(|(a, b)| distance(*a, *b)).fold(0.0, f32::max)
    });
    assert!(off < 0.01 * off_whole, "{off} {off_whole}");
}

/// A packed rig whose numbers are coarse.
fn packed(rig: &Rig) -> Vec<u8> {
    let step = |found: rig_file::Roundable| Step { array: found.array, size: found.largest / 2048.0 };
    let steps: Vec<Step> = rig_file::roundable(rig).into_iter().map(step).collect();
    let packing = Packing {
        worst: 0.0,
        rms: 0.0,
        normals: 0.0,
        finished: 0.0,
        finished_beyond: 0,
        poses: 0,
        rig: String::new(),
    };
    rig_file::pack(rig, &steps, &packing).unwrap()
}
