//! Levels of detail: rigs on fewer vertices.
//!
//! The chapter asks for a mesh that is decimated "depending on the frequency of the high-resolution
//! features". So edges are collapsed by quadrics (Garland and Heckbert 1998, with attributes) not of the
//! neutral alone: where the vertices of each pose go counts as the neutral's shape does.

use crate::Playback;
use crate::poses::poses;
use glam::DVec3;
use meshoptimizer_rs::{
    Attributes, Positions, SimplifyOptions, SimplifySettings, VertexFlags, Workspace, simplify_scale,
    simplify_with_attributes,
};
use rayon::prelude::*;
use rhytid_core::{
    DeviceInfo, Error, Level, LevelCorner, LevelTriangle, Progress, Result, Rig, SurfacePoint, VertexId,
};
use rhytid_geometry::{Closest, Surface, components};
use rhytid_kernels::vec3;
use std::collections::BTreeMap;

/// Poses that count in the search for the vertices that go. meshoptimizer has room for 32 numbers of a
/// vertex.
const COUNTED: usize = 10;
/// So many frames of a take, evenly spaced, may be among them.
const LOOKED_AT: usize = 64;
/// A displacement of a pose counts so many times as much as the distance from the neutral's surface. On five
/// heads, levels are then nearest to the whole rig.
const OF_POSES: f32 = 10.0;
/// Triangles of a level in which a vertex of the whole rig may have its place.
const CANDIDATES: usize = 24;
/// Poses that are evaluated at once.
const BATCH: usize = 16;
/// A level has at most this part of the triangles of the one before. If none can be made, there are no more
/// levels.
const FEWER: f64 = 0.9;

/// A level of detail with its distance from the whole rig.
#[derive(Debug)]
pub struct LevelOfDetail {
    /// The rig, and the vertices that it keeps.
    pub level: Level,
    /// Where each of the V vertices of the whole rig is on the level's surface at rest. The vertices are the
    /// level's.
    pub points: Vec<SurfacePoint>,
    /// The largest distance of a vertex of the whole rig from its point, in all poses, in mesh units.
    pub worst: f64,
    /// The root of the mean squared distance.
    pub rms: f64,
    /// How many poses were compared.
    pub poses: usize,
}

/// Makes levels of detail: a half of the triangles, a quarter, and so on, `count` levels or as many as can be
/// made. Each is made from the whole rig.
///
/// Vertices that handles hold stay, so markers are met on every level. Seams of texture coordinates and
/// borders between materials stay seams. A vertex that stays has all its numbers, so it goes where it goes in
/// the whole rig.
///
/// The distance is measured at rest, in the examples, half of the way to each, and in all frames of a take.
/// `take` has frames × H positions of handles, and may be empty.
///
/// # Errors
/// As [`Rig::level`]; [`Error::Device`]; [`Error::Cancelled`].
pub fn levels(
    rig: &Rig,
    take: &[[f32; 3]],
    count: usize,
    devices: &[DeviceInfo],
    progress: &dyn Progress,
) -> Result<Vec<LevelOfDetail>> {
    let mut playback = Playback::new(rig, devices, BATCH)?;
    let all = [&rig.handles().rest[..], &poses(rig), take].concat();
    let mesh = Wedges::new(rig)?;
    let counted = counted(&mut playback, take, progress)?;
    let attributes = mesh.attributes(&counted, rig);
    let mut made: Vec<LevelOfDetail> = Vec::new();
    let mut most = mesh.triangles.len();
    for number in 1..=count {
        progress.step("take vertices away", number as u64 - 1, count as u64)?;
        let triangles = mesh.simplified(mesh.triangles.len() >> number, &attributes)?;
        if triangles.is_empty() || triangles.len() as f64 > FEWER * most as f64 {
            break;
        }
        most = triangles.len();
        let level = rig.level(&triangles)?;
        let points = points_of(rig, &level, &triangles, &counted);
        made.push(LevelOfDetail { level, points, worst: 0.0, rms: 0.0, poses: 0 });
    }
    progress.step("take vertices away", count as u64, count as u64)?;
    measure(&mut playback, &all, &mut made, progress)?;
    Ok(made)
}

