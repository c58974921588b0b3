//! The sheet of keys.

use crate::app::ViewApp;
use crate::commands::BINDINGS;
use eframe::egui;

/// The actions of the pointer.
const POINTER: [(&str, &str); 9] = [
    ("drag a marker", "move it and its neighbours"),
    ("Shift, click a marker", "add it to the selection"),
    ("drag beside markers", "turn the face"),
    ("Shift or middle button, drag", "move the face"),
    ("wheel, pinch", "zoom to the pointer"),
    ("two fingers", "move the face"),
    ("click the skin", "show what drives that vertex"),
    ("double click", "centre the view there"),
    ("drop files", "open a rig or a take"),
];

pub(crate) fn show(app: &mut ViewApp, context: &egui::Context) {
    let mut open = app.keys_shown;
    let room = context.content_rect();
    let width = (room.width() - 40.0).min(480.0);
    let sheet = egui::Window::new("Keys").open(&mut open).vscroll(true).default_height(room.height() - 60.0);
    sheet.default_width(width).max_width(width).show(context, |ui| {
        // Each column has half of the width, so long lines wrap in a narrow window.
        let half = 0.5 * (width - ui.spacing().item_spacing.x);
        egui::Grid::new("keys").num_columns(2).max_col_width(half).striped(true).show(ui, |ui| {
            for (what, words) in POINTER {
                ui.strong(what);
                ui.label(words);
                ui.end_row();
            }
            let mut bindings = BINDINGS.iter().peekable();
            while let Some(binding) = bindings.next() {
                let mut keys = context.format_shortcut(&binding.key);
                // Bindings without words share the line of the one before.
                while let Some(more) = bindings.next_if(|binding| binding.words.is_empty()) {
                    keys = format!("{keys}, {}", context.format_shortcut(&more.key));
                }
                ui.strong(if binding.words.contains("F1 to") { "F1 to F9".to_owned() } else { keys });
                ui.label(binding.words);
                ui.end_row();
            }
        });
    });
    app.keys_shown = open;
}
