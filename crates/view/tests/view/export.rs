//! Exports from the window: takes with edits and pulls, and films.

use super::*;
use rhytid_devices::{Guard, choose_devices};
use rhytid_formats::animation::{self, Format};
use rhytid_formats::{Reach, take};
use rhytid_playback::{Layers, Performance, verify};
use std::time::{Duration, Instant};

/// A window with a pull at some frames.
fn pulled(folder: &Folder) -> View {
    // The panel is long.
    let mut view = opened(folder, [800.0, 1200.0]);
    seek(&mut view, 90);
    view.get_by_label("at this frame").click();
    view.run();
    let from = at(&view, handle_in_front(&view));
    drag(&mut view, from, from + egui::vec2(20.0, 10.0), Modifiers::NONE);
    view.run();
    view
}

/// Presses a button in the section of files.
fn press(view: &mut View, words: &str) {
    if view.query_by_label(words).is_none() {
        view.get_all_by_label("Save").next().unwrap().click();
        view.run();
    }
    view.get_by_label(words).click();
    view.step();
}

fn finish(view: &mut View) {
    let begin = Instant::now();
    while view.state().is_exporting() {
        assert!(begin.elapsed() < Duration::from_secs(300), "the export never ends");
        view.step();
        std::thread::sleep(Duration::from_millis(5));
    }
    view.run();
}

fn saved(folder: &Folder, name: &str) -> Option<(String, bool)> {
    Some((format!("saved {}", folder.path(name).display()), false))
}

fn note(view: &View) -> Option<(String, bool)> {
    view.state().note().map(|(words, is_error)| (words.to_owned(), is_error))
}

/// Whether a file is what the take with these edits gives, and how many frames were compared.
fn verified(folder: &Folder, name: &str, edit: Option<&str>) -> (bool, usize) {
    let rig = &demo().1;
    let path = folder.path(name);
    let mut reader = animation::open(&path).unwrap();
    let layers = edit.map(|edit| Layers::read(&folder.path(edit), rig, Reach::Below).unwrap());
    let take = take::read(&folder.path("take.csv"), None, take::Missing::Hold).unwrap();
    let recipe = reader.summary().recipe.as_ref().expect("the file has its recipe").recipe().unwrap();
    // The program compares these hashes before it verifies a file.
    assert_eq!(recipe.rig, rig_file::hash(&folder.path("FACE.safetensors")).unwrap());
    if let Some(layers) = &layers {
        assert_eq!(recipe.edit_hash.as_deref(), Some(layers.hash()));
    }
    let performance = Performance::new(recipe, rig.clone(), take, layers).unwrap();
    let devices = choose_devices("cpu:0", Guard::NONE, &NoProgress).unwrap().devices;
    let mut playback = performance.playback(&devices, &NoProgress).unwrap();
    let format = Format::from_extension(&path).unwrap();
    let found = verify(&mut *reader, format, &performance, &mut playback, &NoProgress).unwrap();
    (found.passed(), found.frames)
}

#[test]
fn the_exported_take_is_what_animate_makes_of_the_saved_edit() {
    let folder = Folder::new();
    let mut view = pulled(&folder);
    view.key_press_modifiers(Modifiers::COMMAND, egui::Key::E);
    view.run();
    let frames = document(&view).transport.frames();
    press(&mut view, "The take with edits, as USD");
    finish(&mut view);
    assert_eq!(note(&view), saved(&folder, "FACE-take-0001.usdc"));
    assert_eq!(verified(&folder, "FACE-take-0001.usdc", Some("FACE-edit-0001.toml")), (true, frames));
    assert!(!verified(&folder, "FACE-take-0001.usdc", None).0, "it has the pull");
    // Only the range is written, beside the first file.
    seek(&mut view, 80);
    view.key_press(egui::Key::I);
    seek(&mut view, 99);
    view.key_press(egui::Key::O);
    view.run();
    let [first, last] = document(&view).transport.range();
    for (words, name) in [
        ("The take with edits, as USD", "FACE-take-0002.usdc"),
        ("The take with edits, as GLB", "FACE-take-0001.glb"),
    ] {
        press(&mut view, words);
        finish(&mut view);
        assert_eq!(note(&view), saved(&folder, name));
        assert_eq!(verified(&folder, name, Some("FACE-edit-0001.toml")), (true, last + 1 - first));
    }
}

