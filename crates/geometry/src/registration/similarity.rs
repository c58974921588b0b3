//! Rigid and similarity fits of point sets, weighted and robust.
//!
//! The rotation is Horn's ([`horn`]), so that reflections cannot come out.
use super::seen;
use glam::{DMat3, DQuat, DVec3};
use rhytid_core::horn;
use rhytid_core::numbers::median;

/// `x ↦ scale · rotation · x + translation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Similarity {
    /// Above 0; 1 for a rigid motion.
    pub scale: f64,
    /// A unit quaternion.
    pub rotation: DQuat,
    /// Added last.
    pub translation: DVec3,
}

impl Similarity {
    /// The motion that changes nothing.
    pub const IDENTITY: Self = Self { scale: 1.0, rotation: DQuat::IDENTITY, translation: DVec3::ZERO };

    /// The image of a point.
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.rotation * (self.scale * point) + self.translation
    }

    /// Its inverse.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.conjugate();
        let scale = 1.0 / self.scale;
        Self { scale, rotation, translation: -(rotation * (scale * self.translation)) }
    }

    /// The composition: first `first`, then this one.
    pub fn after(&self, first: &Self) -> Self {
        Self {
            scale: self.scale * first.scale,
            rotation: (self.rotation * first.rotation).normalize(),
            translation: self.apply(first.translation),
        }
    }
}

/// The similarity (or, without `with_scale`, the rigid motion) that takes `from` to `to` with the least
/// weighted sum of squared distances. Pairs with a NaN do not count. `None` if fewer than three points with a
/// weight remain, or if they lie on a line.
pub fn fit(from: &[DVec3], to: &[DVec3], weights: &[f64], with_scale: bool) -> Option<Similarity> {
    let pairs = || {
        let all = from.iter().zip(to).zip(weights).map(|((a, b), w)| (*a, *b, *w));
        all.filter(|(a, b, w)| seen(*a) && seen(*b) && *w > 0.0)
    };
    let total: f64 = pairs().map(|(_, _, w)| w).sum();
    if pairs().count() < 3 {
        return None;
    }
    let (a0, b0) = pairs()
        .fold((DVec3::ZERO, DVec3::ZERO), |(a0, b0), (a, b, w)| (a0 + a * (w / total), b0 + b * (w / total)));
    let mut correlation = DMat3::ZERO;
    let mut spread = [0.0; 2];
    for (a, b, w) in pairs() {
        let (a, b) = (a - a0, b - b0);
        correlation += DMat3::from_cols(a * b.x, a * b.y, a * b.z) * w;
        spread[0] += w * a.length_squared();
        spread[1] += w * b.length_squared();
    }
    // Row i of M = Σ w b aᵀ is bᵢ times a.
    let best = horn(&correlation.to_cols_array_2d());
    // The two largest values are equal if the points lie on a line. Then the turn about the line is free.
    if best.largest - best.second <= 1e-9 * (spread[0] * spread[1]).sqrt() {
        return None;
    }
    let [w, x, y, z] = best.quaternion;
    let rotation = DQuat::from_xyzw(x, y, z, w).normalize();
    let scale = if with_scale { best.largest / spread[0] } else { 1.0 };
    if !(scale.is_finite() && scale > 0.0) {
        return None;
    }
    Some(Similarity { scale, rotation, translation: b0 - rotation * (scale * a0) })
}

/// As [`fit`] with the weight 1 for all, but points that do not fit lose their weight. Points are iteratively
/// reweighted by Geman and McClure's function of the ratio of residual to `tolerance`, a distance in units of
/// `to`. The first weights come from distances between the points, which a rigid motion keeps. So a few bad
/// points cannot mislead the first fit.
///
/// Also returns the RMS residual of the points that keep at least half of their weight.
pub fn fit_robustly(
    from: &[DVec3],
    to: &[DVec3],
    with_scale: bool,
    tolerance: f64,
) -> Option<(Similarity, f64)> {
    let weight = |residual: f64| (1.0 + (residual / tolerance).powi(2)).powi(-2);
    let mut weights = vec![1.0; from.len()];
    let mut fitted = fit(from, to, &weights, with_scale)?;
    let residuals = |fitted: &Similarity| -> Vec<f64> {
        from.iter().zip(to).map(|(a, b)| fitted.apply(*a).distance(*b)).collect()
    };
    let is_bad = |residuals: &[f64]| residuals.iter().any(|r| *r > tolerance);
    let mut left = residuals(&fitted);
    if is_bad(&left) {
        weights = distance_errors(from, to, with_scale).into_iter().map(weight).collect();
        for _ in 0..ITERATIONS {
            let before = fitted;
            fitted = fit(from, to, &weights, with_scale)?;
            left = residuals(&fitted);
            weights = left.iter().map(|r| if r.is_nan() { 0.0 } else { weight(*r) }).collect();
            let moved = left.iter().zip(residuals(&before)).map(|(a, b)| (a - b).abs());
            if moved.fold(0.0, f64::max) < 1e-6 * tolerance {
                break;
            }
        }
    }
    let good = || left.iter().zip(&weights).filter(|(r, w)| !r.is_nan() && **w >= 0.5).map(|(r, _)| r * r);
    Some((fitted, (good().sum::<f64>() / good().count().max(1) as f64).sqrt()))
}

