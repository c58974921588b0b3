//! Lays points over the surface that they lie on, such as markers over a face. It is not known which point
//! belongs where.
use super::similarity::{Similarity, fit};
use crate::surface::Surface;
use glam::{DMat3, DQuat, DVec3};
use rayon::prelude::*;

/// The starting points of the search: so many turns in the plane of the points.
const TURNS: usize = 18;
const TILTS: [f64; 3] = [-25.0, 0.0, 25.0];

/// The points may lie on a part of the surface alone. So the search starts with their middle at the
/// surface's, and this part of the extent to the left and right, above and below.
const SHIFT: f64 = 0.2;
const SHIFTS: [DVec3; 5] = [DVec3::ZERO, DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y];

/// The first search takes about so many of the points.
const FIRST_POINTS: usize = 24;

/// The tolerances of the first search, in parts of the surface's extent, and the number of fits with each.
const FIRST: ([f64; 4], usize) = ([0.1, 0.05, 0.03, 0.02], 6);
const LAST: ([f64; 5], usize) = ([0.05, 0.03, 0.02, 0.015, 0.01], 40);

/// So many of the best results of the first search are refined by the last search. It takes about so many of
/// the points. With all of them, a fit ends with so many steps.
const KEPT: usize = 8;
const LAST_POINTS: usize = 100;
const WITH_ALL: ([f64; 1], usize) = ([0.01], 10);

/// A point at this part of the extent from its place costs one half. The cost of a point that is far away
/// grows to 1.
const HALF_COST: f64 = 0.01;

/// Two results count as different if their rotations differ by more than this, in radians.
const DIFFERENT: f64 = 0.26;

/// The front of the points is known if their bulge is at least this correlation. Else both sides are tried.
const BULGES: f64 = 0.5;

/// The weight of a point whose place is known; a point that looks for its place has the weight 1.
const KNOWN: f64 = 20.0;

/// The pull towards the middle of the allowed scales in each fit, beside the points' own weight of 1. Points
/// on a part of the surface say little about their scale, and would slide along it without the pull.
const USUAL_SIZE: f64 = 0.02;

/// Points all over the surface do say their scale, which the pull would keep from them. So a search without
/// it follows, of so many steps at most. It counts if it makes the cost lower than this part.
const ANY_SIZE: ([f64; 1], usize) = ([0.01], 200);
const CLEARLY: f64 = 0.5;

/// Actors' proportions differ. Each axis is stretched by up to this, and by less if few points ask for it.
const STRETCH: f64 = 1.2;
const STIFFNESS: f64 = 0.25;

/// What is known before the search.
#[derive(Debug, Clone)]
pub struct Start {
    /// The axes of the surface: its right, up, and the direction in which it looks; of length 1, at right
    /// angles.
    pub axes: DMat3,
    /// The approximate place of the points' middle.
    pub middle: DVec3,
    /// The extent of the part of the surface that has the points.
    pub extent: f64,
    /// The least and the greatest scale.
    pub scales: [f64; 2],
    /// The place of each point, if it is known.
    pub known: Vec<Option<DVec3>>,
}

/// Points on a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct OntoSurface {
    /// From the points' space to the surface's.
    pub motion: Similarity,
    /// The stretch along each axis of [`Start::axes`] about the points' middle, after the motion.
    pub stretch: DVec3,
    /// The place of each point, before it is put on the surface.
    pub points: Vec<DVec3>,
    /// How badly the points fit, from 0 to 1.
    pub cost: f64,
}

