//! Files that are opened, including broken ones, and files that are saved.

use super::*;
use rhytid_formats::{mesh, take};

#[test]
fn nothing_is_open_at_first_and_keys_do_no_harm() {
    let mut view = window([900.0, 700.0], false);
    view.run();
    view.get_by_label("Face: no face is open");
    for key in [
        egui::Key::Space,
        egui::Key::N,
        egui::Key::P,
        egui::Key::R,
        egui::Key::Enter,
        egui::Key::F2,
        egui::Key::S,
    ] {
        view.key_press(key);
        view.run();
    }
    drag(&mut view, egui::pos2(100.0, 100.0), egui::pos2(300.0, 200.0), Modifiers::NONE);
    assert_eq!(view.state().note(), None);
}

#[test]
fn the_empty_window_shows_what_to_do_and_opens_files() {
    let folder = Folder::new();
    let kept = folder.path("recent.txt");
    let recent = kept.clone();
    let mut view = window_of([900.0, 700.0], true, |app| app.with_recent_files(recent));
    view.run();
    view.get_by_label("Open a rig");
    // Where no dialog can be had, that is one sentence. Where one opens, nobody answers it here.
    open(&mut view, &[folder.path("FACE.safetensors"), folder.path("take.csv")]);
    let names = std::fs::read_to_string(&kept).unwrap();
    let newest_first = ["take.csv", "FACE.safetensors"].map(|name| folder.path(name).display().to_string());
    assert_eq!(names.lines().collect::<Vec<_>>(), newest_first);
    // The next window offers them.
    let mut view = window_of([900.0, 700.0], true, |app| app.with_whole_pictures().with_recent_files(kept));
    view.run();
    view.get_by_label("Recent").click();
    view.run();
    view.get_by_label("FACE.safetensors").click();
    view.run();
    while view.state().is_opening() {
        view.step();
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    view.run();
    assert_eq!(document(&view).rig.vertices(), demo().1.vertices());
}

#[test]
fn a_file_that_hovers_is_named() {
    let mut view = window([900.0, 700.0], true);
    view.run();
    let before = view.render().unwrap();
    let file = egui::HoveredFile { path: Some("somewhere/face.safetensors".into()), ..Default::default() };
    view.input_mut().hovered_files = vec![file];
    view.step();
    let hovering = view.render().unwrap();
    let edge = |picture: &image::RgbaImage| picture.get_pixel(450, 6).0;
    let [r, g, b, _] = edge(&hovering);
    assert!(r > 200 && g < 160 && b < 80, "an orange rim: {:?}, before {:?}", edge(&hovering), edge(&before));
    view.input_mut().hovered_files.clear();
    view.run();
    assert_eq!(edge(&view.render().unwrap()), edge(&before));
}

#[test]
fn a_project_is_solved_for_the_window() {
    let folder = Folder::new();
    let face = &demo().0;
    mesh::write_obj(&folder.path("neutral.obj"), &face.neutral).unwrap();
    rhytid_formats::tables::write_handles(&folder.path("markers.csv"), &face.handles, None).unwrap();
    let text = "[mesh]\nneutral = \"neutral.obj\"\nunits = \"cm\"\nup = \"y\"\n[handles]\nvertices = \"markers.csv\"\n";
    std::fs::write(folder.path("face.toml"), text).unwrap();
    let mut view = window([900.0, 700.0], true);
    open(&mut view, &[folder.path("take.csv"), folder.path("face.toml")]);
    assert_eq!(view.state().note(), None);
    assert_eq!(document(&view).rig.vertices(), demo().1.vertices());
    assert_eq!(document(&view).rig.handles().labels, demo().1.handles().labels);
    assert!(document(&view).take().is_some(), "the take is for the solved rig");
    let words = view.state().warnings().join(" ");
    assert!(words.contains("face.toml: was solved for this window alone"), "{words}");
}

#[test]
fn broken_files_are_a_sentence_and_what_was_open_stays() {
    let folder = Folder::new();
    let mut view = stand(window([900.0, 700.0], true), &folder);
    let huge = folder.path("huge.safetensors");
    // A sparse file of a terabyte.
    std::fs::File::create(&huge).unwrap().set_len(1 << 40).unwrap();
    std::fs::write(folder.path("empty.safetensors"), b"").unwrap();
    std::fs::write(folder.path("cut.safetensors"), &rig_file::encode(&demo().1).unwrap()[..5_000]).unwrap();
    std::fs::write(folder.path("words.csv"), b"time,a_x,a_y,a_z\n0,one,two,three\n").unwrap();
    std::fs::write(folder.path("picture.png"), b"\x89PNG").unwrap();
    for name in
        ["huge.safetensors", "empty.safetensors", "cut.safetensors", "words.csv", "picture.png", "none.csv"]
    {
        open(&mut view, &[folder.path(name)]);
        let (words, is_error) = view.state().note().expect(name);
        assert!(is_error && words.contains(name), "{name}: {words}");
        view.step();
        view.get_by_label("Close").click();
        view.run();
        assert_eq!(view.state().note(), None);
        assert_eq!(document(&view).rig.vertices(), demo().1.vertices(), "what was open stays");
    }
}

#[test]
fn a_frame_is_saved_as_a_take_and_as_an_example() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let handle = handle_in_front(&view);
    let from = at(&view, handle);
    drag(&mut view, from, from + egui::vec2(20.0, 0.0), Modifiers::NONE);
    view.key_press_modifiers(Modifiers::COMMAND, egui::Key::S);
    view.run();
    let saved = folder.path("FACE-pose-0001.csv");
    assert_eq!(view.state().note(), Some((&*format!("saved {}", saved.display()), false)));
    let read = take::read(&saved, None, take::Missing::Error).unwrap();
    let handles = document(&view).handles(true);
    assert_eq!(read.handle_positions(&demo().1.handles().labels).unwrap(), handles.as_flattened());
    view.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, egui::Key::S);
    view.run();
    let read = mesh::read(&folder.path("FACE-pose-0001.obj")).unwrap();
    assert_eq!(read.faces, demo().1.surface().faces);
    // The mesh's handles are at the positions of the pose.
    for (point, p) in demo().1.handles().points.iter().zip(&handles) {
        let q = point.at(&read.positions).map(|x| x as f32);
        assert!(distance(q, *p) < 1e-4, "{q:?} instead of {p:?}");
    }
    // The next file has the next number, and no file is overwritten.
    view.key_press_modifiers(Modifiers::COMMAND, egui::Key::S);
    view.run();
    assert!(folder.path("FACE-pose-0002.csv").exists());
    view.key_press(egui::Key::S);
    view.run();
    assert!(folder.path("FACE-view-0001.png").exists());
}

