//! What happens in a take: the clean-up's findings, markers in doubt, and edits. The time line shows these
//! events, and the list of them leads to each one.

use crate::app::ViewApp;
use crate::commands::Command;
use crate::document::{Document, TimelineEvent};
use crate::problems::{DOUBTFUL, ProblemKind};
use crate::transport::Transport;
use eframe::egui::{self, Color32, RichText};
use rhytid_core::Take;

/// The side of a square that shows a colour, in points.
const SQUARE: f32 = 10.0;

/// The most events that the words of one place name.
const NAMED: usize = 6;

/// The kind of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum EventKind {
    /// A gap that the clean-up filled. Raw takes have many of them.
    Gap,
    /// The clean-up found or changed something.
    Found,
    /// Something is wrong with a marker.
    Wrong(ProblemKind),
    /// An edit of the file of edits.
    Edit,
    /// A pull of markers, with its number.
    Pull(usize),
}

impl EventKind {
    /// One of each colour.
    pub(crate) const ALL: [Self; 7] = [
        Self::Gap,
        Self::Found,
        Self::Wrong(ProblemKind::Gap),
        Self::Wrong(ProblemKind::Strain),
        Self::Wrong(ProblemKind::Label),
        Self::Edit,
        Self::Pull(0),
    ];

    /// Its colour, for both themes.
    pub(crate) fn colour(self) -> Color32 {
        match self {
            Self::Gap => Color32::from_gray(135),
            Self::Found => Color32::from_rgb(90, 130, 220),
            Self::Wrong(kind) => kind.colour(),
            Self::Edit => Color32::from_rgb(130, 110, 215),
            Self::Pull(_) => Color32::from_rgb(40, 160, 130),
        }
    }

    /// The meaning of its colour.
    pub(crate) fn meaning(self) -> String {
        match self {
            Self::Gap => "gap filled".to_owned(),
            Self::Found => "found by the clean-up".to_owned(),
            Self::Wrong(kind) => kind.meaning(),
            Self::Edit => "edited".to_owned(),
            Self::Pull(_) => "pulled".to_owned(),
        }
    }

    /// Whether it is a change that somebody wanted. Such events have a lane of their own.
    pub(crate) fn is_wanted(self) -> bool {
        matches!(self, Self::Edit | Self::Pull(_))
    }

    /// Whether it has the colour of the other kind.
    pub(crate) fn looks_as(self, other: Self) -> bool {
        self.colour() == other.colour()
    }
}

/// An event.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Event {
    pub kind: EventKind,
    /// Its first and its last frame.
    pub frames: [usize; 2],
    pub words: String,
}

impl Event {
    fn new(found: &TimelineEvent, kind: EventKind) -> Self {
        let last = found.first + found.frames.max(1) - 1;
        let words = match kind {
            EventKind::Wrong(ProblemKind::Gap) => {
                format!("{}, confidence {:.1}", found.words, found.confidence)
            }
            _ => found.words.clone(),
        };
        Self { kind, frames: [found.first, last], words }
    }

    /// The pull that it is.
    pub(crate) fn pull(&self) -> Option<usize> {
        match self.kind {
            EventKind::Pull(pull) => Some(pull),
            _ => None,
        }
    }

    /// Its frames and what it is.
    pub(crate) fn in_words(&self, frames: usize) -> String {
        let [first, last] = self.frames;
        match first == last {
            _ if self.is_whole(frames) => format!("whole take: {}", self.words),
            true => format!("{first}: {}", self.words),
            false => format!("{first} to {last}: {}", self.words),
        }
    }

    /// Whether the keys lead to it, in a take of so many frames. They pass over the many gaps.
    fn is_led_to(&self, frames: usize) -> bool {
        self.kind != EventKind::Gap && !self.is_whole(frames)
    }

    /// Whether it takes as long as a take of so many frames.
    pub(crate) fn is_whole(&self, frames: usize) -> bool {
        self.frames[0] == 0 && self.frames[1] + 1 >= frames
    }
}