/// Lays `points` over `surface` by a similarity. Each fit differs from those before it by a turn of 15° or
/// more; the best one is first. Empty for fewer than four points or without a surface.
///
/// From many starting points, it iterates closest points (Besl and McKay 1992). They are reweighted by Geman
/// and McClure's function with a tolerance that shrinks. Then each axis may stretch a little.
///
/// The bulge tells front from back: the points of a face bulge towards where it looks. On a symmetric
/// surface, mirrored points do not tell left from right; only labels do.
pub fn onto_surface(points: &[DVec3], surface: &Surface, start: &Start) -> Vec<OntoSurface> {
    if points.len() < 4 {
        return Vec::new();
    }
    let search = Search { points, known: &start.known, surface, start, pull: USUAL_SIZE };
    let few = Subset::new(points, start, FIRST_POINTS);
    let quick = Search { points: &few.points, known: &few.known, surface, start, pull: USUAL_SIZE };
    let many = Subset::new(points, start, LAST_POINTS);
    let exact = Search { points: &many.points, known: &many.known, surface, start, pull: USUAL_SIZE };
    let first: Vec<Fit> = search
        .starts()
        .into_par_iter()
        .filter_map(|motion| {
            let motion = quick.refine(motion, &FIRST.0, FIRST.1)?.motion;
            Some(Fit { cost: exact.cost(&motion)?, motion })
        })
        .collect();
    let last: Vec<Fit> = distinct(first)
        .into_par_iter()
        .take(KEPT)
        .filter_map(|fit| {
            let usual = exact.refine(fit.motion, &LAST.0, LAST.1)?;
            let any = exact.of_any_size().refine(usual.motion, &ANY_SIZE.0, ANY_SIZE.1)?;
            let is_of_any = any.cost < CLEARLY * usual.cost;
            let fit = if is_of_any { any } else { usual };
            if many.points.len() == points.len() {
                return Some(fit);
            }
            let search = if is_of_any { search.of_any_size() } else { search };
            search.refine(fit.motion, &WITH_ALL.0, WITH_ALL.1)
        })
        .collect();
    let mut found = Vec::new();
    for Fit { cost, motion } in distinct(last) {
        if let Some((stretch, points)) = search.stretch(&motion) {
            found.push(OntoSurface { motion, stretch, points, cost });
        }
    }
    found
}

/// A motion, and how badly the points fit with it.
struct Fit {
    cost: f64,
    motion: Similarity,
}

/// Some of the points.
struct Subset {
    points: Vec<DVec3>,
    known: Vec<Option<DVec3>>,
}

impl Subset {
    /// At most about `count` of the points, evenly taken from their order, and all whose place is known.
    fn new(points: &[DVec3], start: &Start, count: usize) -> Self {
        let step = points.len().div_ceil(count).max(1);
        let mut subset = Self { points: Vec::new(), known: Vec::new() };
        for (i, (point, known)) in points.iter().zip(&start.known).enumerate() {
            if i % step == 0 || known.is_some() {
                subset.points.push(*point);
                subset.known.push(*known);
            }
        }
        subset
    }
}

/// The fits that are turned otherwise than each better one, the best first.
fn distinct(mut fits: Vec<Fit>) -> Vec<Fit> {
    fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut kept: Vec<Fit> = Vec::new();
    for fit in fits {
        let is_other = |other: &Fit| fit.motion.rotation.angle_between(other.motion.rotation) > DIFFERENT;
        if kept.iter().all(is_other) {
            kept.push(fit);
        }
    }
    kept
}

#[derive(Clone, Copy)]
struct Search<'a> {
    points: &'a [DVec3],
    /// The place of each point, if it is known.
    known: &'a [Option<DVec3>],
    surface: &'a Surface,
    start: &'a Start,
    /// The pull towards the usual scale.
    pull: f64,
}