#[test]
fn an_export_that_is_stopped_leaves_nothing() {
    let folder = Folder::new();
    // A take that nobody exports in the time before the button is shown.
    let mut take = rhytid_demo::performance(&demo().0);
    let (once, step) = (take.clone(), 1.0 / take.rate());
    for _ in 0..40 {
        let start = take.times[take.frames() - 1] + step;
        take.times.extend(once.times.iter().map(|time| start + time - once.times[0]));
        take.positions.extend(&once.positions);
    }
    take::write(&folder.path("take.csv"), &take).unwrap();
    let mut view = pulled(&folder);
    for words in ["The take with edits, as USD", "A film of what is seen"] {
        press(&mut view, words);
        let begin = Instant::now();
        while view.query_by_label("Stop").is_none() && view.state().is_exporting() {
            assert!(begin.elapsed() < Duration::from_secs(60));
            view.step();
        }
        assert!(view.state().is_exporting(), "it was done before anybody could stop it");
        view.get_by_label("Stop").click();
        view.step();
        finish(&mut view);
        assert_eq!(note(&view), Some(("the export was stopped; nothing was written".to_owned(), false)));
    }
    let mut names: Vec<String> = std::fs::read_dir(folder.path("."))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(names, ["FACE.safetensors", "take.csv"]);
    // The window goes on as before.
    assert_eq!(document(&view).pose().pulls.len(), 1);
}

#[test]
fn a_film_shows_the_pictures_of_the_window() {
    let folder = Folder::new();
    let mut view = pulled(&folder);
    for (frame, key) in [(86, egui::Key::I), (92, egui::Key::O)] {
        seek(&mut view, frame);
        view.key_press(key);
        view.run();
    }
    let [first, last] = document(&view).transport.range();
    press(&mut view, "A film of what is seen");
    // The play head and the camera may move meanwhile. The film shows what was seen when it began.
    view.key_press(egui::Key::Home);
    finish(&mut view);
    let film = folder.path("FACE-film-0001.webp");
    if !film.exists() {
        // Built with the program, films are AV1.
        assert_eq!(note(&view), saved(&folder, "FACE-film-0001.mp4"));
        return;
    }
    let file = std::io::BufReader::new(std::fs::File::open(film).unwrap());
    let mut film = image_webp::WebPDecoder::new(file).unwrap();
    assert_eq!(film.num_frames() as usize, last + 1 - first);
    let (width, height) = film.dimensions();
    // The line of the message makes the face smaller.
    let close = |view: &mut View| {
        view.get_by_label("Close").click();
        view.run();
    };
    close(&mut view);
    assert_eq!(view.state().picture_size(), Some([width, height]));
    let mut picture = vec![0; film.output_buffer_size().unwrap()];
    for (number, frame) in (1..).zip(first..=last) {
        film.read_frame(&mut picture).unwrap();
        if frame % 3 != 0 {
            continue;
        }
        while document(&view).transport.frame() != frame {
            view.key_press(egui::Key::ArrowRight);
            view.step();
        }
        view.run();
        let saved = (1..=number).rev().map(|i| folder.path(&format!("FACE-view-{i:04}.png")));
        view.key_press(egui::Key::S);
        view.run();
        close(&mut view);
        let png = saved.into_iter().find(|path| path.exists()).expect("the picture is saved");
        let png = image::open(png).unwrap().to_rgba8();
        let bytes = picture.len() / (width * height) as usize;
        for (i, pixel) in picture.chunks_exact(bytes).enumerate() {
            let other = png.get_pixel(i as u32 % width, i as u32 / width).0;
            assert_eq!(pixel[..3], other[..3], "frame {frame}, pixel {i}");
        }
    }
}

#[test]
fn without_a_take_nothing_is_exported() {
    let folder = Folder::new();
    let mut view = window([900.0, 900.0], false);
    open(&mut view, &[folder.path("FACE.safetensors")]);
    view.run();
    press(&mut view, "A film of what is seen");
    assert!(!view.state().is_exporting());
    assert_eq!(view.state().note(), None);
}
