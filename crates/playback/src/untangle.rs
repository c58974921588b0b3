//! Turns triangles back that the fine detail turns over and the shell does not (`docs/method.md` on triangles
//! that are turned over).

use crate::local_normals;
use rayon::prelude::*;
use rhytid_core::{Learned, Rig, Table, VertexId};
use rhytid_kernels::normals::VertexTriangles;
use rhytid_kernels::{Real, vec3};
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// The least part of a triangle that is left: its area seen along its rest normal, relative to its area at
/// rest.
const LEAST: f64 = 0.02;

/// The part that is left of a triangle may be below its bound by this much.
const TOLERANCE: f64 = 0.002;

/// Where the shell is below [`LEAST`], the bound is below it by this multiple of the shell's distance. So
/// there is no step, and a triangle that the shell turns over by more than a little has no effective bound.
const STEEPNESS: f64 = 10.0;

/// A frame counts as an example at a triangle within this part of the example's squared distance from rest.
/// In the tests' takes, no frame with a turned triangle is nearer than 0.2.
const OWN: f64 = 0.04;

/// The most rounds. Triangles that are still turned over after them stay so. Frames of the tests take 3
/// rounds at the median, and 267 at most.
const ROUNDS: usize = 300;

/// The number of triangles in a block that is tested at once.
const BLOCK: usize = 2048;

/// Turns triangles back with the least movement of their vertices.
///
/// The part that is left of a triangle with the corners a, b, c is `q = ((b − a) × (c − a)) · n / n·n`. Here
/// n is the same cross product at rest. q is 1 at rest, and below 0 where the triangle looks the other way.
///
/// In a rig of the learned method each triangle's q is at least [`LEAST`], with two exceptions. The bound is
/// lower where the shell's own q is below it. There is no bound where the frame is an example at that place,
/// which keeps its own shape.
///
/// A triangle below its bound takes the shortest step to the bound. Its corners share the step in proportion
/// to their derivatives. Handles do not move, nor do vertices without a row of the basis, which stay or are
/// rigid. Triangles take steps one after the other, in rounds, until none is below its bound. A step grows
/// from 0 as a triangle crosses its bound, so a take's frames stay as smooth as they were.
pub(crate) struct Untangle<'a> {
    rig: &'a Rig,
    learned: &'a Learned,
    vertex_triangles: Arc<VertexTriangles>,
    /// The triangles that can be turned over and back. They have an area at rest, and a corner that may move.
    triangles: Vec<Triangle>,
    /// Which of `triangles` are at each vertex that is the lowest of its point.
    around: VertexTriangles,
    /// V: whether the vertex may move.
    is_free: Vec<bool>,
    /// D_pe, (F + H)×P.
    example_vectors: Table<[f32; 3]>,
}

#[derive(Clone, Copy)]
struct Triangle {
    corners: [u32; 3],
    /// n / n·n.
    rest_normal: [f32; 3],
}

impl<'a> Untangle<'a> {
    /// `None` for a rig without learned detail.
    pub(crate) fn new(rig: &'a Rig, vertex_triangles: Arc<VertexTriangles>) -> Option<Self> {
        let learned = rig.learned().filter(|_| Self::is_for(rig))?;
        let mut is_free: Vec<bool> = rig.basis().rows().map(|row| row.iter().any(|b| *b != 0.0)).collect();
        rig.handles().held().for_each(|v| is_free[v.index()] = false);
        // Points are known by their lowest vertices.
        let joined = rig.surface().joined_triangles();
        let triangle = |&corners: &[u32; 3]| {
            let n = normal(corners.map(|v| rig.surface().rest[v as usize].map(f64::from)));
            let square = vec3::dot(n, n);
            let rest_normal = n.map(|x| (x / square) as f32);
            let can_turn =
                rest_normal.iter().all(|x| x.is_finite()) && corners.iter().any(|&v| is_free[v as usize]);
            can_turn.then_some(Triangle { corners, rest_normal })
        };
        let triangles: Vec<Triangle> = joined.iter().filter_map(triangle).collect();
        let corners: Vec<[u32; 3]> = triangles.iter().map(|triangle| triangle.corners).collect();
        let by_example = rig.example_vectors();
        let (features, examples) = (by_example.columns(), by_example.height());
        let of_feature = |e: usize| by_example.rows().map(move |example| example[e]);
        let by_feature = (0..features).flat_map(of_feature).collect();
        Some(Self {
            rig,
            learned,
            vertex_triangles,
            around: VertexTriangles::new(rig.vertices(), &corners),
            triangles,
            is_free,
            example_vectors: Table::new(features, examples, by_feature),
        })
    }

