//! The contents of the window.

use super::*;
use image::RgbaImage;
use rhytid_backend_cpu::Cpu;
use rhytid_core::{Animator, Stage, UploadOptions};
use rhytid_render::{Camera, FrameBuffers, Look, Offscreen, Picture, Renderer};
use rhytid_view::{Before, Show};

/// The window's picture at the place of the face.
pub(crate) fn shown(view: &mut View) -> RgbaImage {
    let rect = face(view);
    let picture = view.render().unwrap();
    let [x, y, w, h] = [rect.left(), rect.top(), rect.width(), rect.height()].map(|n| n.round() as u32);
    RgbaImage::from_fn(w, h, |i, j| *picture.get_pixel(x + i, y + j))
}

/// The part of the pixels that have a colour which differs by more than `by`.
pub(crate) fn differ(a: &RgbaImage, b: impl Fn(u32, u32) -> [u8; 4], by: u8) -> f64 {
    let pixels = a.enumerate_pixels();
    let off = pixels.filter(|(x, y, pixel)| {
        let other = b(*x, *y);
        (0..3).any(|c| pixel.0[c].abs_diff(other[c]) > by)
    });
    off.count() as f64 / f64::from(a.width() * a.height())
}

/// The frame that the processor evaluates, drawn without a window.
pub(crate) fn expected(
    camera: &Camera,
    size: [u32; 2],
    background: [u8; 4],
    handles: &[[f32; 3]],
) -> Picture {
    let rig = &demo().1;
    let wgpu = Wgpu::open(&Wgpu::devices().unwrap()[0]).unwrap();
    let (device, queue) = (wgpu.device(), wgpu.queue());
    let cpu = Cpu::open(&Cpu::devices().unwrap()[0]).unwrap();
    let mut animator = Animator::new(&cpu, rig, UploadOptions::frames(1)).unwrap();
    animator.evaluate(handles.as_flattened()).unwrap();
    let [mut positions, mut normals] = [Vec::new(), Vec::new()];
    animator.read(Stage::Positions, &mut positions).unwrap();
    animator.read(Stage::Normals, &mut normals).unwrap();
    let buffers = FrameBuffers::new(device, queue, rig.vertices()).unwrap();
    buffers.set(&positions, &normals, &[]);
    let mut renderer =
        Renderer::new(device, queue, &rig.surface().faces, &rig.surface().triangles, Offscreen::TARGET)
            .unwrap();
    let page = Offscreen::new(device, queue, size).unwrap();
    renderer.show(camera, page.aspect(), Look::Smooth);
    page.draw(background, |pass| renderer.draw(pass, buffers.vertices())).unwrap()
}

#[test]
fn the_face_is_the_one_that_is_drawn_without_a_window() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    view.state_mut().settings_mut().markers = false;
    for theme in [egui::Theme::Dark, egui::Theme::Light] {
        view.ctx.set_theme(theme);
        seek(&mut view, 90);
        let picture = shown(&mut view);
        let size = [picture.width(), picture.height()];
        let background = view.ctx.global_style().visuals.extreme_bg_color.to_array();
        let camera = view.state().orbit().unwrap().camera();
        let handles = document(&view).handles(true);
        let other = expected(&camera, size, background, &handles);
        let off = differ(&picture, |x, y| other.pixel([x, y]), 3);
        assert!(off < 0.002, "{theme:?}: {off} of the pixels differ");
        let at_rest = expected(&camera, size, background, &demo().1.handles().rest);
        assert!(differ(&picture, |x, y| at_rest.pixel([x, y]), 3) > 0.02, "another frame is another picture");
    }
}

