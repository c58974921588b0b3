//! Finds the skin that is opposite other skin across an opening, and how near they come in the scans.
use crate::learned::{FreeMotion, FreePart};
use crate::{Shell, diagonal};
use rayon::prelude::*;
use rhytid_core::openings::{ACROSS, Gap, LEADERS, smooth_step};
use rhytid_core::{
    Example, Face, Openings, Progress, Result, RimFollower, RimVertex, SurfacePoint, VertexId,
};
use rhytid_geometry::geodesic::{EdgeGraph, Near};
use rhytid_kernels::normals::{VertexTriangles, vertex_normal};
use rhytid_kernels::vec3;
use rstar::RTree;
use rstar::primitives::GeomWithData;
use std::collections::{BTreeMap, BTreeSet};

/// The widest opening that is looked across, as a part of the bounding box's diagonal.
const WIDEST: f64 = 0.025;

/// The largest cosine between normals that are opposite each other.
const OPPOSITE: f64 = -0.3;

/// Vertices across are kept if they are farther from each other than this, in their mean edge lengths.
const SPACING: f64 = 0.75;

/// The way along the skin between vertices across from each other is longer than the straight line by this
/// factor.
const WAY: f64 = 3.0;

/// The most vertices that are looked at, the nearest first.
const LOOKED_AT: usize = 48;

/// How far beside a vertex those across count, in their mean edge lengths.
const REACH: f64 = 2.5;

/// The deepest that scans may go into what is across, in reaches. Vertices that go deeper have no limit.
const CROSSED: f64 = 0.5;

/// How far along the skin a step fades, in reaches.
const FADE: f64 = 2.5;

/// How far along the skin vertices that handles hold keep others from moving, in reaches.
const HELD: f64 = 5.0;

/// Limits are wider than in the scans by this part of the reach, because a rig meets its examples only
/// nearly.
const SLACK: f64 = 1e-3;

/// The openings of a face, as its examples and its neutral show them.
///
/// # Errors
/// [`rhytid_core::Error::Cancelled`].
pub(crate) fn recognise(
    shell: &Shell,
    face: &Face,
    parts: &[FreePart],
    progress: &dyn Progress,
) -> Result<Openings<f64>> {
    let rest = &shell.surface.rest;
    let scans: Vec<Scan<'_>> = std::iter::once(&**rest)
        .chain(face.examples.iter().map(|example: &Example| &*example.positions))
        .map(|positions| Scan { positions, normals: normals(shell, positions) })
        .collect();
    let rims = rims(shell, &scans, WIDEST * diagonal(face), progress)?;
    let mut openings = Openings { rims, ..Openings::default() };
    // Where scans cross, the artist or the scanner let them, and gaps there say little.
    let least = least_gaps(&openings, &scans);
    let crosses = |i: usize| least[i] < -CROSSED * openings.rims[i].reach;
    openings.rims = kept(&openings.rims, |i| !crosses(i));
    if openings.rims.is_empty() {
        return Ok(Openings::default());
    }
    let least = least_gaps(&openings, &scans);
    for (rim, least) in openings.rims.iter_mut().zip(least) {
        rim.least_gap = least - SLACK * rim.reach;
    }
    openings.followers = followers(shell, parts, &openings.rims);
    Ok(openings)
}

/// A pose of the face: the neutral or an example.
struct Scan<'a> {
    positions: &'a [[f64; 3]],
    normals: Vec<[f64; 3]>,
}

/// The least gap of each rim vertex in the scans, at most 0.
fn least_gaps(openings: &Openings<f64>, scans: &[Scan<'_>]) -> Vec<f64> {
    let of_scan = |scan: &Scan<'_>| {
        let of_rims =
            |all: &[[f64; 3]]| openings.rims.iter().map(|rim| all[rim.vertex.index()]).collect::<Vec<_>>();
        let (positions, normals) = (of_rims(scan.positions), of_rims(&scan.normals));
        let gap = |rim| openings.gap(rim, &positions, &normals);
        let width = |gap: Gap| if gap.certainty > 0.0 { gap.width } else { 0.0 };
        (0..positions.len()).map(gap).map(width).collect::<Vec<_>>()
    };
    let mut least = vec![0.0_f64; openings.rims.len()];
    for widths in scans.iter().map(of_scan) {
        least.iter_mut().zip(widths).for_each(|(least, width)| *least = least.min(width));
    }
    least
}

