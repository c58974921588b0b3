//! The question before pulls would be lost: when the window is closed, or another rig is opened.

use crate::app::ViewApp;
use crate::commands::Command;
use crate::open::Source;
use eframe::egui;

/// What waits for the answer.
#[derive(Debug)]
pub(crate) enum Leaving {
    /// Closing the window.
    Close,
    /// Opening these files, of which one is another rig.
    Open(Vec<Source>),
}

/// The user's answer.
#[derive(Clone, Copy)]
enum Answer {
    Save,
    Discard,
    Cancel,
}

impl ViewApp {
    /// Whether pulls would be lost.
    pub(crate) fn has_unsaved_pulls(&self) -> bool {
        self.document().is_some_and(crate::document::Document::has_unsaved_pulls)
    }

    /// Closes the window, after a question where pulls would be lost.
    pub(crate) fn close(&mut self, context: &egui::Context) {
        match self.has_unsaved_pulls() {
            true => self.leaving = Some(Leaving::Close),
            false => context.send_viewport_cmd(egui::ViewportCommand::Close),
        }
    }

    /// Keeps the window open where the system wants to close it, until the question is answered.
    pub(crate) fn take_close(&mut self, context: &egui::Context) {
        if context.input(|input| input.viewport().close_requested()) && self.has_unsaved_pulls() {
            context.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            self.leaving = Some(Leaving::Close);
        }
    }
}

/// Shows the question, if there is one.
pub(crate) fn show(app: &mut ViewApp, context: &egui::Context) {
    let Some(leaving) = &app.leaving else { return };
    let (words, then) = match leaving {
        Leaving::Close => ("Close the window?", "closing the window"),
        Leaving::Open(_) => ("Open another rig?", "opening another rig"),
    };
    let width = (context.content_rect().width() - 48.0).clamp(120.0, 340.0);
    let mut answer = None;
    let modal = egui::Modal::new(egui::Id::unique("leaving")).show(context, |ui| {
        ui.set_width(width);
        ui.heading(words);
        ui.label(format!("Your pulls are not saved, and {then} loses them."));
        ui.add_space(6.0);
        ui.horizontal_wrapped(|ui| {
            for (words, meant) in
                [("Save", Answer::Save), ("Discard", Answer::Discard), ("Cancel", Answer::Cancel)]
            {
                if ui.button(words).clicked() {
                    answer = Some(meant);
                }
            }
        });
    });
    if modal.should_close() {
        answer = answer.or(Some(Answer::Cancel));
    }
    let Some(answer) = answer else { return };
    let Some(leaving) = app.leaving.take() else { return };
    match answer {
        Answer::Cancel => return,
        // Where saving fails, the pulls and the window stay, and the reason is shown.
        Answer::Save => {
            app.save(Command::SaveEdits);
            if app.has_unsaved_pulls() {
                return;
            }
        }
        Answer::Discard => {
            if let Some(scene) = &mut app.scene {
                scene.document.pulls_are_saved();
            }
        }
    }
    match leaving {
        Leaving::Close => context.send_viewport_cmd(egui::ViewportCommand::Close),
        Leaving::Open(sources) => app.open(sources),
    }
}
