//! The window while nothing is open: three pictures of what to do.

use crate::theme;
use eframe::egui::{self, Color32, Pos2, Rect, Stroke, Ui, Vec2, pos2, vec2};

/// A picture's width over its height, and the space between two.
const ASPECT: f32 = 1.25;
const GAP: f32 = 28.0;
/// The widest that a picture gets, in points.
const WIDEST: f32 = 190.0;
/// The height of the words below a picture.
const WORDS: f32 = 54.0;

/// The steps, with their words.
const STEPS: [&str; 3] = [
    "Drop a rig here (.safetensors), or open one.",
    "Drop a take on the face. A raw take is cleaned.",
    "Drag a marker, and the face follows. H lists the keys.",
];

/// Shows the steps in the middle of `room`. In a narrow window they stand below each other.
pub(crate) fn show(ui: &Ui, room: Rect) {
    let across = if room.width() >= 3.0 * 120.0 + 4.0 * GAP { 3 } else { 1 };
    let down = 3 / across;
    let wide = (room.width() - (across + 1) as f32 * GAP) / across as f32;
    let high = (room.height() - 24.0) / down as f32 - GAP - WORDS;
    let width = wide.min(high * ASPECT).min(WIDEST);
    if width < 30.0 {
        words(ui, Rect::from_center_size(room.center(), vec2(room.width() - 24.0, WORDS)), STEPS[0]);
        return;
    }
    let size = vec2(width, width / ASPECT);
    let cell = vec2(if across == 3 { width } else { wide.min(2.0 * WIDEST) }, size.y + WORDS);
    let whole = vec2(
        across as f32 * cell.x + (across - 1) as f32 * GAP,
        down as f32 * cell.y + (down - 1) as f32 * GAP,
    );
    let from = room.center() - 0.5 * whole;
    for (step, said) in STEPS.iter().enumerate() {
        let (column, row) = (step % across, step / across);
        let at = from + vec2(column as f32 * (cell.x + GAP), row as f32 * (cell.y + GAP));
        let cell = Rect::from_min_size(at, cell);
        let picture = Rect::from_center_size(pos2(cell.center().x, cell.top() + 0.5 * size.y), size);
        draw(ui, picture, step);
        words(ui, Rect::from_min_max(pos2(cell.left(), picture.bottom() + 8.0), cell.max), said);
    }
}

/// Words in the middle of a place, from its top.
fn words(ui: &Ui, place: Rect, said: &str) {
    let (font, colour) = (egui::TextStyle::Body.resolve(ui.style()), ui.visuals().text_color());
    let mut job = egui::text::LayoutJob::simple(said.to_owned(), font, colour, place.width());
    job.halign = egui::Align::Center;
    let galley = ui.painter().layout_job(job);
    ui.painter().galley(place.center_top(), galley, colour);
}

/// The picture of a step: a face, a take's curves, or a marker that is dragged.
fn draw(ui: &Ui, place: Rect, step: usize) {
    let visuals = ui.visuals();
    let line = Stroke::new(1.5, visuals.text_color());
    let painter = ui.painter();
    painter.rect(
        place,
        6.0,
        visuals.panel_fill,
        Stroke::new(1.0, visuals.weak_text_color()),
        egui::StrokeKind::Inside,
    );
    match step {
        0 => face(ui, place, Vec2::ZERO, line),
        1 => {
            // Curves of markers over time, with the play head.
            let inside = place.shrink(0.12 * place.width());
            for (row, (waves, height)) in [(1.5, 0.10), (2.5, 0.07), (1.0, 0.12)].into_iter().enumerate() {
                let middle = inside.top() + (0.2 + 0.3 * row as f32) * inside.height();
                let points = (0..=48).map(|i| {
                    let part = i as f32 / 48.0;
                    let y = middle + height * inside.height() * (part * waves * std::f32::consts::TAU).sin();
                    pos2(inside.left() + part * inside.width(), y)
                });
                painter.line(points.collect(), line);
            }
            let head = inside.left() + 0.62 * inside.width();
            painter.vline(head, inside.y_range(), Stroke::new(2.0, theme::MARKED));
        }
        _ => {
            let by = vec2(0.11 * place.width(), -0.06 * place.height());
            face(ui, place, by, line);
            let from = corner(place);
            painter.circle_stroke(from, 0.02 * place.width(), line);
            painter.line_segment([from, from + by], Stroke::new(2.0, theme::MARKED));
            painter.circle_filled(from + by, 0.03 * place.width(), theme::MARKED);
        }
    }
}

/// The corner of the mouth.
fn corner(place: Rect) -> Pos2 {
    place.center() + vec2(0.10 * place.width(), 0.20 * place.height())
}

/// A face with markers. The corner of its mouth is pulled.
fn face(ui: &Ui, place: Rect, pulled: Vec2, line: Stroke) {
    let (painter, c) = (ui.painter(), place.center());
    let (w, h) = (place.width(), place.height());
    let outline = (0..=40).map(|i| {
        let angle = i as f32 / 40.0 * std::f32::consts::TAU;
        // A chin is narrower than a forehead.
        let narrow = 1.0 - 0.18 * angle.sin().max(0.0);
        c + vec2(0.26 * w * narrow * angle.cos(), 0.42 * h * angle.sin())
    });
    painter.line(outline.collect(), line);
    for side in [-1.0, 1.0] {
        let eye = c + vec2(side * 0.10 * w, -0.10 * h);
        painter.line_segment([eye - vec2(0.045 * w, 0.0), eye + vec2(0.045 * w, 0.0)], line);
        marker(ui, eye + vec2(0.0, -0.09 * h), w);
        marker(ui, c + vec2(side * 0.18 * w, 0.06 * h), w);
    }
    let (left, right) = (c + vec2(-0.10 * w, 0.20 * h), corner(place) + pulled);
    let middle = c + vec2(0.0, 0.23 * h);
    painter.line(vec![left, middle, right], line);
    marker(ui, left, w);
    if pulled == Vec2::ZERO {
        marker(ui, right, w);
    }
    marker(ui, c + vec2(0.0, 0.36 * h), w);
}

fn marker(ui: &Ui, at: Pos2, width: f32) {
    ui.painter().circle(at, 0.02 * width, ui.visuals().strong_text_color(), (0.5, Color32::GRAY));
}
