//! A thin shell that is drawn towards targets instead of being held at handles. It lays one face over
//! another.
use crate::system::System;
use rhytid_core::{Error, Progress, Result, Table};
use rhytid_geometry::cholesky::Columns;
use rhytid_geometry::cholesky::Dissection;
use rhytid_geometry::cholesky::Factor;
use rhytid_geometry::cholesky::dissect;
use rhytid_geometry::laplacian::laplacian;

/// The linear thin shell of section 2, drawn towards targets.
///
/// The displacement `u` minimises `∫ ‖∇u‖² + ℓ² ‖Δu‖² + Σ_v w_v ‖u_v − t_v‖²`. So it solves
/// `(A + diag w) u = w t`, with the matrix A of the basis.
///
/// ```
/// use rhytid_core::{NoProgress, Table};
/// use rhytid_solve::SoftShell;
///
/// // A strip of four vertices, held at one end and drawn up at the other.
/// let rest = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]];
/// let shell = SoftShell::new(&rest, &[[0, 2, 1], [1, 2, 3]], &[true; 4], 0.5);
/// let up = [0.0, 0.0, 1.0];
/// let targets = Table::new(4, 1, vec![[0.0; 3], [0.0; 3], [0.0; 3], up]);
/// let moved = shell.drawn(&[1e6, 1e6, 0.0, 1e6], &targets, &NoProgress)?.into_vec();
/// assert!(moved[0][2].abs() < 1e-3 && (moved[3][2] - 1.0).abs() < 1e-3 && moved[2][2] > 0.3);
/// # Ok::<(), rhytid_core::Error>(())
/// ```
pub struct SoftShell {
    matrix: Columns,
    dissection: Dissection,
    vertices: usize,
}

impl SoftShell {
    /// A shell of V rest positions and their triangles, with ℓ in mesh units. Vertices for which `moves` is
    /// false take no part and stay.
    pub fn new(rest: &[[f64; 3]], triangles: &[[u32; 3]], moves: &[bool], bending_length: f64) -> Self {
        let system = System::new(laplacian(rest, triangles), bending_length);
        let moving = (0..rest.len() as u32).filter(|&v| moves[v as usize] && system.mass(v) > 0.0).collect();
        let dissection = dissect(rest, system.pattern(), moving);
        Self { matrix: system.lower(&dissection.order), dissection, vertices: rest.len() }
    }

    /// V×n displacements in mesh units. Each vertex is drawn towards its row of n `targets` by its weight.
    /// The V weights are at least 0.
    ///
    /// # Errors
    /// [`Error::Input`] if a part that moves has no weight, because its place is then undetermined.
    /// [`Error::Internal`] if there are not V weights and V rows of targets. [`Error::Cancelled`].
    pub fn drawn(
        &self,
        weights: &[f64],
        targets: &Table<[f64; 3]>,
        progress: &dyn Progress,
    ) -> Result<Table<[f64; 3]>> {
        let n = targets.columns();
        if weights.len() != self.vertices || targets.height() != self.vertices {
            return Err(Error::Internal("a shell is drawn by a weight and n targets for each vertex".into()));
        }
        let Dissection { order, root } = &self.dissection;
        let mut matrix = self.matrix.clone();
        let mut x = Vec::with_capacity(3 * n * order.len());
        for (j, &v) in order.iter().enumerate() {
            let weight = weights[v as usize];
            // Rows ascend in each column of the lower triangle, so the first entry is the diagonal.
            matrix.values[matrix.offsets[j]] += weight;
            x.extend(targets.row(v as usize).as_flattened().iter().map(|t| weight * t));
        }
        let mut moved = Table::filled(self.vertices, n, [0.0; 3]);
        if n > 0 && !order.is_empty() {
            Factor::new(&matrix, root, progress)?.solve(&mut x, 3 * n);
            let of_vertices = order.iter().zip(x.as_chunks::<3>().0.chunks_exact(n));
            of_vertices.for_each(|(&v, u)| moved.row_mut(v as usize).copy_from_slice(u));
        }
        Ok(moved)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::basis;
    use rhytid_core::{NoProgress, SurfacePoint, VertexId};

    /// A bent sheet of n × n vertices.
    fn sheet(n: usize) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
        let at = |v: usize| {
            let (x, y) = ((v % n) as f64, (v / n) as f64);
            [x, y + 0.1 * x, 0.05 * x * x]
        };
        let quads = (0..n - 1).flat_map(|j| (0..n - 1).map(move |i| (j * n + i) as u32));
        let n32 = n as u32;
        let triangles = quads.flat_map(|a| [[a, a + 1, a + n32], [a + 1, a + n32 + 1, a + n32]]).collect();
        ((0..n * n).map(at).collect(), triangles)
    }

    #[test]
    fn drawn_hard_at_handles_it_is_the_basis() {
        let (rest, triangles) = sheet(9);
        let handles = [0, 8, 40, 77].map(VertexId);
        let moves = vec![true; rest.len()];
        let expected = basis(
            &rest,
            laplacian(&rest, &triangles),
            &handles.map(SurfacePoint::from),
            &moves,
            2.0,
            &NoProgress,
        )
        .unwrap();
        let (mut weights, mut targets) = (vec![0.0; rest.len()], vec![[0.0; 3]; rest.len()]);
        for (h, v) in handles.iter().enumerate() {
            weights[v.index()] = 1e9;
            targets[v.index()] = [h as f64, 1.0, 0.5 * h as f64 * h as f64];
        }
        let shell = SoftShell::new(&rest, &triangles, &moves, 2.0);
        let column = |targets: &[[f64; 3]]| Table::new(targets.len(), 1, targets.to_vec());
        let found = shell.drawn(&weights, &column(&targets), &NoProgress).unwrap();
        // Two fields at once are the same as one after the other.
        let twice = targets.iter().flat_map(|t| [*t, t.map(|x| -x)]).collect();
        let twice = Table::new(targets.len(), 2, twice);
        for (both, u) in shell.drawn(&weights, &twice, &NoProgress).unwrap().rows().zip(found.as_slice()) {
            (0..3).for_each(|c| assert!((both[0][c] - u[c]).abs() + (both[1][c] + u[c]).abs() < 1e-9));
        }
        for (v, u) in found.as_slice().iter().enumerate() {
            for c in 0..3 {
                let row = expected.row(v).iter().zip(handles);
                let of_basis: f64 = row.map(|(b, h)| b * targets[h.index()][c]).sum();
                assert!((u[c] - of_basis).abs() < 1e-6, "vertex {v}: {} instead of {of_basis}", u[c]);
            }
        }
    }

    #[test]
    fn what_nothing_draws_and_what_takes_no_part() {
        let (rest, triangles) = sheet(4);
        let none = SoftShell::new(&rest, &triangles, &[true; 16], 1.0);
        let filled = |x: f64| Table::filled(16, 1, [x; 3]);
        assert!(none.drawn(&[0.0; 16], &filled(0.0), &NoProgress).is_err());
        assert!(none.drawn(&[0.0; 15], &filled(0.0), &NoProgress).is_err());
        let nobody = SoftShell::new(&rest, &triangles, &[false; 16], 1.0);
        assert_eq!(nobody.drawn(&[1.0; 16], &filled(9.0), &NoProgress).unwrap(), filled(0.0));
    }
}
