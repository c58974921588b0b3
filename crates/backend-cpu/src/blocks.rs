//! Blocks of vertices: consecutive ones that a thread takes from the large scale to the positions of one frame, few enough for what it
//! works on to stay in a core's caches.
use crate::lines::PANEL;
use std::ops::Range;

/// The largest block: what a thread works on stays in a second-level cache of 1 MB, and few of its triangles are shared with others.
const LARGEST: usize = 16_384;

/// Blocks of which each thread gets several, so that none waits long for another.
const PER_THREAD: usize = 8;

/// The length of all blocks but the last, a multiple of the panels'.
pub(crate) fn block_length(vertices: usize) -> usize {
    (vertices / (PER_THREAD * rayon::current_num_threads())).next_multiple_of(PANEL).clamp(PANEL, LARGEST)
}

/// The blocks of V vertices.
pub(crate) fn blocks(vertices: usize, length: usize) -> impl Iterator<Item = Range<usize>> {
    (0..vertices).step_by(length).map(move |first| first..(first + length).min(vertices))
}
