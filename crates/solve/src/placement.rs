//! The part of a mesh for handles, and handles where a frame's markers are.
use crate::align::aligned;
use crate::exposure::exposure;
use crate::head::{self, Region};
use crate::mirror::mirror_images_within;
use crate::welded::{Welded, named_by_first};
use glam::{DMat3, DVec2, DVec3};
use rhytid_core::{Error, Example, Face, Remedy, Result, SurfacePoint, VertexId};
use rhytid_geometry::laplacian;
use rhytid_geometry::laplacian::is_degenerate;
use rhytid_geometry::registration::OntoSurface;
use rhytid_geometry::registration::Start;
use rhytid_geometry::registration::onto_surface;
use rhytid_geometry::triangulate;
use rhytid_geometry::{Surface, Topology, components};
use rhytid_kernels::normals;

/// A vertex is in a hole if less than this part of the directions that it faces is open.
const SEEN: f64 = 0.3;

/// A vertex belongs to the back of the head if the cosine between its normal and the face's forward axis is
/// below this.
const AHEAD: f64 = -0.1;

/// The same bound for the front of the face, which handles are spread over.
const FRONT: f64 = 0.05;

/// A vertex that no example moves by more does not belong to the face, as at the neck and the ears.
///
/// The bounds are in metres, and as a part of the movement of the vertex that moves farthest.
const MOVES: (f64, f64) = (1e-3, 0.08);

/// A point that is nearer to a vertex than this, in metres, is that vertex: markers are not seen more
/// exactly.
const AT_VERTEX: f64 = 1e-4;

/// Two markers are at least so far apart, in metres, or they are at one place.
const APART: f64 = 5e-4;

/// The least weight of the corner that a marker inside a triangle has for itself. With less, markers at the
/// other corners would leave it no choice.
const LEAST_OWN: f64 = 0.1;

/// The largest ratio between an actor's size and the mesh's, either way.
const SIZES: f64 = 1.25;

/// The part of a mesh that a marker can be glued to.
pub struct Skin {
    pub(crate) rest: Vec<DVec3>,
    pub(crate) topology: Topology,
    /// V: whether a vertex may be a handle.
    open: Vec<bool>,
    /// V: whether such a vertex is of the face's front, where handles are spread.
    pub(crate) front: Vec<bool>,
    /// V: the area around each vertex.
    pub(crate) area: Vec<f64>,
    /// V: whether some example moves such a vertex; true for all of them without examples.
    moves: Vec<bool>,
    /// The corners of all triangles.
    triangles: Vec<[u32; 3]>,
    /// The triangles at vertices that may be handles.
    surface: Surface,
    /// V: the mirror image of each vertex, if the face is symmetric. Vertices elsewhere may have none.
    pub(crate) images: Option<Vec<Option<u32>>>,
    /// The face's right, up and forward axes.
    pub(crate) axes: DMat3,
    metres_per_unit: f64,
    /// Whether handles can be at vertices alone.
    at_vertices: bool,
    /// How far each example moves each vertex.
    displacements: Vec<Vec<DVec3>>,
}

/// A marker on the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    /// The point of the skin that it holds.
    pub point: SurfacePoint,
    /// The distance of that point from the place of the marker, in mesh units.
    pub distance: f64,
    /// The marker that has the nearest place, so that this one got the next free vertex.
    pub beside: Option<usize>,
}

/// The face with one vertex in the faces for each point of its surface. `None` if it has that already.
pub(crate) fn named(face: &Face) -> Option<Face> {
    Welded::new(face).map(|welded| named_by_first(face, &welded.points))
}

