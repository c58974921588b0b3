//! How far a frame is beyond the reach of the rig's examples.

use crate::Rig;
use rhytid_kernels::vector_differences;

/// What the host needs to say how far a frame's vector strains are beyond the rig's reach.
#[derive(Debug, Clone)]
pub(super) struct Limits {
    strain_edges: Vec<[u32; 2]>,
    /// F + H.
    feature_lengths: Vec<f32>,
    /// F + H.
    feature_limits: Vec<f32>,
}

impl Limits {
    pub(super) fn new(rig: &Rig) -> Self {
        Self {
            strain_edges: rig.handles().edge_numbers().to_vec(),
            feature_lengths: rig.handles().feature_lengths().iter().map(|&length| length as f32).collect(),
            feature_limits: rig.feature_limits(),
        }
    }

    /// D − limited(D) of the F + H features of a frame of H displacements, four numbers each. The fourth of
    /// the first is 1 if any feature is beyond.
    pub(super) fn excess(&self, u: &[[f32; 3]]) -> Vec<[f32; 4]> {
        let buffers = vector_differences::Buffers {
            strain_edges: &self.strain_edges,
            feature_lengths: &self.feature_lengths,
            example_vectors: &[],
            feature_limits: &self.feature_limits,
        };
        let excess = |e: usize| {
            let [x, y, z] = vector_differences::vector_excess(&buffers, u, e);
            [x, y, z, 0.0]
        };
        let mut excess: Vec<[f32; 4]> = (0..self.feature_lengths.len()).map(excess).collect();
        let is_beyond = excess.iter().any(|d| *d != [0.0; 4]);
        if let Some(first) = excess.first_mut() {
            first[3] = f32::from(u8::from(is_beyond));
        }
        excess
    }
}