impl Search<'_> {
    /// The same search without a pull towards the usual scale.
    fn of_any_size(self) -> Self {
        Self { pull: 0.0, ..self }
    }

    /// Starting motions: the points' middle near the surface's, their front forwards, with all turns and
    /// tilts.
    fn starts(&self) -> Vec<Similarity> {
        let count = self.points.len() as f64;
        let middle = self.points.iter().sum::<DVec3>() / count;
        // The direction in which the points spread least is across the face.
        let mut covariance = DMat3::ZERO;
        for p in self.points {
            let d = *p - middle;
            covariance += DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        }
        let across = least(covariance);
        // The points in the middle of the face bulge outwards.
        let (mut heights, mut radii) = (0.0, 0.0);
        let of = |p: &DVec3| {
            let d = *p - middle;
            (d.dot(across), d.reject_from(across).length_squared())
        };
        self.points.iter().map(of).for_each(|(height, radius)| {
            heights += height / count;
            radii += radius / count;
        });
        let (mut bulge, mut of_heights, mut of_radii) = (0.0, 0.0, 0.0);
        for (height, radius) in self.points.iter().map(of) {
            bulge += (height - heights) * (radius - radii);
            of_heights += (height - heights).powi(2);
            of_radii += (radius - radii).powi(2);
        }
        let front = if bulge > 0.0 { -across } else { across };
        let is_known = bulge.abs() > BULGES * (of_heights * of_radii).sqrt();
        let fronts = if is_known { vec![front] } else { vec![front, -front] };
        let scale = (self.start.scales[0] * self.start.scales[1]).sqrt();
        let mut starts = Vec::new();
        for front in fronts.into_iter().filter(|_| scale.is_finite()) {
            let (right, up) = front.any_orthonormal_pair();
            let from = DMat3::from_cols(right, up, front).transpose();
            for i in 0..TURNS {
                let turn = DMat3::from_rotation_z(i as f64 / TURNS as f64 * std::f64::consts::TAU);
                for tilt in TILTS {
                    let turned = DMat3::from_rotation_x(tilt.to_radians()) * turn * from;
                    let rotation = DQuat::from_mat3(&(self.start.axes * turned)).normalize();
                    for shift in SHIFTS {
                        let at = self.start.middle + self.start.axes * (SHIFT * self.start.extent * shift);
                        let translation = at - rotation * (scale * middle);
                        starts.push(Similarity { scale, rotation, translation });
                    }
                }
            }
        }
        starts
    }

    /// The target of each placed point, and its weight.
    fn targets(&self, placed: &[DVec3], tolerance: f64) -> Option<(Vec<DVec3>, Vec<f64>)> {
        let target = |(p, known): (&DVec3, &Option<DVec3>)| match known {
            Some(place) => Some((*place, KNOWN)),
            None => {
                let closest = self.surface.closest(*p)?.point;
                Some((closest, (1.0 + (closest.distance(*p) / tolerance).powi(2)).powi(-2)))
            }
        };
        let pairs: Option<Vec<(DVec3, f64)>> = placed.iter().zip(self.known).map(target).collect();
        Some(pairs?.into_iter().unzip())
    }

    /// Fits with each of some tolerances, in parts of the extent.
    fn refine(&self, mut motion: Similarity, tolerances: &[f64], fits: usize) -> Option<Fit> {
        for tolerance in tolerances.iter().map(|part| part * self.start.extent) {
            for _ in 0..fits {
                let placed: Vec<DVec3> = self.points.iter().map(|p| motion.apply(*p)).collect();
                let (targets, weights) = self.targets(&placed, tolerance)?;
                let before = motion;
                motion = self.bounded(fit(self.points, &targets, &weights, true)?, &targets, &weights);
                let moved = placed.iter().zip(self.points).map(|(x, p)| x.distance(motion.apply(*p)));
                if before.scale == motion.scale || moved.fold(0.0, f64::max) < 1e-5 * self.start.extent {
                    break;
                }
            }
        }
        Some(Fit { cost: self.cost(&motion)?, motion })
    }

    /// The same fit with a scale within the allowed bounds, a little nearer to their middle.
    fn bounded(&self, fitted: Similarity, targets: &[DVec3], weights: &[f64]) -> Similarity {
        let [least, greatest] = self.start.scales;
        let usual = (least * greatest).sqrt();
        let scale = (fitted.scale + self.pull * usual) / (1.0 + self.pull);
        let scale = scale.clamp(least, greatest);
        let total: f64 = weights.iter().sum();
        let mean =
            |points: &[DVec3]| points.iter().zip(weights).map(|(p, w)| *p * (w / total)).sum::<DVec3>();
        let translation = mean(targets) - fitted.rotation * (scale * mean(self.points));
        Similarity { scale, translation, ..fitted }
    }

    fn cost(&self, motion: &Similarity) -> Option<f64> {
        let far = HALF_COST * self.start.extent;
        let of = |(p, known): (&DVec3, &Option<DVec3>)| {
            let p = motion.apply(*p);
            let squared = known.or(self.surface.closest(p).map(|closest| closest.point))?.distance_squared(p);
            Some(squared / (far * far + squared))
        };
        let all: Option<Vec<f64>> = self.points.iter().zip(self.known).map(of).collect();
        Some(all?.iter().sum::<f64>() / self.points.len() as f64)
    }

    /// The stretches of the axes about the points' middle that bring the points nearer still, and the
    /// stretched points.
    fn stretch(&self, motion: &Similarity) -> Option<(DVec3, Vec<DVec3>)> {
        let to_axes = self.start.axes.transpose();
        let placed: Vec<DVec3> = self.points.iter().map(|p| motion.apply(*p)).collect();
        let (mut stretch, mut now) = (DVec3::ONE, placed.clone());
        for _ in 0..LAST.1 {
            let (targets, weights) = self.targets(&now, LAST.0[1] * self.start.extent)?;
            let total: f64 = weights.iter().sum();
            let mean =
                |points: &[DVec3]| points.iter().zip(&weights).map(|(p, w)| *p * (w / total)).sum::<DVec3>();
            let (from, to) = (mean(&placed), mean(&targets));
            let (mut both, mut own) = (DVec3::ZERO, DVec3::ZERO);
            for ((p, q), w) in placed.iter().zip(&targets).zip(&weights) {
                let (p, q) = (to_axes * (*p - from), to_axes * (*q - to));
                both += *w * p * q;
                own += *w * p * p;
            }
            // Ridge regression towards the scale of the similarity.
            stretch = (both + STIFFNESS * own) / (own * (1.0 + STIFFNESS));
            stretch = stretch.clamp(DVec3::splat(1.0 / STRETCH), DVec3::splat(STRETCH));
            let next: Vec<DVec3> =
                placed.iter().map(|p| to + self.start.axes * (stretch * (to_axes * (*p - from)))).collect();
            let moved = next.iter().zip(&now).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            now = next;
            if moved < 1e-5 * self.start.extent {
                break;
            }
        }
        Some((stretch, now))
    }
}

