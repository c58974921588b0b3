//! The face among the markers of a body: a cluster of its own.
use crate::tracks::seen;
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::Take;
use rhytid_core::numbers::median;

/// The markers of a face are within a box whose diagonal is between these, in metres; a cap may be included.
const FACE: [f64; 2] = [0.05, 0.38];

/// A gap ends a cluster if it is wider than this, in metres, and than so many usual gaps of the cluster.
const GAP: (f64, f64) = (0.08, 3.5);

/// Units in which a file that states none may be, in metres.
const UNITS: [f64; 4] = [1e-3, 1e-2, 1.0, 0.0254];

/// Frames that are sampled.
const SAMPLED: usize = 48;

/// A face has at least so many markers.
const FEWEST: usize = 4;

/// In the right unit, the largest cluster has at least this part of the markers that it has in another one. A
/// wrong unit makes a face of a few markers, or of the whole body.
const UNIT: f64 = 1.0 / 3.0;

/// Clusters with less than this part of the largest one's markers are no face.
const SMALL: f64 = 0.5;

/// The clusters of `columns` that have the size of a face, the largest first. All columns are one cluster if
/// there is none of that size. `metres` are those of the take's unit, if known.
///
/// Clusters are those of single linkage. Two markers are farther apart if their distance changes, because a
/// face moves as a whole.
pub(crate) fn face_clusters(take: &Take, columns: &[usize], metres: Option<f64>) -> Vec<Vec<usize>> {
    let tree = Tree::new(take, columns);
    let mut found = metres.map(|metres| tree.clusters(metres)).unwrap_or_default();
    if found.is_empty() {
        found = tree.likeliest();
    }
    if found.is_empty() {
        return vec![columns.to_vec()];
    }
    found.into_iter().map(|cluster| cluster.columns).collect()
}

/// Markers that have the size of a face.
struct Sized {
    columns: Vec<usize>,
    /// Whether one of the edges between them is a gap beside the others. A face has none.
    has_gap: bool,
}

/// The least spanning tree of some markers.
struct Tree<'a> {
    take: &'a Take,
    frames: Vec<usize>,
    columns: &'a [usize],
    edges: Vec<Edge>,
}

/// Two markers, by their place among the columns, and how far apart they are.
struct Edge {
    ends: [usize; 2],
    length: f64,
}

/// Markers that belong together.
struct Cluster {
    members: Vec<usize>,
    /// The lengths of the edges between them.
    lengths: Vec<f64>,
    /// The box around them in each sampled frame.
    boxes: Vec<[DVec3; 2]>,
}

impl Cluster {
    /// The usual diagonal of the box, in the take's unit.
    fn extent(boxes: &[[DVec3; 2]]) -> f64 {
        let shown = boxes.iter().filter(|[low, high]| low.cmple(*high).all());
        median(&mut shown.map(|[low, high]| low.distance(*high)).collect::<Vec<_>>())
    }

    /// Whether an edge of a length is a gap beside the cluster's own edges.
    fn has_gap(&self, length: f64) -> bool {
        let usual = median(&mut self.lengths.clone());
        !usual.is_nan() && length > GAP.1 * usual
    }
}

impl<'a> Tree<'a> {
    fn new(take: &'a Take, columns: &'a [usize]) -> Self {
        let step = take.frames().div_ceil(SAMPLED).max(1);
        let frames = (0..take.frames()).step_by(step).collect();
        let mut tree = Self { take, frames, columns, edges: Vec::new() };
        // Prim's algorithm: the pairs are too many to be kept.
        let mut nearest: Vec<Option<Edge>> = (0..columns.len()).map(|_| None).collect();
        let mut is_open = vec![true; columns.len()];
        let mut last = 0;
        for _ in 1..columns.len() {
            is_open[last] = false;
            nearest.par_iter_mut().enumerate().filter(|(i, _)| is_open[*i]).for_each(|(i, nearest)| {
                let length = tree.apart(columns[last], columns[i]);
                if nearest.as_ref().is_none_or(|edge| length < edge.length) {
                    *nearest = Some(Edge { ends: [last, i], length });
                }
            });
            let open = (0..columns.len()).filter(|&i| is_open[i]);
            let length = |i: usize| nearest[i].as_ref().map_or(f64::INFINITY, |edge| edge.length);
            let Some(next) = open.min_by(|&a, &b| length(a).total_cmp(&length(b))) else { break };
            tree.edges.extend(nearest[next].take());
            last = next;
        }
        tree.edges.sort_by(|a, b| a.length.total_cmp(&b.length));
        tree
    }

