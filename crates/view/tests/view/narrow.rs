//! Small windows, such as a telephone's: the face and the panel are seen together.

use super::*;
use egui::accesskit::Role;

/// The place of the panel's slider for wrinkles.
fn slider(view: &View) -> Rect {
    view.get_by_role_and_label(Role::Slider, "Wrinkles").rect()
}

/// The smallest rectangle around all markers in the window.
fn markers(view: &View) -> Rect {
    let places: Vec<Pos2> = (0..demo().1.handles().len()).map(|handle| at(view, handle)).collect();
    Rect::from_points(&places)
}

#[test]
fn face_and_panel_are_seen_together_in_a_small_window() {
    let folder = Folder::new();
    for [width, height] in [[400.0, 800.0], [800.0, 400.0], [390.0, 660.0], [568.0, 320.0]] {
        let mut view = opened(&folder, [width, height]);
        let whole = Rect::from_min_size(Pos2::ZERO, egui::vec2(width, height));
        let is_open = view.query_by_role_and_label(Role::Slider, "Wrinkles").is_some();
        assert_eq!(is_open, width >= 640.0, "at first");
        if !is_open {
            let alone = face(&view);
            view.get_by_label("Panel").click();
            view.run();
            assert!(face(&view).area() < alone.area());
        }
        let (face, seen) = (face(&view), markers(&view));
        assert!(whole.contains_rect(slider(&view)), "{:?} of {whole:?}", slider(&view));
        assert!(!face.intersects(slider(&view)), "the panel lies over the face");
        // The face has a third of the window, all of its markers are in there, and they fill it.
        assert!(face.area() > 0.33 * whole.area(), "{face:?} of {whole:?}");
        assert!(face.contains_rect(seen), "{seen:?} in {face:?}");
        let filled = (seen.width() / face.width()).max(seen.height() / face.height());
        assert!(filled > 0.6, "the face is small: {seen:?} in {face:?}");
        // It is drawn for this place.
        let picture = view.state().picture_size().unwrap();
        assert_eq!(picture, [face.width(), face.height()].map(|n| n.round() as u32));
    }
}
