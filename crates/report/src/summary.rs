//! The take in numbers.

use rhytid_capture::{Event, Kind, Report};
use rhytid_core::Take;
use serde::Serialize;
use std::collections::BTreeMap;

/// The numbers that a person wants first. A sample is one marker in one frame of the raw take.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Summary {
    /// From the first frame to the end of the last one.
    pub seconds: f64,
    /// Frames of the clean take.
    pub clean_frames: usize,
    /// Its frames per second.
    pub clean_rate: f64,
    /// Handles of the rig.
    pub handles: usize,
    /// The number of handles with a marker in the file.
    pub markers: usize,
    /// All samples: frames × handles.
    pub samples: usize,
    /// The number of samples in each state. They add up to `samples`.
    #[serde(flatten)]
    pub states: States,
    /// The number of events of each kind that occurs.
    pub events: BTreeMap<Kind, usize>,
    /// RMS and greatest of the head's residuals over the frames in which it was fitted, in millimetres.
    /// `None` if it never was.
    pub head_residual_mm: Option<Spread>,
    /// RMS and greatest of the markers' offsets from their handles, in millimetres. `None` if none is known.
    pub offset_mm: Option<Spread>,
}

/// RMS and maximum.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Spread {
    /// The root mean square.
    pub rms: f64,
    /// The greatest.
    pub max: f64,
}

/// Samples by their state. Each is counted once, in the last state that applies.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub(crate) struct States {
    /// As it was measured, except for filtering.
    pub measured: usize,
    /// In a gap that was filled, by the capture system or here.
    pub filled: usize,
    /// An outlier, or under another marker's label.
    pub corrected: usize,
    /// In a gap past the limit, or of a marker that was never seen.
    pub lost: usize,
}

impl Summary {
    /// The summary of a sound report.
    pub(crate) fn new(report: &Report, take: &Take) -> Self {
        let mut events = BTreeMap::new();
        for event in &report.events {
            *events.entry(event.kind).or_default() += 1;
        }
        let fitted = report.head_residuals_mm.iter().map(|&r| f64::from(r)).filter(|&r| r > 0.0);
        Self {
            seconds: if report.rate > 0.0 { report.frames as f64 / report.rate } else { 0.0 },
            clean_frames: take.frames(),
            clean_rate: take.rate(),
            handles: report.labels.len(),
            markers: report.setup.markers.iter().flatten().count(),
            samples: report.frames * report.labels.len(),
            states: States::new(report),
            events,
            head_residual_mm: Spread::new(fitted),
            offset_mm: Spread::new(report.setup.offsets_mm.iter().copied().flatten()),
        }
    }

    /// Number of events of a kind.
    pub(crate) fn count(&self, kind: Kind) -> usize {
        self.events.get(&kind).copied().unwrap_or(0)
    }
}

impl Spread {
    fn new(values: impl Iterator<Item = f64>) -> Option<Self> {
        let (mut n, mut squares, mut max) = (0_usize, 0.0, 0.0_f64);
        for value in values.filter(|value| value.is_finite()) {
            n += 1;
            squares += value * value;
            max = max.max(value);
        }
        (n > 0).then(|| Self { rms: (squares / n as f64).sqrt(), max })
    }
}

impl States {
    fn new(report: &Report) -> Self {
        let mut by_marker: Vec<Vec<&Event>> = vec![Vec::new(); report.labels.len()];
        for event in &report.events {
            // The other marker of a slide or a strain counts as measured.
            let other = event.other.filter(|_| event.kind == Kind::Swap);
            for marker in event.marker.into_iter().chain(other) {
                by_marker[marker].push(event);
            }
        }
        let mut counts = [0; 4];
        let mut states = vec![0_usize; report.frames];
        for events in by_marker {
            states.fill(0);
            for event in events {
                let state = match event.kind {
                    Kind::FilledBefore | Kind::Spline | Kind::Model | Kind::Held => 1,
                    Kind::Swap | Kind::Shuffled | Kind::Outlier | Kind::Slide | Kind::Dropped => 2,
                    Kind::Lost | Kind::NeverSeen | Kind::Left => 3,
                    Kind::Head | Kind::Strain | Kind::Step => 0,
                };
                for old in &mut states[event.first..event.first + event.frames] {
                    *old = state.max(*old);
                }
            }
            for &state in &states {
                counts[state] += 1;
            }
        }
        let [measured, filled, corrected, lost] = counts;
        Self { measured, filled, corrected, lost }
    }
}
