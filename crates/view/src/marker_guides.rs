//! Guides over the picture for the markers that are held: names, values, the reach, the mirror partner.

use crate::scene::Scene;
use crate::settings::Settings;
use crate::theme;
use eframe::egui::{self, Align2, Color32, Pos2, Rect, Stroke, pos2, vec2};
use glam::Vec3;
use rhytid_core::{Rig, VertexId};
use rhytid_kernels::normals::vertex_normal;

/// A marker whose skin is turned away farther than this has no name in the picture. It is the cosine of the
/// angle between the skin's normal and the direction of the viewer.
const TURNED_AWAY: f32 = 0.1;

/// The distance of a name from its marker, in points.
const BESIDE: f32 = 9.0;

/// H unit vectors: the normals of the skin at the handles, at rest.
pub(crate) fn normals(rig: &Rig) -> Vec<Vec3> {
    let surface = rig.surface();
    let around = surface.vertex_triangles();
    let normal = |v: VertexId| {
        let [begin, end] = [0, 1].map(|next| around.offsets[v.index() + next] as usize);
        vertex_normal(&surface.rest, &surface.triangles, &around.triangles[begin..end]).map(f64::from)
    };
    let points = rig.handles().points.iter();
    points.map(|point| Vec3::from(point.mean(normal).map(|x| x as f32)).normalize_or_zero()).collect()
}

/// Draws the guides over the picture at `rect`.
pub(crate) fn show(scene: &Scene, settings: &Settings, ui: &egui::Ui, rect: Rect) {
    if !settings.markers {
        return;
    }
    let handles = scene.document.handles(true);
    let camera = scene.orbit.camera();
    let scale = ui.ctx().pixels_per_point();
    let place = |handle: usize| {
        let [x, y, depth] = camera.project(scene.size(), handles[handle]);
        let at = pos2(rect.left() + x / scale, rect.top() + y / scale);
        ((0.0..=1.0).contains(&depth) && rect.contains(at)).then_some(at)
    };
    let held = scene.held();
    for &handle in &held {
        if let Some(partner) = scene.document.soft_selection().mirror_of(handle).filter(|p| *p != handle)
            && let Some(at) = place(partner)
        {
            ring(ui, rect, at, 8.0, 2.0);
        }
    }
    if let Some(&last) = held.last()
        && settings.reach > 0.0
        && let Some(at) = place(last)
    {
        let reach = settings.reach / scene.millimetres();
        let unit = Vec3::from(scene.orbit.moved(handles[last], [1.0, 0.0], rect.height())).length();
        ring(ui, rect, at, reach / unit, 1.0);
    }
    let eye = Vec3::from(camera.eye());
    let away = |handle: usize| eye.distance(handles[handle].into());
    let mut named: Vec<usize> = held.clone();
    if settings.names {
        let is_seen = |handle: &usize| {
            let toward = (eye - Vec3::from(handles[*handle])).normalize_or_zero();
            toward.dot(scene.normals[*handle]) > TURNED_AWAY && !held.contains(handle)
        };
        let mut others: Vec<usize> = (0..handles.len()).filter(is_seen).collect();
        others.sort_by(|a, b| away(*a).total_cmp(&away(*b)));
        named.extend(others);
    }
    let labels = &scene.document.rig.handles().labels;
    let mut taken = Vec::new();
    for handle in named.into_iter().filter(|handle| scene.under != Some(*handle)) {
        if let Some(at) = place(handle) {
            name(ui, &labels[handle], at, &mut taken);
        }
    }
    if let Some((handle, at)) = scene.under.and_then(|handle| Some((handle, place(handle)?))) {
        values(scene, ui, handle, at);
    }
}

/// Writes a name beside its marker, if no other name is there.
fn name(ui: &egui::Ui, words: &str, at: Pos2, taken: &mut Vec<Rect>) {
    let (font, colour) = (egui::TextStyle::Small.resolve(ui.style()), ui.visuals().strong_text_color());
    let galley = ui.painter().layout_no_wrap(words.to_owned(), font, colour);
    let sides = [(BESIDE, Align2::LEFT_CENTER), (-BESIDE, Align2::RIGHT_CENTER)];
    for (off, align) in sides {
        let place = align.anchor_size(at + vec2(off, 0.0), galley.size()).expand(1.0);
        if taken.iter().all(|other| !other.intersects(place)) {
            ui.painter().rect_filled(place, 2.0, theme::over_picture(ui.visuals()));
            ui.painter().galley(place.min + vec2(1.0, 1.0), galley, colour);
            taken.push(place);
            return;
        }
    }
}

/// The name of the marker under the pointer, its values, and what is wrong with it.
fn values(scene: &Scene, ui: &egui::Ui, handle: usize, at: Pos2) {
    let document = &scene.document;
    let labels = &document.rig.handles().labels;
    let block = egui::Area::new(egui::Id::unique("marker under the pointer"));
    let block = block.order(egui::Order::Tooltip).interactable(false).constrain(true);
    block.fixed_pos(at + vec2(14.0, 10.0)).show(ui.ctx(), |ui| {
        egui::Frame::popup(ui.style()).show(ui, |ui| {
            ui.set_max_width(280.0);
            ui.strong(&labels[handle]);
            let [x, y, z, length] = document.from_rest(handle);
            ui.label(format!("{length:.2} mm from rest ({x:.2}, {y:.2}, {z:.2})"));
            match document.soft_selection().mirror_of(handle) {
                Some(other) if other == handle => ui.label("in the middle of the face"),
                Some(other) => ui.label(format!("mirror: {}", labels[other])),
                None => ui.label("has no mirror partner"),
            };
            for problem in document.problems().iter().filter(|problem| problem.handles.contains(&handle)) {
                coloured(ui, problem.kind.colour(), &problem.words);
            }
        });
    });
}

/// Words behind a dot of a colour.
pub(crate) fn coloured(ui: &mut egui::Ui, colour: Color32, words: &str) {
    ui.horizontal_top(|ui| {
        let height = ui.text_style_height(&egui::TextStyle::Body);
        let (dot, _) = ui.allocate_exact_size(vec2(10.0, height), egui::Sense::hover());
        ui.painter().circle(dot.center(), 4.0, colour, Stroke::new(1.0, ui.visuals().text_color()));
        ui.add(egui::Label::new(words).wrap());
    });
}

/// A circle with a rim, since the picture behind it may have any colour.
fn ring(ui: &egui::Ui, clip: Rect, at: Pos2, radius: f32, width: f32) {
    let painter = ui.painter().with_clip_rect(clip);
    painter.circle_stroke(
        at,
        radius,
        Stroke::new(width + 2.0, ui.visuals().extreme_bg_color.gamma_multiply(0.6)),
    );
    painter.circle_stroke(at, radius, Stroke::new(width, theme::MARKED));
}
