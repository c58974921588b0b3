//! Non-negative least squares: how much of a motion is expressions.
use glam::DVec3;

/// Rounds of coordinate descent.
const ROUNDS: usize = 200;

/// From 0 to 1: the part of the squares of `displacements` that the best sum of examples explains. Each
/// example counts from 0 upwards, since no face shows less than none of an expression.
pub(crate) fn explained(displacements: &[DVec3], examples: &[(String, Vec<DVec3>)]) -> f64 {
    let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
    let whole = dot(displacements, displacements);
    let shown: Vec<&Vec<DVec3>> = examples.iter().map(|(_, shown)| shown).collect();
    let gram: Vec<Vec<f64>> = shown.iter().map(|a| shown.iter().map(|b| dot(a, b)).collect()).collect();
    let along: Vec<f64> = shown.iter().map(|shown| dot(shown, displacements)).collect();
    let mut weights = vec![0.0; shown.len()];
    for _ in 0..ROUNDS {
        for k in 0..weights.len() {
            let others: f64 = (0..weights.len()).filter(|&l| l != k).map(|l| gram[k][l] * weights[l]).sum();
            if gram[k][k] > 0.0 {
                weights[k] = ((along[k] - others) / gram[k][k]).max(0.0);
            }
        }
    }
    // At the best weights, the squares that remain are the whole minus this sum.
    let explained: f64 = weights.iter().zip(&along).map(|(weight, along)| weight * along).sum();
    if whole > 0.0 { (explained / whole).clamp(0.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_count_forwards_only() {
        let examples = [
            ("a".to_owned(), vec![DVec3::X, DVec3::ZERO]),
            ("b".to_owned(), vec![DVec3::new(1.0, 1.0, 0.0), DVec3::ZERO]),
        ];
        let of = |x: f64, y: f64, z: f64| explained(&[DVec3::new(x, y, 0.0), DVec3::Z * z], &examples);
        // Worked out by hand: 2 a + b; b alone explains half of the squares of y; nothing explains −x.
        assert!((of(3.0, 1.0, 0.0) - 1.0).abs() < 1e-9);
        assert!((of(0.0, 1.0, 0.0) - 0.5).abs() < 1e-9);
        assert!((of(3.0, 0.0, 3.0) - 0.5).abs() < 1e-9);
        assert_eq!((of(-1.0, 0.0, 0.0), of(0.0, 0.0, 0.0)), (0.0, 0.0));
        assert_eq!(explained(&[DVec3::X], &[]), 0.0);
    }
}
