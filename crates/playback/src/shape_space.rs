//! Where a rig's handles are on a mesh with shapes, which may be split, cut and turned in another way.

use rhytid_core::{Error, Mesh, Result, Rig, UpAxis};
use rhytid_formats::mesh::Space;
use std::path::Path;

/// A vertex of the mesh is that of the rig within this part of the rig's size.
const SAME_PLACE: f64 = 0.003;

/// Vertices that are this near to each other, as a part of the rig's size, are in one place.
const TOGETHER: f64 = 1e-5;

/// The sizes of one mesh in two files have a ratio below this.
const SAME_SIZE: f64 = 2.0;

/// The unit and the up axis of a mesh, seen from a rig.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ShapeSpace {
    /// The length of the mesh's unit in the rig's.
    scale: f64,
    turn: Turn,
}

/// The turn from one up axis to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Turn {
    None,
    YToZ,
    ZToY,
}

impl ShapeSpace {
    /// What a file says of its space. What it does not say is as in the rig.
    fn stated(space: Space, rig: &Rig) -> Self {
        let surface = rig.surface();
        let turn = match (space.up, surface.up_axis) {
            (Some(UpAxis::Y), UpAxis::Z) => Turn::YToZ,
            (Some(UpAxis::Z), UpAxis::Y) => Turn::ZToY,
            _ => Turn::None,
        };
        Self { scale: space.metres_per_unit.map_or(1.0, |metres| metres / surface.metres_per_unit), turn }
    }

    /// The space of a mesh that is the rig's in a pose. Where its size shows that its unit is the rig's, that
    /// counts more than what the file says.
    ///
    /// # Errors
    /// [`Error::Input`] if the mesh is far larger or smaller than the rig's.
    pub(crate) fn by_size(positions: &[[f64; 3]], space: Space, rig: &Rig, path: &Path) -> Result<Self> {
        let stated = Self::stated(space, rig);
        let ratio = size(positions) / size(&rest(rig));
        let fits = |scale: &f64| (1.0 / SAME_SIZE..SAME_SIZE).contains(&(scale * ratio));
        match [stated.scale, 1.0].into_iter().find(fits) {
            Some(scale) => Ok(Self { scale, ..stated }),
            None => Err(Error::mismatch(format!(
                "{}: is {:.3} times as large as the rig's mesh; export the shapes in the unit of the rig",
                path.display(),
                stated.scale * ratio
            ))),
        }
    }

    /// A vector of the mesh's space in the rig's.
    pub(crate) fn to_rig(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let turned = match self.turn {
            Turn::None => [x, y, z],
            Turn::YToZ => [x, -z, y],
            Turn::ZToY => [x, z, -y],
        };
        turned.map(|x| x * self.scale)
    }
}

/// The rig's rest pose.
pub(crate) fn rest(rig: &Rig) -> Vec<[f64; 3]> {
    rig.surface().rest.iter().map(|x| x.map(f64::from)).collect()
}

/// A rig's handles as vertices of a mesh, with weights.
pub(crate) struct OnMesh {
    space: ShapeSpace,
    /// For each handle.
    corners: Vec<Vec<(usize, f64)>>,
}

impl OnMesh {
    /// Finds the vertices of the handles on the mesh without shapes, by their places.
    ///
    /// Of several vertices in one place, as of closed lips, the one counts around which the mesh lies as
    /// around the rig's vertex.
    ///
    /// # Errors
    /// [`Error::Input`] if a handle's vertex is not there: it is another mesh, or in another place.
    pub(crate) fn find(neutral: &Mesh, space: Space, rig: &Rig, path: &Path) -> Result<Self> {
        let stated = ShapeSpace::stated(space, rig);
        // What a file says of its space may be wrong. Places decide.
        let turns = [stated.turn, Turn::None, Turn::YToZ, Turn::ZToY];
        let spaces =
            [stated.scale, 1.0].into_iter().flat_map(|scale| turns.map(|turn| ShapeSpace { scale, turn }));
        spaces.into_iter().find_map(|space| Self::in_space(neutral, space, rig)).ok_or_else(|| {
            Error::mismatch(format!(
                "{}: its mesh without shapes is not the rig's mesh at rest; give shapes of the mesh that the rig was \
                 solved from, in the same place",
                path.display()
            ))
        })
    }

