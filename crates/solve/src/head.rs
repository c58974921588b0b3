//! Finds the head in a mesh: of a head with its eyes and teeth, or of a whole avatar with clothes and hair.
use crate::align::aligned;
use crate::placement::named as named_points;
use crate::profile::Profile;
use glam::{DMat3, DVec3};
use rhytid_core::text::quoted;
use rhytid_core::{Error, Face, Materials, Mesh, Result, UpAxis};
use rhytid_geometry::laplacian::is_degenerate;
use rhytid_geometry::{components, triangulate};
use std::ops::Range;

/// Words that name a head or its skin, alone or as a part of a name.
const NAMES: [&str; 8] = ["head", "face", "kopf", "gesicht", "visage", "cabeza", "testa", "skin"];

/// A part is the head without another sign if it has this share of the area of all parts.
const NEARLY_ALL: f64 = 0.6;

/// The parts that are looked at, the largest first.
const LOOKED_AT: usize = 32;

/// The head of an avatar is in this upper part of its height.
const UPPER: f64 = 0.4;

/// The head of an avatar is this near to its middle, in widths of the head.
const CENTRAL: f64 = 0.5;

/// A part that is higher than this many heads is more than a head and its neck.
const TALL: f64 = 1.6;

/// The head of a tall part ends so far below the chin, in heights of the head.
const NECK: f64 = 0.4;

/// The box of the head reaches so far to either side, in widths of the head: shoulders can be as high as a
/// chin.
const BOX: f64 = 0.75;

/// The least and the largest size of an eyeball along an axis, in widths of the head.
const EYES: [f64; 2] = [0.06, 0.35];

/// How much longer an eyeball may be along one axis than along another: some are only the half that is seen.
const FLATTEST_EYE: f64 = 3.0;

/// How far the middle of an eyeball is from the tip of the nose to its side, and forward, in widths of the
/// head.
const EYES_ASIDE: Range<f64> = 0.08..0.35;
const EYES_FORWARD: Range<f64> = -0.5..0.1;

/// A group of vertices with a name: an object or a group of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// The name in the file.
    pub name: String,
    /// Its vertices; each is below V.
    pub vertices: Vec<u32>,
}

/// The vertices of a mesh that are its head.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// V: whether a vertex is of the head. Eyes, teeth, hair and clothes are not, if they are not connected
    /// with it.
    pub vertices: Vec<bool>,
    /// The size along x, y and z of the head's bounding box in mesh units. The neck is left out if the chin
    /// is found.
    pub size: [f64; 3],
    /// How the head was found: the second half of a sentence that begins with “the head is”.
    pub why: String,
    pub(crate) profile: Option<Profile>,
    /// V: whether a vertex is of an eyeball, which hides the skin behind it.
    pub(crate) is_eye: Vec<bool>,
}

impl Region {
    /// Whether a nose between cheeks and a chin were found, so that the face surely looks ahead.
    pub fn looks_ahead(&self) -> bool {
        self.profile.is_some()
    }
}

/// Finds the head of a face's neutral. The first of these that says something decides:
///
/// 1. `part`, the name of one of the `parts` or of a material.
/// 2. The examples: the connected part that they move most, as the sum over its area.
/// 3. A name of a part or material with a word such as `head` or `face`, if it has a nose.
/// 4. The shape: a part with a nose between cheeks and a throat below its chin, or with a pair of eyes. It is
///    in the middle of the upper part of the mesh.
/// 5. The size: the one part that has most of the area.
///
/// A part that is much higher than its head, such as a body, is cut below the neck.
///
/// # Errors
/// [`Error::Input`] if `part` names nothing, or if nothing above finds the head.
pub fn find(face: &Face, parts: &[Part], part: Option<&str>) -> Result<Region> {
    let in_place = aligned(face);
    let face = in_place.as_ref().map_or(face, |(face, _)| face);
    let named = named_points(face);
    find_in_place(named.as_ref().unwrap_or(face), parts, part)
}

