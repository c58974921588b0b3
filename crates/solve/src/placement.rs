//! Handles placed on a mesh: spread over its front, or where a frame's markers are.
use crate::align::aligned;
use crate::exposure::exposure;
use crate::mirror::mirror_images;
use crate::welded::{Welded, named_by_first};
use glam::{DMat3, DVec3};
use rhytid_core::{Error, Face, Remedy, Result, SurfacePoint, UpAxis, VertexId};
use rhytid_geometry::geodesic::EdgeGraph;
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

/// A vertex that no example moves by more does not belong to the face, as at the neck and the ears.
///
/// The bounds are in metres, and as a part of the movement of the vertex that moves farthest.
const MOVES: (f64, f64) = (1e-3, 0.08);

/// A point that is nearer to a vertex than this, in metres, is that vertex: markers are not seen more
/// exactly.
const AT_VERTEX: f64 = 1e-4;

/// Two markers in the same triangle are at least so far apart, in metres.
const APART: f64 = 5e-4;

/// The least weight of the corner that a marker inside a triangle has for itself. With less, markers at the
/// other corners would leave it no choice.
const LEAST_OWN: f64 = 0.1;

/// The largest ratio between an actor's size and the mesh's, either way.
const SIZES: f64 = 1.25;

/// The part of a mesh that a marker can be glued to.
pub struct Skin {
    rest: Vec<DVec3>,
    topology: Topology,
    /// V: whether a vertex may be a handle.
    open: Vec<bool>,
    /// V: whether some example moves such a vertex; true for all of them without examples.
    moves: Vec<bool>,
    /// The corners of all triangles.
    triangles: Vec<[u32; 3]>,
    /// The triangles at vertices that may be handles.
    surface: Surface,
    /// The mirror image of each vertex, if the mesh is symmetric.
    images: Option<Vec<u32>>,
    /// The face's right, up and forward axes.
    axes: DMat3,
    metres_per_unit: f64,
    /// Whether handles can be at vertices alone.
    at_vertices: bool,
}

/// A marker on the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    /// The point of the skin that it holds.
    pub point: SurfacePoint,
    /// The distance of that point from the place of the marker, in mesh units.
    pub distance: f64,
    /// Whether the nearest point is too near other markers, so that the marker got the next free vertex.
    pub aside: bool,
}

/// V: the lowest vertex at the mirror image of each vertex's point. `None` if some point has none.
fn images_of_points(welded: &Welded) -> Option<Vec<u32>> {
    let Welded { points, face } = welded;
    let name = |point: usize| points.first[point];
    let images = mirror_images(&face.neutral.positions, &face.neutral.faces, name).ok()?;
    Some(points.of_vertex.iter().map(|&point| name(images[point as usize] as usize).0).collect())
}

