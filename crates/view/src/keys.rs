//! The sheet of keys: a panel of its own beside the face.

use crate::app::ViewApp;
use crate::commands::{BINDINGS, Group};
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
    ("drop files", "open them"),
];

/// Shows the sheet in place of the panel at the side.
pub(crate) fn show(app: &mut ViewApp, ui: &mut egui::Ui) {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.heading("Keys");
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui.button("Close the keys").clicked() {
                app.keys_shown = false;
            }
        });
    });
    group(ui, "Pointer", POINTER.map(|(what, words)| (what.to_owned(), words)));
    for of in Group::ALL {
        let mut rows: Vec<(String, &str)> = Vec::new();
        for binding in BINDINGS.iter().filter(|binding| binding.command.group() == of) {
            let key = ui.ctx().format_shortcut(&binding.key);
            match rows.last_mut().filter(|_| binding.words.is_empty()) {
                // Bindings without words share the line of the one before.
                Some((keys, _)) => *keys = format!("{keys}, {key}"),
                None => rows.push((key, binding.words)),
            }
        }
        if of == Group::Look
            && let [first, ..] = &mut rows[..]
        {
            first.0 = "F1 to F9".to_owned();
        }
        group(ui, of.name(), rows);
    }
}

/// A titled table. Each column has half of the width, and long lines wrap.
fn group<'a>(ui: &mut egui::Ui, title: &str, rows: impl IntoIterator<Item = (String, &'a str)>) {
    ui.add_space(6.0);
    ui.strong(title);
    let half = (0.5 * (ui.available_width() - ui.spacing().item_spacing.x)).floor();
    let table = egui::Grid::new(title).num_columns(2).min_col_width(half).max_col_width(half).striped(true);
    table.show(ui, |ui| {
        for (key, words) in rows {
            ui.add(egui::Label::new(egui::RichText::new(key).strong()).wrap());
            ui.add(egui::Label::new(words).wrap());
            ui.end_row();
        }
    });
}
