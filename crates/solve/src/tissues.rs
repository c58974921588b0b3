//! What the parts of a face are, for the looks of materials about which the file states nothing.
//!
//! Eyeballs are recognised where lids slide on them. Parts without a handle in front of an eyeball are clear,
//! and those a little farther out are lashes. Many small parts below the eyes are teeth, and what is between
//! them is of the mouth.

use crate::head::axes;
use glam::DVec3;
use rhytid_core::{Material, Materials, Rig, Surface, SurfacePoint, Tissue, VertexId};
use rhytid_geometry::components;
use std::collections::HashSet;
use std::ops::RangeInclusive;

/// A part inside of an eyeball reaches at most so far from its centre, in radii of its white.
const INSIDE: f64 = 1.02;
/// A part around the centre reaches at most so far. Its front is in the cornea.
const INSIDE_CORNEA: f64 = 1.25;

/// The middle of a part in front of an eyeball is at least so far forward of its centre, in its radii.
const IN_FRONT: f64 = 0.3;

/// A film of tears reaches at most so far from the centre of the eyeball, in its radii, and lashes so far.
const FILM: f64 = 1.4;
const LASHES: f64 = 2.6;

/// Teeth are so many parts. Those of a beard are more.
const TEETH: RangeInclusive<usize> = 8..=64;

/// A tooth with its root is no larger than this share of the distance between the eyes.
const LARGEST_TOOTH: f64 = 0.6;
/// All teeth together are no wider than this share.
const WIDEST_TEETH: f64 = 1.4;

/// A part with its box.
struct Part {
    low: DVec3,
    high: DVec3,
    tissue: Option<Tissue>,
}

impl Part {
    fn middle(&self) -> DVec3 {
        0.5 * (self.low + self.high)
    }
}

/// The eyeballs of a rig, in the face's axes.
struct Eye {
    center: DVec3,
    radius: f64,
}

/// The materials of `rig`, with the tissues of its parts where the file does not tell them. `eyeballs` are
/// the vertices of recognised eyeballs with their radii in mesh units, in the order of the rig's.
///
/// A material whose name or look says something is kept as it is. `None` if nothing changes.
pub(crate) fn of_parts(rig: &Rig<f64>, eyeballs: &[(VertexId, f64)]) -> Option<Materials> {
    let surface = rig.surface();
    let triangles = surface.joined_triangles();
    let (part_of, count) = components(surface.rest.len(), triangles.iter());
    let tissues = tissues(rig, eyeballs, &part_of, count)?;
    let of_face = |face: &[u32]| tissues[part_of[surface.first(face[0]) as usize] as usize];
    let found: Vec<Option<Tissue>> = surface.faces.iter().map(of_face).collect();
    match &surface.materials {
        None => Some(of_tissues(&found)),
        Some(materials) => refined(materials, &found),
    }
}

/// Materials for a mesh that has none: one for each tissue.
fn of_tissues(found: &[Option<Tissue>]) -> Materials {
    let mut materials = Materials::default();
    for tissue in found {
        let tissue = tissue.unwrap_or_default();
        let place = materials.list.iter().position(|material| material.tissue == tissue);
        let place = place.unwrap_or_else(|| {
            let name = match tissue {
                Tissue::Skin => "skin",
                Tissue::Eye => "eyes",
                Tissue::Iris => "irises",
                Tissue::Clear => "tear film",
                Tissue::Teeth => "teeth",
                Tissue::Mouth => "mouth",
                Tissue::Hair => "lashes",
            };
            materials.list.push(Material { tissue, ..Material::new(name) });
            materials.list.len() - 1
        });
        materials.of_face.push(place as u32);
    }
    materials
}

/// The materials, those of which nothing is known with the tissue that all their faces have.
fn refined(materials: &Materials, found: &[Option<Tissue>]) -> Option<Materials> {
    let mut tissues: Vec<HashSet<Option<Tissue>>> = vec![HashSet::new(); materials.list.len()];
    for (material, tissue) in materials.of_face.iter().zip(found) {
        if *material != Materials::NONE {
            tissues[*material as usize].insert(*tissue);
        }
    }
    let mut refined = materials.clone();
    for (material, tissues) in refined.list.iter_mut().zip(&tissues) {
        let says_nothing = Tissue::of_name(&material.name).is_none() && material.look().is_default;
        if let (true, 1, Some(Some(tissue))) = (says_nothing, tissues.len(), tissues.iter().next()) {
            material.tissue = *tissue;
        }
    }
    (refined != *materials).then_some(refined)
}

