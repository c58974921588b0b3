//! Repairs of a take by hand: labels are exchanged, and positions are dropped or held, in the range of the
//! time line. The take is then read again, as the clean-up reads it with the same repairs. A take in another
//! space is read again in that space.

use crate::app::ViewApp;
use crate::document::Reading;
use crate::open::{self, Elsewhere};
use crate::save::free;
use eframe::egui;
use rhytid_capture::{Axes, Edit};
use rhytid_core::{Error, Result};
use rhytid_formats::take;
use std::path::PathBuf;

/// The buttons, and the number of markers that each needs.
const BUTTONS: [(&str, usize, &str); 3] = [
    ("Exchange labels", 2, "two markers that have each other's label"),
    ("Drop", 1, "positions that are wrong; they are filled as a gap"),
    ("Hold", 1, "the marker stays where it was on the face"),
];

/// The section of repairs.
pub(crate) fn show(app: &mut ViewApp, ui: &mut egui::Ui) {
    let Some(scene) = &app.scene else { return };
    let document = &scene.document;
    let Some(open) = document.take().filter(|_| !document.is_live()) else {
        ui.weak("open a take to repair it");
        return;
    };
    let labels = &document.rig.handles().labels;
    let selected: Vec<String> = scene.selected.iter().map(|&handle| labels[handle].clone()).collect();
    let [first, last] = document.transport.range();
    ui.label(format!("The selected markers, in frames {first} to {last}:"));
    let mut wanted = None;
    ui.horizontal_wrapped(|ui| {
        for (i, (words, count, hint)) in BUTTONS.into_iter().enumerate() {
            let can = selected.len() == count && !app.is_opening();
            let button = ui.add_enabled(can, egui::Button::new(words)).on_hover_text(hint);
            let markers = if count == 2 { "select two markers" } else { "select one marker" };
            if button.on_disabled_hover_text(format!("{hint}; {markers}")).clicked() {
                let frames = first..last + 1;
                wanted = Some(match (i, &selected[..]) {
                    (0, [a, b]) => Edit::Swap([a.clone(), b.clone()], frames),
                    (1, [marker, ..]) => Edit::Drop(marker.clone(), frames),
                    (_, [marker, ..]) => Edit::Hold(marker.clone(), frames),
                    (_, []) => return,
                });
            }
        }
    });
    let mut repairs = open.reading.repairs.clone();
    let mut deleted = None;
    for (i, repair) in repairs.iter().enumerate() {
        ui.horizontal(|ui| {
            if ui.button("Take back").clicked() {
                deleted = Some(i);
            }
            ui.add(egui::Label::new(in_words(repair)).truncate());
        });
    }
    let is_saved = ui
        .add_enabled(!repairs.is_empty(), egui::Button::new("Save the repaired take"))
        .on_disabled_hover_text("nothing is repaired yet")
        .clicked();
    if let Some(i) = deleted {
        repairs.remove(i);
    }
    let is_changed = deleted.is_some() || wanted.is_some();
    repairs.extend(wanted);
    if is_changed {
        app.repair(repairs);
    } else if is_saved {
        match app.save_repaired() {
            Ok(path) => app.saved(&path),
            Err(error) => app.tell(Err(error)),
        }
    }
}

/// A repair in the words of the clean-up's options.
fn in_words(repair: &Edit) -> String {
    match repair {
        Edit::Swap([a, b], frames) => format!("swap {a},{b}:{}..{}", frames.start, frames.end),
        Edit::Drop(label, frames) => format!("drop {label}:{}..{}", frames.start, frames.end),
        Edit::Hold(label, frames) => format!("hold {label}:{}..{}", frames.start, frames.end),
    }
}

impl ViewApp {
    /// Begins to read the open take again, with these repairs in place of those before.
    fn repair(&mut self, repairs: Vec<Edit>) {
        let Some(document) = self.document() else { return };
        let Some(open) = document.take() else { return };
        let reading = Reading { repairs, space: open.reading.space };
        self.read_again(open.name.clone(), reading);
    }

    /// Begins to read a take in another way.
    fn read_again(&mut self, name: String, reading: Reading) {
        let Some(document) = self.document() else { return };
        let rig = document.rig.clone();
        self.warnings.clear();
        (self.note, self.elsewhere) = (None, None);
        self.opening = Some(open::begin_again(name, rig, reading, &self.context));
    }

    /// The button that reads a take in the space in which it fits.
    pub(crate) fn offer_space(&mut self, ui: &mut egui::Ui) {
        let Some(Elsewhere { name, space, .. }) = &self.elsewhere else { return };
        let unit =
            space.unit().map_or_else(|| format!("units of {} m", space.metres_per_unit), str::to_owned);
        let axes = if space.axes == Axes::SAME { String::new() } else { format!(" with {}", space.axes) };
        if ui.button(format!("Read it in {unit}{axes}")).clicked() {
            let reading = Reading { space: Some(*space), ..Reading::default() };
            self.read_again(name.clone(), reading);
        }
    }

    /// Writes the repaired take, without pulls and edits, beside the rig's file.
    fn save_repaired(&self) -> Result<PathBuf> {
        let document = self.document().ok_or_else(|| Error::empty("no rig is open"))?;
        let open = document.take().ok_or_else(|| Error::empty("no take is open"))?;
        let path = free(&PathBuf::from(&document.name), "repaired", "csv")?;
        take::write(&path, &open.take)?;
        Ok(path)
    }
}
