//! The connected parts of a mesh: skin, eyes, teeth, lashes.

use glam::{DMat4, DVec3, DVec4};
use rhytid_core::{Result, Rig, Surface};

/// Linear red, green and blue of teeth and eyeballs: a shade of white, since the rig has no colours.
const WHITE: [f32; 3] = [0.62, 0.60, 0.55];

/// What is learned of a part is affine up to this part of it, if the part is a solid.
const AFFINE_WITHIN: f64 = 0.1;

/// What is learned is nothing if its RMS is below this.
const NOTHING: f64 = 1e-3;

/// The smallest vertex of each vertex's connected part.
fn parts(surface: &Surface) -> Vec<u32> {
    fn root(of: &mut [u32], mut v: u32) -> u32 {
        while of[v as usize] != v {
            of[v as usize] = of[of[v as usize] as usize];
            v = of[v as usize];
        }
        v
    }
    let vertices = surface.rest.len() as u32;
    let mut of: Vec<u32> = (0..vertices).map(|v| surface.first(v)).collect();
    for face in surface.faces.iter() {
        for pair in face.windows(2) {
            let (a, b) = (root(&mut of, pair[0]), root(&mut of, pair[1]));
            of[a.max(b) as usize] = a.min(b);
        }
    }
    (0..vertices).map(|v| root(&mut of, v)).collect()
}

/// Linear albedos of V vertices. All have `skin`, except for rigid parts without a handle, which are assumed
/// to be teeth and eyes.
///
/// The vertices of such a part have the same anchors and nothing else. A solid's movements are affine in the
/// place at rest. What is learned is linear in the movements of the examples, so it is affine too. The gums
/// have the same anchors, but are not affine.
pub fn albedos(rig: &Rig, skin: [f32; 3]) -> Vec<[f32; 3]> {
    let Some(learned) = rig.learned() else { return vec![skin; rig.vertices()] };
    let parts = parts(rig.surface());
    let row = |v: usize| (learned.anchors.row(v), learned.anchor_weights.row(v));
    let is_anchored = |v: usize| row(v).1.iter().sum::<f32>() > 0.999;
    let mut solid: Vec<bool> = (0..rig.vertices()).map(is_anchored).collect();
    for (v, &part) in parts.iter().enumerate() {
        if row(v) != row(part as usize) || !is_anchored(v) {
            solid[part as usize] = false;
        }
    }
    for handle in rig.handles().held() {
        solid[parts[handle.index()] as usize] = false;
    }
    let mut members = vec![Vec::new(); rig.vertices()];
    let of_solids = parts.iter().enumerate().filter(|(_, part)| solid[**part as usize]);
    of_solids.for_each(|(v, &part)| members[part as usize].push(v));
    for (part, members) in members.iter().enumerate().filter(|(_, members)| !members.is_empty()) {
        let rest: Vec<DVec3> =
            members.iter().map(|&v| DVec3::from_array(rig.surface().rest[v].map(f64::from))).collect();
        let basis = |i: usize| rig.basis().row(members[i]).to_vec();
        let weights = |i: usize| learned.example_weights.row(members[i]).as_flattened().to_vec();
        solid[part] = is_affine(&rest, basis) && is_affine(&rest, weights);
    }
    parts.iter().map(|&part| if solid[part as usize] { WHITE } else { skin }).collect()
}

/// Whether the rows of N points are about an affine function of the points.
fn is_affine(points: &[DVec3], row: impl Fn(usize) -> Vec<f32>) -> bool {
    let center = points.iter().sum::<DVec3>() / points.len() as f64;
    let rows: Vec<Vec<f32>> = (0..points.len()).map(row).collect();
    let extent = points.iter().map(|x| x.distance(center)).fold(f64::MIN_POSITIVE, f64::max);
    let affine = |x: &DVec3| ((*x - center) / extent).extend(1.0);
    let mut normal = DMat4::from_diagonal(DVec4::splat(1e-9));
    for a in points.iter().map(affine) {
        normal += DMat4::from_cols(a * a.x, a * a.y, a * a.z, a * a.w);
    }
    let inverse = normal.inverse();
    let (mut square, mut left) = (0.0, 0.0);
    for column in 0..rows.first().map_or(0, Vec::len) {
        let values = || rows.iter().map(|row| f64::from(row[column]));
        let of_column: f64 = values().map(|x| x * x).sum();
        let right: DVec4 = points.iter().zip(values()).map(|(x, value)| affine(x) * value).sum();
        square += of_column;
        left += of_column - right.dot(inverse * right);
    }
    left <= AFFINE_WITHIN.powi(2) * square || square < NOTHING.powi(2) * points.len() as f64
}