/// As [`find`], if the examples are already in the neutral's place, and each point of the surface is one
/// vertex in the faces.
pub(crate) fn find_in_place(face: &Face, parts: &[Part], part: Option<&str>) -> Result<Region> {
    let avatar = Avatar::new(face);
    let named = named(&face.neutral, parts);
    if let Some(wanted) = part {
        let lower = wanted.to_lowercase();
        let found = named.iter().find(|part| part.name == wanted);
        let found = found.or_else(|| named.iter().find(|part| part.name.to_lowercase() == lower));
        let Some(found) = found.filter(|part| !part.vertices.is_empty()) else {
            let names: Vec<String> = named.iter().map(|part| quoted(&part.name)).collect();
            let has = if names.is_empty() { "no part with a name".to_owned() } else { names.join(", ") };
            return Err(Error::input(format!(
                "no part of the mesh is called {}; it has {has}",
                quoted(wanted)
            )));
        };
        return Ok(avatar.region(&found.vertices, format!("the part {}, as wished", quoted(&found.name))));
    }
    if let Some(c) = avatar.most_moved(face) {
        return Ok(avatar.region(&avatar.members[c], "the part that the examples move most".into()));
    }
    let mut by_name: Vec<&Part> = named.iter().filter(|part| says_head(&part.name)).collect();
    by_name.sort_by_key(|part| std::cmp::Reverse(part.vertices.len()));
    for part in by_name.into_iter().take(LOOKED_AT) {
        let region = avatar.region(&part.vertices, format!("the part {}", quoted(&part.name)));
        if region.profile.is_some() {
            return Ok(region);
        }
    }
    if let Some(c) = avatar.with_a_face() {
        return Ok(avatar.region(&avatar.members[c], "the part with the shape of a face".into()));
    }
    match avatar.by_area.first() {
        Some(&c) if avatar.areas[c] >= NEARLY_ALL * avatar.areas.iter().sum::<f64>() => {
            Ok(avatar.region(&avatar.members[c], "the largest part".into()))
        }
        _ => Err(Error::bad_topology(format!(
            "the mesh has {} connected parts, and none of them is certainly the head: no example moves one, and \
             none has the shape of a face that looks along +Z where up = \"y\", or along −Y where up = \"z\"; \
             give the head alone, or name its part",
            avatar.by_area.len()
        ))),
    }
}

/// The axes of a face in columns: its right side in the picture (+x), up, and forward.
pub(crate) fn axes(up: UpAxis) -> DMat3 {
    match up {
        UpAxis::Y => DMat3::IDENTITY,
        UpAxis::Z => DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y),
    }
}

/// Whether a name says that its part is a head: `Head`, `body_head`, `FaceSkin`, and not `HeadBand`.
fn says_head(name: &str) -> bool {
    let mut words: Vec<String> = Vec::new();
    let mut was_lower = false;
    for letter in name.chars() {
        if !letter.is_alphabetic() {
            words.push(String::new());
        } else {
            if words.is_empty() || (was_lower && letter.is_uppercase()) {
                words.push(String::new());
            }
            if let Some(word) = words.last_mut() {
                word.extend(letter.to_lowercase());
            }
        }
        was_lower = letter.is_lowercase();
    }
    words.iter().any(|word| NAMES.contains(&word.as_str()))
}

/// The parts, and the materials as parts.
fn named(mesh: &Mesh, parts: &[Part]) -> Vec<Part> {
    let mut named = parts.to_vec();
    for part in &mut named {
        part.vertices.retain(|v| (*v as usize) < mesh.positions.len());
    }
    let Some(materials) = mesh.materials.as_ref().filter(|all| all.fault(&mesh.faces).is_none()) else {
        return named;
    };
    let first = named.len();
    named.extend(materials.names().map(|name| Part { name: name.to_owned(), vertices: Vec::new() }));
    for (corners, &material) in mesh.faces.iter().zip(&materials.of_face) {
        if material != Materials::NONE {
            named[first + material as usize].vertices.extend(corners);
        }
    }
    for part in &mut named[first..] {
        part.vertices.sort_unstable();
        part.vertices.dedup();
    }
    named
}

