//! The face, and the actions of the pointer on it.

use crate::app::ViewApp;
use crate::painter::Then;
use crate::scene::{Scene, View};
use crate::settings::{Before, Settings};
use crate::{legend, marker_guides, theme, welcome};
use eframe::egui::{self, Color32, Pos2, Rect, Sense, Vec2, pos2};

/// The distance at which the pointer reaches a marker or the wipe's line, in points. A finger is wider.
const NEAR: f32 = 12.0;
const NEAR_FINGER: f32 = 26.0;

/// What the pointer holds, from press to release.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Holds {
    Wipe,
    /// Since it was at this place.
    Markers {
        from: Pos2,
        at: [f32; 3],
    },
    Camera,
    Pan,
}

pub(crate) fn show(app: &mut ViewApp, ui: &mut egui::Ui) {
    let rect = ui.available_rect_before_wrap();
    let response = ui.allocate_rect(rect, Sense::click_and_drag());
    response.widget_info(|| {
        let name = app.scene.as_ref().map_or("no face is open", |scene| scene.document.name.as_str());
        egui::WidgetInfo::labeled(egui::Role::Image, true, format!("Face: {name}"))
    });
    let background = ui.visuals().extreme_bg_color;
    ui.painter().rect_filled(rect, 0.0, background);
    if app.scene.is_none() {
        empty(app, ui, rect);
        return;
    }
    let (patience, now) = (app.patience(), app.seconds());
    let Some(scene) = &mut app.scene else { return };
    let scale = ui.ctx().pixels_per_point();
    let view = View {
        size: [rect.width(), rect.height()].map(|n| (n * scale).round().max(1.0) as u32),
        scale,
        background: background.to_array(),
        now,
        patience,
    };
    let aspect = |rect: Rect| rect.width().max(1.0) / rect.height().max(1.0);
    match scene.place.replace(rect) {
        Some(before) if scene.drawn > 0 => scene.orbit.reshape(aspect(before), aspect(rect)),
        _ => scene.orbit.all(aspect(rect)),
    }
    pointer(scene, &mut app.settings, ui, &response, view);
    let news = scene.draw(&app.settings, view);
    paint(scene, &app.settings, ui, rect);
    app.hear(news);
}

/// The message where nothing is open.
fn empty(app: &ViewApp, ui: &egui::Ui, rect: Rect) {
    if app.is_opening() {
        return;
    }
    welcome::show(ui, rect);
}

fn pointer(scene: &mut Scene, settings: &mut Settings, ui: &egui::Ui, response: &egui::Response, view: View) {
    let (rect, scale) = (response.rect, ui.ctx().pixels_per_point());
    let pixels = |at: Pos2| [(at.x - rect.left()) * scale, (at.y - rect.top()) * scale];
    let id = response.id.with("holds");
    let near = if ui.input(egui::InputState::any_touches) { NEAR_FINGER } else { NEAR };
    let (shift, touch) = ui.input(|input| (input.modifiers.shift, input.multi_touch()));
    let at = response.interact_pointer_pos().or(response.hover_pos());
    let is_free = ui.memory(|memory| memory.data.get_temp::<Holds>(id)).is_none();
    scene.under = at.filter(|_| is_free).and_then(|at| scene.marker_at(pixels(at), near * scale));

    if response.drag_started()
        && let Some(from) = ui.input(|input| input.pointer.press_origin()).or(at)
    {
        let line = rect.left() + settings.wipe * rect.width();
        let marker = scene.marker_at(pixels(from), near * scale);
        let is_middle = ui.input(|input| input.pointer.middle_down());
        let holds = match marker {
            _ if is_middle => Holds::Pan,
            _ if touch.is_some() => Holds::Camera,
            _ if settings.before != Before::Off && (from.x - line).abs() < near => Holds::Wipe,
            Some(marker) => {
                // Any of several selected markers drags them all.
                if !scene.selected.contains(&marker) {
                    take(scene, marker, shift);
                }
                scene.document.begin_drag();
                Holds::Markers { from, at: scene.document.handles(true)[marker] }
            }
            None if shift => Holds::Pan,
            None => Holds::Camera,
        };
        ui.memory_mut(|memory| memory.data.insert_temp(id, holds));
    }
    let holds = ui.memory(|memory| memory.data.get_temp::<Holds>(id));
    if let Some(touch) = touch {
        // Two fingers move the camera, even if the first of them lies on a marker.
        if let Some(Holds::Markers { .. }) = holds {
            scene.document.end_drag(false);
            ui.memory_mut(|memory| memory.data.insert_temp(id, Holds::Camera));
        }
        let Vec2 { x, y } = touch.translation_delta;
        scene.orbit.pan([x, y], rect.height());
        zoom(scene, touch.zoom_delta, touch.center_pos, rect);
    } else if let Some(holds) = holds {
        let moved = response.drag_delta();
        match holds {
            Holds::Wipe => settings.wipe = (settings.wipe + moved.x / rect.width()).clamp(0.0, 1.0),
            Holds::Markers { from, at: point } => {
                // The place of the release. The pointer may have moved on before this frame.
                let at = ui.input(released).filter(|_| response.drag_stopped()).or(at);
                if let Some(at) = at.filter(|_| scene.document.is_dragging()) {
                    let by = scene.orbit.moved(point, [at.x - from.x, at.y - from.y], rect.height());
                    scene.drag(by, settings);
                }
            }
            Holds::Camera => scene.orbit.orbit([moved.x, moved.y]),
            Holds::Pan => scene.orbit.pan([moved.x, moved.y], rect.height()),
        }
    }
    if response.drag_stopped() {
        scene.document.end_drag(true);
        ui.memory_mut(|memory| memory.data.remove::<Holds>(id));
    }

    // Fingers have zoomed above.
    if let Some(over) = response.hover_pos().filter(|_| touch.is_none() && response.contains_pointer()) {
        let (scrolled, pinched) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        if scrolled != 0.0 || pinched != 1.0 {
            zoom(scene, pinched * (0.002 * scrolled).exp(), over, rect);
        }
    }
    if response.double_clicked()
        && let Some(at) = at
    {
        scene.pick(settings, view, pixels(at), Then::Focus);
    } else if response.clicked()
        && let Some(at) = at
    {
        match scene.marker_at(pixels(at), near * scale) {
            Some(marker) => take(scene, marker, shift),
            None => scene.pick(settings, view, pixels(at), Then::Explain),
        }
    }
}

