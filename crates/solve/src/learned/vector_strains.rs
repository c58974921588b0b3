//! Vector strains: the relative movements of the handles in the examples.
use rhytid_core::{HandleId, Table};
use rhytid_kernels::vec3;

/// The features of the examples and of the noise.
///
/// Features of strain edges, `D_e = (u_b − u_a)/l_e`, come before those of anchors, `D_h = u_h/L`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct VectorStrains {
    /// (F + H)×3P: for each feature x, y, z of one example after the other.
    of_examples: Table<f64>,
    /// What noise of variance 1 adds to |D|² per axis: `2/l_e²`, `1/L²`.
    noise: Vec<f64>,
    /// The ends of the strain edges, and their rest lengths.
    strain_edges: Vec<[HandleId; 2]>,
    rest_lengths: Vec<f64>,
    /// L in mesh units.
    mean: f64,
    examples: usize,
    /// The greatest length of each feature in the expressions of a prior, F + H; empty without a prior.
    prior_lengths: Vec<f64>,
    /// ρ_p: what the noise of an example adds to its ridge, P.
    noise_ridges: Vec<f64>,
}

impl VectorStrains {
    /// The vector strains of P examples, given the displacements of the handles, P×H.
    pub(crate) fn new(
        displacements: &[Vec<[f64; 3]>],
        strain_edges: &[[HandleId; 2]],
        rest_lengths: &[f64],
        mean: f64,
    ) -> Self {
        let handles = displacements.first().map_or(0, Vec::len);
        let mut of_examples = Vec::with_capacity((strain_edges.len() + handles) * displacements.len() * 3);
        for (&[a, b], length) in strain_edges.iter().zip(rest_lengths) {
            for u in displacements {
                of_examples.extend((0..3).map(|c| (u[b.index()][c] - u[a.index()][c]) / length));
            }
        }
        for h in 0..handles {
            displacements.iter().for_each(|u| of_examples.extend(u[h].map(|c| c / mean)));
        }
        let noise = rest_lengths.iter().map(|l| 2.0 / (l * l));
        let noise = noise.chain(std::iter::repeat_n(1.0 / (mean * mean), handles)).collect();
        let of_examples = Table::new(strain_edges.len() + handles, 3 * displacements.len(), of_examples);
        Self {
            of_examples,
            noise,
            strain_edges: strain_edges.to_vec(),
            rest_lengths: rest_lengths.to_vec(),
            mean,
            examples: displacements.len(),
            prior_lengths: Vec::new(),
            noise_ridges: vec![0.0; displacements.len()],
        }
    }

    /// The same for examples whose noise adds ρ_p to their ridges, P.
    pub(crate) fn with_noise(self, noise_ridges: Vec<f64>) -> Self {
        Self { noise_ridges, ..self }
    }

    /// ρ_p: what the noise of each example adds to its ridge, P.
    pub(crate) fn noise_ridges(&self) -> &[f64] {
        &self.noise_ridges
    }

    /// The same for a face with a prior, given the vector strains of the prior's expressions.
    pub(crate) fn with_prior(self, prior: &Self) -> Self {
        Self { prior_lengths: prior.longest(), ..self }
    }

    /// The greatest length of each feature in the examples, F + H.
    fn longest(&self) -> Vec<f64> {
        let of_feature =
            |d: &[f64]| d.as_chunks::<3>().0.iter().map(|d| vec3::length(*d)).fold(0.0, f64::max);
        self.of_examples.rows().map(of_feature).collect()
    }

    /// The greatest length of each feature in the expressions of a prior, F + H. Empty without a prior.
    pub(crate) fn prior_lengths(&self) -> &[f64] {
        &self.prior_lengths
    }

    /// P.
    pub(crate) fn examples(&self) -> usize {
        self.examples
    }

    /// D of feature `e`, 3P.
    pub(crate) fn feature(&self, e: u32) -> &[f64] {
        self.of_examples.row(e as usize)
    }

    /// What noise of variance 1 adds to |D|² of feature `e` per axis.
    pub(crate) fn noise(&self, e: u32) -> f64 {
        self.noise[e as usize]
    }

    /// F + H.
    pub(crate) fn features(&self) -> u32 {
        self.noise.len() as u32
    }

    /// F: the first anchor's number.
    pub(crate) fn first_anchor(&self) -> u32 {
        self.strain_edges.len() as u32
    }

    /// D of all features in the examples, P×(F + H).
    pub(crate) fn by_example(&self) -> Table<[f64; 3]> {
        let of_example = |p: usize| self.of_examples.rows().map(move |d| [0, 1, 2].map(|c| d[3 * p + c]));
        let vectors = (0..self.examples).flat_map(of_example).collect();
        Table::new(self.examples, self.of_examples.height(), vectors)
    }

    /// κ of the examples, `Σ_e ω_e D_pe · D_qe`, over the features that influence a vertex.
    ///
    /// κ is P×P, row-major, and only its lower triangle is written.
    pub(crate) fn common(&self, sources: impl Iterator<Item = (u32, f64)>, kappa: &mut [f64]) {
        kappa.fill(0.0);
        for (e, omega) in sources.filter(|(_, omega)| *omega > 0.0) {
            let d = self.feature(e).as_chunks::<3>().0;
            for (p, row) in kappa.chunks_exact_mut(self.examples).enumerate() {
                let of_p = d[p].map(|x| omega * x);
                for (kappa, of_q) in row.iter_mut().zip(&d[..=p]) {
                    *kappa += of_p[0] * of_q[0] + of_p[1] * of_q[1] + of_p[2] * of_q[2];
                }
            }
        }
    }

    /// Adds `weight` times the feature `e` to a row over the handles. The feature is linear in the
    /// displacements.
    pub(crate) fn add_to_row(&self, e: u32, weight: f64, row: &mut [f64]) {
        match self.strain_edges.get(e as usize) {
            Some(&[a, b]) => {
                let slope = weight / self.rest_lengths[e as usize];
                row[b.index()] += slope;
                row[a.index()] -= slope;
            }
            None => row[e as usize - self.strain_edges.len()] += weight / self.mean,
        }
    }
}