/// The eigenvector of the least eigenvalue of a symmetric positive semidefinite matrix. It is found by power
/// iteration with the matrix subtracted from its trace.
fn least(matrix: DMat3) -> DVec3 {
    let trace = matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z;
    let turned = DMat3::from_diagonal(DVec3::splat(trace)) - matrix;
    let mut power = turned * (1.0 / trace.max(f64::MIN_POSITIVE));
    for _ in 0..24 {
        power *= power;
        let largest = power.to_cols_array().into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        power *= 1.0 / largest.max(f64::MIN_POSITIVE);
    }
    let columns = [power.x_axis, power.y_axis, power.z_axis];
    let longest = columns.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    longest.unwrap_or(DVec3::Z).normalize_or(DVec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A face of sorts: an ellipsoid's front with a nose, a chin and a brow, faces along +Z.
    fn face(u: f64, v: f64) -> DVec3 {
        let bump = |x: f64, y: f64, wide: f64, high: f64| {
            high * (-((u - x).powi(2) + (v - y).powi(2)) / (wide * wide)).exp()
        };
        let z = 60.0 * (1.0 - (u / 90.0).powi(2) - (v / 120.0).powi(2));
        DVec3::new(
            u,
            v,
            z + bump(0.0, -5.0, 14.0, 26.0) + bump(0.0, -70.0, 20.0, 12.0) + bump(0.0, 45.0, 40.0, 6.0),
        )
    }

    fn surface() -> Surface {
        let n = 40;
        let at = |i: usize, j: usize| {
            face(-75.0 + 150.0 * i as f64 / n as f64, -95.0 + 190.0 * j as f64 / n as f64)
        };
        let quads = (0..n).flat_map(move |i| (0..n).map(move |j| (i, j)));
        let corners = quads.flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        });
        Surface::new(corners.enumerate())
    }

    #[test]
    fn markers_find_their_face_whichever_way_they_are_turned() {
        let places: Vec<DVec3> = (0..40)
            .map(|i| {
                let (r, angle) = (((f64::from(i) + 0.5) / 40.0).sqrt(), 2.4 * f64::from(i));
                face(60.0 * r * angle.cos(), 80.0 * r * angle.sin())
            })
            .collect();
        let surface = surface();
        let start = Start {
            axes: DMat3::IDENTITY,
            middle: DVec3::new(0.0, 0.0, 35.0),
            extent: 240.0,
            scales: [0.8, 1.25],
            known: vec![None; 41],
        };
        for (axis, angle) in [(DVec3::X, 1.6), (DVec3::new(1.0, 1.0, 0.3), 3.0), (DVec3::Y, -2.2)] {
            let back = Similarity {
                scale: 0.93,
                rotation: DQuat::from_axis_angle(axis.normalize(), angle),
                translation: DVec3::new(-400.0, 1500.0, 90.0),
            };
            // One of the points is no marker of the face.
            let mut markers: Vec<DVec3> = places.iter().map(|p| back.apply(*p)).collect();
            markers.push(back.apply(DVec3::new(0.0, 130.0, 60.0)));
            let all = onto_surface(&markers, &surface, &start);
            let (found, other) = (&all[0], &all[1]);
            let off = found.points.iter().zip(&places).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            assert!(off < 3.0, "turned by {angle} about {axis}: {off} mm off, {found:?}");
            assert!(other.cost > 2.0 * found.cost, "{} {}", found.cost, other.cost);
            assert!(all.is_sorted_by(|a, b| a.cost <= b.cost));
            for (i, a) in all.iter().enumerate() {
                let turn = |b: &OntoSurface| a.motion.rotation.angle_between(b.motion.rotation);
                assert!(all[..i].iter().all(|b| turn(b) > DIFFERENT));
            }
        }
    }

    /// Some of the points lead to the fit of all of them, with the known ones among them.
    #[test]
    fn hundreds_of_points_are_laid_as_exactly_as_few() {
        // As many as MediaPipe's landmarks.
        let places: Vec<DVec3> = (0..478)
            .map(|i| {
                let (r, angle) = (((f64::from(i) + 0.5) / 478.0).sqrt(), 2.4 * f64::from(i));
                face(60.0 * r * angle.cos(), 80.0 * r * angle.sin())
            })
            .collect();
        let mut known = vec![None; places.len()];
        known[3] = Some(places[3]);
        let start = Start {
            axes: DMat3::IDENTITY,
            middle: DVec3::new(0.0, 0.0, 35.0),
            extent: 240.0,
            scales: [0.8, 1.25],
            known,
        };
        for count in [FIRST_POINTS, LAST_POINTS] {
            let subset = Subset::new(&places, &start, count);
            assert!(subset.points.len() <= count + 1 && subset.known.len() == subset.points.len());
            assert_eq!(subset.known.iter().flatten().count(), 1);
        }
        let back = Similarity {
            scale: 0.93,
            rotation: DQuat::from_axis_angle(DVec3::X, 1.6),
            translation: DVec3::new(-400.0, 1500.0, 90.0),
        };
        let markers: Vec<DVec3> = places.iter().map(|p| back.apply(*p)).collect();
        let found = &onto_surface(&markers, &surface(), &start)[0];
        assert_eq!(found.points.len(), places.len());
        let off = found.points.iter().zip(&places).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        assert!(off < 0.6, "{off} mm off");
    }

    /// Many files name the left marker and the right one by turns.
    #[test]
    fn points_that_lie_left_and_right_by_turns_are_laid_in_any_allowed_size() {
        let places: Vec<DVec3> = (0..48)
            .map(|i| {
                let side = if i % 2 == 0 { 1.0 } else { -1.0 };
                let (r, angle) = (((f64::from(i / 2) + 0.5) / 24.0).sqrt(), 2.4 * f64::from(i / 2));
                face(side * 60.0 * r * angle.cos().abs(), 80.0 * r * angle.sin())
            })
            .collect();
        let start = Start {
            axes: DMat3::IDENTITY,
            middle: DVec3::new(0.0, 0.0, 35.0),
            extent: 240.0,
            scales: [0.8, 1.25],
            known: vec![None; 48],
        };
        // The last two are a little beyond the allowed scales.
        for (axis, angle, size, most) in [
            (DVec3::X, 1.6, 0.93, 0.6),
            (DVec3::Y, -2.2, 1.0, 0.6),
            (DVec3::Z, 2.0, 0.79, 2.0),
            (DVec3::Z, 2.0, 1.26, 2.0),
        ] {
            let back = Similarity {
                scale: size,
                rotation: DQuat::from_axis_angle(axis, angle),
                translation: DVec3::new(-400.0, 1500.0, 90.0),
            };
            let markers: Vec<DVec3> = places.iter().map(|p| back.apply(*p)).collect();
            let found = &onto_surface(&markers, &surface(), &start)[0];
            let off = found.points.iter().zip(&places).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            assert!(off < most, "turned by {angle} about {axis}, {size} times the size: {off} mm off");
        }
    }

    #[test]
    fn the_direction_of_least_spread() {
        let turn = DMat3::from_rotation_x(0.7) * DMat3::from_rotation_y(-0.4);
        let matrix = turn * DMat3::from_diagonal(DVec3::new(5.0, 0.3, 2.0)) * turn.transpose();
        assert!(least(matrix).dot(turn.y_axis).abs() > 1.0 - 1e-9);
    }
}
