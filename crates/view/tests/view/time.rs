//! The play head.

use super::*;
use rhytid_view::Repeat;

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
    const SHIFT: Modifiers = Modifiers::SHIFT;
    const NONE: Modifiers = Modifiers::NONE;
    for (modifiers, key, expected) in [
        (NONE, egui::Key::ArrowRight, here + 1),
        (NONE, egui::Key::ArrowLeft, here),
        (NONE, egui::Key::Period, here + 1),
        (NONE, egui::Key::Comma, here),
        (SHIFT, egui::Key::ArrowRight, here + 10),
        (SHIFT, egui::Key::ArrowLeft, here),
        (NONE, egui::Key::Home, 0),
        (NONE, egui::Key::ArrowLeft, 0),
        (NONE, egui::Key::End, frames - 1),
        (SHIFT, egui::Key::ArrowRight, frames - 1),
    ] {
        view.key_press_modifiers(modifiers, key);
        view.run();
        assert_eq!(frame(&view), expected, "{modifiers:?} {key:?}");
    }
}

#[test]
fn the_face_is_turned_by_keys_and_no_frame_passes() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let front = view.state().orbit().unwrap().axes()[2];
    view.key_press_modifiers(Modifiers::COMMAND, egui::Key::ArrowRight);
    view.run();
    let turned = view.state().orbit().unwrap().axes()[2];
    assert!(turned.x < front.x - 0.02, "{turned} after {front}");
    view.key_press_modifiers(Modifiers::COMMAND, egui::Key::ArrowUp);
    view.run();
    assert!(view.state().orbit().unwrap().axes()[2].y < turned.y - 0.02);
    assert_eq!(frame(&view), 0);
}

#[test]
fn a_range_is_set_by_keys_and_by_its_handles_and_alone_is_played() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let last = document(&view).transport.frames() - 1;
    let range = |view: &View| document(view).transport.range();
    for (to, key) in [(40, egui::Key::I), (60, egui::Key::O)] {
        seek(&mut view, to);
        view.key_press(key);
        view.run();
    }
    let [begin, end] = range(&view);
    assert!(begin.abs_diff(40) <= 1 && end.abs_diff(60) <= 1, "{begin} to {end}");
    view.key_press(egui::Key::Space);
    let mut seen = Vec::new();
    for _ in 0..200 {
        view.step();
        seen.push(frame(&view));
    }
    let back = seen.windows(2).filter(|pair| pair[1] < pair[0]).count();
    assert!(seen.iter().all(|frame| (begin..=end).contains(frame)) && back > 1, "{seen:?}");
    view.key_press(egui::Key::Space);
    view.run();
    // The handle of the end is dragged to the take's end, and that of the beginning past it.
    let grip = |view: &View, name: &str| view.get_by_label(name).rect().center();
    let to = on_strip(&view, last);
    let from = grip(&view, "End of the range");
    drag(&mut view, from, egui::pos2(to.x, from.y), Modifiers::NONE);
    view.run();
    assert_eq!(range(&view), [begin, last]);
    let from = grip(&view, "Begin of the range");
    drag(&mut view, from, egui::pos2(to.x + 30.0, from.y), Modifiers::NONE);
    view.run();
    assert_eq!(range(&view), [last, last], "it stops at the other one");
    view.key_press(egui::Key::U);
    view.run();
    assert!(document(&view).transport.plays_all());
    // Repeat has three ways.
    let ways: Vec<Repeat> = (0..3)
        .map(|_| {
            view.key_press(egui::Key::L);
            view.run();
            document(&view).transport.repeat
        })
        .collect();
    assert_eq!(ways, [Repeat::PingPong, Repeat::Once, Repeat::Loop]);
}

/// A take in which two markers are in doubt for a while, and one is so in all frames.
fn doubtful(folder: &Folder) -> PathBuf {
    let mut take = rhytid_demo::performance(&demo().0);
    let markers = take.labels.len();
    let mut confidence = vec![0.7; take.positions.len()];
    for (marker, frames) in [(2, 50..60), (5, 120..121), (7, 0..take.times.len())] {
        frames.for_each(|frame| confidence[frame * markers + marker] = 0.25);
    }
    take.confidence = Some(confidence);
    let path = folder.path("doubtful.csv");
    rhytid_formats::take::write(&path, &take).unwrap();
    path
}

/// The yellow columns of pixels in the time line.
fn yellow(view: &mut View) -> Vec<u32> {
    let strip = view.get_by_label("Time line").rect();
    let picture = view.render().unwrap();
    let is_yellow = |x: u32, y: u32| {
        let [r, g, b, _] = picture.get_pixel(x, y).0;
        r > 190 && g > 170 && b < 90
    };
    // Below the numbers.
    let rows = strip.bottom() as u32 - 22..strip.bottom() as u32 - 12;
    let columns = strip.left() as u32..strip.right() as u32;
    columns.filter(|x| rows.clone().filter(|y| is_yellow(*x, *y)).count() > 3).collect()
}

