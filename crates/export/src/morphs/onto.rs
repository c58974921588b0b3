//! Frames as sums of shapes that are given. Only the weights are found: by least squares over the vertices of
//! each frame, with weights from 0 to 1. No frame knows of another.

use super::bounded;
use super::frames::{Attribute, Frames, TASK};
use super::measure::{Stored, measure, measure_normals};
use super::values::{ClipErrors, Morphs, Target, Values};
use crate::ShapeSet;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use rayon::prelude::*;
use rhytid_core::{Error, Progress, Result};

/// This part of the shapes' mean square is added to each, so that shapes that are the same share their
/// weight.
const RIDGE: f64 = 1e-10;

/// Tasks whose sums are in memory at a time.
const TASKS: usize = 16;

impl Frames {
    /// The weights with which the shapes of `set` come as near to each frame as possible, in the
    /// least-squares sense over the vertices. The base and the targets are those of the set.
    /// [`Morphs::clips`] has the errors.
    ///
    /// # Errors
    /// [`Error::Input`] if there is no frame, no vertex or no shape, or if the set has another number of
    /// vertices; [`Error::Io`]; [`Error::Cancelled`].
    pub fn onto(mut self, set: &ShapeSet, progress: &dyn Progress) -> Result<Morphs> {
        const NAME: &str = "fit the shapes";
        let path = self.path().display().to_string();
        if self.vertices() == 0 || self.frames() == 0 || set.shapes.is_empty() {
            let what = "there is nothing to write: no frame, no vertex or no shape";
            return Err(Error::empty(format!("{path}: {what}")));
        }
        let lengths = set.shapes.iter().map(|shape| shape.offsets.len()).chain([set.base.len()]);
        if let Some(found) = lengths.into_iter().find(|&found| found != self.vertices()) {
            return Err(Error::mismatch(format!(
                "{path}: the shapes have {found} vertices, expected the {} of the frames",
                self.vertices()
            )));
        }
        let rows: Vec<&[f32]> = set.shapes.iter().map(|shape| shape.offsets.as_flattened()).collect();
        let n = rows.len();
        let mut gram = products(&rows, &rows);
        let ridge = RIDGE * (0..n).map(|k| gram[(k, k)]).sum::<f64>() / n as f64;
        // A shape that moves nothing has the weight 0.
        (0..n).for_each(|k| gram[(k, k)] += ridge.max(f64::MIN_POSITIVE));
        let all = self.frames();
        let mut weights: Vec<f32> = Vec::with_capacity(all * n);
        let mut values = Vec::new();
        for batch in self.batches() {
            progress.step(NAME, batch.start as u64, all as u64)?;
            self.batch(Attribute::Positions, batch, &mut values)?;
            let numbers = set.base.as_flattened();
            values.par_chunks_mut(numbers.len()).for_each(|frame| {
                frame.iter_mut().zip(numbers).for_each(|(x, base)| *x -= base);
            });
            let moved: Vec<&[f32]> = values.chunks(numbers.len()).collect();
            let wanted = products(&rows, &moved);
            let of_frame = |frame: usize| bounded::fit(&gram, wanted.col_as_slice(frame));
            let found: Vec<Vec<f64>> = (0..moved.len()).into_par_iter().map(of_frame).collect();
            weights.extend(found.iter().flatten().map(|w| *w as f32));
        }
        progress.step(NAME, all as u64, all as u64)?;
        self.measured(set, weights)
    }

    /// The numbers of the file and their errors.
    fn measured(&mut self, set: &ShapeSet, weights: Vec<f32>) -> Result<Morphs> {
        let values = |vectors: &Vec<[f32; 3]>| Values::F32(vectors.as_flattened().to_vec());
        let has_normals = self.has_normals();
        let base = values(&set.base);
        let base_normals = set.base_normals.as_ref().filter(|_| has_normals).map(|normals| {
            // glTF demands a direction even where there is none.
            let unit = |normal: &[f32; 3]| if *normal == [0.0; 3] { [0.0, 0.0, 1.0] } else { *normal };
            values(&normals.iter().map(unit).collect())
        });
        let positions: Vec<Values> = set.shapes.iter().map(|shape| values(&shape.offsets)).collect();
        let stored =
            Stored { scale: 1.0, translation: [0.0; 3], base: &base, targets: &positions, weights: &weights };
        let measured = measure(self, &stored)?;
        let of_shape = |(shape, positions): (&crate::Shape, Values)| Target {
            name: shape.name.clone(),
            positions,
            normals: shape.normal_offsets.as_ref().filter(|_| base_normals.is_some()).map(values),
        };
        let targets: Vec<Target> = set.shapes.iter().zip(positions).map(of_shape).collect();
        let normals_off = match &base_normals {
            Some(base) => {
                let targets: Vec<&Values> =
                    targets.iter().filter_map(|target| target.normals.as_ref()).collect();
                Some(measure_normals(self, base, &targets, &weights)?)
            }
            None => None,
        };
        let clips = measured.iter().enumerate().map(|(clip, measured)| ClipErrors {
            worst: measured.worst,
            rms: measured.rms,
            extras: Vec::new(),
            normals: normals_off.as_ref().map(|of_normals| of_normals[clip]),
        });
        let clips = clips.collect();
        let (scale, translation) = (1.0, [0.0; 3]);
        Ok(Morphs { scale, translation, base, base_normals, targets, weights, extras: Vec::new(), clips })
    }
}

