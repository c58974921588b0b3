//! Mirror images of examples: which vertex is the mirror image of which.
use glam::DVec3;
use rhytid_core::{Error, Example, Face, Faces, Result, VertexId};
use rstar::RTree;
use rstar::primitives::GeomWithData;
use std::collections::{HashMap, VecDeque};

/// The tolerance of mirror images, as a part of the mean edge at a vertex: the neutral is only nearly
/// symmetric.
const NEAR: f64 = 0.25;

/// The number of faces of a component that are tried as the first face. Faces nearest to their mirror images
/// are tried first.
const SEEDS: usize = 32;

/// A mirror image that differs from its example by no more than this part of the largest displacement adds
/// nothing.
const SAME: f64 = 0.01;

/// A part is symmetric if this share of its vertices have mirror images.
const ENOUGH: f64 = 0.9;

/// The face with the mirror images of its examples appended, named after them. `None` if no example asks for
/// one.
///
/// A mirror image has each vertex's displacement, with left and right exchanged, at the vertex's mirror
/// image. An example that is its own mirror image gets none.
///
/// `name` is what messages call a vertex.
///
/// # Errors
/// [`Error::Input`] if some vertex has no mirror image.
pub(crate) fn with_mirror_images(face: &Face, name: impl Fn(usize) -> VertexId) -> Result<Option<Face>> {
    let Some(first) = face.examples.iter().find(|example| example.mirror) else { return Ok(None) };
    let rest = &face.neutral.positions;
    let images = mirror_images(rest, &face.neutral.faces, name).map_err(|what| {
        Error::bad_topology(format!("example {:?} has mirror = true, but {what}", first.name))
    })?;
    let mut mirrored = face.clone();
    for example in face.examples.iter().filter(|example| example.mirror) {
        let mut positions = rest.clone();
        let (mut largest, mut differs) = (0.0_f64, 0.0_f64);
        let moved = |v: usize| DVec3::from_array(example.positions[v]) - DVec3::from_array(rest[v]);
        for (v, &w) in images.iter().enumerate() {
            let image = moved(v) * DVec3::new(-1.0, 1.0, 1.0);
            largest = largest.max(image.length());
            differs = differs.max(image.distance(moved(w as usize)));
            positions[w as usize] = (DVec3::from_array(rest[w as usize]) + image).to_array();
        }
        if differs > SAME * largest {
            let name = format!("{} mirrored", example.name);
            mirrored.examples.push(Example { name, positions, mirror: false, noise: example.noise });
        }
    }
    Ok(Some(mirrored))
}

/// The mirror image of each vertex.
///
/// Images are found by the places of the vertices. If some vertex has none, they are found by the adjacency
/// of the faces, starting at a face whose image is known by place. The error text is the second half of a
/// sentence.
pub(crate) fn mirror_images(
    rest: &[[f64; 3]],
    faces: &Faces,
    name: impl Fn(usize) -> VertexId,
) -> std::result::Result<Vec<u32>, String> {
    let reach = reach(rest, faces);
    let mut images = by_place(rest, &reach);
    if images.contains(&None) {
        images = by_topology(rest, faces, &images);
    }
    let missing = images.iter().filter(|image| image.is_none()).count();
    images.iter().enumerate().map(|(v, image)| image.ok_or(v)).collect::<std::result::Result<_, _>>().map_err(|v| {
        let [x, y, z] = rest[v];
        format!(
            "{missing} of the {} vertices have no mirror image (the first is vertex {} at ({x}, {y}, {z})): \
             expected a neutral whose sides along x match in the places of their vertices or in the layout \
             of their faces; leave mirror out, or scan both sides",
            rest.len(),
            name(v)
        )
    })
}

