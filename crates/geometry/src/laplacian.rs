//! Section 1: the cotangent Laplacian and the mixed Voronoi areas.
use glam::DVec3;
use rayon::prelude::*;

/// A triangle counts as having no area if the ratio of its height to its longest edge is below this. The
/// limit is about ten times the ratio that float32 makes of three points on a line. The cotangents of such a
/// triangle would be a million, and the system's condition as bad as their square.
const FLAT: f64 = 1e-6;

/// Whether the triangle `abc` has no area.
pub fn is_degenerate([a, b, c]: [DVec3; 3]) -> bool {
    let sides = [b - a, c - b, a - c].map(DVec3::length_squared);
    let longest = sides[0].max(sides[1]).max(sides[2]);
    let twice_area = (b - a).cross(c - a).length();
    twice_area <= FLAT * longest || twice_area.is_nan()
}

/// C and M of a triangle mesh; `Δ = M⁻¹ C`.
#[derive(Debug, Clone, PartialEq)]
pub struct Laplacian {
    /// The strictly upper part of C: `(i, j, w_ij)` with i < j, sorted, one entry per edge.
    pub edges: Vec<(u32, u32, f64)>,
    /// The diagonal of C: `−Σ_j w_ij`.
    pub diagonal: Vec<f64>,
    /// M: the mixed Voronoi area of each vertex in mesh units squared; 0 without a triangle that has an area.
    pub mass: Vec<f64>,
}

/// Assembles the Laplacian of V `positions` and `triangles`. Triangles without area add nothing; boundaries
/// are natural.
pub fn laplacian(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Laplacian {
    let mut mass = vec![0.0; positions.len()];
    let mut parts = Vec::with_capacity(triangles.len() * 3);
    for triangle in triangles {
        let p = triangle.map(|v| DVec3::from_array(positions[v as usize]));
        if is_degenerate(p) {
            continue;
        }
        let twice_area = (p[1] - p[0]).cross(p[2] - p[0]).length();
        let dots: [f64; 3] = std::array::from_fn(|i| (p[(i + 1) % 3] - p[i]).dot(p[(i + 2) % 3] - p[i]));
        let obtuse = dots.iter().position(|&d| d < 0.0);
        for i in 0..3 {
            // The cotangent at corner i belongs to the opposite edge (j, k).
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let cotangent = dots[i] / twice_area;
            let (a, b) = (triangle[j].min(triangle[k]), triangle[j].max(triangle[k]));
            parts.push((a, b, 0.5 * cotangent));
            match obtuse {
                None => {
                    let share = cotangent * (p[j] - p[k]).length_squared() / 8.0;
                    mass[triangle[j] as usize] += share;
                    mass[triangle[k] as usize] += share;
                }
                Some(corner) => {
                    let share = if corner == i { 0.25 } else { 0.125 };
                    mass[triangle[i] as usize] += share * twice_area;
                }
            }
        }
    }
    // A stable sort keeps the triangles' order within an edge, and with it the order of the sum.
    parts.par_sort_by_key(|&(a, b, _)| (a, b));
    let mut diagonal = vec![0.0; positions.len()];
    let mut edges: Vec<(u32, u32, f64)> = Vec::with_capacity(parts.len() / 2 + 1);
    for (a, b, w) in parts {
        match edges.last_mut() {
            Some(last) if (last.0, last.1) == (a, b) => last.2 += w,
            _ => edges.push((a, b, w)),
        }
    }
    for &(a, b, w) in &edges {
        diagonal[a as usize] -= w;
        diagonal[b as usize] -= w;
    }
    Laplacian { edges, diagonal, mass }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_on_a_line_have_no_area() {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.1 * x + 0.2 * y);
        assert!(is_degenerate([p(0.1, 0.1), p(0.2, 0.2), p(0.3, 0.3)]));
        assert!(is_degenerate([p(1.0, 1.0); 3]));
        assert!(!is_degenerate([p(0.0, 0.0), p(1.0, 0.0), p(0.5, 1e-5)]));
    }

    #[test]
    fn areas_add_up_and_linear_functions_are_harmonic_inside() {
        // A fan of six triangles in a plane, two of them obtuse, around an off-centre vertex 0.
        let mut positions = vec![[0.3, -0.2, 0.0]];
        positions.extend((0..6).map(|i| {
            let a = f64::from(i) * std::f64::consts::TAU / 6.0;
            [2.0 * a.cos(), a.sin(), 0.0]
        }));
        let triangles: Vec<[u32; 3]> = (0..6).map(|i| [0, 1 + i, 1 + (i + 1) % 6]).collect();
        let l = laplacian(&positions, &triangles);
        let area = 0.5 * 2.0 * (std::f64::consts::TAU / 6.0).sin() * 6.0;
        assert!((l.mass.iter().sum::<f64>() - area).abs() < 1e-12);
        for value in [|p: [f64; 3]| p[0], |p: [f64; 3]| p[1]] {
            let value = |v: u32| value(positions[v as usize]);
            let mut sum = l.diagonal[0] * value(0);
            sum += l.edges.iter().filter(|e| e.0 == 0).map(|e| e.2 * value(e.1)).sum::<f64>();
            assert!(sum.abs() < 1e-12, "Δx = {sum}");
        }
    }

    #[test]
    fn right_isosceles_triangle_by_hand() {
        let l = laplacian(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
        for ((a, b, w), expected) in l.edges.iter().zip([(0, 1, 0.5), (0, 2, 0.5), (1, 2, 0.0)]) {
            assert!((*a, *b) == (expected.0, expected.1) && (w - expected.2).abs() < 1e-15);
        }
        for (m, expected) in l.mass.iter().zip([0.25, 0.125, 0.125]) {
            assert!((m - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn a_triangle_without_area_adds_nothing() {
        let positions = [[0.1, 0.1, 0.1], [0.2, 0.2, 0.2], [0.3, 0.3, 0.3]];
        let l = laplacian(&positions, &[[0, 1, 2]]);
        assert!(l.edges.is_empty() && l.mass == [0.0; 3] && l.diagonal == [0.0; 3]);
    }
}
