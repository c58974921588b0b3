//! The confidence of a frame: the variance that is left of the linear band, read as a Gaussian process.
use super::choice;
use super::linear_band::{LinearSettings, VertexSystem};
use super::vector_strains::VectorStrains;
use crate::driven::DrivenComponents;
use crate::vectors::widest;
use rayon::prelude::*;
use rhytid_core::{Error, HandleId, Learned, Result, Rig, SurfacePoint, VertexId};
use rhytid_kernels::Real;

/// The relative σ above which a pose is far from the examples.
///
/// It is relative to the σ of an expression without a scan: the larger of that at the vertex and that over
/// the whole face.
pub const EXTRAPOLATION: f64 = 2.0;

/// The vector strains of a rig's poses.
pub(crate) struct HandlePoses {
    strain_edges: Vec<[HandleId; 2]>,
    rest: Vec<[f64; 3]>,
    rest_lengths: Vec<f64>,
    mean: f64,
}

impl HandlePoses {
    pub(crate) fn from_rig<T: Real>(rig: &Rig<T>) -> Self {
        let handles = rig.handles();
        let mut rest_lengths = handles.feature_lengths();
        let mean = rest_lengths.last().copied().unwrap_or(1.0);
        rest_lengths.truncate(handles.strain_edges.len());
        let rest = handles.rest.iter().map(|x| x.map(T::widen)).collect();
        Self { strain_edges: handles.strain_edges.clone(), rest, rest_lengths, mean }
    }

    /// The strains of poses × H positions.
    pub(crate) fn strains<T: Real>(&self, positions: &[[T; 3]]) -> VectorStrains {
        let displacements: Vec<Vec<[f64; 3]>> = (positions.chunks_exact(self.rest.len()))
            .map(|pose| {
                pose.iter().zip(&self.rest).map(|(x, r)| [0, 1, 2].map(|c| x[c].widen() - r[c])).collect()
            })
            .collect();
        VectorStrains::new(&displacements, &self.strain_edges, &self.rest_lengths, self.mean)
    }
}

/// The features that influence a vertex of a rig of the learned method, with their weights ω, all above 0.
pub(crate) fn influences<T: Real>(rig: &Rig<T>, v: usize) -> Vec<(u32, f64)> {
    rig.influences_of(v).filter(|(_, w)| *w > 0.0).map(|(e, w)| (e as u32, w)).collect()
}

/// The number of vertices that stand for the whole face where a vertex has learned nothing.
const SAMPLES: usize = 300;

/// The errors that a rig of the learned method expects, at some of its vertices (`docs/method.md`, the
/// learned method).
///
/// The linear band is the mean of a Gaussian process over the poses u of the handles. The variance that is
/// left of this process is `σ_v² = s_v² tr(κ(u, u) − kᵀ A k)`. σ_v is the RMS distance of the vertex from its
/// place in a scan of the pose. It is 0 at rest, and grows with the distance from the span of the examples.
///
/// s_v means nothing where no example moves the features of a vertex by more than the noise of markers. There
/// the whole face's `Σ s_v²/Σ τ_v` takes its place: `r/(1 + r)` of it is added, with r = n_v/τ_v.
pub struct Confidence {
    poses: HandlePoses,
    examples: VectorStrains,
    share: f64,
    vertices: Vec<VertexId>,
    of_vertices: Vec<OfVertex>,
    /// The numbers of the whole face.
    face: Typical,
}

/// Typical numbers of vertices.
#[derive(Debug, Clone, Copy)]
struct Typical {
    /// `Σ s_v²/Σ τ_v`.
    variance: f64,
    /// σ² of a left-out example.
    left_out: f64,
}

struct OfVertex {
    /// ω where it is above 0.
    influences: Vec<(u32, f64)>,
    /// s_v².
    variance: f64,
    tau: f64,
    /// L of the system's matrix, the lower triangle column by column; empty where nothing is learned.
    factor: Vec<f64>,
    left_out: f64,
    /// r/(1 + r), from 0 to 1: 1 where the examples say nothing.
    unknown: f64,
}

