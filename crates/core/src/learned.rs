//! What a rig of the learned method has beyond one of the chapter's.
use crate::{FoldStrains, Rig};
use rayon::prelude::*;
use rhytid_kernels::bands::EDGES_SHARE;
use rhytid_kernels::{Real, vec3};

/// What was learned of the examples and is no row of the basis: the linear band (`docs/method.md`, the learned method).
///
/// *Features* are the strain edges, counted from 0, and after them the handles as anchors, F + H in all. A vertex listens to its K
/// strain edges, with 0.9 α, and to A anchors. Lengths are in mesh units.
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
    /// How many times as far as in any example a vector strain's components are followed, 1 or more; infinite where there is no bound.
    pub reach: f64,
    /// The strains that the folds are functions of.
    pub fold_strains: FoldStrains,
    /// V×A indices of handles, ascending where they have a weight.
    pub anchors: Vec<u32>,
    /// ν, V×A in 0..1: their sum is 0.1, or 1 where a vertex reaches no strain edge.
    pub anchor_weights: Vec<T>,
    /// g, V×(K + A), of a vertex's strain edges before its anchors: [`Rig::basis`] has ΔB = Σ_e g_ve D_e in it, D_e being linear
    /// in the displacements.
    pub feature_gains: Vec<T>,
    /// c, V×P in mesh units; empty where s is 0.
    pub example_weights: Vec<[T; 3]>,
    /// s_v² = Ŵᵀz/3P, V in mesh units squared: how much the examples move a vertex beyond what the shell does.
    pub variances: Vec<T>,
}

impl<T: Real> Learned<T> {
    /// A: anchors of each vertex.
    pub fn anchors_per_vertex(&self) -> usize {
        self.anchors.len().checked_div(self.variances.len()).unwrap_or(0)
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
            reach: self.reach,
            fold_strains: self.fold_strains,
            anchors: self.anchors.clone(),
            anchor_weights: self.anchor_weights.par_iter().map(number).collect(),
            feature_gains: self.feature_gains.par_iter().map(number).collect(),
            example_weights: self.example_weights.par_iter().map(vector).collect(),
            variances: self.variances.iter().map(number).collect(),
        }
    }
}

impl<T: Real> Rig<T> {
    /// F + H: the features of what is learned.
    pub fn features(&self) -> usize {
        self.strain_edges.len() + self.handles.len()
    }

