//! What a rig of the learned method has in addition to a rig of the chapter's method.
use crate::rig::number;
use crate::rig_check::finite;
use crate::{Contact, HandleId, Result, Rig, Table, WrinkleStrains};
use rayon::prelude::*;
use rhytid_kernels::bands::EDGES_SHARE;
use rhytid_kernels::{Real, vec3};

/// What was learned from the examples and is not in the basis: the linear band (`docs/method.md`, the learned
/// method).
///
/// *Features* are the strain edges, counted from 0, and after them the handles as anchors, F + H in all. A
/// vertex is influenced by its K strain edges, with weights 0.9 α, and by A anchors. Lengths are in mesh
/// units.
#[derive(Debug, Clone, PartialEq)]
pub struct Learned<T: Real = f32> {
    /// s in 0..1: how independent the three axes of the linear band are. 0 lets them move together; 1 lets
    /// each be learned by itself.
    pub share: f64,
    /// λ, above 0: the ridge of the linear band.
    pub ridge: f64,
    /// μ, above 0: the ridge of the wrinkles.
    pub wrinkle_ridge: f64,
    /// σ_m: the standard deviation of a marker's noise per axis, in mesh units.
    pub marker_noise: f64,
    /// How far a vector strain is followed, 1 or more: a multiple of its greatest length in an example.
    /// Infinite where there is no limit.
    pub reach: f64,
    /// The greatest length of each feature in the expressions of a prior, F + H ratios. Empty without a
    /// prior.
    pub prior_lengths: Vec<T>,
    /// The strains that the wrinkles are functions of.
    pub wrinkle_strains: WrinkleStrains,
    /// V×A handles, ascending where they have a weight.
    pub anchors: Table<HandleId>,
    /// ν, V×A in 0..1: their sum is 0.1, or 1 where a vertex reaches no strain edge.
    pub anchor_weights: Table<T>,
    /// g, V×(K + A): the strain edges of a vertex come before its anchors. [`Rig::basis`] has ΔB = Σ_e g_ve
    /// D_e in it, where D_e is linear in the displacements.
    pub feature_gains: Table<T>,
    /// c, V×P in mesh units. The table has no columns where s is 0.
    pub example_weights: Table<[T; 3]>,
    /// s_v² = Ŵᵀz/3P, V in mesh units squared: how much the examples move a vertex in addition to the shell.
    pub variances: Vec<T>,
    /// Which vertices rest on eyeballs.
    pub contact: Contact<T>,
}

impl<T: Real> Learned<T> {
    /// A: anchors of each vertex.
    pub fn anchors_per_vertex(&self) -> usize {
        self.anchors.columns()
    }

    /// The anchors of vertex `v`: handles and ν.
    pub fn anchors_of(&self, v: usize) -> impl Iterator<Item = (HandleId, T)> + Clone {
        self.anchors.row(v).iter().copied().zip(self.anchor_weights.row(v).iter().copied())
    }

    /// The same in another precision. Numbers are rounded to the nearest `f32`.
    pub(crate) fn cast<U: Real>(&self) -> Learned<U> {
        Learned {
            share: self.share,
            ridge: self.ridge,
            wrinkle_ridge: self.wrinkle_ridge,
            marker_noise: self.marker_noise,
            reach: self.reach,
            prior_lengths: self.prior_lengths.iter().map(|x| number(*x)).collect(),
            wrinkle_strains: self.wrinkle_strains,
            anchors: self.anchors.clone(),
            anchor_weights: self.anchor_weights.map(|x| number(*x)),
            feature_gains: self.feature_gains.map(|x| number(*x)),
            example_weights: self.example_weights.map(|c| c.map(number)),
            variances: self.variances.iter().map(|x| number(*x)).collect(),
            contact: self.contact.cast(),
        }
    }
}

impl<T: Real> Rig<T> {
    /// `D_pe`, P×(F + H), a ratio: the vector strains of the examples, those of strain edges before those of
    /// anchors.
    pub fn example_vectors(&self) -> Table<[T; 3]> {
        self.widened_example_vectors().map(|d| d.map(T::round_from))
    }

    /// The same in f64, for a rig of any precision.
    pub(crate) fn widened_example_vectors(&self) -> Table<[f64; 3]> {
        let vectors =
            self.examples().handles.rows().flat_map(|example| self.handles().vector_strains(example));
        Table::new(self.examples().len(), self.handles().features(), vectors.collect())
    }

    /// Whether the wrinkles are functions of vector strains, along the mesh's axes. Otherwise they are
    /// functions of strain lengths, in tangent frames.
    pub fn vector_wrinkles(&self) -> bool {
        let of_vectors = |learned: &Learned<T>| learned.wrinkle_strains == WrinkleStrains::Vectors;
        !self.examples().is_empty() && self.learned().is_some_and(of_vectors)
    }

    /// Whether the basis has a part that is followed only up to the rig's reach: ΔB, whose gains g are
    /// [`Learned::feature_gains`]. A rig without examples has no limit.
    pub fn limits_basis(&self) -> bool {
        let is_limited = |learned: &Learned<T>| {
            learned.reach.is_finite() && learned.feature_gains.as_slice().iter().any(|g| *g != T::ZERO)
        };
        !self.examples().is_empty() && self.learned().is_some_and(is_limited)
    }

    /// What was learned in addition to the basis, if anything: a linear band, or wrinkles of vector strains.
    pub fn bands(&self) -> Option<&Learned<T>> {
        let has_bands = |learned: &&Learned<T>| {
            !learned.example_weights.is_empty() || self.vector_wrinkles() || self.limits_basis()
        };
        self.learned().filter(has_bands)
    }