/// The dot products of all `rows` with all `columns`, of equal lengths. The order of every sum is fixed.
fn products(rows: &[&[f32]], columns: &[&[f32]]) -> Mat<f64> {
    let numbers = rows.first().map_or(0, |row| row.len());
    let size = 3 * TASK;
    let tasks: Vec<usize> = (0..numbers).step_by(size).collect();
    let mut sum = Mat::zeros(rows.len(), columns.len());
    for some in tasks.chunks(TASKS) {
        let of_task = |&first: &usize| {
            let end = numbers.min(first + size);
            let narrow = |vectors: &[&[f32]]| -> Vec<f64> {
                vectors.iter().flat_map(|vector| vector[first..end].iter().copied().map(f64::from)).collect()
            };
            let (rows_here, columns_here) = (narrow(rows), narrow(columns));
            let rows_here = MatRef::from_column_major_slice(&rows_here, end - first, rows.len());
            let columns_here = MatRef::from_column_major_slice(&columns_here, end - first, columns.len());
            let mut part = Mat::zeros(rows.len(), columns.len());
            matmul(part.as_mut(), Accum::Replace, rows_here.transpose(), columns_here, 1.0, Par::Seq);
            part
        };
        let parts: Vec<Mat<f64>> = some.par_iter().map(of_task).collect();
        for part in &parts {
            sum += part;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Shape;
    use rhytid_core::NoProgress;
    use std::path::Path;

    const VERTICES: usize = 700;

    fn vectors(seed: f32) -> Vec<[f32; 3]> {
        let x = |v: usize, c: usize| (seed * (3 * v + c + 1) as f32).sin();
        (0..VERTICES).map(|v| [x(v, 0), x(v, 1), x(v, 2)]).collect()
    }

    fn set() -> ShapeSet {
        let shape = |k: usize| Shape {
            name: format!("s{k}"),
            offsets: vectors(0.37 * (k + 1) as f32),
            normal_offsets: None,
        };
        ShapeSet { base: vectors(0.11), base_normals: None, shapes: (0..4).map(shape).collect() }
    }

    /// The frame of some weights.
    fn mixed(set: &ShapeSet, weights: &[f32]) -> Vec<f32> {
        let base = set.base.as_flattened();
        let moved = |i: usize| -> f64 {
            let shapes = set.shapes.iter().zip(weights);
            shapes.map(|(shape, w)| f64::from(*w) * f64::from(shape.offsets.as_flattened()[i])).sum()
        };
        (0..base.len()).map(|i| (f64::from(base[i]) + moved(i)) as f32).collect()
    }

    fn onto(set: &ShapeSet, frames: &[Vec<f32>], clips: &[usize]) -> Result<Morphs> {
        let spool = tempfile::tempfile().unwrap();
        let mut spooled = Frames::new(spool, Path::new("out.glb"), VERTICES, false, Vec::new())
            .with_clips(clips.iter().copied());
        frames.iter().for_each(|frame| spooled.push(frame, None, &[]).unwrap());
        spooled.onto(set, &NoProgress)
    }

    #[test]
    fn known_weights_come_back_and_clips_have_errors_of_their_own() {
        let set = set();
        let known = [[0.0, 0.25, 1.0, 0.5], [1.0, 1.0, 0.0, 0.125], [0.3, 0.7, 0.2, 0.9]];
        let mut frames: Vec<Vec<f32>> = known.iter().map(|weights| mixed(&set, weights)).collect();
        // No sum of the shapes moves one vertex alone.
        frames[2][3 * 41 + 1] += 0.5;
        let found = onto(&set, &frames, &[2, 1]).unwrap();
        let names: Vec<&str> = found.targets.iter().map(|target| &*target.name).collect();
        assert_eq!(names, ["s0", "s1", "s2", "s3"]);
        for (found, known) in found.weights[..8].iter().zip(known.as_flattened()) {
            assert!((found - known).abs() < 1e-5, "{found} {known}");
        }
        let [first, second] = &found.clips[..] else { panic!("{:?}", found.clips) };
        assert!(first.worst.error < 1e-5 && first.rms < 1e-6, "{first:?}");
        assert_eq!((second.worst.frame, second.worst.vertex), (0, 41));
        assert!((0.48..0.51).contains(&second.worst.error), "{second:?}");
        // By hand: nearly all of the square of 0.5 remains, over 700 vertices.
        assert!((second.rms - 0.5 / 700.0_f64.sqrt()).abs() < 1e-3, "{second:?}");
    }

    #[test]
    fn weights_beyond_the_bounds_end_at_them_and_equal_shapes_share() {
        let mut set = set();
        let beyond = mixed(&set, &[1.6, -0.4, 0.5, 0.0]);
        let found = onto(&set, &[beyond], &[1]).unwrap();
        assert!(found.weights.iter().all(|w| (0.0..=1.0).contains(w)), "{:?}", found.weights);
        assert_eq!((found.weights[0], found.weights[1]), (1.0, 0.0));
        set.shapes[3].offsets = set.shapes[2].offsets.clone();
        set.shapes[1].offsets = vec![[0.0; 3]; VERTICES];
        let found = onto(&set, &[mixed(&set, &[0.0, 0.0, 0.6, 0.0])], &[1]).unwrap();
        let near = |a: f32, b: f32| (a - b).abs() < 1e-4;
        let w = &found.weights;
        assert!(w[1] == 0.0 && near(w[2], 0.3) && near(w[3], 0.3), "{w:?}");
    }

    #[test]
    fn another_number_of_vertices_is_refused() {
        let mut set = set();
        let frame = mixed(&set, &[0.0; 4]);
        set.base.pop();
        let error = onto(&set, &[frame], &[1]).unwrap_err().to_string();
        assert!(error.contains("the shapes have 699 vertices, expected the 700"), "{error}");
    }
}
