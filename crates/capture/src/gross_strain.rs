//! Strains that no skin has: a label slid, was swapped or names another place than the rig's handle.
use crate::events::{event, runs};
use crate::target::{StrainLimit, Target};
use crate::{Event, Kind};
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{Rig, Take, Warning, human};

/// The worst strain of a take that is beyond what skin does.
#[derive(Debug, Clone, PartialEq)]
pub struct GrossStrain {
    /// The frame.
    pub frame: usize,
    /// The two handles.
    pub labels: [String; 2],
    /// Their strain, 1 for twice the rest length.
    pub strain: f64,
    /// The number of frames with such a strain.
    pub frames: usize,
}

impl GrossStrain {
    /// What a user should know of it. `take` is the take that has it.
    pub fn warning(&self, take: &Take) -> Warning {
        let Self { frame, labels: [a, b], strain, frames } = self;
        Warning::from(format!(
            "between {a} and {b} the skin is stretched by {} in frame {frame} ({:.2} s), far beyond any example \
             ({} like it); look for a label that slid or was swapped, or that names another place on the rig",
            human::percent(*strain, 0),
            take.times[*frame],
            if *frames == 1 { "no other frame is".to_owned() } else { format!("{frames} frames are") }
        ))
    }
}

/// The worst strain of a take that is beyond what skin does. The limit is the rig's examples plus 100 %, or
/// 200 % without examples. `None` if no strain passes its limit, or if the take lacks a handle of the rig.
pub fn gross_strain(take: &Take, rig: &Rig) -> Option<GrossStrain> {
    let columns = columns(take, rig)?;
    let target = Target::from_rig(rig);
    let at = |h: usize, f: usize| DVec3::from_array(take.positions[f * take.labels.len() + columns[h]]);
    let events = events(&target, take.frames(), at);
    let over = |e: &&Event| e.strain.unwrap_or(0.0);
    let worst = events.iter().max_by(|a, b| over(a).total_cmp(&over(b)))?;
    let (a, b) = (worst.marker?, worst.other?);
    let rest = target.rest[a].distance(target.rest[b]);
    let strain = |f: usize| at(a, f).distance(at(b, f)) / rest - 1.0;
    let stretch = worst.first..worst.first + worst.frames;
    let frame = stretch.max_by(|f, g| strain(*f).total_cmp(&strain(*g)))?;
    let mut frames: Vec<usize> = events.iter().flat_map(|e| e.first..e.first + e.frames).collect();
    frames.sort_unstable();
    frames.dedup();
    let labels = [a, b].map(|h| rig.handles().labels[h].clone());
    Some(GrossStrain { frame, labels, strain: strain(frame), frames: frames.len() })
}

/// The stretches of a take in which skin is strained beyond the limits of [`gross_strain`]. `None` if the
/// take lacks a handle of the rig.
pub fn gross_strain_events(take: &Take, rig: &Rig) -> Option<Vec<Event>> {
    let columns = columns(take, rig)?;
    let at = |h: usize, f: usize| DVec3::from_array(take.positions[f * take.labels.len() + columns[h]]);
    Some(events(&Target::from_rig(rig), take.frames(), at))
}

/// H columns of the take: those of the rig's handles.
fn columns(take: &Take, rig: &Rig) -> Option<Vec<usize>> {
    let place = |label: &String| take.labels.iter().position(|known| known == label);
    rig.handles().labels.iter().map(place).collect()
}

/// The stretches of frames in which a limit is passed. `at` gives a handle's position in a frame, on the rig.
pub(crate) fn events(
    target: &Target,
    frames: usize,
    at: impl Fn(usize, usize) -> DVec3 + Sync,
) -> Vec<Event> {
    let of_pair = |limit: &StrainLimit| {
        let [a, b] = limit.handles;
        let rest = target.rest[a].distance(target.rest[b]);
        let strain = |f: usize| at(a, f).distance(at(b, f)) / rest - 1.0;
        let beyond: Vec<usize> = (0..frames).filter(|&f| strain(f) > limit.most).collect();
        let of_run = |run: std::ops::Range<usize>| Event {
            other: Some(b),
            strain: Some(run.clone().map(strain).fold(limit.most, f64::max)),
            ..event(Kind::Strain, a, run, 1.0)
        };
        runs(&beyond).into_iter().map(of_run).collect::<Vec<_>>()
    };
    target.strains.par_iter().flat_map_iter(of_pair).collect()
}
