//! Repairs by hand: what a person saw in the report and corrects.
use crate::events::event;
use crate::labels::Matched;
use crate::tracks::Tracks;
use crate::{Event, Kind};
use glam::DVec3;
use rhytid_core::{Error, InputErrorKind, Result};
use std::ops::Range;

/// One repair, in frames of the raw take, counted from 0. Frames beyond the take's end are ignored. Labels
/// are the handles' or the file's.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Edit {
    /// Two markers that have each other's label are exchanged.
    Swap([String; 2], Range<usize>),
    /// A marker's positions are dropped, and filled as a gap.
    Drop(String, Range<usize>),
    /// A handle's marker stays where it was on the face, and moves at the end to where it is seen again.
    Hold(String, Range<usize>),
}

/// Confidence of positions that were held by hand.
const HELD_CONFIDENCE: f32 = 0.5;

/// Makes the repairs in the file's tracks and returns the events. Swaps come first. Then dropped and held
/// positions become gaps.
///
/// # Errors
/// [`Error::Input`] if a label is neither a handle's nor in the file, a stretch has no frame of the take, or
/// a held label is no handle's.
pub(crate) fn apply(
    tracks: &mut Tracks,
    edits: &[Edit],
    handles: &[String],
    labels: &[String],
    matched: &Matched,
) -> Result<Vec<Event>> {
    let take = tracks.frames();
    let within = |what: &str, frames: &Range<usize>| {
        let frames = frames.start..frames.end.min(take);
        if frames.is_empty() {
            let wrong = format!("{what} from frame {}, but the take has frames 0..{take}", frames.start);
            return Err(Error::out_of_range(wrong));
        }
        Ok(frames)
    };
    let column = |what: &str, label: &String| {
        let handle = handles.iter().position(|handle| handle == label).and_then(|j| matched.columns[j]);
        handle.or_else(|| labels.iter().position(|other| other == label)).ok_or_else(|| {
            Error::input(format!(
                "{what} names “{label}”, which is neither a handle with a marker nor a label of the file"
            ))
            .of_kind(InputErrorKind::UnknownMarkers { labels: vec![label.clone()] })
        })
    };
    let handle = |column: usize| matched.columns.iter().position(|c| *c == Some(column));
    let mut events = Vec::new();
    for edit in edits {
        let Edit::Swap([a, b], frames) = edit else { continue };
        let frames = within("swap", frames)?;
        let (a, b) = (column("swap", a)?, column("swap", b)?);
        for f in frames.clone() {
            let at_a = tracks.columns[a][f];
            tracks.columns[a][f] = tracks.columns[b][f];
            tracks.columns[b][f] = at_a;
        }
        let (a, b) = (handle(a), handle(b));
        if let Some(marker) = a.or(b) {
            let other = a.and(b);
            events.push(Event { other, ..event(Kind::Swap, marker, frames, 1.0) });
        }
    }
    for edit in edits {
        let (what, label, frames, kind) = match edit {
            Edit::Swap(..) => continue,
            Edit::Drop(label, frames) => ("drop", label, frames, Kind::Dropped),
            Edit::Hold(label, frames) => ("hold", label, frames, Kind::Held),
        };
        let (frames, column) = (within(what, frames)?, column(what, label)?);
        tracks.columns[column][frames.clone()].fill(DVec3::NAN);
        match handle(column) {
            Some(marker) => events.push(event(kind, marker, frames, HELD_CONFIDENCE)),
            None if kind == Kind::Held => {
                return Err(Error::input(format!("hold names “{label}”, which is no handle’s marker"))
                    .of_kind(InputErrorKind::UnknownMarkers { labels: vec![label.clone()] }));
            }
            None => (),
        }
    }
    Ok(events)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edited(edits: &[Edit]) -> Result<(Tracks, Vec<Event>)> {
        let columns = (0..3).map(|j| (0..10).map(|f| DVec3::new(f64::from(j), f64::from(f), 0.0)).collect());
        let mut tracks = Tracks { columns: columns.collect(), rate: 60.0 };
        let names = |names: [&str; 2]| names.map(str::to_owned);
        let matched = Matched { columns: vec![Some(1), Some(0)], others: vec![2], ..Matched::default() };
        let labels = ["m0", "m1", "cap"].map(str::to_owned);
        let events = apply(&mut tracks, edits, &names(["chin", "brow"]), &labels, &matched)?;
        Ok((tracks, events))
    }

    #[test]
    fn handles_and_labels_are_named() {
        let swap = Edit::Swap(["chin".into(), "m0".into()], 2..4);
        let (tracks, events) = edited(&[
            Edit::Drop("m0".into(), 3..5),
            swap,
            Edit::Hold("chin".into(), 8..99),
            Edit::Drop("cap".into(), 0..1),
        ])
        .unwrap();
        let x = |j: usize, f: usize| tracks.columns[j][f].x;
        assert_eq!((x(0, 2), x(1, 2), x(1, 3), x(0, 5)), (1.0, 0.0, 0.0, 0.0));
        assert!(x(0, 3).is_nan() && x(0, 4).is_nan() && x(1, 9).is_nan() && x(2, 0).is_nan());
        let found: Vec<_> = events.iter().map(|e| (e.kind, e.marker, e.other, e.first, e.frames)).collect();
        assert_eq!(
            found,
            [
                (Kind::Swap, Some(0), Some(1), 2, 2),
                (Kind::Dropped, Some(1), None, 3, 2),
                (Kind::Held, Some(0), None, 8, 2)
            ]
        );
    }

    #[test]
    fn mistakes_are_named() {
        for (edit, expected) in [
            (Edit::Drop("nose".into(), 0..2), "drop names “nose”, which is neither"),
            (Edit::Hold("cap".into(), 0..2), "hold names “cap”, which is no handle’s marker"),
            (
                Edit::Swap(["chin".into(), "brow".into()], 10..12),
                "swap from frame 10, but the take has frames 0..10",
            ),
        ] {
            let message = edited(&[edit]).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
