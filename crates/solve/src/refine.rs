//! Offline refinement of frames with bends for which one rotation per handle is not enough.
//!
//! The shell's energy is minimised with a rotation of its own at every vertex (`docs/method.md`, rotations).
use crate::driven::DrivenComponents;
use crate::system::System;
use rayon::prelude::*;
use rhytid_core::{Error, Progress, Result, Rig, SurfacePoint, VertexId, human, nearest_turn};
use rhytid_geometry::cholesky::Dissection;
use rhytid_geometry::cholesky::Factor;
use rhytid_geometry::cholesky::dissect;
use rhytid_geometry::laplacian;
use rhytid_kernels::vec3;

/// The iteration ends at a step that moves no vertex by more than this part of the handles' spacing.
const STILL: f64 = 1e-4;

/// The most steps.
const MOST_STEPS: usize = 60;

/// ℓ of the refinement, as a part of the rig's ℓ. This part was nearest to both test shapes, a rolled sheet
/// and a bent cylinder.
const BENDING: f64 = 0.25;

/// The refinement of frames of a rig without examples.
///
/// Two steps alternate. The first finds the rotation R_i at each vertex that best takes the edges to its
/// neighbours from the rest pose r to the positions x. The second finds the positions that minimise `Σ_ij
/// w_ij ‖x_i − x_j − R_i (r_i − r_j)‖² + ℓ² Σ_i M_i ‖(Δx)_i − R_i (Δr)_i‖²`, with the handles in their
/// places. One factorisation serves all frames.
///
/// The first term makes the surface as rigid as possible (Sorkine and Alexa 2007). The second makes it stiff
/// in bending, as the shell is. Without it, the surface forms a tip at each handle.
pub struct Refine {
    rest: Vec<[f64; 3]>,
    /// ℓ² times Δr of the rest pose, which the rotations turn.
    bending: Vec<[f64; 3]>,
    system: System,
    factor: Factor,
    /// The vertices that are free, in the factor's order.
    order: Vec<u32>,
    /// V: whether the vertex is free.
    is_free: Vec<bool>,
    handles: Vec<SurfacePoint>,
    /// A step that moves all vertices by less than this is the last, in mesh units.
    still: f64,
    /// The vertices that are not the lowest of their points, each with the lowest.
    copies: Vec<(VertexId, VertexId)>,
}

impl Refine {
    /// The refinement of a rig without examples, with a quarter of its bending length.
    ///
    /// Parts without a handle, and vertices that do not move, stay where frames have them.
    ///
    /// # Errors
    /// As [`Refine::with_bending_length`].
    pub fn new(rig: &Rig<f64>, progress: &dyn Progress) -> Result<Self> {
        Self::with_bending_length(rig, BENDING * rig.bending_length(), progress)
    }

    /// The same, with ℓ in mesh units. With ℓ = 0, only stretching is resisted.
    ///
    /// # Errors
    /// [`Error::Input`] if the rig has examples, which describe the surface better than an energy does. Also
    /// if the system is not positive definite in floating point. [`Error::Cancelled`].
    pub fn with_bending_length(rig: &Rig<f64>, bending_length: f64, progress: &dyn Progress) -> Result<Self> {
        if !rig.examples().is_empty() {
            return Err(Error::conflict(format!(
                "the rig has {}, and refining would replace the detail that was learned from them; refine a \
                 rig without examples",
                human::counted(rig.examples().len(), "example")
            )));
        }
        let (surface, handles) = (rig.surface(), rig.handles());
        let triangles = surface.joined_triangles();
        let mut is_free = DrivenComponents::of_surface(surface, &handles.points).driven;
        // The energy knows points by their lowest vertices.
        surface.copies().for_each(|(v, _)| is_free[v.index()] = false);
        is_free
            .iter_mut()
            .zip(rig.basis().rows())
            .for_each(|(free, row)| *free &= row.iter().any(|b| *b != 0.0));
        handles.held().for_each(|v| is_free[v.index()] = false);
        let free = (0..rig.vertices() as u32).filter(|&v| is_free[v as usize]).collect();
        let system = System::new(laplacian::laplacian(&surface.rest, &triangles), bending_length);
        let Dissection { order, root } = dissect(&surface.rest, system.pattern(), free);
        let factor = Factor::new(&system.lower(&order), &root, progress)?;
        let bending = system.bending(&surface.rest);
        let spacing = handles.feature_lengths().last().copied().unwrap_or(1.0);
        Ok(Self {
            rest: surface.rest.clone(),
            bending,
            system,
            factor,
            order,
            is_free,
            handles: handles.points.clone(),
            still: STILL * spacing,
            copies: surface.copies().collect(),
        })
    }