/// The mirror images of the vertices of a part, such as the head of an avatar whose hair has none. `None` if
/// less than a certain share of them have an image in the part.
pub(crate) fn mirror_images_within(
    rest: &[[f64; 3]],
    faces: &Faces,
    is_in: &[bool],
) -> Option<Vec<Option<u32>>> {
    let kept: Vec<usize> = (0..rest.len()).filter(|&v| is_in[v]).collect();
    if let Ok(images) = mirror_images(rest, faces, VertexId::from_index) {
        // Two heads beside one another are mirror images too.
        let within = kept.iter().filter(|v| is_in[images[**v] as usize]).count();
        if within as f64 >= ENOUGH * kept.len() as f64 {
            return Some(images.into_iter().map(Some).collect());
        }
    }
    let places: Vec<[f64; 3]> = kept.iter().map(|&v| rest[v]).collect();
    let radii = reach(rest, faces);
    let found = by_place(&places, &kept.iter().map(|&v| radii[v]).collect::<Vec<_>>());
    if (found.iter().flatten().count() as f64) < ENOUGH * kept.len() as f64 {
        return None;
    }
    let mut images = vec![None; rest.len()];
    for (&v, image) in kept.iter().zip(found) {
        images[v] = image.map(|w| kept[w as usize] as u32);
    }
    Some(images)
}

/// The search radius of each vertex's mirror image: a part of the mean edge at the vertex.
fn reach(rest: &[[f64; 3]], faces: &Faces) -> Vec<f64> {
    let mut sums = vec![(0.0, 0); rest.len()];
    for corners in faces.iter() {
        for (i, &a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % corners.len()];
            let length = DVec3::from_array(rest[a as usize]).distance(DVec3::from_array(rest[b as usize]));
            for v in [a, b] {
                sums[v as usize].0 += length;
                sums[v as usize].1 += 1;
            }
        }
    }
    sums.into_iter().map(|(sum, count)| NEAR * sum / f64::from(count.max(1))).collect()
}

/// The vertices that lie at each other's mirror image, in a plane x = constant. The plane is moved to where
/// most vertices have an image.
fn by_place(rest: &[[f64; 3]], reach: &[f64]) -> Vec<Option<u32>> {
    let tree = RTree::bulk_load((0..).zip(rest).map(|(v, p): (u32, _)| GeomWithData::new(*p, v)).collect());
    let (low, high) =
        rest.iter().fold((f64::MAX, f64::MIN), |(low, high), p| (low.min(p[0]), high.max(p[0])));
    let mean = rest.iter().map(|p| p[0]).sum::<f64>() / rest.len() as f64;
    // A stray vertex moves one of these away from the middle, but hardly all of them.
    let starts = [0.5 * (low + high), mean, 0.0];
    let all = starts.map(|start| about(start, rest, reach, &tree, 1e-12 * (high - low)));
    let found = |images: &[Option<u32>]| images.iter().flatten().count();
    all.into_iter().reduce(|a, b| if found(&b) > found(&a) { b } else { a }).unwrap_or_default()
}

/// The same, starting from one plane.
fn about(
    mut plane: f64,
    rest: &[[f64; 3]],
    reach: &[f64],
    tree: &RTree<GeomWithData<[f64; 3], u32>>,
    still: f64,
) -> Vec<Option<u32>> {
    let mut images = vec![None; rest.len()];
    // The plane is found from approximate images, and the images from a narrow search.
    for wider in [4.0, 2.0, 1.0, 1.0] {
        let nearest: Vec<Option<u32>> = rest
            .iter()
            .zip(reach)
            .map(|(&[x, y, z], reach)| {
                let image = [2.0 * plane - x, y, z];
                // Of vertices at one place, the lowest counts. Parts that touch are told apart by their
                // faces.
                let found = tree.nearest_neighbors(&image).into_iter().min_by_key(|found| found.data)?;
                let off = DVec3::from_array(*found.geom()).distance(DVec3::from_array(image));
                (off <= wider * reach).then_some(found.data)
            })
            .collect();
        let back = |v: usize| nearest[v].filter(|&w| nearest[w as usize] == Some(v as u32));
        images = (0..rest.len()).map(back).collect();
        let mut sums: Vec<f64> = (0..)
            .zip(&images)
            .filter_map(|(v, w): (usize, _)| Some(rest[v][0] + rest[(*w)? as usize][0]))
            .collect();
        if sums.is_empty() {
            break;
        }
        let middle = sums.len() / 2;
        let median = *sums.select_nth_unstable_by(middle, f64::total_cmp).1;
        if wider == 1.0 && (0.5 * median - plane).abs() < still {
            break;
        }
        plane = 0.5 * median;
    }
    images
}

