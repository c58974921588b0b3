//! A rig on fewer vertices: a level of detail.
use crate::rig_rows::Rows;
use crate::{
    Contact, Error, Faces, LidVertex, Materials, Openings, Result, Rig, RimFollower, RimVertex, Surface, Uvs,
    VertexId,
};
use rhytid_kernels::Real;
use std::collections::{BTreeMap, BTreeSet};

/// A triangle with all that belongs to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct LevelTriangle {
    /// The corners, in order.
    pub corners: [LevelCorner; 3],
    /// Its entry in [`Materials::list`], or [`Materials::NONE`].
    pub material: u32,
}

/// A corner of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct LevelCorner {
    /// Its vertex in the whole rig.
    pub vertex: VertexId,
    /// Its entry in [`Uvs::values`] of the whole rig. 0 without texture coordinates.
    pub uv: u32,
}

/// A level of detail.
#[derive(Debug, Clone, PartialEq)]
pub struct Level<T: Real = f32> {
    /// The rig.
    pub rig: Rig<T>,
    /// The vertices of the whole rig that it has, ascending.
    pub kept: Vec<VertexId>,
}

impl<T: Real> Rig<T> {
    /// The triangles of the whole rig, from which those of a level are made.
    ///
    /// # Errors
    /// [`Error::Internal`] if the triangles are not those of the faces, which a sound rig's are.
    pub fn level_triangles(&self) -> Result<Vec<LevelTriangle>> {
        let surface = self.surface();
        let corners = surface.triangle_corners()?;
        let uv = |corner: u32, vertex: u32| match &surface.uvs {
            None => 0,
            Some(Uvs { corners: Some(corners), .. }) => corners[corner as usize],
            Some(Uvs { corners: None, .. }) => vertex,
        };
        let faces = surface.faces.counts.iter().enumerate();
        let of_faces = faces.flat_map(|(face, &n)| std::iter::repeat_n(face, n as usize - 2));
        let material = |face: usize| match &surface.materials {
            Some(materials) => materials.of_face[face],
            None => Materials::NONE,
        };
        let triangles = surface.triangles.iter().zip(corners).zip(of_faces);
        let triangle = |((vertices, corners), face): ((&[u32; 3], [u32; 3]), usize)| LevelTriangle {
            corners: std::array::from_fn(|i| LevelCorner {
                vertex: VertexId(vertices[i]),
                uv: uv(corners[i], vertices[i]),
            }),
            material: material(face),
        };
        Ok(triangles.map(triangle).collect())
    }

    /// The rig on the vertices of these triangles, and on those that handles hold or that place an eyeball.
    /// Every vertex keeps its order and all its numbers. So a level has it where the whole rig has it, before
    /// parts that touch are kept apart. Materials without a triangle go.
    ///
    /// # Errors
    /// [`Error::Input`] if the rig has details in tangent frames, as those of the chapter's method: such a
    /// frame belongs to the whole mesh. [`Error::Internal`] if there is no triangle.
    pub fn level(&self, triangles: &[LevelTriangle]) -> Result<Level<T>> {
        let has_details = self.fine_scale().rbf_weights.as_slice().iter().any(|w| *w != [T::ZERO; 3]);
        if has_details && !self.vector_wrinkles() {
            return Err(Error::conflict(
                "the details of this rig are in tangent frames of its mesh, which has other triangles on another \
                 level; solve the face with method = \"learned\" and wrinkle_strains = \"vectors\", the defaults",
            ));
        }
        if triangles.is_empty() {
            return Err(Error::Internal("a level has no triangle".into()));
        }
        let mut vertices: BTreeSet<VertexId> = self.handles().held().collect();
        vertices.extend(triangles.iter().flat_map(|triangle| triangle.corners).map(|corner| corner.vertex));
        let eyeballs = self.learned().into_iter().flat_map(|learned| &learned.contact.eyeballs);
        vertices.extend(eyeballs.flat_map(|eyeball| eyeball.corners));
        let kept: Vec<VertexId> = vertices.into_iter().collect();
        let rows = Rows::new(&kept, self.vertices());
        let contact = self.learned().map(|learned| of_contact(&rows, &learned.contact));
        let parts = rows.parts(self, self.level_surface(triangles, &rows), contact.unwrap_or_default());
        Ok(Level { rig: Rig::new(parts)?, kept })
    }

