//! The influences on each vertex (steps 4 and 5 of the learned method): strain edges by the distance along
//! the mesh, and the nearest handles as anchors.
use super::distances::Distances;
use rayon::prelude::*;
use rhytid_core::{HandleId, HandleSet, StrainEdgeId, Table, VertexId};
use rhytid_kernels::vec3;

/// The number of anchors of a vertex of a driven part.
pub(crate) const ANCHORS: usize = 8;

/// The part of a vertex's weights that its anchors have. Its strain edges have the rest.
const ANCHORS_SHARE: f64 = 0.1;

/// The influence at which the chapter cuts. It is subtracted from all weights, so a weight reaches zero where
/// it would be cut.
const THRESHOLD: f64 = 0.025;

/// The width of an anchor's weight in mean rest lengths, on the surface and around a part.
const WIDTH_ON_SURFACE: f64 = 1.5;
const WIDTH_AROUND_PART: f64 = 2.0;

/// α of every vertex.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct EdgeInfluences {
    /// V×K strain edges, ascending; K = min(`max_influences`, F).
    pub edges: Table<StrainEdgeId>,
    /// α, V×K: at least 0, with the sum 1, or all 0 where no strain edge can be reached.
    pub weights: Table<f64>,
}

/// The K strain edges that influence each vertex, and their weights α.
///
/// They are the edges of smallest `s = g_va + g_vb − g_ab` (ties: the lower edge index). The weights are `α =
/// max(exp(−ln 40 · (s − min s)/gap) − 0.025, 0)` over their sum, with `gap = max(s_(K+1) − s_(1), 0.1 L)`.
/// If a vertex reaches no more than K edges, the last of them stands for the (K+1)-th.
///
/// `mean` is L, the mean rest length, in mesh units.
pub(crate) fn edge_influences(
    distances: &Distances,
    handles: &HandleSet<f64>,
    mean: f64,
    max_influences: usize,
) -> EdgeInfluences {
    let strain_edges = &handles.strain_edges;
    let (vertices, k) = (distances.vertices(), max_influences.min(strain_edges.len()));
    let mut edges = Table::filled(vertices, k, StrainEdgeId(0));
    let mut weights = Table::filled(vertices, k, 0.0);
    if k == 0 {
        return EdgeInfluences { edges, weights };
    }
    edges.par_rows_mut().zip(weights.par_rows_mut()).enumerate().for_each_init(
        || (vec![0.0; handles.len()], Vec::with_capacity(strain_edges.len())),
        |(to_handle, order), (v, (edges, weights))| {
            distances.to_handles(v, to_handle);
            order.clear();
            let lengths = strain_edges.iter().zip(distances.of_edges()).enumerate();
            let all = lengths.map(|(i, (&[a, b], length))| {
                (to_handle[a.index()] + to_handle[b.index()] - length, i as u32)
            });
            order.extend(all.filter(|(s, _)| s.is_finite()));
            let nearer = |a: &(f64, u32), b: &(f64, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
            let last = match order.len().checked_sub(1) {
                Some(last) => order.select_nth_unstable_by(k.min(last), nearer).1.0,
                None => 0.0,
            };
            order.truncate(k);
            let least = order.iter().fold(f64::INFINITY, |least, &(s, _)| least.min(s));
            let gap = (last - least).max(0.1 * mean);
            // A vertex that reaches fewer edges gets other edges with the weight 0.
            let others = (0..strain_edges.len() as u32).filter(|e| order.iter().all(|(_, edge)| edge != e));
            let others: Vec<_> = others.take(k - order.len()).map(|edge| (f64::INFINITY, edge)).collect();
            order.extend(others);
            order.sort_unstable_by_key(|&(_, edge)| edge);
            let alpha = |s: f64| match s.is_finite() {
                true => ((THRESHOLD.ln() * (s - least) / gap).exp() - THRESHOLD).max(0.0),
                false => 0.0,
            };
            let sum: f64 = order.iter().map(|&(s, _)| alpha(s)).sum();
            for (i, &(s, edge)) in order.iter().enumerate() {
                edges[i] = StrainEdgeId(edge);
                weights[i] = if sum > 0.0 { alpha(s) / sum } else { 0.0 };
            }
        },
    );
    EdgeInfluences { edges, weights }
}

/// ω: the influences on the linear band of every vertex.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LinearInfluences {
    /// V×(K + 8): strain edges count from 0, the handles' anchors from F.
    pub features: Table<u32>,
    /// V×(K + 8), at least 0, with the sum 1 unless a vertex reaches no handle.
    pub weights: Table<f64>,
}