#[test]
fn every_look_is_drawn_and_differs_from_the_others() {
    let folder = Folder::new();
    let mut view = opened(&folder, [700.0, 560.0]);
    seek(&mut view, 192);
    let handle = handle_in_front(&view);
    let place = at(&view, handle) + egui::vec2(14.0, 5.0);
    click(&mut view, place, Modifiers::NONE);
    let mut pictures: Vec<(Show, RgbaImage)> = Vec::new();
    for (i, show) in Show::ALL.into_iter().enumerate() {
        let key = [
            egui::Key::F1,
            egui::Key::F2,
            egui::Key::F3,
            egui::Key::F4,
            egui::Key::F5,
            egui::Key::F6,
            egui::Key::F7,
            egui::Key::F8,
            egui::Key::F9,
        ][i];
        view.key_press(key);
        view.run();
        assert_eq!(view.state().note(), None, "{show:?}");
        assert_eq!(view.state_mut().settings_mut().show, show);
        let picture = shown(&mut view);
        for (other, before) in &pictures {
            let off = differ(&picture, |x, y| before.get_pixel(x, y).0, 8);
            assert!(off > 0.003, "{show:?} looks as {other:?}: {off}");
        }
        pictures.push((show, picture));
    }
}

#[test]
fn before_and_after_are_beside_each_other() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    view.state_mut().settings_mut().markers = false;
    seek(&mut view, 192);
    view.state_mut().settings_mut().gain = 2.0;
    view.run();
    let result = shown(&mut view);
    view.state_mut().settings_mut().gain = 0.0;
    view.run();
    let large_scale = shown(&mut view);
    let wrinkles = differ(&result, |x, y| large_scale.get_pixel(x, y).0, 4);
    assert!(wrinkles > 0.006, "there are no wrinkles here: {wrinkles}");
    let settings = view.state_mut().settings_mut();
    (settings.gain, settings.before, settings.wipe) = (2.0, Before::LargeScale, 0.5);
    view.run();
    let both = shown(&mut view);
    let line = both.width() / 2;
    // The line and the words at the top are left out.
    let is_words = |x: u32, y: u32| y < 28 || x.abs_diff(line) < 4;
    let other = |x: u32, y: u32| match x < line {
        _ if is_words(x, y) => both.get_pixel(x, y).0,
        true => large_scale.get_pixel(x, y).0,
        false => result.get_pixel(x, y).0,
    };
    let off = differ(&both, other, 3);
    assert!(off < 0.002, "{off}");
}

#[test]
fn another_device_draws_the_same() {
    let folder = Folder::new();
    let devices = Cpu::devices().unwrap();
    let mut view = opened(&folder, [900.0, 700.0]);
    let here = shown(&mut view);
    let set = |app: ViewApp| app.with_whole_pictures().with_devices(devices);
    let mut view = window_of([900.0, 700.0], false, set);
    open(&mut view, &[folder.path("FACE.safetensors"), folder.path("take.csv")]);
    view.key_press(egui::Key::Space);
    view.key_press(egui::Key::Home);
    view.run();
    view.get_by_label("evaluated").click();
    view.run();
    view.get_by(|node| node.label().is_some_and(|label| label.starts_with("cpu:0"))).click();
    view.run();
    assert_eq!(view.state().note(), None);
    let other = shown(&mut view);
    assert_eq!(here.dimensions(), other.dimensions());
    let off = differ(&other, |x, y| here.get_pixel(x, y).0, 3);
    assert!(off < 0.002, "{off}");
}

#[test]
fn a_narrow_window_is_of_use() {
    let folder = Folder::new();
    let mut view = opened(&folder, [400.0, 700.0]);
    assert!(view.query_by_label("Mirrored").is_none(), "the panel is closed at first");
    let rect = face(&view);
    assert!(rect.width() > 390.0 && rect.height() > 400.0, "{rect:?}");
    let handle = handle_in_front(&view);
    let from = at(&view, handle);
    drag(&mut view, from, from + egui::vec2(10.0, 0.0), Modifiers::NONE);
    assert!(at(&view, handle).distance(from + egui::vec2(10.0, 0.0)) < 1.0);
    view.key_press(egui::Key::T);
    view.run();
    let panel = view.get_by_label("Mirrored").rect();
    assert!(panel.right() <= 400.0, "{panel:?}");
    assert!(face(&view).width() > 50.0, "the face is still there beside it");
}