/// The mirror images of all vertices that are connected, face by face, to a face whose image is known by
/// place.
fn by_topology(rest: &[[f64; 3]], faces: &Faces, by_place: &[Option<u32>]) -> Vec<Option<u32>> {
    let all: Vec<&[u32]> = faces.iter().collect();
    // The face at each directed edge, and the corner at which the edge begins.
    let mut beside = HashMap::new();
    for (f, corners) in all.iter().enumerate() {
        for (i, &a) in corners.iter().enumerate() {
            beside.insert((a, corners[(i + 1) % corners.len()]), (f, i));
        }
    }
    let image_of = |f: usize| -> Option<Vec<u32>> { all[f].iter().map(|&v| by_place[v as usize]).collect() };
    // A mirror image has its corners in the opposite order.
    let mut seeds: Vec<(f64, usize)> = (0..all.len())
        .filter_map(|f| {
            let image = image_of(f)?;
            let &(g, from) = beside.get(&(image[1], image[0]))?;
            let n = image.len();
            let is_face = all[g].len() == n && (0..n).all(|i| image[i] == all[g][(from + 1 + n - i) % n]);
            let off = |(&v, &w): (&u32, &u32)| {
                let ([_, y, z], [_, b, c]) = (rest[v as usize], rest[w as usize]);
                (y - b).abs() + (z - c).abs()
            };
            if !is_face {
                return None;
            }
            Some((all[f].iter().zip(&image).map(off).sum(), f))
        })
        .collect();
    seeds.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut images = vec![None; rest.len()];
    let mut tried = 0;
    for (_, seed) in seeds {
        if tried == SEEDS || all[seed].iter().all(|&v| images[v as usize].is_some()) {
            continue;
        }
        let Some(image) = image_of(seed) else { continue };
        tried += 1;
        if let Some(found) = spread(&all, &beside, seed, &image) {
            tried = 0;
            for (v, w) in found {
                images[v as usize] = Some(w);
                images[w as usize] = Some(v);
            }
        }
    }
    // Vertices without a face, and parts whose faces did not help, get their images by place.
    let free = |v: u32, images: &[Option<u32>]| images[v as usize].is_none();
    for (v, image) in (0..).zip(by_place) {
        if let Some(w) = *image
            && free(v, &images)
            && free(w, &images)
        {
            images[v as usize] = Some(w);
            images[w as usize] = Some(v);
        }
    }
    images
}