#[test]
fn numbers_of_a_file_are_a_heat_map_until_another_rig_is_opened() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let rig = &demo().1;
    let positions = rig.surface().rest.iter().map(|x| x.map(f64::from)).collect();
    let rest = mesh::read(&{
        let path = folder.path("rest.obj");
        let faces = rig.surface().faces.clone();
        mesh::write_obj(&path, &rhytid_core::Mesh { positions, faces, ..rhytid_core::Mesh::default() })
            .unwrap();
        path
    })
    .unwrap();
    let left: Vec<f32> = rig.surface().rest.iter().map(|x| x[0].max(0.0)).collect();
    let signed: Vec<f32> = rig.surface().rest.iter().map(|x| x[1]).collect();
    mesh::write_numbers(&folder.path("maps.ply"), &rest, &[("left", &left), ("height", &signed)]).unwrap();
    open(&mut view, &[folder.path("maps.ply")]);
    view.run();
    assert_eq!(view.state().note(), None);
    assert_eq!(view.state_mut().settings_mut().show, rhytid_view::Show::Numbers);
    // One half has the colour of 0 everywhere, and the other has not.
    let picture = view.render().unwrap();
    let place = face(&view);
    let row = (place.center().y - 20.0) as u32;
    let reds = |from: f32, to: f32| {
        let pixels = (from as u32..to as u32).map(|x| picture.get_pixel(x, row).0);
        pixels.filter(|[r, ..]| *r > 70).count()
    };
    let middle = place.center().x;
    let (right_half, left_half) = (reds(place.left(), middle - 25.0), reds(middle + 25.0, place.right()));
    assert!(left_half > right_half + 20, "{left_half} bright pixels beside {right_half}");
    open(&mut view, &[folder.path("FACE.safetensors")]);
    assert_eq!(view.state_mut().settings_mut().show, rhytid_view::Show::Shaded);
    let other = rhytid_core::Mesh {
        positions: rest.positions.clone(),
        faces: rest.faces.clone(),
        ..rhytid_core::Mesh::default()
    };
    mesh::write_numbers(&folder.path("none.ply"), &other, &[]).unwrap();
    open(&mut view, &[folder.path("none.ply")]);
    let (words, is_error) = view.state().note().unwrap();
    assert!(is_error && words.contains("none.ply: its vertices have no numbers"), "{words}");
}

#[test]
fn a_take_in_another_unit_is_refused_and_a_noisy_one_is_warned_of() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let take = rhytid_demo::performance(&demo().0);
    let mut metres = take.clone();
    metres.positions.iter_mut().flatten().for_each(|x| *x *= 0.01);
    take::write(&folder.path("metres.csv"), &metres).unwrap();
    open(&mut view, &[folder.path("metres.csv")]);
    let (words, is_error) = view.state().note().unwrap();
    assert!(is_error && words.contains("metres.csv: no frame is near the rest pose"), "{words}");
    assert!(words.contains(" in m"), "{words}");
    assert_eq!(document(&view).take().unwrap().take, take, "the take before stays");
    // A button reads it as it was meant.
    view.run();
    view.get_by_label("Read it in m").click();
    view.step();
    while view.state().is_opening() {
        view.step();
    }
    assert_eq!(view.state().note(), None);
    let read = document(&view).take().unwrap();
    assert!(read.name.ends_with("metres.csv"));
    let pairs = read.take.positions.as_flattened().iter().zip(take.positions.as_flattened());
    assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 1e-5), "its metres are the rig's centimetres");
    // Half a millimetre up and down in every frame.
    let mut noisy = take;
    for (i, x) in noisy.positions.iter_mut().flatten().enumerate() {
        // Mixed bits are as good as random.
        let mut bits = i as u32;
        for _ in 0..3 {
            bits = (bits ^ (bits >> 16)).wrapping_mul(0x045d_9f3b);
        }
        *x += if bits >> 31 == 0 { 0.05 } else { -0.05 };
    }
    take::write(&folder.path("noisy.csv"), &noisy).unwrap();
    open(&mut view, &[folder.path("noisy.csv")]);
    let warnings = view.state().warnings();
    assert!(warnings.iter().any(|words| words.contains("mm of noise per axis")), "{warnings:?}");
    // The next file has no warning.
    open(&mut view, &[folder.path("take.csv")]);
    assert!(view.state().warnings().is_empty(), "{:?}", view.state().warnings());
}
