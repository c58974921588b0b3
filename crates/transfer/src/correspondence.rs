//! The correspondence of two faces: each vertex of the second has a place on the first.
//!
//! It also has how the surface turns, grows and stretches from the first face to the second.
use crate::gradients::{Local, gradients, local, turned_over};
use crate::landmarks::{Landmarks, at_point};
use crate::skin::Skin;
use crate::warp::warp;
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use rhytid_core::{Face, Mesh, Progress, Result, Rig, Surface, SurfacePoint, VertexId};
use rhytid_geometry::Topology;
use rhytid_geometry::registration::Similarity;
use rhytid_geometry::triangulate;
use rhytid_kernels::normals::VertexTriangles;
use rhytid_solve::DrivenComponents;
use serde::Serialize;

/// The search distance of a counterpart, in spacings of the handles. Beyond the border of the first face, the
/// shorter one holds.
const WITHIN: f64 = 0.25;
const BEYOND: f64 = 0.125;

/// The bound of torn edges, and the most passes of their search.
///
/// An edge is torn if its ends move apart by more than `TORN[0] + TORN[1] · s` of its length. Here s is the
/// largest stretch of the first face there. The search is repeated while torn edges are found.
const TORN: [f64; 2] = [0.75, 1.0];
const PASSES: usize = 8;

/// A piece between tears is in the wrong place if it has less than one part in this many of all vertices with
/// a counterpart.
const SMALL: usize = 20;

/// Why a vertex has no counterpart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Missing {
    /// Its part of the mesh has no landmark: eyes, teeth, lashes.
    OtherPart,
    /// The first face ends before it: the back of a head beside a mask.
    BeyondTheBorder,
    /// The surface nearby faces another way: the mouth's lining, the nostrils.
    FacesAway,
    /// No surface is near.
    TooFar,
    /// The surface nearby does not move as that at the vertices around: the other lip.
    Elsewhere,
}

/// A place on the first face: its three vertices and their weights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    /// Vertices of a triangle, or three times the same.
    pub corners: [u32; 3],
    /// Their weights, from 0 to 1, with a sum of 1.
    pub weights: [f64; 3],
    /// The distance of the vertex from the place once the faces lie on each other, in units of the second
    /// face.
    pub distance: f64,
}

impl Place {
    /// The place at a point of the first face.
    pub(crate) fn at(point: SurfacePoint) -> Self {
        Self { corners: point.triangle().map(|v| v.0), weights: point.weights(), distance: 0.0 }
    }

    /// The weighted mean of the corners' values.
    pub(crate) fn mean<T: std::ops::Mul<f64, Output = T> + std::iter::Sum + Copy>(&self, values: &[T]) -> T {
        self.corners.iter().zip(self.weights).map(|(&v, w)| values[v as usize] * w).sum()
    }
}

/// The places of the second face's vertices on the first face.
pub(crate) struct Correspondence {
    /// The place of each vertex of the second face, or why it has none.
    pub places: Vec<Result<Place, Missing>>,
    /// The change of the surface from the first face to the second at each place. A vertex without a place
    /// has the change of the similarity.
    pub locals: Vec<Local>,
    /// The change of the surface at each landmark of the first face.
    pub at_landmarks: Vec<Local>,
    /// V: whether a vertex of the second face is in a part with a landmark.
    pub takes_part: Vec<bool>,
    /// The similarity from the first face to the second.
    pub overall: Similarity,
    /// Whether both have the same faces, so that vertices correspond by their numbers.
    pub same_topology: bool,
    /// Triangles of the first face that the warp turns over.
    pub turned_over: Vec<usize>,
    /// The distance of each landmark of the first face from its partner after the warp.
    pub landmark_distances: Vec<f64>,
}