    /// Whether the rig has learned detail.
    pub(crate) fn is_for(rig: &Rig) -> bool {
        rig.learned().is_some() && !rig.examples().names.is_empty()
    }

    /// Moves a frame's V positions so that no triangle is turned over, and updates its normals.
    ///
    /// `handles` are the frame's H positions. `normals` is empty where no normals are wanted. Away from
    /// turned triangles every bit stays.
    pub(crate) fn frame(&self, handles: &[[f32; 3]], positions: &mut [[f32; 3]], normals: &mut [[f32; 3]]) {
        self.turn(self.turned(positions), handles, positions, normals);
    }

    /// Does the same as [`Untangle::frame`], but begins with the turned triangles at the vertices that
    /// `begin` (V) marks. Triangles that turn over on the way are included.
    pub(crate) fn frame_at(
        &self,
        begin: &[bool],
        handles: &[[f32; 3]],
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
    ) {
        let begin = (0..).zip(begin).filter(|(_, begin)| **begin).map(|(v, _)| v);
        let mut turned = self.at(begin);
        turned.retain(|t| is_turned(&self.triangles[*t as usize], positions));
        self.turn(turned, handles, positions, normals);
    }

    fn turn(
        &self,
        turned: Vec<u32>,
        handles: &[[f32; 3]],
        positions: &mut [[f32; 3]],
        normals: &mut [[f32; 3]],
    ) {
        if turned.is_empty() {
            return;
        }
        let moved = self.turn_back(handles, positions, turned);
        moved.iter().for_each(|(&v, x)| positions[v as usize] = x.map(|x| x as f32));
        for (v, first) in self.rig.surface().copies().filter(|(_, first)| moved.contains_key(&first.0)) {
            positions[v.index()] = positions[first.index()];
        }
        local_normals::update(self.rig, &self.vertex_triangles, moved.keys().copied(), positions, normals);
    }

    /// The triangles of which less than [`LEAST`] is left, as indices into [`Untangle::triangles`],
    /// ascending.
    fn turned(&self, positions: &[[f32; 3]]) -> Vec<u32> {
        let is_turned = |triangle: &Triangle| is_turned(triangle, positions);
        // Most blocks have no turned triangle, and a block is tested without an early exit.
        let in_block = |(block, triangles): (usize, &[Triangle])| {
            let turned = triangles.iter().fold(false, |any, triangle| any | is_turned(triangle));
            let numbered = (block * BLOCK..).zip(if turned { triangles } else { &[] });
            numbered.filter(|(_, triangle)| is_turned(triangle)).map(|(t, _)| t as u32).collect::<Vec<_>>()
        };
        self.triangles.par_chunks(BLOCK).enumerate().flat_map_iter(in_block).collect()
    }

