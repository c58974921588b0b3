//! Corrections: what an artist sculpted of one frame, in all frames that are like it.

use crate::local_normals;
use rayon::prelude::*;
use rhytid_core::Rig;
use rhytid_formats::edits::Curve;
use rhytid_kernels::normals::{self, VertexTriangles};
use rhytid_kernels::vec3;

/// What is moved by less is as it was: a part of the face's diagonal, below which files round.
const NOTHING: f64 = 2e-6;

/// Where nothing else is said, a correction reaches so far of the way to the rest pose.
const USUAL_REACH: f64 = 0.5;

/// A correction reaches no less far, as a ratio: what is sculpted near the rest pose would flicker with the markers' noise.
const LEAST_REACH: f64 = 0.02;

/// What was sculpted of one frame: offsets of its vertices, which fade as a frame is less like it.
///
/// Vertex v of a frame moves by `a ψ(r_v / reach) F_v S_vᵀ d_v`, with the offset d_v and the frame of its normal and its tangent neighbour S_v in the
/// sculpted frame, and F_v now. r_v is how far the frame is from the sculpted one, as the vertex sees it: `√Σ ω ‖D_e − D_e'‖²` over the vector strains (of
/// a rig of the chapter's method over strains) that it listens to; and `ψ(s) = (1 − s)⁴ (4 s + 1)` (Wendland's C²), which is 0 from 1 on. So the sculpted
/// frame is met to rounding, and a frame farther away than the reach keeps every bit.
#[derive(Debug, Clone, PartialEq)]
pub struct Correction {
    /// The frame of the take that was sculpted.
    frame: usize,
    /// Those that move, ascending.
    vertices: Vec<u32>,
    /// S_vᵀ d_v of each, with the region's weight, in mesh units.
    offsets: Vec<[f64; 3]>,
    features: Vec<[f64; 3]>,
    reach: f64,
    /// a over the take's time in seconds.
    amount: Curve,
}

/// A sculpted frame as files have it.
pub(crate) struct Sculpted<'a> {
    pub frame: usize,
    /// V positions in mesh units, and those that they were before.
    pub positions: &'a [[f64; 3]],
    pub before: &'a [[f32; 3]],
    /// H positions.
    pub handles: &'a [[f32; 3]],
    /// V, from 0 to 1.
    pub weights: &'a [f32],
    /// `None` for [`USUAL_REACH`].
    pub reach: Option<f64>,
    pub amount: Curve,
}

impl Correction {
    pub(crate) fn new(rig: &Rig, triangles: &VertexTriangles, sculpted: Sculpted<'_>) -> Self {
        let bounds = rig.surface().rest.iter().fold([[f64::MAX; 3], [f64::MIN; 3]], |[low, high], x| {
            let x = x.map(f64::from);
            [0, 1].map(|end: usize| {
                [0, 1, 2].map(|c| if end == 0 { low[c].min(x[c]) } else { high[c].max(x[c]) })
            })
        });
        let nothing = NOTHING * length(vec3::sub(bounds[1], bounds[0]));
        let (mut vertices, mut offsets) = (Vec::new(), Vec::new());
        let pairs = sculpted.positions.iter().zip(sculpted.before).zip(sculpted.weights);
        for (v, ((after, before), weight)) in pairs.enumerate() {
            let off = vec3::sub(*after, before.map(f64::from));
            if length(off) > nothing && *weight > 0.0 {
                let [t, b, n] = frame_of(rig, triangles, sculpted.before, v);
                let local = [vec3::dot(t, off), vec3::dot(b, off), vec3::dot(n, off)];
                vertices.push(v as u32);
                offsets.push(local.map(|x| x * f64::from(*weight)));
            }
        }
        let features = features(rig, sculpted.handles);
        let rest = vec![[0.0; 3]; features.len()];
        let from_rest = vertices.iter().map(|&v| apart(rig, v as usize, &features, &rest)).sum::<f64>();
        let usual = (USUAL_REACH * from_rest / vertices.len().max(1) as f64).max(LEAST_REACH);
        Self {
            frame: sculpted.frame,
            vertices,
            offsets,
            features,
            reach: sculpted.reach.unwrap_or(usual),
            amount: sculpted.amount,
        }
    }

