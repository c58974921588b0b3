//! The effects of commands.

use crate::commands::Command;
use crate::events;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::soft_selection::Drag;

/// The factor of a key that moves the camera nearer.
const NEARER: f32 = 1.15;

impl Scene {
    /// Runs the command of a key or a button.
    pub(crate) fn run(&mut self, command: Command, settings: &Settings) {
        let [width, height] = self.size().map(|n| n as f32);
        let transport = &mut self.document.transport;
        match command {
            Command::Play => transport.toggle(),
            Command::Repeat => transport.repeat = transport.repeat.next(),
            Command::Step(frames) => transport.step(frames),
            Command::Begin => transport.set_begin(transport.frame()),
            Command::End => transport.set_end(transport.frame()),
            Command::ResetRange => transport.reset_range(),
            Command::Event(step) => {
                let events = events::of(&self.document);
                let transport = &mut self.document.transport;
                if let Some(frame) = events::beside(&events, transport, step) {
                    transport.playing = false;
                    transport.seek(frame);
                }
            }
            Command::First => transport.seek(0),
            Command::Last => transport.seek(usize::MAX),
            Command::Undo => {
                self.document.undo();
            }
            Command::Redo => {
                self.document.redo();
            }
            Command::Reset => self.document.reset(&self.selected),
            Command::DeletePull => self.document.delete_pull(),
            Command::Pin => self.document.toggle_pins(&self.selected),
            Command::NextMarker => self.take_next(1),
            Command::PreviousMarker => self.take_next(-1),
            Command::Deselect => match self.document.is_dragging() {
                true => self.document.end_drag(false),
                false => self.selected.clear(),
            },
            Command::Nudge(x, y) => {
                let [right, upward, _] = self.orbit.axes();
                let millimetre = 1.0 / self.millimetres();
                let by = millimetre * (f32::from(x) * right + f32::from(y) * upward);
                self.document.begin_drag();
                self.drag(by.to_array(), settings);
                self.document.end_drag(true);
            }
            // The face turns to the right as if the pointer dragged it there.
            Command::Turn(x, y) => self.orbit.orbit([2.5 * f32::from(x), 2.5 * f32::from(y)]),
            Command::Nearer => self.orbit.zoom(NEARER, [0.5 * width, 0.5 * height], [width, height]),
            Command::Farther => self.orbit.zoom(1.0 / NEARER, [0.5 * width, 0.5 * height], [width, height]),
            Command::Front => self.orbit.look_from(0.0, 0.0),
            Command::Side => self.orbit.look_from(90.0, 0.0),
            Command::Above => self.orbit.look_from(0.0, 90.0),
            Command::All => self.orbit.all(width / height),
            Command::Mirror
            | Command::Names
            | Command::Panels
            | Command::Keys
            | Command::Events
            | Command::Look(_)
            | Command::Screenshot
            | Command::SaveFrame
            | Command::SaveExample
            | Command::SaveEdits => {}
            #[cfg(not(target_arch = "wasm32"))]
            Command::Close
            | Command::Open
            | Command::ExportUsd
            | Command::ExportGlb
            | Command::ExportFilm => {}
        }
    }

    /// Drags the selected markers by `by`, counted from the beginning of the drag.
    pub(crate) fn drag(&mut self, by: [f32; 3], settings: &Settings) {
        let pinned = self.document.pose().pinned.clone();
        self.document.drag(Drag {
            grabbed: &self.selected,
            by,
            reach: settings.reach / self.millimetres(),
            mirrored: settings.mirrored,
            pinned: &pinned,
        });
    }

    fn take_next(&mut self, step: isize) {
        if self.document.is_mesh() {
            return;
        }
        let count = self.document.rig.handles().len() as isize;
        let next = match self.selected.last() {
            Some(&selected) => (selected as isize + step).rem_euclid(count),
            None if step > 0 => 0,
            None => count - 1,
        };
        self.selected = vec![next as usize];
    }
}
