//! Examples of the second face, made from those of the first.
use crate::correspondence::{Correspondence, Place};
use crate::gradients::{Local, gradients, local};
use crate::shapes::Evaluated;
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use rhytid_core::{Example, Face, Handles, Progress, Result, Rig, StrainEdges, Table};
use rhytid_geometry::laplacian;
use rhytid_kernels::normals::VertexTriangles;
use rhytid_solve::{SoftShell, shell};

/// The length over which wrinkles fade beyond the vertices with a counterpart, in spacings of the handles.
const FADES: f64 = 0.5;

/// The factor by which vertices with a counterpart are held more strongly while the others are filled.
const HELD: f64 = 1e8;

/// A shell of the second face, which the first face's examples move.
pub(crate) struct Base {
    /// B, V×n, for the n handles whose places are known.
    basis: Table<f64>,
    /// These handles.
    handles: Vec<Known>,
    /// V: whether a vertex stays in all examples.
    stays: Vec<bool>,
}

/// A handle of the second face whose place on the first is known.
pub(crate) struct Known {
    /// Its number.
    pub handle: usize,
    /// The vertices that it holds, or one place for all of it.
    pub corners: Vec<Corner>,
}

/// A part of a handle.
pub(crate) struct Corner {
    /// Its place on the first face.
    pub place: Place,
    /// The change of the surface there.
    pub local: Local,
    /// How much of the handle it is, with a sum of 1.
    pub weight: f64,
}

impl Known {
    /// The displacement of the handle, as [`carried`].
    fn carried(&self, positions: &[[f64; 3]], rest: &[DVec3]) -> DVec3 {
        let of_corner =
            |corner: &Corner| carried(positions, rest, &corner.place, &corner.local) * corner.weight;
        self.corners.iter().map(of_corner).sum()
    }
}

/// `s R (x − x₀)` at a place of the first face: its displacement, carried over to the second face.
fn carried(positions: &[[f64; 3]], rest: &[DVec3], place: &Place, local: &Local) -> DVec3 {
    let moved = place.corners.iter().zip(place.weights);
    let d: DVec3 =
        moved.map(|(&v, w)| (DVec3::from_array(positions[v as usize]) - rest[v as usize]) * w).sum();
    local.rotation * d * local.scale
}

/// The displacements of the first face in one of its examples, carried over to each vertex of the second; 0
/// without a counterpart.
pub(crate) fn carried_everywhere(
    found: &Correspondence,
    positions: &[[f64; 3]],
    rest: &[DVec3],
) -> Vec<DVec3> {
    let places = found.places.par_iter().zip(&found.locals);
    places
        .map(|(place, local)| place.as_ref().map_or(DVec3::ZERO, |p| carried(positions, rest, p, local)))
        .collect()
}

/// The maker of the examples.
pub(crate) struct Maker<'a> {
    pub from: &'a Rig,
    /// Its vertices at rest.
    pub rest: &'a [DVec3],
    pub to: &'a Face,
    pub correspondence: &'a Correspondence,
    pub shapes: &'a [Evaluated],
    /// Triangles of the second face.
    pub triangles: &'a [[u32; 3]],
    pub spacing: f64,
}

