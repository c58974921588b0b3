//! Shortest ways through a graph, from many sources at once (Dijkstra 1959).
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// How a node is reached.
pub trait Label: Copy + PartialEq {
    /// The label of a node that is not reached.
    const UNREACHED: Self;

    /// The distance from the source.
    fn distance(&self) -> f64;

    /// The label of a neighbour that is `length` farther on.
    #[must_use]
    fn through(&self, length: f64) -> Self;

    /// The order in which nodes are visited. Of two labels of a node the lesser is kept.
    fn order(&self, other: &Self) -> Ordering;
}

/// The distance alone.
impl Label for f64 {
    const UNREACHED: Self = Self::INFINITY;

    fn distance(&self) -> f64 {
        *self
    }

    fn through(&self, length: f64) -> Self {
        self + length
    }

    fn order(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }
}

/// A node in the queue.
struct Visit<L> {
    label: L,
    node: u32,
}

impl<L: Label> Ord for Visit<L> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.label.order(&other.label).then(self.node.cmp(&other.node))
    }
}

impl<L: Label> PartialOrd for Visit<L> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<L: Label> PartialEq for Visit<L> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl<L: Label> Eq for Visit<L> {}

/// Writes the label of every node into `labels`. A node is labelled from `sources`, along `edges`. `edges`
/// returns the neighbours of a node and the lengths of the ways to them, 0 or more. No node is reached that
/// would be farther than its `limit`.
///
/// ```
/// use rhytid_geometry::dijkstra::shortest_ways;
///
/// // A chain of four nodes whose edges have the length 1.
/// let edges = |node: u32| [node.wrapping_sub(1), node + 1].into_iter().filter(|&n| n < 4).map(|n| (n, 1.0));
/// let mut distances = [0.0; 4];
/// shortest_ways([(0, 0.0)], edges, |_| 2.0, &mut distances);
/// assert_eq!(distances, [0.0, 1.0, 2.0, f64::INFINITY]);
/// ```
pub fn shortest_ways<L: Label, E: Iterator<Item = (u32, f64)>>(
    sources: impl IntoIterator<Item = (u32, L)>,
    edges: impl Fn(u32) -> E,
    limit: impl Fn(u32) -> f64,
    labels: &mut [L],
) {
    labels.fill(L::UNREACHED);
    spread(sources, edges, limit, labels);
}

/// Does the same where no node is labelled yet. Returns the nodes that are reached, in the order in which
/// they are found.
pub(crate) fn spread<L: Label, E: Iterator<Item = (u32, f64)>>(
    sources: impl IntoIterator<Item = (u32, L)>,
    edges: impl Fn(u32) -> E,
    limit: impl Fn(u32) -> f64,
    labels: &mut [L],
) -> Vec<u32> {
    let mut reached = Vec::new();
    let mut queue = BinaryHeap::new();
    let mut visit = |node: u32, label: L, labels: &mut [L], queue: &mut BinaryHeap<_>| {
        let known = &mut labels[node as usize];
        if label.order(known).is_lt() {
            if *known == L::UNREACHED {
                reached.push(node);
            }
            *known = label;
            queue.push(Reverse(Visit { label, node }));
        }
    };
    for (node, label) in sources {
        visit(node, label, labels, &mut queue);
    }
    while let Some(Reverse(Visit { label, node })) = queue.pop() {
        if labels[node as usize] != label {
            // A shorter way was found since.
            continue;
        }
        for (next, length) in edges(node) {
            let candidate = label.through(length);
            if candidate.distance() <= limit(next) {
                visit(next, candidate, labels, &mut queue);
            }
        }
    }
    reached
}