    /// The frame of the take that was sculpted.
    pub fn frame(&self) -> usize {
        self.frame
    }

    /// How many vertices it moves.
    pub fn vertices(&self) -> usize {
        self.vertices.len()
    }

    /// The farthest that it moves one, in mesh units.
    pub fn largest(&self) -> f64 {
        self.offsets.iter().map(|offset| length(*offset)).fold(0.0, f64::max)
    }

    /// From where on it does nothing: how far a frame's strains are from the sculpted frame's, a ratio.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// Moves a frame's V positions and their normals (empty where they are not wanted), from its H handle positions and its time in seconds. The result
    /// is the farthest that a vertex moves, in mesh units; where it is 0, every bit is as it was.
    pub fn apply(
        &self,
        rig: &Rig,
        triangles: &VertexTriangles,
        time: f64,
        handles: &[[f32; 3]],
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
    ) -> f64 {
        let amount = self.amount.at(time);
        if amount == 0.0 {
            return 0.0;
        }
        let features = features(rig, handles);
        let before: &[[f32; 3]] = positions;
        let moved = |(&v, offset): (&u32, &[f64; 3])| {
            let s = apart(rig, v as usize, &features, &self.features) / self.reach;
            if s >= 1.0 {
                return None;
            }
            let amount = amount * (1.0 - s).powi(4) * (4.0 * s + 1.0);
            let [t, b, n] = frame_of(rig, triangles, before, v as usize);
            let along = |c: usize| amount * (offset[0] * t[c] + offset[1] * b[c] + offset[2] * n[c]);
            Some((v, [along(0), along(1), along(2)]))
        };
        let pairs = self.vertices.par_iter().zip(&self.offsets);
        let moved: Vec<(u32, [f64; 3])> = pairs.filter_map(moved).collect();
        for &(v, by) in &moved {
            let x = &mut positions[v as usize];
            *x = std::array::from_fn(|c| (f64::from(x[c]) + by[c]) as f32);
        }
        local_normals::update(rig, triangles, moved.iter().map(|(v, _)| *v), positions, normals);
        moved.iter().map(|(_, by)| length(*by)).fold(0.0, f64::max)
    }
}

/// What vertices see of a pose.
fn features(rig: &Rig, handles: &[[f32; 3]]) -> Vec<[f64; 3]> {
    match rig.learned() {
        Some(_) => rig.handles().vector_strains(handles),
        None => rig.handles().strains(handles).into_iter().map(|strain| [strain.into(), 0.0, 0.0]).collect(),
    }
}

/// How far two poses are from each other, as a vertex sees them; the mean of all features where it listens to none.
fn apart(rig: &Rig, vertex: usize, a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let square = |e: usize| {
        let off = vec3::sub(a[e], b[e]);
        vec3::dot(off, off)
    };
    let (mut sum, mut total) = (0.0, 0.0);
    for (e, weight) in rig.listens_to(vertex) {
        sum += weight * square(e);
        total += weight;
    }
    match total > 0.0 {
        true => (sum / total).sqrt(),
        false => ((0..a.len()).map(square).sum::<f64>() / a.len().max(1) as f64).sqrt(),
    }
}

/// Tangent, bitangent and normal of a vertex; the axes where it has no surface around it.
fn frame_of(rig: &Rig, triangles: &VertexTriangles, positions: &[[f32; 3]], v: usize) -> [[f64; 3]; 3] {
    let n = normals::vertex_normal(positions, &rig.surface().triangles, triangles.at(v)).map(f64::from);
    let neighbour = positions[rig.surface().tangent_neighbors[v].index()].map(f64::from);
    let edge = vec3::sub(neighbour, positions[v].map(f64::from));
    let along = vec3::dot(edge, n);
    let tangent: [f64; 3] = std::array::from_fn(|c| edge[c] - along * n[c]);
    let size = length(tangent);
    if !(size > 0.0 && length(n) > 0.5) {
        return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    }
    let t = tangent.map(|x| x / size);
    [t, vec3::cross(n, t), n]
}

fn length(x: [f64; 3]) -> f64 {
    vec3::dot(x, x).sqrt()
}