    /// The new positions of the vertices that have to move.
    ///
    /// `open` are some of the triangles that are turned over, which are turned back.
    fn turn_back(
        &self,
        handles: &[[f32; 3]],
        positions: &[[f32; 3]],
        mut open: Vec<u32>,
    ) -> FxHashMap<u32, [f64; 3]> {
        let frame = Frame::new(self.rig, self.learned, &self.example_vectors, handles);
        let mut corners_seen = FxHashMap::default();
        let mut bounds = FxHashMap::default();
        let mut moved: FxHashMap<u32, [f64; 3]> = FxHashMap::default();
        for _ in 0..ROUNDS {
            let mut stepped = Vec::new();
            for t in open {
                let Triangle { corners, rest_normal, .. } = self.triangles[t as usize];
                let rest = rest_normal.map(f64::from);
                let before = |v: u32| positions[v as usize].map(f64::from);
                let at = corners.map(|v| moved.get(&v).copied().unwrap_or_else(|| before(v)));
                let left = vec3::dot(normal(at), rest);
                if left >= LEAST - TOLERANCE {
                    continue;
                }
                let bound = *bounds.entry(t).or_insert_with(|| {
                    let seen = corners.map(|v| *corners_seen.entry(v).or_insert_with(|| frame.corner(v)));
                    bound(seen, rest, vec3::dot(normal(corners.map(before)), rest))
                });
                if left >= bound - TOLERANCE {
                    continue;
                }
                // The derivative of the part that is left, by each corner.
                let opposite = [1, 2, 0].map(|i| vec3::sub(at[(i + 1) % 3], at[i]));
                let slopes = opposite.map(|edge| vec3::cross(rest, edge));
                let free = || (0..3).filter(|&i| self.is_free[corners[i] as usize]);
                let square: f64 = free().map(|i| vec3::dot(slopes[i], slopes[i])).sum();
                let step = (bound - left) / square;
                if !step.is_finite() {
                    continue;
                }
                for i in free() {
                    moved.insert(corners[i], [0, 1, 2].map(|c| at[i][c] + step * slopes[i][c]));
                    stepped.push(corners[i]);
                }
            }
            open = self.at(stepped.into_iter());
            if open.is_empty() {
                break;
            }
        }
        moved
    }

    /// The triangles at any of these vertices, as indices into [`Untangle::triangles`], ascending.
    fn at(&self, vertices: impl Iterator<Item = u32>) -> Vec<u32> {
        let mut around: Vec<u32> = vertices.flat_map(|v| self.around.at(v as usize)).copied().collect();
        around.sort_unstable();
        around.dedup();
        around
    }
}

/// The handles of a frame, from which bounds are computed.
struct Frame<'a> {
    rig: &'a Rig,
    learned: &'a Learned,
    /// u, 1×H in mesh units. Where the handles turn, the input of the kernel `large_scale`, 4×H.
    motions: Table<[f64; 3]>,
    /// The vertex that the handles turn about.
    center: Option<VertexId>,
    /// D, F + H.
    vectors: Vec<[f64; 3]>,
    /// ‖D_e − D_pe‖² and ‖D_pe‖², (F + H)×P.
    squares: Table<[f64; 2]>,
}

impl<'a> Frame<'a> {
    fn new(
        rig: &'a Rig,
        learned: &'a Learned,
        example_vectors: &Table<[f32; 3]>,
        handles: &[[f32; 3]],
    ) -> Self {
        let (motions, center) = match rig.handles().rotations {
            true => {
                let motions = rig.handles().motions(handles);
                (motions.vectors.into_iter().map(|x| x.map(f64::from)).collect(), motions.center)
            }
            false => (rig.handles().displacements(handles), None),
        };
        let of_frame = motions.len() / handles.len();
        let motions = Table::new(of_frame, handles.len(), motions);
        let vectors = rig.handles().vector_strains(handles);
        let squares = |(d, of_examples): (&[f64; 3], &[[f32; 3]])| {
            let square = |d: [f64; 3]| vec3::dot(d, d);
            let of_example = |of_example: &[f32; 3]| {
                let of_example = of_example.map(f64::from);
                [square(vec3::sub(*d, of_example)), square(of_example)]
            };
            of_examples.iter().map(of_example).collect::<Vec<_>>()
        };
        let (features, examples) = (example_vectors.height(), example_vectors.columns());
        let squares = vectors.iter().zip(example_vectors.rows()).flat_map(squares).collect();
        Self { rig, learned, motions, center, squares: Table::new(features, examples, squares), vectors }
    }

    fn corner(&self, v: u32) -> Corner {
        Corner { shell: self.shell(v as usize), nearest: self.nearest(v as usize) }
    }

    /// The position of a vertex in the shell, in mesh units.
    fn shell(&self, v: usize) -> [f64; 3] {
        let rest = self.rig.surface().rest[v].map(f64::from);
        let row = self.rig.basis().row(v);
        let from_center =
            self.center.map(|c| vec3::sub(rest, self.rig.surface().rest[c.index()].map(f64::from)));
        let scales = std::iter::once(1.0).chain(from_center.into_iter().flatten());
        let mut x = rest;
        let mut add = |weight: f64, moved: &[f64; 3]| (0..3).for_each(|c| x[c] += weight * moved[c]);
        for (scale, of_handles) in scales.zip(self.motions.rows()) {
            row.iter().zip(of_handles).for_each(|(b, u)| add(scale * f64::from(*b), u));
        }
        // The basis contains ΔB, which is subtracted here.
        let gains = self.learned.feature_gains.row(v);
        self.rig.influences_of(v).zip(gains).for_each(|((e, _), g)| add(-f64::from(*g), &self.vectors[e]));
        x
    }

