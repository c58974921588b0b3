//! The smooth part of a field on the rest mesh (step 3 of the learned method).
use crate::driven::DrivenComponents;
use crate::laplacian::{self, Laplacian};
use crate::points;
use crate::system::{NONE, System};
use rayon::prelude::*;
use rhytid_core::{Progress, Result, Rig, SurfacePoint, Table};
use rhytid_geometry::cholesky::Dissection;
use rhytid_geometry::cholesky::Factor;
use rhytid_geometry::cholesky::dissect;

/// σ in mean rest lengths.
const SIGMA: f64 = 1.0 / 12.0;

/// σ of the learned method, given the mean of the rest lengths.
pub(crate) fn sigma(mean: f64) -> f64 {
    SIGMA * mean
}

/// Columns of the right-hand side that one thread solves for at a time.
const COLUMNS_AT_ONCE: usize = 16;

/// The smoothing that takes the wrinkles out of a field on the rest mesh.
///
/// It is `Ŵ = (M_ff − (σ²/2) C_ff)⁻¹ M_ff W_f` at the free vertices, which are those of parts with a handle
/// that are no handles themselves. Ŵ is 0 at handles, and is made so where a handle is inside a triangle.
/// Parts without a handle keep their field.
pub struct Smoothing {
    system: System,
    factor: Factor,
    order: Vec<u32>,
    /// The place of each vertex in `order`, or [`NONE`].
    place: Vec<u32>,
    handles: points::Zeroed,
}

impl Smoothing {
    /// For a rig's rest mesh, with σ as in the learned method: a twelfth of the mean rest length of the
    /// strain edges.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Input`] if the system is not positive definite in floating point,
    /// [`rhytid_core::Error::Cancelled`].
    pub fn new(rig: &Rig<f64>, progress: &dyn Progress) -> Result<Self> {
        Self::over(rig, sigma(rig.handles().feature_lengths().last().copied().unwrap_or(1.0)), progress)
    }

    /// The same with another σ, in mesh units. σ is the width of the shapes that are smoothed away.
    ///
    /// # Errors
    /// As [`Smoothing::new`].
    pub fn over(rig: &Rig<f64>, sigma: f64, progress: &dyn Progress) -> Result<Self> {
        let (surface, handles) = (rig.surface(), &rig.handles().points);
        let driven = DrivenComponents::new(&surface.rest, &surface.triangles, handles).driven;
        let laplacian = laplacian::laplacian(&surface.rest, &surface.triangles);
        Self::from_surface(&surface.rest, laplacian, handles, &driven, sigma, progress)
    }

    /// `driven[v]` says whether vertex v is in a part with a handle and is to be smoothed.
    ///
    /// # Errors
    /// As [`Smoothing::new`].
    pub(crate) fn from_surface(
        rest: &[[f64; 3]],
        laplacian: Laplacian,
        handles: &[SurfacePoint],
        driven: &[bool],
        sigma: f64,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let mut free = driven.to_vec();
        let vertices = handles.iter().filter_map(SurfacePoint::vertex);
        vertices.for_each(|v| free[v.index()] = false);
        let free: Vec<u32> = (0..rest.len() as u32).filter(|&v| free[v as usize]).collect();
        let system = System::smoothing(laplacian, sigma);
        let Dissection { order, root } = dissect(rest, system.pattern(), free);
        let factor = Factor::new(&system.lower(&order), &root, progress)?;
        let place = system.places(&order);
        Ok(Self { system, factor, order, place, handles: points::Zeroed::new(handles) })
    }

    /// `field` is W, V×n in any unit, and becomes Ŵ.
    ///
    /// # Errors
    /// [`rhytid_core::Error::Cancelled`].
    pub fn apply(&self, field: &mut Table<[f64; 3]>, progress: &dyn Progress) -> Result<()> {
        let width = 3 * field.columns();
        if width == 0 {
            return Ok(());
        }
        self.handles.apply(field);
        let mut firsts: Vec<usize> = (0..width).step_by(COLUMNS_AT_ONCE).collect();
        let at_once = rayon::current_num_threads().min(firsts.len());
        let mut solved: Vec<Vec<f64>> = vec![Vec::new(); at_once];
        for firsts in firsts.chunks_mut(at_once) {
            progress.step("smooth", firsts[0] as u64, width as u64)?;
            let from = &*field;
            solved.par_iter_mut().zip(firsts.par_iter()).for_each(|(x, &first)| {
                let k = COLUMNS_AT_ONCE.min(width - first);
                x.clear();
                for &v in &self.order {
                    let mass = self.system.mass(v);
                    x.extend(from.row(v as usize).as_flattened()[first..][..k].iter().map(|w| mass * w));
                }
                self.factor.solve(x, k);
            });
            let rows = field.par_rows_mut().map(<[[f64; 3]]>::as_flattened_mut).zip(&self.place);
            rows.filter(|(_, p)| **p != NONE).for_each(|(row, &place)| {
                for (x, &first) in solved.iter().zip(firsts.iter()) {
                    let k = COLUMNS_AT_ONCE.min(width - first);
                    row[first..][..k].copy_from_slice(&x[place as usize * k..][..k]);
                }
            });
        }
        self.handles.apply(field);
        progress.step("smooth", width as u64, width as u64)
    }
}
