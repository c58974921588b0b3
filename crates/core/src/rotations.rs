//! How the surface turns at each handle (`docs/method.md`, rotations), and what devices get of it. The host
//! computes it once per frame, in f64. It uses only sums, products and roots, so every device gets the same
//! bits.
use crate::HandleId;
use crate::HandleSet;
use crate::nearest_turn;
use rayon::prelude::*;
use rhytid_kernels::large_scale::MOTION;
use rhytid_kernels::{Real, vec3};

/// The weight of the turn of all handles at each handle along an axis, relative to the average weight of its
/// neighbours. It determines what the neighbours do not, such as the turn about a line in which they lie. A
/// weight of 1 would more than halve every turn of a flat neighbourhood, since its neighbours have no weight
/// across.
const OF_ALL: f64 = 0.1;

/// The weight of no turn in the turn of all handles, relative to the handles' own weight. Where they lie in a
/// line, the smallest turn is taken.
const NO_TURN: f64 = 1e-9;

/// The data from which the rotations of a rig's handles are estimated.
#[derive(Debug, Clone, PartialEq)]
pub struct Rotations {
    /// H rest positions, in mesh units.
    rest: Vec<[f64; 3]>,
    /// H edges from their mean.
    from_mean: Vec<[f64; 3]>,
    /// The index of each handle's first neighbour, and the end of the last ones: H + 1.
    offsets: Vec<usize>,
    /// The other ends of each handle's strain edges.
    neighbors: Vec<Neighbor>,
    /// Index of the handle nearest to the mean.
    center: usize,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Neighbor {
    handle: usize,
    /// The edge to it at rest.
    edge: [f64; 3],
    /// One over the square of the edge's length, so that each direction counts equally.
    weight: f64,
}

/// A 3×3 matrix, row by row.
type Matrix = [[f64; 3]; 3];

impl Rotations {
    /// The rotations of handles that turn. `None` where they do not turn.
    pub fn new<T: Real>(handles: &HandleSet<T>) -> Option<Self> {
        if !handles.rotations {
            return None;
        }
        let rest: Vec<[f64; 3]> = handles.rest.iter().map(|x| x.map(T::widen)).collect();
        let from_mean = from_mean(&rest);
        let square = |h: &usize| vec3::dot(from_mean[*h], from_mean[*h]);
        let center = (0..rest.len()).min_by(|a, b| square(a).total_cmp(&square(b))).unwrap_or(0);
        let mut of_handles = vec![Vec::new(); rest.len()];
        for &[a, b] in &handles.strain_edges {
            let [a, b] = [a, b].map(HandleId::index);
            let edge = vec3::sub(rest[b], rest[a]);
            let weight = 1.0 / vec3::dot(edge, edge);
            // Two handles at one place have no edge to turn.
            if weight.is_finite() {
                of_handles[a].push(Neighbor { handle: b, edge, weight });
                of_handles[b].push(Neighbor { handle: a, edge: edge.map(|x| -x), weight });
            }
        }
        let ends = of_handles.iter().scan(0, |end, neighbors| {
            *end += neighbors.len();
            Some(*end)
        });
        let offsets = std::iter::once(0).chain(ends).collect();
        Some(Self { rest, from_mean, offsets, neighbors: of_handles.concat(), center })
    }

    /// The index of the handle about which vertices are turned: the one nearest to the mean of all. The exact
    /// point does not matter. It only keeps the rest positions small when it is subtracted from them.
    pub fn center(&self) -> usize {
        self.center
    }

    /// R_h − I of each handle, H, where the handles are at H `positions`.
    pub fn turns(&self, positions: &[[f64; 3]]) -> Vec<Matrix> {
        let mut all = [[0.0; 3]; 3];
        from_mean(positions)
            .iter()
            .zip(&self.from_mean)
            .for_each(|(now, rest)| add(&mut all, 1.0, *now, *rest));
        let spread: f64 = self.from_mean.iter().map(|x| vec3::dot(*x, *x)).sum();
        (0..3).for_each(|c| all[c][c] += NO_TURN * spread);
        let all = nearest_turn(&all);
        let of_handle = |h: usize| {
            let neighbors = &self.neighbors[self.offsets[h]..self.offsets[h + 1]];
            let mut own = [[0.0; 3]; 3];
            for neighbor in neighbors {
                let now = vec3::sub(positions[neighbor.handle], positions[h]);
                add(&mut own, neighbor.weight, now, neighbor.edge);
            }
            let counts = OF_ALL / 3.0 * neighbors.len().max(1) as f64;
            for (i, row) in own.iter_mut().enumerate() {
                for (j, x) in row.iter_mut().enumerate() {
                    *x += counts * (all[i][j] + f64::from(u8::from(i == j)));
                }
            }
            nearest_turn(&own)
        };
        (0..self.rest.len()).map(of_handle).collect()
    }

