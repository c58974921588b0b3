//! Work that takes long: the window goes on, says what is happening, and can stop it.

use super::*;
use rhytid_core::{Progress, Warning};
use rhytid_formats::mesh;
use rhytid_view::Show;
use std::fmt::Write;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// The longest wait, on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// A window for people, which does not wait for pictures.
fn impatient(folder: &Folder) -> View {
    let mut view = window_of([700.0, 560.0], false, |app| app);
    open(&mut view, &[folder.path("FACE.safetensors"), folder.path("take.csv")]);
    view.key_press(egui::Key::Space);
    view.step();
    view.key_press(egui::Key::Home);
    rest(&mut view);
    view
}

/// Steps until `what` is true.
fn until(view: &mut View, what: &str, is_so: impl Fn(&View) -> bool) {
    let begin = Instant::now();
    while !is_so(view) {
        assert!(begin.elapsed() < PATIENCE, "{what}: waited for nothing");
        view.step();
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Steps until the picture is drawn in full.
fn rest(view: &mut View) {
    view.step();
    until(view, "a whole picture", |view| !view.state().is_drawing());
}

#[test]
fn skin_keeps_its_light_while_a_marker_is_dragged_and_is_lit_at_rest() {
    let folder = Folder::new();
    let mut view = impatient(&folder);
    view.state_mut().settings_mut().show = Show::Skin;
    rest(&mut view);
    let (whole, _) = view.state().times().unwrap();
    if whole.evaluation + whole.lighting + whole.drawing < Duration::from_millis(60) {
        rhytid_test_support::skip("this device lights skin so fast that it is never drawn coarsely");
        return;
    }
    let still = view.render().unwrap();
    let handle = handle_in_front(&view);
    let from = at(&view, handle);
    button(&mut view, from, PointerButton::Primary, true, Modifiers::NONE);
    view.step();
    let (mut coarse, mut step, begin) = (0, 0, Instant::now());
    while coarse < 5 {
        assert!(begin.elapsed() < PATIENCE, "no picture is drawn without new light");
        let drawn = view.state().times().unwrap().1;
        step += 1;
        view.hover_at(from + egui::vec2(0.5 * (step % 40) as f32, 0.0));
        view.step();
        std::thread::sleep(Duration::from_millis(5));
        let (times, now) = view.state().times().unwrap();
        coarse += usize::from(now > drawn && times.lighting < whole.lighting / 4);
    }
    assert!(view.state().is_drawing(), "what is shown while it moves is not the last word");
    button(&mut view, from + egui::vec2(19.5, 0.0), PointerButton::Primary, false, Modifiers::NONE);
    rest(&mut view);
    let (last, _) = view.state().times().unwrap();
    assert!(last.lighting > whole.lighting / 4, "at rest it is lit: {last:?}, first {whole:?}");
    // What is shown at rest is what a window shows that waits for each picture.
    let mut patient = opened(&folder, [700.0, 560.0]);
    patient.state_mut().settings_mut().show = Show::Skin;
    patient.run();
    let expected = patient.render().unwrap();
    let place = face(&view);
    let inside = |x: u32, y: u32| place.shrink(2.0).contains(egui::pos2(x as f32, y as f32));
    let differ = |a: &image::RgbaImage, b: &image::RgbaImage| {
        let pixels = a.enumerate_pixels().filter(|(x, y, _)| inside(*x, *y));
        let off = |(x, y, p): &(u32, u32, &image::Rgba<u8>)| {
            (0..3).any(|c| p.0[c].abs_diff(b.get_pixel(*x, *y).0[c]) > 3)
        };
        pixels.filter(off).count()
    };
    assert_eq!(differ(&still, &expected), 0, "the picture before the drag");
    assert!(differ(&view.render().unwrap(), &expected) > 100, "the marker was moved");
}

#[test]
fn long_work_is_said_and_stopped() {
    let folder = Folder::new();
    let mut view = impatient(&folder);
    // A table without an end, which is read until it is stopped.
    let pipe = folder.path("endless.csv");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    if !made.is_ok_and(|status| status.success()) {
        rhytid_test_support::skip("there are no named pipes here");
        return;
    }
    view.state_mut().open_paths(std::slice::from_ref(&pipe));
    until(&mut view, "the words", |view| view.query_by_label_contains("reading").is_some());
    assert!(view.query_by_label_contains("endless.csv").is_some());
    // The face is there, and it can be turned in the meantime.
    let orbit = view.state().orbit().unwrap().clone();
    let beside = face(&view).left_bottom() + egui::vec2(15.0, -15.0);
    drag(&mut view, beside, beside + egui::vec2(60.0, 0.0), Modifiers::NONE);
    assert_ne!(*view.state().orbit().unwrap(), orbit);
    view.get_by_label("Stop").click();
    view.step();
    view.step();
    assert!(!view.state().is_opening());
    assert_eq!(view.state().note(), None);
    // The thread that waits for the pipe ends with it.
    drop(std::fs::OpenOptions::new().write(true).open(&pipe));
}

#[test]
fn preparing_skin_is_stopped_by_showing_something_else() {
    let folder = Folder::new();
    let mut view = impatient(&folder);
    view.state_mut().settings_mut().show = Show::Skin;
    view.step();
    view.key_press(egui::Key::F1);
    rest(&mut view);
    assert_eq!(view.state().times().unwrap().0.lighting, Duration::ZERO);
    view.key_press(egui::Key::F2);
    rest(&mut view);
    assert_ne!(view.state().times().unwrap().0.lighting, Duration::ZERO, "skin is lit after all");
}

/// The demo's performance in millimetres, with labels that the rig does not know.
pub(super) fn nameless() -> String {
    let take = rhytid_demo::performance(&demo().0);
    let (frames, markers) = (take.frames(), take.labels.len());
    let labels: String = (0..markers).map(|j| format!("\tx{j}\t\t")).collect();
    let mut text = format!(
        "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n30\t{frames}\t{markers}\tmm\n\
         Frame#\tTime{labels}\n"
    );
    let millimetres = 1e3 * demo().1.surface().metres_per_unit;
    for (f, row) in take.positions.chunks_exact(markers).enumerate() {
        write!(text, "{}\t{:.6}", f + 1, f as f64 / 30.0).unwrap();
        for x in row.as_flattened() {
            write!(text, "\t{:.5}", millimetres * x).unwrap();
        }
        text.push('\n');
    }
    text
}

/// The warnings of a clean-up, as a program would print them.
#[derive(Default)]
struct Printed(Mutex<Vec<String>>);

impl Progress for Printed {
    fn report(&self, _: &'static str, _: u64, _: u64) {}

    fn warn(&self, warning: &Warning) {
        self.0.lock().unwrap().push(warning.to_string());
    }
}

#[test]
fn a_raw_take_is_cleaned_beside_the_face_and_its_warnings_are_shown() {
    let folder = Folder::new();
    let raw = folder.path("nameless.trc");
    std::fs::write(&raw, nameless()).unwrap();
    let printed = Printed::default();
    let clean_up = rhytid_playback::CleanUp::default();
    let (cleaned, _) = rhytid_playback::read_raw_take(&raw, &demo().1, &clean_up, &printed).unwrap();
    let printed = printed.0.into_inner().unwrap();
    assert!(printed.iter().any(|words| words.contains("were matched by position")), "{printed:?}");

    let mut view = window_of([900.0, 900.0], true, |app| app);
    view.state_mut().open_paths(&[folder.path("FACE.safetensors"), raw]);
    let begin = Instant::now();
    let mut alone = false;
    while view.state().is_opening() {
        assert!(begin.elapsed() < PATIENCE);
        view.step();
        let shown = view.state().document().filter(|_| view.state().is_opening());
        alone |= shown.is_some_and(|document| document.take().is_none());
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(alone, "the face is shown before its take is clean");
    assert_eq!(document(&view).take().unwrap().take, cleaned.take);
    assert_eq!((view.state().note(), view.state().warnings()), (None, &printed[..]));
    view.step();
    for words in &printed {
        view.get_by_label(&format!("Warning: {words}"));
    }
    view.get_by_label("Close the warnings").click();
    view.step();
    view.step();
    assert!(view.query_by_label_contains("Warning:").is_none());
}

#[test]
fn a_file_of_another_kind_is_named() {
    let folder = Folder::new();
    let mesh =
        document(&opened(&folder, [400.0, 400.0])).frame_as_mesh(demo().1.surface().rest.as_flattened());
    mesh::write_obj(&folder.path("neutral.obj"), &mesh).unwrap();
    let mut view = window([900.0, 700.0], true);
    for (name, words) in [
        ("take.csv", "take.csv: is a take, expected a rig; open a rig first"),
        ("nowhere.csv", "nowhere.csv: no such file"),
    ] {
        open(&mut view, &[folder.path(name)]);
        let (said, is_error) = view.state().note().unwrap();
        assert!(is_error && said.contains(words), "{said}");
    }
    open(&mut view, &[folder.path("FACE.safetensors"), folder.path("neutral.obj")]);
    let (said, is_error) = view.state().note().unwrap();
    assert!(is_error && said.contains("neutral.obj: is a mesh, expected a take"), "{said}");
    assert!(view.state().document().is_some(), "the rig is open all the same");
}