impl Skin {
    /// The skin of a face, on which handles lie at any point or, where they turn, at vertices. It is the
    /// outside of the head that [`head::find`] finds, without the back of the head.
    ///
    /// The insides of mouth and nostrils and the parts behind lids are left out. The face's handles do not
    /// matter.
    ///
    /// # Errors
    /// As [`head::find`]; [`Error::Input`] if nothing is left. This is so for a mesh without faces, and for
    /// one that looks another way than along +Z (up Y) or −Y (up Z).
    pub fn from_face(face: &Face) -> Result<Self> {
        let in_place = aligned(face);
        let face = in_place.as_ref().map_or(face, |(face, _)| face);
        has_faces(face)?;
        let named = named(face);
        let face = named.as_ref().unwrap_or(face);
        Self::in_place(face, &head::find_in_place(face, &[], None)?)
    }

    /// As [`Skin::from_face`], for a head that is found already.
    ///
    /// # Errors
    /// As [`Skin::from_face`]; [`Error::Input`] if the region is of another mesh.
    pub fn from_region(face: &Face, region: &Region) -> Result<Self> {
        let in_place = aligned(face);
        let face = in_place.as_ref().map_or(face, |(face, _)| face);
        has_faces(face)?;
        let named = named(face);
        Self::in_place(named.as_ref().unwrap_or(face), region)
    }

    /// The skin of a face that is in its place. Each point of its surface is one vertex in its faces.
    fn in_place(face: &Face, region: &Region) -> Result<Self> {
        let positions = &face.neutral.positions;
        if region.vertices.len() != positions.len() {
            return Err(Error::input(format!(
                "the head is known for a mesh of {} vertices, and the neutral has {}; find it in the neutral",
                region.vertices.len(),
                positions.len()
            )));
        }
        let triangles = triangulate(&face.neutral);
        let topology = Topology::new(positions.len(), &triangles);
        let rest: Vec<DVec3> = positions.iter().copied().map(DVec3::from_array).collect();
        let axes = head::axes(face.up_axis);
        let seen = seen_of_head(positions, &triangles, region);
        let area = laplacian::laplacian(positions, &triangles).mass;
        let ahead = |v: usize| {
            let normal = normals::vertex_normal(positions, &triangles, topology.vertex_triangles.at(v));
            DVec3::from_array(normal).dot(axes.z_axis)
        };
        let mut open: Vec<bool> = (0..rest.len())
            .map(|v| region.vertices[v] && area[v] > 0.0 && seen[v] >= SEEN && ahead(v) > AHEAD)
            .collect();
        // Eyes, teeth and lashes are parts of their own.
        let with_area = triangles.iter().filter(|t| !is_degenerate(t.map(|v| rest[v as usize])));
        let (component, count) = components(rest.len(), with_area);
        let mut sizes = vec![0.0; count];
        for v in (0..rest.len()).filter(|&v| open[v]) {
            sizes[component[v] as usize] += area[v];
        }
        let largest = (0..count).max_by(|&a, &b| sizes[a].total_cmp(&sizes[b])).unwrap_or(0);
        let moved_by = |example: &Example| -> Vec<DVec3> {
            example.positions.iter().zip(&rest).map(|(x, rest)| DVec3::from_array(*x) - *rest).collect()
        };
        let displacements: Vec<Vec<DVec3>> = face.examples.iter().map(moved_by).collect();
        let moved = |v: usize| {
            let of_example = displacements.iter().filter_map(|example| example.get(v));
            of_example.map(|x| x.length()).fold(0.0, f64::max)
        };
        let moved: Vec<f64> = (0..rest.len()).map(moved).collect();
        let farthest = (0..rest.len()).filter(|&v| open[v]).map(|v| moved[v]).fold(0.0, f64::max);
        let least = (MOVES.0 / face.metres_per_unit).max(MOVES.1 * farthest);
        for (v, open) in open.iter_mut().enumerate() {
            *open &= component[v] as usize == largest;
        }
        let moves: Vec<bool> =
            (0..rest.len()).map(|v| open[v] && (face.examples.is_empty() || moved[v] > least)).collect();
        if moves.iter().filter(|open| **open).count() < 4 {
            return Err(Error::bad_topology(
                "the mesh has no place for handles: expected a face that looks along +Z where up = \"y\", or along −Y where up = \"z\", \
                 and examples that move it",
            ));
        }
        let images = mirror_images_within(positions, &face.neutral.faces, &open);
        let mut front = moves.clone();
        if let Some(profile) = &region.profile {
            let place = |v: usize| axes.transpose() * rest[v];
            let in_front = |v: &usize| open[*v] && ahead(*v) > FRONT && profile.has_in_front(place(*v));
            let in_front: Vec<usize> = (0..rest.len()).filter(in_front).collect();
            // Skin between what the examples move is of the face too, such as the bridge of the nose.
            let moving = in_front.iter().filter(|v| moves[**v]).map(|v| place(*v).truncate());
            let (low, high) = moving
                .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
            front.fill(false);
            for v in in_front {
                let place = place(v).truncate();
                front[v] = place.cmpge(low).all() && place.cmple(high).all();
            }
        } else {
            log::warn!(
                "the front of the face is not found: expected a nose between cheeks, and a chin; handles are \
                 spread over all that is seen or moves; look at the picture"
            );
        }
        if let Some(images) = &images {
            let is_in = |v: u32| front[v as usize];
            front = images.iter().zip(0..).map(|(image, v)| is_in(v) && image.is_some_and(is_in)).collect();
        }
        if front.iter().filter(|front| **front).count() < 4 {
            front.clone_from(&moves);
        }
        let is_open = |t: &&[u32; 3]| t.iter().any(|&v| open[v as usize]);
        let corners = |(i, t): (usize, &[u32; 3])| (i, t.map(|v| rest[v as usize]));
        let corners = triangles.iter().enumerate().filter(|(_, t)| is_open(t)).map(corners);
        let surface = Surface::new(corners.filter(|(_, corners)| !is_degenerate(*corners)));
        Ok(Self {
            topology,
            open,
            front,
            area,
            moves,
            surface,
            images,
            axes,
            metres_per_unit: face.metres_per_unit,
            at_vertices: face.settings.rotations,
            rest,
            triangles,
            displacements,
        })
    }