    /// What vertex `v` of a rig of the learned method listens to, features and their weights ω: K strain edges, then A anchors.
    pub fn listens_to(&self, v: usize) -> impl Iterator<Item = (usize, f64)> {
        let (k, edges) = (self.influences(), self.strain_edges.len());
        let of_edges = (v * k..(v + 1) * k)
            .map(|i| (self.influence_edges[i] as usize, EDGES_SHARE * self.influence_weights[i].widen()));
        let of_anchors = self.learned.iter().flat_map(move |learned| {
            let a = learned.anchors_per_vertex();
            let of_vertex = v * a..(v + 1) * a;
            of_vertex.map(move |i| (edges + learned.anchors[i] as usize, learned.anchor_weights[i].widen()))
        });
        of_edges.chain(of_anchors)
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

    /// `D_pe`, P×(F + H), a ratio: the vector strains of the examples, those of strain edges before those of anchors.
    pub fn example_vectors(&self) -> Vec<[T; 3]> {
        let examples = self.example_handles.chunks_exact(self.handles.len().max(1));
        examples.flat_map(|example| self.vector_strains(example)).map(|d| d.map(T::round_from)).collect()
    }

    /// `D_e = (u_b − u_a) / l_e` of the strain edges and `D_h = u_h / L` of the handles, F + H, where the H handles are those of an
    /// example.
    pub fn vector_strains(&self, example: &[[T; 3]]) -> Vec<[f64; 3]> {
        let lengths = self.feature_lengths();
        let of_lengths = self.moved_features(example).into_iter().zip(lengths);
        of_lengths.map(|(moved, length)| moved.map(|x| x / length)).collect()
    }

    /// `u_b − u_a` of the strain edges and `u_h` of the handles, F + H in mesh units, where the H handles are those of an example.
    fn moved_features(&self, example: &[[T; 3]]) -> Vec<[f64; 3]> {
        let rest = self.handles.iter().map(|&v| self.rest[v as usize]);
        let difference = |(x, rest): (&[T; 3], [T; 3])| [0, 1, 2].map(|c| x[c].widen() - rest[c].widen());
        let u: Vec<[f64; 3]> = example.iter().zip(rest).map(difference).collect();
        let of_edges = self.strain_edges.iter().map(|&[a, b]| vec3::sub(u[b as usize], u[a as usize]));
        of_edges.chain(u.iter().copied()).collect()
    }

    /// Whether the folds are functions of vector strains, and along the mesh's axes: where not, they are of strain lengths and in
    /// tangent frames.
    pub fn vector_folds(&self) -> bool {
        let of_vectors = |learned: &Learned<T>| learned.fold_strains == FoldStrains::Vectors;
        !self.example_names.is_empty() && self.learned.as_ref().is_some_and(of_vectors)
    }

    /// What was learned beyond the basis, if the rig has any: a linear band, or folds of vector strains.
    pub fn bands(&self) -> Option<&Learned<T>> {
        let has_bands = |learned: &&Learned<T>| !learned.example_weights.is_empty() || self.vector_folds();
        self.learned.as_ref().filter(has_bands)
    }

    /// c / 2 as devices keep it, V×P in mesh units: all 0 where s is 0, and empty where the rig has no [`Rig::bands`].
    pub fn half_example_weights(&self) -> Vec<[T; 3]> {
        let Some(learned) = self.bands() else { return Vec::new() };
        if learned.example_weights.is_empty() {
            return vec![[T::ZERO; 3]; self.vertices() * self.example_names.len()];
        }
        learned.example_weights.iter().map(|c| c.map(|c| T::round_from(0.5 * c.widen()))).collect()
    }

    /// a, b and w as devices keep them, V×[`fold_weights`](rhytid_kernels::bands::fold_weights) in mesh units, where `half` is c / 2
    /// as it is stored: in fp16, a is of what has been rounded, so that the rest pose is exact all the same.
    pub fn fold_weights(&self, half: &[[T; 3]]) -> Vec<[T; 3]> {
        if self.bands().is_none() {
            return Vec::new();
        }
        let (features, examples) = (self.features(), self.example_names.len());
        let examples_handles = self.example_handles.chunks_exact(self.handles.len());
        let vectors = examples_handles.flat_map(|example| self.vector_strains(example));
        let at_rest: Vec<f64> = vectors.map(|d| vec3::dot(d, d)).collect();
        let of_vertex = |v: usize| {
            let mut constant = [0.0; 3];
            for (c, squares) in half[v * examples..][..examples].iter().zip(at_rest.chunks_exact(features)) {
                let squared: f64 = self.listens_to(v).map(|(e, omega)| omega * squares[e]).sum();
                constant = vec3::add(constant, c.map(|c| c.widen() * squared));
            }
            constant.map(T::round_from)
        };
        let constants: Vec<[T; 3]> = (0..self.vertices()).into_par_iter().map(of_vertex).collect();
        if !self.vector_folds() {
            return constants;
        }
        let rows = constants.iter().zip(self.rbf_weights.chunks_exact(self.centers()));
        rows.flat_map(|(a, b_and_w)| std::iter::once(a).chain(b_and_w)).copied().collect()
    }

    /// How far the vector strains are followed, 2×(F + H), a ratio, the least before the most: the examples' own, and 0, times the
    /// rig's reach, each component for itself. What is beyond is taken for the bound.
    pub fn feature_bounds(&self) -> Vec<[T; 3]> {
        let features = self.features();
        let reach = self.learned.as_ref().map_or(f64::INFINITY, |learned| learned.reach);
        // The largest number of a shader stands for no bound.
        let farthest = f64::from(f32::MAX);
        if reach.is_infinite() {
            return [-farthest, farthest]
                .iter()
                .flat_map(|x| vec![[T::round_from(*x); 3]; features])
                .collect();
        }
        let mut bounds = [vec![[0.0_f64; 3]; features], vec![[0.0_f64; 3]; features]];
        let [least, most] = &mut bounds;
        for example in self.example_handles.chunks_exact(self.handles.len().max(1)) {
            for ((d, least), most) in
                self.vector_strains(example).iter().zip(least.iter_mut()).zip(most.iter_mut())
            {
                *least = [0, 1, 2].map(|c| least[c].min(reach * d[c]).max(-farthest));
                *most = [0, 1, 2].map(|c| most[c].max(reach * d[c]).min(farthest));
            }
        }
        bounds.concat().into_iter().map(|x| x.map(T::round_from)).collect()
    }

    /// What the large scale adds to each of the V vertices when `handle` moves along `axis` (0 to 2) and no other does, by mesh
    /// unit: it is linear as far as the rig's reach goes, so that there these columns together are all of it, but for how handles turn.
    pub fn large_scale_column(&self, handle: usize, axis: usize) -> Vec<[T; 3]> {
        let (handles, k, edges) = (self.handles.len(), self.influences(), self.strain_edges.len());
        let learned = self.learned.as_ref().filter(|learned| !learned.example_weights.is_empty());
        // T of the features that this handle is a part of.
        let vectors = if learned.is_some() { self.example_vectors() } else { Vec::new() };
        let lengths = self.feature_lengths();
        let product = |p: usize, e: usize| {
            let sign = match self.strain_edges.get(e) {
                Some(&[_, b]) if b as usize == handle => 1.0,
                Some(&[a, _]) if a as usize == handle => -1.0,
                None if e - edges == handle => 1.0,
                _ => return 0.0,
            };
            sign * vectors[p * self.features() + e][axis].widen() / lengths[e]
        };
        (0..self.vertices())
            .into_par_iter()
            .map(|v| {
                let mut offset = [0.0; 3];
                offset[axis] = self.basis[v * handles + handle].widen();
                if let Some(learned) = learned {
                    let (a, examples) = (learned.anchors_per_vertex(), self.example_names.len());
                    for (p, c) in learned.example_weights[v * examples..][..examples].iter().enumerate() {
                        let of_edges = (v * k..(v + 1) * k).map(|i| {
                            self.influence_weights[i].widen() * product(p, self.influence_edges[i] as usize)
                        });
                        let of_anchors = (v * a..(v + 1) * a).map(|i| {
                            learned.anchor_weights[i].widen()
                                * product(p, edges + learned.anchors[i] as usize)
                        });
                        let kappa = EDGES_SHARE * of_edges.sum::<f64>() + of_anchors.sum::<f64>();
                        (0..3).for_each(|axis| offset[axis] += c[axis].widen() * kappa);
                    }
                }
                offset.map(T::round_from)
            })
            .collect()
    }

    /// Multiplies the folds of each vertex, what the full result has more than the large scale, by `factor`, a ratio: they are linear in their weights. By 0 none
    /// are left; by 1 every bit stays. Frames cost what they cost without.
    pub fn scale_folds(&mut self, factor: impl Fn(usize) -> f64) {
        let centers = self.centers();
        for (v, weights) in self.rbf_weights.chunks_exact_mut(centers).enumerate() {
            let factor = factor(v);
            if factor != 1.0 {
                weights.as_flattened_mut().iter_mut().for_each(|w| *w = T::round_from(factor * w.widen()));
            }
        }
    }

    /// The rig with the shell alone, as it was before any example was seen: ΔB is taken out of the basis, nothing is added to it,
    /// and there are no folds.
    pub fn shell(mut self) -> Self {
        self.rbf_weights.fill([T::ZERO; 3]);
        let Some(learned) = self.learned.take() else { return self };
        let (handles, k, a) = (self.handles.len(), self.influences(), learned.anchors_per_vertex());
        let (lengths, edges) = (self.feature_lengths(), &self.strain_edges);
        let (influence_edges, anchors) = (&self.influence_edges, &learned.anchors);
        self.basis.par_chunks_mut(handles.max(1)).enumerate().for_each(|(v, row)| {
            let mut add = |h: u32, x: f64| row[h as usize] = T::round_from(row[h as usize].widen() + x);
            let (of_edges, of_anchors) = learned.feature_gains[v * (k + a)..][..k + a].split_at(k);
            for (&e, g) in influence_edges[v * k..].iter().zip(of_edges) {
                let slope = g.widen() / lengths[e as usize];
                let [a, b] = edges[e as usize];
                add(b, -slope);
                add(a, slope);
            }
            for (&h, g) in anchors[v * a..].iter().zip(of_anchors) {
                add(h, -g.widen() / lengths[edges.len() + h as usize]);
            }
        });
        self
    }
}
