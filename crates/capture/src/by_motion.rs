//! Handles where the examples move as their markers do.
//!
//! On another face, the point nearest to a marker may be beside the part that the marker is glued to. A
//! marker of an upper lid can come to lie at the corner of the eye, which no example moves. Then the eye
//! would never close. So a marker whose motion no example shows at its place goes to a near place at which
//! they do.
use crate::tracks::seen;
use faer::{
    Mat, Side,
    linalg::solvers::{Llt, Solve},
};
use glam::DVec3;
use rayon::prelude::*;
use rhytid_core::{SurfacePoint, VertexId};
use rhytid_solve::Skin;

/// A marker that moves less says nothing of its place, in metres RMS.
const MOVES: f64 = 1e-3;

/// A place shows a motion if the examples leave at most this part of its squares there …
const SHOWN: f64 = 0.2;

/// … and does not show it if they leave more than this part.
const UNSHOWN: f64 = 0.6;

/// No marker goes farther, in metres.
const REACH: f64 = 8e-3;

/// The part of a motion's squares that a place at the end of the reach must show more than one here.
const NEARER: f64 = 0.1;

/// The ridge of an example's weight, as a part of its squares at the markers. An example that moves few of
/// them counts like one that moves all.
const RIDGE: f64 = 0.01;

/// The weights of the examples are found again after markers have moved.
const ROUNDS: usize = 3;

/// The new point of each marker at `points` that moves otherwise than the examples do there.
///
/// `motions` has the displacements of each marker in each frame from its mean place, without the head's
/// motion and in mesh units; NaN where it was not seen.
pub(crate) fn moved(
    skin: &Skin,
    points: &[SurfacePoint],
    motions: &[Vec<DVec3>],
    metres_per_unit: f64,
) -> Vec<Option<SurfacePoint>> {
    let frames = motions.first().map_or(0, Vec::len);
    let mut moved: Vec<Option<SurfacePoint>> = vec![None; points.len()];
    if skin.displacements().is_empty() || frames == 0 {
        return moved;
    }
    for _ in 0..ROUNDS {
        let now: Vec<SurfacePoint> =
            points.iter().zip(&moved).map(|(point, moved)| moved.unwrap_or(*point)).collect();
        let shown: Vec<Vec<DVec3>> = now.iter().map(|point| shown_at(skin, point)).collect();
        let weights: Vec<Vec<f64>> =
            (0..frames).into_par_iter().map(|f| weights(&shown, motions, f)).collect();
        let wished: Vec<Vec<SurfacePoint>> = points
            .par_iter()
            .zip(motions)
            .map(|(point, motion)| better(skin, point, motion, &weights, metres_per_unit))
            .collect();
        let next = each_its_own(skin, points, &wished);
        if next == moved {
            break;
        }
        moved = next;
    }
    moved
}

/// For each marker the first of its wishes that is no other marker's place. None for a marker without one:
/// it stays at its point.
fn each_its_own(
    skin: &Skin,
    points: &[SurfacePoint],
    wished: &[Vec<SurfacePoint>],
) -> Vec<Option<SurfacePoint>> {
    let mut places: Vec<DVec3> = points.iter().map(|point| skin.at(point)).collect();
    let mut moved = vec![None; points.len()];
    for (i, wishes) in wished.iter().enumerate() {
        let is_free = |point: &&SurfacePoint| {
            let place = skin.at(point);
            (0..places.len()).all(|j| j == i || skin.are_apart(places[j], place))
        };
        if let Some(point) = wishes.iter().find(is_free) {
            places[i] = skin.at(point);
            moved[i] = Some(*point);
        }
    }
    moved
}

/// How far each example moves a point.
fn shown_at(skin: &Skin, point: &SurfacePoint) -> Vec<DVec3> {
    let of = |example: &Vec<DVec3>| DVec3::from_array(point.mean(|v| example[v.index()].to_array()));
    skin.displacements().iter().map(of).collect()
}

/// The weights of the examples whose sum is most like the markers' motions in frame `f`.
fn weights(shown: &[Vec<DVec3>], motions: &[Vec<DVec3>], f: usize) -> Vec<f64> {
    let examples = shown.first().map_or(0, Vec::len);
    let mut gram = Mat::<f64>::zeros(examples, examples);
    let mut along = Mat::<f64>::zeros(examples, 1);
    for (shown, motion) in shown.iter().zip(motions).filter(|(_, motion)| seen(motion[f])) {
        for (k, a) in shown.iter().enumerate() {
            along[(k, 0)] += a.dot(motion[f]);
            for (l, b) in shown.iter().enumerate() {
                gram[(k, l)] += a.dot(*b);
            }
        }
    }
    for k in 0..examples {
        let square = gram[(k, k)];
        gram[(k, k)] = if square > 0.0 { (1.0 + RIDGE) * square } else { 1.0 };
    }
    match Llt::new(gram.as_ref(), Side::Lower) {
        Ok(factor) => {
            let weights = factor.solve(&along);
            (0..examples).map(|k| weights[(k, 0)]).collect()
        }
        Err(_) => vec![0.0; examples],
    }
}

