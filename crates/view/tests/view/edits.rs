//! A take with edits, and drags that are saved as an edit.

use super::*;
use rhytid_devices::{Guard, choose_devices};
use rhytid_formats::export::Recipe;
use rhytid_formats::{Reach, mesh, take};
use rhytid_playback::{EditedTake, Layers, Playback, Selection};

const FRAME: usize = 25;

fn seek(view: &mut View, frame: usize) {
    while document(view).transport.frame() != frame {
        view.key_press(egui::Key::Period);
        view.step();
    }
    view.run();
}

/// The frame that is shown, saved.
fn saved(view: &mut View, folder: &Folder, number: usize) -> Vec<[f64; 3]> {
    view.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, egui::Key::S);
    view.run();
    mesh::read(&folder.path(&format!("FACE-pose-{number:04}.obj"))).unwrap().positions
}

/// The same frame, played.
fn played(folder: &Folder, edit: Option<&str>) -> Vec<[f64; 3]> {
    let rig = &demo().1;
    let take = take::read(&folder.path("take.csv"), None, take::Missing::Error).unwrap();
    let layers = edit.map(|edit| Layers::read(&folder.path(edit), rig, Reach::Below).unwrap());
    let take = match &layers {
        Some(layers) => layers.edit(take, rig).unwrap(),
        None => EditedTake::from(take),
    };
    let devices = choose_devices("cpu:0", Guard::NONE, &NoProgress).unwrap().devices;
    let mut playback = Playback::new(rig, &devices, 1).unwrap();
    if let Some(layers) = &layers {
        playback = playback.with_layers(layers, &take, &NoProgress).unwrap();
    }
    let mut positions = Vec::new();
    let selection = Selection::all(take.slice(FRAME..FRAME + 1)).unwrap();
    playback
        .play(&selection, &Recipe::default(), &NoProgress, |frame| {
            positions = frame.positions().as_chunks::<3>().0.iter().map(|x| x.map(f64::from)).collect();
            Ok(())
        })
        .unwrap();
    positions
}

fn farthest(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>());
    squares.fold(0.0, f64::max).sqrt()
}

#[test]
fn a_take_is_shown_edited_and_as_it_was() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    seek(&mut view, FRAME);
    let plain = saved(&mut view, &folder, 1);
    assert!(farthest(&plain, &played(&folder, None)) < 1e-4);
    // The saved frame is sculpted a little and used as a correction, together with gains.
    let mut sculpted = mesh::read(&folder.path("FACE-pose-0001.obj")).unwrap();
    sculpted.positions.iter_mut().filter(|x| x[1] > 1.0).for_each(|x| x[2] += 0.2);
    mesh::write_obj(&folder.path("sculpted.obj"), &sculpted).unwrap();
    // The region has half of the handles, so the other half stays.
    let region: Vec<String> =
        demo().1.handles().labels.iter().step_by(2).map(|label| format!("{label:?}")).collect();
    let region = format!("[region.some]\nmarkers = [{}]\n", region.join(", "));
    let text = "[[gain]]\nregion = \"some\"\nby = 1.25\n[[detail]]\nby = 0.5\n[[correction]]\nmesh = \"sculpted.obj\"\nframe = 25\nreach = 0.4\n";
    std::fs::write(folder.path("EDIT.toml"), region + text).unwrap();
    open(&mut view, &[folder.path("EDIT.toml")]);
    assert_eq!(view.state().note(), None);
    assert_eq!(document(&view).transport.frame(), FRAME, "the play head stays");
    let edited = saved(&mut view, &folder, 2);
    assert!(farthest(&edited, &played(&folder, Some("EDIT.toml"))) < 1e-4);
    assert!(farthest(&edited, &plain) > 0.05, "{}", farthest(&edited, &plain));
    let label = format!("Edited by {}", folder.path("EDIT.toml").display());
    view.get_by_label(&label).click();
    view.run();
    assert!(farthest(&saved(&mut view, &folder, 3), &plain) == 0.0);
    // All files are opened at once, in any order.
    let mut view = window([900.0, 700.0], false);
    open(&mut view, &["EDIT.toml", "take.csv", "FACE.safetensors"].map(|name| folder.path(name)));
    assert_eq!((view.state().note(), document(&view).edits()), (None, Some((&label[10..], true))));
    // Without a take, edits are refused.
    let mut view = window([900.0, 700.0], false);
    open(&mut view, &["EDIT.toml", "FACE.safetensors"].map(|name| folder.path(name)));
    let (words, is_error) = view.state().note().unwrap();
    assert!(is_error && words.contains("EDIT.toml: open a rig and a take first"), "{words}");
}

#[test]
fn drags_are_saved_as_an_edit_that_does_the_same() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    view.key_press_modifiers(Modifiers::COMMAND, egui::Key::E);
    view.run();
    assert!(view.state().note().unwrap().0.contains("no marker was pulled"), "{:?}", view.state().note());
    seek(&mut view, FRAME);
    let from = at(&view, handle_in_front(&view));
    drag(&mut view, from, from + egui::vec2(30.0, 10.0), Modifiers::NONE);
    let dragged = document(&view).handles(true);
    assert_ne!(dragged, document(&view).handles(false));
    view.key_press_modifiers(Modifiers::COMMAND, egui::Key::E);
    view.run();
    let edit = folder.path("FACE-edit-0001.toml");
    assert_eq!(view.state().note(), Some((&*format!("saved {}", edit.display()), false)));
    // The whole face is the one that is played with the saved edit, also where no pulled marker drives it.
    let here = saved(&mut view, &folder, 1);
    let off = farthest(&here, &played(&folder, Some("FACE-edit-0001.toml")));
    assert!(off < 1e-4, "{off}");
    assert!(farthest(&here, &played(&folder, None)) > 0.05);
    let mut again = opened(&folder, [900.0, 700.0]);
    open(&mut again, &[edit]);
    seek(&mut again, FRAME);
    for (found, expected) in document(&again).handles(true).into_iter().zip(dragged) {
        assert!(distance(found, expected) < 1e-4, "{found:?}, {expected:?}");
    }
}
