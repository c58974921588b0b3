//! The actions of the pointer and the keys on markers and on the camera.

use super::*;
use rhytid_view::Before;

const NONE: Modifiers = Modifiers::NONE;

#[test]
fn a_marker_follows_the_pointer_and_is_undone() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let handle = handle_in_front(&view);
    let before = document(&view).handles(true);
    let (from, drawn) = (at(&view, handle), view.state().times().unwrap().1);
    let to = from + egui::vec2(24.0, -31.0);
    drag(&mut view, from, to, NONE);
    assert!(at(&view, handle).distance(to) < 1.0, "{:?} instead of {to:?}", at(&view, handle));
    assert_eq!(view.state().selected(), [handle]);
    let after = document(&view).handles(true);
    let moved = (0..after.len()).filter(|&h| distance(after[h], before[h]) > 1e-4).count();
    assert!(moved > 1, "its neighbours come with it");
    // Each step that moved the pointer drew its picture in the same step.
    assert!(view.state().times().unwrap().1 >= drawn + 4);
    view.key_press_modifiers(Modifiers::COMMAND, egui::Key::Z);
    view.run();
    assert_eq!(document(&view).handles(true), before, "one undo takes all of a drag back");
    view.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, egui::Key::Z);
    view.run();
    assert_eq!(document(&view).handles(true), after);
    view.get_by_label("Undo").click();
    view.run();
    assert_eq!(document(&view).handles(true), before, "the button does the same");
}

#[test]
fn what_is_dragged_is_drawn_in_the_same_frame() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let handle = handle_in_front(&view);
    let from = at(&view, handle);
    button(&mut view, from, PointerButton::Primary, true, NONE);
    view.step();
    view.hover_at(from + egui::vec2(8.0, 0.0));
    view.step();
    let drawn = view.state().times().unwrap().1;
    view.hover_at(from + egui::vec2(30.0, 0.0));
    view.step();
    assert!(at(&view, handle).distance(from + egui::vec2(30.0, 0.0)) < 1.0);
    assert_eq!(view.state().times().unwrap().1, drawn + 1, "one event, one picture");
    // Escape undoes the drag.
    view.key_press(egui::Key::Escape);
    view.run();
    assert!(at(&view, handle).distance(from) < 0.1);
}

#[test]
fn a_marker_stays_where_it_was_let_go_though_the_pointer_goes_on() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let handle = handle_in_front(&view);
    let from = at(&view, handle);
    let to = from + egui::vec2(20.0, 12.0);
    button(&mut view, from, PointerButton::Primary, true, NONE);
    view.step();
    view.hover_at(from + egui::vec2(8.0, 0.0));
    view.step();
    // All events come between two frames, as when a frame takes long.
    let beyond = egui::Event::PointerMoved(to + egui::vec2(90.0, 60.0));
    view.input_mut().events.extend([egui::Event::PointerMoved(to), primary(to, false), beyond]);
    view.run();
    assert!(at(&view, handle).distance(to) < 1.0, "{:?} instead of {to:?}", at(&view, handle));
}

#[test]
fn a_whole_drag_between_two_frames_is_a_drag() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let handle = handle_in_front(&view);
    let from = at(&view, handle);
    let to = from + egui::vec2(20.0, 12.0);
    view.input_mut().events.extend([
        egui::Event::PointerMoved(from),
        primary(from, true),
        egui::Event::PointerMoved(from + egui::vec2(8.0, 0.0)),
        egui::Event::PointerMoved(to),
        primary(to, false),
        egui::Event::PointerMoved(to + egui::vec2(90.0, 60.0)),
    ]);
    view.run();
    assert!(at(&view, handle).distance(to) < 1.0, "{:?} instead of {to:?}", at(&view, handle));
}

/// An event of a finger.
fn touch(finger: u64, phase: egui::TouchPhase, pos: Pos2) -> egui::Event {
    let (device_id, id) = (egui::TouchDeviceId(0), egui::TouchId(finger));
    egui::Event::Touch { device_id, id, phase, pos, force: None }
}

#[test]
fn two_fingers_zoom_even_if_the_first_lies_on_a_marker() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let (handle, before) = (handle_in_front(&view), document(&view).handles(true));
    let (first, others) = (at(&view, handle), [0, 1].map(|other| at(&view, other)));
    let apart = |view: &View| at(view, 0).distance(at(view, 1));
    // The first finger has begun to drag the marker.
    button(&mut view, first, PointerButton::Primary, true, NONE);
    view.event(touch(0, egui::TouchPhase::Start, first));
    view.step();
    view.event(egui::Event::PointerMoved(first + egui::vec2(-9.0, 0.0)));
    view.event(touch(0, egui::TouchPhase::Move, first + egui::vec2(-9.0, 0.0)));
    view.step();
    assert_ne!(document(&view).handles(true), before);
    let second = first + egui::vec2(91.0, 0.0);
    view.event(touch(1, egui::TouchPhase::Start, second));
    view.step();
    for step in 1..=5 {
        let out = egui::vec2(10.0 * step as f32, 0.0);
        view.event(egui::Event::PointerMoved(first + egui::vec2(-9.0, 0.0) - out));
        view.event(touch(0, egui::TouchPhase::Move, first + egui::vec2(-9.0, 0.0) - out));
        view.event(touch(1, egui::TouchPhase::Move, second + out));
        view.step();
    }
    view.event(touch(1, egui::TouchPhase::End, second));
    view.event(touch(0, egui::TouchPhase::End, first));
    button(&mut view, first, PointerButton::Primary, false, NONE);
    view.run();
    assert_eq!(document(&view).handles(true), before, "the marker is where it was");
    assert_eq!(document(&view).can_undo_and_redo(), [false, false]);
    let zoomed = apart(&view) / others[0].distance(others[1]);
    assert!((1.6..2.4).contains(&zoomed), "the fingers went from 100 to 200 points apart: {zoomed}");
}