impl Skin {
    /// The skin of a face, on which handles lie at any point or, where they turn, at vertices. It is the
    /// outside of its largest part, without the back of the head.
    ///
    /// The insides of mouth and nostrils and the parts behind lids are left out. The face's handles do not
    /// matter.
    ///
    /// # Errors
    /// [`Error::Input`] if nothing is left. This is so for a mesh without faces, and for one that looks
    /// another way than along +Z (up Y) or −Y (up Z).
    pub fn from_face(face: &Face) -> Result<Self> {
        let in_place = aligned(face);
        let face = in_place.as_ref().map_or(face, |(face, _)| face);
        let welded = Welded::new(face);
        let named = welded.as_ref().map(|welded| named_by_first(face, &welded.points));
        let face = named.as_ref().unwrap_or(face);
        let positions = &face.neutral.positions;
        if face.neutral.faces.fault(positions.len()).is_some() || face.neutral.faces.is_empty() {
            return Err(Error::bad_topology(
                "the neutral mesh has no faces, or a face with a fault; the doctor says what is wrong with \
                 it",
            )
            .with_remedies(&[Remedy::Examine]));
        }
        let triangles = triangulate(&face.neutral);
        let topology = Topology::new(positions.len(), &triangles);
        let rest: Vec<DVec3> = positions.iter().copied().map(DVec3::from_array).collect();
        let axes = match face.up_axis {
            UpAxis::Y => DMat3::IDENTITY,
            UpAxis::Z => DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y),
        };
        let seen = exposure(positions, &triangles, &topology);
        let area = laplacian::laplacian(positions, &triangles).mass;
        let ahead = |v: usize| {
            let normal = normals::vertex_normal(positions, &triangles, topology.vertex_triangles.at(v));
            DVec3::from_array(normal).dot(axes.z_axis) > AHEAD
        };
        let mut open: Vec<bool> =
            (0..rest.len()).map(|v| area[v] > 0.0 && seen[v] >= SEEN && ahead(v)).collect();
        // Eyes, teeth and lashes are parts of their own.
        let with_area = triangles.iter().filter(|t| !is_degenerate(t.map(|v| rest[v as usize])));
        let (component, count) = components(rest.len(), with_area);
        let mut sizes = vec![0.0; count];
        for v in (0..rest.len()).filter(|&v| open[v]) {
            sizes[component[v] as usize] += area[v];
        }
        let largest = (0..count).max_by(|&a, &b| sizes[a].total_cmp(&sizes[b])).unwrap_or(0);
        let moved = |v: usize| {
            let of_example = face.examples.iter().filter_map(|example| example.positions.get(v));
            of_example.map(|x| DVec3::from_array(*x).distance(rest[v])).fold(0.0, f64::max)
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
        let images = match &welded {
            Some(welded) => images_of_points(welded),
            None => mirror_images(positions, &face.neutral.faces, VertexId::from_index).ok(),
        };
        let is_open = |t: &&[u32; 3]| t.iter().any(|&v| open[v as usize]);
        let corners = |(i, t): (usize, &[u32; 3])| (i, t.map(|v| rest[v as usize]));
        let corners = triangles.iter().enumerate().filter(|(_, t)| is_open(t)).map(corners);
        let surface = Surface::new(corners.filter(|(_, corners)| !is_degenerate(*corners)));
        Ok(Self {
            topology,
            open,
            moves,
            surface,
            images,
            axes,
            metres_per_unit: face.metres_per_unit,
            at_vertices: face.settings.rotations,
            rest,
            triangles,
        })
    }

    /// Vertices for `count` handles, spread over the vertices that the examples move, after the `kept` ones.
    ///
    /// Each next vertex is the farthest along the mesh from those before it. On a symmetric mesh the handles
    /// are symmetric too, and there may be one more or less.
    pub fn spread(&self, count: usize, kept: &[VertexId]) -> Vec<VertexId> {
        let rest: Vec<[f64; 3]> = self.rest.iter().map(DVec3::to_array).collect();
        let graph = EdgeGraph::new(&rest, &self.topology);
        let mut nearest = vec![f64::INFINITY; self.rest.len()];
        let mut chosen: Vec<VertexId> = Vec::new();
        let add = |v: VertexId, nearest: &mut Vec<f64>, chosen: &mut Vec<VertexId>| {
            chosen.push(v);
            let mut distances = vec![0.0; nearest.len()];
            let before = nearest.clone();
            graph.distances(&v.into(), |w| before[w as usize], &mut distances);
            for (near, distance) in nearest.iter_mut().zip(distances) {
                *near = near.min(distance);
            }
        };
        kept.iter().for_each(|&v| add(v, &mut nearest, &mut chosen));
        if chosen.is_empty() {
            // The foremost vertex, usually the tip of the nose.
            let forward = |v: &usize| self.rest[*v].dot(self.axes.z_axis);
            let first = self.moving().max_by(|a, b| forward(a).total_cmp(&forward(b)));
            first.into_iter().for_each(|v| add(VertexId::from_index(v), &mut nearest, &mut chosen));
        }
        while chosen.len() < count {
            let farthest = self.moving().filter(|&v| !chosen.contains(&VertexId::from_index(v)));
            let Some(v) = farthest.max_by(|&a, &b| nearest[a].total_cmp(&nearest[b]).then(b.cmp(&a))) else {
                break;
            };
            let image = VertexId(self.images.as_ref().map_or(v as u32, |images| images[v]));
            let apart = self.rest[v].distance(self.rest[image.index()]);
            let alone = nearest[v];
            add(VertexId::from_index(v), &mut nearest, &mut chosen);
            // Near the middle, one handle is enough for both sides.
            if apart > 0.5 * alone && self.moves[image.index()] && !chosen.contains(&image) {
                add(image, &mut nearest, &mut chosen);
            }
        }
        chosen
    }

