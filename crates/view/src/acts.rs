//! What commands do to what is open.

use crate::commands::Command;
use crate::pull::Drag;
use crate::scene::Scene;
use crate::settings::Settings;

/// How much nearer a key goes.
const NEARER: f32 = 1.15;

impl Scene {
    /// Does what a key or a button says.
    pub(crate) fn run(&mut self, command: Command, settings: &Settings) {
        let [width, height] = self.size().map(|n| n as f32);
        let transport = &mut self.document.transport;
        match command {
            Command::Play => transport.toggle(),
            Command::Loop => transport.looping = !transport.looping,
            Command::Next => transport.step(1),
            Command::Previous => transport.step(-1),
            Command::First => transport.seek(0),
            Command::Last => transport.seek(usize::MAX),
            Command::Undo => {
                self.document.undo();
            }
            Command::Redo => {
                self.document.redo();
            }
            Command::Reset => self.document.reset(&self.taken),
            Command::Pin => self.document.toggle_pins(&self.taken),
            Command::NextMarker => self.take_next(1),
            Command::PreviousMarker => self.take_next(-1),
            Command::LetGo => match self.document.is_dragging() {
                true => self.document.end_drag(false),
                false => self.taken.clear(),
            },
            Command::Nudge(x, y) => {
                let [right, upward, _] = self.orbit.axes();
                let millimetre = 1.0 / self.millimetres();
                let by = millimetre * (f32::from(x) * right + f32::from(y) * upward);
                self.document.begin_drag();
                self.drag(by.to_array(), settings);
                self.document.end_drag(true);
            }
            // A face turns to the right as if it was dragged there.
            Command::Turn(x, y) => self.orbit.orbit([2.5 * f32::from(x), 2.5 * f32::from(y)]),
            Command::Nearer => self.orbit.zoom(NEARER, [0.5 * width, 0.5 * height], [width, height]),
            Command::Farther => self.orbit.zoom(1.0 / NEARER, [0.5 * width, 0.5 * height], [width, height]),
            Command::Front => self.orbit.look_from(0.0, 0.0),
            Command::Side => self.orbit.look_from(90.0, 0.0),
            Command::Above => self.orbit.look_from(0.0, 90.0),
            Command::All => self.orbit.all(width / height),
            Command::Mirror
            | Command::Panels
            | Command::Keys
            | Command::Look(_)
            | Command::Screenshot
            | Command::SaveFrame
            | Command::SaveExample
            | Command::SavePulls => {}
            #[cfg(not(target_arch = "wasm32"))]
            Command::Close => {}
        }
    }

    /// Drags what is taken, by so much since the drag began.
    pub(crate) fn drag(&mut self, by: [f32; 3], settings: &Settings) {
        let pinned = self.document.pose().pinned.clone();
        self.document.drag(Drag {
            grabbed: &self.taken,
            by,
            reach: settings.reach / self.millimetres(),
            mirrored: settings.mirrored,
            pinned: &pinned,
        });
    }

    fn take_next(&mut self, step: isize) {
        let count = self.document.rig.handles().vertices.len() as isize;
        let next = match self.taken.last() {
            Some(&taken) => (taken as isize + step).rem_euclid(count),
            None if step > 0 => 0,
            None => count - 1,
        };
        self.taken = vec![next as usize];
    }
}
