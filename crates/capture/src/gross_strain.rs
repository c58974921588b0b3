//! Strains that no skin has: of labels that slid, were swapped or name another place than the rig's.
use glam::DVec3;
use rhytid_core::{Rig, Take};

/// A strain may be larger than in any example by this; a face without examples says less.
const BEYOND: [f64; 2] = [1.0, 2.0];

/// The worst strain of a take that is beyond what skin does.
#[derive(Debug, Clone, PartialEq)]
pub struct GrossStrain {
    /// The frame.
    pub frame: usize,
    /// The two handles.
    pub labels: [String; 2],
    /// Their strain, 1 for twice the rest length.
    pub strain: f64,
    /// How many frames have one.
    pub frames: usize,
}

/// The worst of the strains that are beyond those of the rig's examples by 100 % (by 200 % without examples), of a take that has all of the rig's
/// handles. `None` if there is none.
pub fn gross_strain(take: &Take, rig: &Rig) -> Option<GrossStrain> {
    let place = |label: &String| take.labels.iter().position(|known| known == label);
    let columns: Vec<usize> = rig.labels.iter().map(place).collect::<Option<_>>()?;
    let lengths = rig.rest_lengths();
    let edges = rig.strain_edges.len();
    let shown =
        |e: usize| rig.pose_features.iter().skip(e).step_by(edges).fold(0.0_f32, |most, f| most.max(*f));
    let beyond = if rig.example_names.is_empty() { BEYOND[1] } else { BEYOND[0] };
    let most: Vec<f64> = (0..edges).map(|e| f64::from(shown(e)) + beyond).collect();
    let (mut worst, mut frames): (Option<(f64, GrossStrain)>, usize) = (None, 0);
    for (frame, positions) in take.positions.chunks_exact(take.labels.len().max(1)).enumerate() {
        let at = |h: u32| DVec3::from_array(positions[columns[h as usize]]);
        let mut is_gross = false;
        for (e, &[a, b]) in rig.strain_edges.iter().enumerate() {
            let strain = at(a).distance(at(b)) / f64::from(lengths[e]) - 1.0;
            let over = strain - most[e];
            if over > 0.0 {
                is_gross = true;
                if worst.as_ref().is_none_or(|(other, _)| over > *other) {
                    let labels = [a, b].map(|h| rig.labels[h as usize].clone());
                    worst = Some((over, GrossStrain { frame, labels, strain, frames: 0 }));
                }
            }
        }
        frames += usize::from(is_gross);
    }
    worst.map(|(_, worst)| GrossStrain { frames, ..worst })
}
