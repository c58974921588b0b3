//! Recognises eyeballs, and the vertices that slide on them.
use crate::learned::{FreeMotion, FreePart};
use crate::{Shell, diagonal};
use glam::{DMat3, DMat4, DVec3, DVec4};
use rhytid_core::{Contact, Example, Eyeball, Face, LidVertex, SurfacePoint, VertexId};
use rstar::RTree;
use rstar::primitives::GeomWithData;

/// The fewest vertices of an eyeball.
const FEWEST: usize = 20;

/// The part of an eyeball's vertices that the sphere is fitted to. The others may be on the cornea.
const FITTED: f64 = 0.6;

/// The largest RMS distance of these vertices from the sphere, and the largest of all, in radii.
const OFF: [f64; 2] = [0.02, 0.2];

/// How one-sided an eyeball may be: the length of the mean direction of its vertices. It is 0.5 for a half.
const ONE_SIDED: f64 = 0.7;

/// The largest radius of an eyeball, as a part of the bounding box's diagonal.
const LARGEST: f64 = 0.15;

/// Solids whose centres are nearer than this, in radii, are one eyeball: its white, its cornea and its lens.
const SAME: f64 = 0.3;

/// The vertices that may come to lie on an eyeball are nearer to its centre than this, in radii.
const NEAR: f64 = 1.6;

/// How much farther than in any example a vertex may be, in radii: of all lids, and of each radius by which a
/// vertex is more than 1.05 radii away at rest.
const LIFT: f64 = 0.03;
const LIFT_PER_RADIUS: f64 = 2.0;
const OF_LIDS: f64 = 1.05;

/// Distances are wider than the scans' by this part, because a rig meets its examples only nearly.
const SLACK: f64 = 1e-3;

/// An eyeball that was recognised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoundEyeball {
    /// The lowest vertex of its outermost part.
    pub first_vertex: VertexId,
    /// The radius of its white, in mesh units.
    pub radius: f64,
    /// The number of vertices that slide on it or stay away from it.
    pub lid_vertices: usize,
}

/// A solid that is nearly a sphere.
struct Ball {
    members: Vec<VertexId>,
    center: DVec3,
    radius: f64,
    /// The distance of its farthest vertex from the centre.
    farthest: f64,
}

/// The eyeballs among the solid `parts`, and the vertices around them.
///
/// A vertex may be as near to the centre as in the nearest example, and as far as in the farthest, with the
/// rest pose among them. A vertex that is outside of the eyeball in all of them may come down to its surface.
pub(crate) fn recognise(shell: &Shell, face: &Face, parts: &[FreePart]) -> (Contact<f64>, Vec<FoundEyeball>) {
    let rest: Vec<DVec3> = shell.surface.rest.iter().copied().map(DVec3::from_array).collect();
    let balls = eyeballs(&rest, shell, parts, LARGEST * diagonal(face));
    let mut contact = Contact::default();
    let mut found = Vec::new();
    for (b, ball) in balls.iter().enumerate() {
        let radii = |v: VertexId, ball: &Ball| rest[v.index()].distance(ball.center) / ball.radius;
        let is_nearer = |other: usize, v: VertexId| radii(v, &balls[other]) < radii(v, ball);
        let is_near = |v: VertexId| {
            radii(v, ball) < NEAR && (0..balls.len()).all(|other| other == b || !is_nearer(other, v))
        };
        let Some(eyeball) = eyeball(&rest, ball) else { continue };
        let lids = lids(shell, &face.examples, parts, ball, &eyeball, is_near);
        if lids.is_empty() {
            continue;
        }
        found.push(FoundEyeball {
            first_vertex: ball.members[0],
            radius: ball.radius,
            lid_vertices: lids.len(),
        });
        let (number, first) = (contact.eyeballs.len() as u32, contact.lids.len() as u32);
        let numbered = |lid: LidVertex<f64>| LidVertex { eyeball: number, leader: first + lid.leader, ..lid };
        contact.lids.extend(lids.into_iter().map(numbered));
        contact.eyeballs.push(eyeball);
    }
    (contact, found)
}

/// The balls among the solids of up to the radius `largest`; of those inside of each other, the one of the
/// largest radius.
fn eyeballs(rest: &[DVec3], shell: &Shell, parts: &[FreePart], largest: f64) -> Vec<Ball> {
    let members = shell.parts.without_handle();
    let solids = parts.iter().filter(|part| part.motion == FreeMotion::Solid);
    let of_part = |part: &FreePart| shell.parts.component[part.first_vertex.index()] as usize;
    let mut balls: Vec<Ball> = solids
        .filter_map(|part| ball(rest, &members[of_part(part)]))
        .filter(|ball| ball.radius <= largest)
        .collect();
    balls.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    let mut outer: Vec<Ball> = Vec::new();
    for ball in balls {
        match outer.iter_mut().find(|other| other.center.distance(ball.center) < SAME * other.radius) {
            Some(other) => {
                let from_center = ball.members.iter().map(|v| rest[v.index()].distance(other.center));
                other.farthest = from_center.fold(other.farthest, f64::max);
            }
            None => outer.push(ball),
        }
    }
    outer.sort_by_key(|ball| ball.members[0]);
    outer
}

