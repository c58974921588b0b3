//! Pulls that are not saved, when the window is closed or another rig is opened.

use super::*;
use eframe::egui::{ViewportCommand, ViewportEvent, ViewportId};

fn pulled(folder: &Folder) -> View {
    let mut view = opened(folder, [900.0, 700.0]);
    let from = at(&view, handle_in_front(&view));
    drag(&mut view, from, from + egui::vec2(20.0, 10.0), Modifiers::NONE);
    view.run();
    view
}

/// The commands that the window was given in the last frame.
fn commands(view: &View) -> Vec<ViewportCommand> {
    view.output().viewport_output.values().flat_map(|output| output.commands.clone()).collect()
}

/// Whether the window was told to close within some frames.
fn closes(view: &mut View) -> bool {
    (0..5).any(|_| {
        view.step();
        commands(view).contains(&ViewportCommand::Close)
    })
}

fn answer(view: &mut View, words: &str) {
    // The panel has a section named Save, too. The question comes after it.
    view.get_all_by_label(words).last().unwrap().click();
}

fn is_asked(view: &View) -> bool {
    view.query_by_label_contains("Your pulls are not saved").is_some()
}

/// Presses the key in the next frame. The harness would release it in a frame of its own.
fn quit(view: &mut View) {
    view.input_mut().events.push(egui::Event::Key {
        key: egui::Key::Q,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers: Modifiers::COMMAND,
    });
}

#[test]
fn a_window_without_pulls_closes_at_once() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    quit(&mut view);
    assert!(closes(&mut view) && !is_asked(&view));
}

#[test]
fn closing_asks_and_cancel_keeps_everything() {
    let folder = Folder::new();
    let mut view = pulled(&folder);
    quit(&mut view);
    assert!(!closes(&mut view) && is_asked(&view));
    answer(&mut view, "Cancel");
    assert!(!closes(&mut view) && !is_asked(&view));
    assert_eq!(document(&view).pose().pulls.len(), 1);
    // The cross of the window asks, too. The window is kept open until the answer.
    let close = |view: &mut View| {
        let window = view.input_mut().viewports.entry(ViewportId::ROOT).or_default();
        window.events.push(ViewportEvent::Close);
        view.step();
    };
    close(&mut view);
    assert!(commands(&view).contains(&ViewportCommand::CancelClose));
    view.step();
    assert!(is_asked(&view));
    answer(&mut view, "Discard");
    assert!(closes(&mut view), "it closes by itself then");
    close(&mut view);
    assert!(!commands(&view).contains(&ViewportCommand::CancelClose), "and is not held up again");
    assert!(!folder.path("FACE-edit-0001.toml").exists());
}

#[test]
fn save_saves_and_closes_and_what_is_saved_is_not_asked_for() {
    let folder = Folder::new();
    let mut view = pulled(&folder);
    quit(&mut view);
    view.run();
    answer(&mut view, "Save");
    assert!(closes(&mut view));
    assert!(folder.path("FACE-edit-0001.toml").exists());
    let mut view = pulled(&folder);
    view.key_press_modifiers(Modifiers::COMMAND, egui::Key::E);
    view.run();
    quit(&mut view);
    assert!(closes(&mut view) && !is_asked(&view));
    // Another drag is not saved.
    let from = at(&view, handle_in_front(&view));
    drag(&mut view, from, from + egui::vec2(0.0, 20.0), Modifiers::NONE);
    quit(&mut view);
    assert!(!closes(&mut view) && is_asked(&view));
}

#[test]
fn another_rig_is_opened_after_the_answer() {
    let folder = Folder::new();
    let mut view = pulled(&folder);
    std::fs::copy(folder.path("FACE.safetensors"), folder.path("OTHER.safetensors")).unwrap();
    let other = [folder.path("OTHER.safetensors")];
    let name = |view: &View| document(view).name.clone();
    for (words, becomes) in [("Cancel", "FACE.safetensors"), ("Save", "OTHER.safetensors")] {
        view.state_mut().open_paths(&other);
        view.run();
        assert!(is_asked(&view) && name(&view).ends_with("FACE.safetensors"));
        answer(&mut view, words);
        view.step();
        while view.state().is_opening() {
            view.step();
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        view.step();
        assert!(name(&view).ends_with(becomes), "{words}: {}", name(&view));
    }
    assert!(folder.path("FACE-edit-0001.toml").exists());
    assert!(document(&view).pose().pulls.is_empty());
    // A take is no reason to ask: the pulls stay.
    let mut view = pulled(&folder);
    open(&mut view, &[folder.path("take.csv")]);
    assert!(!is_asked(&view));
    assert_eq!(document(&view).pose().pulls.len(), 1);
}

#[test]
fn a_mesh_in_the_place_of_the_rig_asks_too() {
    let folder = Folder::new();
    let mut view = pulled(&folder);
    let mesh = document(&view).frame_as_mesh(demo().1.surface().rest.as_flattened());
    rhytid_formats::mesh::write_obj(&folder.path("other.obj"), &mesh).unwrap();
    view.state_mut().open_paths(&[folder.path("other.obj")]);
    view.run_steps(3);
    assert!(is_asked(&view));
    answer(&mut view, "Cancel");
    view.run_steps(3);
    assert!(!is_asked(&view) && !document(&view).is_mesh() && !document(&view).pose().pulls.is_empty());
}
