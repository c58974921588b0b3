//! Shapes: a rig's examples and handles as offsets from its rest pose, for use as sliders.

use crate::Playback;
use rhytid_core::{Error, HandleId, Progress, Result, Rig};
use rhytid_formats::export::{OutputStage, Shape};

impl Playback<'_> {
    /// The offset of each of the P examples from the rest pose: the rig is evaluated at the example's own
    /// handles. With V `rest_normals`, shapes also have the offsets of the normals.
    ///
    /// # Errors
    /// As [`Playback::evaluate`].
    pub fn example_shapes(
        &mut self,
        rest_normals: Option<&[[f32; 3]]>,
        progress: &dyn Progress,
    ) -> Result<Vec<Shape>> {
        let rig = self.rig();
        let mut names = rig.examples().names.iter();
        let mut shapes = Vec::with_capacity(rig.examples().names.len());
        let total = rig.examples().names.len() as u64;
        progress.report("evaluate the examples", 0, total);
        let handles = rig.examples().handles.as_slice().as_flattened();
        let normals = rest_normals.is_some();
        self.evaluate(handles, OutputStage::Full, normals, progress, |positions, normals| {
            let name = names.next().cloned().unwrap_or_default();
            let offsets = difference(positions, &rig.surface().rest);
            let normal_offsets = rest_normals.map(|rest| difference(normals, rest));
            shapes.push(Shape { name, offsets, normal_offsets });
            progress.step("evaluate the examples", shapes.len() as u64, total)
        })?;
        Ok(shapes)
    }
}

impl Playback<'_> {
    /// The sizes of the wrinkles of each of the P examples: V lengths in mesh units.
    ///
    /// The wrinkles are the detail that the rig adds at that example.
    ///
    /// # Errors
    /// As [`Playback::evaluate`].
    pub fn example_wrinkles(&mut self, progress: &dyn Progress) -> Result<Vec<Vec<f32>>> {
        let handles = self.rig().examples().handles.clone();
        let mut poses = |stage| {
            let mut poses: Vec<Vec<f32>> = Vec::new();
            self.evaluate(handles.as_slice().as_flattened(), stage, false, progress, |positions, _| {
                poses.push(positions.to_vec());
                Ok(())
            })?;
            Ok::<_, Error>(poses)
        };
        let (full, smooth) = (poses(OutputStage::Full)?, poses(OutputStage::LargeScale)?);
        let length =
            |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt();
        let wrinkles = |(full, smooth): (&Vec<f32>, &Vec<f32>)| {
            full.as_chunks::<3>().0.iter().zip(smooth.as_chunks::<3>().0).map(length).collect()
        };
        Ok(full.iter().zip(&smooth).map(wrinkles).collect())
    }
}

fn difference(moved: &[f32], rest: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let moved = moved.as_chunks::<3>().0.iter();
    moved.zip(rest).map(|(moved, rest)| std::array::from_fn(|c| moved[c] - rest[c])).collect()
}

/// The 3 H columns of the large scale: the offsets where one handle moves by one unit along an axis. No
/// column has the name of one of the `examples`.
pub fn handle_shapes(rig: &Rig, examples: &[Shape]) -> Vec<Shape> {
    let handles = rig.handles().len();
    let shape = |h: HandleId, axis: usize| {
        let mut name = format!("{}_{}", rig.handles().labels[h.index()], ["x", "y", "z"][axis]);
        while examples.iter().any(|example| example.name == name) {
            name += "_handle";
        }
        Shape { name, offsets: rig.large_scale_column(h, axis), normal_offsets: None }
    };
    (0..handles)
        .map(HandleId::from_index)
        .flat_map(|h| (0..3).map(move |axis| (h, axis)))
        .map(|(h, axis)| shape(h, axis))
        .collect()
}
