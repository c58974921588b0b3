//! Faces whose files have some points of the surface as several vertices, as glTF at texture seams.
//!
//! The solve sees each point once. The rig has the file's vertices again.
use crate::{LeaveOneOut, SolveReport, Solved};
use rhytid_core::{
    Contact, Example, Eyeball, Face, Faces, FineScale, HandleSet, Handles, Influences, Learned, LidVertex,
    Mesh, Openings, Pins, Prior, Result, Rig, RigParts, RimFollower, RimVertex, Surface, Table, VertexId,
};
use rhytid_geometry::{Points, triangulate};

/// The points of a face, some of which are several vertices.
///
/// `None` if the settings join no vertices, or if each vertex is a point of its own. The face may have
/// faults: a mesh or an example that is damaged joins nothing.
pub fn points(face: &Face) -> Option<Points> {
    let neutral = &face.neutral;
    let vertices = neutral.positions.len();
    if !face.settings.weld || neutral.faces.fault(vertices).is_some() {
        return None;
    }
    let examples: Vec<&[[f64; 3]]> = face.examples.iter().map(|example| &*example.positions).collect();
    if examples.iter().any(|positions| positions.len() != vertices) {
        return None;
    }
    Points::new(neutral, &examples)
}

/// A face with one vertex for each point.
pub struct Welded {
    /// The points of the face that was welded.
    pub points: Points,
    /// The face, without texture coordinates and materials.
    pub face: Face,
}

impl Welded {
    /// `None` as for [`points`].
    ///
    /// # Panics
    /// If the face has a handle or a pin that is no vertex. [`check`](crate::check) finds it.
    pub fn new(face: &Face) -> Option<Self> {
        let points = points(face)?;
        let chosen = |positions: &[[f64; 3]]| points.first.iter().map(|v| positions[v.index()]).collect();
        let point = |v: VertexId| VertexId(points.of_vertex[v.index()]);
        let example =
            |example: &Example| Example { positions: chosen(&example.positions), ..example.clone() };
        // What other faces do can differ a little between the vertices of a point.
        let expression = |expression: &Example| {
            let mut positions = expression.positions.clone();
            points.even_out(&mut positions);
            Example { positions: chosen(&positions), ..expression.clone() }
        };
        let prior = face.prior.as_ref().map(|prior| Prior {
            expressions: prior.expressions.iter().map(expression).collect(),
            weight: prior.weight,
        });
        let mut pinned: Vec<VertexId> = face.settings.pins.vertices.iter().map(|&v| point(v)).collect();
        pinned.sort_unstable();
        pinned.dedup();
        let mut settings = face.settings.clone();
        settings.pins = Pins { vertices: pinned, ..settings.pins };
        let welded = Face {
            name: face.name.clone(),
            neutral: Mesh {
                positions: chosen(&face.neutral.positions),
                faces: renamed(&face.neutral.faces, |v| points.of_vertex[v as usize]),
                uvs: None,
                materials: None,
            },
            metres_per_unit: face.metres_per_unit,
            up_axis: face.up_axis,
            handles: Handles {
                labels: face.handles.labels.clone(),
                points: face.handles.points.iter().map(|at| at.renamed(point)).collect(),
            },
            examples: face.examples.iter().map(example).collect(),
            prior,
            settings,
        };
        Some(Self { points, face: welded })
    }

    /// What was solved for the points, for the vertices of `face`.
    ///
    /// # Errors
    /// As [`Rig::new`].
    pub(crate) fn expanded(&self, solved: Solved, face: &Face) -> Result<Solved> {
        let rig = self.rig(solved.rig.into_parts(), face)?;
        let first = |v: VertexId| self.points.first[v.index()];
        let mut report: SolveReport = solved.report;
        report.parts.iter_mut().for_each(|part| part.first_vertex = first(part.first_vertex));
        report.eyeballs.iter_mut().for_each(|eyeball| eyeball.first_vertex = first(eyeball.first_vertex));
        let left_out = solved.left_out.map(|left_out| LeaveOneOut {
            errors: self.rows(&left_out.errors),
            of_shell: self.rows(&left_out.of_shell),
            skin_area: self.shares(&left_out.skin_area),
        });
        Ok(Solved { rig, report, left_out })
    }

