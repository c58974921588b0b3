//! The rotation nearest to a correlation of points, by Horn's quaternion (B. K. P. Horn, *Closed-form
//! solution of absolute orientation using unit quaternions*, 1987). The result is never a reflection.

/// The result of Horn's symmetric 4×4 matrix for a correlation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Horn {
    /// The best rotation as a unit quaternion: w, x, y, z.
    pub quaternion: [f64; 4],
    /// tr(Rᵀ M) of the best rotation R: the largest eigenvalue.
    pub largest: f64,
    /// The second largest eigenvalue. Where it is equal to the largest, the best rotation is not unique: the
    /// points lie on a line.
    pub second: f64,
}

/// The rotation R with the largest tr(Rᵀ M), where M = Σ b aᵀ for points a that R takes to b, both about
/// their centroids.
pub fn horn(m: &[[f64; 3]; 3]) -> Horn {
    let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = *m;
    let mut matrix = [
        [xx + yy + zz, zy - yz, xz - zx, yx - xy],
        [zy - yz, xx - yy - zz, xy + yx, zx + xz],
        [xz - zx, xy + yx, yy - xx - zz, yz + zy],
        [yx - xy, zx + xz, yz + zy, zz - xx - yy],
    ];
    let vectors = diagonalize(&mut matrix);
    let value = |i: usize| matrix[i][i];
    let best = (0..4).fold(0, |best, i| if value(i) > value(best) { i } else { best });
    let others = (0..4).filter(|&i| i != best).map(value);
    let length = vectors[best].iter().map(|x| x * x).sum::<f64>().sqrt();
    Horn {
        quaternion: vectors[best].map(|x| x / length),
        largest: value(best),
        second: others.fold(f64::NEG_INFINITY, f64::max),
    }
}

/// R − I of the rotation R of [`horn`]. It is exactly 0 for a symmetric matrix without negative eigenvalues.
pub fn nearest_turn(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let [w, x, y, z] = horn(m).quaternion;
    [
        [-2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), -2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), -2.0 * (x * x + y * y)],
    ]
}

/// Makes a symmetric matrix diagonal and gives its eigenvectors: row i is the one of `a[i][i]`. By Jacobi's
/// rotations, which converge quadratically.
fn diagonalize(a: &mut [[f64; 4]; 4]) -> [[f64; 4]; 4] {
    const SWEEPS: usize = 12;
    let mut vectors = [[0.0; 4]; 4];
    (0..4).for_each(|i| vectors[i][i] = 1.0);
    for _ in 0..SWEEPS {
        let mut is_diagonal = true;
        for p in 0..3 {
            for q in p + 1..4 {
                let (app, aqq, apq) = (a[p][p], a[q][q], a[p][q]);
                if apq.abs() <= f64::EPSILON * f64::EPSILON * (app.abs() + aqq.abs()) {
                    continue;
                }
                is_diagonal = false;
                let theta = (aqq - app) / (2.0 * apq);
                let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                for row in a.iter_mut() {
                    let (x, y) = (row[p], row[q]);
                    (row[p], row[q]) = (c * x - s * y, s * x + c * y);
                }
                for i in 0..4 {
                    let (x, y) = (a[p][i], a[q][i]);
                    (a[p][i], a[q][i]) = (c * x - s * y, s * x + c * y);
                    let (x, y) = (vectors[p][i], vectors[q][i]);
                    (vectors[p][i], vectors[q][i]) = (c * x - s * y, s * x + c * y);
                }
                (a[p][q], a[q][p]) = (0.0, 0.0);
            }
        }
        if is_diagonal {
            break;
        }
    }
    vectors
}