    /// The squared distance to the nearest example, relative to that example's from rest.
    ///
    /// Distances are of the features that influence the vertex.
    fn nearest(&self, v: usize) -> f64 {
        let mut sums = vec![[0.0; 2]; self.squares.columns()];
        self.rig.influences_of(v).for_each(|(e, omega)| {
            for (sum, squares) in sums.iter_mut().zip(self.squares.row(e)) {
                sum[0] += omega * squares[0];
                sum[1] += omega * squares[1];
            }
        });
        let relative = |[apart, size]: [f64; 2]| if size > 0.0 { apart / size } else { f64::INFINITY };
        sums.into_iter().map(relative).fold(f64::INFINITY, f64::min)
    }
}

/// What the bounds of a frame's triangles depend on at one of their corners.
#[derive(Clone, Copy)]
struct Corner {
    /// Its position in the shell, in mesh units.
    shell: [f64; 3],
    /// The squared distance to the nearest example, relative to that example's from rest.
    nearest: f64,
}

/// The bound of a triangle of which the part `before` is left. `rest` is its rest normal.
fn bound(corners: [Corner; 3], rest: [f64; 3], before: f64) -> f64 {
    let of_shell = vec3::dot(normal(corners.map(|corner| corner.shell)), rest);
    let bound = LEAST - STEEPNESS * (LEAST - of_shell).max(0.0);
    if before >= bound {
        return bound;
    }
    let nearest = corners.iter().map(|corner| corner.nearest).fold(OWN, f64::min) / OWN;
    // From 0 to 1 without a kink.
    before + nearest * nearest * (3.0 - 2.0 * nearest) * (bound - before)
}

#[inline(always)]
fn is_turned(triangle: &Triangle, positions: &[[f32; 3]]) -> bool {
    // Written without `map`: where `map` is not inlined, it is called for each triangle, which takes twice as
    // long.
    let [a, b, c] = triangle.corners;
    let n = normal([positions[a as usize], positions[b as usize], positions[c as usize]]);
    vec3::dot(n, triangle.rest_normal) < LEAST as f32
}

