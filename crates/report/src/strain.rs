//! Strains: how much the clean take stretches the rig's strain edges (section 3 of the method).

use glam::DVec3;
use rhytid_core::{Error, HandleId, Result, Rig, Take};
use serde::Serialize;

/// The strains of a take.
pub(crate) struct Strains<'a> {
    take: &'a Take,
    /// The marker's column in the take for each handle.
    columns: Vec<usize>,
    /// For each edge of the rig its two handles and rest length; in the rig's order.
    pairs: Vec<([usize; 2], f64)>,
    /// The edges that have a length, largest strain first.
    pub edges: Vec<Edge>,
}

/// An edge and its extremes; strains are fractions of the rest length.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Edge {
    /// The label of one end.
    pub a: String,
    /// The label of the other.
    pub b: String,
    /// The least strain, of the largest compression.
    pub least: f64,
    /// The greatest strain, of the largest stretch.
    pub greatest: f64,
    /// The time of the larger of the two, in seconds.
    pub time: f64,
    /// The frame of the clean take at that time.
    pub frame: usize,
    /// Its index in the rig.
    #[serde(skip)]
    index: usize,
}

impl<'a> Strains<'a> {
    /// Measures `take` on `rig`.
    ///
    /// # Errors
    /// [`Error::Internal`] if the take lacks a handle.
    pub(crate) fn new(take: &'a Take, rig: &Rig) -> Result<Self> {
        let column = |label: &String| {
            let found = take.labels.iter().position(|l| l == label);
            found.ok_or_else(|| Error::Internal(format!("the clean take lacks the handle {label:?}")))
        };
        let columns = rig.handles().labels.iter().map(column).collect::<Result<Vec<_>>>()?;
        let rest = |handle: HandleId| DVec3::from(rig.handles().rest[handle.index()].map(f64::from));
        let pairs: Vec<([usize; 2], f64)> = (rig.handles().strain_edges.iter())
            .map(|edge| (edge.map(HandleId::index), rest(edge[0]).distance(rest(edge[1]))))
            .collect();
        let mut strains = Self { take, columns, pairs, edges: Vec::new() };
        let start = take.times.first().copied().unwrap_or(0.0);
        let edge = |index: usize| {
            let [a, b] = strains.pairs[index].0.map(|handle| rig.handles().labels[handle].clone());
            Edge { a, b, least: 0.0, greatest: 0.0, time: start, frame: 0, index }
        };
        let mut edges: Vec<Edge> =
            (0..strains.pairs.len()).filter(|&i| strains.pairs[i].1 > 0.0).map(edge).collect();
        // Frame by frame, because a long take is larger than any cache.
        for (frame, &time) in take.times.iter().enumerate() {
            for edge in &mut edges {
                edge.see(strains.at(edge.index, frame), frame, time);
            }
        }
        edges.sort_by(|x, y| y.peak().abs().total_cmp(&x.peak().abs()));
        strains.edges = edges;
        Ok(strains)
    }

    fn at(&self, index: usize, frame: usize) -> f64 {
        let ([a, b], length) = self.pairs[index];
        let [a, b] = [a, b].map(|handle| DVec3::from(self.position(handle, frame)));
        (a.distance(b) - length) / length
    }

    /// The position of a handle's marker in a frame of the clean take.
    pub(crate) fn position(&self, handle: usize, frame: usize) -> [f64; 3] {
        self.take.positions[frame * self.take.labels.len() + self.columns[handle]]
    }

    /// The take's first and last time.
    pub(crate) fn span(&self) -> [f64; 2] {
        let ends = self.take.times.first().zip(self.take.times.last());
        ends.map_or([0.0; 2], |(&first, &last)| [first, last])
    }

    /// The two handles of an edge.
    pub(crate) fn handles(&self, edge: &Edge) -> [usize; 2] {
        self.pairs[edge.index].0
    }

    /// Time and strain of an edge, frame by frame.
    pub(crate) fn over_time(&self, edge: &Edge) -> impl Iterator<Item = [f64; 2]> {
        let index = edge.index;
        self.take.times.iter().enumerate().map(move |(frame, &time)| [time, self.at(index, frame)])
    }

    /// Time, and whether one end of an edge was not measured then.
    pub(crate) fn doubtful(&self, edge: &Edge) -> impl Iterator<Item = (f64, bool)> {
        let ends = self.handles(edge).map(|handle| self.columns[handle]);
        let markers = self.take.labels.len();
        let confidence = self.take.confidence.as_deref();
        self.take.times.iter().enumerate().map(move |(frame, &time)| {
            let doubtful = |column| confidence.is_some_and(|c| c[frame * markers + column] < 1.0);
            (time, ends.into_iter().any(doubtful))
        })
    }
}

impl Edge {
    fn see(&mut self, strain: f64, frame: usize, time: f64) {
        if !strain.is_finite() {
            return;
        }
        if strain.abs() > self.peak().abs() {
            (self.frame, self.time) = (frame, time);
        }
        self.least = self.least.min(strain);
        self.greatest = self.greatest.max(strain);
    }

    /// The strain with the largest absolute value.
    pub(crate) fn peak(&self) -> f64 {
        if self.greatest >= -self.least { self.greatest } else { self.least }
    }
}
