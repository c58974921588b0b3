//! Pulls that act in some frames: in the window, on the time line, and in the file that is saved.

use super::*;
use rhytid_formats::{Reach, take};
use rhytid_playback::Layers;
use rhytid_view::{Pull, When};

const HERE: usize = 90;

/// Pulls the marker in front by some points.
fn pull(view: &mut View, by: egui::Vec2) {
    let from = at(view, handle_in_front(view));
    drag(view, from, from + by, Modifiers::NONE);
    view.run();
}

/// Chooses when new pulls act.
fn choose(view: &mut View, when: When) {
    view.get_by_label(when.name()).click();
    view.run();
}

fn key(view: &mut View, modifiers: Modifiers, key: egui::Key) {
    view.key_press_modifiers(modifiers, key);
    view.run();
}

fn pulls(view: &View) -> &[Pull] {
    &document(view).pose().pulls
}

/// The handles that the window shows in each frame.
fn shown(view: &mut View) -> Vec<Vec<[f32; 3]>> {
    let frames = document(view).transport.frames();
    key(view, Modifiers::NONE, egui::Key::Home);
    let mut shown = vec![document(view).handles(true)];
    for _ in 1..frames {
        view.key_press(egui::Key::ArrowRight);
        view.step();
        shown.push(document(view).handles(true));
    }
    assert_eq!(document(view).transport.frame(), frames - 1);
    shown
}