    /// Lays markers over the skin in each orientation in which they come to rest, the one that fits best
    /// first. There is at least one.
    ///
    /// `markers` may be in any unit and axes. `metres_per_unit` is their unit, if known, and `known` are the
    /// points of markers whose point is known.
    ///
    /// # Errors
    /// [`Error::Input`] for fewer than four markers.
    pub fn lay(
        &self,
        markers: &[DVec3],
        metres_per_unit: Option<f64>,
        known: &[Option<SurfacePoint>],
    ) -> Result<Vec<OntoSurface>> {
        let middle = self.middle();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for v in self.moving() {
            (low, high) = (low.min(self.rest[v]), high.max(self.rest[v]));
        }
        let extent = low.distance(high);
        let scale = metres_per_unit.map(|metres| metres / self.metres_per_unit);
        let scale = scale.unwrap_or_else(|| self.likely_scale(markers, extent));
        let start = Start {
            axes: self.axes,
            middle,
            extent,
            scales: [scale / SIZES, scale * SIZES],
            known: known.iter().map(|point| point.map(|point| self.at(&point))).collect(),
        };
        let laid = onto_surface(markers, &self.surface, &start);
        if laid.is_empty() {
            return Err(Error::no_fit(
                "fewer than four markers are seen in that frame; choose another frame",
            ));
        }
        Ok(laid)
    }

