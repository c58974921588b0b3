//! What each vertex listens to (steps 4 and 5 of the learned method): strain edges by the distance along the mesh, and
//! the nearest handles as anchors.
use super::distances::Distances;
use rayon::prelude::*;

/// Handles that a vertex of a driven part has as anchors.
pub(crate) const ANCHORS: usize = 8;

/// The part of a vertex's weights that its anchors have; its strain edges have the rest.
const ANCHORS_SHARE: f64 = 0.1;

/// The influence at which the chapter cuts, and which is taken off all: a weight reaches zero where it would be cut.
const THRESHOLD: f64 = 0.025;

/// The width of an anchor's weight in mean rest lengths, on the surface and around a rigid part.
const WIDTH_ON_SURFACE: f64 = 1.5;
const WIDTH_AROUND_RIGID: f64 = 2.0;

/// α of every vertex.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeInfluences {
    /// V×K indices of strain edges, ascending; K = min(`max_influences`, F).
    pub edges: Vec<u32>,
    /// α, V×K: at least 0, with the sum 1, or all 0 where no strain edge can be reached.
    pub weights: Vec<f64>,
}

/// The K strain edges of smallest `s = g_va + g_vb − g_ab` (ties: the lower edge index), and
/// `α = max(exp(−ln 40 · (s − min s)/gap) − 0.025, 0)` over their sum, with `gap = max(s_(K+1) − s_(1), 0.1 L)`; where a
/// vertex reaches no more than K edges, the last of them stands for the (K+1)-th.
///
/// `mean` is L, the mean rest length, in mesh units.
pub(crate) fn edge_influences(
    distances: &Distances,
    handles: &[u32],
    strain_edges: &[[u32; 2]],
    mean: f64,
    max_influences: usize,
) -> EdgeInfluences {
    let (vertices, k) = (distances.vertices(), max_influences.min(strain_edges.len()));
    let mut edges = vec![0; vertices * k];
    let mut weights = vec![0.0; vertices * k];
    if k == 0 {
        return EdgeInfluences { edges, weights };
    }
    let between: Vec<f64> =
        strain_edges.iter().map(|&[a, b]| distances.get(a, handles[b as usize] as usize)).collect();
    edges.par_chunks_mut(k).zip(weights.par_chunks_mut(k)).enumerate().for_each_init(
        || (vec![0.0; handles.len()], Vec::with_capacity(strain_edges.len())),
        |(to_handle, order), (v, (edges, weights))| {
            distances.to_handles(v, to_handle);
            order.clear();
            let lengths = strain_edges.iter().zip(&between).enumerate();
            let all = lengths.map(|(i, (&[a, b], length))| {
                (to_handle[a as usize] + to_handle[b as usize] - length, i as u32)
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
            // A vertex that reaches fewer edges has some others, of no weight.
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
                edges[i] = edge;
                weights[i] = if sum > 0.0 { alpha(s) / sum } else { 0.0 };
            }
        },
    );
    EdgeInfluences { edges, weights }
}

/// ω: what the linear band of every vertex listens to.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearInfluences {
    /// V×(K + 8): strain edges count from 0, the handles' anchors from F.
    pub features: Vec<u32>,
    /// V×(K + 8), at least 0, with the sum 1 unless a vertex reaches no handle.
    pub weights: Vec<f64>,
    /// K + 8.
    pub per_vertex: usize,
}

impl LinearInfluences {
    /// The anchors alone, V×A handles and their weights, where A is the most that any vertex has; and V×(K + A) gains, of strain
    /// edges before anchors, given those of all features. `strain_edges` is F.
    pub(crate) fn anchors(
        &self,
        strain_edges: u32,
        k: usize,
        gains: &[f64],
    ) -> (Vec<u32>, Vec<f64>, Vec<f64>) {
        let rows = || self.features.chunks(self.per_vertex).zip(self.weights.chunks(self.per_vertex));
        let is_anchor = |feature: u32, weight: f64| feature >= strain_edges && weight > 0.0;
        let count = |(features, weights): (&[u32], &[f64])| {
            features.iter().zip(weights).filter(|(e, w)| is_anchor(**e, **w)).count()
        };
        let a = rows().map(count).max().unwrap_or(0).max(ANCHORS);
        let vertices = self.features.len() / self.per_vertex;
        let (mut anchors, mut nu) = (vec![0; vertices * a], vec![0.0; vertices * a]);
        let mut of_features = vec![0.0; vertices * (k + a)];
        for (v, ((features, weights), gains)) in rows().zip(gains.chunks(self.per_vertex)).enumerate() {
            let all = features.iter().zip(weights).zip(gains);
            let of_vertex = &mut of_features[v * (k + a)..][..k + a];
            // Where there are edges, they are the first K.
            for (to, ((_, _), gain)) in
                of_vertex.iter_mut().zip(all.clone()).take(k).filter(|(_, ((e, _), _))| **e < strain_edges)
            {
                *to = *gain;
            }
            for (i, ((e, w), gain)) in all.filter(|((e, w), _)| is_anchor(**e, **w)).enumerate() {
                anchors[v * a + i] = e - strain_edges;
                nu[v * a + i] = *w;
                of_vertex[k + i] = *gain;
            }
        }
        (anchors, nu, of_features)
    }
}

