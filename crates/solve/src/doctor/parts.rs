//! Identical parts of the neutral, such as two eyeballs or teeth, that an example has in another order.
use super::finding::{Finding, Severity};
use super::words::first_few;
use glam::DVec3;
use rhytid_core::{Example, Mesh, VertexId};
use rhytid_geometry::{components, triangulate};
use std::collections::{BTreeMap, BTreeSet};

/// Two parts are exchanged if each is where the other one was, up to this part of their distance. An
/// expression does not bring two parts past each other.
const THERE: f64 = 0.2;

/// Parts nearer to each other than this part of the mesh's size are not compared: exchanged or not, they look
/// the same.
const APART: f64 = 1e-4;

/// The most parts of one size that are compared with each other. More are hairs or lashes.
const MOST_ALIKE: usize = 400;

/// The least vertices of a part that is compared.
const LEAST: usize = 3;

/// The parts of a mesh that could be taken for each other.
pub(super) struct Parts {
    /// Lists of parts with the same number of vertices. A part is its vertices, ascending.
    alike: Vec<Vec<Vec<usize>>>,
}

impl Parts {
    pub(super) fn new(neutral: &Mesh) -> Self {
        let (part_of, count) = components(neutral.positions.len(), triangulate(neutral).iter());
        let mut parts = vec![Vec::new(); count];
        for (v, part) in part_of.into_iter().enumerate() {
            parts[part as usize].push(v);
        }
        let mut by_size: BTreeMap<usize, Vec<Vec<usize>>> = BTreeMap::new();
        for part in parts.into_iter().filter(|part| part.len() >= LEAST) {
            by_size.entry(part.len()).or_default().push(part);
        }
        let is_compared = |parts: &Vec<Vec<usize>>| (2..=MOST_ALIKE).contains(&parts.len());
        Self { alike: by_size.into_values().filter(is_compared).collect() }
    }

    /// Pairs of parts that an example has in each other's place. `rest` are the neutral's vertices, and
    /// `diagonal` is their size.
    pub(super) fn exchanged(&self, example: &Example, rest: &[DVec3], diagonal: f64) -> Option<Finding> {
        let at = |v: usize| DVec3::from_array(example.positions[v]);
        let mut pairs = Vec::new();
        for parts in &self.alike {
            for (i, a) in parts.iter().enumerate() {
                for b in &parts[i + 1..] {
                    if let Some(common) = exchanged(a, b, &at, rest, APART * diagonal) {
                        pairs.push(Pair { first: a[0], second: b[0], common });
                    }
                }
            }
        }
        // Of parts in a row, the outer two exchanged look like the first two exchanged and moved. The pair
        // that moves less is meant.
        pairs.sort_by(|a, b| a.common.total_cmp(&b.common));
        let mut taken = BTreeSet::new();
        pairs.retain(|pair| {
            let is_free = !taken.contains(&pair.first) && !taken.contains(&pair.second);
            if is_free {
                taken.extend([pair.first, pair.second]);
            }
            is_free
        });
        pairs.sort_by_key(|pair| pair.first);
        let words = |pair: &Pair| format!("the parts of vertices {} and {}", pair.first, pair.second);
        let found: Vec<String> = pairs.iter().map(words).collect();
        (!found.is_empty()).then(|| {
            let message = format!(
                "example {} has parts in each other's place, as if they were exported in another order: {}; export \
                 the example with its parts in the neutral's order",
                example.name,
                first_few(&found)
            );
            let vertices = pairs.iter().flat_map(|pair| [pair.first, pair.second]);
            Finding::new(Severity::Warning, "parts-exchanged", message).at(vertices.map(VertexId::from_index))
        })
    }
}

/// Two parts in each other's place.
struct Pair {
    /// The lowest vertex of each.
    first: usize,
    second: usize,
    /// How far both move in common.
    common: f64,
}

/// The distance that two parts move in common, as with the jaw, if `a` is then where `b` is at rest and the
/// other way round. `None` if they are not. Parts nearer than `least` never are.
fn exchanged(
    a: &[usize],
    b: &[usize],
    at: &impl Fn(usize) -> DVec3,
    rest: &[DVec3],
    least: f64,
) -> Option<f64> {
    let n = a.len() as f64;
    let mean =
        |place: &dyn Fn(usize) -> DVec3, part: &[usize]| part.iter().map(|&v| place(v)).sum::<DVec3>() / n;
    let at_rest = |v: usize| rest[v];
    let [rest_a, rest_b] = [a, b].map(|part| mean(&at_rest, part));
    let [now_a, now_b] = [a, b].map(|part| mean(at, part));
    let common = 0.5 * (now_a + now_b - rest_a - rest_b);
    // The middles alone decide for nearly all.
    let between = rest_a.distance(rest_b);
    let is_there = |now: DVec3, other: DVec3| (now - common).distance(other) <= THERE * between;
    if between <= least || !is_there(now_a, rest_b) || !is_there(now_b, rest_a) {
        return None;
    }
    let mut off = 0.0;
    for (&v, &w) in a.iter().zip(b) {
        off += (at(v) - common).distance(rest[w]) + (at(w) - common).distance(rest[v]);
    }
    (off / (2.0 * n) <= THERE * between).then(|| common.length())
}