    /// Gives each marker that was laid a point of its own on the skin. `known` are the points of markers
    /// whose point is known.
    ///
    /// # Errors
    /// [`Error::Input`] for more markers than vertices.
    pub fn points(&self, laid: &OntoSurface, known: &[Option<SurfacePoint>]) -> Result<Vec<Placed>> {
        let surface = &self.surface;
        let markers = &laid.points;
        let mut placed: Vec<Option<Placed>> = vec![None; markers.len()];
        let mut taken = vec![false; self.rest.len()];
        for (placed, point) in
            placed.iter_mut().zip(known).filter_map(|(placed, point)| Some((placed, (*point)?)))
        {
            *placed = Some(Placed { point, distance: 0.0, beside: None });
            taken[point.nearest_vertex().index()] = true;
        }
        // The marker nearest to the surface gets its point first.
        let mut wishes: Vec<(f64, usize)> = (0..markers.len())
            .filter(|&i| placed[i].is_none())
            .map(|i| {
                (
                    surface
                        .closest(laid.points[i])
                        .map_or(f64::INFINITY, |c| c.point.distance(laid.points[i])),
                    i,
                )
            })
            .collect();
        wishes.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, i) in wishes {
            if let Some((point, own)) = self.inside(laid.points[i], &placed, &taken) {
                taken[own.index()] = true;
                let distance = self.at(&point).distance(laid.points[i]);
                placed[i] = Some(Placed { point, distance, beside: None });
                continue;
            }
            let nearest_of = |place: DVec3, placed: &[Option<Placed>]| {
                let far = |j: usize| Some((self.at(&placed[j].as_ref()?.point).distance(place), j));
                let all = (0..placed.len()).filter_map(far);
                all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, j)| j)
            };
            let on = surface.closest(laid.points[i]).map_or(laid.points[i], |closest| closest.point);
            let nearest = |among: &dyn Fn(usize) -> bool| {
                let near = |v: &usize| self.rest[*v].distance_squared(on);
                (0..self.rest.len())
                    .filter(|&v| self.open[v] && among(v))
                    .min_by(|a, b| near(a).total_cmp(&near(b)))
            };
            let is_free = |v: usize| !taken[v] && self.is_apart(self.rest[v], &placed);
            // A coarse mesh can have no vertex that is far enough from all the others.
            let v = nearest(&is_free)
                .or_else(|| nearest(&|v| !taken[v]))
                .ok_or_else(|| Error::out_of_range("there are more markers than vertices for them"))?;
            let wished = nearest(&|_| true).map_or(on, |wished| self.rest[wished]);
            let beside = match (self.is_apart(on, &placed), self.rest[v] == wished) {
                (true, true) => None,
                (true, false) => nearest_of(wished, &placed),
                (false, _) => nearest_of(on, &placed),
            };
            taken[v] = true;
            let point = VertexId::from_index(v).into();
            placed[i] = Some(Placed { point, distance: self.rest[v].distance(laid.points[i]), beside });
        }
        Ok(placed.into_iter().flatten().collect())
    }

    /// Where a point of the mesh is at rest.
    pub fn at(&self, point: &SurfacePoint) -> DVec3 {
        DVec3::from_array(point.mean(|v| self.rest[v.index()].to_array()))
    }

    /// The point of the skin closest to a marker, and the corner of its triangle that no other marker may
    /// have. `None` if it is not far enough from a vertex or from the `placed` markers, or has no free
    /// corner.
    fn inside(
        &self,
        marker: DVec3,
        placed: &[Option<Placed>],
        taken: &[bool],
    ) -> Option<(SurfacePoint, VertexId)> {
        let is_open = |t: usize| self.triangles[t].iter().all(|&v| self.open[v as usize]);
        let found =
            self.surface.closest_that(marker, f64::INFINITY, is_open).filter(|_| !self.at_vertices)?;
        let point = SurfacePoint::new(self.triangles[found.triangle].map(VertexId), found.weights)?;
        let corner = self.rest[point.nearest_vertex().index()];
        let off = self.at(&point).distance(corner) * self.metres_per_unit;
        if off < AT_VERTEX || !self.is_apart(self.at(&point), placed) {
            return None;
        }
        let is_free = |(v, weight): &(VertexId, f64)| !taken[v.index()] && *weight >= LEAST_OWN;
        let own = point.corners().filter(is_free).max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((point, own.0))
    }

    /// Whether a place is not that of another marker.
    fn is_apart(&self, place: DVec3, placed: &[Option<Placed>]) -> bool {
        placed.iter().flatten().all(|other| self.are_apart(self.at(&other.point), place))
    }

    /// Whether two places are far enough from each other for a marker at each.
    pub fn are_apart(&self, a: DVec3, b: DVec3) -> bool {
        a.distance(b) * self.metres_per_unit >= APART
    }

    /// The face's right, up and forward axes, of length 1.
    pub fn axes(&self) -> DMat3 {
        self.axes
    }

    /// The middle of what examples move, or of the skin without examples.
    pub fn middle(&self) -> DVec3 {
        self.moving().map(|v| self.rest[v]).sum::<DVec3>() / self.moving().count() as f64
    }

    /// The distance of a point from the skin, in mesh units.
    pub fn distance(&self, point: DVec3) -> f64 {
        self.surface.closest(point).map_or(f64::INFINITY, |closest| closest.point.distance(point))
    }

    /// For each example, how far it moves each of the V vertices, in mesh units.
    pub fn displacements(&self) -> &[Vec<DVec3>] {
        &self.displacements
    }

    /// The vertices for handles that are at most `reach` from a place, in mesh units.
    pub fn vertices_within(&self, place: DVec3, reach: f64) -> Vec<VertexId> {
        let is_near = |v: &usize| self.open[*v] && self.rest[*v].distance(place) <= reach;
        (0..self.rest.len()).filter(is_near).map(VertexId::from_index).collect()
    }

    /// The vertices that some example moves.
    fn moving(&self) -> impl Iterator<Item = usize> {
        (0..self.rest.len()).filter(|&v| self.moves[v])
    }

    /// The likely scale of the markers: the spread of the markers is about the size of the face in that unit.
    /// Units are metres, centimetres, millimetres and inches.
    fn likely_scale(&self, markers: &[DVec3], extent: f64) -> f64 {
        let bounds =
            markers.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
        let spread = bounds.0.distance(bounds.1);
        let units = [1.0, 0.01, 0.001, 0.0254].map(|metres| metres / self.metres_per_unit);
        let off = |scale: f64| (scale * spread / (0.9 * extent)).ln().abs();
        units.into_iter().min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(1.0)
    }
}