    /// What the kernel `large_scale` reads for frames × H positions: frames × 4 × H vectors. In each frame,
    /// the first H vectors tell where the handles take the centre from rest. The columns of R_h − I follow.
    pub fn motions<T: Real>(&self, positions: &[[T; 3]]) -> Vec<[T; 3]> {
        let handles = self.rest.len();
        let mut motions = vec![[T::ZERO; 3]; MOTION * positions.len()];
        let frames = motions.par_chunks_exact_mut(MOTION * handles.max(1));
        frames.zip(positions.par_chunks_exact(handles.max(1))).for_each(|(motions, positions)| {
            let positions: Vec<[f64; 3]> = positions.iter().map(|p| p.map(T::widen)).collect();
            for (h, turn) in self.turns(&positions).iter().enumerate() {
                let to_center = vec3::sub(self.rest[self.center], self.rest[h]);
                let u = vec3::sub(positions[h], self.rest[h]);
                let moved = vec3::add(u, turn.map(|row| vec3::dot(row, to_center)));
                motions[h] = moved.map(T::round_from);
                for c in 0..3 {
                    motions[(1 + c) * handles + h] = turn.map(|row| T::round_from(row[c]));
                }
            }
        });
        motions
    }
}

fn from_mean(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let sum = points.iter().fold([0.0; 3], |sum, x| vec3::add(sum, *x));
    let mean = sum.map(|x| x / points.len() as f64);
    points.iter().map(|x| vec3::sub(*x, mean)).collect()
}

/// Adds w a bᵀ. Where a is b, the added matrix is exactly symmetric.
fn add(sum: &mut Matrix, w: f64, a: [f64; 3], b: [f64; 3]) {
    for i in 0..3 {
        for j in 0..3 {
            sum[i][j] += w * (a[i] * b[j]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VertexId;

    /// Handles at these places and nothing else. Strain edges join all that lie apart, and not farther than
    /// `farthest`.
    fn rotations(rest: &[[f64; 3]], farthest: f64) -> Rotations {
        let h = rest.len();
        let pairs = (0..h as u32).flat_map(|a| (0..a).map(move |b| [b, a]));
        let joined = |&[a, b]: &[u32; 2]| {
            let length = off(rest[a as usize], rest[b as usize]);
            length > 0.0 && length <= farthest
        };
        let handles = HandleSet {
            labels: Vec::new(),
            points: (0..h as u32).map(|v| VertexId(v).into()).collect(),
            rest: rest.to_vec(),
            strain_edges: pairs.filter(joined).map(|pair| pair.map(HandleId)).collect(),
            rotations: true,
        };
        Rotations::new(&handles).unwrap()
    }

    /// About an axis of length 1, by Rodrigues' formula.
    fn rodrigues(axis: [f64; 3], angle: f64, x: [f64; 3]) -> [f64; 3] {
        let across = vec3::cross(axis, x);
        let along = vec3::dot(axis, x);
        std::array::from_fn(|c| {
            x[c] * angle.cos() + across[c] * angle.sin() + axis[c] * along * (1.0 - angle.cos())
        })
    }

    fn applied(turn: &Matrix, x: [f64; 3]) -> [f64; 3] {
        vec3::add(x, turn.map(|row| vec3::dot(row, x)))
    }

    fn off(a: [f64; 3], b: [f64; 3]) -> f64 {
        vec3::length(vec3::sub(a, b))
    }

    const AXIS: [f64; 3] = [2.0 / 7.0, -3.0 / 7.0, 6.0 / 7.0];
    const FIVE: [[f64; 3]; 5] =
        [[1.0, 2.0, 0.5], [3.0, -1.0, 0.2], [-2.0, 0.3, -0.4], [0.1, -2.0, 1.0], [0.0, 0.0, 0.3]];

    #[test]
    fn a_turn_of_all_is_found_at_each_whatever_its_angle() {
        for rest in [&FIVE[..], &FIVE[..3]] {
            let rotations = rotations(rest, 99.0);
            for degrees in [0.0f64, 1e-7, 30.0, 90.0, 170.0, 179.0, -120.0] {
                let turned = |x| rodrigues(AXIS, degrees.to_radians(), x);
                let now: Vec<[f64; 3]> =
                    rest.iter().map(|x| vec3::add(turned(*x), [5.0, -7.0, 2.0])).collect();
                for turn in rotations.turns(&now) {
                    for x in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
                        assert!(off(applied(&turn, x), turned(x)) < 1e-7, "{degrees}: {turn:?}");
                    }
                }
            }
            assert!(rotations.turns(rest).iter().flatten().flatten().all(|x| *x == 0.0));
        }
    }

    /// The motion of a handle's neighbours gives nearly all of its turn; [`OF_ALL`] takes only a small part.
    #[test]
    fn a_strip_that_is_bent_turns_by_its_own_angle() {
        let places = (0..7).flat_map(|i| [-0.75, 0.75].map(|y| [f64::from(i) - 3.0, y, 0.0]));
        let rest: Vec<[f64; 3]> = places.collect();
        // A quarter of a circle.
        let radius = 6.0 / std::f64::consts::FRAC_PI_2;
        let bent = |x: &[f64; 3]| {
            let angle = x[0] / radius;
            [radius * angle.sin(), x[1], radius * (1.0 - angle.cos())]
        };
        let now: Vec<[f64; 3]> = rest.iter().map(bent).collect();
        let strip = rotations(&rest, 1.6);
        for (turn, x) in strip.turns(&now).iter().zip(&rest) {
            let [_, _, up] = applied(turn, [1.0, 0.0, 0.0]);
            // The ends see one side of themselves.
            let expected = (x[0].abs().min(2.5).copysign(x[0])) / radius;
            assert!(
                (up.asin() - expected).abs() < 0.15 * expected.abs() + 1e-9,
                "{} for {expected}",
                up.asin()
            );
        }
    }

    #[test]
    fn what_determines_no_rotation_takes_the_smallest() {
        let all_at_one = vec![[1.0, 2.0, 3.0]; 4];
        for (rest, now) in [
            (vec![[1.0, 2.0, 3.0]], vec![[9.0, 9.0, 9.0]]),
            (all_at_one.clone(), FIVE[..4].to_vec()),
            (FIVE[..4].to_vec(), all_at_one),
        ] {
            let turns = rotations(&rest, 99.0).turns(&now);
            assert!(turns.iter().flatten().flatten().all(|x| *x == 0.0), "{turns:?}");
        }
        // Two handles turn as the line between them does, and not about it.
        let turns = rotations(&[[0.0; 3], [2.0, 0.0, 0.0]], 99.0).turns(&[[1.0, 1.0, 1.0], [1.0, 4.0, 1.0]]);
        for turn in turns {
            for (x, expected) in [
                ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
                ([0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]),
                ([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]),
            ] {
                assert!(off(applied(&turn, x), expected) < 1e-6, "{turn:?}");
            }
        }
    }

    /// Handles that move steadily turn steadily, also through a half turn.
    #[test]
    fn neighbouring_frames_have_neighbouring_rotations() {
        let rotations = rotations(&FIVE, 99.0);
        let frame = |i: usize| {
            let t = i as f64 / 1000.0;
            let turned = FIVE.iter().enumerate().map(|(h, x)| {
                let own = rodrigues(AXIS, 6.0 * t, *x);
                [own[0] + (5.0 * t + h as f64).sin(), own[1], own[2] + 0.3 * (9.0 * t * h as f64).cos()]
            });
            rotations.turns(&turned.collect::<Vec<_>>())
        };
        let frames: Vec<Vec<Matrix>> = (0..=1000).map(frame).collect();
        for [before, after] in frames.array_windows() {
            for (a, b) in before.iter().flatten().flatten().zip(after.iter().flatten().flatten()) {
                assert!((a - b).abs() < 0.03, "{a} and then {b}");
            }
        }
    }
}
