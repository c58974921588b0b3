//! The panel at the side.

use crate::app::ViewApp;
use crate::commands::Command;
use crate::legend::Spread;
use crate::marker_values;
use crate::pull_panel;
use crate::scene::Scene;
use crate::settings::{Before, Settings, Show};
use eframe::egui;
use rhytid_core::{Explanation, HandleShare, Rig, human, scale};
use rhytid_formats::mesh::Numbers;
use rhytid_render::Look;
use std::cmp::Ordering;

/// The number of rows of a vertex's table.
const ROWS: usize = 8;

pub(crate) fn show(app: &mut ViewApp, ui: &mut egui::Ui) {
    let mut wanted = Vec::new();
    ui.add_space(4.0);
    ui.horizontal_wrapped(|ui| {
        #[cfg(not(target_arch = "wasm32"))]
        opening(app, ui);
        for (words, command) in
            [("Whole face", Command::All), ("Front", Command::Front), ("Side", Command::Side)]
        {
            if ui.button(words).clicked() {
                wanted.push(command);
            }
        }
        if ui.button("Keys").clicked() {
            wanted.push(Command::Keys);
        }
    });
    let numbers = app.scene.as_ref().map_or(&[][..], |scene| scene.document.numbers());
    let spread = app.scene.as_ref().and_then(|scene| scene.spread);
    let is_mesh = app.scene.as_ref().is_some_and(|scene| scene.document.is_mesh());
    section(ui, "Look", true, |ui| look(&mut app.settings, numbers, Shown { is_mesh, spread }, ui));
    if is_mesh {
        section(ui, "Markers", true, |ui| ui.weak("a mesh has no markers: open a rig to drag them"));
    } else if let Some(scene) = &mut app.scene {
        section(ui, "Markers", true, |ui| markers(scene, &mut app.settings, ui, &mut wanted));
        section(ui, "Problems", true, |ui| marker_values::problems(scene, ui));
        section(ui, "Pulls", true, |ui| pull_panel::show(&mut scene.document, ui, &mut wanted));
    }
    #[cfg(not(target_arch = "wasm32"))]
    section(ui, "Repairs", false, |ui| crate::repairs::show(app, ui));
    section(ui, "Device", true, |ui| device(app, ui));
    #[cfg(not(target_arch = "wasm32"))]
    {
        section(ui, "Live", true, |ui| live(app, ui));
        section(ui, "Save", false, |ui| {
            for (words, command) in [
                ("The frame as a take", Command::SaveFrame),
                ("The frame as a mesh, for an example", Command::SaveExample),
                ("The pulls of markers, as an edit", Command::SaveEdits),
                ("The picture", Command::Screenshot),
            ] {
                if ui.add_enabled(app.scene.is_some(), egui::Button::new(words)).clicked() {
                    wanted.push(command);
                }
            }
            exports(app, ui, &mut wanted);
        });
    }
    section(ui, "Window", false, theme);
    // This comes last, as it is the longest.
    if let (Some(scene), false) = (&mut app.scene, is_mesh) {
        section(ui, "Vertex", true, |ui| vertex(scene, ui));
    }
    wanted.into_iter().for_each(|command| app.run(command, ui));
}

/// The buttons of exports. Only the range of the time line is exported.
#[cfg(not(target_arch = "wasm32"))]
fn exports(app: &ViewApp, ui: &mut egui::Ui, wanted: &mut Vec<Command>) {
    let document = app.document().filter(|document| document.take().is_some());
    if let Some(document) = document.filter(|document| !document.transport.plays_all()) {
        let [first, last] = document.transport.range();
        ui.weak(format!("of the take, frames {first} to {last}:"));
    }
    for (words, command) in [
        ("The take with edits, as USD", Command::ExportUsd),
        ("The take with edits, as GLB", Command::ExportGlb),
        ("A film of what is seen", Command::ExportFilm),
    ] {
        let can = document.is_some() && !app.is_exporting();
        if ui.add_enabled(can, egui::Button::new(words)).clicked() {
            wanted.push(command);
        }
    }
}