/// The rim vertices with these numbers, as far as they still have any across, numbered anew.
fn kept(rims: &[RimVertex<f64>], is_kept: impl Fn(usize) -> bool) -> Vec<RimVertex<f64>> {
    let mut is_named = vec![false; rims.len()];
    for i in (0..rims.len()).filter(|i| is_kept(*i)) {
        for other in rims[i].across.map(|other| other as usize) {
            if other != i && is_kept(other) {
                (is_named[i], is_named[other]) = (true, true);
            }
        }
    }
    let numbers: BTreeMap<u32, u32> =
        (0..).zip(&is_named).filter(|(_, named)| **named).map(|(i, _)| i).zip(0..).collect();
    let renumbered = |(&old, &own): (&u32, &u32)| {
        let rim = &rims[old as usize];
        RimVertex { across: rim.across.map(|other| numbers.get(&other).copied().unwrap_or(own)), ..*rim }
    };
    numbers.iter().map(renumbered).collect()
}

fn normals(shell: &Shell, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let triangles = &shell.surface.triangles;
    let around = VertexTriangles::new(positions.len(), triangles);
    (0..positions.len()).into_par_iter().map(|v| vertex_normal(positions, triangles, around.at(v))).collect()
}

/// The vertices that have others across an opening in any scan.
///
/// # Errors
/// [`rhytid_core::Error::Cancelled`].
fn rims(
    shell: &Shell,
    scans: &[Scan<'_>],
    widest: f64,
    progress: &dyn Progress,
) -> Result<Vec<RimVertex<f64>>> {
    let mut across: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for (i, scan) in scans.iter().enumerate() {
        progress.step("openings", i as u64, scans.len() as u64)?;
        for [a, b] in opposite(shell, scan, widest) {
            across.entry(a).or_default().insert(b);
            across.entry(b).or_default().insert(a);
        }
    }
    progress.step("openings", scans.len() as u64, scans.len() as u64)?;
    let rest = &shell.surface.rest;
    let graph = EdgeGraph::new(rest, &shell.topology);
    let apart = |a: u32, b: u32, positions: &[[f64; 3]]| {
        vec3::length(vec3::sub(positions[a as usize], positions[b as usize]))
    };
    let around = |v: &u32| shell.topology.neighbors(*v as usize).iter().copied();
    let ring = |of: &BTreeSet<u32>| of.iter().flat_map(around).chain(of.iter().copied()).collect();
    // Each vertex with those across, the nearest first, and the mean length of the edges there.
    let of_vertex = |ways: &mut Near<'_>, (&vertex, found): (&u32, &BTreeSet<u32>)| {
        let near: BTreeSet<u32> = ring(&ring(found));
        let lengths = found.iter().flat_map(|v| around(v).map(|w| apart(*v, w, rest)));
        let edge = lengths.sum::<f64>() / found.iter().flat_map(around).count().max(1) as f64;
        let least =
            |v: u32| scans.iter().map(|s| apart(vertex, v, s.positions)).fold(f64::INFINITY, f64::min);
        let mut near: Vec<(f64, u32)> =
            near.into_iter().filter(|v| across.contains_key(v)).map(|v| (least(v), v)).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.truncate(LOOKED_AT);
        let farthest = near.last().map_or(0.0, |(distance, _)| *distance);
        let _ = ways.search(vertex, WAY * farthest);
        let mut kept: Vec<u32> = Vec::with_capacity(ACROSS);
        let is_across = |(distance, v): &(f64, u32)| ways.distance(*v) > edge.max(WAY * distance);
        for (_, v) in near.into_iter().filter(is_across) {
            let is_apart = |other: &u32| apart(*other, v, rest) > SPACING * edge;
            if kept.len() < ACROSS && kept.iter().all(is_apart) {
                kept.push(v);
            }
        }
        (vertex, kept, edge)
    };
    let across: Vec<(u32, Vec<u32>, f64)> =
        across.par_iter().map_init(|| Near::new(&graph), of_vertex).collect();
    // Who has none across, or is across from none, is no rim vertex.
    let named: BTreeSet<u32> = across
        .iter()
        .filter(|(_, kept, _)| !kept.is_empty())
        .flat_map(|(vertex, kept, _)| kept.iter().chain([vertex]).copied())
        .collect();
    let numbers: BTreeMap<u32, u32> = named.into_iter().zip(0..).collect();
    let rim = |(vertex, kept, edge): &(u32, Vec<u32>, f64)| {
        let own = *numbers.get(vertex)?;
        let mut across = [own; ACROSS];
        across.iter_mut().zip(kept).for_each(|(slot, v)| *slot = numbers[v]);
        Some(RimVertex { vertex: VertexId(*vertex), across, reach: REACH * edge, least_gap: 0.0 })
    };
    Ok(across.iter().filter_map(rim).collect())
}

