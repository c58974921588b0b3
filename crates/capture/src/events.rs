//! Events: the findings of the steps, for the report and for the take's confidence.
use crate::{Event, Kind};
use rhytid_core::Take;
use std::ops::Range;

/// An event of a single marker.
pub(crate) fn event(kind: Kind, marker: usize, frames: Range<usize>, confidence: f32) -> Event {
    Event {
        kind,
        marker: Some(marker),
        other: None,
        first: frames.start,
        frames: frames.len(),
        distance_mm: None,
        strain: None,
        confidence,
    }
}

/// Runs of consecutive numbers in an ascending list.
pub(crate) fn runs(ascending: &[usize]) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for &i in ascending {
        match runs.last_mut() {
            Some(run) if run.end == i => run.end += 1,
            _ => runs.push(i..i + 1),
        }
    }
    runs
}

/// The gaps of handles' markers, in these columns of the file, that the capture system filled.
pub(crate) fn filled_before(tracks: &Take, columns: &[Option<usize>]) -> Vec<Event> {
    let (Some(confidence), m) = (&tracks.confidence, tracks.labels.len()) else { return Vec::new() };
    let mut events = Vec::new();
    for (marker, column) in columns.iter().enumerate() {
        let Some(column) = *column else { continue };
        let at = |f: usize| confidence[f * m + column];
        let filled: Vec<usize> = (0..tracks.frames())
            .filter(|&f| at(f) < 1.0 && !tracks.positions[f * m + column][0].is_nan())
            .collect();
        events.extend(runs(&filled).into_iter().map(|run| {
            let lowest = run.clone().map(at).fold(1.0, f32::min);
            event(Kind::FilledBefore, marker, run, lowest)
        }));
    }
    events
}

/// frames × `markers`: the lowest confidence of the events of each position; `None` where all are 1.
pub(crate) fn confidence(events: &[Event], frames: usize, markers: usize) -> Option<Vec<f32>> {
    let mut confidence = vec![1.0_f32; frames * markers];
    for event in events {
        let Some(marker) = event.marker else { continue };
        for f in event.first..event.first + event.frames {
            let at = &mut confidence[f * markers + marker];
            *at = at.min(event.confidence);
        }
    }
    confidence.iter().any(|c| *c < 1.0).then_some(confidence)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn confidence_is_that_of_the_least_trusted_event() {
        assert_eq!(confidence(&[event(Kind::Swap, 0, 0..2, 1.0)], 2, 2), None);
        let events = [event(Kind::Lost, 1, 2..3, 0.0), event(Kind::Spline, 1, 1..3, 0.8)];
        assert_eq!(confidence(&events, 3, 2).unwrap(), [1.0, 1.0, 1.0, 0.8, 1.0, 0.0]);
    }

    #[test]
    fn what_was_filled_before() {
        let tracks = Take {
            labels: vec!["a".into(), "b".into()],
            times: vec![0.0, 1.0, 2.0],
            positions: vec![[0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3], [f64::NAN; 3], [0.0; 3]],
            head: None,
            confidence: Some(vec![1.0, 0.5, 1.0, 0.5, 0.5, 1.0]),
        };
        let found = filled_before(&tracks, &[Some(0), None, Some(1)]);
        assert_eq!(found, [event(Kind::FilledBefore, 2, 0..2, 0.5)]);
    }
}
