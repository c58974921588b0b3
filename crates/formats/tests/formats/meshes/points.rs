//! The vertices that glTF splits are found to be one point, on real meshes.

use rhytid_core::{Faces, Mesh};
use rhytid_formats::mesh::{order, read, read_like};
use rhytid_geometry::Points;
use rhytid_test_support::split::{SplitMesh, split_mesh};
use rhytid_test_support::{glb, shared};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// The neutral of a face beside the repository, and its poses.
fn real(name: &str) -> Option<(PathBuf, Vec<PathBuf>)> {
    let folder = shared("data")?.join(name);
    let poses = std::fs::read_dir(folder.join("poses")).unwrap().map(|pose| pose.unwrap().path());
    Some((folder.join("neutral.obj"), poses.collect()))
}

/// The mesh split at its texture seams, and with flat shading.
fn splits(mesh: &Mesh) -> [SplitMesh; 2] {
    let corners = mesh.uvs.as_ref().and_then(|uvs| uvs.corners.clone());
    [
        split_mesh(mesh, |_, corner| corners.as_ref().map_or(0, |uvs| uvs[corner] as usize)),
        split_mesh(mesh, |face, _| face),
    ]
}

#[test]
fn the_points_of_real_meshes_are_the_vertices_that_were_split() {
    for name in ["face", "head", "aura", "makehuman"] {
        let Some((neutral, poses)) = real(name) else { return };
        let mesh = read(&neutral).unwrap();
        let poses: Vec<Vec<[f64; 3]>> =
            poses.iter().map(|pose| read_like(&mesh, &neutral, pose).unwrap()).collect();
        for SplitMesh { mesh, of_vertex } in splits(&mesh) {
            let split = |positions: &Vec<[f64; 3]>| -> Vec<[f64; 3]> {
                of_vertex.iter().map(|&v| positions[v as usize]).collect()
            };
            let examples: Vec<Vec<[f64; 3]>> = poses.iter().map(split).collect();
            let examples: Vec<&[[f64; 3]]> = examples.iter().map(Vec::as_slice).collect();
            // Vertices of points are together, and all others apart. With and without examples.
            for examples in [&examples[..], &[]] {
                let found = Points::new(&mesh, examples);
                let found =
                    found.map_or_else(|| (0..of_vertex.len() as u32).collect(), |found| found.of_vertex);
                // Vertices of the same one that are not together, and others that are.
                let mut point_of = HashMap::new();
                let mut apart = 0;
                for (of, point) in of_vertex.iter().zip(&found) {
                    apart += usize::from(*point_of.entry(of).or_insert(point) != point);
                }
                let points: HashSet<&u32> = point_of.values().copied().collect();
                let extra = point_of.len() - points.len();
                // The strips at the eyes of this head lie on each other with their edges.
                let most_extra = if name == "head" { 100 } else { 0 };
                assert!(apart == 0 && extra <= most_extra, "{name}: {apart} apart, {extra} extra");
            }
        }
    }
}

/// A closed tent of four triangles over a square.
fn tent(height: f32) -> Mesh {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let mut mesh = Mesh::default();
    mesh.positions.extend(corners.map(|[x, y]| [x, y, 0.0]));
    mesh.positions.push([0.25, 0.0, f64::from(height)]);
    (0..4).for_each(|i| mesh.faces.push(&[i, (i + 1) % 4, 4]));
    mesh
}

fn written(folder: &Path, name: &str, mesh: &Mesh) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, glb(mesh)).unwrap();
    path
}