/// The largest difference to what the take with this file of edits has, in all frames.
fn off(shown: &[Vec<[f32; 3]>], folder: &Folder, edit: &str) -> f32 {
    let rig = &demo().1;
    let take = take::read(&folder.path("take.csv"), None, take::Missing::Error).unwrap();
    let layers = Layers::read(&folder.path(edit), rig, Reach::Below).unwrap();
    let edited = layers.edit(take, rig).unwrap().take.handle_positions(&rig.handles().labels).unwrap();
    let pairs = shown.iter().flat_map(|frame| frame.as_flattened()).zip(&edited);
    assert_eq!(edited.len(), shown.len() * 3 * rig.handles().len());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// In centimetres: a few steps of single precision at the size of a head.
const ROUNDING: f32 = 4e-6;

#[test]
fn the_window_and_the_saved_edit_have_the_same_markers_in_every_frame() {
    let folder = Folder::new();
    let mut view = opened(&folder, [1280.0, 900.0]);
    let plain = shown(&mut view);
    seek(&mut view, HERE);
    let here = document(&view).transport.frame();
    choose(&mut view, When::At);
    pull(&mut view, egui::vec2(24.0, -31.0));
    let one = document(&view).handles(true);
    choose(&mut view, When::From);
    key(&mut view, Modifiers::SHIFT, egui::Key::ArrowRight);
    pull(&mut view, egui::vec2(-10.0, 17.0));
    choose(&mut view, When::Whole);
    pull(&mut view, egui::vec2(9.0, 8.0));
    let kinds: Vec<When> = pulls(&view).iter().map(|pull| pull.span.when).collect();
    assert_eq!(kinds, [When::At, When::From, When::Whole]);
    assert_eq!(pulls(&view)[1].span.frames[0], here + 10);
    let found = shown(&mut view);
    key(&mut view, Modifiers::COMMAND, egui::Key::E);
    assert_eq!(
        view.state().note(),
        Some((&*format!("saved {}", folder.path("FACE-edit-0001.toml").display()), false))
    );
    let off = off(&found, &folder, "FACE-edit-0001.toml");
    assert!(off < ROUNDING, "{off}");
    // The pull at the frame was met there, and is gone long before and after it.
    let moved =
        |a: &[[f32; 3]], b: &[[f32; 3]]| a.iter().zip(b).map(|(a, b)| distance(*a, *b)).fold(0.0, f32::max);
    assert!(moved(&one, &plain[here]) > 0.2, "{}", moved(&one, &plain[here]));
    let whole = moved(&found[0], &plain[0]);
    assert!(whole > 0.01 && (moved(&found[here - 20], &plain[here - 20]) - whole).abs() < 1e-5);
    // The file has no digits that mean nothing.
    let text = std::fs::read_to_string(folder.path("FACE-edit-0001.toml")).unwrap();
    let digits =
        text.split(|c: char| !c.is_ascii_digit() && c != '.').filter_map(|word| word.split_once('.'));
    let most = digits.map(|(_, part)| part.len()).max();
    assert!(most.is_some_and(|most| most <= 3), "{most:?} digits:\n{text}");
}

#[test]
fn a_hold_of_the_open_edits_holds_pulls_as_in_the_saved_file() {
    let folder = Folder::new();
    let mut view = opened(&folder, [1280.0, 900.0]);
    let region: Vec<String> =
        demo().1.handles().labels.iter().step_by(2).map(|label| format!("{label:?}")).collect();
    let text = format!(
        "# Mine.\n[region.some]\nmarkers = [{}]\n[[gain]]\nby = [[60, 1], [90, 1.4], [120, 1]]\n\
         [[hold]]\nframes = \"85..95\"\nease = 4\n[[hold]]\nregion = \"some\"\nframes = \"90..110\"\nat = 60\nease = 9\n",
        region.join(", ")
    );
    std::fs::write(folder.path("EDIT.toml"), text).unwrap();
    open(&mut view, &[folder.path("EDIT.toml")]);
    for (frame, when) in [(HERE - 8, When::At), (HERE + 4, When::From), (HERE + 20, When::Whole)] {
        seek(&mut view, frame);
        choose(&mut view, when);
        pull(&mut view, egui::vec2(20.0, 15.0));
    }
    let found = shown(&mut view);
    key(&mut view, Modifiers::COMMAND, egui::Key::E);
    // It lies beside the edits that it begins with, whose comments it keeps.
    let saved = std::fs::read_to_string(folder.path("EDIT-edit-0001.toml")).unwrap();
    assert!(saved.starts_with("# Mine.") && saved.contains("[[offset]]"), "{saved}");
    let off = off(&found, &folder, "EDIT-edit-0001.toml");
    assert!(off < ROUNDING, "{off}");
}

#[test]
fn pulls_are_on_the_time_line_and_are_changed_and_deleted_there() {
    let folder = Folder::new();
    let mut view = opened(&folder, [1280.0, 900.0]);
    seek(&mut view, HERE);
    let here = document(&view).transport.frame();
    choose(&mut view, When::At);
    pull(&mut view, egui::vec2(24.0, 0.0));
    // Another drag in the same frame goes into the same pull.
    pull(&mut view, egui::vec2(0.0, 12.0));
    assert_eq!(pulls(&view).len(), 1);
    let first = pulls(&view)[0].clone();
    view.get_by_label("pulled");
    // A second one at another frame. A click on the bar of the first selects that again.
    seek(&mut view, 30);
    pull(&mut view, egui::vec2(10.0, 0.0));
    assert_eq!((pulls(&view).len(), document(&view).selected_pull()), (2, Some(1)));
    let bar = on_strip(&view, here);
    let strip = view.get_by_label("Time line").rect();
    click(&mut view, egui::pos2(bar.x, strip.bottom() - 7.0), Modifiers::NONE);
    view.run();
    assert_eq!(document(&view).selected_pull(), Some(0));
    // Its last frame is typed. That is one step to undo.
    let field = view.get_by_label("Last frame").rect().center();
    click(&mut view, field, Modifiers::NONE);
    view.run();
    view.key_press_modifiers(Modifiers::COMMAND, egui::Key::A);
    view.event(egui::Event::Text((here + 12).to_string()));
    view.run();
    view.key_press(egui::Key::Enter);
    view.run();
    assert_eq!(pulls(&view)[0].span.frames, [here, here + 12]);
    assert_eq!(pulls(&view)[0].millimetres, first.millimetres, "it moves the same markers");
    // A drag in its middle now changes this pull, which is selected.
    seek(&mut view, here + 6);
    pull(&mut view, egui::vec2(-9.0, 4.0));
    assert_eq!(pulls(&view).len(), 2);
    assert_ne!(pulls(&view)[0].millimetres, first.millimetres);
    key(&mut view, Modifiers::COMMAND, egui::Key::Z);
    key(&mut view, Modifiers::COMMAND, egui::Key::Z);
    assert_eq!(pulls(&view)[0], first);
    // Its kind, and the whole pull.
    view.get_by_label("From a frame").click();
    view.run();
    assert_eq!((pulls(&view)[0].span.when, pulls(&view)[0].span.frames[0]), (When::From, here));
    view.get_by_label("Delete this pull").click();
    view.run();
    assert_eq!((pulls(&view).len(), document(&view).selected_pull()), (1, None));
    key(&mut view, Modifiers::COMMAND, egui::Key::Z);
    assert_eq!(pulls(&view).len(), 2);
    // The list of events leads to a pull, and the key deletes it.
    key(&mut view, Modifiers::NONE, egui::Key::E);
    let words = |label: Option<String>| {
        label.is_some_and(|label| label.contains(" to ") && label.contains(": pull: "))
    };
    view.get_all_by(|node| words(node.label())).next().unwrap().click();
    view.run();
    let selected = document(&view).selected_pull().expect("the pull was clicked");
    assert!(document(&view).transport.frame() < 30, "its ease begins before its frame");
    key(&mut view, Modifiers::NONE, egui::Key::Delete);
    assert_eq!((selected, pulls(&view).len()), (1, 1));
}
