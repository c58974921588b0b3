//! Least squares with weights from 0 to 1: the w of least `½ wᵀ G w − bᵀ w`, by an active-set method (Stark
//! and Parker, Bounded-variable least squares, 1995).
//!
//! Each weight is at 0, at 1 or free. The free ones solve their part of the normal equations. If a solution
//! is out of bounds, the weights move towards it until the first one is at its bound, and stay there. Then
//! the weight whose gradient points inwards most is freed. No gradient points inwards at the best weights.

use super::linear::solve;
use faer::Mat;

/// Gradients below this part of the largest right side are rounding.
const ROUNDING: f64 = 1e-11;

/// Weights that are freed, for each weight, until the search stops.
const FREED: usize = 8;

/// Where a weight is.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Place {
    Lower,
    Upper,
    Free,
}

/// The best weights, from 0 to 1, for a positive definite `gram` (N×N) and the right side `wanted` (N).
pub(super) fn fit(gram: &Mat<f64>, wanted: &[f64]) -> Vec<f64> {
    let n = wanted.len();
    // The weights without bounds show which of them will be at one.
    let mut weights = solve(gram, wanted.to_vec());
    let place = |w: &f64| match *w {
        w if w > 0.0 && w < 1.0 => Place::Free,
        w if w >= 1.0 => Place::Upper,
        _ => Place::Lower,
    };
    let mut places: Vec<Place> = weights.iter().map(place).collect();
    weights.iter_mut().for_each(|w| *w = if w.is_finite() { w.clamp(0.0, 1.0) } else { 0.0 });
    let least = ROUNDING * wanted.iter().fold(0.0, |most: f64, b| most.max(b.abs()));
    // A weight that went back to its bound at once was freed by rounding alone.
    let mut refused = vec![false; n];
    settle(gram, wanted, &mut weights, &mut places);
    for _ in 0..FREED * n {
        let inwards = |&k: &usize| {
            let gradient = wanted[k] - (0..n).map(|l| gram[(k, l)] * weights[l]).sum::<f64>();
            match places[k] {
                Place::Lower => gradient,
                Place::Upper => -gradient,
                Place::Free => 0.0,
            }
        };
        let candidates = (0..n).filter(|&k| !refused[k] && inwards(&k) > least);
        let Some(k) = candidates.max_by(|a, b| inwards(a).total_cmp(&inwards(b))) else { break };
        let (before, was) = (weights.clone(), places[k]);
        places[k] = Place::Free;
        settle(gram, wanted, &mut weights, &mut places);
        let is_back = places[k] == was && weights == before;
        refused[k] = is_back;
        if !is_back {
            refused.iter_mut().for_each(|refused| *refused = false);
        }
    }
    weights
}

/// Moves the free weights to their best values, as far as the bounds allow.
fn settle(gram: &Mat<f64>, wanted: &[f64], weights: &mut [f64], places: &mut [Place]) {
    loop {
        let free: Vec<usize> = (0..wanted.len()).filter(|&k| places[k] == Place::Free).collect();
        if free.is_empty() {
            return;
        }
        let held = |k: usize| -> f64 {
            let others = (0..wanted.len()).filter(|&l| places[l] == Place::Upper);
            others.map(|l| gram[(k, l)] * weights[l]).sum()
        };
        let right = free.iter().map(|&k| wanted[k] - held(k)).collect();
        let system = Mat::from_fn(free.len(), free.len(), |i, j| gram[(free[i], free[j])]);
        let best = solve(&system, right);
        // How far each weight may move towards its best value.
        let reach = |(&k, &to): (&usize, &f64)| match to {
            to if to < 0.0 => weights[k] / (weights[k] - to),
            to if to > 1.0 => (1.0 - weights[k]) / (to - weights[k]),
            _ => f64::INFINITY,
        };
        let reaches: Vec<f64> = free.iter().zip(&best).map(reach).collect();
        let part = reaches.iter().copied().fold(f64::INFINITY, f64::min);
        if part >= 1.0 {
            free.iter().zip(&best).for_each(|(&k, &to)| weights[k] = to.clamp(0.0, 1.0));
            return;
        }
        for ((&k, &to), reach) in free.iter().zip(&best).zip(&reaches) {
            weights[k] += part * (to - weights[k]);
            if *reach <= part {
                (weights[k], places[k]) = if to < 0.0 { (0.0, Place::Lower) } else { (1.0, Place::Upper) };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The least value over all choices of bounds, for few weights.
    fn by_trial(gram: &Mat<f64>, wanted: &[f64]) -> f64 {
        let n = wanted.len();
        let mut least = f64::INFINITY;
        for choice in 0..3_usize.pow(n as u32) {
            let digit = |k: usize| choice / 3_usize.pow(k as u32) % 3;
            let free: Vec<usize> = (0..n).filter(|&k| digit(k) == 2).collect();
            let mut weights: Vec<f64> = (0..n).map(|k| if digit(k) == 1 { 1.0 } else { 0.0 }).collect();
            let right = |&k: &usize| wanted[k] - (0..n).map(|l| gram[(k, l)] * weights[l]).sum::<f64>();
            let right = free.iter().map(right).collect();
            let solved = solve(&Mat::from_fn(free.len(), free.len(), |i, j| gram[(free[i], free[j])]), right);
            free.iter().zip(solved).for_each(|(&k, w)| weights[k] = w);
            if weights.iter().all(|w| (-1e-12..=1.0 + 1e-12).contains(w)) {
                least = least.min(value(gram, wanted, &weights));
            }
        }
        least
    }

    fn value(gram: &Mat<f64>, wanted: &[f64], weights: &[f64]) -> f64 {
        let along = |k: usize| (0..weights.len()).map(|l| gram[(k, l)] * weights[l]).sum::<f64>();
        (0..weights.len()).map(|k| weights[k] * (0.5 * along(k) - wanted[k])).sum()
    }

    #[test]
    fn no_choice_of_bounds_is_better() {
        let mut state = 7_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
        };
        let mut at_bounds = [0; 3];
        for _ in 0..200 {
            // Shapes that are much alike, so that many weights end at a bound.
            let shapes = Mat::from_fn(9, 5, |_, _| next() + 0.4);
            let gram = shapes.transpose() * &shapes;
            let wanted: Vec<f64> = (0..5).map(|_| 6.0 * next() + 1.0).collect();
            let found = fit(&gram, &wanted);
            assert!(found.iter().all(|w| (0.0..=1.0).contains(w)), "{found:?}");
            let (here, least) = (value(&gram, &wanted, &found), by_trial(&gram, &wanted));
            assert!((here - least).abs() < 1e-9 * (1.0 + least.abs()), "{here} {least} {found:?}");
            for w in found {
                at_bounds[if w == 0.0 {
                    0
                } else if w == 1.0 {
                    1
                } else {
                    2
                }] += 1;
            }
        }
        assert!(at_bounds.iter().all(|&n| n > 100), "{at_bounds:?}");
    }
}
