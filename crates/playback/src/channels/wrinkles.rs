//! Wrinkle activation: how strongly the wrinkles of each example are switched on (`docs/wrinkles.md`).

use rayon::prelude::*;
use rhytid_core::{Error, InputErrorKind, Result, Rig, Table};
use rhytid_formats::export::WrinkleGroups;
use rhytid_kernels::vec3;
use rhytid_kernels::vector_differences::limited;
use std::sync::Arc;

/// μ where the rig has none, as with the chapter's method.
const RIDGE: f64 = 1e-3;

/// Where an example starts to count and where it counts in full.
///
/// Both are parts of the example's largest strain of the skin. Below the first, the example is not switched
/// on. From the second on, it counts in full.
const COUNTS: [f64; 2] = [0.02, 0.1];

/// The quantile of an example's strains over the vertices that stands for its largest strain. A few slivers
/// with extreme strains are left out.
const MOST: f64 = 0.995;

/// How strongly the wrinkles of examples, or of groups of examples, are switched on at each vertex.
///
/// The wrinkles of vertex v are `Σ_p a_p d_p`, where d_p are the vertex's wrinkles in example p and
/// `a = (G + μ tr G/P · I)⁻¹ k`. There `G_pq = ‖p‖ + ‖q‖ − ‖p − q‖` and `k_p = ‖f‖ + ‖p‖ − ‖f − p‖`. The
/// norms are distances of the strains that influence the vertex, as in the kernel that the wrinkles are
/// learned with. So a_p is 1 where the frame is example p, and 0 at rest and at another example.
///
/// Where an example hardly strains the skin, a_p is unreliable and changes from vertex to vertex. So a_p is
/// multiplied by a smooth step from 0 to 1 between the two bounds of [`COUNTS`]. The activation of a channel
/// is this product, or its sum over a group, clamped to 0..1. A vertex that no strain edge drives has no
/// wrinkles and no activations.
pub(crate) struct WrinkleActivations {
    /// The features of the norms: vector strains, or strains as vectors along x.
    features: Features,
    /// The features of each example, features × 3, in the rig's order.
    examples: Arc<[Vec<[f64; 3]>]>,
    /// Where each vertex's entries of `influences` begin. An entry is a feature that influences the vertex,
    /// with its weight.
    begins: Vec<u32>,
    influences: Vec<(u32, f32)>,
    /// V × P: ‖p‖.
    lengths: Table<f64>,
    /// V × P: how much an example counts, from 0 to 1.
    counts: Table<f64>,
    /// V × P(P + 1)/2: the Cholesky factor of G + μ tr G/P · I, row by row; 0 where there are no wrinkles.
    factors: Table<f64>,
    /// The channel of each example, if it is in one.
    channels: Vec<Option<usize>>,
    /// Channels × V.
    activations: Vec<Vec<f32>>,
}

/// The strains that distances are computed from.
#[derive(Clone, Copy, PartialEq)]
enum Features {
    Vectors,
    Lengths,
}

/// The names of the channels: the groups, or all examples where there is no group.
///
/// # Errors
/// [`Error::Input`] if the rig has no examples, or if a group names an unknown example or an example of
/// another group.
pub(crate) fn names(rig: &Rig, groups: &WrinkleGroups) -> Result<Vec<String>> {
    if rig.examples().names.is_empty() {
        return Err(Error::rig_lacks("the rig has no examples, whose wrinkles could be switched on"));
    }
    if groups.is_empty() {
        return Ok(rig.examples().names.clone());
    }
    let mut seen: Vec<&String> = Vec::new();
    for group in &groups.0 {
        for example in &group.examples {
            if !rig.examples().names.contains(example) {
                return Err(Error::input(format!(
                    "the wrinkle group {group}: the rig has no example “{example}”; it has {}",
                    rig.examples().names.join(", ")
                ))
                .of_kind(InputErrorKind::UnknownName { name: example.clone() }));
            }
            if seen.contains(&example) {
                return Err(Error::conflict(format!(
                    "the wrinkle group {group}: “{example}” is in a group already, expected each example once"
                )));
            }
            seen.push(example);
        }
    }
    Ok(groups.0.iter().map(|group| group.name.clone()).collect())
}

