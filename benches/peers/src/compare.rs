//! Whether a peer computed the same.
//!
//! Positions are compared with Rhytid's. Normals are compared with the float64 twin's of the peer's own positions: where
//! triangles are small, positions that differ by nearly nothing have other normals.
use crate::folder::read_array;
use crate::ours::Ours;
use crate::times::What;
use rayon::prelude::*;
use rhytid_core::{Error, Result, Rig};
use rhytid_kernels::normals::{VertexTriangles, vertex_normal};
use serde::Serialize;
use std::path::Path;

/// What positions may differ by, as a share of the largest displacement, and normals, which are of length 1.
const TOLERANCE: f64 = 1e-4;

/// The largest differences found, in the units of [`TOLERANCE`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Differences {
    pub positions: f64,
    pub normals: f64,
}

impl Differences {
    fn max(self, other: Self) -> Self {
        Self { positions: self.positions.max(other.positions), normals: self.normals.max(other.normals) }
    }
}

/// What peers are compared with.
pub struct Checker<'a> {
    rig: &'a Rig,
    vertex_triangles: VertexTriangles,
    frame: Expected,
    batch: Expected,
}

/// One evaluation of Rhytid's.
struct Expected {
    what: What,
    /// Frames × V.
    positions: Vec<[f32; 3]>,
    /// How far a vertex is from rest at most.
    largest_displacement: f64,
}

impl<'a> Checker<'a> {
    /// Takes Rhytid's results as the expected ones, having checked their own normals.
    ///
    /// # Errors
    /// [`Error::Input`] if nothing moves; [`Error::Internal`] if the normals are wrong.
    pub fn new(rig: &'a Rig, ours: &mut Ours) -> Result<Self> {
        let mut expected = |what| {
            let [positions, normals] = ours.results(what)?;
            Ok::<_, Error>((Expected::new(what, vectors(&positions), &rig.rest)?, vectors(&normals)))
        };
        let (frame, frame_normals) = expected(What::Frame)?;
        let (batch, batch_normals) = expected(What::Batch)?;
        let vertex_triangles = VertexTriangles::new(rig.vertices(), &rig.triangles);
        let checker = Self { rig, vertex_triangles, frame, batch };
        for (expected, normals) in [(&checker.frame, frame_normals), (&checker.batch, batch_normals)] {
            checker.compare("Rhytid", expected, &expected.positions, &normals)?;
        }
        Ok(checker)
    }

    /// Compares what the peer called `name` wrote into `folder`.
    ///
    /// # Errors
    /// [`Error::Internal`] with the vertex that differs most, if one differs by more than [`TOLERANCE`].
    pub fn check(&self, name: &str, folder: &Path) -> Result<Differences> {
        let mut all = Differences::default();
        for expected in [&self.frame, &self.batch] {
            let what = expected.what;
            let shape = [what.frames(), self.rig.vertices(), 3];
            let read = |array: &str| read_array(folder, &format!("{}_{array}", what.name()), &shape, name);
            let (positions, normals) = (vectors(&read("positions")?), vectors(&read("normals")?));
            all = all.max(self.compare(name, expected, &positions, &normals)?);
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
            let own: Vec<[f64; 3]> = positions.iter().map(|x| x.map(f64::from)).collect();
            let ours = expected_positions.iter().map(|x| x.map(f64::from));
            let allowed = TOLERANCE * expected.largest_displacement;
            let positions = furthest(&format!("{place}: the position"), own.iter().copied(), ours, allowed)?;
            let wanted =
                (0..v).map(|v| vertex_normal(&own, &self.rig.triangles, self.vertex_triangles.at(v)));
            let normals = normals.iter().map(|n| n.map(f64::from));
            let normals = furthest(&format!("{place}: the normal"), normals, wanted, TOLERANCE)?;
            Ok(Differences { positions: positions / expected.largest_displacement, normals })
        });
        per_frame.try_reduce(Differences::default, |a, b| Ok(a.max(b)))
    }
}

impl Expected {
    fn new(what: What, positions: Vec<[f32; 3]>, rest: &[[f32; 3]]) -> Result<Self> {
        let displacements = positions.iter().zip(rest.iter().cycle());
        let largest_displacement = displacements
            .map(|(x, rest)| distance(x.map(f64::from), rest.map(f64::from)))
            .fold(0.0, f64::max);
        if largest_displacement > 0.0 {
            return Ok(Self { what, positions, largest_displacement });
        }
        Err(Error::input(
            "no vertex moves, so there is nothing to compare; are all examples like the neutral mesh?",
        ))
    }
}

fn vectors(numbers: &[f32]) -> Vec<[f32; 3]> {
    numbers.as_chunks().0.to_vec()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// The largest distance between a vector of `found` and that of `expected`.
///
/// # Errors
/// [`Error::Internal`] that begins with `what`, if it is above `allowed` or no number.
fn furthest(
    what: &str,
    found: impl Iterator<Item = [f64; 3]>,
    expected: impl Iterator<Item = [f64; 3]>,
    allowed: f64,
) -> Result<f64> {
    let mut largest = (0.0, 0, [0.0; 3], [0.0; 3]);
    for (v, (found, expected)) in found.zip(expected).enumerate() {
        let away = distance(found, expected);
        // NaN is above everything.
        if away.total_cmp(&largest.0).is_gt() {
            largest = (away, v, found, expected);
        }
    }
    let (away, v, found, expected) = largest;
    if away <= allowed {
        return Ok(away);
    }
    Err(Error::Internal(format!(
        "{what} of vertex {v} is {found:?}, expected {expected:?}: {away:.3e} apart, allowed are {allowed:.3e}"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FRAMES, folder, rig};
    use rhytid_core::{BasisStorage, NoProgress};

    /// What a faultless peer would write, changed by `fault`, and what becomes of it.
    fn check(fault: impl FnOnce(&mut [[f32; 3]], &mut [[f32; 3]])) -> Result<Differences> {
        let rig: Rig = rhytid_core::solve(&rhytid_demo::face(1500), &NoProgress)?.cast();
        let handles = rig::handles_over_time(&rig, FRAMES)?;
        let mut ours = Ours::new(&rig, &handles, BasisStorage::F32)?;
        let checker = Checker::new(&rig, &mut ours)?;
        let [mut positions, mut normals] = ours.results(What::Batch)?.map(|numbers| vectors(&numbers));
        fault(&mut positions, &mut normals);
        checker.compare("peer", &checker.batch, &positions, &normals)
    }

    #[test]
    fn the_same_numbers_agree() {
        let Differences { positions, normals } = check(|_, _| {}).unwrap();
        assert_eq!(positions, 0.0);
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
        let rig: Rig = rhytid_core::solve(&rhytid_demo::face(1500), &NoProgress).unwrap().cast();
        let handles = rig::handles_over_time(&rig, FRAMES).unwrap();
        let folder = folder::write(&rig, &handles).unwrap();
        let shape = [rig.vertices(), rig.handles.len()];
        assert_eq!(read_array(folder.path(), "basis", &shape, "a").unwrap(), rig.basis);
        let error = read_array(folder.path(), "basis", &shape[..1], "a").unwrap_err().to_string();
        assert!(error.contains("a: basis has shape"), "{error}");
    }
}