/// Pairs of vertices of the skin that are opposite each other.
///
/// A ball touches the skin from outside at a vertex. It shrinks until no vertex with an opposite normal is
/// inside (Ma, Bae and Choi, *3D medial axis point approximation using nearest neighbors and the normal
/// field*, 2012). The last one that was inside is opposite.
fn opposite(shell: &Shell, scan: &Scan<'_>, widest: f64) -> Vec<[u32; 2]> {
    let at = |v: u32| scan.positions[v as usize];
    let normal = |v: u32| scan.normals[v as usize];
    let skin: Vec<u32> = (0..scan.positions.len() as u32)
        .filter(|v| shell.parts.driven[*v as usize] && normal(*v) != [0.0; 3])
        .collect();
    let tree = RTree::bulk_load(skin.iter().map(|v| GeomWithData::new(at(*v), *v)).collect());
    let of_vertex = |&v: &u32| {
        let mut radius = 0.5 * widest;
        let mut last = None;
        // Each ball is smaller than the one before; a few are enough.
        for _ in 0..20 {
            let center = vec3::add(at(v), normal(v).map(|n| radius * n));
            let distance = |w: u32| vec3::length(vec3::sub(at(w), center));
            let nearest = tree
                .locate_within_distance(center, radius * radius)
                .map(|found| found.data)
                .filter(|w| vec3::dot(normal(v), normal(*w)) < OPPOSITE)
                .min_by(|a, b| distance(*a).total_cmp(&distance(*b)).then(a.cmp(b)));
            let Some(w) = nearest.filter(|w| last != Some(*w)) else { break };
            last = Some(w);
            let to = vec3::sub(at(w), at(v));
            let in_front = vec3::dot(to, normal(v));
            if in_front <= 0.0 {
                break;
            }
            radius = vec3::dot(to, to) / (2.0 * in_front);
        }
        last.map(|w| [v, w])
    };
    skin.par_iter().filter_map(of_vertex).collect()
}

/// The nearest of some rim vertices, with weights that fade with the distance. They are 0 from `farthest` on,
/// and their sum is 1 at a distance of 0.
fn nearest(mut found: Vec<(f64, u32)>, farthest: f64) -> [(u32, f64); LEADERS / 2] {
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    found.truncate(LEADERS / 2);
    let mut nearest = [(0, 0.0); LEADERS / 2];
    let Some((first, _)) = found.first().copied() else { return nearest };
    // In units of the first distance, so that nothing is divided by 0.
    let share = |distance: f64| match distance > first {
        true => (first / distance * (farthest - distance) / (farthest - first)).powi(2),
        false => 1.0,
    };
    let total: f64 = found.iter().map(|(distance, _)| share(*distance)).sum();
    for (slot, (distance, rim)) in nearest.iter_mut().zip(found) {
        *slot = (rim, share(distance) / total * smooth_step(1.0 - first / farthest));
    }
    nearest
}