/// The button that opens files, and the files that were opened lately.
#[cfg(not(target_arch = "wasm32"))]
fn opening(app: &mut ViewApp, ui: &mut egui::Ui) {
    if ui.button("Open").clicked() {
        app.choose();
    }
    let recent = app.recent.there();
    ui.add_enabled_ui(!recent.is_empty(), |ui| {
        let mut chosen = None;
        ui.menu_button("Recent", |ui| {
            for file in recent {
                let name = file.file_name().map(|name| name.to_string_lossy().into_owned());
                let button = ui.button(name.unwrap_or_default()).on_hover_text(file.display().to_string());
                if button.clicked() {
                    chosen = Some(file);
                    ui.close();
                }
            }
        });
        if let Some(file) = chosen {
            app.open_paths(&[file]);
        }
    });
}

fn section<R>(ui: &mut egui::Ui, words: &str, is_open: bool, show: impl FnOnce(&mut egui::Ui) -> R) {
    egui::CollapsingHeader::new(words).default_open(is_open).show(ui, show);
}

/// A slider with its label before it. The label is also its name for accessibility.
fn slider(ui: &mut egui::Ui, words: &str, slider: egui::Slider<'_>) {
    let label = ui.label(words);
    ui.add(slider).labelled_by(label.id);
}

/// The choice between light and dark.
fn theme(ui: &mut egui::Ui) {
    use egui::ThemePreference::{Dark, Light, System};
    let mut theme = ui.options(|options| options.theme_preference);
    ui.horizontal_wrapped(|ui| {
        for (value, words) in [(System, "as the system"), (Light, "light"), (Dark, "dark")] {
            ui.selectable_value(&mut theme, value, words);
        }
    });
    ui.ctx().set_theme(theme);
}

/// What is shown, and its numbers.
#[derive(Clone, Copy)]
struct Shown {
    is_mesh: bool,
    spread: Option<Spread>,
}

fn look(settings: &mut Settings, numbers: &[Numbers], shown: Shown, ui: &mut egui::Ui) {
    let Shown { is_mesh, spread } = shown;
    let of_file = numbers.get(settings.numbers).filter(|_| settings.show == Show::Numbers);
    let shown = of_file.map_or(settings.show.name(), |(name, _)| name);
    egui::ComboBox::from_label("shown").selected_text(shown).show_ui(ui, |ui| {
        for show in Show::ALL {
            ui.add_enabled_ui(!(is_mesh && show.needs_rig()), |ui| {
                ui.selectable_value(&mut settings.show, show, show.name())
                    .on_disabled_hover_text("needs a rig, and a mesh is open");
            });
        }
        for (i, (name, list)) in numbers.iter().enumerate() {
            let is_shown = settings.show == Show::Numbers && settings.numbers == i;
            if ui.selectable_label(is_shown, name).clicked() {
                settings.show_numbers(i, list);
            }
        }
    });
    if !is_mesh {
        of_rig(settings, ui);
    }
    if settings.show == Show::Skin {
        let [right, up] = &mut settings.light;
        slider(ui, "Light from the right", egui::Slider::new(right, -180.0..=180.0).suffix("°"));
        slider(ui, "Light from above", egui::Slider::new(up, -90.0..=90.0).suffix("°"));
    }
    map_scale(settings, of_file.map_or("", |(name, _)| name), spread, ui);
}

/// The scale of the map that is shown, and what lies beyond it.
fn map_scale(settings: &mut Settings, name: &str, spread: Option<Spread>, ui: &mut egui::Ui) {
    if settings.look().is_some_and(|look| matches!(look, Look::Heat(_) | Look::LitHeat(_))) {
        ui.checkbox(&mut settings.lit_maps, "Lit")
            .on_hover_text("light shows the form; without it, the colours are exactly those of the legend");
    }
    let Some(map) = settings.map(name) else { return };
    let (factor, unit) = (map.factor, map.unit);
    // There is a line in every frame, so that nothing below it jumps while a take plays.
    let words = spread.map(|spread| {
        let part = human::percent(f64::from(spread.beyond), 1);
        format!("beyond the scale: {part}, largest: {} {unit}", map.words(spread.largest()))
    });
    let Some(end) = settings.map_end() else { return };
    let mut shown = factor * *end;
    let range = egui::Slider::new(&mut shown, factor * 1e-3..=factor * 1e3).logarithmic(true);
    let suffix = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    slider(ui, "Scale to", range.max_decimals(4).suffix(suffix));
    // Scales end at round numbers.
    match shown.partial_cmp(&(factor * *end)) {
        Some(Ordering::Greater) => *end = scale::round_up(shown / factor),
        Some(Ordering::Less) => *end = scale::round_down(shown / factor),
        _ => {}
    }
    if let (Some(words), Some(spread)) = (words, spread) {
        ui.label(words);
        let fit = egui::Button::new("Fit the scale");
        if ui.add_enabled(spread.largest() > 0.0, fit).clicked() {
            *end = scale::round_up(spread.largest());
        }
    }
}