    fn level_surface(&self, triangles: &[LevelTriangle], rows: &Rows<'_>) -> Surface<T> {
        let surface = self.surface();
        let place = |v: VertexId| rows.place(v).map_or(0, |v| v.0);
        let own: Vec<[u32; 3]> =
            triangles.iter().map(|triangle| triangle.corners.map(|corner| place(corner.vertex))).collect();
        let mut faces = Faces::default();
        own.iter().for_each(|triangle| faces.push(triangle));
        let uvs = surface.uvs.as_ref().map(|uvs| match &uvs.corners {
            None => Uvs { values: rows.of_each(&uvs.values), corners: None },
            Some(_) => {
                let mut numbers = Numbers::default();
                let of_corners = triangles.iter().flat_map(|triangle| triangle.corners);
                let corners = of_corners.map(|corner| numbers.of(corner.uv)).collect();
                let values = numbers.order.iter().map(|&uv| uvs.values[uv as usize]).collect();
                Uvs { values, corners: Some(corners) }
            }
        });
        let materials = surface.materials.as_ref().map(|materials| {
            let used: BTreeSet<u32> = triangles.iter().map(|triangle| triangle.material).collect();
            let used: Vec<u32> = used.into_iter().filter(|&material| material != Materials::NONE).collect();
            let of_face = |triangle: &LevelTriangle| {
                used.binary_search(&triangle.material).map_or(Materials::NONE, |number| number as u32)
            };
            Materials {
                list: used.iter().map(|&material| materials.list[material as usize].clone()).collect(),
                textures: materials.textures.clone(),
                of_face: triangles.iter().map(of_face).collect(),
            }
        });
        let mut beside: Vec<Option<u32>> = vec![None; rows.kept.len()];
        for &[a, b, c] in &own {
            for (v, other) in [(a, b), (b, c), (c, a)] {
                let neighbor = &mut beside[v as usize];
                *neighbor = Some(neighbor.map_or(other, |neighbor| neighbor.min(other)));
            }
        }
        let neighbor = |(own, v): (usize, &VertexId)| {
            let whole = rows.place(surface.tangent_neighbors[v.index()]);
            whole.unwrap_or(VertexId(beside[own].unwrap_or(own as u32)))
        };
        Surface {
            name: surface.name.clone(),
            metres_per_unit: surface.metres_per_unit,
            up_axis: surface.up_axis,
            faces,
            uvs,
            materials,
            triangles: own,
            rest: surface.at(rows.kept),
            tangent_neighbors: rows.kept.iter().enumerate().map(neighbor).collect(),
            joined: rows.joined(surface),
        }
    }
}

/// Numbers in the order in which they are first asked for.
#[derive(Default)]
struct Numbers {
    known: BTreeMap<u32, u32>,
    order: Vec<u32>,
}

impl Numbers {
    fn of(&mut self, number: u32) -> u32 {
        let next = self.order.len() as u32;
        *self.known.entry(number).or_insert_with(|| {
            self.order.push(number);
            next
        })
    }
}

/// What touches, among the vertices that are kept. A vertex whose leader goes leads itself.
fn of_contact<T: Real>(rows: &Rows<'_>, contact: &Contact<T>) -> Contact<T> {
    let eyeballs = contact.eyeballs.iter().map(|eyeball| {
        let mut own = *eyeball;
        own.corners = eyeball.corners.map(|v| rows.place(v).unwrap_or(v));
        own
    });
    let lids = Kept::new(contact.lids.iter().map(|lid| rows.place(lid.vertex)));
    let rims = Kept::new(contact.openings.rims.iter().map(|rim| rows.place(rim.vertex)));
    let lid = |(own, vertex, old): (u32, VertexId, usize)| {
        let lid = &contact.lids[old];
        LidVertex { vertex, leader: lids.number(lid.leader).unwrap_or(own), ..*lid }
    };
    let rim = |(own, vertex, old): (u32, VertexId, usize)| {
        let rim: &RimVertex<T> = &contact.openings.rims[old];
        RimVertex { vertex, across: rim.across.map(|other| rims.number(other).unwrap_or(own)), ..*rim }
    };
    let follower = |follower: &RimFollower<T>| {
        let vertex = rows.place(follower.vertex)?;
        let sum = |weights: &[T]| weights.iter().map(|weight| weight.widen()).sum::<f64>();
        let mut own = RimFollower { vertex, ..*follower };
        for (leader, weight) in own.leaders.iter_mut().zip(&mut own.weights) {
            match rims.number(*leader) {
                Some(number) => *leader = number,
                None => (*leader, *weight) = (0, T::ZERO),
            }
        }
        // The leaders that are kept take the weights of the others.
        let (before, after) = (sum(&follower.weights), sum(&own.weights));
        let factor = if after.abs() > 1e-6 { before / after } else { 0.0 };
        own.weights = own.weights.map(|weight| T::round_from((factor * weight.widen()).clamp(-1.0, 1.0)));
        (factor != 0.0).then_some(own)
    };
    let followers = contact.openings.followers.iter().filter_map(follower);
    Contact {
        eyeballs: eyeballs.collect(),
        lids: lids.kept().map(lid).collect(),
        openings: Openings { rims: rims.kept().map(rim).collect(), followers: followers.collect() },
    }
}

/// Which of some numbered vertices are kept.
struct Kept {
    /// For each its vertex of the level and its new number.
    places: Vec<Option<(u32, VertexId)>>,
}

impl Kept {
    fn new(vertices: impl Iterator<Item = Option<VertexId>>) -> Self {
        let mut count = 0;
        let numbered = |vertex: Option<VertexId>| {
            vertex.map(|vertex| {
                count += 1;
                (count - 1, vertex)
            })
        };
        Self { places: vertices.map(numbered).collect() }
    }

    /// The new number of the one that was `number`.
    fn number(&self, number: u32) -> Option<u32> {
        self.places[number as usize].map(|(number, _)| number)
    }

    /// The new number, the vertex and the old number of each that is kept.
    fn kept(&self) -> impl Iterator<Item = (u32, VertexId, usize)> {
        let places = self.places.iter().enumerate();
        places.filter_map(|(old, place)| place.map(|(number, vertex)| (number, vertex, old)))
    }
}