/// The sphere of a part, if it is nearly one.
fn ball(rest: &[DVec3], members: &[VertexId]) -> Option<Ball> {
    if members.len() < FEWEST {
        return None;
    }
    let mut points: Vec<DVec3> = members.iter().map(|v| rest[v.index()]).collect();
    let fitted = (FITTED * points.len() as f64) as usize;
    let (mut center, mut radius) = sphere(&points)?;
    for _ in 0..10 {
        let off = |x: &DVec3| (x.distance(center) - radius).abs();
        points.sort_by(|a, b| off(a).total_cmp(&off(b)));
        (center, radius) = sphere(&points[..fitted])?;
    }
    let off = |x: &DVec3| (x.distance(center) - radius) / radius;
    let rms = (points[..fitted].iter().map(|x| off(x).powi(2)).sum::<f64>() / fitted as f64).sqrt();
    let worst = points.iter().map(|x| off(x).abs()).fold(0.0, f64::max);
    let mean = points.iter().map(|x| (*x - center).normalize_or_zero()).sum::<DVec3>() / points.len() as f64;
    let is_ball = rms < OFF[0] && worst < OFF[1] && mean.length() < ONE_SIDED;
    let farthest = points.iter().map(|x| x.distance(center)).fold(0.0, f64::max);
    is_ball.then(|| Ball { members: members.to_vec(), center, radius, farthest })
}

/// The centre and the radius of the sphere of least squares of `|x|² − 2 x·c = r² − |c|²`.
fn sphere(points: &[DVec3]) -> Option<(DVec3, f64)> {
    let mean = points.iter().sum::<DVec3>() / points.len() as f64;
    let extent = points.iter().map(|x| x.distance(mean)).fold(0.0, f64::max);
    let (mut matrix, mut right) = (DMat4::ZERO, DVec4::ZERO);
    for x in points.iter().map(|x| (*x - mean) / extent) {
        let row = (2.0 * x).extend(1.0);
        matrix += DMat4::from_cols(row * row.x, row * row.y, row * row.z, row);
        right += row * x.length_squared();
    }
    let found = matrix.inverse() * right;
    let center = found.truncate();
    let radius = (found.w + center.length_squared()).sqrt();
    radius.is_finite().then(|| (mean + extent * center, extent * radius))
}

/// Four corners that are far from each other, and the centre by their weights. `None` if all vertices are in
/// a plane.
fn eyeball(rest: &[DVec3], ball: &Ball) -> Option<Eyeball<f64>> {
    let at = |v: &VertexId| rest[v.index()];
    let most = |measure: &dyn Fn(DVec3) -> f64| {
        ball.members.iter().copied().max_by(|a, b| measure(at(a)).total_cmp(&measure(at(b))))
    };
    let first = ball.members[0];
    let second = most(&|x| x.distance(at(&first)))?;
    let line = at(&second) - at(&first);
    let third = most(&|x| line.cross(x - at(&first)).length())?;
    let normal = line.cross(at(&third) - at(&first));
    let fourth = most(&|x| normal.dot(x - at(&first)).abs())?;
    let edges = DMat3::from_cols(line, at(&third) - at(&first), at(&fourth) - at(&first));
    let weights = edges.inverse() * (ball.center - at(&first));
    let [b, c, d] = weights.to_array();
    let eyeball = Eyeball { corners: [first, second, third, fourth], weights: [1.0 - b - c - d, b, c, d] };
    // Where the corners are nearly in a plane, the centre would not be certain.
    weights.to_array().iter().all(|w| w.abs() < 10.0).then_some(eyeball)
}

/// The vertices around an eyeball, which is taken for the first. Their leaders are counted among them.
fn lids(
    shell: &Shell,
    examples: &[Example],
    parts: &[FreePart],
    ball: &Ball,
    eyeball: &Eyeball<f64>,
    is_near: impl Fn(VertexId) -> bool,
) -> Vec<LidVertex<f64>> {
    let rest = &shell.surface.rest;
    let poses: Vec<(&[[f64; 3]], DVec3)> = std::iter::once(&**rest)
        .chain(examples.iter().map(|example| &*example.positions))
        .map(|positions| (positions, DVec3::from_array(eyeball.center(positions))))
        .collect();
    let distance = |v: usize, (positions, center): &(&[[f64; 3]], DVec3)| {
        DVec3::from_array(positions[v]).distance(*center)
    };
    let mut is_held = vec![false; rest.len()];
    let held = shell.handles.points.iter().flat_map(SurfacePoint::corners);
    held.for_each(|(v, _)| is_held[v.index()] = true);
    let skin = (0..rest.len()).filter(|v| shell.parts.driven[*v] && !is_held[*v] && !shell.pinned[*v]);
    let mut lids: Vec<LidVertex<f64>> = Vec::new();
    for v in skin.filter(|v| is_near(VertexId::from_index(*v))) {
        let distances = || poses.iter().map(|pose| distance(v, pose));
        let nearest = distances().fold(ball.farthest, f64::min);
        let beyond = (distance(v, &poses[0]) / ball.radius - OF_LIDS).max(0.0);
        let lift = (LIFT + LIFT_PER_RADIUS * beyond) * ball.radius;
        lids.push(LidVertex {
            vertex: VertexId::from_index(v),
            eyeball: 0,
            leader: lids.len() as u32,
            nearest: nearest * (1.0 - SLACK),
            farthest: distances().fold(0.0, f64::max) * (1.0 + SLACK) + lift,
        });
    }
    let skin: Vec<_> = lids
        .iter()
        .enumerate()
        .map(|(i, lid)| GeomWithData::new(rest[lid.vertex.index()], i as u32))
        .collect();
    let skin = RTree::bulk_load(skin);
    let members = shell.parts.without_handle();
    for part in parts.iter().filter(|part| part.motion.follows_skin()) {
        let members = &members[shell.parts.component[part.first_vertex.index()] as usize];
        for v in members.iter().filter(|v| is_near(**v)) {
            // Of equally near vertices, the lowest counts.
            let nearest = skin.nearest_neighbors(&rest[v.index()]);
            let Some(leader) = nearest.into_iter().map(|found| found.data).min() else { return lids };
            lids.push(LidVertex { vertex: *v, ..lids[leader as usize] });
        }
    }
    lids
}
