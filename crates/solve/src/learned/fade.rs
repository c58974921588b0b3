//! Where the linear band is faded to the shell, because left-out examples are predicted no better with it.
use super::choice::{self, FEWEST_LEFT_OUT};
use super::linear_band::{self, LinearSettings};
use super::neighborhoods::LinearInfluences;
use super::vector_strains::VectorStrains;
use rayon::prelude::*;
use rhytid_core::{Result, Table, VertexId};
use rhytid_kernels::vec3;

/// The number of vertices in the sample.
const SAMPLES: usize = 4096;

/// A left-out example may be this much worse than with the shell, because the band is needed for mixtures of
/// the examples, which are not left out.
const SLACK: f64 = 1.04;

/// How often the weight of an example is doubled whose error is above the shell's.
const ROUNDS: usize = 24;

/// How much of the linear band is kept: 1 where it is whole, 0 where the shell is alone.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fade {
    /// H.
    pub(crate) of_handles: Vec<f64>,
    /// V.
    pub(crate) of_vertices: Vec<f64>,
}

/// Sums around a handle for one example, in mesh units squared: W · W of what the shell leaves, W · P and
/// P · P, where P is what the other examples predict of it.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    ww: f64,
    wp: f64,
    pp: f64,
}

impl Fade {
    /// Keeps the whole band of H handles and V vertices.
    pub(crate) fn whole(handles: usize, vertices: usize) -> Self {
        Self { of_handles: vec![1.0; handles], of_vertices: vec![1.0; vertices] }
    }

    /// The largest parts with which left-out examples are hardly worse than with the shell.
    ///
    /// Around each handle the part is the largest up to 1 with `Σ |W − part P|² ≤ 1.04² Σ |W|²`. A vertex has
    /// the mean of its nearest handles, by the weights ν of its anchors. Where an example as a whole is still
    /// worse than its shell, its terms count double, again and again.
    ///
    /// `area` and `smooth` are as in [`super::choice::choose`]. With fewer than two examples nothing is
    /// faded.
    ///
    /// # Errors
    /// As [`linear_band::leave_one_out`].
    pub(crate) fn by_leaving_out(
        strains: &VectorStrains,
        influences: &LinearInfluences,
        smooth: &Table<[f64; 3]>,
        settings: LinearSettings,
        area: &[f64],
    ) -> Result<Self> {
        let first_anchor = strains.first_anchor();
        let handles = (strains.features() - first_anchor) as usize;
        let vertices = influences.weights.height();
        let mut fade = Self::whole(handles, vertices);
        let examples = strains.examples();
        if examples < FEWEST_LEFT_OUT {
            return Ok(fade);
        }
        let sample: Vec<VertexId> =
            choice::sample(area, SAMPLES).into_iter().map(VertexId::from_index).collect();
        let errors = linear_band::leave_one_out(strains, influences, smooth, settings, &sample)?;
        let anchors = |v: usize| {
            let anchors = move |&(e, w): &(u32, f64)| e >= first_anchor && w > 0.0;
            let sum: f64 = influences.at(v).filter(anchors).map(|(_, w)| w).sum();
            influences.at(v).filter(anchors).map(move |(e, w)| ((e - first_anchor) as usize, w / sum))
        };
        let mut of_handles = Table::filled(handles, examples, Sums::default());
        for (v, errors) in sample.iter().zip(errors.rows()) {
            for (h, w) in anchors(v.index()) {
                let sums = of_handles.row_mut(h).iter_mut();
                for ((sums, error), smooth) in sums.zip(errors).zip(smooth.row(v.index())) {
                    let predicted = vec3::sub(*smooth, *error);
                    sums.ww += w * vec3::dot(*smooth, *smooth);
                    sums.wp += w * vec3::dot(*smooth, predicted);
                    sums.pp += w * vec3::dot(predicted, predicted);
                }
            }
        }
        let mut weights = vec![1.0; examples];
        for _ in 0..ROUNDS {
            for (part, sums) in fade.of_handles.iter_mut().zip(of_handles.rows()) {
                let sum = |of: fn(&Sums) -> f64| -> f64 {
                    sums.iter().zip(&weights).map(|(sums, w)| w * of(sums)).sum()
                };
                let (ww, wp, pp) = (sum(|sums| sums.ww), sum(|sums| sums.wp), sum(|sums| sums.pp));
                let root = (wp * wp + (SLACK * SLACK - 1.0) * ww * pp).sqrt();
                *part = if pp > 0.0 { ((wp + root) / pp).clamp(0.0, 1.0) } else { 1.0 };
            }
            let mut squares = vec![[0.0; 2]; examples];
            for (v, errors) in sample.iter().zip(errors.rows()) {
                let part: f64 = anchors(v.index()).map(|(h, w)| w * fade.of_handles[h]).sum();
                for ((squares, error), smooth) in squares.iter_mut().zip(errors).zip(smooth.row(v.index())) {
                    let faded = faded(part, *smooth, *error);
                    squares[0] += vec3::dot(faded, faded);
                    squares[1] += vec3::dot(*smooth, *smooth);
                }
            }
            let mut is_worse = false;
            for (weight, [faded, shell]) in weights.iter_mut().zip(squares) {
                if faded > SLACK * SLACK * shell {
                    *weight *= 2.0;
                    is_worse = true;
                }
            }
            if !is_worse {
                break;
            }
        }
        fade.of_vertices
            .par_iter_mut()
            .enumerate()
            .filter(|(v, _)| anchors(*v).next().is_some())
            .for_each(|(v, part)| *part = anchors(v).map(|(h, w)| w * fade.of_handles[h]).sum());
        Ok(fade)
    }
}

/// The error of an example of which `part` of the prediction is kept, given Ŵ and the whole prediction's
/// error.
pub(crate) fn faded(part: f64, smooth: [f64; 3], error: [f64; 3]) -> [f64; 3] {
    vec3::add(smooth.map(|w| (1.0 - part) * w), error.map(|e| part * e))
}
