//! The play head.

use super::*;

fn frame(view: &View) -> usize {
    document(view).transport.frame()
}

#[test]
fn a_take_plays_at_its_own_rate() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let rate = rhytid_demo::performance(&demo().0).rate();
    view.key_press(egui::Key::Space);
    view.step();
    let first = frame(&view);
    // One second, with the window's 60 pictures a second.
    for _ in 0..60 {
        view.step();
    }
    let played = (frame(&view) - first) as f64;
    assert!((played - rate).abs() <= 1.0, "{played} frames in a second, expected {rate}");
    // It waits for the next frame, and draws each frame once.
    view.get_by_label("Stop").click();
    view.run();
    let stopped = frame(&view);
    (0..10).for_each(|_| view.step());
    assert_eq!(frame(&view), stopped);
}

#[test]
fn the_time_line_is_scrubbed_and_stepped() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let frames = document(&view).transport.frames();
    let strip = view.get_by_label("Time line").rect();
    let middle = strip.center();
    drag(&mut view, strip.left_center() + egui::vec2(2.0, 0.0), middle, Modifiers::NONE);
    assert!(frame(&view).abs_diff(frames / 2) <= 1, "{} of {frames}", frame(&view));
    let handles = document(&view).handles(true);
    let take = rhytid_demo::performance(&demo().0).handle_positions(&demo().1.handles().labels).unwrap();
    let h = 3 * demo().1.handles().len();
    assert_eq!(handles.as_flattened(), &take[frame(&view) * h..][..h]);
    let here = frame(&view);
    for (key, expected) in [
        (egui::Key::Period, here + 1),
        (egui::Key::Comma, here),
        (egui::Key::Home, 0),
        (egui::Key::Comma, 0),
        (egui::Key::End, frames - 1),
        (egui::Key::Period, frames - 1),
    ] {
        view.key_press(key);
        view.run();
        assert_eq!(frame(&view), expected, "{key:?}");
    }
    view.key_press(egui::Key::L);
    view.run();
    assert!(!document(&view).transport.looping);
}