impl Features {
    /// The features of a pose of H handle positions.
    fn at_pose(self, rig: &Rig, pose: &[[f32; 3]]) -> Vec<[f64; 3]> {
        match self {
            Self::Lengths => {
                rig.handles().strains(pose).into_iter().map(|strain| [strain.into(), 0.0, 0.0]).collect()
            }
            Self::Vectors => {
                // The device follows them to the same length.
                let vectors = rig.handles().vector_strains(pose).into_iter().zip(rig.feature_limits());
                vectors.map(|(d, limit)| limited(d, limit.into())).collect()
            }
        }
    }

    /// The features that influence a vertex, with their weights.
    fn influences_of(self, rig: &Rig, v: usize) -> Vec<(u32, f32)> {
        let of_edges = || {
            rig.influences().at(v).map(|(edge, weight)| (edge.0, weight)).filter(|(_, weight)| *weight > 0.0)
        };
        match self {
            _ if of_edges().next().is_none() => Vec::new(),
            Self::Lengths => of_edges().collect(),
            Self::Vectors => {
                let all = rig.influences_of(v).map(|(feature, weight)| (feature as u32, weight as f32));
                all.filter(|(_, weight)| *weight > 0.0).collect()
            }
        }
    }
}

impl WrinkleActivations {
    /// # Errors
    /// As [`names`].
    pub(crate) fn new(rig: &Rig, groups: &WrinkleGroups) -> Result<Self> {
        let names = names(rig, groups)?;
        let channel = |example: &String| match groups.is_empty() {
            true => names.iter().position(|name| name == example),
            false => groups.0.iter().position(|group| group.examples.contains(example)),
        };
        let features = if rig.vector_wrinkles() { Features::Vectors } else { Features::Lengths };
        let examples: Arc<[Vec<[f64; 3]>]> =
            rig.examples().handles.rows().map(|pose| features.at_pose(rig, pose)).collect();
        let (mut begins, mut influences) = (vec![0], Vec::new());
        for v in 0..rig.vertices() {
            influences.extend(features.influences_of(rig, v));
            begins.push(influences.len() as u32);
        }
        let count = examples.len();
        let mut activations = Self {
            features,
            begins,
            influences,
            lengths: Table::filled(rig.vertices(), count, 0.0),
            counts: Table::without_columns(rig.vertices()),
            factors: Table::filled(rig.vertices(), count * (count + 1) / 2, 0.0),
            channels: rig.examples().names.iter().map(channel).collect(),
            activations: vec![vec![0.0; rig.vertices()]; names.len()],
            examples,
        };
        let ridge = rig.learned().map_or(RIDGE, |learned| learned.wrinkle_ridge);
        activations.factorise(ridge);
        activations.count();
        Ok(activations)
    }

    /// Finds how much each example counts at each vertex.
    fn count(&mut self) {
        let examples = self.examples.len();
        let most = |p: usize| {
            let mut of_example: Vec<f64> = self.lengths.rows().map(|lengths| lengths[p]).collect();
            of_example.sort_by(f64::total_cmp);
            let at = (MOST * of_example.len() as f64) as usize;
            of_example.get(at).or(of_example.last()).copied().unwrap_or(0.0)
        };
        let most: Vec<f64> = (0..examples).map(most).collect();
        let count = |(length, most): (&f64, &f64)| {
            let part = if *most > 0.0 { length / most } else { 0.0 };
            let s = ((part - COUNTS[0]) / (COUNTS[1] - COUNTS[0])).clamp(0.0, 1.0);
            s * s * (3.0 - 2.0 * s)
        };
        let counts = self.lengths.rows().flat_map(|lengths| lengths.iter().zip(&most).map(count));
        self.counts = Table::new(self.lengths.height(), examples, counts.collect());
    }

    fn of_vertex(&self, v: usize) -> &[(u32, f32)] {
        &self.influences[self.begins[v] as usize..self.begins[v + 1] as usize]
    }