    fn in_space(neutral: &Mesh, space: ShapeSpace, rig: &Rig) -> Option<Self> {
        let positions: Vec<[f64; 3]> = neutral.positions.iter().map(|x| space.to_rig(*x)).collect();
        let rest = rest(rig);
        let size = size(&rest);
        let around_rig = Around::new(&rest, &rig.surface().faces);
        let around_mesh = Around::new(&positions, &neutral.faces);
        let vertex = |v: usize| -> Option<usize> {
            let is_near = |w: &usize| distance(positions[*w], rest[v]) <= TOGETHER * size;
            // The usual mesh has the rig's order.
            if positions.len() == rest.len() && is_near(&v) {
                return Some(v);
            }
            let nearest =
                (0..positions.len()).map(|w| distance(positions[w], rest[v])).fold(f64::INFINITY, f64::min);
            if nearest > SAME_PLACE * size {
                return None;
            }
            let in_place = (0..positions.len())
                .filter(|w| distance(positions[*w], rest[v]) <= nearest + TOGETHER * size);
            let off = |w: &usize| distance(around_mesh.mean[*w], around_rig.mean[v]);
            in_place.min_by(|a, b| off(a).total_cmp(&off(b)))
        };
        let handle = |point: &rhytid_core::SurfacePoint| {
            point.corners().map(|(v, weight)| Some((vertex(v.index())?, weight))).collect()
        };
        let corners = rig.handles().points.iter().map(handle).collect::<Option<Vec<_>>>()?;
        Some(Self { space, corners })
    }

    /// What a shape does to the handles. `rest` are the mesh's places without it.
    pub(crate) fn displacements(&self, positions: &[[f64; 3]], rest: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let of_handle = |corners: &Vec<(usize, f64)>| {
            let mut moved = [0.0; 3];
            for (v, weight) in corners {
                let by = difference(positions[*v], rest[*v]);
                moved.iter_mut().zip(by).for_each(|(x, by)| *x += weight * by);
            }
            self.space.to_rig(moved)
        };
        self.corners.iter().map(of_handle).collect()
    }
}

/// Where the faces around each vertex are.
struct Around {
    /// The mean of the corners of all faces at a vertex.
    mean: Vec<[f64; 3]>,
}

impl Around {
    fn new(positions: &[[f64; 3]], faces: &rhytid_core::Faces) -> Self {
        let mut sums = vec![[0.0; 4]; positions.len()];
        for face in faces.iter() {
            let mut of_face = [0.0; 4];
            for &v in face {
                let [x, y, z] = positions[v as usize];
                of_face.iter_mut().zip([x, y, z, 1.0]).for_each(|(sum, x)| *sum += x);
            }
            for &v in face {
                sums[v as usize].iter_mut().zip(of_face).for_each(|(sum, x)| *sum += x);
            }
        }
        let mean = |(sum, at): (&[f64; 4], &[f64; 3])| match sum[3] {
            0.0 => *at,
            count => [sum[0] / count, sum[1] / count, sum[2] / count],
        };
        Self { mean: sums.iter().zip(positions).map(mean).collect() }
    }
}

pub(crate) fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| a[c] - b[c])
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    difference(a, b).iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The diagonal of the box around positions.
fn size(positions: &[[f64; 3]]) -> f64 {
    let bound = |of: fn(f64, f64) -> f64, from: f64| -> [f64; 3] {
        std::array::from_fn(|c| positions.iter().map(|x| x[c]).fold(from, of))
    };
    distance(bound(f64::min, f64::INFINITY), bound(f64::max, f64::NEG_INFINITY))
}