/// The vertices of the skin within [`FADE`] of rim vertices, and those of other parts that move with them.
///
/// Vertices that handles hold stay. Where they are in the rim, what they would have to move is subtracted
/// around them, so that skin between markers that cross is as smooth as before. Steps fade towards others.
fn followers(shell: &Shell, parts: &[FreePart], rims: &[RimVertex<f64>]) -> Vec<RimFollower<f64>> {
    let rest = &shell.surface.rest;
    let graph = EdgeGraph::new(rest, &shell.topology);
    let reach = rims.iter().map(|rim| rim.reach).sum::<f64>() / rims.len() as f64;
    let fade = FADE * reach;
    let is_rim: BTreeSet<VertexId> = rims.iter().map(|rim| rim.vertex).collect();
    let held: BTreeSet<VertexId> =
        shell.handles.points.iter().flat_map(SurfacePoint::corners).map(|(v, _)| v).collect();
    let mut search = Near::new(&graph);
    let mut from_held = vec![f64::INFINITY; rest.len()];
    for vertex in held.difference(&is_rim) {
        for (v, distance) in search.search(vertex.0, reach) {
            from_held[v as usize] = from_held[v as usize].min(distance);
        }
    }
    // The nearest rim vertices, and the nearest of those that are held, with their distances.
    let mut near: BTreeMap<u32, [Vec<(f64, u32)>; 2]> = BTreeMap::new();
    for (number, rim) in (0..).zip(rims) {
        let is_held = held.contains(&rim.vertex);
        let farthest = if is_held { HELD * reach } else { fade };
        for (v, distance) in search.search(rim.vertex.0, farthest) {
            let [leaders, held] = near.entry(v).or_default();
            if distance < fade {
                leaders.push((distance, number));
            }
            if is_held && distance < farthest {
                held.push((distance, number));
            }
        }
    }
    let mut followers = BTreeMap::new();
    for (v, [leaders, of_held]) in near {
        let moves = shell.parts.driven[v as usize] && !shell.pinned[v as usize];
        let towards_held = smooth_step(from_held[v as usize] / reach);
        if !moves || held.contains(&VertexId(v)) || towards_held == 0.0 || leaders.is_empty() {
            continue;
        }
        let leaders = nearest(leaders, fade).map(|(rim, weight)| (rim, weight * towards_held));
        let of_held = nearest(of_held, HELD * reach).map(|(rim, weight)| (rim, -weight));
        let own = leaders.iter().map(|(_, weight)| weight).sum::<f64>();
        let mut follower =
            RimFollower { vertex: VertexId(v), leaders: [0; LEADERS], weights: [0.0; LEADERS] };
        let all = leaders.into_iter().chain(of_held.map(|(rim, weight)| (rim, weight * own)));
        for (slot, (rim, weight)) in all.enumerate() {
            follower.leaders[slot] = rim;
            follower.weights[slot] = weight;
        }
        followers.insert(v, follower);
    }
    let skin: Vec<_> = (0..rest.len() as u32)
        .filter(|v| shell.parts.driven[*v as usize])
        .map(|v| GeomWithData::new(rest[v as usize], v))
        .collect();
    let skin = RTree::bulk_load(skin);
    let members = shell.parts.without_handle();
    let mut others = Vec::new();
    for part in parts {
        let fades = match part.motion {
            FreeMotion::Skin => false,
            FreeMotion::Blend { .. } => true,
            FreeMotion::Still | FreeMotion::Solid => continue,
        };
        for &vertex in &members[shell.parts.component[part.first_vertex.index()] as usize] {
            let at = rest[vertex.index()];
            // Of equally near vertices, the lowest counts.
            let nearest = skin.nearest_neighbors(&at).into_iter().map(|found| found.data).min();
            let Some(skin) = nearest.and_then(|v| followers.get(&v)) else { continue };
            let distance = vec3::length(vec3::sub(at, rest[skin.vertex.index()]));
            let weight = if fades { smooth_step(1.0 - distance / fade) } else { 1.0 };
            if weight > 0.0 {
                others.push(RimFollower { vertex, weights: skin.weights.map(|w| weight * w), ..*skin });
            }
        }
    }
    let mut followers: Vec<_> = followers.into_values().chain(others).collect();
    followers.sort_by_key(|follower| follower.vertex);
    followers
}
