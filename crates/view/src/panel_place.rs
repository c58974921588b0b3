//! The place of the panel: beside the face, or below it in a narrow window. The face is seen with either.

use crate::app::{NARROW, ViewApp};
use crate::{keys, panel};
use eframe::egui;

/// The most of the window's width or height that the panel takes.
const MOST: f32 = 0.42;
/// The panel's width beside the face at first, and at most, in points.
const WIDTHS: [f32; 2] = [300.0, 360.0];

/// Shows the panel or the sheet of keys, if one is open, in what is left of the window.
pub(crate) fn show(app: &mut ViewApp, ui: &mut egui::Ui) {
    let window = ui.ctx().content_rect().size();
    if !app.keys_shown && !app.is_panel_shown(window.x) {
        return;
    }
    // The panel's size does not depend on its contents, so the face stays where it is.
    let contents = |ui: &mut egui::Ui| {
        let area = |id| egui::ScrollArea::vertical().id_salt(id).auto_shrink(false);
        match app.keys_shown {
            true => area("keys").show(ui, |ui| keys::show(app, ui)),
            false => area("panel").show(ui, |ui| panel::show(app, ui)),
        };
    };
    if window.x < NARROW && window.x < window.y {
        let most = MOST * window.y;
        egui::Panel::bottom("panel below").default_size(most).max_size(most).show(ui, contents);
    } else {
        let [first, most] = WIDTHS.map(|width| width.min(MOST * window.x));
        egui::Panel::right("panel").default_size(first).max_size(most).show(ui, contents);
    }
}
