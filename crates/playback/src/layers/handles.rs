//! Edits of the handles.

use super::{Layers, time_of};
use crate::EditedTake;
use rhytid_core::{Error, Result, Rig, Take};
use rhytid_formats::edits::{Added, Curve, Ease, Hold};
use std::ops::Range;
use std::sync::Arc;

/// The displacements of another take, which are added.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct AddedTake {
    take: Arc<Take>,
    /// For each of the rig's H handles its column in the other take, if it has one.
    columns: Vec<Option<usize>>,
    /// H, from 0 to 1.
    weights: Vec<f64>,
    frame: f64,
    amount: Curve,
}

/// Handles that are held.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Held {
    /// H, from 0 to 1.
    pub weights: Vec<f64>,
    pub hold: Hold,
}

impl AddedTake {
    /// # Errors
    /// [`Error::Input`] if the take has none of the handles.
    pub(super) fn new(take: Arc<Take>, rig: &Rig, weights: Vec<f64>, added: &Added) -> Result<Self> {
        let column = |label: &String| take.labels.iter().position(|other| other == label);
        let columns: Vec<Option<usize>> = rig.handles().labels.iter().map(column).collect();
        if columns.iter().all(Option::is_none) || take.frames() == 0 {
            return Err(Error::empty("has no frame of any of the rig's handles, so there is nothing to add"));
        }
        Ok(Self { columns, weights, frame: added.frame, amount: added.amount.clone(), take })
    }

    /// The two frames of the other take around a time, which counts from its first frame.
    fn place(&self, since: f64) -> Between {
        let time = self.take.times[0] + since;
        let next = self.take.times.partition_point(|at| *at <= time);
        let (Some(before), Some(&to)) = (next.checked_sub(1), self.take.times.get(next)) else {
            let end = next.saturating_sub(1);
            return Between { before: end, next: end, part: 0.0 };
        };
        let from = self.take.times[before];
        Between { before, next, part: (time - from) / (to - from) }
    }

    fn position(&self, column: usize, Between { before, next, part }: Between) -> [f64; 3] {
        let at = |frame: usize| self.take.positions[frame * self.take.labels.len() + column];
        let (a, b) = (at(before), at(next));
        std::array::from_fn(|c| a[c] + part * (b[c] - a[c]))
    }
}

/// A time between two frames.
#[derive(Clone, Copy)]
struct Between {
    before: usize,
    next: usize,
    /// The position between the two frames, from 0 to 1.
    part: f64,
}

/// [`Layers::edit`].
pub(super) fn edit(layers: &Layers, before: Take, rig: &Rig) -> Result<EditedTake> {
    let mut take = before.clone();
    // One frame is enough to report missing handles.
    take.slice(0..take.frames().min(1)).handle_positions(&rig.handles().labels)?;
    let column = |label: &String| take.labels.iter().position(|other| other == label).unwrap_or_default();
    let columns: Vec<usize> = rig.handles().labels.iter().map(column).collect();
    let rest: Vec<[f64; 3]> = rig.handles().rest.iter().map(|x| x.map(f64::from)).collect();
    let markers = take.labels.len();
    for frame in 0..take.frames() {
        let at = frame as f64;
        let gains = factors(layers.gains.iter().map(|(weights, by)| (weights, by.at(at))));
        let moved = layers.offsets.iter().map(|(by, amount)| (by, amount.at(at)));
        let moved: Vec<(&Vec<[f64; 3]>, f64)> = moved.filter(|(_, amount)| *amount != 0.0).collect();
        let added = layers.added.iter().map(|added| {
            let since = take.times[frame] - time_of(&take, added.frame);
            (added, added.place(since), added.amount.at(at))
        });
        let added: Vec<_> = added.filter(|(_, _, amount)| *amount != 0.0).collect();
        for (handle, &column) in columns.iter().enumerate() {
            let x = &mut take.positions[frame * markers + column];
            if let Some(gain) = gains.as_ref().map(|gains| gains[handle]).filter(|gain| *gain != 1.0) {
                *x = std::array::from_fn(|c| rest[handle][c] + gain * (x[c] - rest[handle][c]));
            }
            for (by, amount) in &moved {
                *x = std::array::from_fn(|c| x[c] + amount * by[handle][c]);
            }
            for (added, place, amount) in &added {
                if let Some(column) = added.columns[handle] {
                    let (other, amount) = (added.position(column, *place), amount * added.weights[handle]);
                    *x = std::array::from_fn(|c| x[c] + amount * (other[c] - rest[handle][c]));
                }
            }
        }
    }
    for held in &layers.holds {
        hold(held, &mut take, &columns).map_err(|error| error.in_file(layers.path.display()))?;
    }
    Ok(EditedTake::new(before, take))
}