fn has_faces(face: &Face) -> Result<()> {
    let faces = &face.neutral.faces;
    if faces.fault(face.neutral.positions.len()).is_some() || faces.is_empty() {
        return Err(Error::bad_topology(
            "the neutral mesh has no faces, or a face with a fault; the doctor says what is wrong with it",
        )
        .with_remedies(&[Remedy::Examine]));
    }
    Ok(())
}

/// The exposure of the head's vertices, V. Only its eyeballs hide them as well: a handle may lie under hair.
pub(crate) fn seen_of_head(positions: &[[f64; 3]], triangles: &[[u32; 3]], region: &Region) -> Vec<f64> {
    let kept: Vec<usize> = (0..positions.len()).filter(|&v| region.vertices[v] || region.is_eye[v]).collect();
    let mut numbers = vec![None; positions.len()];
    for (number, &v) in (0_u32..).zip(&kept) {
        numbers[v] = Some(number);
    }
    let renumbered = |[a, b, c]: &[u32; 3]| -> Option<[u32; 3]> {
        Some([numbers[*a as usize]?, numbers[*b as usize]?, numbers[*c as usize]?])
    };
    let triangles: Vec<[u32; 3]> = triangles.iter().filter_map(renumbered).collect();
    let places: Vec<[f64; 3]> = kept.iter().map(|&v| positions[v]).collect();
    let mut seen = vec![0.0; positions.len()];
    for (v, exposure) in
        kept.iter().zip(exposure(&places, &triangles, &Topology::new(kept.len(), &triangles)))
    {
        seen[*v] = exposure;
    }
    seen
}