    fn rig(&self, parts: RigParts<f64>, face: &Face) -> Result<Rig<f64>> {
        let first = |v: VertexId| self.points.first[v.index()];
        let neutral = &face.neutral;
        let surface = Surface {
            faces: neutral.faces.clone(),
            uvs: neutral.uvs.clone(),
            materials: neutral.materials.clone(),
            triangles: triangulate(neutral),
            rest: self.each(&parts.surface.rest),
            tangent_neighbors: self.each(&parts.surface.tangent_neighbors).into_iter().map(first).collect(),
            joined: Some(self.points.first_of_each()),
            ..parts.surface
        };
        Rig::new(RigParts {
            surface,
            handles: HandleSet {
                points: parts.handles.points.iter().map(|at| at.renamed(first)).collect(),
                ..parts.handles
            },
            basis: self.rows(&parts.basis),
            influences: Influences {
                edges: self.rows(&parts.influences.edges),
                weights: self.rows(&parts.influences.weights),
                beta: parts.influences.beta,
            },
            fine_scale: FineScale {
                rbf_weights: self.rows(&parts.fine_scale.rbf_weights),
                pose_features: parts.fine_scale.pose_features,
            },
            learned: parts.learned.map(|learned| Learned {
                anchors: self.rows(&learned.anchors),
                anchor_weights: self.rows(&learned.anchor_weights),
                feature_gains: self.rows(&learned.feature_gains),
                example_weights: self.rows(&learned.example_weights),
                variances: self.each(&learned.variances),
                contact: self.contact(&learned.contact),
                ..learned
            }),
            examples: parts.examples,
            bending_length: parts.bending_length,
        })
    }

    /// The contact of the vertices. What moves names all vertices of its points, and all else the lowest.
    fn contact(&self, contact: &Contact<f64>) -> Contact<f64> {
        let first = |v: VertexId| self.points.first[v.index()];
        let eyeball = |eyeball: &Eyeball<f64>| Eyeball { corners: eyeball.corners.map(first), ..*eyeball };
        let mut lids: Vec<LidVertex<f64>> =
            contact.lids.iter().map(|lid| LidVertex { vertex: first(lid.vertex), ..*lid }).collect();
        let vertices = self.vertices_of_points();
        // Lids name each other by their places in the list, so the others come after them.
        for lid in &contact.lids {
            let others = vertices[lid.vertex.index()].iter().skip(1);
            lids.extend(others.map(|&vertex| LidVertex { vertex, ..*lid }));
        }
        let rim = |rim: &RimVertex<f64>| RimVertex { vertex: first(rim.vertex), ..*rim };
        let followers = contact.openings.followers.iter().flat_map(|follower| {
            vertices[follower.vertex.index()].iter().map(|&vertex| RimFollower { vertex, ..*follower })
        });
        Contact {
            eyeballs: contact.eyeballs.iter().map(eyeball).collect(),
            lids,
            openings: Openings {
                rims: contact.openings.rims.iter().map(rim).collect(),
                followers: followers.collect(),
            },
        }
    }

    /// The vertices of each point, ascending.
    fn vertices_of_points(&self) -> Vec<Vec<VertexId>> {
        let mut vertices = vec![Vec::new(); self.points.len()];
        for (v, &point) in self.points.of_vertex.iter().enumerate() {
            vertices[point as usize].push(VertexId::from_index(v));
        }
        vertices
    }

    /// V elements from those of the U points.
    pub fn each<E: Clone>(&self, of_points: &[E]) -> Vec<E> {
        self.points.of_vertex.iter().map(|&point| of_points[point as usize].clone()).collect()
    }

    fn rows<E: Clone>(&self, of_points: &Table<E>) -> Table<E> {
        of_points.chosen(self.points.of_vertex.iter().map(|&point| point as usize))
    }

    /// Numbers of points, each shared out evenly among its vertices, so that their sum stays.
    fn shares(&self, of_points: &[f64]) -> Vec<f64> {
        let mut counts = vec![0.0; of_points.len()];
        self.points.of_vertex.iter().for_each(|&point| counts[point as usize] += 1.0);
        let share = |&point: &u32| of_points[point as usize] / counts[point as usize];
        self.points.of_vertex.iter().map(share).collect()
    }
}

/// Faces with other names for their vertices.
fn renamed(faces: &Faces, name: impl Fn(u32) -> u32) -> Faces {
    Faces { counts: faces.counts.clone(), indices: faces.indices.iter().map(|&v| name(v)).collect() }
}

/// The face with the lowest vertex of each point in the place of its others, which are in no face then.
/// Vertices keep their numbers, so messages name those of the file.
pub(crate) fn named_by_first(face: &Face, points: &Points) -> Face {
    let first = points.first_of_each();
    let of = |v: VertexId| first.get(v.index()).copied().unwrap_or(v);
    let mut named = face.clone();
    named.neutral.faces = renamed(&face.neutral.faces, |v| of(VertexId(v)).0);
    named.handles.points.iter_mut().for_each(|point| *point = point.renamed(of));
    named.settings.pins.vertices.iter_mut().for_each(|v| *v = of(*v));
    named
}