/// `Π (1 + w (g − 1))` of each handle; `None` where all gains are 1.
fn factors<'a>(gains: impl Iterator<Item = (&'a Vec<f64>, f64)>) -> Option<Vec<f64>> {
    let mut factors: Option<Vec<f64>> = None;
    for (weights, gain) in gains.filter(|(_, gain)| *gain != 1.0) {
        let factors = factors.get_or_insert_with(|| vec![1.0; weights.len()]);
        factors.iter_mut().zip(weights).for_each(|(factor, weight)| *factor *= 1.0 + weight * (gain - 1.0));
    }
    factors
}

impl Held {
    /// The frame whose positions are held.
    fn at(&self) -> usize {
        self.hold.at.unwrap_or(self.hold.frames.start)
    }

    /// How far a frame is held, from 0 to 1.
    fn amount(&self, frame: usize) -> f64 {
        let Hold { frames: Range { start: first, end }, ease, .. } = self.hold;
        // The number of frames outside the held ones. The amount would be 0 at one frame more than the ease.
        let outside = first.saturating_sub(frame).max((frame + 1).saturating_sub(end));
        Ease::Smooth.at((1.0 - outside as f64 / (ease + 1) as f64).max(0.0))
    }
}

/// [`Layers::let_through`], by these holds.
pub(super) fn let_through(
    holds: &[Held],
    frame: usize,
    moved: &dyn Fn(usize) -> Vec<[f64; 3]>,
) -> Vec<[f64; 3]> {
    let Some((held, before)) = holds.split_last() else { return moved(frame) };
    let mut through = let_through(before, frame, moved);
    let amount = held.amount(frame);
    if amount > 0.0 {
        let still = let_through(before, held.at(), moved);
        for ((x, still), weight) in through.iter_mut().zip(still).zip(&held.weights) {
            *x = std::array::from_fn(|c| x[c] + amount * weight * (still[c] - x[c]));
        }
    }
    through
}

/// Keeps handles where they are in one frame. Before and after the held frames, the handles ease in and out.
fn hold(held: &Held, take: &mut Take, columns: &[usize]) -> Result<()> {
    let Hold { frames: Range { start: first, end }, ease, .. } = held.hold;
    let at = held.at();
    let markers = take.labels.len();
    let frames = take.frames();
    if end > frames || at >= frames {
        return Err(Error::out_of_range(format!(
            "[[hold]] of the frames {first}..{end} at {at}: the take has {frames}, counted from 0"
        )));
    }
    let still: Vec<[f64; 3]> = columns.iter().map(|column| take.positions[at * markers + column]).collect();
    for frame in first.saturating_sub(ease)..(end + ease).min(frames) {
        let amount = held.amount(frame);
        for ((&column, still), weight) in columns.iter().zip(&still).zip(&held.weights) {
            let x = &mut take.positions[frame * markers + column];
            match amount * weight {
                0.0 => {}
                1.0 => *x = *still,
                amount => *x = std::array::from_fn(|c| x[c] + amount * (still[c] - x[c])),
            }
        }
    }
    Ok(())
}
