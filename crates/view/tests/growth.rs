//! A viewer's memory does not grow in long use. The test is alone in its process, whose memory is measured.

use eframe::egui;
use eframe::egui_wgpu::{WgpuSetup, WgpuSetupCreateNew};
use egui_kittest::Harness;
use rhytid_backend_wgpu::Wgpu;
use rhytid_core::{NoProgress, Rig, rig_file};
use rhytid_test_support::resident;
use rhytid_view::ViewApp;
use std::sync::Arc;

/// More than this is growth. The memory that allocators and the driver keep settles within 24 MB. A rig that
/// is not released would add 2 MB with each load.
const MOST: u64 = 40 << 20;

/// The number of repetitions. `RHYTID_LOADS=1000` asks for more loads, and `RHYTID_PICTURES=216000` for an
/// hour of playing.
fn times(variable: &str, otherwise: usize) -> usize {
    std::env::var(variable).ok().and_then(|times| times.parse().ok()).unwrap_or(otherwise)
}

#[test]
fn rigs_are_opened_and_takes_played_again_and_again_without_growth() {
    let face = rhytid_demo::face(2_000);
    let rig: Rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let files = ["FACE.safetensors", "take.csv"].map(|name| folder.path().join(name));
    rig_file::write(&files[0], &rig).unwrap();
    rhytid_formats::take::write(&files[1], &rhytid_demo::performance(&face)).unwrap();
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.device_descriptor = Arc::new(Wgpu::device_descriptor);
    let builder = Harness::builder().with_size([300.0, 240.0]).with_step_dt(1.0 / 60.0);
    let mut view = builder
        .wgpu_setup(WgpuSetup::CreateNew(setup))
        .build_eframe(|context| ViewApp::new(context).unwrap().with_whole_pictures());
    let mut load = |times: usize, frames: usize| {
        for _ in 0..times {
            view.state_mut().open_paths(&files);
            while view.state().is_opening() {
                view.step();
                std::thread::sleep(std::time::Duration::from_millis(2));
            }
            (0..frames).for_each(|_| view.step());
            assert_eq!(view.state().note(), None);
        }
        // Now and then the window itself changes.
        view.key_press(egui::Key::H);
        view.step();
        resident()
    };
    let loads = times("RHYTID_LOADS", 30);
    let pictures = times("RHYTID_PICTURES", 40 * loads);
    let before = load(loads / 3, 3);
    let after = load(loads, 3);
    assert!(after < before + MOST, "loads: {} MB became {} MB", before >> 20, after >> 20);
    let played = load(1, pictures);
    assert!(played < after + MOST, "playing: {} MB became {} MB", after >> 20, played >> 20);
    println!(
        "{} MB, after {loads} loads {} MB, after {pictures} pictures of playing {} MB",
        before >> 20,
        after >> 20,
        played >> 20
    );
}
