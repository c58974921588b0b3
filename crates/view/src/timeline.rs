//! The take's time line: its controls, and the strip with its rulers, the range that plays, and the events.

use crate::app::ViewApp;
use crate::commands::Command;
use crate::document::Document;
use crate::events::{self, Event, EventKind};
use crate::ruler::{Ruler, frame_marks, second_marks};
use crate::theme;
use crate::transport::Repeat;
use eframe::egui::{self, Align2, FontId, Pos2, Rect, Sense, pos2, vec2};

/// The heights of the strip's rows, in points.
const RANGE: f32 = 14.0;
const RULER: f32 = 15.0;
const LANE: f32 = 11.0;
/// The size of the rulers' numbers, in points.
const NUMBERS: f32 = 11.5;
/// Room beside the first and the last frame, for the handles of the range.
const MARGIN: f32 = 8.0;

pub(crate) fn show(app: &mut ViewApp, ui: &mut egui::Ui) {
    let mut wanted = Vec::new();
    let width = ui.ctx().content_rect().width();
    let events = app.document().map(events::of).unwrap_or_default();
    let are_listed = app.events_shown;
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
        if document.is_live() {
            ui.label("live");
            return;
        }
        if document.transport.frames() < 2 {
            ui.weak(if document.is_mesh() {
                "a mesh that does not move"
            } else {
                "no take: drop one on the window"
            });
            return;
        }
        controls(document, ui, &mut wanted);
        let frames = document.transport.frames();
        events::controls(&events, frames, are_listed, ui, &mut wanted);
    });
    if let Some(scene) = &mut app.scene
        && scene.document.transport.frames() > 1
        && !scene.document.is_live()
    {
        strip(&mut scene.document, &events, ui);
    }
    wanted.into_iter().for_each(|command| app.run(command, ui));
}

/// The buttons and fields of the play head.
fn controls(document: &mut Document, ui: &mut egui::Ui, wanted: &mut Vec<Command>) {
    let transport = &mut document.transport;
    let mut button = |ui: &mut egui::Ui, words: &str, command| {
        if ui.button(words).clicked() {
            wanted.push(command);
        }
    };
    button(ui, if transport.playing { "Stop" } else { "Play" }, Command::Play);
    button(ui, "Previous", Command::Step(-1));
    button(ui, "Next", Command::Step(1));
    let repeat = egui::ComboBox::from_id_salt("repeat").width(76.0).selected_text(transport.repeat.name());
    let repeat = repeat.show_ui(ui, |ui| {
        for repeat in Repeat::ALL {
            ui.selectable_value(&mut transport.repeat, repeat, repeat.name());
        }
    });
    repeat.response.on_hover_text("at the end of the range (L)");
    let mut frame = transport.frame();
    let last = transport.frames() - 1;
    let label = ui.label("Frame");
    let field = egui::DragValue::new(&mut frame).range(0..=last);
    if ui.add(field).labelled_by(label.id).changed() {
        transport.seek(frame);
    }
    // The text is never wrapped, for any width of the window.
    ui.add(egui::Label::new(format!("of {last}   {:.2} s", transport.time())).extend());
    let speed = egui::DragValue::new(&mut transport.speed).range(0.05..=8.0).speed(0.01).max_decimals(2);
    ui.add(speed.suffix(" × the take's rate"));
    if !transport.plays_all() {
        let [first, last] = transport.range();
        button(ui, &format!("Play all, not {first} to {last}"), Command::ResetRange);
    }
}

/// The strip's rows, from top to bottom.
struct Rows {
    range: Rect,
    seconds: Rect,
    frames: Rect,
    /// What was found in the take.
    found: Rect,
    /// What was changed on purpose.
    wanted: Rect,
}

impl Rows {
    fn new(strip: Rect) -> Self {
        let mut top = strip.top();
        let mut row = |height: f32| {
            let row = Rect::from_x_y_ranges(strip.x_range(), top..=top + height);
            top += height;
            row
        };
        Self {
            range: row(RANGE),
            seconds: row(RULER),
            frames: row(RULER),
            found: row(LANE),
            wanted: row(LANE),
        }
    }

    /// The rows whose numbers are at the play head.
    fn rulers(&self) -> Rect {
        self.seconds.union(self.frames)
    }

    fn lane(&self, event: &Event) -> Rect {
        if event.kind.is_wanted() { self.wanted } else { self.found }
    }
}