/// Displacements of all vertices in the poses that count, V each: those that are farthest from each other.
fn counted(
    playback: &mut Playback<'_>,
    take: &[[f32; 3]],
    progress: &dyn Progress,
) -> Result<Vec<Vec<[f32; 3]>>> {
    let rig = playback.rig();
    let handles = rig.handles().len();
    let frames = take.len() / handles;
    let mut all = poses(rig);
    for frame in (0..frames).step_by(frames.div_ceil(LOOKED_AT).max(1)) {
        all.extend_from_slice(&take[frame * handles..][..handles]);
    }
    let mut moved: Vec<Vec<[f32; 3]>> = Vec::new();
    playback.evaluate_unfinished(&all, progress, |positions, _| {
        let pairs = positions.iter().zip(&rig.surface().rest);
        moved.push(pairs.map(|(x, rest)| vec3::sub(*x, *rest)).collect());
    })?;
    let square = |a: &[[f32; 3]], b: &[[f32; 3]]| -> f64 {
        let pairs = a.as_flattened().par_iter().zip(b.as_flattened());
        // Squares are added in the order of the vertices, so that the same poses count everywhere.
        pairs.map(|(a, b)| f64::from(a - b).powi(2)).collect::<Vec<_>>().iter().sum()
    };
    let nowhere = vec![[0.0; 3]; rig.vertices()];
    let mut distances: Vec<f64> = moved.iter().map(|pose| square(pose, &nowhere)).collect();
    let mut chosen = Vec::new();
    while chosen.len() < COUNTED {
        let farthest =
            (0..moved.len()).max_by(|&a, &b| distances[a].total_cmp(&distances[b]).then(b.cmp(&a)));
        let Some(next) = farthest.filter(|&next| distances[next] > 0.0) else { break };
        chosen.push(moved[next].clone());
        for (distance, pose) in distances.iter_mut().zip(&moved) {
            *distance = distance.min(square(pose, &moved[next]));
        }
    }
    Ok(chosen)
}

/// The whole mesh, with a vertex of its own for each pair of a vertex and what differs at its corners: a
/// seam is where several lie at one place.
struct Wedges {
    triangles: Vec<LevelTriangle>,
    /// The corner and the material of each wedge.
    wedges: Vec<(LevelCorner, u32)>,
    /// The wedges of each triangle.
    indices: Vec<u32>,
    positions: Vec<[f32; 3]>,
    flags: Vec<VertexFlags>,
}

impl Wedges {
    fn new(rig: &Rig) -> Result<Self> {
        let triangles = rig.level_triangles()?;
        let mut numbers: BTreeMap<(LevelCorner, u32), u32> = BTreeMap::new();
        for triangle in &triangles {
            for corner in triangle.corners {
                numbers.insert((corner, triangle.material), 0);
            }
        }
        // In the order of the vertices.
        numbers.values_mut().zip(0..).for_each(|(number, next)| *number = next);
        let of_triangle = |t: &LevelTriangle| t.corners.map(|corner| numbers[&(corner, t.material)]);
        let indices = triangles.iter().flat_map(of_triangle).collect();
        let mut is_locked = vec![false; rig.vertices()];
        rig.handles().held().for_each(|v| is_locked[v.index()] = true);
        let eyeballs = rig.learned().into_iter().flat_map(|learned| &learned.contact.eyeballs);
        eyeballs.flat_map(|eyeball| eyeball.corners).for_each(|v| is_locked[v.index()] = true);
        let wedges: Vec<(LevelCorner, u32)> = numbers.into_keys().collect();
        let rest = &rig.surface().rest;
        let flag = |v: VertexId| if is_locked[v.index()] { VertexFlags::LOCK } else { VertexFlags::EMPTY };
        Ok(Self {
            triangles,
            indices,
            positions: wedges.iter().map(|(corner, _)| rest[corner.vertex.index()]).collect(),
            flags: wedges.iter().map(|(corner, _)| flag(corner.vertex)).collect(),
            wedges,
        })
    }