    /// The lengths up to which vector strains are followed, F + H ratios: the greatest length in an example
    /// or in an expression of the prior, times the rig's reach. A longer one is followed in its direction up
    /// to that length.
    pub fn feature_limits(&self) -> Vec<T> {
        let features = self.handles().features();
        let reach = self.learned().map_or(f64::INFINITY, |learned| learned.reach);
        // Shaders have no infinity: their largest number means that there is no limit.
        let farthest = f64::from(f32::MAX);
        if reach.is_infinite() {
            return vec![T::round_from(farthest); features];
        }
        let mut limits = vec![0.0_f64; features];
        let of_prior = self.learned().into_iter().flat_map(|learned| &learned.prior_lengths);
        for (limit, length) in limits.iter_mut().zip(of_prior) {
            *limit = (reach * length.widen()).min(farthest);
        }
        for example in self.widened_example_vectors().rows() {
            for (d, limit) in example.iter().zip(&mut limits) {
                *limit = limit.max(reach * vec3::dot(*d, *d).sqrt()).min(farthest);
            }
        }
        limits.into_iter().map(T::round_from).collect()
    }

    /// What the large scale adds to each of the V vertices when `handle` moves by one mesh unit along `axis`
    /// (0 to 2) and no other handle moves. Within the rig's reach the large scale is linear. There it is the
    /// sum of these columns, apart from the turns of the handles.
    pub fn large_scale_column(&self, handle: HandleId, axis: usize) -> Vec<[T; 3]> {
        let strain_edges = &self.handles().strain_edges;
        let learned = self.learned().filter(|learned| !learned.example_weights.is_empty());
        // T of the features that contain this handle.
        let vectors = self.example_vectors();
        let lengths = self.handles().feature_lengths();
        let product = |p: usize, e: usize| {
            let sign = match strain_edges.get(e) {
                Some(&[_, b]) if b == handle => 1.0,
                Some(&[a, _]) if a == handle => -1.0,
                None if e - strain_edges.len() == handle.index() => 1.0,
                _ => return 0.0,
            };
            sign * vectors.row(p)[e][axis].widen() / lengths[e]
        };
        (0..self.vertices())
            .into_par_iter()
            .map(|v| {
                let mut offset = [0.0; 3];
                offset[axis] = self.basis().row(v)[handle.index()].widen();
                if let Some(learned) = learned {
                    for (p, c) in learned.example_weights.row(v).iter().enumerate() {
                        let of_edges =
                            self.influences().at(v).map(|(e, alpha)| alpha.widen() * product(p, e.index()));
                        let of_anchors = learned
                            .anchors_of(v)
                            .map(|(h, nu)| nu.widen() * product(p, strain_edges.len() + h.index()));
                        let kappa = EDGES_SHARE * of_edges.sum::<f64>() + of_anchors.sum::<f64>();
                        (0..3).for_each(|axis| offset[axis] += c[axis].widen() * kappa);
                    }
                }
                offset.map(T::round_from)
            })
            .collect()
    }

    /// Multiplies the wrinkles of each vertex by `factor`, a ratio. Wrinkles are the difference between the
    /// full result and the large scale; they are linear in their weights. With 0 no wrinkles are left; with 1
    /// every bit stays. The cost of a frame does not change.
    ///
    /// # Errors
    /// [`Error::Input`](crate::Error::Input) if a weight becomes too large for the rig's precision.
    pub fn scale_wrinkles(self, factor: impl Fn(usize) -> f64) -> Result<Self> {
        let mut parts = self.into_parts();
        let mut scaled = false;
        for (v, weights) in parts.fine_scale.rbf_weights.rows_mut().enumerate() {
            let factor = factor(v);
            if factor != 1.0 {
                weights.as_flattened_mut().iter_mut().for_each(|w| *w = T::round_from(factor * w.widen()));
                scaled = true;
            }
        }
        if scaled {
            finite("rbf_weights", parts.fine_scale.rbf_weights.as_slice().as_flattened())?;
        }
        Ok(Self::of_sound(parts))
    }

    /// The rig with the shell alone. ΔB is taken out of the basis, and the rig has no linear band and no
    /// wrinkles.
    ///
    /// # Errors
    /// [`Error::Input`](crate::Error::Input) if a number of the basis becomes too large for the rig's
    /// precision.
    pub fn shell(self) -> Result<Self> {
        let mut parts = self.into_parts();
        parts.fine_scale.rbf_weights.as_mut_slice().fill([T::ZERO; 3]);
        let Some(learned) = parts.learned.take() else { return Ok(Self::of_sound(parts)) };
        let (influences, edges) = (&parts.influences, &parts.handles.strain_edges);
        let lengths = parts.handles.feature_lengths();
        parts.basis.par_rows_mut().enumerate().for_each(|(v, row)| {
            let mut add = |h: HandleId, x: f64| row[h.index()] = T::round_from(row[h.index()].widen() + x);
            let (of_edges, of_anchors) = learned.feature_gains.row(v).split_at(influences.per_vertex());
            for (&e, g) in influences.edges.row(v).iter().zip(of_edges) {
                let slope = g.widen() / lengths[e.index()];
                let [a, b] = edges[e.index()];
                add(b, -slope);
                add(a, slope);
            }
            for (&h, g) in learned.anchors.row(v).iter().zip(of_anchors) {
                add(h, -g.widen() / lengths[edges.len() + h.index()]);
            }
        });
        finite("basis", parts.basis.as_slice())?;
        Ok(Self::of_sound(parts))
    }
}
