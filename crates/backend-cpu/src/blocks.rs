//! Vertices in blocks: a block is one task, and takes what it reads of the rig through all frames of a batch.

/// Vertices of a block: what a task works on stays in the nearest caches.
pub const BLOCK: usize = 1024;

/// Each block's part of frames × V results, frame after frame.
pub fn blocks(results: &mut [[f32; 3]], vertices: usize) -> Vec<Vec<&mut [[f32; 3]]>> {
    let frames = results.len() / vertices;
    let mut blocks: Vec<Vec<&mut [[f32; 3]]>> = Vec::new();
    blocks.resize_with(vertices.div_ceil(BLOCK), || Vec::with_capacity(frames));
    for frame in results.chunks_exact_mut(vertices) {
        for (part, block) in frame.chunks_mut(BLOCK).zip(&mut blocks) {
            block.push(part);
        }
    }
    blocks
}