#[test]
fn a_finger_may_rest_before_it_drags() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let handle = handle_in_front(&view);
    let from = at(&view, handle);
    let to = from + egui::vec2(20.0, 12.0);
    button(&mut view, from, PointerButton::Primary, true, NONE);
    view.event(touch(0, egui::TouchPhase::Start, from));
    let begin = view.ctx.input(|input| input.time);
    while view.ctx.input(|input| input.time) < begin + 2.0 {
        view.step();
    }
    view.event(egui::Event::PointerMoved(to));
    view.event(touch(0, egui::TouchPhase::Move, to));
    view.step();
    view.event(touch(0, egui::TouchPhase::End, to));
    button(&mut view, to, PointerButton::Primary, false, NONE);
    view.run();
    assert!(at(&view, handle).distance(to) < 1.0, "{:?} instead of {to:?}", at(&view, handle));
}

#[test]
fn at_rest_nothing_is_drawn_and_nothing_asked_for() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let drawn = view.state().times().unwrap().1;
    for _ in 0..20 {
        view.step();
    }
    assert_eq!(view.state().times().unwrap().1, drawn);
    let wanted: Vec<_> = view.output().viewport_output.values().map(|output| output.repaint_delay).collect();
    assert!(wanted.iter().all(|delay| delay.as_secs() > 3600), "{wanted:?}");
}

#[test]
fn several_are_dragged_together_and_pinned_ones_stay() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let first = handle_in_front(&view);
    let other = document(&view).soft_selection().mirror_of(first).filter(|other| *other != first);
    let other = other.unwrap_or_else(|| (0..demo().1.handles().len()).find(|&h| h != first).unwrap());
    let place = at(&view, first);
    click(&mut view, place, NONE);
    let place = at(&view, other);
    click(&mut view, place, Modifiers::SHIFT);
    assert_eq!(view.state().selected(), [first, other]);
    let before = document(&view).handles(true);
    let from = at(&view, first);
    drag(&mut view, from, from + egui::vec2(0.0, -20.0), NONE);
    let after = document(&view).handles(true);
    let [a, b] = [first, other].map(|h| distance(after[h], before[h]));
    assert!(a > 0.0 && (a - b).abs() < 1e-3 * a, "{a} and {b}");
    view.key_press_modifiers(Modifiers::COMMAND, egui::Key::Z);
    view.run();
    // One is pinned, the other dragged.
    click(&mut view, place, NONE);
    view.key_press(egui::Key::P);
    view.run();
    assert!(document(&view).pose().pinned[other]);
    let from = at(&view, first);
    drag(&mut view, from, from + egui::vec2(0.0, -20.0), NONE);
    assert_eq!(document(&view).handles(true)[other], before[other]);
}

#[test]
fn the_mirror_does_the_same_on_the_other_side() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let soft_selection = document(&view).soft_selection().clone();
    let handle = (0..demo().1.handles().len())
        .find(|&h| {
            soft_selection.mirror_of(h).is_some_and(|other| other != h)
                && at(&view, h).distance(face(&view).center()) < 200.0
        })
        .unwrap();
    let other = soft_selection.mirror_of(handle).unwrap();
    view.key_press(egui::Key::M);
    view.state_mut().settings_mut().reach = 0.0;
    view.run();
    let before = document(&view).handles(true);
    let from = at(&view, handle);
    drag(&mut view, from, from + egui::vec2(14.0, -9.0), NONE);
    let after = document(&view).handles(true);
    let by = |h: usize| [0, 1, 2].map(|c| after[h][c] - before[h][c]);
    let ([x, y, z], [a, b, c]) = (by(handle), by(other));
    assert!(x.abs() > 0.01 && (x + a).abs() < 1e-5 && (y - b).abs() < 1e-5 && (z - c).abs() < 1e-5);
}

