//! The take's time line.

use crate::app::ViewApp;
use crate::commands::Command;
use crate::document::Document;
use eframe::egui::{self, Color32, Rect, Sense, pos2, vec2};

pub(crate) fn show(app: &mut ViewApp, ui: &mut egui::Ui) {
    let mut wanted = Vec::new();
    let width = ui.ctx().content_rect().width();
    ui.horizontal_wrapped(|ui| {
        if ui.selectable_label(app.is_panel_shown(width), "Panel").clicked() {
            wanted.push(Command::Panels);
        }
        let Some(document) = app.scene.as_mut().map(|scene| &mut scene.document) else {
            #[cfg(not(target_arch = "wasm32"))]
            if ui.button("Open a rig").clicked() {
                wanted.push(Command::Open);
            }
            ui.weak("no take");
            return;
        };
        let mut button = |ui: &mut egui::Ui, words: &str, command| {
            if ui.button(words).clicked() {
                wanted.push(command);
            }
        };
        if document.is_live() {
            ui.label("live");
            return;
        }
        if document.transport.frames() < 2 {
            ui.weak("no take: drop one on the window");
            return;
        }
        let playing = document.transport.playing;
        button(ui, if playing { "Stop" } else { "Play" }, Command::Play);
        button(ui, "Previous", Command::Previous);
        button(ui, "Next", Command::Next);
        ui.checkbox(&mut document.transport.looping, "Loop");
        let mut frame = document.transport.frame();
        let last = document.transport.frames() - 1;
        let label = ui.label("Frame");
        let field = egui::DragValue::new(&mut frame).range(0..=last);
        if ui.add(field).labelled_by(label.id).changed() {
            document.transport.seek(frame);
        }
        // The text is never wrapped, for any width of the window.
        ui.add(egui::Label::new(format!("of {last}   {:.2} s", document.transport.time())).extend());
        ui.add(
            egui::DragValue::new(&mut document.transport.speed)
                .range(0.05..=8.0)
                .speed(0.01)
                .max_decimals(2)
                .suffix(" × the take's rate"),
        );
    });
    if let Some(scene) = &mut app.scene
        && scene.document.transport.frames() > 1
        && !scene.document.is_live()
    {
        strip(&mut scene.document, ui);
    }
    wanted.into_iter().for_each(|command| app.run(command, ui));
}

/// All frames from left to right, with the clean-up's findings, the confidence, and the play head. The play
/// head follows the pointer.
fn strip(document: &mut Document, ui: &mut egui::Ui) {
    let size = vec2(ui.available_width(), 34.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let frames = document.transport.frames();
    let frame = document.transport.frame();
    response.widget_info(|| {
        let mut info = egui::WidgetInfo::slider(ui.is_enabled(), frame as f64, "Time line");
        info.value = Some(frame as f64);
        info
    });
    if let Some(at) = response.interact_pointer_pos() {
        let part = ((at.x - rect.left()) / rect.width()).clamp(0.0, 1.0);
        document.transport.seek((part * (frames - 1) as f32).round() as usize);
    }
    if response.has_focus() {
        let step = ui.input(|input| {
            let pressed = |key| input.num_presses(key) as isize;
            pressed(egui::Key::ArrowRight) - pressed(egui::Key::ArrowLeft)
        });
        if step != 0 {
            document.transport.step(step);
        }
    }
    let x = |frame: usize| rect.left() + rect.width() * frame as f32 / (frames - 1) as f32;
    let visuals = ui.visuals().clone();
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, visuals.extreme_bg_color);
    // A column of pixels shows the lowest confidence of its frames.
    let confidence = document.confidence();
    let columns = (rect.width().max(1.0)) as usize;
    for column in 0..columns.min(confidence.len()) {
        let of = |column: usize| column * confidence.len() / columns.min(confidence.len());
        let least =
            confidence[of(column)..of(column + 1).max(of(column) + 1)].iter().copied().fold(1.0, f32::min);
        if least < 1.0 {
            let (left, right) = (x(of(column)), x(of(column + 1)).max(x(of(column)) + 1.0));
            let top = rect.bottom() - (1.0 - least) * 0.5 * rect.height();
            let bar = Rect::from_min_max(pos2(left, top), pos2(right, rect.bottom()));
            painter.rect_filled(bar, 0.0, Color32::from_rgb(214, 140, 30).gamma_multiply(0.8));
        }
    }
    let mut told = None;
    if let Some(take) = document.take() {
        let pointer = response.hover_pos();
        for incident in &take.incidents {
            let end = (incident.first + incident.frames).min(frames - 1);
            let right = x(end).max(x(incident.first) + 1.5);
            let bar =
                Rect::from_min_max(pos2(x(incident.first), rect.top() + 3.0), pos2(right, rect.top() + 11.0));
            painter.rect_filled(bar, 1.0, Color32::from_rgb(90, 120, 200));
            if pointer.is_some_and(|at| bar.expand(2.0).contains(at)) && told.is_none() {
                told = Some(format!(
                    "{}, frames {} to {}, confidence {:.2}",
                    incident.words,
                    incident.first,
                    incident.first + incident.frames - 1,
                    incident.confidence
                ));
            }
        }
    }
    let head = x(document.transport.frame());
    painter.vline(head, rect.y_range(), egui::Stroke::new(2.0, visuals.strong_text_color()));
    if let Some(told) = told {
        response.on_hover_text(told);
    }
}