/// What a vertex of a part without a handle listens to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Listens {
    /// Of a driven part: for itself.
    Itself,
    /// Of a part that follows: as this vertex of the driven surface.
    As(u32),
    /// Of a rigid part: as all of it, by the straight distance from this point, its centroid.
    At([f64; 3]),
    /// Of a part that is to stay where it is.
    Nothing,
}

/// 0.9 α on a vertex's edges, and 0.1 `ν = exp(−(g² − min g²)/(1.5 L)²)` on its [`ANCHORS`] nearest handles, over their
/// sum; a vertex that reaches no edge, and parts without a handle, have anchors alone.
///
/// `listens` is V long; F is `strain_edges`; `mean` is L.
pub(crate) fn linear_influences(
    rest: &[[f64; 3]],
    handles: &[u32],
    distances: &Distances,
    alpha: &EdgeInfluences,
    listens: &[Listens],
    strain_edges: usize,
    mean: f64,
) -> LinearInfluences {
    let vertices = rest.len();
    let k = alpha.edges.len().checked_div(vertices).unwrap_or(0);
    let per_vertex = k + ANCHORS;
    let mut features = vec![strain_edges as u32; vertices * per_vertex];
    let mut weights = vec![0.0; vertices * per_vertex];
    let first_anchor = strain_edges as u32;
    features.par_chunks_mut(per_vertex).zip(weights.par_chunks_mut(per_vertex)).enumerate().for_each_init(
        || Vec::with_capacity(handles.len()),
        |anchors, (v, (features, weights))| {
            let (edges, edge_weights) = (&alpha.edges[v * k..][..k], &alpha.weights[v * k..][..k]);
            let has_edges = listens[v] == Listens::Itself && edge_weights.iter().any(|&w| w > 0.0);
            let (start, share) = if has_edges { (k, ANCHORS_SHARE) } else { (0, 1.0) };
            if has_edges {
                features[..k].copy_from_slice(edges);
                for (to, w) in weights[..k].iter_mut().zip(edge_weights) {
                    *to = (1.0 - ANCHORS_SHARE) * w;
                }
            }
            let straight = |h: u32, from: [f64; 3]| {
                let to = rest[handles[h as usize] as usize];
                (0..3).map(|c| (to[c] - from[c]).powi(2)).sum::<f64>().sqrt()
            };
            let distance = |h: u32| match listens[v] {
                Listens::Nothing => f64::INFINITY,
                Listens::Itself => distances.get(h, v),
                Listens::As(w) => distances.get(h, w as usize),
                Listens::At(centroid) => straight(h, centroid),
            };
            let (room, width) = match listens[v] {
                Listens::Itself | Listens::Nothing => (ANCHORS, WIDTH_ON_SURFACE),
                Listens::As(_) => (per_vertex, WIDTH_ON_SURFACE),
                Listens::At(_) => (per_vertex, WIDTH_AROUND_RIGID),
            };
            nearest(handles.len() as u32, room, distance, anchors);
            let Some(&(least, _)) = anchors.first() else { return };
            anchors.sort_unstable_by_key(|&(_, h)| h);
            let nu = |g: f64| (-(g * g - least * least) / (width * mean).powi(2)).exp();
            let sum: f64 = anchors.iter().map(|&(g, _)| nu(g)).sum();
            for (i, &(g, h)) in anchors.iter().enumerate() {
                features[start + i] = first_anchor + h;
                weights[start + i] = share * nu(g) / sum;
            }
        },
    );
    LinearInfluences { features, weights, per_vertex }
}

/// Up to `count` of `handles` handles at a finite distance, the nearest first (ties: the lower handle), into `found`.
fn nearest(handles: u32, count: usize, distance: impl Fn(u32) -> f64, found: &mut Vec<(f64, u32)>) {
    found.clear();
    found.extend((0..handles).map(|h| (distance(h), h)).filter(|(g, _)| g.is_finite()));
    let nearer = |a: &(f64, u32), b: &(f64, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    if count < found.len() {
        found.select_nth_unstable_by(count, nearer);
        found.truncate(count);
    }
    found.sort_unstable_by(nearer);
}
