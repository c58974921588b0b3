//! Blocks of consecutive vertices. A thread computes a block from the large scale to the positions of one
//! frame. A block is so small that its data stay in a core's caches.
use crate::lines::PANEL;
use std::ops::Range;

/// The largest block. Its data stay in a second-level cache of 1 MB, and it shares few of its triangles with
/// others.
const LARGEST: usize = 16_384;

/// The number of blocks for each thread. With several blocks, no thread waits long for another.
const PER_THREAD: usize = 8;

/// The length of all blocks except the last: a multiple of a panel's length.
pub(crate) fn block_length(vertices: usize) -> usize {
    (vertices / (PER_THREAD * rayon::current_num_threads())).next_multiple_of(PANEL).clamp(PANEL, LARGEST)
}

/// The blocks of V vertices.
pub(crate) fn blocks(vertices: usize, length: usize) -> impl Iterator<Item = Range<usize>> {
    (0..vertices).step_by(length).map(move |first| first..(first + length).min(vertices))
}
