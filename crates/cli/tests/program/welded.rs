//! A face as glTF, which splits its vertices, gives what the whole face gives.

use crate::common::{rhytid, stderr};
use rhytid::core::{Faces, Mesh, rig_file};
use rhytid::formats::mesh;
use rhytid_test_support::split::{SplitMesh, left_or_right, split_mesh};
use rhytid_test_support::{glb, shared};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Real examples: two are split as the neutral is, and two in another way.
const POSES: [&str; 4] = ["rom3_1460", "rom3_2020", "rom3_3580", "rom3_3690"];

/// What `command` prints in a folder, on both streams.
fn done(folder: &Path, command: &str) -> String {
    let output = rhytid(command).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{command}: {}", stderr(&output));
    String::from_utf8(output.stdout.clone()).unwrap() + &stderr(&output)
}

/// The frames that a rig in a folder makes of a take, each with V positions.
fn animated(folder: &Path, rig: &str, take: &Path) -> Vec<Vec<[f32; 3]>> {
    done(folder, &format!("animate {rig} {} -o {rig}.pc2 --frames 900..1000 --device cpu:0", take.display()));
    let vertices = rig_file::read(&folder.join(rig)).unwrap().vertices();
    let bytes = std::fs::read(folder.join(format!("{rig}.pc2"))).unwrap();
    let numbers: Vec<f32> = bytes[32..].as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    numbers.chunks_exact(3 * vertices).map(|frame| frame.as_chunks().0.to_vec()).collect()
}

/// A mesh of quads as triangles, with the numbers that glTF has.
fn as_gltf(mesh: &Mesh) -> Mesh {
    let mut faces = Faces::default();
    for face in mesh.faces.iter() {
        face[1..].windows(2).for_each(|pair| faces.push(&[face[0], pair[0], pair[1]]));
    }
    let positions = mesh.positions.iter().map(|x| x.map(|x| f64::from(x as f32))).collect();
    Mesh { positions, faces, ..Mesh::default() }
}

/// Writes a mesh as OBJ, and split as GLB.
fn write(folder: &Path, name: &str, mesh: &Mesh, side: impl Fn(usize, usize) -> usize) -> Vec<u32> {
    mesh::write_obj(&folder.join(format!("{name}.obj")), mesh).unwrap();
    let SplitMesh { mesh, of_vertex } = split_mesh(mesh, side);
    std::fs::write(folder.join(format!("{name}.glb")), glb(&mesh)).unwrap();
    of_vertex
}

/// A folder with `neutral` and [`POSES`] in both formats and `markers.csv` for both. With the vertices of
/// the OBJ that those of the GLB were.
fn face(data: &Path, folder: &Path) -> Vec<u32> {
    let neutral_path = data.join("face/neutral.obj");
    let quads = mesh::read(&neutral_path).unwrap();
    let neutral = as_gltf(&quads);
    let of_vertex = write(folder, "neutral", &neutral, left_or_right(&neutral));
    for (i, name) in POSES.iter().enumerate() {
        let path: PathBuf = data.join(format!("face/poses/{name}.obj"));
        let pose = as_gltf(&mesh::read(&path).unwrap());
        let halves = left_or_right(&neutral);
        write(folder, name, &pose, |face, corner| if i < 2 { halves(face, corner) } else { face });
    }
    let markers = std::fs::read_to_string(data.join("markers.csv")).unwrap();
    let mut of_split = "label,vertex\n".to_owned();
    for line in markers.lines().skip(1) {
        let (label, vertex) = line.split_once(',').unwrap();
        let vertex: u32 = vertex.parse().unwrap();
        let last = of_vertex.iter().rposition(|of| *of == vertex).unwrap();
        writeln!(of_split, "{label},{last}").unwrap();
    }
    std::fs::write(folder.join("obj.csv"), markers).unwrap();
    std::fs::write(folder.join("glb.csv"), of_split).unwrap();
    of_vertex
}

fn project(method: &str, extension: &str) -> String {
    let mut text = format!(
        "method = \"{method}\"\n[mesh]\nneutral = \"neutral.{extension}\"\nunits = \"cm\"\n[handles]\n\
         vertices = \"{extension}.csv\"\n"
    );
    for name in POSES {
        write!(text, "[[example]]\nname = \"{name}\"\nmesh = \"{name}.{extension}\"\n").unwrap();
    }
    text
}

#[test]
fn every_frame_is_that_of_the_whole_face_and_seams_stay_closed_to_the_bit() {
    let Some(data) = shared("data") else { return };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let of_vertex = face(&data, folder);
    let take = data.join("takes/rom_3_clean.csv");
    for method in ["learned", "chapter"] {
        let frames = ["obj", "glb"].map(|extension| {
            let (toml, rig) = (format!("{extension}.toml"), format!("{extension}.safetensors"));
            std::fs::write(folder.join(&toml), project(method, extension)).unwrap();
            let said = done(folder, &format!("solve {toml} -o {rig}"));
            let joins = format!("{} vertices are {} points", of_vertex.len(), 9409);
            assert_eq!(said.replace(',', "").contains(&joins), extension == "glb", "{said}");
            animated(folder, &rig, &take)
        });
        let [whole, split] = &frames;
        assert_eq!((whole.len(), split.len()), (100, 100));
        let mut moved = 0.0_f32;
        for (i, (whole, split)) in whole.iter().zip(split).enumerate() {
            let mut first: Vec<Option<[f32; 3]>> = vec![None; whole.len()];
            for (x, &of) in split.iter().zip(&of_vertex) {
                let of = of as usize;
                let first = first[of].get_or_insert(*x);
                assert_eq!(first.map(f32::to_bits), x.map(f32::to_bits), "frame {i}, vertex {of}");
                let largest =
                    |a: &[f32; 3], b: &[f32; 3]| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
                // A tenth of a micrometre: the order of the vertices changes the last bits.
                let apart = largest(x, &whole[of]);
                assert!(apart < 1e-5, "{method}, frame {i}, vertex {of}: {apart} cm");
                moved = moved.max(largest(&whole[of], &frames[0][0][of]));
            }
        }
        assert!(moved > 0.1, "{moved}");
    }
}

#[test]
fn what_is_joined_is_said_and_can_be_asked_for() {
    let Some(data) = shared("data") else { return };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let of_vertex = face(&data, folder);
    let with = |extension: &str, weld: &str| {
        let text = project("learned", extension).replace("[mesh]\n", &format!("[mesh]\n{weld}"));
        std::fs::write(folder.join("face.toml"), text).unwrap();
        let info: serde_json::Value = serde_json::from_str(&done(folder, "info face.toml --json")).unwrap();
        (info["weld"].as_bool().unwrap(), info["points"].as_u64().unwrap(), done(folder, "doctor face.toml"))
    };
    let vertices = of_vertex.len() as u64;
    let cut = "boundary vertices lie exactly on another one";
    let (weld, points, said) = with("glb", "");
    assert!(weld && points == 9409 && !said.contains(cut), "{points} {said}");
    let (weld, points, said) = with("glb", "weld = false\n");
    assert!(!weld && points == vertices && said.contains(cut) && said.contains("weld = true"), "{said}");
    let (weld, points, _) = with("obj", "");
    assert!(!weld && points == 9409);
    // A whole mesh stays as it is.
    let (weld, points, said) = with("obj", "weld = true\n");
    assert!(weld && points == 9409 && !said.contains("points of the surface"), "{said}");
}
