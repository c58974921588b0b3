//! The words for work that takes long, with a button that stops it.

use crate::app::ViewApp;
use eframe::egui;
use web_time::Duration;

/// Shorter work is not worth a word.
const WORTH_A_WORD: Duration = Duration::from_millis(400);
/// The spinner turns by steps, since each picture of the window costs time that the work could use.
const STEP: Duration = Duration::from_millis(100);

pub(crate) fn show(app: &mut ViewApp, context: &egui::Context) {
    let opening = app.opening.as_ref().map(|opening| (opening.in_words(), opening.work.age()));
    let scene = app.scene.as_ref().and_then(|scene| scene.work(&app.settings));
    let scene = scene.map(|(words, work)| (words, work.age()));
    let works = [(Whose::Opening, opening), (Whose::Scene, scene), (Whose::Export, export(app))];
    let mut shown = Vec::new();
    for (whose, work) in works {
        let Some((words, age)) = work else { continue };
        match WORTH_A_WORD.checked_sub(age) {
            Some(left) => context.request_repaint_after(left),
            None => shown.push((whose, words)),
        }
    }
    if shown.is_empty() {
        return;
    }
    context.request_repaint_after(STEP);
    let face = app.scene.as_ref().and_then(|scene| scene.place);
    let room = face.unwrap_or(context.content_rect());
    let area = egui::Area::new(egui::Id::unique("busy")).fixed_pos(room.left_top() + egui::vec2(12.0, 12.0));
    area.order(egui::Order::Middle).show(context, |ui| {
        egui::Frame::popup(ui.style()).show(ui, |ui| {
            ui.set_max_width((room.width() - 48.0).clamp(240.0, 420.0));
            for (whose, words) in shown {
                ui.horizontal(|ui| {
                    spinner(ui);
                    if ui.button("Stop").clicked() {
                        stop(app, whose);
                    }
                    ui.add(egui::Label::new(words).wrap());
                });
            }
        });
    });
}

/// Whose work it is.
#[derive(Clone, Copy)]
enum Whose {
    Opening,
    Scene,
    Export,
}

fn stop(app: &mut ViewApp, whose: Whose) {
    match (whose, &mut app.scene) {
        (Whose::Scene, Some(scene)) => scene.stop(&mut app.settings),
        (Whose::Scene, None) => {}
        (Whose::Opening, _) => app.stop_opening(),
        #[cfg(not(target_arch = "wasm32"))]
        (Whose::Export, _) => app.stop_exporting(),
        #[cfg(target_arch = "wasm32")]
        (Whose::Export, _) => {}
    }
}

#[cfg(not(target_arch = "wasm32"))]
fn export(app: &ViewApp) -> Option<(String, Duration)> {
    app.exporting.as_ref().map(|task| (task.0.in_words(), task.0.work.age()))
}

/// A browser has no files to export to.
#[cfg(target_arch = "wasm32")]
fn export(_: &ViewApp) -> Option<(String, Duration)> {
    None
}

/// Eight dots, one of which is bright. egui's own spinner draws the window anew as often as it can.
fn spinner(ui: &mut egui::Ui) {
    const DOTS: u32 = 8;
    let size = ui.spacing().interact_size.y;
    let (rect, _) = ui.allocate_exact_size(egui::Vec2::splat(size), egui::Sense::hover());
    let bright = (ui.input(|input| input.time) / STEP.as_secs_f64()) as u32 % DOTS;
    let colour = ui.visuals().strong_text_color();
    for dot in 0..DOTS {
        let age = (bright + DOTS - dot) % DOTS;
        let angle = dot as f32 * std::f32::consts::TAU / DOTS as f32;
        let at = rect.center() + 0.36 * size * egui::Vec2::angled(angle);
        let fade = 1.0 - 0.8 * age as f32 / DOTS as f32;
        ui.painter().circle_filled(at, 0.08 * size, colour.gamma_multiply(fade));
    }
}