    fn at(&self, frame: usize, column: usize) -> DVec3 {
        DVec3::from_array(self.take.positions[frame * self.take.labels.len() + column])
    }

    /// How far two markers are apart, and how much that changes. Infinite where they are never seen together.
    fn apart(&self, a: usize, b: usize) -> f64 {
        let distance = |f: &usize| self.at(*f, a).distance(self.at(*f, b));
        let mut distances: Vec<f64> = self.frames.iter().map(distance).filter(|d| !d.is_nan()).collect();
        if distances.is_empty() {
            return f64::INFINITY;
        }
        distances.sort_by(f64::total_cmp);
        let part = |part: f64| distances[(part * (distances.len() - 1) as f64).round() as usize];
        part(0.5) + 2.0 * (part(0.9) - part(0.1))
    }

    /// A cluster of one marker.
    fn single(&self, i: usize) -> Cluster {
        let around = |f: &usize| {
            let at = self.at(*f, self.columns[i]);
            if seen(at) { [at, at] } else { [DVec3::INFINITY, DVec3::NEG_INFINITY] }
        };
        Cluster { members: vec![i], lengths: Vec::new(), boxes: self.frames.iter().map(around).collect() }
    }

    /// The clusters in the likeliest unit: the one with the largest face, without a gap if possible.
    fn likeliest(&self) -> Vec<Sized> {
        let size = |clusters: &[Sized]| clusters.first().map_or(0, |first| first.columns.len());
        let of_units = UNITS.map(|metres| self.clusters(metres));
        let most = of_units.iter().map(|clusters| size(clusters)).max().unwrap_or(0);
        let is_whole = |clusters: &[Sized]| {
            clusters.first().is_some_and(|first| !first.has_gap)
                && size(clusters) as f64 >= UNIT * most as f64
        };
        // Of equal ones, the first unit is the likeliest.
        let units = of_units.into_iter().rev();
        units.max_by_key(|clusters| (is_whole(clusters), size(clusters))).unwrap_or_default()
    }