/// The rig without the polygons and triangles of connected parts that have any of these `vertices`, so that
/// they are not drawn.
///
/// # Errors
/// [`rhytid_core::Error::Input`] if no polygon would remain.
///
/// # Panics
/// If the rig has no such vertex.
pub fn hide_parts(rig: Rig, vertices: &[usize]) -> Result<Rig> {
    if vertices.is_empty() {
        return Ok(rig);
    }
    let mut rig = rig.into_parts();
    let surface = &mut rig.surface;
    let parts = parts(surface);
    let hidden: Vec<u32> = vertices.iter().map(|&v| parts[v]).collect();
    let is_seen = |corners: &[u32]| corners.iter().all(|&v| !hidden.contains(&parts[v as usize]));
    let of_faces: Vec<bool> = surface.faces.iter().map(is_seen).collect();
    let counts = surface.faces.counts.iter();
    let of_corners: Vec<bool> = of_faces
        .iter()
        .zip(counts)
        .flat_map(|(seen, &count)| std::iter::repeat_n(*seen, count as usize))
        .collect();
    surface.triangles.retain(|triangle| is_seen(&triangle[..]));
    keep(&mut surface.faces.counts, &of_faces);
    keep(&mut surface.faces.indices, &of_corners);
    if let Some(corners) = surface.uvs.as_mut().and_then(|uvs| uvs.corners.as_mut()) {
        keep(corners, &of_corners);
    }
    if let Some(materials) = &mut surface.materials {
        keep(&mut materials.of_face, &of_faces);
    }
    Rig::new(rig)
}

/// Keeps the elements that are seen.
fn keep<T>(all: &mut Vec<T>, seen: &[bool]) {
    let mut seen = seen.iter();
    all.retain(|_| seen.next().is_none_or(|seen| *seen));
}

#[cfg(test)]
mod tests {
    use super::*;
    use rhytid_core::NoProgress;

    /// The demo's face with two blocks behind it. In each example, all corners of the last block move with
    /// the face's first handle. Of the block before, one corner moves so.
    fn rig() -> Rig {
        let mut face = rhytid_demo::face(2_000);
        let first = face.neutral.positions.len() as u32;
        let at = face.handles.points[0].nearest_vertex().index();
        let corner = |p: [f64; 3], i: usize| {
            let [x, y, z] = p;
            [x + (i & 1) as f64, y + (i >> 1 & 1) as f64, z - 2.0 - (i >> 2) as f64]
        };
        let rest = face.neutral.positions[at];
        face.neutral.positions.extend((0..16).map(|i| corner(rest, i % 8)));
        for first in [first, first + 8] {
            for quad in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
                face.neutral.faces.push(&quad.map(|v: u32| first + v));
            }
        }
        face.neutral.uvs = None;
        face.neutral.materials = None;
        for example in &mut face.examples {
            let moved = example.positions[at];
            example.positions.extend((0..16).map(|i| corner(if i < 7 { rest } else { moved }, i % 8)));
        }
        rhytid_solve::solve(&face, &NoProgress).unwrap().rounded().unwrap()
    }

    #[test]
    fn what_is_affine() {
        let points: Vec<DVec3> =
            (0..27).map(|i| DVec3::new(f64::from(i % 3), f64::from(i / 3 % 3), f64::from(i / 9))).collect();
        let affine = |x: DVec3| vec![(0.3 + x.x - 2.0 * x.y) as f32, (0.1 * x.z) as f32];
        assert!(is_affine(&points, |i| affine(points[i])));
        assert!(is_affine(&points, |_| vec![0.0, 0.0]) && is_affine(&points, |_| vec![1.0]));
        assert!(is_affine(&points[..1], |i| affine(points[i])));
        assert!(!is_affine(&points, |i| vec![(points[i].y - 1.0).max(0.0) as f32]));
    }

    #[test]
    fn solids_are_white_and_parts_are_left_out() {
        let rig = rig();
        let skin = [0.5, 0.3, 0.2];
        let first = rig.vertices() - 8;
        let albedos = albedos(&rig, skin);
        assert!(albedos[..first].iter().all(|albedo| *albedo == skin));
        assert!(albedos[first..].iter().all(|albedo| *albedo == WHITE));
        let face = hide_parts(rig.clone(), &[first + 3]).unwrap();
        let counts =
            [face.surface().faces.len(), face.surface().triangles.len(), face.surface().faces.indices.len()];
        let all =
            [rig.surface().faces.len(), rig.surface().triangles.len(), rig.surface().faces.indices.len()];
        assert_eq!(counts, [all[0] - 6, all[1] - 12, all[2] - 24]);
        assert!(face.surface().triangles.as_flattened().iter().all(|&v| (v as usize) < first));
        face.surface().triangle_corners().unwrap();
        assert!(hide_parts(rig.clone(), &[0, first - 8, first]).is_err(), "nothing is left");
        let block = hide_parts(rig, &[0, first - 8]).unwrap();
        assert_eq!((block.surface().faces.len(), block.surface().triangles.len()), (6, 12));
    }
}
