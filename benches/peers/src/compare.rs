//! The comparison of a peer's results with ours.
//!
//! Positions are compared with Rhytid's. Where two examples look nearly the same to a vertex, its RBF weights
//! are large and of opposite sign. The method's sum cancels there, so rounding in float32 is allowed for.
//! Normals are compared with the float64 reference's for the peer's own positions. Where triangles are small,
//! positions with tiny differences have other normals.
use crate::folder::read_array;
use crate::ours::Ours;
use crate::times::What;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use rhytid_core::{Error, Result, Rig, StrainEdgeId};
use rhytid_kernels::detail::feature_distance;
use rhytid_kernels::normals::{VertexTriangles, vertex_normal};
use serde::Serialize;
use std::path::Path;

/// Largest difference of positions, as a share of the largest displacement, and of normals, whose length is
/// 1.
pub(crate) const TOLERANCE: f64 = 1e-4;

/// Rounding error of each of two sums `Σ_j w_vj r_j`, as a share of `Σ_j ‖w_vj‖ r_j`.
const ROUNDING: f64 = 2.0 * f32::EPSILON as f64;

/// The largest differences found, in the units of [`TOLERANCE`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(crate) struct Differences {
    pub positions: f64,
    /// Positions that differ by more than [`TOLERANCE`] through rounding alone.
    pub rounded: usize,
    pub normals: f64,
}

impl Differences {
    fn and(self, other: Self) -> Self {
        Self {
            positions: self.positions.max(other.positions),
            rounded: self.rounded + other.rounded,
            normals: self.normals.max(other.normals),
        }
    }
}

/// The results with which peers are compared.
pub(crate) struct Checker<'a> {
    rig: &'a Rig,
    vertex_triangles: VertexTriangles,
    frame: Expected,
    batch: Expected,
}

/// One evaluation of Rhytid's.
struct Expected {
    what: What,
    /// Frames × F.
    strains: Vec<f32>,
    /// Frames × V.
    positions: Vec<[f32; 3]>,
    /// The largest distance of a vertex from rest.
    largest_displacement: f64,
}

impl<'a> Checker<'a> {
    /// Takes Rhytid's results as the expected ones, after a check of their normals.
    ///
    /// # Errors
    /// [`Error::Input`] if nothing moves; [`Error::Internal`] if the normals are wrong.
    pub(crate) fn new(rig: &'a Rig, ours: &mut Ours) -> Result<Self> {
        let mut expected = |what| {
            let [positions, normals] = ours.results(what)?;
            let expected = Expected::new(rig, what, ours.handles(what), vectors(&positions))?;
            Ok::<_, Error>((expected, vectors(&normals)))
        };
        let (frame, frame_normals) = expected(What::Frame)?;
        let (batch, batch_normals) = expected(What::Batch)?;
        let vertex_triangles = VertexTriangles::new(rig.vertices(), &rig.surface().triangles);
        let checker = Self { rig, vertex_triangles, frame, batch };
        for (expected, normals) in [(&checker.frame, frame_normals), (&checker.batch, batch_normals)] {
            checker.compare("Rhytid", expected, &expected.positions, &normals)?;
        }
        Ok(checker)
    }

    /// Compares the files that the peer `name` wrote into `folder`.
    ///
    /// # Errors
    /// [`Error::Internal`] with the vertex that differs most, if one differs by more than [`TOLERANCE`].
    pub(crate) fn check(&self, name: &str, folder: &Path) -> Result<Differences> {
        let mut all = Differences::default();
        for expected in [&self.frame, &self.batch] {
            let what = expected.what;
            let shape = [what.frames(), self.rig.vertices(), 3];
            let read = |array: &str| read_array(folder, &format!("{}_{array}", what.name()), &shape, name);
            let (positions, normals) = (vectors(&read("positions")?), vectors(&read("normals")?));
            all = all.and(self.compare(name, expected, &positions, &normals)?);
        }
        Ok(all)
    }

    /// `positions` and `normals` are frames × V.
    fn compare(
        &self,
        name: &str,
        expected: &Expected,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
    ) -> Result<Differences> {
        let v = self.rig.vertices();
        let frames = expected.positions.par_chunks(v).zip(positions.par_chunks(v)).zip(normals.par_chunks(v));
        let per_frame = frames.enumerate().map(|(frame, ((expected_positions, positions), normals))| {
            let place =
                format!("{name}, {} of {}, frame {frame}", expected.what.name(), expected.what.frames());
            let [positions, normals, expected_positions] = [positions, normals, expected_positions]
                .map(|vectors| -> Vec<[f64; 3]> { vectors.iter().map(|x| x.map(f64::from)).collect() });
            let tolerance = TOLERANCE * expected.largest_displacement;
            let f = &expected.strains[frame * self.rig.handles().strain_edges.len()..]
                [..self.rig.handles().strain_edges.len()];
            let allowed = |v| tolerance + self.rounding(v, f);
            let away =
                distances(&format!("{place}: the position"), &positions, &expected_positions, allowed)?;
            let rounded = away.iter().filter(|&&away| away > tolerance).count();
            let wanted: Vec<[f64; 3]> = (0..v)
                .map(|v| {
                    vertex_normal(&positions, &self.rig.surface().triangles, self.vertex_triangles.at(v))
                })
                .collect();
            let turned = distances(&format!("{place}: the normal"), &normals, &wanted, |_| TOLERANCE)?;
            let largest = |distances: &[f64]| distances.iter().copied().fold(0.0, f64::max);
            let positions = largest(&away) / expected.largest_displacement;
            Ok(Differences { positions, rounded, normals: largest(&turned) })
        });
        per_frame.try_reduce(Differences::default, |a, b| Ok(a.and(b)))
    }

