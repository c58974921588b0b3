//! The work of each frame of the window.

use crate::app::{Note, ViewApp};
use crate::document::Document;
use crate::open::Source;
use crate::{busy, commands, events, panel_place, theme, timeline, viewport};
use eframe::egui;
use std::sync::PoisonError;

impl eframe::App for ViewApp {
    #[cfg(target_arch = "wasm32")]
    fn as_any_mut(&mut self) -> Option<&mut dyn std::any::Any> {
        Some(self)
    }

    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        if let Some(reason) = self.lost.lock().unwrap_or_else(PoisonError::into_inner).take() {
            let device = self.gpu.name();
            let message = format!("the device that draws was lost ({reason}); open the viewer again");
            self.note = Some(Note { words: format!("{device}: {message}"), is_error: true });
        }
        // WebGL hands results over only between frames.
        #[cfg(target_arch = "wasm32")]
        if std::rc::Rc::strong_count(&self.reading) > 1 {
            context.request_repaint();
        }
        #[cfg(not(target_arch = "wasm32"))]
        self.take_close(&context);
        self.take_opened();
        #[cfg(not(target_arch = "wasm32"))]
        self.take_live();
        #[cfg(not(target_arch = "wasm32"))]
        self.take_chosen();
        #[cfg(not(target_arch = "wasm32"))]
        self.take_exported();
        self.play(&context);
        self.take_dropped(ui);
        if !self.is_asking() {
            for command in commands::pressed(ui) {
                self.run(command, ui);
            }
        }
        if self.note.is_some() || !self.warnings.is_empty() {
            egui::Panel::bottom("note").show(ui, |ui| self.notes(ui));
        }
        egui::Panel::bottom("time line").show(ui, |ui| timeline::show(self, ui));
        panel_place::show(self, ui);
        egui::CentralPanel::no_frame().show(ui, |ui| viewport::show(self, ui));
        busy::show(self, &context);
        hovering(&context);
        self.set_title(&context);
        events::list(self, &context);
        #[cfg(not(target_arch = "wasm32"))]
        crate::leaving::show(self, &context);
    }
}

impl ViewApp {
    /// Names the open files in the window's title.
    fn set_title(&mut self, context: &egui::Context) {
        let title = self.document().map_or_else(|| "Rhytid".to_owned(), Document::title);
        if title != self.title {
            context.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    /// Whether a question waits for its answer, which the keys belong to.
    #[cfg(not(target_arch = "wasm32"))]
    fn is_asking(&self) -> bool {
        self.leaving.is_some()
    }

    #[cfg(target_arch = "wasm32")]
    fn is_asking(&self) -> bool {
        false
    }

    /// Lets time pass for the play head, and asks to be called again when the next frame is due.
    fn play(&mut self, context: &egui::Context) {
        let Some(scene) = &mut self.scene else { return };
        let transport = &mut scene.document.transport;
        let now = context.input(|input| input.time);
        if let Some(before) = self.clock.replace(now) {
            transport.advance(now - before);
        }
        match transport.playing && !scene.document.is_live() {
            true => {
                let wait = scene.document.transport.until_next();
                context.request_repaint_after(std::time::Duration::from_secs_f64(wait.min(1.0)));
            }
            false => self.clock = None,
        }
    }

    #[cfg(not(target_arch = "wasm32"))]
    fn take_dropped(&mut self, ui: &egui::Ui) {
        let dropped = ui.input(|input| input.raw.dropped_files.clone());
        self.open(dropped.iter().map(|file| Source::new(file.path().to_owned())).collect());
    }

    /// A browser reads files while the page keeps running.
    #[cfg(target_arch = "wasm32")]
    fn take_dropped(&mut self, ui: &egui::Ui) {
        let dropped = ui.input(|input| input.raw.dropped_files.clone());
        if !dropped.is_empty() {
            let inbox = self.inbox.clone();
            wasm_bindgen_futures::spawn_local(async move {
                let mut read = Vec::new();
                for file in dropped {
                    read.push((file.path().display().to_string(), file.bytes_async().await));
                }
                inbox.put(read);
            });
        }
        let read = self.inbox.take();
        let faults =
            read.iter().filter_map(|(name, bytes)| Some(format!("{name}: {}", bytes.as_ref().err()?)));
        if let Some(fault) = faults.reduce(|a, b| a + "; " + &b) {
            self.tell(Err(rhytid_core::Error::input(fault)));
        }
        let sources = read.into_iter().filter_map(|(name, bytes)| Some(Source::new(&name, bytes.ok()?)));
        self.open(sources.collect());
    }

    fn notes(&mut self, ui: &mut egui::Ui) {
        let warnings = std::mem::take(&mut self.warnings);
        if !warnings.is_empty() {
            let closed = ui.horizontal_top(|ui| {
                let closed = ui.button("Close the warnings").clicked();
                let height = 0.25 * ui.ctx().content_rect().height();
                egui::ScrollArea::vertical().max_height(height).show(ui, |ui| {
                    for warning in &warnings {
                        ui.add(egui::Label::new(format!("Warning: {warning}")).wrap());
                    }
                });
                closed
            });
            if !closed.inner {
                self.warnings = warnings;
            }
        }
        let Some(note) = self.note.clone() else { return };
        ui.horizontal_wrapped(|ui| {
            if ui.button("Close").clicked() {
                (self.note, self.elsewhere) = (None, None);
            }
            #[cfg(not(target_arch = "wasm32"))]
            self.offer_space(ui);
            let words = egui::RichText::new(&note.words);
            let error = ui.visuals().error_fg_color;
            ui.label(if note.is_error { words.color(error) } else { words });
        });
    }
}

/// Where a file hovers over the window: what dropping it does.
fn hovering(context: &egui::Context) {
    let files = context.input(|input| input.raw.hovered_files.clone());
    if files.is_empty() {
        return;
    }
    let name = |file: &egui::HoveredFile| {
        let path = file.path.as_ref()?;
        Some(path.file_name()?.to_string_lossy().into_owned())
    };
    let names: Vec<String> = files.iter().filter_map(name).collect();
    let words = match &names[..] {
        [] => "Drop to open".to_owned(),
        names => format!("Drop to open {}", names.join(", ")),
    };
    let painter =
        context.layer_painter(egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop")));
    let (room, visuals) = (context.content_rect(), context.global_style().visuals.clone());
    painter.rect_filled(room, 0.0, theme::over_picture(&visuals));
    let stroke = egui::Stroke::new(4.0, theme::MARKED);
    painter.rect_stroke(room.shrink(6.0), 8.0, stroke, egui::StrokeKind::Inside);
    let font = egui::TextStyle::Heading.resolve(&context.global_style());
    let colour = visuals.strong_text_color();
    let galley = painter.layout(words, font, colour, room.width() - 48.0);
    painter.galley(room.center() - 0.5 * galley.size(), galley, colour);
}