/// The events of the open take, by their first frames. Those of the whole take come first.
pub(crate) fn of(document: &Document) -> Vec<Event> {
    let mut events = Vec::new();
    for found in document.findings() {
        let kind = match found.problem {
            Some(problem) => EventKind::Wrong(problem),
            None if found.is_filled_gap => EventKind::Gap,
            None => EventKind::Found,
        };
        events.push(Event::new(found, kind));
    }
    for edit in document.edit_spans() {
        events.push(Event::new(edit, EventKind::Edit));
    }
    for (i, pull) in document.pull_events().enumerate() {
        events.push(Event::new(&pull, EventKind::Pull(i)));
    }
    let frames = document.transport.frames();
    events.sort_by_key(|event| (!event.is_whole(frames), event.frames));
    events
}

/// The stretches in which a marker is in doubt. `columns` are those of the rig's handles in the take.
pub(crate) fn doubts(take: &Take, columns: &[usize]) -> Vec<TimelineEvent> {
    let mut doubts = Vec::new();
    let Some(confidence) = &take.confidence else { return doubts };
    for (handle, &column) in columns.iter().enumerate() {
        let of_marker = confidence.iter().skip(column).step_by(take.labels.len());
        let mut open: Option<TimelineEvent> = None;
        for (frame, &confidence) in of_marker.enumerate() {
            match (&mut open, confidence < DOUBTFUL) {
                (Some(doubt), true) => {
                    doubt.frames += 1;
                    doubt.confidence = doubt.confidence.min(confidence);
                }
                (None, true) => {
                    let words = format!("in doubt: {}", take.labels[column]);
                    open = Some(TimelineEvent {
                        confidence,
                        problem: Some(ProblemKind::Gap),
                        handles: vec![handle],
                        ..TimelineEvent::new(frame, 1, words)
                    });
                }
                (_, false) => doubts.extend(open.take()),
            }
        }
        doubts.extend(open);
    }
    doubts
}

/// The frame of the next event for a positive `step`, or of the one before. `None` where there is none.
pub(crate) fn beside(events: &[Event], transport: &Transport, step: isize) -> Option<usize> {
    let frames = transport.frames();
    let here = transport.frame();
    let starts = events.iter().filter(|event| event.is_led_to(frames)).map(|event| event.frames[0]);
    match step > 0 {
        true => starts.filter(|first| *first > here).min(),
        false => starts.filter(|first| *first < here).max(),
    }
}

/// The words of some events, a line each.
pub(crate) fn in_words<'a>(events: impl Iterator<Item = &'a Event>, frames: usize) -> String {
    let mut lines: Vec<String> = events.map(|event| event.in_words(frames)).collect();
    let left = lines.len().saturating_sub(NAMED);
    if left > 0 {
        lines.truncate(NAMED);
        lines.push(format!("and {left} more"));
    }
    lines.join("\n")
}

/// The buttons of the events, and what their colours mean.
pub(crate) fn controls(
    events: &[Event],
    frames: usize,
    is_listed: bool,
    ui: &mut egui::Ui,
    wanted: &mut Vec<Command>,
) {
    if ui.selectable_label(is_listed, format!("Events ({})", events.len())).clicked() {
        wanted.push(Command::Events);
    }
    let can = events.iter().any(|event| event.is_led_to(frames));
    for (words, step) in [("Event before", -1), ("Event after", 1)] {
        if ui.add_enabled(can, egui::Button::new(words)).clicked() {
            wanted.push(Command::Event(step));
        }
    }
    for kind in EventKind::ALL {
        if events.iter().any(|event| event.kind.looks_as(kind)) {
            meaning(ui, kind);
        }
    }
}

/// The meaning of a colour, as one piece, which goes to the next line as a whole.
fn meaning(ui: &mut egui::Ui, kind: EventKind) {
    let font = egui::TextStyle::Body.resolve(ui.style());
    let words = kind.meaning();
    let galley = ui.painter().layout_no_wrap(words.clone(), font, ui.visuals().weak_text_color());
    let size = egui::vec2(SQUARE + 4.0 + galley.size().x, ui.spacing().interact_size.y);
    let (rect, response) = ui.allocate_exact_size(size, egui::Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, words.clone()));
    let at = egui::pos2(rect.left() + 0.5 * SQUARE, rect.center().y);
    let square = egui::Rect::from_center_size(at, egui::Vec2::splat(SQUARE));
    ui.painter().rect_filled(square, 2.0, kind.colour());
    let left = egui::pos2(square.right() + 4.0, rect.center().y - 0.5 * galley.size().y);
    ui.painter().galley(left, galley, ui.visuals().weak_text_color());
}

