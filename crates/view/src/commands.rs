//! The commands of the keyboard: one table for the keys and for the sheet that lists them.

use eframe::egui::{Key, KeyboardShortcut, Modifiers, Ui};

/// A command of a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Command {
    Play,
    Repeat,
    /// By so many frames.
    Step(isize),
    First,
    Last,
    /// The range that plays begins here.
    Begin,
    /// The range that plays ends here.
    End,
    ResetRange,
    /// The next event, or the one before.
    Event(isize),
    /// The list of events.
    Events,
    Undo,
    Redo,
    Reset,
    DeletePull,
    Pin,
    Mirror,
    NextMarker,
    PreviousMarker,
    Deselect,
    Names,
    /// Moves by steps of a millimetre, to the picture's right and up.
    Nudge(i8, i8),
    /// Turns by degrees, to the right and down.
    Turn(i8, i8),
    Nearer,
    Farther,
    Front,
    Side,
    Above,
    All,
    Panels,
    Keys,
    Screenshot,
    SaveFrame,
    SaveExample,
    SaveEdits,
    #[cfg(not(target_arch = "wasm32"))]
    ExportUsd,
    #[cfg(not(target_arch = "wasm32"))]
    ExportGlb,
    #[cfg(not(target_arch = "wasm32"))]
    ExportFilm,
    #[cfg(not(target_arch = "wasm32"))]
    Close,
    #[cfg(not(target_arch = "wasm32"))]
    Open,
    /// The look with this number, counted from 0.
    Look(u8),
}

/// What a command is about: a part of the sheet of keys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Group {
    Time,
    Markers,
    Camera,
    Look,
    Files,
    Window,
}

impl Group {
    /// All, in the order of the sheet.
    pub(crate) const ALL: [Self; 6] =
        [Self::Time, Self::Markers, Self::Camera, Self::Look, Self::Files, Self::Window];

    /// Its title.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Time => "Time",
            Self::Markers => "Markers",
            Self::Camera => "Camera",
            Self::Look => "Look",
            Self::Files => "Files",
            Self::Window => "Window",
        }
    }
}

impl Command {
    /// What it is about.
    pub(crate) fn group(self) -> Group {
        match self {
            Self::Play
            | Self::Repeat
            | Self::Step(_)
            | Self::First
            | Self::Last
            | Self::Begin
            | Self::End
            | Self::ResetRange
            | Self::Event(_)
            | Self::Events => Group::Time,
            Self::Undo
            | Self::Redo
            | Self::Reset
            | Self::DeletePull
            | Self::Pin
            | Self::Mirror
            | Self::NextMarker
            | Self::PreviousMarker
            | Self::Deselect
            | Self::Names
            | Self::Nudge(..) => Group::Markers,
            Self::Turn(..)
            | Self::Nearer
            | Self::Farther
            | Self::Front
            | Self::Side
            | Self::Above
            | Self::All => Group::Camera,
            Self::Look(_) => Group::Look,
            Self::Screenshot | Self::SaveFrame | Self::SaveExample | Self::SaveEdits => Group::Files,
            #[cfg(not(target_arch = "wasm32"))]
            Self::Open | Self::ExportUsd | Self::ExportGlb | Self::ExportFilm => Group::Files,
            Self::Panels | Self::Keys => Group::Window,
            #[cfg(not(target_arch = "wasm32"))]
            Self::Close => Group::Window,
        }
    }
}

/// A command, its key, and its description.
pub(crate) struct Binding {
    pub command: Command,
    pub key: KeyboardShortcut,
    pub words: &'static str,
}

const fn on(command: Command, modifiers: Modifiers, key: Key, words: &'static str) -> Binding {
    Binding { command, key: KeyboardShortcut::new(modifiers, key), words }
}

const NONE: Modifiers = Modifiers::NONE;
const COMMAND: Modifiers = Modifiers::COMMAND;
const ALT: Modifiers = Modifiers::ALT;
const SHIFT: Modifiers = Modifiers::SHIFT;
const REDO: Modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };

/// Every key, in the order of the sheet. For the same key, bindings with more modifiers come first.
pub(crate) const BINDINGS: &[Binding] = &[
    on(Command::Play, NONE, Key::Space, "play or pause"),
    on(Command::Repeat, NONE, Key::L, "at the end: once, loop or ping-pong"),
    on(Command::Nudge(-1, 0), ALT, Key::ArrowLeft, "move the selected markers by a millimetre"),
    on(Command::Nudge(1, 0), ALT, Key::ArrowRight, ""),
    on(Command::Nudge(0, 1), ALT, Key::ArrowUp, ""),
    on(Command::Nudge(0, -1), ALT, Key::ArrowDown, ""),
    on(Command::Turn(-5, 0), COMMAND, Key::ArrowLeft, "turn the face"),
    on(Command::Turn(5, 0), COMMAND, Key::ArrowRight, ""),
    on(Command::Turn(0, -5), COMMAND, Key::ArrowUp, ""),
    on(Command::Turn(0, 5), COMMAND, Key::ArrowDown, ""),
    on(Command::Step(-10), SHIFT, Key::ArrowLeft, "ten frames back or on"),
    on(Command::Step(10), SHIFT, Key::ArrowRight, ""),
    on(Command::Step(-1), NONE, Key::ArrowLeft, "the frame before or after"),
    on(Command::Step(1), NONE, Key::ArrowRight, ""),
    on(Command::Step(-1), NONE, Key::Comma, ""),
    on(Command::Step(1), NONE, Key::Period, ""),
    on(Command::First, NONE, Key::Home, "first frame"),
    on(Command::Last, NONE, Key::End, "last frame"),
    // In a browser, dialogs and the tab belong to the browser.
    #[cfg(not(target_arch = "wasm32"))]
    on(Command::Open, COMMAND, Key::O, "open files"),
    on(Command::Begin, NONE, Key::I, "play from this frame on"),
    on(Command::End, NONE, Key::O, "play up to this frame"),
    on(Command::ResetRange, NONE, Key::U, "play all frames"),
    on(Command::SaveEdits, COMMAND, Key::E, "save the pulls of markers, as an edit"),
    on(Command::Event(-1), NONE, Key::PageUp, "the event before or after"),
    on(Command::Event(1), NONE, Key::PageDown, ""),
    on(Command::Events, NONE, Key::E, "show or hide the list of events"),
    on(Command::NextMarker, NONE, Key::N, "select the next marker"),
    on(Command::PreviousMarker, NONE, Key::B, "select the previous marker"),
    on(Command::Deselect, NONE, Key::Escape, "close this list, deselect all markers, or cancel a drag"),
    on(Command::Pin, NONE, Key::P, "pin the selected markers, or unpin them"),
    on(Command::Mirror, NONE, Key::M, "mirrored drags: on or off"),
    on(Command::Names, NONE, Key::A, "names of all markers: on or off"),
    on(Command::Reset, NONE, Key::R, "reset the selected markers, or all of them"),
    on(Command::DeletePull, NONE, Key::Delete, "delete the selected pull"),
    on(Command::Redo, REDO, Key::Z, "redo"),
    on(Command::Undo, COMMAND, Key::Z, "undo"),
    on(Command::Nearer, NONE, Key::Plus, "zoom in"),
    on(Command::Nearer, NONE, Key::Equals, ""),
    on(Command::Farther, NONE, Key::Minus, "zoom out"),
    on(Command::Front, NONE, Key::Num1, "look from the front"),
    on(Command::Side, NONE, Key::Num3, "look from the side"),
    on(Command::Above, NONE, Key::Num7, "look from above"),
    on(Command::All, NONE, Key::Enter, "show the whole face"),
    on(Command::Look(0), NONE, Key::F1, "what is shown: F1 to F9"),
    on(Command::Look(1), NONE, Key::F2, ""),
    on(Command::Look(2), NONE, Key::F3, ""),
    on(Command::Look(3), NONE, Key::F4, ""),
    on(Command::Look(4), NONE, Key::F5, ""),
    on(Command::Look(5), NONE, Key::F6, ""),
    on(Command::Look(6), NONE, Key::F7, ""),
    on(Command::Look(7), NONE, Key::F8, ""),
    on(Command::Look(8), NONE, Key::F9, ""),
    on(Command::SaveExample, REDO, Key::S, "save the frame as a mesh, for an example"),
    on(Command::SaveFrame, COMMAND, Key::S, "save the frame as a take"),
    on(Command::Screenshot, NONE, Key::S, "save the picture"),
    on(Command::Panels, NONE, Key::T, "show or hide the panel"),
    on(Command::Keys, NONE, Key::H, "show or hide this list"),
    // In a browser, the tab belongs to the browser.
    #[cfg(not(target_arch = "wasm32"))]
    on(Command::Close, COMMAND, Key::Q, "close the window"),
];

/// The commands whose keys were pressed, in the order of [`BINDINGS`]. None while the user types into a
/// field.
pub(crate) fn pressed(ui: &Ui) -> Vec<Command> {
    if ui.ctx().text_edit_focused() {
        return Vec::new();
    }
    let focused = ui.memory(|memory| memory.focused().is_some());
    ui.input_mut(|input| {
        let mut commands = Vec::new();
        for binding in BINDINGS {
            // A widget with the focus uses these keys itself.
            let key = binding.key.logical_key;
            let is_arrow = matches!(key, Key::ArrowLeft | Key::ArrowRight | Key::ArrowUp | Key::ArrowDown);
            let of_widgets =
                matches!(key, Key::Space | Key::Enter) || is_arrow && binding.key.modifiers == NONE;
            let count = match focused && of_widgets {
                true => 0,
                false => input.count_and_consume_key(binding.key.modifiers, binding.key.logical_key),
            };
            commands.extend(std::iter::repeat_n(binding.command, count));
        }
        commands
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_means_two_things() {
        for (i, a) in BINDINGS.iter().enumerate() {
            for b in &BINDINGS[i + 1..] {
                assert_ne!(a.key, b.key, "{:?} and {:?}", a.command, b.command);
                // egui accepts a key with additional modifiers for a binding with fewer. So bindings with
                // more have to come first.
                let is_later = b.key.modifiers != NONE && a.key.modifiers == NONE;
                assert!(
                    !(a.key.logical_key == b.key.logical_key && is_later),
                    "{:?} hides {:?}",
                    a.command,
                    b.command
                );
            }
        }
        assert!(BINDINGS[0].words.len() > 3);
    }
}