#[test]
fn the_camera_goes_around_nearer_and_back() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    let orbit = |view: &View| view.state().orbit().unwrap().clone();
    let front = orbit(&view);
    // Beside the face there is no marker.
    let beside = face(&view).left_top() + egui::vec2(15.0, 15.0);
    drag(&mut view, beside, beside + egui::vec2(100.0, 0.0), NONE);
    let turned = orbit(&view);
    assert_ne!(turned, front);
    assert!(turned.axes()[1].distance(front.axes()[1]) < 1e-5, "the horizon stays level");
    view.key_press(egui::Key::Num1);
    view.run();
    assert_eq!(orbit(&view).axes(), front.axes());
    view.key_press(egui::Key::Enter);
    view.run();
    assert_eq!(orbit(&view), front);
    drag(&mut view, beside, beside + egui::vec2(40.0, 30.0), Modifiers::SHIFT);
    assert!(orbit(&view) != front && orbit(&view).axes() == front.axes(), "moved, not turned");
    view.key_press(egui::Key::Enter);
    view.run();
    assert_eq!(orbit(&view), front);
    let over = face(&view).center();
    view.hover_at(over);
    let wheel = egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Point,
        delta: egui::vec2(0.0, 120.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: NONE,
    };
    view.event(wheel);
    // The camera moves smoothly.
    view.run_steps(20);
    let eye = |orbit: &rhytid_view::Orbit| orbit.camera().eye();
    let target = front.camera().target();
    assert!(distance(eye(&orbit(&view)), target) < 0.95 * distance(eye(&front), target), "it is nearer");
    for (key, axis) in [(egui::Key::Num3, 0), (egui::Key::Num7, 1)] {
        view.key_press(key);
        view.run();
        let toward = orbit(&view).axes()[2].to_array();
        assert!((toward[axis] - 1.0).abs() < 1e-3, "{key:?}: {toward:?}");
    }
}

#[test]
fn a_vertex_says_what_drives_it() {
    let folder = Folder::new();
    let mut view = opened(&folder, [1100.0, 900.0]);
    let handle = handle_in_front(&view);
    // The place is beside the dot, on the skin.
    let place = at(&view, handle) + egui::vec2(16.0, 6.0);
    click(&mut view, place, NONE);
    let vertex = view.state().vertex().expect("the skin was clicked");
    let rest = &demo().1.surface().rest;
    let near = distance(rest[vertex], rest[demo().1.handles().points[handle].nearest_vertex().index()]);
    assert!(near < 2.0, "the vertex is {near} from the marker that it is beside");
    view.run();
    view.get_by_label("strain edge");
    view.get_by_label("wrinkles");
    let explanation = demo().1.explain(vertex, &document(&view).handles(true)).unwrap();
    let [a, b] = demo().1.handles().strain_edges[explanation.edges[0].edge.index()]
        .map(|h| &*demo().1.handles().labels[h.index()]);
    view.get_all_by_label(&format!("{a} – {b}")).next().expect("the edge that counts most is listed");
}

#[test]
fn everything_is_done_by_keys_too() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    view.key_press(egui::Key::N);
    view.run();
    assert_eq!(view.state().selected(), [0]);
    view.key_press(egui::Key::B);
    view.run();
    assert_eq!(view.state().selected(), [demo().1.handles().len() - 1]);
    let before = document(&view).handles(true);
    view.key_press_modifiers(Modifiers::ALT, egui::Key::ArrowUp);
    view.run();
    let last = demo().1.handles().len() - 1;
    let millimetres = 1e3 * demo().1.surface().metres_per_unit as f32;
    let moved = millimetres * (document(&view).handles(true)[last][1] - before[last][1]);
    assert!((moved - 1.0).abs() < 1e-3, "a millimetre up: {moved}");
    view.key_press(egui::Key::R);
    view.run();
    assert_eq!(document(&view).handles(true)[last], before[last]);
    view.key_press(egui::Key::H);
    view.run();
    view.get_by_label("drag a marker");
    view.get_by_label("F1 to F9");
    view.key_press(egui::Key::H);
    view.run();
    assert!(view.query_by_label("drag a marker").is_none());
    // Escape closes the sheet first, and the selection stays.
    view.key_press(egui::Key::H);
    view.run();
    view.key_press(egui::Key::Escape);
    view.run();
    assert!(view.query_by_label("drag a marker").is_none());
    assert_eq!(view.state().selected(), [last]);
    view.key_press(egui::Key::Escape);
    view.run();
    assert!(view.state().selected().is_empty());
    let shown = view.query_by_label("Mirrored").is_some();
    view.key_press(egui::Key::T);
    view.run();
    assert_ne!(view.query_by_label("Mirrored").is_some(), shown);
}

#[test]
fn the_wipe_is_dragged() {
    let folder = Folder::new();
    let mut view = opened(&folder, [900.0, 700.0]);
    view.state_mut().settings_mut().before = Before::LargeScale;
    view.run();
    let rect = face(&view);
    let line = egui::pos2(rect.center().x, rect.top() + 40.0);
    let orbit = view.state().orbit().unwrap().clone();
    drag(&mut view, line, line + egui::vec2(100.0, 0.0), NONE);
    let wipe = view.state_mut().settings_mut().wipe;
    assert!((wipe - 0.5 - 100.0 / rect.width()).abs() < 0.02, "{wipe}");
    assert_eq!(view.state().orbit().unwrap(), &orbit, "the face stays");
}
