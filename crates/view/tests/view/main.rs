//! The viewer without a window, on a software driver: the actions of the pointer and the keys, and the
//! pictures.

mod edits;
mod export;
mod files;
mod leaving;
mod live;
mod markers;
mod meshes;
mod narrow;
mod pictures;
mod pointer;
mod pulls;
mod repairs;
mod session;
mod slow;
mod time;

use eframe::egui::{self, Modifiers, PointerButton, Pos2, Rect};
use eframe::egui_wgpu::{WgpuSetup, WgpuSetupCreateNew};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use rhytid_backend_wgpu::Wgpu;
use rhytid_core::{Backend, Face, NoProgress, Rig, rig_file};
use rhytid_view::{Document, ViewApp};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

/// A harness of the viewer.
type View = Harness<'static, ViewApp>;

/// The demo's face and its rig.
fn demo() -> &'static (Face, Rig) {
    static DEMO: OnceLock<(Face, Rig)> = OnceLock::new();
    DEMO.get_or_init(|| {
        let face = rhytid_demo::face(4_000);
        let rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        (face, rig)
    })
}

/// A folder with the rig and a take. It is removed when it is dropped.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        let (face, rig) = demo();
        rig_file::write(&folder.path("FACE.safetensors"), rig).unwrap();
        rhytid_formats::take::write(&folder.path("take.csv"), &rhytid_demo::performance(face)).unwrap();
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }
}

/// The first device that is a software driver for Vulkan, as wgpu lists them.
fn setup() -> WgpuSetup {
    let devices = Wgpu::devices().unwrap();
    let info = devices.into_iter().next().expect("a device of wgpu's");
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.device_descriptor = Arc::new(Wgpu::device_descriptor);
    setup.native_adapter_selector = Some(Arc::new(move |adapters, _| {
        let found = adapters.iter().find(|adapter| Wgpu::is(adapter, &info));
        found.cloned().ok_or_else(|| "the device that was listed is gone".to_owned())
    }));
    WgpuSetup::CreateNew(setup)
}

/// An empty window that waits for each picture. `allow` permits glyphs that its fonts lack, as in names of
/// broken files.
fn window(size: [f32; 2], allow: bool) -> View {
    window_of(size, allow, ViewApp::with_whole_pictures)
}

/// An empty window, set up by `set`.
fn window_of(size: [f32; 2], allow: bool, set: impl FnOnce(ViewApp) -> ViewApp) -> View {
    window_on(1.0, size, allow, set)
}

/// The same on a screen with `scale` pixels in a point.
fn window_on(scale: f32, size: [f32; 2], allow: bool, set: impl FnOnce(ViewApp) -> ViewApp) -> View {
    let builder = Harness::builder().with_size(size).with_pixels_per_point(scale);
    let builder = builder.with_step_dt(1.0 / 60.0).with_render_cursor(false);
    // On a busy machine, the thread that draws wakes the window once or twice more.
    let builder = builder.with_max_steps(16);
    let builder = if allow { builder.allow_missing_glyphs() } else { builder };
    builder.wgpu_setup(setup()).build_eframe(|context| set(ViewApp::new(context).unwrap()))
}

/// Opens files and waits until they are open.
fn open(view: &mut View, files: &[PathBuf]) {
    view.state_mut().open_paths(files);
    while view.state().is_opening() {
        view.step();
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    view.step();
}

/// A window with the rig and the take, which stands still at its first frame.
fn opened(folder: &Folder, size: [f32; 2]) -> View {
    stand(window(size, false), folder)
}

/// Opens the rig and the take.
fn stand(mut view: View, folder: &Folder) -> View {
    open(&mut view, &[folder.path("FACE.safetensors"), folder.path("take.csv")]);
    assert_eq!(view.state().note(), None);
    view.key_press(egui::Key::Space);
    view.step();
    view.key_press(egui::Key::Home);
    view.run();
    view
}

fn document(view: &View) -> &Document {
    view.state().document().expect("a rig is open")
}

/// The place of the face in the window.
fn face(view: &View) -> Rect {
    view.get_by(|node| node.label().is_some_and(|label| label.starts_with("Face:"))).rect()
}

/// The place of a handle in the window.
fn at(view: &View, handle: usize) -> Pos2 {
    let rect = face(view);
    let camera = view.state().orbit().unwrap().camera();
    let size = [rect.width(), rect.height()].map(|n| n.round() as u32);
    let [x, y, _] = camera.project(size, document(view).handles(true)[handle]);
    rect.min + egui::vec2(x, y)
}

/// A handle that is visible from the front and not near another.
fn handle_in_front(view: &View) -> usize {
    let seen: Vec<Pos2> = (0..demo().1.handles().len()).map(|handle| at(view, handle)).collect();
    let alone = |handle: usize| {
        let others = seen.iter().enumerate().filter(|(other, _)| *other != handle);
        others.map(|(_, p)| p.distance(seen[handle])).fold(f32::MAX, f32::min)
    };
    let middle = face(view).center();
    let inside = (0..seen.len()).filter(|&handle| seen[handle].distance(middle) < 0.4 * face(view).height());
    inside.max_by(|&a, &b| alone(a).total_cmp(&alone(b))).unwrap()
}

/// The first button of the mouse, without keys.
fn primary(pos: Pos2, pressed: bool) -> egui::Event {
    egui::Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
}

fn button(view: &mut View, at: Pos2, button: PointerButton, pressed: bool, modifiers: Modifiers) {
    view.event(egui::Event::PointerMoved(at));
    view.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers });
}

/// Drags from one place to another in three steps, and releases.
fn drag(view: &mut View, from: Pos2, to: Pos2, modifiers: Modifiers) {
    view.event(egui::Event::ModifiersChanged(modifiers));
    button(view, from, PointerButton::Primary, true, modifiers);
    view.step();
    for part in [0.3, 0.7, 1.0] {
        view.hover_at(from + part * (to - from));
        view.step();
    }
    button(view, to, PointerButton::Primary, false, modifiers);
    view.event(egui::Event::ModifiersChanged(Modifiers::NONE));
    view.step();
}

/// Presses and releases at a place.
fn click(view: &mut View, at: Pos2, modifiers: Modifiers) {
    view.event(egui::Event::ModifiersChanged(modifiers));
    button(view, at, PointerButton::Primary, true, modifiers);
    view.step();
    button(view, at, PointerButton::Primary, false, modifiers);
    view.event(egui::Event::ModifiersChanged(Modifiers::NONE));
    view.step();
}

/// The place of a frame on the time line. The first and the last frame stand 8 points from its ends.
fn on_strip(view: &View, frame: usize) -> Pos2 {
    let strip = view.get_by_label("Time line").rect().shrink2(egui::vec2(8.0, 0.0));
    let part = frame as f32 / (document(view).transport.frames() - 1) as f32;
    egui::pos2(strip.left() + part * strip.width(), strip.center().y)
}

/// Shows a frame, by a click on the time line.
fn seek(view: &mut View, frame: usize) {
    let place = on_strip(view, frame);
    click(view, place, Modifiers::NONE);
    view.run();
    assert!(document(view).transport.frame().abs_diff(frame) <= 1);
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    glam::Vec3::from(a).distance(b.into())
}