/// A mesh in its connected parts.
struct Avatar {
    /// V, in the face's axes.
    points: Vec<DVec3>,
    axes: DMat3,
    triangles: Vec<[u32; 3]>,
    /// V: the area around a vertex.
    area: Vec<f64>,
    /// The vertices of each part.
    members: Vec<Vec<u32>>,
    /// The area of each part.
    areas: Vec<f64>,
    /// The parts with an area, the largest first.
    by_area: Vec<usize>,
}

impl Avatar {
    fn new(face: &Face) -> Self {
        let axes = axes(face.up_axis);
        let points: Vec<DVec3> =
            face.neutral.positions.iter().map(|x| axes.transpose() * DVec3::from_array(*x)).collect();
        let mut triangles = triangulate(&face.neutral);
        triangles.retain(|t| !is_degenerate(t.map(|v| points[v as usize])));
        let (component, count) = components(points.len(), triangles.iter());
        let mut area = vec![0.0; points.len()];
        for triangle in &triangles {
            let [a, b, c] = triangle.map(|v| points[v as usize]);
            let third = (b - a).cross(c - a).length() / 6.0;
            triangle.iter().for_each(|&v| area[v as usize] += third);
        }
        let (mut members, mut areas) = (vec![Vec::new(); count], vec![0.0; count]);
        for (v, &c) in component.iter().enumerate() {
            members[c as usize].push(v as u32);
            areas[c as usize] += area[v];
        }
        let mut by_area: Vec<usize> = (0..count).filter(|&c| areas[c] > 0.0).collect();
        by_area.sort_by(|&a, &b| areas[b].total_cmp(&areas[a]).then(a.cmp(&b)));
        Self { points, axes, triangles, area, members, areas, by_area }
    }