impl Maker<'_> {
    /// The shell, held at the handles whose places are known.
    ///
    /// # Errors
    /// As [`shell`].
    pub(crate) fn base(&self, known: Vec<Known>, progress: &dyn Progress) -> Result<Base> {
        let (rest, to_rest) = (self.rest, &self.to.neutral.positions);
        let handles = &self.to.handles;
        let held = Handles {
            labels: known.iter().map(|known| handles.labels[known.handle].clone()).collect(),
            points: known.iter().map(|known| handles.points[known.handle]).collect(),
        };
        // Examples are needed to find the vertices that stay. Vertices without a counterpart are at rest in
        // them.
        let provisional = self.shapes.iter().enumerate().map(|(p, shape)| {
            let moved = carried_everywhere(self.correspondence, &shape.full, rest);
            let at = |(p, u): (&[f64; 3], DVec3)| (DVec3::from_array(*p) + u).to_array();
            let mut positions: Vec<[f64; 3]> = to_rest.iter().zip(moved).map(at).collect();
            for known in &known {
                let moved = known.carried(&shape.full, rest);
                for (v, _) in handles.points[known.handle].corners() {
                    positions[v.index()] = (DVec3::from_array(to_rest[v.index()]) + moved).to_array();
                }
            }
            Example { name: p.to_string(), positions, mirror: false, noise: None }
        });
        let mut face = Face { handles: held, examples: provisional.collect(), ..self.to.clone() };
        if face.handles.len() < handles.len() {
            // Edges that the project gives are between all handles.
            face.settings.strain_edges = StrainEdges::Auto;
        }
        let shell = shell(&face, progress)?;
        let basis = shell.basis;
        let stays = |v: usize| self.correspondence.takes_part[v] && basis.row(v).iter().all(|b| *b == 0.0);
        Ok(Base { stays: (0..to_rest.len()).map(stays).collect(), basis, handles: known })
    }

    /// The examples: the shell, moved by the first face's handles, plus the wrinkles. With `linear_band`, the
    /// whole movement of the first face is carried over.
    ///
    /// # Errors
    /// As [`SoftShell::drawn`].
    pub(crate) fn examples(
        &self,
        base: &Base,
        linear_band: bool,
        progress: &dyn Progress,
    ) -> Result<Vec<Example>> {
        let (rest, count) = (self.rest, self.shapes.len());
        let to_rest: Vec<DVec3> = self.to.neutral.positions.iter().copied().map(DVec3::from_array).collect();
        let (at_from, at_to) =
            (self.from.surface().vertex_triangles(), VertexTriangles::new(to_rest.len(), self.triangles));
        let Correspondence { places, locals, .. } = self.correspondence;
        let mut shells = Vec::with_capacity(count);
        let mut left = Table::filled(to_rest.len(), count, [0.0; 3]);
        for (p, shape) in self.shapes.iter().enumerate() {
            progress.step("make examples", p as u64, count as u64)?;
            let leads = if linear_band { &shape.full } else { &shape.smooth };
            let u: Vec<DVec3> = base.handles.iter().map(|known| known.carried(leads, rest)).collect();
            let moved = |v: usize| -> DVec3 { base.basis.row(v).iter().zip(&u).map(|(b, u)| *u * *b).sum() };
            let moved: Vec<DVec3> = (0..to_rest.len()).into_par_iter().map(moved).collect();
            // The rotations of each surface by its smooth motion: wrinkles turn with it.
            let (turned_from, turned_to) = if linear_band {
                (Vec::new(), Vec::new())
            } else {
                let smooth: Vec<DVec3> = shape.smooth.iter().copied().map(DVec3::from_array).collect();
                let there: Vec<DVec3> = to_rest.iter().zip(&moved).map(|(p, u)| *p + *u).collect();
                (
                    gradients(rest, &smooth, &self.from.surface().triangles, &at_from, DMat3::IDENTITY),
                    gradients(&to_rest, &there, self.triangles, &at_to, DMat3::IDENTITY),
                )
            };
            let turn = |gradient: DMat3| local(gradient).map_or(DMat3::IDENTITY, |local| local.rotation);
            let of_vertex = |v: usize| {
                let Ok(place) = &places[v] else { return DVec3::ZERO };
                let local = &locals[v];
                if linear_band {
                    return carried(&shape.full, rest, place, local) - moved[v];
                }
                let wrinkle = |v: u32| {
                    DVec3::from_array(shape.full[v as usize]) - DVec3::from_array(shape.smooth[v as usize])
                };
                let wrinkle: DVec3 =
                    place.corners.iter().zip(place.weights).map(|(&v, w)| wrinkle(v) * w).sum();
                let back = turn(place.mean(&turned_from)).transpose();
                turn(turned_to[v]) * (local.rotation * (back * wrinkle)) * local.scale
            };
            let of_vertices: Vec<DVec3> = (0..to_rest.len()).into_par_iter().map(of_vertex).collect();
            left.rows_mut().zip(of_vertices).for_each(|(left, d)| left[p] = d.to_array());
            shells.push(moved);
        }
        progress.step("make examples", count as u64, count as u64)?;
        self.fill(&mut left, progress)?;
        let example = |(p, moved): (usize, Vec<DVec3>)| {
            let at = |(v, u): (usize, &DVec3)| match base.stays[v] && places[v].is_err() {
                true => to_rest[v].to_array(),
                false => (to_rest[v] + *u + DVec3::from_array(left.row(v)[p])).to_array(),
            };
            let positions = moved.iter().enumerate().map(at).collect();
            Example { name: self.from.examples().names[p].clone(), positions, mirror: false, noise: None }
        };
        Ok(shells.into_iter().enumerate().map(example).collect())
    }

    /// Continues a field, V×P, from the vertices with a counterpart to those without. The continuation is as
    /// smooth as a shell, and fades.
    fn fill(&self, field: &mut Table<[f64; 3]>, progress: &dyn Progress) -> Result<()> {
        let Correspondence { places, takes_part, .. } = self.correspondence;
        if places.iter().zip(takes_part).all(|(place, takes_part)| place.is_ok() || !takes_part) {
            return Ok(());
        }
        let rest = &self.to.neutral.positions;
        let fades = FADES * self.spacing;
        let area = laplacian::laplacian(rest, self.triangles).mass;
        let weight = |(place, area): (&Result<Place, _>, &f64)| {
            area / (fades * fades) * if place.is_ok() { HELD } else { 1.0 }
        };
        let weights: Vec<f64> = places.iter().zip(&area).map(weight).collect();
        let filled =
            SoftShell::new(rest, self.triangles, takes_part, fades).drawn(&weights, field, progress)?;
        for (v, place) in places.iter().enumerate() {
            if place.is_err() {
                field.row_mut(v).copy_from_slice(filled.row(v));
            }
        }
        Ok(())
    }
}