#[test]
fn an_example_may_be_split_in_another_way_if_one_is_gltf() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let [whole, raised] = [tent(1.0), tent(1.5)];
    let flat = |mesh: &Mesh| split_mesh(mesh, |face, _| face).mesh;
    let halves = |mesh: &Mesh| split_mesh(mesh, |face, _| face / 2).mesh;
    let neutrals = [whole.clone(), flat(&whole), halves(&whole)];
    let examples = [raised.clone(), flat(&raised), halves(&raised)];
    for (n, neutral) in neutrals.iter().enumerate() {
        let neutral_path = written(folder, "neutral.glb", neutral);
        let neutral = read(&neutral_path).unwrap();
        for (e, example) in examples.iter().enumerate() {
            let path = written(folder, "raised.glb", example);
            let found = read_like(&neutral, &neutral_path, &path).unwrap();
            // The neutral has its own vertices, at the heights of the example.
            let raised = |x: &[f64; 3]| [x[0], x[1], if x[2] > 0.0 { 1.5 } else { 0.0 }];
            let expected: Vec<[f64; 3]> = neutral.positions.iter().map(raised).collect();
            assert_eq!(found, expected, "{n} {e}");
        }
    }
    // Also where an example's corners are apart that are one vertex of the neutral, as a torn mesh.
    let mut torn = flat(&raised);
    torn.positions[8][2] = 0.5;
    let (neutral_path, path) = (written(folder, "neutral.glb", &whole), written(folder, "torn.glb", &torn));
    let error = read_like(&read(&neutral_path).unwrap(), &neutral_path, &path).unwrap_err().to_string();
    for words in
        ["torn.glb: has 12 vertices, but ", "same shading and texture coordinates", "keep vertex order"]
    {
        assert!(error.contains(words), "{error}");
    }
    // Faces in another order are not matched, as their corners are elsewhere.
    let mut turned = flat(&raised);
    turned.faces.indices[..6].rotate_left(3);
    let path = written(folder, "turned.glb", &turned);
    assert!(order(&read(&path).unwrap(), &whole, &neutral_path, &path).is_err());
    // OBJ has its own order, in which a vertex more is another mesh.
    let obj = folder.join("neutral.obj");
    let error = order(&flat(&raised), &whole, &obj, &folder.join("raised.obj")).unwrap_err().to_string();
    assert!(error.contains("without merging, splitting or reordering"), "{error}");
}

#[test]
fn real_poses_that_are_exported_flat_fit_a_smooth_neutral() {
    let Some((neutral_path, poses)) = real("face") else { return };
    let folder = tempfile::tempdir().unwrap();
    let quads = read(&neutral_path).unwrap();
    let seams = &splits(&quads)[0];
    let glb_path = written(folder.path(), "neutral.glb", &seams.mesh);
    let neutral = read(&glb_path).unwrap();
    for pose in poses.iter().take(2) {
        let positions = read_like(&quads, &neutral_path, pose).unwrap();
        let flat = &splits(&Mesh { positions: positions.clone(), ..quads.clone() })[1];
        let path = written(folder.path(), "pose.glb", &flat.mesh);
        let found = read_like(&neutral, &glb_path, &path).unwrap();
        for (x, &v) in found.iter().zip(&seams.of_vertex) {
            let expected = positions[v as usize].map(|x| f64::from(x as f32));
            assert_eq!(*x, expected);
        }
    }
}

#[test]
fn quads_that_an_exporter_cuts_in_another_way_in_a_pose_are_the_same() {
    // A strip of three quads, of which the middle one is cut from its second corner in the pose.
    let mut quads = Mesh::default();
    for y in [0.0, 1.0] {
        quads.positions.extend((0..4).map(|x| [f64::from(x), y, 0.0]));
    }
    let triangles = |height: f64, cut_from_second: bool| {
        let mut mesh = Mesh { faces: Faces::default(), ..quads.clone() };
        mesh.positions.iter_mut().for_each(|x| x[2] = height * x[0]);
        for x in 0..3 {
            let [a, b, c, d] = [x, x + 1, x + 5, x + 4];
            let halves = match x == 1 && cut_from_second {
                true => [[a, b, d], [b, c, d]],
                false => [[a, b, c], [a, c, d]],
            };
            halves.iter().for_each(|half| mesh.faces.push(half));
        }
        mesh
    };
    let folder = tempfile::tempdir().unwrap();
    for [of_neutral, of_pose] in [[false, true], [true, false]] {
        let [neutral, pose] = [triangles(0.0, of_neutral), triangles(1.0, of_pose)];
        let flat = |mesh: &Mesh| split_mesh(mesh, |face, _| face).mesh;
        for neutral in [neutral.clone(), flat(&neutral)] {
            for pose in [pose.clone(), flat(&pose)] {
                let path = written(folder.path(), "neutral.glb", &neutral);
                let found = read_like(&neutral, &path, &written(folder.path(), "pose.glb", &pose)).unwrap();
                let expected: Vec<[f64; 3]> = neutral.positions.iter().map(|x| [x[0], x[1], x[0]]).collect();
                assert_eq!(found, expected);
            }
        }
    }
}