/// The learned method's arrays that concern anchors.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Anchors {
    /// V×A, where A is the largest number of anchors of a vertex.
    pub(crate) handles: Table<HandleId>,
    /// ν, V×A.
    pub(crate) weights: Table<f64>,
    /// V×(K + A), of strain edges before anchors.
    pub(crate) gains: Table<f64>,
}

impl EdgeInfluences {
    /// Gives vertex `to` the influences of vertex `from`.
    pub(crate) fn copy(&mut self, from: VertexId, to: VertexId) {
        self.edges.copy_row(from.index(), to.index());
        self.weights.copy_row(from.index(), to.index());
    }
}

impl LinearInfluences {
    /// Gives vertex `to` the influences of vertex `from`.
    pub(crate) fn copy(&mut self, from: VertexId, to: VertexId) {
        self.features.copy_row(from.index(), to.index());
        self.weights.copy_row(from.index(), to.index());
    }

    /// The influences on `vertices`.
    pub(crate) fn of(&self, vertices: &[VertexId]) -> Self {
        let rows = || vertices.iter().map(|v| v.index());
        let features = rows().flat_map(|v| self.features.row(v)).copied().collect();
        let weights = rows().flat_map(|v| self.weights.row(v)).copied().collect();
        let (height, columns) = (vertices.len(), self.features.columns());
        Self {
            features: Table::new(height, columns, features),
            weights: Table::new(height, columns, weights),
        }
    }

    /// Gives `vertices` these influences, in the order of the vertices.
    pub(crate) fn set(&mut self, vertices: &[VertexId], to: &Self) {
        for (v, (features, weights)) in vertices.iter().zip(to.features.rows().zip(to.weights.rows())) {
            self.features.row_mut(v.index()).copy_from_slice(features);
            self.weights.row_mut(v.index()).copy_from_slice(weights);
        }
    }

    /// Gives each of `vertices` the influences of [`InfluenceSource::At`] a centroid. `mean` is L.
    pub(crate) fn around(
        &mut self,
        handles: &HandleSet<f64>,
        centroid: [f64; 3],
        vertices: &[VertexId],
        mean: f64,
    ) {
        let mut anchors = Vec::new();
        let distance = |h: HandleId| straight(handles, h, centroid);
        nearest(handles.len(), self.features.columns(), distance, &mut anchors);
        let weights = anchor_weights(&mut anchors, WIDTH_AROUND_PART * mean);
        let first_anchor = handles.strain_edges.len() as u32;
        for v in vertices {
            self.weights.row_mut(v.index()).fill(0.0);
            let row = self.features.row_mut(v.index()).iter_mut().zip(self.weights.row_mut(v.index()));
            for ((feature, weight), (&(_, h), nu)) in row.zip(anchors.iter().zip(&weights)) {
                (*feature, *weight) = (first_anchor + h.0, *nu);
            }
        }
    }

    /// The features that influence vertex `v`, with their ω.
    pub(crate) fn at(&self, v: usize) -> impl Iterator<Item = (u32, f64)> + Clone {
        self.features.row(v).iter().copied().zip(self.weights.row(v).iter().copied())
    }

    /// The anchors alone, with their gains out of those of all features. `strain_edges` is F.
    pub(crate) fn anchors(&self, strain_edges: u32, k: usize, gains: &Table<f64>) -> Anchors {
        let rows = || self.features.rows().zip(self.weights.rows());
        let is_anchor = |feature: u32, weight: f64| feature >= strain_edges && weight > 0.0;
        let count = |(features, weights): (&[u32], &[f64])| {
            features.iter().zip(weights).filter(|(e, w)| is_anchor(**e, **w)).count()
        };
        let a = rows().map(count).max().unwrap_or(0).max(ANCHORS);
        let vertices = self.features.height();
        let mut anchors = Anchors {
            handles: Table::filled(vertices, a, HandleId(0)),
            weights: Table::filled(vertices, a, 0.0),
            gains: Table::filled(vertices, k + a, 0.0),
        };
        for (v, ((features, weights), gains)) in rows().zip(gains.rows()).enumerate() {
            let all = features.iter().zip(weights).zip(gains);
            let of_vertex = anchors.gains.row_mut(v);
            // Where there are edges, they are the first K.
            for (to, ((_, _), gain)) in
                of_vertex.iter_mut().zip(all.clone()).take(k).filter(|(_, ((e, _), _))| **e < strain_edges)
            {
                *to = *gain;
            }
            for (i, ((e, w), gain)) in all.filter(|((e, w), _)| is_anchor(**e, **w)).enumerate() {
                anchors.handles.row_mut(v)[i] = HandleId(e - strain_edges);
                anchors.weights.row_mut(v)[i] = *w;
                of_vertex[k + i] = *gain;
            }
        }
        anchors
    }
}

