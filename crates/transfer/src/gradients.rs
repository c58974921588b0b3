//! Deformation gradients: how a deformed surface turns, grows and stretches at each vertex.
use glam::DMat3;
use glam::DVec3;
use rayon::prelude::*;
use rhytid_kernels::normals::VertexTriangles;

/// The most steps of Higham's iteration, which converges quadratically.
const STEPS: usize = 24;

/// The deformation of a surface at a vertex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Local {
    /// Its rotation.
    pub rotation: DMat3,
    /// Its growth in length, the mean of all directions, as a ratio.
    pub scale: f64,
    /// σ₁/σ₂, 1 or more: the ratio of the largest growth to that across it.
    pub anisotropy: f64,
}

/// The area and the gradient of a triangle. Along the normal, the gradient is the square root of the ratio of
/// areas. `None` where the triangle has no area before or after.
fn of_triangle(from: [DVec3; 3], to: [DVec3; 3]) -> Option<(f64, DMat3)> {
    let frame = |[a, b, c]: [DVec3; 3]| {
        let (e, f) = (b - a, c - a);
        let cross = e.cross(f);
        let area = cross.length();
        (area > 1e-12 * e.length_squared().max(f.length_squared())).then_some((e, f, cross / area, area))
    };
    let (e, f, n, area) = frame(from)?;
    let (e1, f1, n1, area1) = frame(to)?;
    let before = DMat3::from_cols(e, f, n);
    let after = DMat3::from_cols(e1, f1, n1 * (area1 / area).sqrt());
    Some((area, after * before.inverse()))
}

/// V gradients: the mean of the triangles at each vertex, by area. A vertex without any has `otherwise`.
pub(crate) fn gradients(
    from: &[DVec3],
    to: &[DVec3],
    triangles: &[[u32; 3]],
    at_vertices: &VertexTriangles,
    otherwise: DMat3,
) -> Vec<DMat3> {
    let corners = |points: &[DVec3], t: u32| triangles[t as usize].map(|v| points[v as usize]);
    let of_vertex = |v: usize| {
        let (mut sum, mut whole) = (DMat3::ZERO, 0.0);
        for &t in at_vertices.at(v) {
            if let Some((area, gradient)) = of_triangle(corners(from, t), corners(to, t)) {
                sum += gradient * area;
                whole += area;
            }
        }
        if whole > 0.0 { sum * (1.0 / whole) } else { otherwise }
    };
    (0..from.len()).into_par_iter().map(of_vertex).collect()
}

/// The deformation of a gradient. `None` where the gradient turns the surface inside out.
pub(crate) fn local(gradient: DMat3) -> Option<Local> {
    let determinant = gradient.determinant();
    if !(determinant > 0.0 && determinant.is_finite()) {
        return None;
    }
    let scale = determinant.cbrt();
    // The polar decomposition (Higham 1986): the mean of a matrix and the transpose of its inverse tends to
    // the rotation.
    let mut rotation = gradient * (1.0 / scale);
    for _ in 0..STEPS {
        let next = (rotation + rotation.inverse().transpose()) * 0.5;
        let change = (next - rotation).to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max);
        rotation = next;
        if change < 1e-14 {
            break;
        }
    }
    // Along the normal the gradient is the scale. So the rest of the trace is σ₁² + σ₂² with σ₁ σ₂ = 1.
    let squares: f64 = gradient.to_cols_array().iter().map(|x| x * x).sum::<f64>() / (scale * scale);
    let half = (0.5 * (squares - 1.0)).max(1.0);
    Some(Local { rotation, scale, anisotropy: half + (half * half - 1.0).sqrt() })
}

/// The triangles that are turned over, compared with the rotation of the surface around them.
pub(crate) fn turned_over(
    from: &[DVec3],
    to: &[DVec3],
    triangles: &[[u32; 3]],
    gradients: &[DMat3],
    counts: impl Fn(&[u32; 3]) -> bool,
) -> Vec<usize> {
    let normal = |points: &[DVec3], t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| points[v as usize]);
        (b - a).cross(c - a)
    };
    let is_over = |t: &[u32; 3]| {
        let around = t.iter().map(|&v| gradients[v as usize]).fold(DMat3::ZERO, |sum, g| sum + g);
        (around * normal(from, t)).dot(normal(to, t)) < 0.0
    };
    (0..triangles.len()).filter(|&t| counts(&triangles[t]) && is_over(&triangles[t])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn what_was_done_is_found() {
        // A sheet, stretched by 1.2 along x and 0.9 along y, made 3 times as large and turned.
        let at = |i: usize| DVec3::new((i % 5) as f64, (i / 5) as f64, 0.0);
        let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), 2.0));
        let from: Vec<DVec3> = (0..25).map(at).collect();
        let stretch = DMat3::from_diagonal(DVec3::new(1.2, 0.9, 1.0));
        let to: Vec<DVec3> = from.iter().map(|p| turn * (3.0 * (stretch * *p)) + DVec3::ONE).collect();
        let quads = (0..4_u32).flat_map(|j| (0..4).map(move |i| 5 * j + i));
        let triangles: Vec<[u32; 3]> = quads.flat_map(|a| [[a, a + 1, a + 6], [a, a + 6, a + 5]]).collect();
        let at_vertices = VertexTriangles::new(25, &triangles);
        let found = gradients(&from, &to, &triangles, &at_vertices, DMat3::IDENTITY);
        for gradient in &found {
            let local = local(*gradient).unwrap();
            assert!((local.rotation - turn).to_cols_array().iter().all(|x| x.abs() < 1e-12));
            assert!((local.scale - 3.0 * (1.2_f64 * 0.9).sqrt()).abs() < 1e-12);
            assert!((local.anisotropy - 1.2 / 0.9).abs() < 1e-12, "{}", local.anisotropy);
        }
        assert!(turned_over(&from, &to, &triangles, &found, |_| true).is_empty());
        // A vertex pulled over its neighbours turns triangles over.
        let mut folded = to.clone();
        folded[12] = to[14];
        let found = gradients(&from, &folded, &triangles, &at_vertices, DMat3::IDENTITY);
        assert!(!turned_over(&from, &folded, &triangles, &found, |_| true).is_empty());
    }

    #[test]
    fn what_is_inside_out_is_nothing() {
        assert_eq!(local(DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0))), None);
        assert_eq!(local(DMat3::ZERO), None);
    }
}