/// Spreads images from a face and its mirror image to all connected faces. `None` if the two sides are not
/// connected in the same way.
fn spread(
    all: &[&[u32]],
    beside: &HashMap<(u32, u32), (usize, usize)>,
    seed: usize,
    image: &[u32],
) -> Option<HashMap<u32, u32>> {
    let mut images: HashMap<u32, u32> = HashMap::new();
    let mut done = vec![false; all.len()];
    let mut queue = VecDeque::from([(seed, image.to_vec())]);
    while let Some((f, image)) = queue.pop_front() {
        if std::mem::replace(&mut done[f], true) {
            continue;
        }
        for (&v, &w) in all[f].iter().zip(&image) {
            if *images.entry(v).or_insert(w) != w || images.get(&w).is_some_and(|back| *back != v) {
                return None;
            }
        }
        let corners = all[f].len();
        for i in 0..corners {
            let next = (i + 1) % corners;
            // The face across an edge has the edge in the opposite direction. The image of that face has it
            // in this face's direction.
            let over = beside.get(&(all[f][next], all[f][i]));
            let over_image = beside.get(&(image[i], image[next]));
            match (over, over_image) {
                (None, None) => {}
                (Some(&(g, at)), Some(&(h, from))) if all[g].len() == all[h].len() => {
                    if done[g] {
                        continue;
                    }
                    let n = all[g].len();
                    let mut of_g = vec![0; n];
                    for step in 0..n {
                        of_g[(at + step) % n] = all[h][(from + 1 + n - step) % n];
                    }
                    queue.push_back((g, of_g));
                }
                _ => return None,
            }
        }
    }
    Some(images)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of 7 × 5 quads across x = 2, bent symmetrically, with its vertices in rows. `skew` moves the
    /// vertices of one side.
    fn grid(skew: f64) -> (Vec<[f64; 3]>, Faces) {
        let at = |i: u32| {
            let (x, y) = (f64::from(i % 8) - 3.5, f64::from(i / 8));
            let skew = if x > 0.0 { skew } else { 0.0 };
            [2.0 + x + 0.3 * skew * y, y + skew * x, 0.1 * x * x + skew]
        };
        let mut faces = Faces::default();
        for a in (0..5).flat_map(|row| (0..7).map(move |column| 8 * row + column)) {
            faces.push(&[a, a + 1, a + 9, a + 8]);
        }
        ((0..48).map(at).collect(), faces)
    }

    fn expected() -> Vec<u32> {
        (0..48).map(|v| v / 8 * 8 + 7 - v % 8).collect()
    }

    #[test]
    fn mirror_images_by_place_and_by_how_the_faces_lie() {
        for skew in [0.0, 0.01, 0.2] {
            let (rest, faces) = grid(skew);
            assert_eq!(mirror_images(&rest, &faces, VertexId::from_index).unwrap(), expected(), "{skew}");
        }
        // The second grid needs more than the places of its vertices.
        let (rest, faces) = grid(0.2);
        assert!(by_place(&rest, &reach(&rest, &faces)).contains(&None));
    }

    #[test]
    fn what_has_no_other_side_is_said() {
        let (mut rest, mut faces) = grid(0.0);
        rest.push([9.0, 0.0, 0.0]);
        let error = mirror_images(&rest, &faces, VertexId::from_index).unwrap_err();
        assert!(error.contains("vertex 48 at (9, 0, 0)"), "{error}");
        // A grid whose faces differ: no image spreads from the first face.
        rest.pop();
        rest[47] = [30.0, 30.0, 0.0];
        faces.push(&[46, 47, 39]);
        assert!(mirror_images(&rest, &faces, VertexId::from_index).is_err());
    }

    #[test]
    fn a_mirrored_example_is_the_example_from_the_other_side() {
        let (rest, faces) = grid(0.0);
        let mut smile = rest.clone();
        smile[9] = [rest[9][0] + 0.5, rest[9][1] + 0.25, rest[9][2] + 1.0];
        let mut face = rhytid_test_support::sheet::face();
        face.neutral.positions = rest.clone();
        face.neutral.faces = faces;
        let raised = rest.iter().map(|[x, y, z]| [*x, *y, z + 1.0]).collect();
        face.examples = vec![
            Example { name: "smile".into(), positions: smile, mirror: true, noise: None },
            // Its own mirror image.
            Example { name: "raised".into(), positions: raised, mirror: true, noise: None },
        ];
        let mirrored = with_mirror_images(&face, VertexId::from_index).unwrap().unwrap();
        assert_eq!(mirrored.examples.len(), 3);
        assert_eq!(mirrored.examples[2].name, "smile mirrored");
        for (v, (found, rest)) in mirrored.examples[2].positions.iter().zip(&rest).enumerate() {
            let moved = if v == 14 { [-0.5, 0.25, 1.0] } else { [0.0; 3] };
            for c in 0..3 {
                assert!((found[c] - rest[c] - moved[c]).abs() < 1e-12, "{v}: {found:?}");
            }
        }
        face.examples.iter_mut().for_each(|example| example.mirror = false);
        assert_eq!(with_mirror_images(&face, VertexId::from_index).unwrap(), None);
    }
}
