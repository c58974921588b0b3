//! A first session, as docs/viewing.md describes it: open, find exchanged labels, repair them, pull a brow,
//! and export a film.

use super::*;
use crate::repairs::{LABELS, exchanged, wait};

/// Clicks the marker of a label.
fn click_marker(view: &mut View, label: &str, modifiers: Modifiers) {
    let handle = demo().1.handles().labels.iter().position(|other| other == label).unwrap();
    let place = at(view, handle);
    click(view, place, modifiers);
}

#[test]
fn a_first_session() {
    let folder = Folder::new();
    rhytid_formats::take::write(&folder.path("session.csv"), &exchanged()).unwrap();
    let mut view = window([1280.0, 1400.0], false);
    open(&mut view, &[folder.path("FACE.safetensors"), folder.path("session.csv")]);
    assert!(view.state().warnings().iter().any(|words| words.contains("in frame")), "1: it says so");

    // 2. The list of events leads to the first of the torn frames.
    view.key_press(egui::Key::Space);
    view.step();
    view.key_press(egui::Key::Home);
    view.run();
    view.get_by_label("Event after").click();
    view.run();
    assert_eq!(document(&view).transport.frame(), 60);
    let torn: Vec<String> = document(&view).problems().into_iter().map(|problem| problem.words).collect();
    assert!(LABELS.iter().all(|label| torn.iter().any(|words| words.contains(label))), "{torn:?}");

    // 3. The range of these frames, the two markers, and the exchange.
    view.key_press(egui::Key::I);
    view.run();
    seek(&mut view, 89);
    view.key_press(egui::Key::O);
    view.run();
    click_marker(&mut view, LABELS[0], Modifiers::NONE);
    click_marker(&mut view, LABELS[1], Modifiers::SHIFT);
    view.get_by_label("Repairs").click();
    view.run();
    view.get_by_label("Exchange labels").click();
    wait(&mut view);
    assert_eq!(document(&view).problems(), []);
    assert!(view.state().warnings().is_empty());

    // 4. A brow is pulled up for a second.
    view.key_press(egui::Key::U);
    seek(&mut view, 120);
    view.get_by_label("at this frame").click();
    view.run();
    let handle = demo().1.handles().labels.iter().position(|label| label == "brow_L2").unwrap();
    let from = at(&view, handle);
    let before = document(&view).handles(false)[handle];
    drag(&mut view, from, from - egui::vec2(0.0, 12.0), Modifiers::NONE);
    view.run();
    assert!(document(&view).handles(true)[handle][1] > before[1] + 0.1, "the brow is higher");
    seek(&mut view, 160);
    let there = document(&view);
    assert_eq!(there.handles(true)[handle], there.handles(false)[handle], "later, it is not");

    // 5. The film of what is seen.
    seek(&mut view, 118);
    view.key_press(egui::Key::I);
    view.run();
    seek(&mut view, 122);
    view.key_press(egui::Key::O);
    view.run();
    view.get_by_label("Save").click();
    view.run();
    view.get_by_label("A film of what is seen").click();
    let begin = std::time::Instant::now();
    let is_there = |folder: &Folder| {
        ["mp4", "webp"].iter().any(|ending| folder.path(&format!("FACE-film-0001.{ending}")).is_file())
    };
    while !is_there(&folder) && begin.elapsed().as_secs() < 120 {
        view.step();
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    assert!(is_there(&folder), "{:?}", view.state().note());
}
