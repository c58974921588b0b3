//! Measures how long a face takes to follow a marker: `cargo run --release -p rhytid-view --example drag --
//! FACE.safetensors [DEVICE] [whole]`
//!
//! A marker of the rig is dragged through the whole application, in an invisible window of 1920 × 1080
//! pixels. The times run from each event to the finished picture of the face, which may be coarse. With
//! `whole`, each picture is drawn in full, and the window waits for it. Medians are printed for the whole,
//! evaluation, light, drawing, and the window itself. DEVICE evaluates, such as `cpu:0`. Without it, the
//! device that draws also evaluates: the first of wgpu.

use eframe::egui;
use eframe::egui_wgpu::{WgpuSetup, WgpuSetupCreateNew};
use egui_kittest::Harness;
use rhytid_backend_wgpu::Wgpu;
use rhytid_core::{Backend, DeviceInfo, Error, Result};
use rhytid_view::{Show, Times, ViewApp};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Events that are measured. Some events before them are not.
const EVENTS: usize = 25;
const WARM: usize = 5;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let rig = arguments.next().ok_or_else(|| Error::input("usage: drag FACE.safetensors [DEVICE]"))?;
    let words: Vec<String> = arguments.collect();
    let is_whole = words.iter().any(|word| word == "whole");
    let device = words.into_iter().find(|word| word != "whole");
    let draws = Wgpu::devices()?.into_iter().next().ok_or_else(|| Error::input("nothing draws here"))?;
    let evaluates = device.map(|id| find(&id)).transpose()?;
    let name = evaluates.as_ref().unwrap_or(&draws).id();
    println!("{rig}: evaluated on {name}, drawn on {} ({})", draws.id(), draws.name);

    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.device_descriptor = Arc::new(Wgpu::device_descriptor);
    setup.native_adapter_selector = Some(Arc::new(move |adapters, _| {
        let found = adapters.iter().find(|adapter| Wgpu::is(adapter, &draws));
        found.cloned().ok_or_else(|| "the device that was listed is gone".to_owned())
    }));
    let builder = Harness::builder().with_size([1920.0, 1080.0]).with_step_dt(1.0 / 60.0);
    let mut view = builder.wgpu_setup(WgpuSetup::CreateNew(setup)).build_eframe(|context| {
        let app = ViewApp::new(context).expect("a device that runs the kernels").with_device(evaluates);
        if is_whole { app.with_whole_pictures() } else { app }
    });
    view.state_mut().open_paths(&[PathBuf::from(&rig)]);
    while view.state().is_opening() {
        view.step();
        std::thread::sleep(Duration::from_millis(5));
    }
    // The key T toggles the panel at the side.
    view.key_press(egui::Key::T);
    rest(&mut view);
    if let Some((words, _)) = view.state().note() {
        return Err(Error::input(words));
    }
    for show in [Show::Shaded, Show::Skin] {
        view.state_mut().settings_mut().show = show;
        rest(&mut view);
        measure(&mut view, show)?;
    }
    Ok(())
}

/// A device that does not belong to wgpu.
fn find(id: &str) -> Result<DeviceInfo> {
    let found = rhytid_devices::backends::devices().devices.into_iter().find(|device| device.id() == id);
    found.ok_or_else(|| Error::input(format!("{id}: no such device")))
}

/// Waits for a whole picture, and returns its times.
fn rest(view: &mut Harness<'static, ViewApp>) -> Times {
    view.step();
    while view.state().is_drawing() {
        std::thread::sleep(Duration::from_millis(1));
        view.step();
    }
    view.state().times().unwrap_or_default().0
}

/// Drags the first marker, and prints the times.
fn measure(view: &mut Harness<'static, ViewApp>, show: Show) -> Result<()> {
    let (orbit, document) = (view.state().orbit(), view.state().document());
    let (Some(orbit), Some(document)) = (orbit, document) else { return Err(Error::input("no rig")) };
    // The picture begins at the window's left and top edge, and leaves out the line at the bottom.
    let size = view.state().picture_size().unwrap_or([1; 2]);
    let [x, y, _] = orbit.camera().project(size, document.handles(true)[0]);
    let from = egui::pos2(x, y);
    let button = |pressed| egui::Event::PointerButton {
        pos: from,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: egui::Modifiers::NONE,
    };
    view.hover_at(from);
    view.event(button(true));
    view.step();
    let mut took: [Vec<f64>; 5] = Default::default();
    let mut longest = Duration::ZERO;
    for event in 0..WARM + EVENTS {
        let angle = 0.5 * event as f32;
        let drawn = view.state().times().map(|(_, drawn)| drawn);
        let begin = Instant::now();
        view.hover_at(from + egui::vec2(40.0 * angle.cos(), 40.0 * angle.sin()));
        view.step();
        longest = longest.max(begin.elapsed());
        while view.state().times().map(|(_, drawn)| drawn) == drawn {
            std::thread::sleep(Duration::from_millis(1));
            view.step();
        }
        let all = begin.elapsed();
        let Some((times, _)) = view.state().times() else { return Err(Error::input("no picture")) };
        if event >= WARM {
            let parts = [times.evaluation, times.lighting, times.drawing];
            let rest = all.saturating_sub(parts.iter().sum());
            let all = [&[all][..], &parts, &[rest]].concat();
            took.iter_mut().zip(all).for_each(|(took, time)| took.push(1e3 * time.as_secs_f64()));
        }
    }
    view.event(button(false));
    let begin = Instant::now();
    let whole = rest(view);
    let until_whole = 1e3 * begin.elapsed().as_secs_f64();
    let median = |times: &mut Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    let [all, evaluation, light, drawing, rest] = took.each_mut().map(median);
    println!(
        "{}, {} × {}: {all:.1} ms from the event to the picture: evaluation {evaluation:.1}, light {light:.1}, drawing {drawing:.1}, the \
         rest {rest:.1}; the window waited {:.1} ms at most; at rest a whole picture after {until_whole:.0} ms: \
         evaluation {:.1}, light {:.1}, drawing {:.1}",
        show.name(),
        size[0],
        size[1],
        1e3 * longest.as_secs_f64(),
        1e3 * whole.evaluation.as_secs_f64(),
        1e3 * whole.lighting.as_secs_f64(),
        1e3 * whole.drawing.as_secs_f64()
    );
    Ok(())
}