    /// The rounding error of vertex `v`'s detail at the strains `f`, in mesh units.
    fn rounding(&self, v: usize, f: &[f32]) -> f64 {
        let (influences, fine_scale) = (self.rig.influences(), self.rig.fine_scale());
        let edges = StrainEdgeId::numbers(influences.edges.row(v));
        let alphas = influences.weights.row(v);
        let centers = fine_scale.pose_features.rows().zip(fine_scale.rbf_weights.row(v));
        let terms = centers.map(|(f_j, w)| {
            Vec3::from(*w).as_dvec3().length() * f64::from(feature_distance(edges, alphas, f, f_j))
        });
        ROUNDING * terms.sum::<f64>()
    }
}

impl Expected {
    fn new(rig: &Rig, what: What, handles: &[f32], positions: Vec<[f32; 3]>) -> Result<Self> {
        let strains = rig.handles().strains(handles.as_chunks().0);
        let displacements = positions.iter().zip(rig.surface().rest.iter().cycle());
        let displacements = displacements.map(|(x, rest)| Vec3::from(*x) - Vec3::from(*rest));
        let largest_displacement = displacements.map(|d| d.as_dvec3().length()).fold(0.0, f64::max);
        if largest_displacement > 0.0 {
            return Ok(Self { what, strains, positions, largest_displacement });
        }
        Err(Error::empty(
            "no vertex moves, so there is nothing to compare; are all examples like the neutral mesh?",
        ))
    }
}

fn vectors(numbers: &[f32]) -> Vec<[f32; 3]> {
    numbers.as_chunks().0.to_vec()
}

/// The distance of each vector of `found` from that of `expected`.
///
/// # Errors
/// [`Error::Internal`] that begins with `what` and names the farthest vector, if it is farther than `allowed`
/// or not a number.
fn distances(
    what: &str,
    found: &[[f64; 3]],
    expected: &[[f64; 3]],
    allowed: impl Fn(usize) -> f64,
) -> Result<Vec<f64>> {
    let distances = found.iter().zip(expected).map(|(a, b)| DVec3::from(*a).distance(DVec3::from(*b)));
    let distances: Vec<f64> = distances.collect();
    let wrong = |v: &usize| distances[*v].is_nan() || distances[*v] > allowed(*v);
    let worst = (0..distances.len()).filter(wrong).max_by(|&a, &b| distances[a].total_cmp(&distances[b]));
    let Some(v) = worst else { return Ok(distances) };
    Err(Error::Internal(format!(
        "{what} of vertex {v} is {:?}, expected {:?}: {:.3e} apart, allowed are {:.3e}",
        found[v],
        expected[v],
        distances[v],
        allowed(v)
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FRAMES, folder, rig};
    use rhytid_core::{BasisStorage, NoProgress};

    /// The result of the check for a faultless peer whose output is changed by `fault`.
    fn check(fault: impl FnOnce(&mut [[f32; 3]], &mut [[f32; 3]])) -> Result<Differences> {
        let rig: Rig = rhytid_solve::solve(&rig::face(1500), &NoProgress)?.rounded()?;
        let handles = rig::handles_over_time(&rig, FRAMES)?;
        let mut ours = Ours::new(&rig, &handles, BasisStorage::F32)?;
        let checker = Checker::new(&rig, &mut ours)?;
        let [mut positions, mut normals] = ours.results(What::Batch)?.map(|numbers| vectors(&numbers));
        fault(&mut positions, &mut normals);
        checker.compare("peer", &checker.batch, &positions, &normals)
    }

    #[test]
    fn the_same_numbers_agree() {
        let Differences { positions, rounded, normals } = check(|_, _| {}).unwrap();
        assert_eq!((positions, rounded), (0.0, 0));
        assert!(normals > 0.0 && normals < 1e-5, "{normals}");
    }

    #[test]
    fn a_planted_disagreement_is_found() {
        let vertices = rhytid_demo::face(1500).neutral.positions.len();
        let at = 7 * vertices + 123;
        let error = check(|positions, _| positions[at][1] += 0.01).unwrap_err().to_string();
        assert!(error.contains("peer, batch of 32, frame 7: the position of vertex 123 is"), "{error}");
        let error = check(|_, normals| normals[at][2] += 0.001).unwrap_err().to_string();
        assert!(error.contains("frame 7: the normal of vertex 123 is"), "{error}");
        let error = check(|positions, _| positions[at][0] = f32::NAN).unwrap_err().to_string();
        assert!(error.contains("NaN"), "{error}");
    }

    #[test]
    fn arrays_come_back_as_they_were_written_and_a_wrong_shape_is_an_error() {
        let rig: Rig = rhytid_solve::solve(&rig::face(1500), &NoProgress).unwrap().rounded().unwrap();
        let handles = rig::handles_over_time(&rig, FRAMES).unwrap();
        let folder = folder::write(&rig, &handles).unwrap();
        let shape = [rig.vertices(), rig.handles().len()];
        assert_eq!(read_array(folder.path(), "basis", &shape, "a").unwrap(), rig.basis().as_slice());
        let error = read_array(folder.path(), "basis", &shape[..1], "a").unwrap_err().to_string();
        assert!(error.contains("a: basis has shape"), "{error}");
    }
}