#[test]
fn events_are_coloured_listed_and_led_to() {
    let folder = Folder::new();
    let mut view = opened(&folder, [1280.0, 800.0]);
    view.get_by_label("Events (0)");
    assert_eq!(yellow(&mut view).len(), 0, "a clean take has no colour");
    open(&mut view, &[doubtful(&folder)]);
    view.key_press(egui::Key::Space);
    view.key_press(egui::Key::Home);
    view.run();
    view.get_by_label("in doubt (confidence below 0.5)");
    // Only the two stretches have a colour: neither 0.7, nor what is low in all frames.
    let seen = yellow(&mut view);
    let [a, b, c] = [50, 59, 120].map(|frame| on_strip(&view, frame).x);
    let is_right = |x: &u32| (a - 4.0..b + 4.0).contains(&(*x as f32)) || (*x as f32 - c).abs() < 5.0;
    assert!(seen.iter().all(is_right) && seen.len() as f32 >= b - a, "{a} to {b} and {c}: {seen:?}");
    // The keys lead through the events.
    for (key, expected) in [
        (egui::Key::PageDown, 50),
        (egui::Key::PageDown, 120),
        (egui::Key::PageDown, 120),
        (egui::Key::PageUp, 50),
    ] {
        view.key_press(key);
        view.run();
        assert_eq!(frame(&view), expected);
    }
    // Words appear at the pointer.
    let labels = &demo().1.handles().labels;
    let over = on_strip(&view, 120);
    view.hover_at(over + egui::vec2(0.0, 18.0));
    view.run_steps(60);
    let words = format!("120: in doubt: {}, confidence 0.2", labels[5]);
    view.get_by_label_contains(&words);
    view.hover_at(egui::pos2(300.0, 200.0));
    view.run();
    // The list leads to an event, too. What lasts as long as the take is said first.
    view.get_by_label("Events (3)").click();
    view.run();
    view.get_by_label(&format!("whole take: in doubt: {}, confidence 0.2", labels[7]));
    view.get_by_label(&words).click();
    view.run();
    assert_eq!(frame(&view), 120);
    view.key_press(egui::Key::E);
    view.run();
    assert!(view.query_by_label(&words).is_none(), "the key closes the list");
}

/// A raw take in which one marker is missing for a moment, and another one for long.
fn gappy(folder: &Folder) -> PathBuf {
    let mut text = String::new();
    for line in slow::nameless().lines() {
        let mut fields: Vec<&str> = line.split('\t').collect();
        let frame = fields[0].parse::<usize>().unwrap_or_default();
        // Frames of the file count from 1. Each marker has three fields, behind the frame and the time.
        for (marker, frames) in [(3, 41..=43), (8, 81..=180)] {
            if frames.contains(&frame) {
                fields[2 + 3 * marker..5 + 3 * marker].fill("");
            }
        }
        text += &(fields.join("\t") + "\n");
    }
    let path = folder.path("gappy.trc");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn filled_gaps_are_listed_and_only_a_lost_marker_stands_out() {
    let folder = Folder::new();
    let mut view = window([1280.0, 900.0], true);
    open(&mut view, &[folder.path("FACE.safetensors"), gappy(&folder)]);
    view.key_press(egui::Key::Space);
    view.key_press(egui::Key::Home);
    view.run();
    let labels = &demo().1.handles().labels;
    view.get_by_label("gap filled");
    // Orange where the marker is lost, and nowhere else. The short gap is a thin line.
    let [a, b] = [80, 179].map(|frame| on_strip(&view, frame).x);
    let seen = yellow(&mut view);
    assert!(seen.iter().all(|x| (a - 4.0..b + 4.0).contains(&(*x as f32))), "{a} to {b}: {seen:?}");
    assert!(seen.len() as f32 > b - a - 4.0, "{a} to {b}: {seen:?}");
    // The keys pass over the short gap. The list has it.
    view.key_press(egui::Key::PageDown);
    view.run();
    assert_eq!(frame(&view), 80);
    view.key_press(egui::Key::E);
    view.run();
    view.get_by_label_contains(&format!("gap filled, spline: {}", labels[3])).click();
    view.run();
    assert_eq!(frame(&view), 40);
    view.get_by_label_contains(&format!("lost: {}", labels[8]));
}

#[test]
fn edits_of_a_file_are_events_with_their_frames() {
    let folder = Folder::new();
    let mut view = opened(&folder, [1280.0, 800.0]);
    let text = "[[gain]]\nby = [[30, 1], [40, 1.2], [50, 1]]\n[[hold]]\nframes = \"70..80\"\n";
    std::fs::write(folder.path("EDIT.toml"), text).unwrap();
    open(&mut view, &[folder.path("EDIT.toml")]);
    view.key_press(egui::Key::E);
    view.run();
    view.get_by_label("31 to 49: [[gain]]");
    view.get_by_label("70 to 79: [[hold]]").click();
    view.run();
    assert_eq!(frame(&view), 70);
}

#[test]
fn the_time_line_is_of_use_in_narrow_and_wide_windows_on_any_screen() {
    let folder = Folder::new();
    let doubtful = doubtful(&folder);
    for (size, scale) in [([400.0, 700.0], 1.0), ([400.0, 700.0], 2.0), ([1280.0, 800.0], 2.0)] {
        let mut view = window_on(scale, size, false, ViewApp::with_whole_pictures);
        open(&mut view, &[folder.path("FACE.safetensors"), doubtful.clone()]);
        view.key_press(egui::Key::Space);
        view.run();
        let room = Rect::from_min_size(Pos2::ZERO, size.into());
        for name in
            ["Play", "Frame", "Events (3)", "Event after", "in doubt (confidence below 0.5)", "Time line"]
        {
            let found: Vec<Rect> = view.get_all_by_label(name).map(|node| node.rect()).collect();
            assert!(found.iter().all(|rect| room.contains_rect(*rect)), "{size:?}: {name} at {found:?}");
        }
        // A click at a frame's place shows that frame, also with a finger's width to the next one.
        seek(&mut view, 100);
        view.get_by_label("Event after").click();
        view.run();
        assert_eq!(frame(&view), 120);
        assert!(face(&view).height() > 0.5 * size[1], "the face has most of the room");
    }
}