/// The correspondence of two faces by their landmarks. `spacing` is the approximate distance between handles
/// of the second face.
///
/// # Errors
/// As [`warp`].
pub(crate) fn correspondence(
    from: &Rig,
    to: &Face,
    landmarks: &Landmarks,
    overall: Similarity,
    spacing: f64,
    progress: &dyn Progress,
) -> Result<Correspondence> {
    let rest: Vec<DVec3> = from.surface().rest.iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
    let to_rest: Vec<DVec3> = to.neutral.positions.iter().copied().map(DVec3::from_array).collect();
    let triangles = triangulate(&to.neutral);
    let side = |i: usize| -> Vec<SurfacePoint> { landmarks.pairs.iter().map(|pair| pair[i]).collect() };
    let takes_part = DrivenComponents::new(&to.neutral.positions, &triangles, &side(1)).driven;
    let numbers = numbers(from.surface(), &to.neutral);
    let same_topology = numbers.is_some();
    // Whether the second face has one vertex for each point of the first.
    let is_joined = rest.len() != to_rest.len();
    let whole = DMat3::from_quat(overall.rotation) * overall.scale;
    let joined = from.surface().joined_triangles();
    let (at_from, warped, places) = if let Some(numbers) = numbers {
        let vertices = (0..rest.len() as u32).filter(|&v| !is_joined || from.surface().first(v) == v);
        let places = vertices.map(|v| Ok(Place::at(VertexId(v).into()))).collect();
        let warped = numbers.iter().map(|&number| to_rest[number as usize]).collect();
        (from.surface().vertex_triangles(), warped, places)
    } else {
        let scaled: Vec<DVec3> = rest.iter().map(|p| overall.apply(*p)).collect();
        let from_part = DrivenComponents::of_surface(from.surface(), &side(0)).driven;
        let here = Skin::new(scaled, &joined, from_part);
        let there = Skin::new(to_rest, &triangles, takes_part.clone());
        let warped = warp(&here, &there, &landmarks.pairs, spacing, progress)?;
        progress.step("correspondence", 0, 1)?;
        let places = places(&here, &warped, &there, spacing);
        progress.step("correspondence", 1, 1)?;
        (here.at_vertices, warped, places)
    };
    let of_vertices = gradients(&rest, &warped, &from.surface().triangles, &at_from, whole);
    let as_a_whole =
        Local { rotation: DMat3::from_quat(overall.rotation), scale: overall.scale, anisotropy: 1.0 };
    let at = |place: &Result<Place, Missing>| {
        place.as_ref().ok().and_then(|place| local(place.mean(&of_vertices))).unwrap_or(as_a_whole)
    };
    // Vertices that take no part are where the similarity put them.
    let takes_part_here =
        |t: &[u32; 3]| t.iter().any(|&v| warped[v as usize] != overall.apply(rest[v as usize]));
    Ok(Correspondence {
        locals: places.par_iter().map(at).collect(),
        at_landmarks: side(0).into_iter().map(|point| at(&Ok(Place::at(point)))).collect(),
        places,
        takes_part,
        overall,
        same_topology,
        turned_over: turned_over(&rest, &warped, &from.surface().triangles, &of_vertices, takes_part_here),
        landmark_distances: landmarks
            .pairs
            .iter()
            .map(|[a, b]| at_point(a, &warped).distance(DVec3::from_array(b.at(&to.neutral.positions))))
            .collect(),
    })
}

/// For each vertex of a rig, the vertex of a mesh that has the same faces. The mesh may have one vertex for
/// each point of the rig. `None` if the faces differ.
fn numbers(surface: &Surface, to: &Mesh) -> Option<Vec<u32>> {
    let vertices = surface.rest.len() as u32;
    if surface.faces == to.faces && surface.rest.len() == to.positions.len() {
        return Some((0..vertices).collect());
    }
    surface.joined.as_ref()?;
    let (mut numbers, mut count) = (Vec::with_capacity(surface.rest.len()), 0);
    for v in 0..vertices {
        let first = surface.first(v);
        numbers.push(if first == v { count } else { numbers[first as usize] });
        count += u32::from(first == v);
    }
    let named = surface.faces.indices.iter().map(|&v| numbers[v as usize]);
    let is_same = count as usize == to.positions.len()
        && surface.faces.counts == to.faces.counts
        && named.eq(to.faces.indices.iter().copied());
    is_same.then_some(numbers)
}

