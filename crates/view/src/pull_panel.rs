//! The panel of pulls: when new ones act, and the list of all, each of which can be changed or deleted.

use crate::commands::Command;
use crate::document::Document;
use crate::pulls::{Pull, Span, When};
use eframe::egui;

/// The longest ease, in seconds.
const LONGEST: f64 = 60.0;

pub(crate) fn show(document: &mut Document, ui: &mut egui::Ui, wanted: &mut Vec<Command>) {
    let frames = document.transport.frames();
    if frames > 1 {
        ui.label("New pulls act");
        ui.horizontal_wrapped(|ui| {
            for when in When::ALL {
                ui.selectable_value(&mut document.new_pulls.when, when, when.name());
            }
        });
        let new = &mut document.new_pulls;
        eases(new.when, &mut new.ease, ["Ease in", "Ease out"], ui);
    }
    let pulls = document.pose().pulls.clone();
    if pulls.is_empty() {
        ui.weak("no pulls yet: drag a marker");
        return;
    }
    let selected = document.selected_pull();
    let words: Vec<String> = pulls.iter().map(|pull| pull.in_words(&document.rig)).collect();
    for (i, words) in words.into_iter().enumerate() {
        let is_selected = selected == Some(i);
        if ui.add(egui::Button::selectable(is_selected, words).truncate()).clicked() {
            document.select_pull((!is_selected).then_some(i));
        }
        if is_selected {
            ui.indent("selected pull", |ui| {
                if frames > 1 {
                    change(document, &pulls[i], ui);
                }
                if ui.button("Delete this pull").clicked() {
                    wanted.push(Command::DeletePull);
                }
            });
        }
    }
}

/// The fields of seconds. A pull of the whole take has none, and one from a frame on has no end.
fn eases(when: When, ease: &mut [f64; 2], names: [&str; 2], ui: &mut egui::Ui) -> Vec<egui::Response> {
    let count = match when {
        When::Whole => 0,
        When::From => 1,
        When::At => 2,
    };
    let mut fields = Vec::new();
    if count == 0 {
        return fields;
    }
    ui.horizontal_wrapped(|ui| {
        for (name, seconds) in names.into_iter().zip(ease).take(count) {
            let label = ui.label(name);
            let field = egui::DragValue::new(seconds).range(0.0..=LONGEST).speed(0.01).max_decimals(3);
            fields.push(ui.add(field.suffix(" s")).labelled_by(label.id));
        }
    });
    fields
}

/// The fields of the selected pull. A drag of a field is one step to undo.
fn change(document: &mut Document, pull: &Pull, ui: &mut egui::Ui) {
    let mut span = pull.span;
    let last = document.transport.frames() - 1;
    let mut fields = Vec::new();
    ui.horizontal_wrapped(|ui| {
        for when in When::ALL {
            // What is at a frame of its own need not be here.
            let name = match when {
                When::Whole => "Whole take",
                When::From => "From a frame",
                When::At => "At frames",
            };
            if ui.selectable_label(span.when == when, name).clicked() && span.when != when {
                let frame =
                    if span.when == When::Whole { document.transport.frame() } else { span.frames[0] };
                let ease = if span.when == When::Whole { document.new_pulls.ease } else { span.ease };
                document.change_pull(Span::new(when, frame, ease));
                return;
            }
        }
    });
    if span.when != When::Whole {
        ui.horizontal_wrapped(|ui| {
            let [first, end] = &mut span.frames;
            let label = ui.label("First frame");
            let field = egui::DragValue::new(first).range(0..=last);
            fields.push(ui.add(field).labelled_by(label.id));
            *end = (*end).max(*first);
            if span.when == When::At {
                let label = ui.label("Last frame");
                let field = egui::DragValue::new(end).range(*first..=last);
                fields.push(ui.add(field).labelled_by(label.id));
            }
        });
    }
    fields.extend(eases(span.when, &mut span.ease, ["Comes in", "Goes in"], ui));
    let is_any = |is: fn(&egui::Response) -> bool| fields.iter().any(is);
    if is_any(egui::Response::drag_started) {
        document.begin_drag();
    }
    if is_any(egui::Response::changed) {
        if span.when == When::From {
            span.frames[1] = span.frames[0];
        }
        document.change_pull(span);
    }
    if is_any(egui::Response::drag_stopped) {
        document.end_drag(true);
    }
}