    /// The part that the examples move most. `None` if they move nothing.
    fn most_moved(&self, face: &Face) -> Option<usize> {
        let mut moved = vec![0.0_f64; self.points.len()];
        for example in &face.examples {
            for (moved, (x, rest)) in
                moved.iter_mut().zip(example.positions.iter().zip(&face.neutral.positions))
            {
                *moved = moved.max(DVec3::from_array(*x).distance(DVec3::from_array(*rest)));
            }
        }
        let of_part =
            |c: usize| self.members[c].iter().map(|&v| self.area[v as usize] * moved[v as usize]).sum();
        let sums: Vec<(f64, usize)> = self.by_area.iter().map(|&c| (of_part(c), c)).collect();
        let most = sums.into_iter().max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)))?;
        (most.0 > 0.0).then_some(most.1)
    }

    /// The part with the shape of a face: with eyes or a throat, in the middle of the upper part of the mesh.
    /// Of several, one with eyes, and the one with the widest head.
    fn with_a_face(&self) -> Option<usize> {
        let [low, high] = bounds(self.by_area.iter().flat_map(|&c| &self.members[c]).map(|&v| self.at(v)))?;
        // A mesh that is no higher than a head and its neck is all upper part.
        let is_above = |profile: &Profile| {
            let upper = (UPPER * (high.y - low.y)).max(2.0 * (profile.top - profile.chin.y));
            profile.chin.y > high.y - upper
        };
        let is_central =
            |profile: &Profile| (profile.nose.x - 0.5 * (low.x + high.x)).abs() < CENTRAL * profile.width;
        let mut found: Option<Candidate> = None;
        for &part in self.by_area.iter().take(LOOKED_AT) {
            let Some(profile) = self.profile(&self.members[part]) else { continue };
            let has_eyes = self.has_eyes(&profile);
            if !is_above(&profile) || !is_central(&profile) || !(has_eyes || profile.has_throat) {
                continue;
            }
            // A tongue can look like a small head.
            let candidate = Candidate { part, has_eyes, width: profile.width };
            let is_better = |other: &Candidate| match candidate.has_eyes == other.has_eyes {
                true => candidate.width > other.width,
                false => candidate.has_eyes,
            };
            if found.as_ref().is_none_or(is_better) {
                found = Some(candidate);
            }
        }
        found.map(|candidate| candidate.part)
    }

    /// The parts at the places of the eyes: those on the right, at smaller x, and those on the left.
    fn eyes(&self, profile: &Profile) -> [Vec<usize>; 2] {
        let mut sides = [Vec::new(), Vec::new()];
        let height = profile.nose.y - profile.chin.y;
        for &c in &self.by_area {
            let Some([low, high]) = bounds(self.members[c].iter().map(|&v| self.at(v))) else { continue };
            let (middle, size) = (0.5 * (low + high) - profile.nose, (high - low) / profile.width);
            let is_ball = size.min_element() > EYES[0]
                && size.max_element() < EYES[1]
                && size.max_element() < FLATTEST_EYE * size.min_element();
            let is_there = EYES_ASIDE.contains(&(middle.x.abs() / profile.width))
                && (0.0..height).contains(&middle.y)
                && EYES_FORWARD.contains(&(middle.z / profile.width));
            if is_ball && is_there {
                sides[usize::from(middle.x > 0.0)].push(c);
            }
        }
        sides
    }

    fn has_eyes(&self, profile: &Profile) -> bool {
        self.eyes(profile).iter().all(|side| !side.is_empty())
    }

    fn at(&self, v: u32) -> DVec3 {
        self.points[v as usize]
    }

    fn profile(&self, members: &[u32]) -> Option<Profile> {
        let mut is_in = vec![false; self.points.len()];
        members.iter().for_each(|&v| is_in[v as usize] = true);
        let triangles: Vec<[DVec3; 3]> = self
            .triangles
            .iter()
            .filter(|t| t.iter().all(|&v| is_in[v as usize]))
            .map(|t| t.map(|v| self.at(v)))
            .collect();
        Profile::new(&triangles)
    }

    /// The head among `members`.
    fn region(&self, members: &[u32], why: String) -> Region {
        // Eyes and teeth in a part with a name do not hide its nose.
        let profile = self.profile(members);
        let bottom = members.iter().map(|&v| self.at(v).y).fold(f64::INFINITY, f64::min);
        let is_head = |v: &u32| {
            let Some(profile) = profile else { return true };
            let (point, height) = (self.at(*v), profile.top - profile.chin.y);
            profile.top - bottom <= TALL * height
                || (point.y > profile.chin.y - NECK * height
                    && (point.x - profile.nose.x).abs() <= profile.width)
        };
        let mut vertices = vec![false; self.points.len()];
        for &v in members.iter().filter(|v| is_head(v)) {
            vertices[v as usize] = true;
        }
        let is_boxed = |v: &&u32| {
            let in_box = |profile: Profile| {
                let aside = (self.at(**v).x - profile.nose.x).abs();
                self.at(**v).y >= profile.chin.y && aside <= BOX * profile.width
            };
            vertices[**v as usize] && profile.is_none_or(in_box)
        };
        let boxed = members.iter().filter(is_boxed);
        let size = bounds(boxed.map(|&v| self.at(v))).map_or(DVec3::ZERO, |[low, high]| high - low);
        let mut is_eye = vec![false; self.points.len()];
        for c in profile.iter().flat_map(|profile| self.eyes(profile)).flatten() {
            self.members[c].iter().for_each(|&v| is_eye[v as usize] = true);
        }
        Region { vertices, is_eye, size: (self.axes * size).abs().to_array(), why, profile }
    }
}

/// A part that may be the head.
struct Candidate {
    part: usize,
    has_eyes: bool,
    /// The width of its head.
    width: f64,
}

fn bounds(points: impl Iterator<Item = DVec3>) -> Option<[DVec3; 2]> {
    points.fold(None, |bounds: Option<[DVec3; 2]>, point| {
        Some(bounds.map_or([point; 2], |[low, high]| [low.min(point), high.max(point)]))
    })
}

#[cfg(test)]
mod tests {
    use super::says_head;

    #[test]
    fn names_that_say_head() {
        let heads =
            ["Head", "body_head", "CC_Base_Head", "FaceSkin", "kopf.001", "Mesh:face", "Std_Skin_Head"];
        assert_eq!(heads.map(says_head), [true; 7]);
        let others = ["hair", "eyelashes", "trousers", "Headphones", "surface", "forehead_band", ""];
        assert_eq!(others.map(says_head), [false; 7]);
    }
}
