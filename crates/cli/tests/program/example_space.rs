//! Examples in another space than the neutral, in files of other people.

use crate::common::{rhytid, stderr};
use rhytid_test_support::shared;
use std::path::Path;

fn copied(files: &[&Path], folder: &Path) {
    for file in files {
        std::fs::copy(file, folder.join(file.file_name().unwrap())).unwrap();
    }
}

/// What `solve` says of a project, and the rig if there is one.
fn solved(folder: &Path, project: &str) -> (Option<Vec<u8>>, String) {
    std::fs::write(folder.join("face.toml"), project).unwrap();
    let output = rhytid("solve face.toml -o face.safetensors").current_dir(folder).output().unwrap();
    assert_eq!(
        output.status.code(),
        Some(if output.status.success() { 0 } else { 2 }),
        "{}",
        stderr(&output)
    );
    let rig = output.status.success().then(|| std::fs::read(folder.join("face.safetensors")).unwrap());
    (rig, stderr(&output))
}

/// The positions of a take's frames, as the rig in a folder animates them.
fn animated(folder: &Path, take: &Path) -> Vec<f32> {
    let command =
        format!("animate face.safetensors {} -o out.pc2 --frames 0..300 --device cpu:0", take.display());
    let output = rhytid(&command).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let bytes = std::fs::read(folder.join("out.pc2")).unwrap();
    bytes[32..].as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

fn largest_difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

const MESH: &str =
    "[mesh]\nneutral = \"neutral.obj\"\nunits = \"cm\"\n[handles]\nvertices = \"markers.csv\"\n";

#[test]
fn gltf_is_in_metres_beside_a_neutral_in_centimetres() {
    let (Some(files), Some(data)) = (shared("data/other-people/meshes/example_in_metres"), shared("data"))
    else {
        return;
    };
    let names = ["rom3_1460", "rom3_2020"];
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    copied(&[&files.join("neutral.obj"), &files.join("markers.csv")], folder);
    for name in names {
        copied(&[&files.join(format!("{name}.glb")), &data.join(format!("face/poses/{name}.obj"))], folder);
    }
    let project = |extension: &str, keys: &str| {
        let example = |name| format!("[[example]]\nname = \"{name}\"\nmesh = \"{name}.{extension}\"\n{keys}");
        format!("{MESH}{}", names.map(example).concat())
    };
    let take = data.join("takes/rom_3_clean.csv");
    let (rig, said) = solved(folder, &project("obj", ""));
    assert!(rig.is_some(), "{said}");
    let expected = animated(folder, &take);
    for keys in ["", "unit = \"m\"\n", "unit = \"cm\"\nscale = 100\n"] {
        let (rig, said) = solved(folder, &project("glb", keys));
        assert!(rig.is_some() && !said.contains("example "), "{said}");
        let apart = largest_difference(&animated(folder, &take), &expected);
        assert!(apart < 1e-3, "{keys}: {apart}");
    }
    let (rig, said) = solved(folder, &project("glb", "unit = \"cm\"\n"));
    let words = ["rom3_1460 is 100 times smaller than the neutral, as if it were in metres", "unit = \"m\""];
    assert!(rig.is_none() && words.iter().all(|word| said.contains(word)), "{said}");
}

#[test]
fn a_negated_axis_is_named_and_taken_back() {
    let Some(files) = shared("data/other-people/meshes/example_x_negated") else { return };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for file in ["neutral.obj", "markers.csv", "ex.obj", "ok.obj"] {
        copied(&[&files.join(file)], folder);
    }
    let project = |keys: &str| {
        format!(
            "{MESH}[[example]]\nname = \"ex\"\nmesh = \"ex.obj\"\n{keys}[[example]]\nname = \"ok\"\nmesh = \"ok.obj\"\n"
        )
    };
    let (rig, said) = solved(folder, &project(""));
    let words = ["example ex is a mirror image of the neutral", "axes = \"-x+y+z\" at its [[example]]"];
    assert!(rig.is_none() && words.iter().all(|word| said.contains(word)), "{said}");
    let (rig, said) = solved(folder, &project("axes = \"-x+y+z\"\n"));
    assert!(rig.is_some() && !said.contains("error"), "{said}");
    let (rig, said) = solved(folder, &project("axes = \"x y z\"\n"));
    assert!(
        rig.is_none() && said.contains("[[example]] axes is \"x y z\", expected the mesh's axes"),
        "{said}"
    );
}