impl Confidence {
    /// The confidence at `vertices` of a rig.
    ///
    /// # Errors
    /// [`Error::Input`] if the rig is not of the learned method, or if it has no example. [`Error::Internal`]
    /// if a system has no solution in floating point.
    pub fn new<T: Real>(rig: &Rig<T>, vertices: &[VertexId]) -> Result<Self> {
        let Some(learned) = rig.learned().filter(|_| !rig.examples().is_empty()) else {
            return Err(Error::rig_lacks(
                "the rig cannot say how uncertain it is: this needs the learned method and an example; solve \
                 it again with method = \"learned\"",
            ));
        };
        let poses = HandlePoses::from_rig(rig);
        let examples = poses.strains(rig.examples().handles.as_slice());
        let of = |vertices: &[VertexId]| of_vertices(rig, learned, &examples, vertices);
        let typical = of(&sample(rig, SAMPLES))?;
        let sum = |number: fn(&OfVertex) -> f64| typical.iter().map(number).sum::<f64>();
        let moved = sum(|v| v.tau);
        let face = Typical {
            variance: if moved > 0.0 { sum(|v| v.variance) / moved } else { 0.0 },
            left_out: sum(|v| v.left_out) / typical.len().max(1) as f64,
        };
        let of_vertices = of(vertices)?;
        Ok(Self { poses, share: learned.share, vertices: vertices.to_vec(), of_vertices, face, examples })
    }

    /// The confidence at up to `count` vertices that stand for the parts with a handle, by their areas.
    ///
    /// # Errors
    /// As [`Confidence::new`].
    pub fn sampled<T: Real>(rig: &Rig<T>, count: usize) -> Result<Self> {
        Self::new(rig, &sample(rig, count))
    }

    /// The vertices, S of them.
    pub fn vertices(&self) -> &[VertexId] {
        &self.vertices
    }

    /// σ² of a left-out example, the mean over the examples, S in mesh units squared.
    ///
    /// It is the scale for [`Confidence::variances`]. A pose that is as far from the examples as they are
    /// from each other has this σ².
    pub fn left_out(&self) -> impl Iterator<Item = f64> {
        self.of_vertices.iter().map(|of_vertex| of_vertex.left_out + of_vertex.unknown * self.face.left_out)
    }

    /// The mean of [`Confidence::left_out`] over the whole face.
    ///
    /// Where the examples predict each other well, a left-out example has a small σ². A pose with more than
    /// that is no reason to worry.
    pub fn typical_left_out(&self) -> f64 {
        self.face.left_out
    }

    /// `κ_v(u, u)`, frames × S: the squared vector strains that influence a vertex, for frames × H handle
    /// positions.
    ///
    /// σ is linear, so σ does not show frames that go in the direction of the examples but farther. These
    /// numbers do.
    pub fn squared_strains<T: Real>(&self, handle_positions: &[[T; 3]]) -> Vec<f64> {
        let of_frame = |positions: &[[T; 3]]| {
            let frame = self.poses.strains(positions);
            self.of_vertices.iter().map(|of_vertex| of_vertex.squared_strain(&frame)).collect::<Vec<f64>>()
        };
        handle_positions.par_chunks(self.poses.rest.len()).flat_map_iter(of_frame).collect()
    }

    /// σ², frames × S in mesh units squared, given frames × H positions of the handles in the rig's order.
    pub fn variances<T: Real>(&self, handle_positions: &[[T; 3]]) -> Vec<f64> {
        let handles = self.poses.rest.len();
        let mut variances = vec![0.0; handle_positions.len() / handles * self.vertices.len()];
        variances
            .par_chunks_mut(self.vertices.len().max(1))
            .zip(handle_positions.par_chunks(handles))
            .for_each_init(Vec::new, |scratch, (variances, positions)| {
                let frame = self.poses.strains(positions);
                widest(
                    #[inline(always)]
                    || {
                        for (variance, of_vertex) in variances.iter_mut().zip(&self.of_vertices) {
                            *variance = of_vertex.variance(self, &frame, scratch);
                        }
                    },
                );
            });
        variances
    }
}

