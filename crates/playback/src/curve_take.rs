//! Takes from curves: weights of shapes become positions of a rig's handles.
//!
//! The rig then adds its own folds, as for positions that were measured.

use crate::named_shapes::{NamedShapes, of_examples};
use rhytid_core::text::{listed, quoted};
use rhytid_core::{Error, Progress, Remedy, Result, Rig, Take, Warning};
use rhytid_formats::curves::{self, Curves, Meant};
use std::path::Path;

/// A curve without a shape is worth a warning from this weight on.
const USED: f32 = 0.01;

/// Reads curves, and makes a take of them: each handle is at rest plus the sum of weight times displacement
/// over the shapes of the curves' names. Without `shapes`, the rig's own examples are the shapes. `rate`
/// replaces the times of the file.
///
/// # Errors
/// [`Error::Input`]: no shapes, no curve with a shape of its name, or an error of reading either.
/// [`Error::Io`].
pub(crate) fn read(
    path: &Path,
    rig: &Rig,
    shapes: Option<&Path>,
    rate: Option<f64>,
    progress: &dyn Progress,
) -> Result<Take> {
    let curves = curves::read(path, rate)?;
    let shapes = match shapes {
        Some(shapes) => NamedShapes::read(shapes, rig)?,
        None => of_examples(rig).ok_or_else(|| {
            Error::empty(format!(
                "{}: holds curves, which are weights of shapes and no places of markers, and the rig has no \
                 examples with names; give the shapes that they weigh: a file with blend shapes, a folder of \
                 meshes or a project file",
                path.display()
            ))
            .with_remedies(&[Remedy::GiveShapes])
        })?,
    };
    let warn = |sentence: String| progress.warn(&Warning::from(sentence).in_file(path.display()));
    curves.warnings.iter().cloned().for_each(warn);
    let meant = curves::meant(&curves.names, &shapes.names);
    if meant.shapes.iter().all(Vec::is_empty) {
        return Err(Error::mismatch(format!(
            "{}: no curve has the name of a shape: the curves are {}, and {} has {}",
            path.display(),
            listed(curves.names.iter().map(String::as_str)),
            shapes.of,
            listed(shapes.names.iter().map(String::as_str))
        ))
        .with_remedies(&[Remedy::GiveShapes]));
    }
    warnings(&curves, &meant, &shapes).into_iter().for_each(|warning| {
        progress.warn(&warning.in_file(path.display()));
    });
    Ok(take(&curves, &meant, &shapes, rig))
}

/// What of the curves does not reach the rig.
fn warnings(curves: &Curves, meant: &Meant, shapes: &NamedShapes) -> Vec<Warning> {
    let mut found = Vec::new();
    for [first, other] in &meant.twice {
        found.push(Warning::from(format!(
            "the curves {} and {} mean the same shape; the second is left out",
            quoted(&curves.names[*first]),
            quoted(&curves.names[*other])
        )));
    }
    let is_twice = |i: usize| meant.twice.iter().any(|[_, other]| *other == i);
    let without: Vec<(usize, f32)> = (0..curves.names.len())
        .filter(|&i| meant.shapes[i].is_empty() && !is_twice(i))
        .map(|i| (i, curves.largest(i)))
        .filter(|(_, largest)| *largest > USED)
        .collect();
    let most = without.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((most, largest)) = most {
        found.push(
            Warning::from(format!(
                "{} of {} curves have no shape of their name in {} and are left out, the largest being {} with the \
                 weight {largest}: {}",
                without.len(),
                curves.names.len(),
                shapes.of,
                quoted(&curves.names[*most]),
                listed(without.iter().map(|(i, _)| curves.names[*i].as_str()))
            ))
            .with_remedies(&[Remedy::GiveShapes]),
        );
    }
    found
}

fn take(curves: &Curves, meant: &Meant, shapes: &NamedShapes, rig: &Rig) -> Take {
    let handles = rig.handles();
    let rest: Vec<[f64; 3]> = handles.rest.iter().map(|x| x.map(f64::from)).collect();
    let mut positions = Vec::with_capacity(curves.frames() * rest.len());
    for weights in curves.weights.chunks_exact(curves.names.len()) {
        let mut frame = rest.clone();
        for (weight, shapes_of_curve) in weights.iter().zip(&meant.shapes) {
            for &shape in shapes_of_curve {
                let weight = f64::from(*weight);
                for (position, by) in frame.iter_mut().zip(&shapes.at_handles[shape]) {
                    position.iter_mut().zip(by).for_each(|(x, by)| *x += weight * by);
                }
            }
        }
        positions.extend(frame);
    }
    Take { labels: handles.labels.clone(), times: curves.times.clone(), positions, ..Take::default() }
}