/// The place where a button was released since the last frame.
fn released(input: &egui::InputState) -> Option<Pos2> {
    input.events.iter().find_map(|event| match event {
        egui::Event::PointerButton { pos, pressed: false, .. } => Some(*pos),
        _ => None,
    })
}

/// Selects a marker alone. With `more`, adds it to the selected ones, or removes it from them.
fn take(scene: &mut Scene, marker: usize, more: bool) {
    match (more, scene.selected.iter().position(|&selected| selected == marker)) {
        (false, _) => scene.selected = vec![marker],
        (true, Some(i)) => {
            scene.selected.remove(i);
        }
        (true, None) => scene.selected.push(marker),
    }
}

fn zoom(scene: &mut Scene, factor: f32, at: Pos2, rect: Rect) {
    let from = at - rect.min;
    scene.orbit.zoom(factor, [from.x, from.y], [rect.width(), rect.height()]);
}

fn paint(scene: &Scene, settings: &Settings, ui: &egui::Ui, rect: Rect) {
    let part = |from: f32, to: f32| {
        let x = |part: f32| rect.left() + part * rect.width();
        let place = Rect::from_min_max(pos2(x(from), rect.top()), pos2(x(to), rect.bottom()));
        (place, Rect::from_min_max(pos2(from, 0.0), pos2(to, 1.0)))
    };
    let wipe = if settings.before == Before::Off { 0.0 } else { settings.wipe };
    for (side, (from, to)) in [(0, (wipe, 1.0)), (1, (0.0, wipe))] {
        if let Some(texture) = scene.texture(side).filter(|_| to > from) {
            let (place, uv) = part(from, to);
            ui.painter().image(texture, place, uv, Color32::WHITE);
        }
    }
    if settings.before != Before::Off {
        let x = rect.left() + wipe * rect.width();
        // The line has a rim, since the picture behind it may have any colour.
        for (width, colour) in [(4.0, ui.visuals().extreme_bg_color), (1.5, ui.visuals().strong_text_color())]
        {
            ui.painter().vline(x, rect.y_range(), egui::Stroke::new(width, colour));
        }
        let y = rect.top() + 6.0;
        write(ui, pos2(x - 8.0, y), egui::Align2::RIGHT_TOP, settings.before.name());
        write(ui, pos2(x + 8.0, y), egui::Align2::LEFT_TOP, "result");
    }
    if let Some(map) = settings.map(scene.document.numbers_name(settings.numbers)) {
        legend::show(ui, rect, &map, scene.spread);
    }
    marker_guides::show(scene, settings, ui, rect);
}

/// Small text over the picture. It has its own background, since the picture behind it may have any colour.
fn write(ui: &egui::Ui, at: Pos2, align: egui::Align2, words: &str) {
    let (font, colour) = (egui::TextStyle::Small.resolve(ui.style()), ui.visuals().strong_text_color());
    let galley = ui.painter().layout_no_wrap(words.to_owned(), font, colour);
    let place = align.anchor_size(at, galley.size());
    ui.painter().rect_filled(place.expand(2.0), 2.0, theme::over_picture(ui.visuals()));
    ui.painter().galley(place.min, galley, colour);
}
