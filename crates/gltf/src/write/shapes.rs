//! Named morph targets without an animation.

use super::clips::Clips;
use super::container::Kind;
use super::document::{About, Document, Placement};
use super::grid::{Extent, normal_offsets, offsets, snap_normals};
use super::measure::Measure;
use super::targets::{most_targets, targets_that_viewers_show, unit_normals};
use rhytid_core::{Error, Progress, Remedy, Result};
use rhytid_export::morphs::Values;
use rhytid_export::{Options, Shape, Shapes, Written};
use std::path::Path;

/// Returns an error if `count` shapes are more than a file at `path` may hold.
pub fn check_count(path: &Path, count: usize, options: &Options) -> Result<()> {
    let most = most_targets(options);
    if count <= most {
        return Ok(());
    }
    Err(Error::too_large(format!(
        "{}: {count} shapes are more than {}: write .usd, leave some out, or lift the limit",
        path.display(),
        targets_that_viewers_show(most)
    ))
    .with_remedies(&[Remedy::MostTargets, Remedy::Force]))
}

/// Writes a mesh with a target for each shape; `shapes` have been checked. Only the options for the numbers
/// of targets apply.
///
/// # Errors
/// [`Error::Input`] if the file could not hold them, or would be larger than `options` allow; [`Error::Io`];
/// [`Error::Cancelled`].
pub fn write_shapes(
    path: &Path,
    kind: Kind,
    shapes: &Shapes<'_>,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Written> {
    check_count(path, shapes.shapes.len(), options)?;
    let rest = shapes.rest_scene();
    let document =
        Document::create(path, kind, &rest, options, About::new(&rest).with_recipe(shapes.recipe))?;
    match options.quantize {
        true => quantized(document, shapes, progress),
        false => plain(document, shapes, progress),
    }
}

fn plain(mut document: Document, shapes: &Shapes<'_>, progress: &dyn Progress) -> Result<Written> {
    let normals = shapes.rest_normals.map(|normals| Values::F32(unit_normals(normals.as_flattened())));
    document.base(&Values::F32(shapes.rest.as_flattened().to_vec()), normals.as_ref())?;
    let count = shapes.shapes.len() as u64;
    for (k, Shape { name, offsets, normal_offsets }) in shapes.shapes.iter().enumerate() {
        progress.step("shapes", k as u64, count)?;
        let values = |offsets: &Vec<[f32; 3]>| Values::F32(offsets.as_flattened().to_vec());
        document.target(name.clone(), &values(offsets), normal_offsets.as_ref().map(values).as_ref())?;
    }
    progress.step("shapes", count, count)?;
    document.finish(Placement::NONE, None, Clips::default(), progress)
}

/// The returned error is that of each shape alone.
fn quantized(mut document: Document, shapes: &Shapes<'_>, progress: &dyn Progress) -> Result<Written> {
    let rest = shapes.rest.as_flattened();
    let moved = |shape: &Shape| -> Vec<f32> {
        rest.iter().zip(shape.offsets.as_flattened()).map(|(a, b)| a + b).collect()
    };
    let mut extent = Extent::new(rest);
    shapes.shapes.iter().for_each(|shape| extent.add(rest, &moved(shape)));
    let grid = extent.grid().ok_or_else(|| {
        Error::out_of_range(format!(
            "{}: has shapes too large to be quantised; export them without quantising",
            document.path().display()
        ))
        .with_remedies(&[Remedy::DoNotQuantize])
    })?;
    let base = grid.snap(rest);
    let normals = shapes.rest_normals.unwrap_or_default().as_flattened();
    let base_normals = snap_normals(&unit_normals(normals));
    let shown = shapes.rest_normals.map(|_| Values::I8(base_normals.clone()));
    document.base(&Values::I16(base.clone()), shown.as_ref())?;

    let mut measure = Measure::default();
    let count = shapes.shapes.len() as u64;
    for (k, shape) in shapes.shapes.iter().enumerate() {
        progress.step("shapes", k as u64, count)?;
        let points = offsets(&base, &grid.snap(&moved(shape)));
        let vectors = |points| <[i16]>::as_chunks::<3>(points).0;
        let stored = vectors(&base).iter().zip(vectors(&points));
        let given = shapes.rest.iter().zip(&shape.offsets);
        for (v, ((rest, offset), (base, point))) in given.zip(stored).enumerate() {
            let given = std::array::from_fn(|axis| f64::from(rest[axis]) + f64::from(offset[axis]));
            let point = std::array::from_fn(|axis| i32::from(base[axis]) + i32::from(point[axis]));
            measure.add(k, v, given, grid.position(point));
        }
        let to_normals = shape.normal_offsets.as_ref().map(|offsets| {
            let to: Vec<f32> = normals.iter().zip(offsets.as_flattened()).map(|(a, b)| a + b).collect();
            normal_offsets(&base_normals, &to)
        });
        document.target(shape.name.clone(), &Values::I16(points), to_normals.as_ref())?;
    }
    progress.step("shapes", count, count)?;
    let error = measure.deviation(grid.reach());
    document.state(error);
    let written = document.finish(grid.placement(), None, Clips::default(), progress)?;
    Ok(Written { errors: vec![error], ..written })
}