    /// Labels for spread handles: `m01`, `m02` and so on.
    ///
    /// Mirror images share a number and end with `_l` and `_r`. Left is the face's own left side, +x.
    pub fn labels(&self, vertices: &[VertexId]) -> Vec<String> {
        let mut labels = vec![String::new(); vertices.len()];
        let mut number = 0;
        for i in 0..vertices.len() {
            if !labels[i].is_empty() {
                continue;
            }
            number += 1;
            let image = self.images.as_ref().map(|images| VertexId(images[vertices[i].index()]));
            let other = image.filter(|image| *image != vertices[i]);
            match other.and_then(|image| vertices.iter().position(|v| *v == image)) {
                Some(j) => {
                    let is_left = self.rest[vertices[i].index()].x > self.rest[vertices[j].index()].x;
                    let sides = if is_left { ["l", "r"] } else { ["r", "l"] };
                    labels[i] = format!("m{number:02}_{}", sides[0]);
                    labels[j] = format!("m{number:02}_{}", sides[1]);
                }
                None => labels[i] = format!("m{number:02}"),
            }
        }
        labels
    }

    /// Lays markers over the skin, and gives each marker a point of its own.
    ///
    /// `markers` may be in any unit and axes. `metres_per_unit` is their unit, if known, and `known` are the
    /// points of markers whose point is known.
    ///
    /// # Errors
    /// [`Error::Input`] for fewer than four markers.
    pub fn place(
        &self,
        markers: &[DVec3],
        metres_per_unit: Option<f64>,
        known: &[Option<SurfacePoint>],
    ) -> Result<(OntoSurface, Vec<Placed>)> {
        let surface = &self.surface;
        let mut middle = DVec3::ZERO;
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for v in self.moving() {
            middle += self.rest[v];
            (low, high) = (low.min(self.rest[v]), high.max(self.rest[v]));
        }
        middle /= self.moving().count() as f64;
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
        let laid = onto_surface(markers, surface, &start).ok_or_else(|| {
            Error::no_fit("fewer than four markers are seen in that frame; choose another frame")
        })?;
        let mut placed: Vec<Option<Placed>> = vec![None; markers.len()];
        let mut taken = vec![false; self.rest.len()];
        for (placed, point) in
            placed.iter_mut().zip(known).filter_map(|(placed, point)| Some((placed, (*point)?)))
        {
            *placed = Some(Placed { point, distance: 0.0, aside: false });
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
                placed[i] = Some(Placed { point, distance, aside: false });
                continue;
            }
            let on = surface.closest(laid.points[i]).map_or(laid.points[i], |closest| closest.point);
            let nearest = |among: &dyn Fn(usize) -> bool| {
                let near = |v: &usize| self.rest[*v].distance_squared(on);
                (0..self.rest.len())
                    .filter(|&v| self.open[v] && among(v))
                    .min_by(|a, b| near(a).total_cmp(&near(b)))
            };
            let v = nearest(&|v| !taken[v])
                .ok_or_else(|| Error::out_of_range("there are more markers than vertices for them"))?;
            let aside = nearest(&|_| true) != Some(v);
            taken[v] = true;
            let point = VertexId::from_index(v).into();
            placed[i] = Some(Placed { point, distance: self.rest[v].distance(laid.points[i]), aside });
        }
        Ok((laid, placed.into_iter().flatten().collect()))
    }

    /// Where a point is at rest.
    fn at(&self, point: &SurfacePoint) -> DVec3 {
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
        let metres = |a: DVec3, b: DVec3| a.distance(b) * self.metres_per_unit;
        if metres(self.at(&point), self.rest[point.nearest_vertex().index()]) < AT_VERTEX {
            return None;
        }
        let shares = |other: &SurfacePoint| other.corners().any(|(v, _)| point.has(v));
        let mut near = placed.iter().flatten().filter(|other| shares(&other.point));
        if near.any(|other| metres(self.at(&other.point), self.at(&point)) < APART) {
            return None;
        }
        let is_free = |(v, weight): &(VertexId, f64)| !taken[v.index()] && *weight >= LEAST_OWN;
        let own = point.corners().filter(is_free).max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((point, own.0))
    }

    /// The distance of a point from the skin, in mesh units.
    pub fn distance(&self, point: DVec3) -> f64 {
        self.surface.closest(point).map_or(f64::INFINITY, |closest| closest.point.distance(point))
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
