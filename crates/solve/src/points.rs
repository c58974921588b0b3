//! Handles inside triangles: what holds at a vertex must hold at the mean of three.
use crate::basis::solve_columns;
use crate::system::{NONE, System};
use faer::Mat;
use faer::linalg::solvers::Solve;
use rayon::prelude::*;
use rhytid_core::{Error, Progress, Result, SurfacePoint, Table, VertexId};
use rhytid_geometry::cholesky::{Columns, Factor};

/// The basis is the identity at each handle to within this.
const MET: f64 = 1e-7;

/// The vertices at which the basis is solved first: of each handle, the corner with the greatest weight.
pub(crate) fn held(handles: &[SurfacePoint]) -> Vec<VertexId> {
    let mut held = Vec::with_capacity(handles.len());
    for vertex in handles.iter().map(SurfacePoint::nearest_vertex) {
        if !held.contains(&vertex) {
            held.push(vertex);
        }
    }
    held
}

/// The basis of handles at any points, V×H, from the basis of the C vertices `held`, V×C.
///
/// Let q be the positions of the held vertices, B the given basis and E the weights of the corners, H×V. All
/// surfaces are `B q + y`, with y = 0 at the held vertices. Their energies are `qᵀ S q + yᵀ A_ff y`. Here S
/// are the rows and columns of `A B` at the held vertices. The handles at p ask for `E (B q + y) = p`. So the
/// least energy has
///
/// ```text
/// y = G λ        G = A_ff⁻¹ E_fᵀ
/// [ S     −(EB)ᵀ ] [q]   [0]
/// [ EB     E_f G ] [λ] = [p]
/// ```
///
/// # Errors
/// [`Error::Input`] if the handles cannot all be met; [`Error::Cancelled`].
pub(crate) fn from_vertices_to_points(
    system: &System,
    factor: &Factor,
    order: &[u32],
    held: &[VertexId],
    handles: &[SurfacePoint],
    basis: &Table<f64>,
    progress: &dyn Progress,
) -> Result<Table<f64>> {
    let place = system.places(order);
    let (vertices, c, h) = (basis.height(), held.len(), handles.len());
    let mut right = Columns::default();
    for point in handles {
        let corners = point.corners().map(|(v, weight)| (place[v.index()], weight));
        let mut free: Vec<(u32, f64)> = corners.filter(|(place, _)| *place != NONE).collect();
        free.sort_unstable_by_key(|(place, _)| *place);
        right.push(free);
    }
    let mut compliance = Table::filled(vertices, h, 0.0);
    solve_columns(system, factor, order, &right, &mut compliance, progress)?;

    let stiffness = stiffness(system, held, basis);
    let scale = (0..c).map(|i| stiffness.row(i)[i].abs()).fold(0.0, f64::max);
    let scale = if scale > 0.0 { scale } else { 1.0 };
    let at_handles = weighted(handles, basis);
    let of_forces = weighted(handles, &compliance);
    let matrix = Mat::from_fn(c + h, c + h, |i, j| match (i < c, j < c) {
        (true, true) => stiffness.row(i)[j] / scale,
        (true, false) => -at_handles.row(j - c)[i],
        (false, true) => at_handles.row(i - c)[j],
        (false, false) => scale * of_forces.row(i - c)[j - c],
    });
    let right = Mat::from_fn(c + h, h, |i, j| f64::from(u8::from(i == c + j)));
    let solved = matrix.partial_piv_lu().solve(&right);
    // q, then λ, in rows.
    let of_row = |i: usize| if i < c { 1.0 } else { scale };
    let solved =
        (0..c + h).flat_map(|i| (0..h).map(move |j| (i, j))).map(|(i, j)| of_row(i) * solved[(i, j)]);
    let solved = Table::new(c + h, h, solved.collect());

    let mut moved = Table::filled(vertices, h, 0.0);
    let rows = moved.par_rows_mut().zip(basis.par_rows()).zip(compliance.par_rows());
    rows.for_each(|((row, of_held), of_forces)| {
        for (weight, of_weight) in of_held.iter().chain(of_forces).zip(solved.rows()) {
            if *weight != 0.0 {
                row.iter_mut().zip(of_weight).for_each(|(x, solved)| *x += weight * solved);
            }
        }
    });
    // A vertex meets its marker to the last bit.
    for (i, v) in handles.iter().enumerate().filter_map(|(i, point)| Some((i, point.vertex()?))) {
        let row = moved.row_mut(v.index());
        row.fill(0.0);
        row[i] = 1.0;
    }
    let met = weighted(handles, &moved);
    let off = |i: usize, j: usize| (met.row(i)[j] - f64::from(u8::from(i == j))).abs();
    match (0..h).find(|&i| !(0..h).all(|j| off(i, j) <= MET)) {
        None => Ok(moved),
        Some(i) => Err(Error::not_solvable(format!(
            "the handle in the triangle of {} cannot be met together with the handles around it: they are too many, \
             or too near each other, for the vertices there",
            handles[i]
        ))),
    }
}

