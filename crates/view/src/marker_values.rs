//! The values of the selected markers in the panel, and the problems of the frame.

use crate::marker_guides::coloured;
use crate::scene::Scene;
use eframe::egui;
use rhytid_core::human;

/// The width of a marker's name, in points. Longer names are cut.
const NAME: f32 = 112.0;

/// The most rows of a table.
const ROWS: usize = 8;

/// The lines of the list of problems.
const LINES: f32 = 4.0;

pub(crate) fn show(scene: &Scene, ui: &mut egui::Ui) {
    let document = &scene.document;
    if !scene.selected.is_empty() {
        let from_rest = |handle: usize| {
            let [x, y, z, _] = document.from_rest(handle);
            [x, y, z]
        };
        table(ui, "mm from rest", scene, from_rest);
        let by_pulls = |handle: usize| document.pulled_here(handle).map(|x| x as f32);
        if scene.selected.iter().any(|&handle| by_pulls(handle) != [0.0; 3]) {
            table(ui, "mm by pulls", scene, by_pulls);
        }
    }
}

/// What is wrong in the frame that is shown. Its height does not depend on the frame, so nothing below it
/// jumps while a take plays.
pub(crate) fn problems(scene: &Scene, ui: &mut egui::Ui) {
    let area = egui::ScrollArea::vertical().id_salt("problems").auto_shrink(false);
    let height = LINES * (ui.text_style_height(&egui::TextStyle::Body) + ui.spacing().item_spacing.y);
    area.max_height(height).min_scrolled_height(height).show(ui, |ui| {
        let problems = scene.document.problems();
        if problems.is_empty() {
            ui.weak("none in this frame");
        }
        for problem in &problems {
            coloured(ui, problem.kind.colour(), &problem.words);
        }
    });
}

/// A row for each selected marker, with three values.
fn table(ui: &mut egui::Ui, title: &str, scene: &Scene, values: impl Fn(usize) -> [f32; 3]) {
    let labels = &scene.document.rig.handles().labels;
    egui::Grid::new(title).num_columns(4).striped(true).show(ui, |ui| {
        for words in [title, "x", "y", "z"] {
            ui.strong(words);
        }
        ui.end_row();
        for &handle in scene.selected.iter().take(ROWS) {
            ui.horizontal(|ui| {
                ui.set_width(NAME);
                ui.add(egui::Label::new(&labels[handle]).truncate());
            });
            for value in values(handle) {
                ui.label(format!("{value:+.2}"));
            }
            ui.end_row();
        }
    });
    if scene.selected.len() > ROWS {
        ui.label(format!("and {} more markers", human::count(scene.selected.len() - ROWS)));
    }
}