    /// Where each pose takes the wedges, one after the other. Without a pose, they stay.
    fn attributes(&self, poses: &[Vec<[f32; 3]>], rig: &Rig) -> Moved {
        debug_assert!(poses.iter().all(|pose| pose.len() == rig.vertices()));
        if poses.is_empty() {
            return Moved { numbers: vec![0.0; self.wedges.len()], width: 1 };
        }
        let of_wedge = |(corner, _): &(LevelCorner, u32)| {
            let v = corner.vertex.index();
            poses.iter().flat_map(move |pose| pose[v])
        };
        Moved { numbers: self.wedges.iter().flat_map(of_wedge).collect(), width: 3 * poses.len() }
    }

    /// About so many triangles, or more where no fewer can be had.
    fn simplified(&self, target: usize, moved: &Moved) -> Result<Vec<LevelTriangle>> {
        let failed = |e: meshoptimizer_rs::Error| Error::Internal(format!("simplifying failed: {e}"));
        let positions = Positions::from_packed(&self.positions);
        // The library divides positions by the size of the mesh.
        let size = simplify_scale(positions).map_err(failed)?;
        let weights = vec![OF_POSES / size.max(f32::MIN_POSITIVE); moved.width];
        let attributes =
            Attributes::from_interleaved(&moved.numbers, self.wedges.len(), moved.width, moved.width, 0)
                .map_err(failed)?;
        let settings = SimplifySettings {
            target_index_count: 3 * target,
            // The number of triangles decides.
            target_error: 1e6,
            // Without it, triangles become slivers and turn over.
            options: SimplifyOptions::REGULARIZE_LIGHT,
        };
        let mut workspace = Workspace::default();
        let found = simplify_with_attributes(
            &self.indices,
            positions,
            attributes,
            &weights,
            Some(&self.flags),
            settings,
            &mut workspace,
        )
        .map_err(failed)?;
        let triangle = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|wedge| self.wedges[wedge as usize]);
            LevelTriangle { corners: [a.0, b.0, c.0], material: a.1 }
        };
        let has_area = |triangle: &LevelTriangle| {
            let [a, b, c] = triangle.corners.map(|corner| corner.vertex);
            a != b && b != c && c != a
        };
        let (corners, _) = found.indices.as_chunks::<3>();
        Ok(corners.iter().map(triangle).filter(has_area).collect())
    }
}

/// Where poses take the wedges: `width` numbers of each.
struct Moved {
    numbers: Vec<f32>,
    width: usize,
}

/// Where each vertex of the whole rig is on the level's surface. It is in the triangle that it is nearest to
/// at rest and in all `poses` together, of a few near triangles of its part. Lips that touch at rest are told
/// apart by poses in which they do not.
fn points_of(
    rig: &Rig,
    level: &Level,
    triangles: &[LevelTriangle],
    poses: &[Vec<[f32; 3]>],
) -> Vec<SurfacePoint> {
    let surface = level.rig.surface();
    let at = |v: u32| DVec3::from(surface.rest[v as usize].map(f64::from));
    let corners = |t: usize| surface.triangles[t].map(at);
    let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
    let with_area = (0..surface.triangles.len()).filter(|&t| normal(corners(t)).length_squared() > 0.0);
    let tree = Surface::new(with_area.map(|t| (t, corners(t))));
    let (parts, _) = components(rig.vertices(), rig.surface().joined_triangles().iter());
    let part = |v: VertexId| parts[rig.surface().first(v.0) as usize];
    let mut places = vec![None; rig.vertices()];
    level.kept.iter().enumerate().for_each(|(i, v)| places[v.index()] = Some(VertexId::from_index(i)));
    let point = |v: usize| {
        if let Some(own) = places[v] {
            return SurfacePoint::from(own);
        }
        let p = DVec3::from(rig.surface().rest[v].map(f64::from));
        let is_of_part = |found: &Closest| {
            part(triangles[found.triangle].corners[0].vertex) == part(VertexId::from_index(v))
        };
        let apart = |found: &Closest| {
            let corners = triangles[found.triangle].corners.map(|corner| corner.vertex.index());
            let at_rest = found.point - p;
            let of_pose = |pose: &Vec<[f32; 3]>| {
                let at = |v: usize| DVec3::from(pose[v].map(f64::from));
                let moved: DVec3 = corners.iter().zip(found.weights).map(|(&c, w)| w * at(c)).sum();
                (at_rest + moved - at(v)).length_squared()
            };
            at_rest.length_squared() + poses.iter().map(of_pose).sum::<f64>()
        };
        let near = |count| tree.nearest(p, count).filter(|found| is_of_part(found));
        // A part among others may have no triangle among the nearest.
        let few = near(CANDIDATES).min_by(|a, b| apart(a).total_cmp(&apart(b)));
        let found = few.or_else(|| near(usize::MAX).next()).or_else(|| tree.closest(p));
        let point = found.and_then(|found| {
            SurfacePoint::new(surface.triangles[found.triangle].map(VertexId), found.weights)
        });
        point.unwrap_or(SurfacePoint::from(VertexId(0)))
    };
    (0..rig.vertices()).into_par_iter().map(point).collect()
}

