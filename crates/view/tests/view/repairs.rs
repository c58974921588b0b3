//! Repairs of a take by hand.

use super::*;
use rhytid_core::Take;

pub(crate) const LABELS: [&str; 2] = ["brow_L2", "lip_low"];

/// The demo's performance with the labels of two markers exchanged in frames 60 to 89.
pub(crate) fn exchanged() -> Take {
    let mut take = rhytid_demo::performance(&demo().0);
    let column = |label: &str| take.labels.iter().position(|other| other == label).unwrap();
    let [a, b] = LABELS.map(column);
    let markers = take.labels.len();
    for frame in 60..90 {
        take.positions.swap(frame * markers + a, frame * markers + b);
    }
    take
}

/// Waits until the take has been read again.
pub(crate) fn wait(view: &mut View) {
    view.step();
    while view.state().is_opening() {
        view.step();
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    view.run();
}

/// Whether two takes have the same places, within a micrometre.
fn are_same(a: &Take, b: &Take) -> bool {
    let pairs = a.positions.as_flattened().iter().zip(b.positions.as_flattened());
    a.positions.len() == b.positions.len() && pairs.clone().all(|(a, b)| (a - b).abs() < 1e-4)
}

#[test]
fn exchanged_labels_are_exchanged_back_and_the_take_is_saved() {
    let folder = Folder::new();
    let path = folder.path("exchanged.csv");
    rhytid_formats::take::write(&path, &exchanged()).unwrap();
    let mut view = opened(&folder, [900.0, 900.0]);
    open(&mut view, &[path]);
    view.key_press(egui::Key::Space);
    view.run();
    let warnings = view.state().warnings().to_vec();
    assert!(warnings.iter().any(|words| words.contains("stretched by")), "{warnings:?}");
    // The range of the bad frames, and the two markers.
    for (frame, key) in [(60, egui::Key::I), (89, egui::Key::O)] {
        seek(&mut view, frame);
        view.key_press(key);
        view.run();
    }
    view.get_by_label("Device").click();
    view.get_by_label("Repairs").click();
    view.run();
    let labels = &demo().1.handles().labels;
    for (label, modifiers) in LABELS.into_iter().zip([Modifiers::NONE, Modifiers::SHIFT]) {
        let handle = labels.iter().position(|other| other == label).unwrap();
        let place = at(&view, handle);
        click(&mut view, place, modifiers);
    }
    assert_eq!(view.state().selected().len(), 2);
    view.run();
    view.get_by_label("Exchange labels").click();
    wait(&mut view);
    assert_eq!(view.state().note(), None);
    let right = rhytid_demo::performance(&demo().0);
    assert!(are_same(&document(&view).take().unwrap().take, &right), "the labels are right again");
    assert!(view.state().warnings().is_empty(), "{:?}", view.state().warnings());
    assert_eq!(document(&view).transport.frame(), 89, "the play head stays");
    view.get_by_label("swap brow_L2,lip_low:60..90");
    view.get_by_label("Save the repaired take").click();
    view.run();
    let saved = folder.path("FACE-repaired-0001.csv");
    let saved = rhytid_formats::take::read(&saved, None, rhytid_core::Missing::Error).unwrap();
    assert!(are_same(&saved, &right));
    view.get_by_label("Take back").click();
    wait(&mut view);
    assert!(are_same(&document(&view).take().unwrap().take, &exchanged()), "as it was");
}
