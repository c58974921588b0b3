//! The order in which section 2's system is eliminated: nested dissection by the rest positions.
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

/// Parts up to this size are eliminated in one piece. Dividing them further would cost more than it saves in
/// arithmetic.
const SMALLEST: usize = 24;

/// Parts above this size are worth another thread.
const WORTH_A_THREAD: usize = 4096;

/// Which vertices share an entry of a symmetric matrix.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Graph {
    /// V + 1 entries: where each vertex's part of `neighbors` begins.
    pub offsets: Vec<usize>,
    /// The neighbours of each vertex in ascending order. The vertex itself may be among them.
    pub neighbors: Vec<u32>,
}

impl Graph {
    /// The vertices that share an entry with vertex `v`.
    pub fn neighbors(&self, v: u32) -> &[u32] {
        &self.neighbors[self.offsets[v as usize]..self.offsets[v as usize + 1]]
    }
}

/// A part of the elimination order: first its two halves, which share no entry, then the vertices that
/// separate them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// Its places in the order.
    pub places: Range<usize>,
    /// The last of the places: those of the vertices that separate the halves. All places if the part is not
    /// divided.
    pub columns: Range<usize>,
    /// The two halves, before `columns`; `None` if the part is not divided.
    pub halves: Option<Box<[Part; 2]>>,
}

/// An elimination order and the tree it comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dissection {
    /// The vertex at each place.
    pub order: Vec<u32>,
    /// The part that is the whole order.
    pub root: Part,
}

/// Orders `vertices` (distinct, in range) for an elimination with little fill.
///
/// The vertices are cut in two halves at the median of their longest extent. Those of one half that share an
/// entry with the other half come last. Each half is then divided in the same way. The positions only say
/// where to cut: any positions will do, and bad ones only cost fill.
pub fn dissect(positions: &[[f64; 3]], graph: &Graph, mut vertices: Vec<u32>) -> Dissection {
    let part_of = (0..positions.len()).map(|_| AtomicU32::new(0)).collect();
    let root = Cutter { positions, graph, part_of }.divide(&mut vertices, 0, 1);
    Dissection { order: vertices, root }
}

struct Cutter<'a> {
    positions: &'a [[f64; 3]],
    graph: &'a Graph,
    /// For each vertex the part that it was last put in; 0 if it is in a separator or outside.
    ///
    /// Threads read each other's entries while these change, but no result depends on that. A part only asks
    /// whether an entry is one of its own two halves. No other thread writes these two numbers before the
    /// part is done.
    part_of: Vec<AtomicU32>,
}

impl Cutter<'_> {
    /// Orders `subset`, which begins at place `first` of the whole order. The halves of part `p` are 2 p and
    /// 2 p + 1. Each half is at most half as large, so 32 bits suffice.
    fn divide(&self, subset: &mut [u32], first: usize, part: u32) -> Part {
        let places = first..first + subset.len();
        let extent = self.extent(subset);
        if subset.len() <= SMALLEST {
            self.sort(subset, extent.max_position());
            return Part { columns: places.clone(), places, halves: None };
        }
        let mut separator = self.cut_best(subset, extent, part);
        separator.iter().for_each(|&v| self.put(v, 0));
        // Neighbours in space stand together, so that a smaller part needs a contiguous run of the separator.
        let separator_extent = self.extent(&separator);
        self.sort(&mut separator, separator_extent.max_position());
        let half =
            |label: u32| -> Vec<u32> { subset.iter().copied().filter(|&v| self.part(v) == label).collect() };
        let ordered = [half(2 * part), half(2 * part + 1), separator];
        let [left, right, separator] = ordered.each_ref().map(Vec::len);
        subset.copy_from_slice(&ordered.concat());
        drop(ordered);

        let (left, right) = subset[..left + right].split_at_mut(left);
        let second = first + left.len();
        let (mut divide_left, mut divide_right) =
            (|| self.divide(left, first, 2 * part), || self.divide(right, second, 2 * part + 1));
        let halves = match places.len() > WORTH_A_THREAD {
            true => rayon::join(divide_left, divide_right).into(),
            false => [divide_left(), divide_right()],
        };
        let columns = places.end - separator..places.end;
        Part { places, columns, halves: Some(Box::new(halves)) }
    }

    /// Cuts across the best axis and returns the smallest separator of those tried. A cut across the longest
    /// axis usually has the smallest separator, but not where the surface is bent. Short axes are not worth
    /// the time.
    fn cut_best(&self, subset: &mut [u32], extent: DVec3, part: u32) -> Vec<u32> {
        let long = |axis: &usize| extent[*axis] >= 0.5 * extent.max_element();
        let axes: Vec<usize> = (0..3).filter(long).collect();
        let axis = match axes[..] {
            [axis] => Some(axis),
            _ => axes.into_iter().min_by_key(|&axis| self.cut(subset, axis, part).len()),
        };
        self.cut(subset, axis.unwrap_or(0), part)
    }

    /// Puts each half of `subset` in a part of its own and returns the separator.
    ///
    /// The vertices of a half that share an entry with the other half can separate the two. The separator
    /// comes from the half with fewer such vertices.
    fn cut(&self, subset: &mut [u32], axis: usize, part: u32) -> Vec<u32> {
        let middle = subset.len() / 2;
        subset.select_nth_unstable_by(middle, |a, b| self.compare(axis, a, b));
        let (lower, upper) = subset.split_at(middle);
        let (low, high) = (2 * part, 2 * part + 1);
        lower.iter().for_each(|&v| self.put(v, low));
        upper.iter().for_each(|&v| self.put(v, high));
        let touching = |half: &[u32], other: u32| -> Vec<u32> {
            let touches = |v: &&u32| self.graph.neighbors(**v).iter().any(|&w| self.part(w) == other);
            half.par_iter().with_min_len(WORTH_A_THREAD).filter(touches).copied().collect()
        };
        let (below, above) = (touching(lower, high), touching(upper, low));
        if below.len() <= above.len() { below } else { above }
    }

    fn part(&self, v: u32) -> u32 {
        self.part_of[v as usize].load(Ordering::Relaxed)
    }

    fn put(&self, v: u32, part: u32) {
        self.part_of[v as usize].store(part, Ordering::Relaxed);
    }

    /// By position along an axis, then by number: never equal.
    fn compare(&self, axis: usize, &a: &u32, &b: &u32) -> std::cmp::Ordering {
        let along = |v: u32| self.positions[v as usize][axis];
        along(a).total_cmp(&along(b)).then(a.cmp(&b))
    }

    fn sort(&self, subset: &mut [u32], axis: usize) {
        subset.sort_unstable_by(|a, b| self.compare(axis, a, b));
    }

    /// The size of the bounding box.
    fn extent(&self, subset: &[u32]) -> DVec3 {
        let position = |&v: &u32| DVec3::from_array(self.positions[v as usize]);
        let low = subset.iter().map(position).fold(DVec3::INFINITY, DVec3::min);
        let high = subset.iter().map(position).fold(DVec3::NEG_INFINITY, DVec3::max);
        high - low
    }
}