/// The data of `vertices`.
fn of_vertices<T: Real>(
    rig: &Rig<T>,
    learned: &Learned<T>,
    examples: &VectorStrains,
    vertices: &[VertexId],
) -> Result<Vec<OfVertex>> {
    let settings = LinearSettings {
        share: learned.share,
        ridge: learned.ridge,
        marker_noise: learned.marker_noise,
        reach: learned.reach,
    };
    let count = examples.examples();
    let of_vertex = |system: &mut VertexSystem, &v: &VertexId| {
        let influences = influences(rig, v.index());
        let (features, omega): (Vec<u32>, Vec<f64>) = influences.iter().copied().unzip();
        system.assemble(examples, &features, &omega);
        let (tau, variance) = (system.tau(), learned.variances[v.index()].widen());
        let is_learned = variance > 0.0 && system.factorize(settings)?;
        let (factor, left_out) = match is_learned {
            true => (system.factor(), variance * system.left_out().iter().sum::<f64>() / count as f64),
            false => (Vec::new(), 0.0),
        };
        let noise = settings.marker_noise.powi(2) * system.noise();
        // A handle is where its marker is.
        let unknown = match tau > 0.0 {
            _ if rig.handles().points.contains(&v.into()) => 0.0,
            true => noise / (noise + tau),
            false => 1.0,
        };
        Ok(OfVertex { influences, variance, tau, factor, left_out, unknown })
    };
    vertices.par_iter().map_init(|| VertexSystem::new(count), of_vertex).collect()
}

impl OfVertex {
    /// κ(u, u).
    fn squared_strain(&self, frame: &VectorStrains) -> f64 {
        let square = |d: &[f64]| d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        self.influences.iter().map(|&(e, w)| w * square(frame.feature(e))).sum()
    }

    /// `s_v² tr(κ(u, u) − kᵀ A k)`, the trace over the axes, plus the addition where the examples say little.
    #[inline(always)]
    fn variance(&self, of: &Confidence, frame: &VectorStrains, k: &mut Vec<[f64; 3]>) -> f64 {
        let (share, examples) = (of.share, &of.examples);
        let own = (1.0 + 2.0 * share) * self.squared_strain(frame);
        let unknown = self.unknown * of.face.variance * own;
        if self.factor.is_empty() {
            return unknown;
        }
        let size = 3 * examples.examples();
        k.clear();
        k.resize(size, [0.0; 3]);
        for &(e, w) in &self.influences {
            let d = frame.feature(e);
            let (dx, dy, dz) = (d[0], d[1], d[2]);
            // (1 − s) K1, and s κ on its diagonal.
            for (k, p) in k.as_chunks_mut::<3>().0.iter_mut().zip(examples.feature(e).as_chunks::<3>().0) {
                let common = share * w * (p[0] * dx + p[1] * dy + p[2] * dz);
                for (c, row) in k.iter_mut().enumerate() {
                    let moved = (1.0 - share) * w * p[c];
                    row[0] += moved * dx;
                    row[1] += moved * dy;
                    row[2] += moved * dz;
                    row[c] += common;
                }
            }
        }
        // |L⁻¹ k|², the part of the variance that the examples explain.
        let mut told = 0.0;
        let mut column = &self.factor[..];
        for j in 0..size {
            let (of_column, rest) = column.split_at(size - j);
            let y = k[j].map(|k| k / of_column[0]);
            told += y[0] * y[0] + y[1] * y[1] + y[2] * y[2];
            for (k, l) in k[j + 1..].iter_mut().zip(&of_column[1..]) {
                k[0] -= l * y[0];
                k[1] -= l * y[1];
                k[2] -= l * y[2];
            }
            column = rest;
        }
        self.variance * (own / self.tau - told / (self.tau * self.tau)).max(0.0) + unknown
    }
}

/// At most `count` vertices that stand for equal areas, ascending. They are in parts with a handle, and none
/// is a handle.
pub(crate) fn sample<T: Real>(rig: &Rig<T>, count: usize) -> Vec<VertexId> {
    let (surface, handles) = (rig.surface(), &rig.handles().points);
    let rest: Vec<[f64; 3]> = surface.rest.iter().map(|x| x.map(T::widen)).collect();
    let driven = DrivenComponents::new(&rest, &surface.triangles, handles).driven;
    let mut area = vec![0.0; rest.len()];
    for triangle in &surface.triangles {
        let [a, b, c] = triangle.map(|v| glam::DVec3::from_array(rest[v as usize]));
        let of_triangle = (b - a).cross(c - a).length();
        triangle.iter().for_each(|&v| area[v as usize] += of_triangle);
    }
    area.iter_mut().zip(&driven).filter(|(_, driven)| !**driven).for_each(|(area, _)| *area = 0.0);
    handles.iter().filter_map(SurfacePoint::vertex).for_each(|v| area[v.index()] = 0.0);
    let mut vertices: Vec<VertexId> =
        choice::sample(&area, count).into_iter().map(VertexId::from_index).collect();
    vertices.dedup();
    vertices
}