/// The source of a vertex's influences.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum InfluenceSource {
    /// A vertex of a driven part has its own influences.
    Itself,
    /// A vertex of a part that follows has the influences of this vertex of the driven surface.
    As(VertexId),
    /// All vertices of a rigid part have the same influences, by the straight distance from its centroid,
    /// which is this point.
    At([f64; 3]),
    /// A vertex of a part that stays has no influences.
    Nothing,
}

/// ω of every vertex.
///
/// It is 0.9 α on a vertex's edges, and 0.1 `ν = exp(−(g² − min g²)/(1.5 L)²)`, over the sum of ν, on its
/// [`ANCHORS`] nearest handles. A vertex that reaches no edge, and a part without a handle, have anchors
/// alone.
///
/// `sources` is V long; `mean` is L.
pub(crate) fn linear_influences(
    handles: &HandleSet<f64>,
    distances: &Distances,
    alpha: &EdgeInfluences,
    sources: &[InfluenceSource],
    mean: f64,
) -> LinearInfluences {
    let (vertices, k) = (sources.len(), alpha.edges.columns());
    let per_vertex = k + ANCHORS;
    let first_anchor = handles.strain_edges.len() as u32;
    let mut features = Table::filled(vertices, per_vertex, first_anchor);
    let mut weights = Table::filled(vertices, per_vertex, 0.0);
    features.par_rows_mut().zip(weights.par_rows_mut()).enumerate().for_each_init(
        || Vec::with_capacity(handles.len()),
        |anchors, (v, (features, weights))| {
            let (edges, edge_weights) = (alpha.edges.row(v), alpha.weights.row(v));
            let has_edges = sources[v] == InfluenceSource::Itself && edge_weights.iter().any(|&w| w > 0.0);
            let (start, share) = if has_edges { (k, ANCHORS_SHARE) } else { (0, 1.0) };
            if has_edges {
                features.iter_mut().zip(edges).for_each(|(to, edge)| *to = edge.0);
                for (to, w) in weights[..k].iter_mut().zip(edge_weights) {
                    *to = (1.0 - ANCHORS_SHARE) * w;
                }
            }
            let distance = |h: HandleId| match sources[v] {
                InfluenceSource::Nothing => f64::INFINITY,
                InfluenceSource::Itself => distances.get(h, v),
                InfluenceSource::As(w) => distances.get(h, w.index()),
                InfluenceSource::At(centroid) => straight(handles, h, centroid),
            };
            let (room, width) = match sources[v] {
                InfluenceSource::Itself | InfluenceSource::Nothing => (ANCHORS, WIDTH_ON_SURFACE),
                InfluenceSource::As(_) => (per_vertex, WIDTH_ON_SURFACE),
                InfluenceSource::At(_) => (per_vertex, WIDTH_AROUND_PART),
            };
            nearest(handles.len(), room, distance, anchors);
            let of_anchors = anchor_weights(anchors, width * mean);
            for (i, (&(_, h), nu)) in anchors.iter().zip(of_anchors).enumerate() {
                features[start + i] = first_anchor + h.0;
                weights[start + i] = share * nu;
            }
        },
    );
    LinearInfluences { features, weights }
}

/// The weights ν of `anchors`, with the sum 1. The nearest anchor is the first at first; after this, they are
/// in the order of the handles.
fn anchor_weights(anchors: &mut [(f64, HandleId)], width: f64) -> Vec<f64> {
    let Some(&(least, _)) = anchors.first() else { return Vec::new() };
    anchors.sort_unstable_by_key(|&(_, h)| h);
    let nu = |g: f64| (-(g * g - least * least) / width.powi(2)).exp();
    let sum: f64 = anchors.iter().map(|&(g, _)| nu(g)).sum();
    anchors.iter().map(|&(g, _)| nu(g) / sum).collect()
}

/// The straight distance from a point to a handle.
fn straight(handles: &HandleSet<f64>, h: HandleId, from: [f64; 3]) -> f64 {
    vec3::length(vec3::sub(handles.rest[h.index()], from))
}

/// Writes up to `count` of `handles` handles at a finite distance into `found`, the nearest first (ties: the
/// lower handle).
fn nearest(
    handles: usize,
    count: usize,
    distance: impl Fn(HandleId) -> f64,
    found: &mut Vec<(f64, HandleId)>,
) {
    found.clear();
    let all = (0..handles).map(HandleId::from_index);
    found.extend(all.map(|h| (distance(h), h)).filter(|(g, _)| g.is_finite()));
    let nearer = |a: &(f64, HandleId), b: &(f64, HandleId)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    if count < found.len() {
        found.select_nth_unstable_by(count, nearer);
        found.truncate(count);
    }
    found.sort_unstable_by(nearer);
}
