//! The pointer on a slow machine, where a press and its release may lie between two frames.

use eframe::egui::{Context, Event, Plugin, RawInput, Ui};

/// A press ends the events of a frame, and a release begins those of another one.
///
/// In one frame, egui takes a press and a release for a click, wherever the pointer was in between. A drag
/// begins only in a frame without either.
#[derive(Default)]
pub(crate) struct SlowFrames {
    later: Vec<Event>,
}

impl Plugin for SlowFrames {
    fn debug_name(&self) -> &'static str {
        "slow frames"
    }

    fn input_hook(&mut self, _: &Context, input: &mut RawInput) {
        let mut events = std::mem::take(&mut self.later);
        events.append(&mut input.events);
        let is_button = |i: usize, is_press: bool| matches!(events[i], Event::PointerButton { pressed, .. } if pressed == is_press);
        let cut = (1..events.len()).find(|&i| is_button(i - 1, true) || is_button(i, false));
        self.later = cut.map_or_else(Vec::new, |cut| events.split_off(cut));
        input.events = events;
    }

    fn on_end_pass(&mut self, ui: &mut Ui) {
        if !self.later.is_empty() {
            ui.ctx().request_repaint();
        }
    }
}