/// What a rig's frames have, and a mesh has not.
fn of_rig(settings: &mut Settings, ui: &mut egui::Ui) {
    egui::ComboBox::from_label("comparison").selected_text(settings.before.name()).show_ui(ui, |ui| {
        for before in Before::ALL {
            ui.selectable_value(&mut settings.before, before, before.name());
        }
    });
    if settings.before != Before::Off {
        slider(ui, "Wipe", egui::Slider::new(&mut settings.wipe, 0.0..=1.0));
    }
    slider(ui, "Wrinkles", egui::Slider::new(&mut settings.gain, 0.0..=2.0).suffix(" ×"));
}

fn markers(scene: &mut Scene, settings: &mut Settings, ui: &mut egui::Ui, wanted: &mut Vec<Command>) {
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut settings.markers, "Dots");
        ui.add_enabled(settings.markers, egui::Checkbox::new(&mut settings.names, "Names"));
        ui.checkbox(&mut settings.mirrored, "Mirrored");
    });
    slider(ui, "Reach", egui::Slider::new(&mut settings.reach, 0.0..=120.0).suffix(" mm"));
    if let Some((name, mut shown)) = scene.document.edits().map(|(name, shown)| (name.to_owned(), shown))
        && ui.checkbox(&mut shown, format!("Edited by {name}")).changed()
    {
        scene.document.show_edited(shown);
    }
    let document = &scene.document;
    if scene.selected.is_empty() {
        ui.label("no marker selected: click one, or press N");
    }
    let (pose, [can_undo, can_redo]) = (document.pose(), document.can_undo_and_redo());
    let is_dragged = !pose.pulls.is_empty();
    let is_pinned = !scene.selected.is_empty() && scene.selected.iter().all(|&handle| pose.pinned[handle]);
    ui.horizontal_wrapped(|ui| {
        for (words, can, command) in [
            ("Undo", can_undo, Command::Undo),
            ("Redo", can_redo, Command::Redo),
            ("Reset", is_dragged, Command::Reset),
            (if is_pinned { "Unpin" } else { "Pin" }, !scene.selected.is_empty(), Command::Pin),
        ] {
            if ui.add_enabled(can, egui::Button::new(words)).clicked() {
                wanted.push(command);
            }
        }
    });
    marker_values::show(scene, ui);
}

fn vertex(scene: &mut Scene, ui: &mut egui::Ui) {
    let last = scene.document.rig.vertices() - 1;
    let mut number = scene.vertex.unwrap_or_default();
    ui.horizontal(|ui| {
        let label = ui.label("Vertex");
        let field = egui::DragValue::new(&mut number).range(0..=last);
        if ui.add(field).labelled_by(label.id).changed() {
            scene.vertex = Some(number);
        }
    });
    match scene.explanation() {
        Ok(Some(explanation)) => table(ui, &scene.document.rig, &explanation),
        Ok(None) => {
            ui.weak("click the skin to list what drives that vertex");
        }
        Err(error) => {
            ui.label(error.to_string());
        }
    }
}

