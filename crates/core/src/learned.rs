//! What a rig of the learned method has beyond one of the chapter's.
use crate::Rig;
use rayon::prelude::*;
use rhytid_kernels::Real;

/// What was learned of the examples and is no row of the basis: the linear band and the folds' constants (`docs/method.md`,
/// the learned method).
///
/// *Features* are the strain edges, counted from 0, and after them the handles as anchors, F + H in all. A vertex listens to
/// A = K + 8 of them at most. Lengths are in mesh units.
#[derive(Debug, Clone, PartialEq)]
pub struct Learned<T: Real = f32> {
    /// s in 0..1: the part of the linear band in which the three axes do as they like.
    pub share: f64,
    /// λ, above 0: how little the examples are believed.
    pub ridge: f64,
    /// μ, above 0: the same of the folds.
    pub fold_ridge: f64,
    /// σ_m: the standard deviation of a marker's noise per axis, in mesh units.
    pub marker_noise: f64,
    /// V×A indices of features, each at most once with a weight.
    pub features: Vec<u32>,
    /// ω, V×A: at least 0; their sum is 1 where a vertex listens to anything.
    pub feature_weights: Vec<T>,
    /// g, V×A: [`Rig::basis`] has ΔB = Σ_e g_ve D_e in it, D_e being linear in the displacements.
    pub feature_gains: Vec<T>,
    /// c, V×P in mesh units; empty where s is 0.
    pub example_weights: Vec<[T; 3]>,
    /// b, V in mesh units along t, b, n: what makes the folds zero at rest.
    pub fold_constants: Vec<[T; 3]>,
    /// s_v² = Ŵᵀz/3P, V in mesh units squared: how much the examples move a vertex beyond what the shell does.
    pub variances: Vec<T>,
}

impl<T: Real> Learned<T> {
    /// A: features of each vertex.
    pub fn features_per_vertex(&self) -> usize {
        self.features.len().checked_div(self.fold_constants.len()).unwrap_or(0)
    }

    /// The same in another precision; to `f32` it rounds to nearest.
    pub(crate) fn cast<U: Real>(&self) -> Learned<U> {
        let number = |x: &T| U::round_from(x.widen());
        let vector = |x: &[T; 3]| x.map(|c| U::round_from(c.widen()));
        Learned {
            share: self.share,
            ridge: self.ridge,
            fold_ridge: self.fold_ridge,
            marker_noise: self.marker_noise,
            features: self.features.clone(),
            feature_weights: self.feature_weights.par_iter().map(number).collect(),
            feature_gains: self.feature_gains.par_iter().map(number).collect(),
            example_weights: self.example_weights.par_iter().map(vector).collect(),
            fold_constants: self.fold_constants.iter().map(vector).collect(),
            variances: self.variances.iter().map(number).collect(),
        }
    }
}

impl<T: Real> Rig<T> {
    /// F + H: the features of the linear band.
    pub fn features(&self) -> usize {
        self.strain_edges.len() + self.handles.len()
    }

    /// The lengths that the displacements are divided by, F + H in mesh units: `l_e` of a strain edge, `L`, the mean of
    /// those, of an anchor. Without a strain edge, L is 1.
    pub fn feature_lengths(&self) -> Vec<f64> {
        let mut lengths = self.exact_rest_lengths();
        let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
        let mean = if lengths.is_empty() { 1.0 } else { mean };
        lengths.extend(std::iter::repeat_n(mean, self.handles.len()));
        lengths
    }

    /// The rest lengths in f64, whatever the rig's precision.
    fn exact_rest_lengths(&self) -> Vec<f64> {
        let at = |h: u32| self.rest[self.handles[h as usize] as usize].map(T::widen);
        let length = |&[a, b]: &[u32; 2]| {
            let (a, b) = (at(a), at(b));
            (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
        };
        self.strain_edges.iter().map(length).collect()
    }

    /// `D_pe / l_e`, P×(F + H) in 1/mesh unit: the vector strains of the examples, ready to be multiplied with a frame's
    /// displacements, those of strain edges before those of anchors.
    pub fn example_vectors(&self) -> Vec<[T; 3]> {
        let lengths = self.feature_lengths();
        let handles = self.handles.len();
        let rest: Vec<[f64; 3]> = self.handles.iter().map(|&v| self.rest[v as usize].map(T::widen)).collect();
        let mut vectors = Vec::with_capacity(self.example_names.len() * lengths.len());
        for example in self.example_handles.chunks_exact(handles.max(1)) {
            let u = |h: usize| [0, 1, 2].map(|c| example[h][c].widen() - rest[h][c]);
            for (e, &length) in lengths.iter().enumerate() {
                let moved = match self.strain_edges.get(e) {
                    Some(&[a, b]) => {
                        let (a, b) = (u(a as usize), u(b as usize));
                        [0, 1, 2].map(|c| b[c] - a[c])
                    }
                    None => u(e - self.strain_edges.len()),
                };
                vectors.push(moved.map(|x| T::round_from(x / (length * length))));
            }
        }
        vectors
    }

    /// The rig with the shell alone as its large scale, as it was before any example was seen: ΔB is taken out of the
    /// basis, and nothing is added to it. A rig of the chapter's method has nothing else, and is returned as it is.
    pub fn shell(mut self) -> Self {
        let Some(learned) = self.learned.take() else { return self };
        let (handles, per_vertex) = (self.handles.len(), learned.features_per_vertex());
        let (lengths, edges) = (self.feature_lengths(), &self.strain_edges);
        let gains = learned.feature_gains.par_chunks(per_vertex.max(1));
        let rows = self.basis.par_chunks_mut(handles.max(1));
        rows.zip(learned.features.par_chunks(per_vertex.max(1)).zip(gains)).for_each(
            |(row, (features, g))| {
                for (&e, g) in features.iter().zip(g) {
                    let slope = g.widen() / lengths[e as usize];
                    let mut add = |h: usize, x: f64| row[h] = T::round_from(row[h].widen() + x);
                    match edges.get(e as usize) {
                        Some(&[a, b]) => {
                            add(b as usize, -slope);
                            add(a as usize, slope);
                        }
                        None => add(e as usize - edges.len(), -slope),
                    }
                }
            },
        );
        self
    }
}