/// The near vertices that show the motion, the best one first. Empty if the point shows it.
fn better(
    skin: &Skin,
    point: &SurfacePoint,
    motion: &[DVec3],
    weights: &[Vec<f64>],
    metres_per_unit: f64,
) -> Vec<SurfacePoint> {
    let there = || motion.iter().zip(weights).filter(|(moved, _)| seen(**moved));
    let squares: f64 = there().map(|(moved, _)| moved.length_squared()).sum();
    let rms = (squares / there().count().max(1) as f64).sqrt();
    let left = |point: &SurfacePoint| {
        let shown = shown_at(skin, point);
        let of_frame = |(moved, weights): (&DVec3, &Vec<f64>)| {
            let sum: DVec3 = shown.iter().zip(weights).map(|(shown, weight)| *shown * *weight).sum();
            moved.distance_squared(sum)
        };
        there().map(of_frame).sum::<f64>() / squares
    };
    if rms * metres_per_unit < MOVES || left(point) < UNSHOWN {
        return Vec::new();
    }
    let (here, reach) = (skin.at(point), REACH / metres_per_unit);
    let cost = |v: VertexId| {
        let point = SurfacePoint::from(v);
        let (left, away) = (left(&point), skin.at(&point).distance(here) / reach);
        (left <= SHOWN).then_some((left + NEARER * away * away, point))
    };
    let near = skin.vertices_within(here, reach);
    let mut found: Vec<(f64, SurfacePoint)> = near.into_iter().filter_map(cost).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.into_iter().map(|(_, point)| point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::Face;

    /// How far each example moves a vertex, in millimetres.
    fn shown(face: &Face, v: usize) -> Vec<DVec3> {
        let at = |positions: &[[f64; 3]]| DVec3::from_array(positions[v]) * face.metres_per_unit * 1e3;
        face.examples.iter().map(|example| at(&example.positions) - at(&face.neutral.positions)).collect()
    }

    /// Markers on the mesh that move as it does, but for two at one place that go with places beside it.
    #[test]
    fn markers_go_where_the_mesh_moves_as_they_do_and_never_to_one_place() {
        let face = rhytid_demo::face(20_000);
        let skin = Skin::from_face(&face).unwrap();
        let open = skin.vertices_within(skin.middle(), f64::INFINITY);
        let (reach, all) = (REACH / face.metres_per_unit, |v: &VertexId| shown(&face, v.index()));
        let square = |motion: &[DVec3]| motion.iter().map(|d| d.length_squared()).sum::<f64>();
        let unlike = |a: &[DVec3], b: &[DVec3]| {
            a.iter().zip(b).map(|(a, b)| a.distance_squared(*b)).sum::<f64>() / square(a)
        };
        // A vertex that moves little beside one that moves a lot.
        let moving = |v: &&VertexId| square(&all(v)) > 16.0 * face.examples.len() as f64;
        let beside = |v: &VertexId| {
            let near = skin.vertices_within(skin.at(&(*v).into()), 0.7 * reach);
            let motion = all(v);
            near.into_iter().find(|w| unlike(&motion, &all(w)) > 0.8)
        };
        let (target, start) = open.iter().filter(moving).find_map(|v| Some((*v, beside(v)?))).unwrap();
        let mut points: Vec<SurfacePoint> = open.iter().step_by(40).map(|v| (*v).into()).collect();
        let count = points.len();
        // Frames that show one example each, in mesh units.
        let metres = 1e-3 / face.metres_per_unit;
        let of = |v: usize| shown(&face, v).into_iter().map(|d| d * metres).collect::<Vec<_>>();
        let mut motions: Vec<Vec<DVec3>> =
            points.iter().map(|point| of(point.nearest_vertex().index())).collect();
        for _ in 0..2 {
            points.push(start.into());
            motions.push(of(target.index()));
        }
        let found = moved(&skin, &points, &motions, face.metres_per_unit);
        assert!(found[..count].iter().all(Option::is_none), "a marker that moves as the mesh does stays");
        let [a, b] = [count, count + 1].map(|i| found[i].unwrap());
        assert!(skin.are_apart(skin.at(&a), skin.at(&b)), "{a:?} {b:?}");
        for point in [a, b] {
            let v = point.vertex().unwrap();
            assert!(skin.at(&point).distance(skin.at(&start.into())) <= reach);
            assert!(unlike(&all(&target), &all(&v)) < 0.3, "{}", unlike(&all(&target), &all(&v)));
        }
    }
}