    fn factorise(&mut self, ridge: f64) {
        let count = self.examples.len();
        let (mut lengths, mut factors) = (self.lengths.clone(), self.factors.clone());
        let rest = vec![[0.0; 3]; self.examples[0].len()];
        let rows = lengths.par_rows_mut().zip(factors.par_rows_mut());
        rows.enumerate().for_each(|(v, (lengths, factor))| {
            let influences = self.of_vertex(v);
            for (length, example) in lengths.iter_mut().zip(&*self.examples) {
                *length = apart(influences, example, &rest);
            }
            let trace: f64 = 2.0 * lengths.iter().sum::<f64>();
            if trace <= 0.0 {
                return;
            }
            let mut at = 0;
            for p in 0..count {
                for q in 0..=p {
                    let between = apart(influences, &self.examples[p], &self.examples[q]);
                    let diagonal = if p == q { ridge * trace / count as f64 } else { 0.0 };
                    factor[at] = lengths[p] + lengths[q] - between + diagonal;
                    at += 1;
                }
            }
            cholesky(factor, count);
        });
        (self.lengths, self.factors) = (lengths, factors);
    }

    /// a of each vertex, V × P, in a frame with these H handle positions.
    fn solve(&self, rig: &Rig, pose: &[[f32; 3]]) -> Vec<Vec<f64>> {
        let frame = self.features.at_pose(rig, pose);
        let rest = vec![[0.0; 3]; frame.len()];
        let count = self.examples.len();
        let of_vertex = |v: usize| {
            let mut a = vec![0.0; count];
            let factor = self.factors.row(v);
            if factor[0] > 0.0 {
                let (influences, lengths) = (self.of_vertex(v), self.lengths.row(v));
                let length = apart(influences, &frame, &rest);
                for ((a, example), of_example) in a.iter_mut().zip(&*self.examples).zip(lengths) {
                    *a = length + of_example - apart(influences, &frame, example);
                }
                solve(factor, &mut a);
            }
            a
        };
        (0..rig.vertices()).into_par_iter().map(of_vertex).collect()
    }

    /// The activations of a frame with these H handle positions.
    pub(crate) fn measure(&mut self, rig: &Rig, pose: &[[f32; 3]]) {
        let (all, count) = (self.solve(rig, pose), self.examples.len());
        for (channel, activations) in self.activations.iter_mut().enumerate() {
            let examples: Vec<usize> = (0..count).filter(|p| self.channels[*p] == Some(channel)).collect();
            let of_vertices = activations.iter_mut().zip(&all).zip(self.counts.rows());
            for ((activation, a), counts) in of_vertices {
                let sum: f64 = examples.iter().map(|&p| counts[p] * a[p]).sum();
                *activation = sum.clamp(0.0, 1.0) as f32;
            }
        }
    }

    /// V activations of each channel, from 0 to 1.
    pub(crate) fn activations(&self) -> impl Iterator<Item = &[f32]> {
        self.activations.iter().map(Vec::as_slice)
    }
}

/// The distance of two poses, from the features that influence a vertex.
fn apart(influences: &[(u32, f32)], a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let square = |&(feature, weight): &(u32, f32)| {
        let off = vec3::sub(a[feature as usize], b[feature as usize]);
        f64::from(weight) * vec3::dot(off, off)
    };
    influences.iter().map(square).sum::<f64>().sqrt()
}

/// The Cholesky factor, in place of a matrix whose lower triangle is stored row by row. All 0 where the
/// matrix is not positive definite.
fn cholesky(matrix: &mut [f64], n: usize) {
    let row = |i: usize| i * (i + 1) / 2;
    for i in 0..n {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| matrix[row(i) + k] * matrix[row(j) + k]).sum();
            let x = matrix[row(i) + j] - dot;
            matrix[row(i) + j] = match i == j {
                true if x > 0.0 => x.sqrt(),
                true => return matrix.fill(0.0),
                false => x / matrix[row(j) + j],
            };
        }
    }
}