const ITERATIONS: usize = 20;

/// For each point the median change of its distances to the other points, from `from` to `to`. If the scale
/// is free, the distances in `from` are scaled by the median ratio first. Infinite for points that were not
/// seen.
fn distance_errors(from: &[DVec3], to: &[DVec3], with_scale: bool) -> Vec<f64> {
    let valid: Vec<usize> = (0..from.len()).filter(|&i| seen(from[i]) && seen(to[i])).collect();
    let distances = |i: usize| {
        let others = valid.iter().filter(move |&&j| j != i);
        others.map(move |&j| (from[i].distance(from[j]), to[i].distance(to[j])))
    };
    let scale = if with_scale {
        let pairs = valid.iter().flat_map(|&i| distances(i)).filter(|(a, _)| *a > 0.0);
        median(&mut pairs.map(|(a, b)| b / a).collect::<Vec<_>>())
    } else {
        1.0
    };
    let mut errors = vec![f64::INFINITY; from.len()];
    for &i in &valid {
        errors[i] = median(&mut distances(i).map(|(a, b)| (b - scale * a).abs()).collect::<Vec<_>>());
    }
    errors
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(n: usize) -> Vec<DVec3> {
        // Halton's sequence: spread evenly, and the same every time.
        let halton = |mut i: usize, base: usize| {
            let (mut f, mut r) = (1.0, 0.0);
            while i > 0 {
                f /= base as f64;
                r += f * (i % base) as f64;
                i /= base;
            }
            r
        };
        (1..=n).map(|i| DVec3::new(halton(i, 2), halton(i, 3), halton(i, 5)) * 10.0).collect()
    }

    fn motion(scale: f64) -> Similarity {
        let rotation = DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 2.0);
        Similarity { scale, rotation, translation: DVec3::new(3.0, 150.0, -7.0) }
    }

    fn check(found: &Similarity, expected: &Similarity, tolerance: f64) {
        for p in cloud(8) {
            assert!(found.apply(p).distance(expected.apply(p)) < tolerance, "{found:?} {expected:?}");
        }
    }

    #[test]
    fn an_exact_motion_is_found() {
        for (n, scale) in [(3, 1.0), (4, 1.0), (20, 0.93), (5, 0.001)] {
            let from = cloud(n);
            let to: Vec<DVec3> = from.iter().map(|p| motion(scale).apply(*p)).collect();
            check(&fit(&from, &to, &vec![1.0; n], true).unwrap(), &motion(scale), 1e-9);
            if scale == 1.0 {
                check(&fit(&from, &to, &vec![1.0; n], false).unwrap(), &motion(scale), 1e-9);
            }
        }
    }

    #[test]
    fn mirrored_points_are_turned_and_not_mirrored() {
        let from = cloud(10);
        let to: Vec<DVec3> = from.iter().map(|p| DVec3::new(-p.x, p.y, p.z)).collect();
        let found = fit(&from, &to, &[1.0; 10], false).unwrap();
        assert!((DMat3::from_quat(found.rotation).determinant() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn points_on_a_line_and_too_few_points_have_no_fit() {
        let line: Vec<DVec3> = (0..5).map(|i| DVec3::new(1.0, 2.0, 3.0) * f64::from(i)).collect();
        assert!(fit(&line, &line, &[1.0; 5], false).is_none());
        let two = [DVec3::X, DVec3::Y, DVec3::NAN];
        assert!(fit(&two, &two, &[1.0; 3], false).is_none());
        assert!(fit(&two[..2], &two[..2], &[1.0; 2], true).is_none());
    }

    #[test]
    fn a_third_of_bad_points_changes_nothing() {
        for (n, bad, scale) in [(4, 1, 1.0), (30, 9, 1.0), (30, 9, 0.93)] {
            let from = cloud(n);
            let mut to: Vec<DVec3> = from.iter().map(|p| motion(scale).apply(*p)).collect();
            (0..bad).for_each(|i| to[i] += cloud(20)[10 + i] * 0.7);
            to[n - 1] = if n > 4 { DVec3::NAN } else { to[n - 1] };
            let (found, rms) = fit_robustly(&from, &to, scale != 1.0, 0.01).unwrap();
            check(&found, &motion(scale), 1e-3);
            assert!(rms < 1e-3, "{rms}");
        }
    }

    #[test]
    fn weights_count() {
        let from = cloud(4);
        let mut to = from.clone();
        to[0] += DVec3::new(0.0, 0.0, 1.0);
        let even = fit(&from, &to, &[1.0; 4], false).unwrap();
        let found = fit(&from, &to, &[1e-9, 1.0, 1.0, 1.0], false).unwrap();
        check(&found, &Similarity::IDENTITY, 1e-6);
        assert!(even.apply(from[1]).distance(from[1]) > 0.05);
    }

    #[test]
    fn inverse_and_composition() {
        let (a, b) = (motion(2.0), motion(0.3).inverse());
        for p in cloud(5) {
            assert!(a.inverse().apply(a.apply(p)).distance(p) < 1e-12);
            assert!(a.after(&b).apply(p).distance(a.apply(b.apply(p))) < 1e-9);
        }
    }
}