/// How far the vertices of the whole rig are from their points on each level.
fn measure(
    playback: &mut Playback<'_>,
    poses: &[[f32; 3]],
    levels: &mut [LevelOfDetail],
    progress: &dyn Progress,
) -> Result<()> {
    let vertices = playback.rig().vertices();
    let count = poses.len() / playback.rig().handles().len();
    let mut squares = vec![0.0_f64; levels.len()];
    let handles = playback.rig().handles().len();
    for (i, some) in poses.chunks(BATCH * handles).enumerate() {
        progress.step("measure the levels", (i * BATCH) as u64, count as u64)?;
        playback.evaluate_unfinished(some, progress, |positions, _| {
            for (level, squares) in levels.iter_mut().zip(&mut squares) {
                let own: Vec<[f32; 3]> = level.level.kept.iter().map(|v| positions[v.index()]).collect();
                let apart: Vec<f64> = level
                    .points
                    .par_iter()
                    .zip(positions)
                    .map(|(point, x)| {
                        let off = vec3::sub(point.at(&own).map(f64::from), x.map(f64::from));
                        vec3::dot(off, off)
                    })
                    .collect();
                level.worst = apart.iter().copied().fold(level.worst, f64::max);
                *squares += apart.iter().sum::<f64>();
            }
        })?;
    }
    progress.step("measure the levels", count as u64, count as u64)?;
    for (level, squares) in levels.iter_mut().zip(squares) {
        level.worst = level.worst.sqrt();
        level.rms = (squares / (count * vertices).max(1) as f64).sqrt();
        level.poses = count;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_conformance::evaluate;
    use rhytid_core::NoProgress;
    use rhytid_devices::{Guard, choose_devices};
    use rhytid_test_support::lips;

    fn solved(face: &rhytid_core::Face) -> Rig {
        rhytid_solve::solve(face, &NoProgress).unwrap().rounded().unwrap()
    }

    fn devices() -> Vec<DeviceInfo> {
        choose_devices("cpu:0", Guard::NONE, &NoProgress).unwrap().devices
    }

    /// Beside the reference evaluation of both rigs.
    #[test]
    fn vertices_that_stay_are_where_the_whole_rig_has_them() {
        for face in [rhytid_demo::face(5_000), lips::face()] {
            let rig = solved(&face);
            let made = levels(&rig, &[], 2, &devices(), &NoProgress).unwrap();
            assert!(!made.is_empty());
            for LevelOfDetail { level, points, worst, rms, .. } in &made {
                assert!(level.kept.is_sorted_by(|a, b| a < b) && level.kept.len() < rig.vertices());
                assert_eq!(level.rig.handles().labels, rig.handles().labels);
                let triangles = &level.rig.surface().triangles;
                for v in level.rig.handles().held() {
                    assert!(
                        triangles.iter().flatten().any(|corner| *corner == v.0),
                        "{v:?} is in no triangle"
                    );
                }
                let (mut farthest, mut squares, mut count) = (0.0_f64, 0.0, 0);
                let all = [&rig.handles().rest[..], &poses(&rig)].concat();
                for pose in all.chunks(rig.handles().len()) {
                    let [whole, own] = [&rig, &level.rig].map(|rig| evaluate(rig, pose).positions);
                    for (v, x) in level.kept.iter().zip(&own) {
                        assert_eq!(*x, whole[v.index()], "{v:?}");
                    }
                    for (point, x) in points.iter().zip(&whole) {
                        let off = vec3::sub(point.at(&own).map(f64::from), x.map(f64::from));
                        farthest = farthest.max(vec3::length(off));
                        squares += vec3::dot(off, off);
                        count += 1;
                    }
                }
                assert!((farthest - worst).abs() < 1e-3 * worst, "{farthest}, {worst} stated");
                let found = (squares / f64::from(count)).sqrt();
                assert!((found - rms).abs() < 1e-3 * rms, "{found}, {rms} stated");
            }
        }
    }

    /// The vertices that poses need are other ones than those that the neutral needs.
    #[test]
    fn poses_count_in_the_choice_of_vertices() {
        let rig = solved(&rhytid_demo::face(20_000));
        let mut playback = Playback::new(&rig, &devices(), BATCH).unwrap();
        let mesh = Wedges::new(&rig).unwrap();
        let counted = counted(&mut playback, &[], &NoProgress).unwrap();
        assert!((3..=COUNTED).contains(&counted.len()));
        let mut rms = |poses_counted: &[Vec<[f32; 3]>]| {
            let attributes = mesh.attributes(poses_counted, &rig);
            let triangles = mesh.simplified(mesh.triangles.len() / 4, &attributes).unwrap();
            let level = rig.level(&triangles).unwrap();
            let points = points_of(&rig, &level, &triangles, &counted);
            let mut made = [LevelOfDetail { level, points, worst: 0.0, rms: 0.0, poses: 0 }];
            measure(&mut playback, &poses(&rig), &mut made, &NoProgress).unwrap();
            made[0].rms
        };
        let [with, without] = [rms(&counted), rms(&[])];
        println!("RMS {with:.5} with poses, {without:.5} without");
        assert!(with < 0.9 * without, "{with} {without}");
    }

    /// A triangle that is turned over or very thin is a dark fleck in a picture.
    #[test]
    fn hardly_a_triangle_is_turned_over_or_a_sliver() {
        let rig = solved(&rhytid_demo::face(30_000));
        let normals = evaluate(&rig, &rig.handles().rest).normals;
        for LevelOfDetail { level, .. } in levels(&rig, &[], 3, &devices(), &NoProgress).unwrap() {
            let surface = level.rig.surface();
            let (mut turned, mut slivers) = (0, 0);
            for triangle in &surface.triangles {
                let [a, b, c] = triangle.map(|v| surface.rest[v as usize].map(f64::from));
                let [ab, ac, bc] = [vec3::sub(b, a), vec3::sub(c, a), vec3::sub(c, b)];
                let normal = vec3::cross(ab, ac);
                let whole = triangle.map(|v| normals[level.kept[v as usize].index()].map(f64::from));
                turned += usize::from(whole.iter().all(|n| vec3::dot(*n, normal) < 0.0));
                let longest = [ab, ac, bc].map(vec3::length).into_iter().fold(0.0, f64::max);
                slivers += usize::from(vec3::length(normal) < 0.02 * longest * longest);
            }
            let all = surface.triangles.len();
            println!("{all} triangles: {turned} turned over, {slivers} slivers");
            assert!(turned * 2_000 <= all, "{turned} of {all} are turned over");
            assert!(slivers * 200 <= all, "{slivers} of {all} are slivers");
        }
    }

    /// Texture coordinates and materials of every corner are those of the whole mesh.
    #[test]
    fn seams_and_materials_stay() {
        let mut face = rhytid_demo::face(3_000);
        let names = ["left", "right"];
        let middle = |indices: &[u32]| {
            indices.iter().map(|&v| face.neutral.positions[v as usize][0]).sum::<f64>() / indices.len() as f64
        };
        let of_face: Vec<u32> =
            face.neutral.faces.iter().map(|indices| u32::from(middle(indices) > 0.0)).collect();
        face.neutral.materials = Some(rhytid_core::Materials::named(names, of_face));
        let rig = solved(&face);
        let whole = rig.level_triangles().unwrap();
        let made = levels(&rig, &[], 2, &devices(), &NoProgress).unwrap();
        for LevelOfDetail { level, .. } in &made {
            let own = level.rig.level_triangles().unwrap();
            let materials = level.rig.surface().materials.as_ref().unwrap();
            assert_eq!(materials.names().collect::<Vec<_>>(), names);
            let (of_level, of_whole) = (level.rig.surface().uvs.as_ref(), rig.surface().uvs.as_ref());
            let (of_level, of_whole) = (of_level.unwrap(), of_whole.unwrap());
            // All pairs of a vertex with coordinates and a material that the whole mesh has.
            let key = |corner: &LevelCorner, material: u32, uvs: &rhytid_core::Uvs, kept: &[VertexId]| {
                let vertex = if kept.is_empty() { corner.vertex } else { kept[corner.vertex.index()] };
                (vertex, uvs.values[corner.uv as usize].map(f32::to_bits), material)
            };
            let known: std::collections::BTreeSet<_> = whole
                .iter()
                .flat_map(|t| t.corners.iter().map(move |corner| (corner, t.material)))
                .map(|(corner, material)| key(corner, material, of_whole, &[]))
                .collect();
            for triangle in &own {
                for corner in &triangle.corners {
                    assert!(known.contains(&key(corner, triangle.material, of_level, &level.kept)));
                }
            }
            // The border between the two lies where it lay.
            let on_border = |triangles: &[LevelTriangle], material: u32| {
                let of = triangles.iter().filter(move |t| t.material == material);
                of.flat_map(|t| t.corners.map(|corner| corner.vertex))
                    .collect::<std::collections::BTreeSet<_>>()
            };
            let [left, right] = [0, 1].map(|material| on_border(&own, material));
            let shared = left.intersection(&right).count();
            assert!(shared > 5, "{shared} vertices on the border");
        }
    }

    /// A mesh of OBJ, say, has a coordinate for each corner: the upper half of this one lies elsewhere in the
    /// texture, and no vertex is double.
    #[test]
    fn islands_of_texture_coordinates_stay_islands() {
        const ASIDE: f32 = 4.0;
        let mut face = rhytid_demo::face(3_000);
        let uvs = face.neutral.uvs.take().unwrap();
        let vertices = uvs.values.len() as u32;
        let aside = uvs.values.iter().map(|[u, v]| [u + ASIDE, *v]);
        let is_upper = |indices: &[u32]| indices.iter().all(|&v| uvs.values[v as usize][1] > 0.5);
        let of_face = |indices: &[u32]| {
            let first = if is_upper(indices) { vertices } else { 0 };
            indices.iter().map(|v| first + v).collect::<Vec<u32>>()
        };
        face.neutral.uvs = Some(rhytid_core::Uvs {
            corners: Some(face.neutral.faces.iter().flat_map(of_face).collect()),
            values: uvs.values.iter().copied().chain(aside).collect(),
        });
        let made = levels(&solved(&face), &[], 2, &devices(), &NoProgress).unwrap();
        assert_eq!(made.len(), 2);
        for LevelOfDetail { level, .. } in &made {
            let surface = level.rig.surface();
            let own = surface.uvs.as_ref().unwrap();
            let corners = own.corners.as_ref().unwrap();
            let mut islands = [const { std::collections::BTreeSet::new() }; 2];
            let triangles = surface.faces.indices.as_chunks::<3>().0;
            for (vertices, corners) in triangles.iter().zip(corners.as_chunks::<3>().0) {
                let at = corners.map(|corner| own.values[corner as usize]);
                let island = usize::from(at[0][0] >= ASIDE);
                for (v, [across, up]) in vertices.iter().zip(at) {
                    let [own, height] = uvs.values[level.kept[*v as usize].index()];
                    let expected = [own + ASIDE * island as f32, height];
                    assert_eq!([across, up], expected, "a corner at vertex {v} of the level");
                    islands[island].insert(*v);
                }
            }
            let seam = islands[0].intersection(&islands[1]).count();
            assert!(
                seam > 5 && islands.iter().all(|island| island.len() > 50),
                "{seam} vertices on the seam"
            );
        }
    }
}