fn square(ui: &mut egui::Ui, kind: EventKind) {
    let (rect, _) = ui.allocate_exact_size(egui::Vec2::splat(SQUARE), egui::Sense::hover());
    ui.painter().rect_filled(rect, 2.0, kind.colour());
}

/// The list of all events. A click on one leads to its first frame.
pub(crate) fn list(app: &mut ViewApp, context: &egui::Context) {
    let Some(document) = app.document().filter(|_| app.events_shown) else { return };
    let (events, frames, here) = (of(document), document.transport.frames(), document.transport.frame());
    let room = context.content_rect();
    let width = (room.width() - 40.0).min(340.0);
    let mut open = true;
    let mut chosen = None;
    let window = egui::Window::new("Events").open(&mut open).default_size([width, 240.0]);
    let place = room.left_bottom() + egui::vec2(12.0, -430.0_f32.max(60.0 - room.height()));
    window.default_pos(place).max_width(width).show(context, |ui| {
        if events.is_empty() {
            ui.label("nothing unusual in this take");
        }
        let height = ui.spacing().interact_size.y;
        let area = egui::ScrollArea::vertical().auto_shrink(false).max_height(240.0);
        area.show_rows(ui, height, events.len(), |ui, rows| {
            for event in &events[rows] {
                let [first, last] = event.frames;
                let is_here = (first..=last).contains(&here) && !event.is_whole(frames);
                let words = event.in_words(frames);
                ui.horizontal(|ui| {
                    square(ui, event.kind);
                    let words = RichText::new(words);
                    let row = egui::Button::selectable(is_here, words).truncate();
                    if ui.add(row).on_hover_text(event.kind.meaning()).clicked() {
                        chosen = Some((first, event.kind));
                    }
                });
            }
        });
    });
    app.events_shown = open;
    if let (Some((frame, kind)), Some(scene)) = (chosen, &mut app.scene) {
        scene.document.transport.playing = false;
        scene.document.transport.seek(frame);
        if let EventKind::Pull(pull) = kind {
            scene.document.select_pull(Some(pull));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn take(confidence: &[[f32; 2]]) -> Take {
        Take {
            labels: vec!["chin".into(), "brow".into()],
            times: (0..confidence.len()).map(|i| i as f64 / 25.0).collect(),
            positions: vec![[0.0; 3]; 2 * confidence.len()],
            confidence: Some(confidence.concat()),
            ..Take::default()
        }
    }

    #[test]
    fn only_what_is_clearly_low_is_in_doubt_and_each_marker_by_itself() {
        let take = take(&[[1.0, 0.5], [0.4, 0.8], [0.0, 0.2], [1.0, 0.1], [0.49, 1.0]]);
        let found = |columns: &[usize]| -> Vec<(usize, usize, String, f32)> {
            let doubts = doubts(&take, columns).into_iter();
            doubts.map(|doubt| (doubt.first, doubt.frames, doubt.words, doubt.confidence)).collect()
        };
        let chin = [(1, 2, "in doubt: chin".to_owned(), 0.0), (4, 1, "in doubt: chin".to_owned(), 0.49)];
        assert_eq!(found(&[0]), chin);
        assert_eq!(found(&[1]), [(2, 2, "in doubt: brow".to_owned(), 0.1)]);
        assert_eq!(found(&[]), []);
    }

    #[test]
    fn keys_lead_from_event_to_event_and_past_gaps_and_those_of_the_whole_take() {
        let event = |frames| Event { kind: EventKind::Found, frames, words: String::new() };
        let gap = Event { kind: EventKind::Gap, ..event([4, 5]) };
        let events = [event([0, 9]), event([2, 3]), event([2, 5]), gap, event([7, 7])];
        let mut transport = Transport::new(&[0., 1., 2., 3., 4., 5., 6., 7., 8., 9.], 1.0);
        let mut way = Vec::new();
        for step in [1, 1, 1, -1, -1] {
            let found = beside(&events, &transport, step);
            way.push(found);
            found.into_iter().for_each(|frame| transport.seek(frame));
        }
        assert_eq!(way, [Some(2), Some(7), None, Some(2), None]);
    }
}