/// S, C×C.
fn stiffness(system: &System, held: &[VertexId], basis: &Table<f64>) -> Table<f64> {
    let mut stiffness = Table::filled(held.len(), held.len(), 0.0);
    stiffness.par_rows_mut().zip(held).for_each(|(row, v)| {
        // A vertex without a face resists nothing.
        if system.mass(v.0) > 0.0 {
            let mut values = Vec::new();
            system.row(v.0, &mut values);
            for (w, value) in system.pattern().neighbors(v.0).iter().zip(values) {
                row.iter_mut().zip(basis.row(*w as usize)).for_each(|(sum, b)| *sum += value * b);
            }
        }
    });
    stiffness
}

/// The mean of the rows at the corners of each handle, H×n, by their weights.
fn weighted(handles: &[SurfacePoint], rows: &Table<f64>) -> Table<f64> {
    let mut weighted = Table::filled(handles.len(), rows.columns(), 0.0);
    for (point, sum) in handles.iter().zip(weighted.rows_mut()) {
        for (v, weight) in point.corners() {
            sum.iter_mut().zip(rows.row(v.index())).for_each(|(sum, x)| *sum += weight * x);
        }
    }
    weighted
}

/// Fields that are zero at all handles.
pub(crate) struct Zeroed {
    vertices: Vec<VertexId>,
    /// The corners of each handle inside a triangle that are no handles themselves, with their weights.
    corners: Vec<Vec<(VertexId, f64)>>,
    /// `(E Eᵀ)⁻¹` over these corners.
    inverse: Mat<f64>,
}

impl Zeroed {
    pub(crate) fn new(handles: &[SurfacePoint]) -> Self {
        let vertices: Vec<VertexId> = handles.iter().filter_map(SurfacePoint::vertex).collect();
        let inside = handles.iter().filter(|point| point.vertex().is_none());
        let free = |point: &SurfacePoint| point.corners().filter(|(v, _)| !vertices.contains(v)).collect();
        let corners: Vec<Vec<(VertexId, f64)>> = inside.map(free).collect();
        let product = |a: &[(VertexId, f64)], b: &[(VertexId, f64)]| -> f64 {
            let pairs = a.iter().flat_map(|a| b.iter().map(move |b| (a, b)));
            pairs.filter(|(a, b)| a.0 == b.0).map(|(a, b)| a.1 * b.1).sum()
        };
        let n = corners.len();
        let products = Mat::from_fn(n, n, |i, j| product(&corners[i], &corners[j]));
        let inverse = products.partial_piv_lu().solve(Mat::<f64>::identity(n, n));
        Self { vertices, corners, inverse }
    }

    /// Changes a field of V×n vectors as little as it takes, by the sum of squares: only at the corners.
    pub(crate) fn apply(&self, field: &mut Table<[f64; 3]>) {
        self.vertices.iter().for_each(|v| field.row_mut(v.index()).fill([0.0; 3]));
        let n = field.columns();
        let mut off = Table::filled(self.corners.len(), 3 * n, 0.0);
        for (corners, off) in self.corners.iter().zip(off.rows_mut()) {
            for (v, weight) in corners {
                let of_vertex = field.row(v.index()).as_flattened();
                off.iter_mut().zip(of_vertex).for_each(|(off, x)| *off += weight * x);
            }
        }
        for (i, corners) in self.corners.iter().enumerate() {
            for (j, off) in off.rows().enumerate() {
                let inverse = self.inverse[(i, j)];
                if inverse != 0.0 {
                    for (v, weight) in corners {
                        let of_vertex = field.row_mut(v.index()).as_flattened_mut();
                        of_vertex.iter_mut().zip(off).for_each(|(x, off)| *x -= weight * inverse * off);
                    }
                }
            }
        }
    }
}
