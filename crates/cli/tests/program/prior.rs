//! A prior from another face, from the project file to the summary.

use crate::common::{demo, rhytid, stderr};
use serde_json::Value;
use std::path::Path;
use std::process::Output;

fn run(command: &str, folder: &Path) -> Output {
    rhytid(command).current_dir(folder).output().unwrap()
}

fn done(command: &str, folder: &Path) -> String {
    let output = run(command, folder);
    assert!(output.status.success(), "{command}: {}", stderr(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// A project with the demo's neutral and its smile, and all of the demo's expressions as another face.
fn project(folder: &Path) -> String {
    let copy = |from: &str, to: &str| std::fs::copy(demo().join(from), folder.join(to)).unwrap();
    std::fs::create_dir(folder.join("generic")).unwrap();
    copy("neutral.obj", "neutral.obj");
    copy("neutral.obj", "generic/Neutral.obj");
    copy("markers.csv", "markers.csv");
    copy("poses/smile.obj", "smile.obj");
    for pose in std::fs::read_dir(demo().join("poses")).unwrap() {
        let name = pose.unwrap().file_name().into_string().unwrap();
        copy(&format!("poses/{name}"), &format!("generic/{name}"));
    }
    "[mesh]\nneutral = \"neutral.obj\"\nunits = \"cm\"\n[handles]\nvertices = \"markers.csv\"\n\
     [[example]]\nname = \"smile\"\nmesh = \"smile.obj\"\n[prior]\nfrom = \"generic\"\n"
        .to_owned()
}

#[test]
fn a_prior_is_taken_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text = project(folder);
    let count = std::fs::read_dir(folder.join("generic")).unwrap().count() - 1;
    std::fs::write(folder.join("face.toml"), &text).unwrap();
    let told = done("solve face.toml -o face.safetensors", folder);
    assert!(told.contains(&format!("the prior ({count} expressions) has a weight of 0.9")), "{told}");
    let told: Value =
        serde_json::from_str(&done("solve face.toml -o face.safetensors --json", folder)).unwrap();
    assert_eq!(told["prior"]["expressions"], count);
    assert!(told["prior"]["weight"].as_f64().unwrap() > 0.9, "{told}");
    assert!(told["candidates"][0]["left_out_mm"].as_f64().is_some(), "{told}");
    let said = done("info face.toml", folder);
    assert!(said.contains(&format!("generic, {count} expressions, weight auto")), "{said}");
    // The frames are those of the demo's own rig, but for what its wrinkles add.
    done("evaluate face.toml --json", folder);

    // A file with all of them as shapes does as well.
    let all: String = std::fs::read_dir(folder.join("generic"))
        .unwrap()
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .filter(|file| file != "Neutral.obj")
        .map(|file| {
            format!("[[example]]\nname = \"{}\"\nmesh = \"generic/{file}\"\n", &file[..file.len() - 4])
        })
        .collect();
    let neutral =
        "[mesh]\nneutral = \"neutral.obj\"\nunits = \"cm\"\n[handles]\nvertices = \"markers.csv\"\n";
    std::fs::write(folder.join("all.toml"), format!("{neutral}{all}")).unwrap();
    done("solve all.toml -o all.safetensors", folder);
    done("export-shapes all.safetensors -o all.glb", folder);
    std::fs::write(folder.join("face.toml"), text.replace("\"generic\"", "\"all.glb\"")).unwrap();
    let of_file: Value =
        serde_json::from_str(&done("solve face.toml -o face.safetensors --json", folder)).unwrap();
    assert_eq!(of_file["prior"]["expressions"], count);
    let [a, b] = [&told, &of_file].map(|told| told["prior"]["weight"].as_f64().unwrap());
    assert!((a - b).abs() < 1e-3, "{a} {b}");

    // Its rig does as well, and a rig is no project's only content.
    let rig = std::fs::read(folder.join("face.safetensors")).unwrap();
    std::fs::write(folder.join("other.safetensors"), rig).unwrap();
    std::fs::write(folder.join("face.toml"), text.replace("\"generic\"", "\"other.safetensors\"")).unwrap();
    let told = done("solve face.toml -o new.safetensors", folder);
    assert!(told.contains("the prior (1 expression) "), "{told}");
    assert!(done("info face.toml", folder).contains("other.safetensors, a rig, weight auto"));
    assert!(done("doctor face.toml", folder).contains("can be solved"));
}

#[test]
fn a_prior_that_cannot_be_used_is_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text = project(folder);
    let refused = |text: &str, words: &[&str]| {
        std::fs::write(folder.join("face.toml"), text).unwrap();
        let output = run("solve face.toml -o face.safetensors", folder);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        words.iter().for_each(|word| assert!(said.contains(word), "{word}: {said}"));
        assert!(!folder.join("face.safetensors").exists());
    };
    refused(&format!("method = \"chapter\"\n{text}"), &["the chapter's method learns nothing from a prior"]);
    refused(&format!("{text}[large_scale]\nrotations = true\n"), &["rotations do not go with a prior"]);
    refused(
        &format!("{text}weight = 2\n"),
        &["[prior] weight is 2, expected \"auto\" or a number from 0 to 1"],
    );
    refused(&text.replace("\"generic\"", "\"../elsewhere\""), &["../elsewhere", "not in"]);
    std::fs::write(folder.join("generic/cube.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    refused(&text, &["cube.obj: has 3 vertices, but"]);
    let triangle = "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[]}]}";
    std::fs::write(folder.join("none.gltf"), triangle).unwrap();
    refused(&text.replace("\"generic\"", "\"none.gltf\""), &["none.gltf", "has 0 vertices but no faces"]);
    refused(&text.replace("\"generic\"", "\"all.glb\""), &["all.glb, which does not exist"]);

    // Without an example, nothing says whether the prior fits.
    std::fs::remove_file(folder.join("generic/cube.obj")).unwrap();
    let alone = text.replace("[[example]]\nname = \"smile\"\nmesh = \"smile.obj\"\n", "");
    std::fs::write(folder.join("face.toml"), alone).unwrap();
    let output = run("solve face.toml -o face.safetensors", folder);
    let said = stderr(&output);
    assert!(output.status.success() && said.contains("there is a prior and no example"), "{said}");
}