/// (b − a) × (c − a).
#[inline(always)]
fn normal<T: Real>([a, b, c]: [[T; 3]; 3]) -> [T; 3] {
    vec3::cross(vec3::sub(b, a), vec3::sub(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_conformance::evaluate;
    use rhytid_core::{LearnedSettings, Method, NoProgress};
    use rhytid_kernels::normals;
    use rhytid_test_support::split::{SplitFace, split};

    fn untangle(rig: &Rig) -> Untangle<'_> {
        let triangles = rig.surface().vertex_triangles();
        Untangle::new(rig, Arc::new(triangles)).unwrap()
    }
    use std::collections::BTreeSet;

    fn rig(share: Option<f64>) -> Rig {
        let mut face = rhytid_demo::face(1_000);
        face.settings.method = Method::Learned(LearnedSettings { share, ..LearnedSettings::default() });
        rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap()
    }

    fn handles_at_rest(rig: &Rig) -> Vec<f32> {
        rig.handles().rest.iter().flatten().copied().collect()
    }

    /// The part that is left of every triangle.
    fn left(rig: &Rig, positions: &[[f32; 3]]) -> Vec<f64> {
        let of =
            |positions: &[[f32; 3]], t: &[u32; 3]| normal(t.map(|v| positions[v as usize].map(f64::from)));
        let of_triangle = |t| {
            let rest = of(&rig.surface().rest, t);
            vec3::dot(of(positions, t), rest) / vec3::dot(rest, rest)
        };
        rig.surface().triangles.iter().map(of_triangle).collect()
    }

    fn apart(a: &[[f32; 3]], b: &[[f32; 3]]) -> f32 {
        a.iter().zip(b).map(|(a, b)| vec3::length(vec3::sub(*a, *b))).fold(0.0, f32::max)
    }

    /// The rest pose with one vertex moved towards a neighbour, by this multiple of their distance.
    fn tangled(rig: &Rig, v: u32, times: f32) -> Vec<[f32; 3]> {
        let t = rig.surface().triangles.iter().find(|t| t.contains(&v)).unwrap();
        let neighbour = *t.iter().find(|w| **w != v).unwrap();
        let mut positions = rig.surface().rest.clone();
        let (from, to) = (rig.surface().rest[v as usize], rig.surface().rest[neighbour as usize]);
        positions[v as usize] = [0, 1, 2].map(|c| from[c] + times * (to[c] - from[c]));
        positions
    }

    /// The vertices that may move, and whose neighbours all may move.
    fn amid_free_ones(untangle: &Untangle<'_>) -> Vec<u32> {
        let around = |v: usize| {
            untangle.vertex_triangles.at(v).iter().flat_map(|&t| untangle.rig.surface().triangles[t as usize])
        };
        let is_free = |v: &u32| around(*v as usize).all(|w| untangle.is_free[w as usize]);
        (0..untangle.rig.vertices() as u32).filter(is_free).collect()
    }

    #[test]
    fn what_is_turned_over_is_turned_back_and_little_else_moves() {
        let rig = rig(None);
        let handles = handles_at_rest(&rig);
        let untangle = untangle(&rig);
        let all_normals = |positions: &[[f32; 3]]| -> Vec<[f32; 3]> {
            let triangles = rig.surface().vertex_triangles();
            (0..rig.vertices())
                .map(|v| normals::vertex_normal(positions, &rig.surface().triangles, triangles.at(v)))
                .collect()
        };
        let mut seen = 0;
        for v in amid_free_ones(&untangle).into_iter().step_by(37) {
            let mut last: Option<Vec<[f32; 3]>> = None;
            for step in 0..31 {
                let before = tangled(&rig, v, 0.05 * step as f32);
                let (mut after, mut normals) = (before.clone(), all_normals(&before));
                untangle.frame(handles.as_chunks().0, &mut after, &mut normals);
                let turned = left(&rig, &before).iter().filter(|left| **left < 0.0).count();
                seen += turned;
                assert!(
                    left(&rig, &after).iter().all(|left| *left > 0.0),
                    "vertex {v}, step {step}, {turned}"
                );
                assert_eq!(normals, all_normals(&after));
                let is_near = |w: usize| {
                    let way = vec3::length(vec3::sub(rig.surface().rest[w], rig.surface().rest[v as usize]));
                    way < 4.0 * apart(&before, &rig.surface().rest).max(0.01)
                };
                for (w, (after, before)) in after.iter().zip(&before).enumerate() {
                    let stays = rig.handles().held().any(|v| v.index() == w)
                        || !is_near(w)
                        || turned == 0 && step < 10;
                    assert!(!stays || after == before, "vertex {v}, step {step}: {w}");
                }
                // The output changes as smoothly as the input.
                if let Some(last) = last {
                    let came = apart(&before, &tangled(&rig, v, 0.05 * (step - 1) as f32));
                    assert!(
                        apart(&after, &last) < 2.0 * came,
                        "vertex {v}, step {step}: {} of {came}",
                        apart(&after, &last)
                    );
                }
                last = Some(after);
            }
        }
        assert!(seen > 100, "{seen}");
    }

    #[test]
    fn turning_back_can_begin_at_some_vertices() {
        let rig = rig(None);
        let untangle = untangle(&rig);
        let handles = handles_at_rest(&rig);
        for v in amid_free_ones(&untangle).into_iter().step_by(97) {
            let before = tangled(&rig, v, 1.5);
            let (mut expected, mut found) = (before.clone(), before.clone());
            let mut begin = vec![false; rig.vertices()];
            untangle.frame_at(&begin, handles.as_chunks().0, &mut found, &mut []);
            assert_eq!(found, before, "vertex {v}");
            begin[v as usize] = true;
            untangle.frame_at(&begin, handles.as_chunks().0, &mut found, &mut []);
            untangle.frame(handles.as_chunks().0, &mut expected, &mut []);
            assert!(apart(&before, &expected) > 0.0, "vertex {v}");
            assert_eq!(found, expected, "vertex {v}");
        }
    }

    #[test]
    fn examples_keep_their_own_shape_and_only_they() {
        let rig = rig(None);
        let untangle = untangle(&rig);
        let rest = handles_at_rest(&rig);
        // The vertex that the example moves most.
        let example = evaluate(&rig, rig.examples().handles.row(0)).positions;
        let moved = |v: &u32| vec3::length(vec3::sub(example[*v as usize], rig.surface().rest[*v as usize]));
        let v = amid_free_ones(&untangle).into_iter().max_by(|a, b| moved(a).total_cmp(&moved(b))).unwrap();
        let positions = tangled(&rig, v, 1.5);
        let moved = |part: f32| {
            let example = rig.examples().handles.row(0).as_flattened();
            let handles: Vec<f32> = rest.iter().zip(example).map(|(r, x)| r + part * (x - r)).collect();
            let mut after = positions.clone();
            untangle.frame(handles.as_chunks().0, &mut after, &mut []);
            apart(&after, &positions)
        };
        assert_eq!(moved(1.0), 0.0);
        let parts = [0.95, 0.9, 0.85, 0.7, 0.5, 0.0].map(moved);
        assert!(parts[0] > 0.0 && parts.is_sorted(), "{parts:?}");
        assert!(parts[0] < 0.5 * parts[4], "{parts:?}");
    }

    /// Triangles that the shell turns over stay so. The shell's positions are right with any linear band in
    /// the basis.
    #[test]
    fn the_shell_is_what_it_is_by_itself() {
        for share in [None, Some(0.2)] {
            let rig = rig(share);
            let untangle = untangle(&rig);
            let mut handles: Vec<[f32; 3]> = rig.handles().rest.clone();
            // Two handles swap their places.
            let [a, b] = rig.handles().strain_edges[0].map(rhytid_core::HandleId::index);
            handles.swap(a, b);
            let shell = evaluate(&rig.clone().shell().unwrap(), &handles).positions;
            let frame = Frame::new(&rig, untangle.learned, &untangle.example_vectors, &handles);
            let found: Vec<[f32; 3]> =
                (0..rig.vertices()).map(|v| frame.shell(v).map(|x| x as f32)).collect();
            assert!(
                apart(&found, &shell) < 1e-4 * apart(&shell, &rig.surface().rest),
                "{}",
                apart(&found, &shell)
            );
            let turned: BTreeSet<u32> = untangle.turned(&shell).into_iter().collect();
            assert!(!turned.is_empty());
            let moved = untangle.turn_back(&handles, &shell, turned.into_iter().collect());
            assert!(moved.is_empty(), "{moved:?}");
        }
    }

    #[test]
    fn a_split_face_is_turned_back_as_the_whole_one_is() {
        let mut face = rhytid_demo::face(1_000);
        face.neutral.positions.iter_mut().flatten().for_each(|x| *x = f64::from(*x as f32));
        let whole = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let SplitFace { face, of_vertex } = split(&face, |face, _| face);
        let rig = rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap();
        let [untangle_whole, untangle_split] = [&whole, &rig].map(untangle);
        let handles = handles_at_rest(&whole);
        let each = |positions: &[[f32; 3]]| -> Vec<[f32; 3]> {
            of_vertex.iter().map(|&v| positions[v as usize]).collect()
        };
        for v in amid_free_ones(&untangle_whole).into_iter().step_by(97) {
            let before = tangled(&whole, v, 1.5);
            let (mut expected, mut found) = (before.clone(), each(&before));
            let mut normals = [vec![[0.0; 3]; expected.len()], vec![[0.0; 3]; found.len()]];
            untangle_whole.frame(handles.as_chunks().0, &mut expected, &mut normals[0]);
            untangle_split.frame(handles.as_chunks().0, &mut found, &mut normals[1]);
            assert!(apart(&before, &expected) > 0.0, "vertex {v}");
            assert_eq!(found, each(&expected), "vertex {v}");
            assert_eq!(normals[1], each(&normals[0]), "vertex {v}");
        }
    }
}
