//! Corrections: an artist sculpts one frame, and all similar frames follow.

use crate::local_normals;
use rayon::prelude::*;
use rhytid_core::Rig;
use rhytid_formats::edits::Curve;
use rhytid_kernels::normals::{self, VertexTriangles};
use rhytid_kernels::vec3;

/// An offset below this part of the face's diagonal counts as none. Files round to more than that.
const NOTHING: f64 = 2e-6;

/// The reach of a correction that states none, as a part of the mean distance from the sculpted frame to the
/// rest pose.
const USUAL_REACH: f64 = 0.5;

/// The least reach of a correction that states none, as a ratio. With a smaller reach, a correction near the
/// rest pose would flicker with the markers' noise.
const LEAST_REACH: f64 = 0.02;

/// The sculpted offsets of one frame's vertices, which fade as a frame is less like that frame.
///
/// Vertex v of a frame moves by `a ψ(r_v / reach) F_v S_vᵀ d_v`. Here d_v is the vertex's sculpted offset,
/// and a is the amount at the frame's time. S_v is the vertex's tangent frame in the sculpted frame, made of
/// its normal and its tangent neighbour. F_v is its tangent frame in the frame that is moved.
///
/// r_v is the distance of the frame from the sculpted one at the vertex: `√Σ ω ‖D_e − D_e'‖²`. The sum is
/// over the vector strains that influence the vertex. A rig of the chapter's method has strains in their
/// place. `ψ(s) = (1 − s)⁴ (4 s + 1)` is Wendland's C² function, which is 0 from s = 1 on. So the sculpted
/// frame is met to rounding, and a frame farther away than the reach keeps every bit.
#[derive(Debug, Clone, PartialEq)]
pub struct Correction {
    /// The frame of the take that was sculpted.
    frame: usize,
    /// The vertices that move, ascending.
    vertices: Vec<u32>,
    /// S_vᵀ d_v of each of them, multiplied by the region's weight, in mesh units.
    offsets: Vec<[f64; 3]>,
    features: Vec<[f64; 3]>,
    reach: f64,
    /// a over the take's time in seconds.
    amount: Curve,
}

/// A sculpted frame as the files give it.
pub(crate) struct Sculpted<'a> {
    pub frame: usize,
    /// V sculpted positions, in mesh units; `before` has the positions before the sculpting.
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

    /// The number of vertices that the correction moves.
    pub fn vertices(&self) -> usize {
        self.vertices.len()
    }

    /// The largest distance that the correction moves a vertex, in mesh units.
    pub fn largest(&self) -> f64 {
        self.offsets.iter().map(|offset| length(*offset)).fold(0.0, f64::max)
    }

    /// The distance from the sculpted frame, in strain, beyond which the correction does nothing, a ratio.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// Moves a frame's V positions and updates their normals.
    ///
    /// `handles` are the frame's H positions, and `time` is in seconds. `normals` is empty where no normals
    /// are wanted. The result is the largest distance that a vertex moves, in mesh units. Where it is 0,
    /// every bit is as it was.
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

/// The strains of a pose: vector strains for a rig of the learned method, else strain lengths as vectors
/// along x.
fn features(rig: &Rig, handles: &[[f32; 3]]) -> Vec<[f64; 3]> {
    match rig.learned() {
        Some(_) => rig.handles().vector_strains(handles),
        None => rig.handles().strains(handles).into_iter().map(|strain| [strain.into(), 0.0, 0.0]).collect(),
    }
}

/// The distance of two poses at a vertex, from the features that influence the vertex.
///
/// If no feature influences the vertex, the distance is the root mean square over all features.
fn apart(rig: &Rig, vertex: usize, a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let square = |e: usize| {
        let off = vec3::sub(a[e], b[e]);
        vec3::dot(off, off)
    };
    let (mut sum, mut total) = (0.0, 0.0);
    for (e, weight) in rig.influences_of(vertex) {
        sum += weight * square(e);
        total += weight;
    }
    match total > 0.0 {
        true => (sum / total).sqrt(),
        false => ((0..a.len()).map(square).sum::<f64>() / a.len().max(1) as f64).sqrt(),
    }
}

/// The tangent, bitangent and normal of a vertex. Where the vertex has no surface around it, the coordinate
/// axes.
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