/// All frames from left to right. The play head follows the pointer.
fn strip(document: &mut Document, events: &[Event], ui: &mut egui::Ui) {
    let size = vec2(ui.available_width(), RANGE + 2.0 * RULER + 2.0 * LANE + 2.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    let frames = document.transport.frames();
    let frame = document.transport.frame();
    response.widget_info(|| {
        let mut info = egui::WidgetInfo::slider(ui.is_enabled(), frame as f64, "Time line");
        info.value = Some(frame as f64);
        info
    });
    let rows = Rows::new(rect);
    let ruler = Ruler::new(rect.shrink2(vec2(MARGIN, 0.0)).x_range(), document.transport.times());
    if let Some(at) = response.interact_pointer_pos() {
        document.transport.seek(ruler.frame_at(at.x));
    }
    let is_at = |event: &&Event, at: Pos2| {
        !event.is_whole(frames) && bar(event, &ruler, &rows).expand(2.0).contains(at)
    };
    if let Some(at) = response.interact_pointer_pos().filter(|_| response.clicked())
        && let Some(pull) = events.iter().filter(|event| is_at(event, at)).find_map(Event::pull)
    {
        document.select_pull(Some(pull));
    }
    if response.has_focus() {
        let keys = egui::EventFilter { horizontal_arrows: true, ..Default::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, keys));
        let step = ui.input(|input| {
            let pressed = |key| input.num_presses(key) as isize;
            pressed(egui::Key::ArrowRight) - pressed(egui::Key::ArrowLeft)
        });
        if step != 0 {
            document.transport.step(step);
        }
    }
    ui.painter().rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
    numbers(document, &ruler, &rows, ui);
    bars(document, events, &ruler, &rows, ui);
    range(document, &ruler, &rows, ui);
    head(document, &ruler, &rows, ui);
    let Some(over) = response.hover_pos() else { return };
    let here = ruler.frame_at(over.x);
    let told = events.iter().filter(|event| is_at(event, over));
    let told = events::in_words(told, frames);
    let words = match told.is_empty() {
        true => format!("frame {here}, {:.2} s", document.transport.times()[here]),
        false => told,
    };
    response.on_hover_text_at_pointer(words);
}

/// The rulers: round seconds, and round frames below them.
fn numbers(document: &Document, ruler: &Ruler, rows: &Rows, ui: &egui::Ui) {
    let painter = ui.painter();
    let font = FontId::proportional(NUMBERS);
    let colour = ui.visuals().weak_text_color();
    let line = ui.visuals().widgets.noninteractive.bg_stroke;
    let width = |words: &str| painter.layout_no_wrap(words.to_owned(), font.clone(), colour).size().x;
    let times = document.transport.times();
    let seconds = second_marks(ruler, times, |words| width(words));
    let frames = frame_marks(ruler, times.len(), |words| width(words));
    for (row, marks) in [(rows.seconds, seconds), (rows.frames, frames)] {
        for mark in marks {
            painter.vline(mark.x, row.top() + 1.0..=row.bottom() - 1.0, line);
            let galley = painter.layout_no_wrap(mark.words, font.clone(), colour);
            let place = Align2::LEFT_CENTER.anchor_size(pos2(mark.x + 3.0, row.center().y), galley.size());
            // At the very end, a line has no room for its number.
            if place.right() < row.right() {
                painter.galley(place.min, galley, colour);
            }
        }
    }
    painter.hline(rows.range.x_range(), rows.frames.bottom(), line);
}

/// The place of an event.
fn bar(event: &Event, ruler: &Ruler, rows: &Rows) -> Rect {
    let [first, last] = event.frames;
    let (left, right) = (ruler.x(first), ruler.x(last).max(ruler.x(first) + 2.0));
    let lane = rows.lane(event).shrink(2.0);
    // A gap is a thin line, over which all else is seen.
    let top = if event.kind == EventKind::Gap { lane.bottom() - 2.0 } else { lane.top() };
    Rect::from_x_y_ranges(left - 1.0..=right + 1.0, top..=lane.bottom())
}