/// The tissue of each part. `None` if all that is known is skin.
fn tissues(
    rig: &Rig<f64>,
    eyeballs: &[(VertexId, f64)],
    part_of: &[u32],
    count: usize,
) -> Option<Vec<Option<Tissue>>> {
    let surface = rig.surface();
    let to_face = axes(surface.up_axis).transpose();
    let at = |v: usize| to_face * DVec3::from_array(surface.rest[v]);
    let contact = &rig.learned()?.contact;
    if contact.eyeballs.is_empty() || contact.eyeballs.len() != eyeballs.len() {
        return None;
    }
    let mut eyes = Vec::new();
    for (eyeball, (_, radius)) in contact.eyeballs.iter().zip(eyeballs) {
        let corners = eyeball.corners.iter().zip(eyeball.weights);
        let center = corners.map(|(v, weight)| at(v.index()) * weight).sum::<DVec3>();
        eyes.push(Eye { center, radius: *radius });
    }
    let mut parts: Vec<Part> = Vec::new();
    parts.resize_with(count, || Part { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY, tissue: None });
    for v in points(surface) {
        let part = &mut parts[part_of[v] as usize];
        (part.low, part.high) = (part.low.min(at(v)), part.high.max(at(v)));
    }
    let mut has_handle = vec![false; count];
    for v in rig.handles().points.iter().flat_map(SurfacePoint::triangle) {
        has_handle[part_of[v.index()] as usize] = true;
    }
    // The farthest vertex of each part from each eye.
    let mut reach = vec![vec![0.0_f64; count]; eyes.len()];
    for (reach, eye) in reach.iter_mut().zip(&eyes) {
        for v in points(surface) {
            let reach = &mut reach[part_of[v] as usize];
            *reach = reach.max(at(v).distance(eye.center) / eye.radius);
        }
    }
    for (part, found) in parts.iter_mut().enumerate().filter(|(part, _)| !has_handle[*part]) {
        for (eye, reach) in eyes.iter().zip(&reach) {
            let is_in_front = (found.middle() - eye.center).z > IN_FRONT * eye.radius;
            let is_around = found.middle().distance(eye.center) < IN_FRONT * eye.radius;
            found.tissue = found.tissue.or(match reach[part] {
                reach if reach <= if is_around { INSIDE_CORNEA } else { INSIDE } => Some(Tissue::Eye),
                reach if reach <= FILM && is_in_front => Some(Tissue::Clear),
                reach if reach <= LASHES && is_in_front => Some(Tissue::Hair),
                _ => None,
            });
        }
    }
    // The cornea of an eyeball is farther out than its white.
    for (v, _) in eyeballs {
        parts[part_of[v.index()] as usize].tissue = Some(Tissue::Eye);
    }
    mark_teeth(&mut parts, &has_handle, &eyes);
    Some(parts.iter().map(|part| part.tissue).collect())
}

/// The vertices that are the lowest of their points, and of the surface.
fn points(surface: &Surface<f64>) -> impl Iterator<Item = usize> {
    (0..surface.rest.len()).filter(|v| surface.first(*v as u32) as usize == *v)
}

/// Marks teeth, and the parts between them.
fn mark_teeth(parts: &mut [Part], has_handle: &[bool], eyes: &[Eye]) {
    let [first, second, ..] = eyes else { return };
    let distance = first.center.distance(second.center);
    let lowest_eye = eyes.iter().map(|eye| eye.center.y - eye.radius).fold(f64::INFINITY, f64::min);
    let is_free =
        |number: usize, part: &Part| !has_handle[number] && part.tissue.is_none() && part.high.y < lowest_eye;
    let is_tooth = |part: &Part| (part.high - part.low).max_element() <= LARGEST_TOOTH * distance;
    let mut teeth = Vec::new();
    for (number, part) in parts.iter().enumerate() {
        if is_free(number, part) && is_tooth(part) {
            teeth.push(number);
        }
    }
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &number in &teeth {
        (low, high) = (low.min(parts[number].low), high.max(parts[number].high));
    }
    if !TEETH.contains(&teeth.len()) || high.x - low.x > WIDEST_TEETH * distance {
        return;
    }
    for number in teeth {
        parts[number].tissue = Some(Tissue::Teeth);
    }
    for (number, part) in parts.iter_mut().enumerate() {
        let middle = part.middle();
        if is_free(number, part) && middle.cmpge(low).all() && middle.cmple(high).all() {
            part.tissue = Some(Tissue::Mouth);
        }
    }
}
