//! The order in which section 2's system is eliminated: nested dissection by the rest positions.
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

/// Parts up to this size are eliminated in one piece: smaller ones cost more in small pieces than they save in
/// arithmetic.
const SMALLEST: usize = 24;

/// Parts above this size are worth another thread.
const WORTH_A_THREAD: usize = 4096;

/// Which vertices share an entry of a symmetric matrix.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Graph {
    /// V + 1 entries: where each vertex's part of `neighbors` begins.
    pub offsets: Vec<usize>,
    /// Ascending for each vertex, the vertex itself among them or not.
    pub neighbors: Vec<u32>,
}

impl Graph {
    /// Those that share an entry with vertex `v`.
    pub fn neighbors(&self, v: u32) -> &[u32] {
        &self.neighbors[self.offsets[v as usize]..self.offsets[v as usize + 1]]
    }
}

/// A part of the elimination order: its two halves, which share no entry, before what separates them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// Its places in the order.
    pub places: Range<usize>,
    /// The last of these, which separate the halves; all of them where a part is not divided.
    pub columns: Range<usize>,
    /// What stands before `columns`.
    pub halves: Option<Box<[Part; 2]>>,
}

/// An elimination order and the tree it comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dissection {
    /// The vertex at each place.
    pub order: Vec<u32>,
    /// All of the order.
    pub root: Part,
}

/// Orders `vertices` (distinct, in range) for an elimination with little fill.
///
/// The vertices are cut in two halves at the median of their longest extent; those of one half that share an entry
/// with the other come last, and each half is treated likewise. The positions say only where to cut: any will do,
/// and what they cost when they are no help is fill.
pub fn dissect(positions: &[[f64; 3]], graph: &Graph, mut vertices: Vec<u32>) -> Dissection {
    let part_of = (0..positions.len()).map(|_| AtomicU32::new(0)).collect();
    let root = Cutter { positions, graph, part_of }.divide(&mut vertices, 0, 1);
    Dissection { order: vertices, root }
}

struct Cutter<'a> {
    positions: &'a [[f64; 3]],
    graph: &'a Graph,
    /// For each vertex the part that it was last put in; 0 in a separator or outside.
    ///
    /// Threads read each other's entries while these change. No result depends on that: a part asks only whether
    /// an entry is one of its own two halves, which no other thread writes before that part is done.
    part_of: Vec<AtomicU32>,
}

impl Cutter<'_> {
    /// Orders `subset`, which begins at place `first` of the whole order. The halves of part `p` are 2 p and 2 p + 1;
    /// each is at most half as large, so that 32 bits suffice.
    fn divide(&self, subset: &mut [u32], first: usize, part: u32) -> Part {
        let places = first..first + subset.len();
        if subset.len() <= SMALLEST {
            self.sort(subset);
            return Part { columns: places.clone(), places, halves: None };
        }
        let axis = self.longest_axis(subset);
        let middle = subset.len() / 2;
        subset.select_nth_unstable_by(middle, |a, b| self.compare(axis, a, b));
        let (low, high) = (2 * part, 2 * part + 1);
        let (lower, upper) = subset.split_at(middle);
        lower.iter().for_each(|&v| self.put(v, low));
        upper.iter().for_each(|&v| self.put(v, high));
        let touching = |half: &[u32], other: u32| -> Vec<u32> {
            let touches = |v: &&u32| self.graph.neighbors(**v).iter().any(|&w| self.part(w) == other);
            half.par_iter().with_min_len(WORTH_A_THREAD).filter(touches).copied().collect()
        };
        let (below, above) = (touching(lower, high), touching(upper, low));
        let mut separator = if below.len() <= above.len() { below } else { above };
        separator.iter().for_each(|&v| self.put(v, 0));
        self.sort(&mut separator);
        let left: Vec<u32> = lower.iter().copied().filter(|&v| self.part(v) == low).collect();
        let right: Vec<u32> = upper.iter().copied().filter(|&v| self.part(v) == high).collect();
        let columns = places.end - separator.len()..places.end;
        let second = first + left.len();
        subset[..left.len()].copy_from_slice(&left);
        subset[left.len()..columns.start - first].copy_from_slice(&right);
        subset[columns.start - first..].copy_from_slice(&separator);
        drop((separator, left, right));

        let (halves, _) = subset.split_at_mut(columns.start - first);
        let (left, right) = halves.split_at_mut(second - first);
        let mut divide_left = || self.divide(left, first, low);
        let mut divide_right = || self.divide(right, second, high);
        let (left, right) = if places.len() > WORTH_A_THREAD {
            rayon::join(divide_left, divide_right)
        } else {
            (divide_left(), divide_right())
        };
        Part { places, columns, halves: Some(Box::new([left, right])) }
    }

    fn part(&self, v: u32) -> u32 {
        self.part_of[v as usize].load(Ordering::Relaxed)
    }

    fn put(&self, v: u32, part: u32) {
        self.part_of[v as usize].store(part, Ordering::Relaxed);
    }

    /// By place along an axis, then by number: never equal.
    fn compare(&self, axis: usize, &a: &u32, &b: &u32) -> std::cmp::Ordering {
        let along = |v: u32| self.positions[v as usize][axis];
        along(a).total_cmp(&along(b)).then(a.cmp(&b))
    }

    /// Neighbours in space stand together, so that a smaller part's share of a separator is a run of it.
    fn sort(&self, subset: &mut [u32]) {
        let axis = self.longest_axis(subset);
        subset.sort_unstable_by(|a, b| self.compare(axis, a, b));
    }

    fn longest_axis(&self, subset: &[u32]) -> usize {
        let position = |&v: &u32| DVec3::from_array(self.positions[v as usize]);
        let low = subset.iter().map(position).fold(DVec3::INFINITY, DVec3::min);
        let high = subset.iter().map(position).fold(DVec3::NEG_INFINITY, DVec3::max);
        (high - low).max_position()
    }
}