/// The events that do not last as long as the take. What is in doubt is drawn over what was found.
fn bars(document: &Document, events: &[Event], ruler: &Ruler, rows: &Rows, ui: &egui::Ui) {
    let frames = document.transport.frames();
    for kind in EventKind::ALL {
        let shown = events.iter().filter(|event| event.kind.looks_as(kind) && !event.is_whole(frames));
        for event in shown {
            let bar = bar(event, ruler, rows);
            ui.painter().rect_filled(bar, 1.0, kind.colour());
            if document.selected_pull().is_some_and(|pull| event.kind == EventKind::Pull(pull)) {
                let stroke = egui::Stroke::new(1.0, ui.visuals().strong_text_color());
                ui.painter().rect_stroke(bar, 1.0, stroke, egui::StrokeKind::Outside);
            }
        }
    }
}

/// The range that plays, with a handle at each end. Frames outside of it are darker.
fn range(document: &mut Document, ruler: &Ruler, rows: &Rows, ui: &mut egui::Ui) {
    let transport = &mut document.transport;
    let whole = rows.range.union(rows.wanted);
    let ends = [("Begin of the range", Align2::RIGHT_TOP), ("End of the range", Align2::LEFT_TOP)];
    for (end, (name, side)) in ends.into_iter().enumerate() {
        let frame = transport.range()[end];
        // Fingers reach a handle that is wider than it looks.
        let seen = side.anchor_size(pos2(ruler.x(frame), rows.range.top()), vec2(MARGIN, RANGE));
        let reach = seen.expand2(vec2(6.0, 2.0));
        let response = ui.interact(reach, ui.scope_id().with(name), Sense::click_and_drag());
        response.widget_info(|| {
            let mut info = egui::WidgetInfo::slider(ui.is_enabled(), frame as f64, name);
            info.value = Some(frame as f64);
            info
        });
        if let Some(at) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            // A handle stops at the other one.
            let [first, last] = transport.range();
            match end {
                0 => transport.set_begin(ruler.frame_at(at.x).min(last)),
                _ => transport.set_end(ruler.frame_at(at.x).max(first)),
            }
        }
        let colour = match response.hovered() || response.dragged() || response.has_focus() {
            true => theme::MARKED,
            false => ui.visuals().weak_text_color(),
        };
        ui.painter().rect_filled(seen, 2.0, colour);
        let response = response.on_hover_cursor(egui::CursorIcon::ResizeHorizontal);
        response.on_hover_text(format!("{name}: frame {frame} ({})", if end == 0 { "I" } else { "O" }));
    }
    let [first, last] = transport.range().map(|frame| ruler.x(frame));
    let between = Rect::from_x_y_ranges(first..=last, rows.range.shrink2(vec2(0.0, 5.0)).y_range());
    ui.painter().rect_filled(between, 0.0, ui.visuals().weak_text_color());
    let shade = ui.visuals().panel_fill.gamma_multiply(0.75);
    for outside in [whole.left()..=first - MARGIN, last + MARGIN..=whole.right()] {
        if !transport.plays_all() && outside.start() < outside.end() {
            ui.painter().rect_filled(Rect::from_x_y_ranges(outside, whole.y_range()), 0.0, shade);
        }
    }
}

/// The play head, with its second and its frame.
fn head(document: &Document, ruler: &Ruler, rows: &Rows, ui: &egui::Ui) {
    let painter = ui.painter();
    let transport = &document.transport;
    let x = ruler.x(transport.frame());
    let whole = rows.range.union(rows.wanted);
    painter.vline(x, whole.y_range(), egui::Stroke::new(2.0, ui.visuals().strong_text_color()));
    let font = FontId::proportional(NUMBERS);
    let colour = ui.visuals().strong_text_color();
    let numbers = [format!("{:.2} s", transport.time()), transport.frame().to_string()];
    let galleys = numbers.map(|words| painter.layout_no_wrap(words, font.clone(), colour));
    let width = galleys.iter().map(|galley| galley.size().x).fold(0.0, f32::max) + 8.0;
    // The numbers stand right of the line, or left of it where there is no room.
    let left = if x + 2.0 + width > whole.right() { x - 2.0 - width } else { x + 2.0 };
    let flag = Rect::from_x_y_ranges(left..=left + width, rows.rulers().y_range());
    painter.rect_filled(flag, 3.0, ui.visuals().widgets.active.weak_bg_fill);
    for (row, galley) in [rows.seconds, rows.frames].into_iter().zip(galleys) {
        painter.galley(pos2(left + 4.0, row.center().y - 0.5 * galley.size().y), galley, colour);
    }
}