    /// Refines the V positions of a frame whose H handles are at `handle_positions`. The result is the number
    /// of steps.
    pub fn frame(&self, handle_positions: &[[f64; 3]], positions: &mut [[f64; 3]]) -> usize {
        // The corners of a triangle stay where the frame has them, so a handle inside it stays met.
        for (point, x) in self.handles.iter().zip(handle_positions) {
            if let Some(v) = point.vertex() {
                positions[v.index()] = *x;
            }
        }
        let steps = (1..=MOST_STEPS).find(|_| self.step(positions) < self.still).unwrap_or(MOST_STEPS);
        self.copies.iter().for_each(|(v, first)| positions[v.index()] = positions[first.index()]);
        steps
    }

    /// Computes the rotations and then the positions. The result is the largest distance that a vertex moves.
    fn step(&self, positions: &mut [[f64; 3]]) -> f64 {
        let turns: Vec<[[f64; 3]; 3]> =
            (0..self.rest.len()).into_par_iter().map(|v| self.turn(positions, v)).collect();
        // The right-hand side: the turned rest pose, less the part of the vertices that are not free.
        let turned: Vec<[f64; 3]> =
            turns.par_iter().zip(&self.bending).map(|(turn, b)| applied(turn, *b)).collect();
        let fixed: Vec<[f64; 3]> = positions
            .iter()
            .zip(&self.is_free)
            .map(|(x, is_free)| if *is_free { [0.0; 3] } else { *x })
            .collect();
        let bending = self.system.bending(&fixed);
        let right = |&v: &u32| {
            let (r, own) = (self.rest[v as usize], &turns[v as usize]);
            let mut sum = [0.0; 3];
            for (w, c) in self.system.laplacian_row(v) {
                let edge = vec3::sub(r, self.rest[w as usize]);
                let [a, b] = [applied(own, edge), applied(&turns[w as usize], edge)];
                let bends = vec3::sub(turned[w as usize], bending[w as usize]);
                for i in 0..3 {
                    sum[i] += c * (0.5 * (a[i] + b[i]) + fixed[w as usize][i] + bends[i]);
                }
            }
            sum
        };
        let mut x: Vec<[f64; 3]> = self.order.par_iter().map(right).collect();
        self.factor.solve(x.as_flattened_mut(), 3);
        let mut farthest = 0.0f64;
        for (&v, x) in self.order.iter().zip(x) {
            let before = std::mem::replace(&mut positions[v as usize], x);
            farthest = farthest.max(vec3::length(vec3::sub(x, before)));
        }
        farthest
    }

    /// R − I of a vertex, where R is the rotation of the edges to its neighbours from rest.
    fn turn(&self, positions: &[[f64; 3]], v: usize) -> [[f64; 3]; 3] {
        let mut sum = [[0.0; 3]; 3];
        for (w, c) in self.system.laplacian_row(v as u32) {
            let w = w as usize;
            let (now, rest) = (vec3::sub(positions[v], positions[w]), vec3::sub(self.rest[v], self.rest[w]));
            for (row, x) in sum.iter_mut().zip(now) {
                row.iter_mut().zip(rest).for_each(|(sum, r)| *sum += c * (x * r));
            }
        }
        nearest_turn(&sum)
    }
}

/// `turn` applied to x.
fn applied(turn: &[[f64; 3]; 3], x: [f64; 3]) -> [f64; 3] {
    vec3::add(x, turn.map(|row| vec3::dot(row, x)))
}