/// Solves `L Lᵀ x = b`, in place of b.
fn solve(factor: &[f64], x: &mut [f64]) {
    let row = |i: usize| i * (i + 1) / 2;
    let n = x.len();
    for i in 0..n {
        let dot: f64 = (0..i).map(|k| factor[row(i) + k] * x[k]).sum();
        x[i] = (x[i] - dot) / factor[row(i) + i];
    }
    for i in (0..n).rev() {
        let dot: f64 = (i + 1..n).map(|k| factor[row(k) + i] * x[k]).sum();
        x[i] = (x[i] - dot) / factor[row(i) + i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::NoProgress;

    /// The sum of all examples' wrinkles, each times its activation, is the vertex's wrinkles. `explain`
    /// gives the wrinkles to compare with and shares no code with this module.
    #[test]
    fn wrinkles_are_the_examples_times_their_activations() {
        let face = rhytid_demo::face(1_500);
        let rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let wrinkles = WrinkleActivations::new(&rig, &WrinkleGroups::default()).unwrap();
        let handles = rig.handles().len();
        let poses: Vec<&[[f32; 3]]> = rig.examples().handles.rows().collect();
        let take = rhytid_demo::performance(&face).handle_positions(&rig.handles().labels).unwrap();
        let mut checked = 0;
        for frame in [20, 45, 70] {
            let pose = &take.as_chunks::<3>().0[frame * handles..][..handles];
            let all = wrinkles.solve(&rig, pose);
            for (v, a) in all.iter().enumerate().step_by(7) {
                let wrinkle = |pose| rig.explain(v, pose).unwrap().wrinkle();
                let found = wrinkle(pose);
                // The ridge makes examples smaller: (G + μI) w = d, and the rig reproduces G w.
                let ridge = rig.learned().unwrap().wrinkle_ridge;
                let trace: f64 = 2.0 * wrinkles.lengths.row(v).iter().sum::<f64>();
                let row = &rig.fine_scale().rbf_weights.row(v)[1..];
                let mut expected = [0.0; 3];
                for ((pose, a), w) in poses.iter().zip(a).zip(row) {
                    let back = wrinkle(pose);
                    for c in 0..3 {
                        expected[c] += a * (back[c] - ridge * trace / poses.len() as f64 * f64::from(w[c]));
                    }
                }
                let size = vec3::dot(found, found).sqrt();
                let off = vec3::sub(found, expected);
                assert!(vec3::dot(off, off).sqrt() < 1e-3 * size + 1e-6, "{v}: {found:?}, {expected:?}");
                checked += usize::from(size > 1e-4);
            }
        }
        assert!(checked > 20, "{checked}");
    }

    #[test]
    fn an_example_switches_itself_on_and_rest_switches_all_off() {
        let face = rhytid_demo::face(1_500);
        let rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let names = &rig.examples().names;
        let groups: WrinkleGroups =
            format!("both={}+{};one={}", names[0], names[1], names[2]).parse().unwrap();
        let mut each = WrinkleActivations::new(&rig, &WrinkleGroups::default()).unwrap();
        let mut grouped = WrinkleActivations::new(&rig, &groups).unwrap();
        let largest = |of: &[f32]| of.iter().copied().fold(0.0, f32::max);
        for (p, pose) in rig.examples().handles.rows().enumerate() {
            each.measure(&rig, pose);
            grouped.measure(&rig, pose);
            let found: Vec<&[f32]> = each.activations().collect();
            assert!(largest(found[p]) > 0.99, "{p}: {}", largest(found[p]));
            // Where the example moves the skin most, nothing else is on.
            let most = (0..rig.vertices()).max_by(|a, b| {
                let length = |v: &usize| each.lengths.row(*v)[p];
                length(a).total_cmp(&length(b))
            });
            let v = most.unwrap();
            for (q, of) in found.iter().enumerate() {
                let expected = if p == q { 1.0 } else { 0.0 };
                assert!((of[v] - expected).abs() < 0.05, "{p} {q}: {}", of[v]);
            }
            let found: Vec<f32> = grouped.activations().map(|of| of[v]).collect();
            let expected = [f32::from(u8::from(p < 2)), f32::from(u8::from(p == 2))];
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.05), "{p}: {found:?}");
        }
        let rest: Vec<[f32; 3]> = rig.handles().rest.clone();
        each.measure(&rig, &rest);
        assert!(each.activations().all(|of| largest(of) < 1e-5));
    }

    #[test]
    fn groups_that_the_rig_does_not_have_are_refused() {
        let face = rhytid_demo::face(500);
        let rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let first = rig.examples().names[0].clone();
        for (groups, says) in [
            ("a=nothing".to_owned(), "no example “nothing”"),
            (format!("a={first};b={first}"), "in a group already"),
        ] {
            let error = names(&rig, &groups.parse().unwrap()).unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        }
        let face = rhytid_core::Face { examples: Vec::new(), ..face };
        let rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        assert!(names(&rig, &WrinkleGroups::default()).unwrap_err().to_string().contains("no examples"));
    }
}