/// The table of what drives a vertex in the frame that is shown.
fn table(ui: &mut egui::Ui, rig: &Rig, explanation: &Explanation) {
    let rows = |ui: &mut egui::Ui, title: [&str; 3], rows: Vec<[String; 3]>| {
        if rows.is_empty() {
            return;
        }
        egui::Grid::new(title[0]).num_columns(3).striped(true).show(ui, |ui| {
            title.iter().for_each(|words| {
                ui.strong(*words);
            });
            ui.end_row();
            for row in rows {
                row.iter().for_each(|cell| {
                    ui.label(cell);
                });
                ui.end_row();
            }
        });
        ui.add_space(4.0);
    };
    let millimetres = 1e3 * rig.surface().metres_per_unit;
    let handles = explanation.handles.iter().take(ROWS / 2);
    let handle = |share: &HandleShare| {
        [rig.handles().labels[share.handle.index()].clone(), format!("{:.2}", share.weight), String::new()]
    };
    rows(ui, ["handle", "weight", ""], handles.map(handle).collect());
    let edges = explanation.edges.iter().take(ROWS).map(|edge| {
        let [a, b] = rig.handles().strain_edges[edge.edge.index()]
            .map(|handle| &*rig.handles().labels[handle.index()]);
        [format!("{a} – {b}"), format!("{:.2}", edge.weight), format!("{:+.1} %", 100.0 * edge.strain)]
    });
    rows(ui, ["strain edge", "weight", "strain"], edges.collect());
    let mut examples: Vec<_> = explanation.examples.iter().zip(&rig.examples().names).collect();
    let size = |wrinkle: &[f64; 3]| wrinkle.iter().map(|x| x * x).sum::<f64>().sqrt();
    examples.sort_by(|a, b| a.0.distance.total_cmp(&b.0.distance));
    let examples = examples.into_iter().take(ROWS).map(|(example, name)| {
        let wrinkle = millimetres * size(&example.wrinkle);
        [name.clone(), format!("{:.3}", example.distance), format!("{wrinkle:.2} mm")]
    });
    rows(ui, ["example", "distance", "wrinkles"], examples.collect());
    ui.label(format!(
        "distance from rest {:.3}; all wrinkles {:.2} mm",
        explanation.from_rest,
        millimetres * size(&explanation.wrinkle())
    ));
}

fn device(app: &mut ViewApp, ui: &mut egui::Ui) {
    ui.label(format!("drawn on {}", app.gpu.name()));
    if app.gpu.kernels().is_none() {
        ui.label("evaluated by the processor, since the device has no compute shaders");
    }
    let is_mesh = app.scene.as_ref().is_some_and(|scene| scene.document.is_mesh());
    if !app.devices.is_empty() && !is_mesh {
        let name = |device: &Option<rhytid_core::DeviceInfo>| match device {
            None => "the device that draws".to_owned(),
            Some(info) => format!("{} ({})", info.id(), info.name),
        };
        let mut chosen = app.device.clone();
        let offered: Vec<_> = std::iter::once(None).chain(app.devices.iter().cloned().map(Some)).collect();
        egui::ComboBox::from_label("evaluated").selected_text(name(&chosen)).width(150.0).show_ui(ui, |ui| {
            for device in offered {
                let words = name(&device);
                ui.selectable_value(&mut chosen, device, words);
            }
        });
        if chosen != app.device {
            match &mut app.scene {
                // The choice is shown when the rig is there.
                Some(scene) => scene.set_device(chosen),
                None => app.device = chosen,
            }
        }
    }
    let Some(scene) = &app.scene else { return };
    let rig = &scene.document.rig;
    match is_mesh {
        true => ui.label(format!("{} vertices", rig.vertices())),
        false => ui.label(format!("{} vertices, {} handles", rig.vertices(), rig.handles().len())),
    };
    if cfg!(not(target_arch = "wasm32")) {
        let ms = |time: web_time::Duration| 1e3 * time.as_secs_f64();
        let times = scene.times;
        ui.label(format!("evaluation {:.1} ms", ms(times.evaluation)));
        if !times.lighting.is_zero() {
            ui.label(format!("light in the skin {:.1} ms", ms(times.lighting)));
        }
        ui.label(format!("drawing {:.1} ms", ms(times.drawing)));
    }
}

#[cfg(not(target_arch = "wasm32"))]
fn live(app: &mut ViewApp, ui: &mut egui::Ui) {
    match &app.live {
        None => {
            if ui.button("Listen").clicked() {
                app.listen_for(crate::Listen::default());
            }
        }
        Some(live) => {
            ui.label(live.status());
            if ui.button("End").clicked() {
                app.stop_listening();
            }
        }
    }
}
