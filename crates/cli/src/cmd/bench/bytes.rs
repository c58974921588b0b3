//! The least number of bytes that a frame moves, by part.

use crate::output;
use rhytid::{BandWeights, BasisStorage, ClusteredBasis, Rig, Stage, UploadOptions};
use serde::Serialize;

/// A part of what a frame reads and writes.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Part {
    pub part: &'static str,
    pub bytes_per_vertex: f64,
}

/// What a frame moves with a storage.
#[derive(Debug, Serialize)]
pub(super) struct Stored {
    pub storage: &'static str,
    pub parts: Vec<Part>,
    /// Bytes of all vertices, in the order of [`Stage::ALL`].
    #[serde(skip)]
    pub stages: [f64; 6],
}

impl Stored {
    /// The least that a frame moves, in a batch of `options.max_frames` frames.
    ///
    /// What is constant is read once a batch. Results that do not fit into caches are written and read once a
    /// frame. Triangles are not counted: their size depends on order and encoding.
    pub(super) fn new(rig: &Rig, options: UploadOptions) -> Self {
        let vertices = rig.vertices() as f64;
        let mut stored = Self { storage: options.basis.name(), parts: Vec::new(), stages: [0.0; 6] };
        let mut add = |part, stage, bytes_per_vertex: f64| {
            stored.stages[stage as usize] += bytes_per_vertex * vertices;
            match stored.parts.iter_mut().find(|known| known.part == part) {
                Some(known) => known.bytes_per_vertex += bytes_per_vertex,
                None => stored.parts.push(Part { part, bytes_per_vertex }),
            }
        };
        let once = 1.0 / options.max_frames as f64;
        let basis = match options.basis {
            BasisStorage::Clustered => ClusteredBasis::new(rig).bytes() as f64 / vertices,
            BasisStorage::F32 => (4 * rig.handles().len()) as f64,
            BasisStorage::F16 => (2 * rig.handles().len()) as f64,
        };
        let wrinkles = rig.vector_wrinkles();
        let index = if rig.handles().strain_edges.len() <= 256 { 1 } else { 2 };
        let weight = if options.basis.has_narrow_weights(wrinkles) { 2 } else { 4 };
        let influences = |count: usize| ((index + weight) * count) as f64;
        let position = 12.0;
        add("basis", Stage::LargeScale, once * basis);
        add("rest positions", Stage::LargeScale, once * position);
        // Vector strains: one pass computes the large scale and the detail.
        let detail = if wrinkles { Stage::LargeScale } else { Stage::Detail };
        add("influences", detail, once * influences(rig.influences().per_vertex()));
        if let Some(learned) = rig.bands() {
            let weights = BandWeights::new(rig, options.basis).bytes() as f64 / vertices;
            add("anchors", Stage::LargeScale, once * influences(learned.anchors_per_vertex()));
            add("weights of the bands", Stage::LargeScale, once * weights);
        }
        if !wrinkles {
            add("weights of the detail", detail, once * (12 * rig.centers()) as f64);
            add("tangent neighbours", Stage::Positions, once * 4.0);
            add("results", Stage::LargeScale, position);
            add("results", Stage::LargeScaleNormals, position);
        }
        // Positions are written, and read for the normals.
        add("results", Stage::Positions, position);
        add("results", Stage::Normals, position);
        stored.stages[Stage::Strain as usize] = (4 * rig.handles().strain_edges.len()) as f64;
        stored
    }

    /// Bytes of a vertex and frame.
    pub(super) fn sum(&self) -> f64 {
        self.parts.iter().map(|part| part.bytes_per_vertex).sum()
    }
}

/// A table with a column for each storage. All have the same parts.
pub(super) fn table(each: &[Stored; BasisStorage::ALL.len()]) -> String {
    let row = |name: &str, bytes: [f64; 3]| {
        let [f32, f16, clustered] = bytes.map(|bytes| format!("{bytes:.1}"));
        [format!("  {name}"), f32, f16, clustered]
    };
    let [f32, f16, clustered] = each.each_ref().map(|stored| stored.storage.to_owned());
    let mut rows = vec![["bytes of a vertex".to_owned(), f32, f16, clustered]];
    for (i, part) in each[0].parts.iter().enumerate() {
        rows.push(row(part.part, each.each_ref().map(|stored| stored.parts[i].bytes_per_vertex)));
    }
    rows.push(row("together", each.each_ref().map(Stored::sum)));
    output::table(&rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid::core::Method;
    use rhytid_demo::{Size, sized_rig};

    #[test]
    fn the_chapters_frame_moves_584_bytes_a_vertex_and_half_of_the_basis_less_as_fp16() {
        let size = Size { vertices: 10_000, ..Size::CHAPTER };
        let rigs = [Method::Chapter, Method::default()].map(|method| sized_rig(size, method));
        let per_vertex = |rig: &Rig, basis, max_frames| {
            let stored = Stored::new(rig, UploadOptions { max_frames, basis });
            let bytes: f64 = stored.stages.iter().sum::<f64>() - stored.stages[Stage::Strain as usize];
            assert!((stored.sum() - bytes / rig.vertices() as f64).abs() < 1e-6);
            stored.sum()
        };
        let is = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-6, "{found}, {expected}");
        let [chapter, learned] = &rigs;
        is(per_vertex(chapter, BasisStorage::F32, 1), 584.0);
        is(per_vertex(chapter, BasisStorage::F16, 1), 584.0 - 178.0);
        is(per_vertex(chapter, BasisStorage::F32, 8), (584.0 - 48.0) / 8.0 + 48.0);
        // Anchors, c and a; smooth positions and normals are not stored between.
        is(per_vertex(learned, BasisStorage::F32, 1), 584.0 + 40.0 + 72.0 + 12.0 - 28.0);
        // Weights of influences have two bytes less. In most tiles those of the examples have a half, and
        // units.
        let wide = 584.0 - 178.0 + 40.0 + 72.0 + 12.0 - 28.0 - 2.0 * 24.0;
        let narrow_part = BandWeights::new(learned, BasisStorage::F16).narrow_part();
        let expected = wide - narrow_part * (72.0 - 4.0);
        let found = per_vertex(learned, BasisStorage::F16, 1);
        assert!(narrow_part > 0.8 && (found - expected).abs() < 1.0, "{found}, {expected}: {narrow_part}");
    }
}