/// The closest place of `here` that faces the same way, for each vertex of `there`. `warped` are the vertices
/// of `here` after the warp.
fn places(here: &Skin<'_>, warped: &[DVec3], there: &Skin<'_>, spacing: f64) -> Vec<Result<Place, Missing>> {
    let surface = here.facing(warped);
    let place = |v: usize| {
        if !there.takes_part[v] {
            return Err(Missing::OtherPart);
        }
        let (p, within) = (there.positions[v], WITHIN * spacing);
        let Some(closest) = surface.closest(p, there.normals[v], within) else {
            let is_near = surface.has_any(p, within);
            return Err(if is_near { Missing::FacesAway } else { Missing::TooFar });
        };
        let distance = closest.point.distance(p);
        if distance > BEYOND * spacing && here.is_border(&closest) {
            return Err(Missing::BeyondTheBorder);
        }
        Ok(Place { corners: here.triangles[closest.triangle], weights: closest.weights, distance })
    };
    (0..there.positions.len()).into_par_iter().map(place).collect()
}

impl Correspondence {
    /// Takes out places that are away from those of the vertices around, as on the other lip.
    ///
    /// Most of the edges at such a vertex would be torn when the first face moves. `examples` has two lists
    /// for each example: the displacements of the second face's vertices, in its units, and the [`stretches`]
    /// of the first face's.
    pub(crate) fn take_out_tears(
        &mut self,
        rest: &[[f64; 3]],
        triangles: &[[u32; 3]],
        examples: &[(Vec<DVec3>, Vec<f64>)],
    ) {
        let around = Topology::new(rest.len(), triangles);
        let at = |v: usize| DVec3::from_array(rest[v]);
        let is_torn = |places: &[Result<Place, Missing>], v: usize, w: usize| {
            let (Ok(here), Ok(there)) = (&places[v], &places[w]) else { return None };
            let edge = at(v).distance(at(w));
            Some(examples.iter().any(|(moved, stretches)| {
                let corners = here.corners.iter().chain(&there.corners);
                let most = corners.map(|&c| stretches[c as usize]).fold(0.0, f64::max);
                moved[v].distance(moved[w]) > (TORN[0] + TORN[1] * most) * edge
            }))
        };
        for _ in 0..PASSES {
            let mostly_torn = |&v: &usize| {
                let others = around.neighbors(v).iter().filter_map(|&w| is_torn(&self.places, v, w as usize));
                let (torn, whole): (Vec<bool>, Vec<bool>) = others.partition(|torn| *torn);
                torn.len() > whole.len()
            };
            let torn: Vec<usize> = (0..rest.len()).into_par_iter().filter(mostly_torn).collect();
            if torn.is_empty() {
                break;
            }
            torn.into_iter().for_each(|v| self.places[v] = Err(Missing::Elsewhere));
        }
        // Pieces that tears cut off from the rest.
        let mut piece = vec![usize::MAX; rest.len()];
        let mut pieces: Vec<Vec<usize>> = Vec::new();
        for first in 0..rest.len() {
            if piece[first] != usize::MAX || self.places[first].is_err() {
                continue;
            }
            let (mut members, mut next) = (vec![first], 0);
            piece[first] = pieces.len();
            while let Some(&v) = members.get(next) {
                next += 1;
                for w in around.neighbors(v).iter().map(|&w| w as usize) {
                    if piece[w] == usize::MAX && is_torn(&self.places, v, w) == Some(false) {
                        piece[w] = pieces.len();
                        members.push(w);
                    }
                }
            }
            pieces.push(members);
        }
        let all: usize = pieces.iter().map(Vec::len).sum();
        for v in pieces.into_iter().filter(|members| members.len() < all / SMALL).flatten() {
            self.places[v] = Err(Missing::Elsewhere);
        }
    }
}

/// The stretch of the surface at each vertex, as a ratio: ‖∇u‖, given the V `positions`.
pub(crate) fn stretches(
    rest: &[DVec3],
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    at_vertices: &VertexTriangles,
) -> Vec<f64> {
    let positions: Vec<DVec3> = positions.iter().copied().map(DVec3::from_array).collect();
    let norm = |gradient: DMat3| {
        let of_motion = gradient - DMat3::IDENTITY;
        of_motion.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt()
    };
    gradients(rest, &positions, triangles, at_vertices, DMat3::IDENTITY).into_iter().map(norm).collect()
}