    /// The clusters of the size of a face, the largest first, if one unit is so many metres.
    fn clusters(&self, metres: f64) -> Vec<Sized> {
        let mut of_member: Vec<usize> = (0..self.columns.len()).collect();
        let mut clusters: Vec<Cluster> = (0..self.columns.len()).map(|i| self.single(i)).collect();
        for Edge { ends: [a, b], length } in &self.edges {
            let [a, b] = [of_member[*a], of_member[*b]];
            let (first, second) = (&clusters[a], &clusters[b]);
            if *length * metres > GAP.0 && (first.has_gap(*length) || second.has_gap(*length)) {
                continue;
            }
            let both = |(a, b): (&[DVec3; 2], &[DVec3; 2])| [a[0].min(b[0]), a[1].max(b[1])];
            let boxes: Vec<[DVec3; 2]> = first.boxes.iter().zip(&second.boxes).map(both).collect();
            if Cluster::extent(&boxes) * metres > FACE[1] {
                continue;
            }
            let second = std::mem::replace(
                &mut clusters[b],
                Cluster { members: Vec::new(), lengths: Vec::new(), boxes: Vec::new() },
            );
            second.members.iter().for_each(|&i| of_member[i] = a);
            let first = &mut clusters[a];
            first.members.extend(second.members);
            first.lengths.extend(second.lengths);
            first.lengths.push(*length);
            first.boxes = boxes;
        }
        clusters.retain(|cluster| {
            cluster.members.len() >= FEWEST && Cluster::extent(&cluster.boxes) * metres >= FACE[0]
        });
        let most = clusters.iter().map(|cluster| cluster.members.len()).max().unwrap_or(0);
        let mut found = Vec::new();
        for cluster in clusters.into_iter().filter(|c| c.members.len() as f64 >= SMALL * most as f64) {
            let mut columns: Vec<usize> = cluster.members.iter().map(|&i| self.columns[i]).collect();
            columns.sort_unstable();
            let longest = cluster.lengths.iter().copied().fold(0.0, f64::max);
            found.push(Sized { has_gap: cluster.has_gap(longest), columns });
        }
        found.sort_by(|a, b| b.columns.len().cmp(&a.columns.len()).then(a.columns.cmp(&b.columns)));
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    /// A face of 30 markers on a walking body of 24, with two hands of 10 markers, in the unit of `metres`.
    fn body(metres: f64) -> Take {
        let (frames, mut positions) = (60, Vec::new());
        for f in 0..frames {
            let t = f64::from(f) / 10.0;
            let walk = DVec3::new(0.0, 0.02 * t.sin(), 0.1 * t);
            let head = DQuat::from_rotation_y(0.4 * (1.3 * t).sin());
            let mut of_frame = Vec::new();
            for i in 0..30 {
                let (x, y) = (f64::from(i % 5) - 2.0, f64::from(i / 5) - 2.5);
                let skin = DVec3::new(0.03 * x, 0.032 * y, 0.1 - 0.008 * x * x);
                let talks = if y < -1.0 { 0.01 * (5.0 * t).sin() } else { 0.0 };
                of_frame.push(DVec3::new(0.0, 1.6, 0.0) + head * (skin + DVec3::Y * talks));
            }
            for i in 0..24 {
                // Collar bones, shoulders, chest, hips, knees, ankles.
                let side = if i % 2 == 0 { 1.0 } else { -1.0 };
                let swing = 0.2 * (t + f64::from(i)).sin();
                of_frame.push(DVec3::new(
                    side * (0.06 + 0.01 * f64::from(i)),
                    1.4 - 0.055 * f64::from(i),
                    swing * 0.3,
                ));
            }
            for i in 0..20 {
                let side = if i < 10 { 1.0 } else { -1.0 };
                let curl = 0.02 * (3.0 * t + f64::from(i)).sin();
                let (x, y) = (f64::from(i % 5), f64::from(i % 10 / 5));
                of_frame.push(DVec3::new(
                    side * 0.5,
                    0.9 - 0.03 * y,
                    0.3 + 0.02 * x + side * 0.2 * t.sin() + curl,
                ));
            }
            positions.extend(of_frame.iter().map(|p| ((*p + walk) / metres).to_array()));
        }
        Take {
            labels: (0..74).map(|m| format!("m{m}")).collect(),
            times: (0..frames).map(|f| f64::from(f) / 30.0).collect(),
            positions,
            ..Take::default()
        }
    }

    #[test]
    fn a_face_is_a_cluster_of_its_own_on_a_body() {
        let (face, all): (Vec<usize>, Vec<usize>) = ((0..30).collect(), (0..74).collect());
        for (metres, stated) in [(1e-3, true), (1.0, true), (1e-3, false), (1e-2, false), (1.0, false)] {
            let take = body(metres);
            let clusters = face_clusters(&take, &all, stated.then_some(metres));
            assert_eq!(clusters[0], face, "{metres} {stated}: {clusters:?}");
        }
        // The face alone is whole, in any unit that the file states.
        for metres in [1e-3, 1.0, 25.4] {
            assert_eq!(face_clusters(&body(1e-3), &face, Some(metres)), std::slice::from_ref(&face));
        }
        assert_eq!(face_clusters(&body(1e-3).slice(0..1), &face[..4], None), [&face[..4]]);
    }
}
