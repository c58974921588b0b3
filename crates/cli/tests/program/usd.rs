//! The bits that USD reads from an animated file are those of the backend's output.

use crate::common::{Fixture, demo};
use rhytid::core::{Backend, rig_file};
use rhytid::devices::cpu::Cpu;
use rhytid::formats::take;
use rhytid::{Animator, Stage, UploadOptions};
use rhytid_test_support::python;
use std::process::Command;

#[test]
fn usd_reads_the_backends_bits() {
    let f = Fixture::new();
    let [rig_path, take_path] = ["face.safetensors", "performance.csv"].map(|name| demo().join(name));
    let rig = rig_file::read(&rig_path).unwrap();
    let take = take::read(&take_path, Some(&rig.handles().labels), take::Missing::Error).unwrap();
    let handles = take.handle_positions(&rig.handles().labels).unwrap();
    let cpu = Cpu::open(&Cpu::devices().unwrap()[0]).unwrap();
    // The shell alone is the large scale of the rig before anything was learned.
    let mut animators = [&rig, &rig.clone().shell().unwrap()]
        .map(|rig| Animator::new(&cpu, rig, UploadOptions::frames(take.frames())).unwrap());
    animators.iter_mut().for_each(|animator| animator.evaluate(&handles).unwrap());
    let mut told = Vec::new();

    for (args, of, stages) in [
        ("", 0, [Stage::Positions, Stage::Normals]),
        (" --stage large-scale", 0, [Stage::LargeScale, Stage::LargeScaleNormals]),
        (" --stage shell", 1, [Stage::LargeScale, Stage::LargeScaleNormals]),
    ] {
        // Other devices agree only within rounding.
        let [of_rig, of_take] = [&rig_path, &take_path].map(|path| path.display());
        f.done(&format!("animate {of_rig} {of_take} -o face.usda --device cpu:0{args}"));
        let mut expected = Vec::new();
        for stage in stages {
            let mut values = Vec::new();
            animators[of].read(stage, &mut values).unwrap();
            expected.extend(values.iter().flat_map(|x| x.to_le_bytes()));
        }
        let dump = f.path("dump.bin");
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/program/dump_usd.py");
        let output = Command::new(python()).arg(script).arg(f.path("face.usda")).arg(&dump).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let codes: Vec<f64> =
            String::from_utf8_lossy(&output.stdout).split_whitespace().map(|c| c.parse().unwrap()).collect();
        assert_eq!(codes, (0..take.frames()).map(|i| i as f64).collect::<Vec<_>>());
        assert!(f.read("dump.bin") == expected, "USD reads other bits than the backend gave{args}");
        told.push(expected);
    }
    assert!(told[0] != told[1] && told[1] != told[2], "stages are not told apart");
}

/// A layer over an asset, in metres and below other prims, is what `verify` expects; and each flag has its
/// formats.
#[test]
fn the_face_is_where_the_pipeline_wants_it() {
    let f = Fixture::new();
    let [rig, take] = ["face.safetensors", "performance.csv"].map(|name| demo().join(name));
    let (rig, take) = (rig.display(), take.display());
    let animate = format!("animate {rig} {take} --device cpu:0 --frames 3..9 -o");
    for (file, options) in [
        ("placed.usd", "--prim-path /char/anna/face --mesh-name geo --subdivision catmullClark"),
        ("over.usda", "--prim-path /char/anna/face --over --start-frame 1001"),
        ("metres.usd", "--metres"),
        ("metres.usda", "--metres --shapes 3"),
    ] {
        f.done(&format!("{animate} {file} {options}"));
        f.done(&format!("verify {file} --rig {rig} --take {take}"));
    }
    let text = f.read_text("over.usda");
    assert!(text.contains("over \"face_mesh\"") && !text.contains("faceVertexIndices"));
    // What was changed is still found.
    f.replace("over.usda", "startTimeCode = 1004", "startTimeCode = 1003");
    let output = f.rhytid(&format!("verify over.usda --rig {rig} --take {take}")).output().unwrap();
    assert!(!output.status.success());

    let animate = format!("animate {rig} {take} -o out/face");
    for (options, words) in [
        (".glb --over", &["--over is for USD (.usd, .usdc, .usda or .usdz)"][..]),
        (".gltf --prim-path /face", &["--prim-path is for USD"]),
        (".pc2 --metres", &["--metres is for USD"]),
        (
            ".usd --prim-path /char/2nd",
            &["the prim path is “/char/2nd”, expected a path such as /char/anna/face"],
        ),
        (".usd --mesh-name a/b", &["the mesh is to be called “a/b”"]),
        (".usd --over --shapes 3", &["has samples alone", "--shapes"]),
        (".usd --over --textures none", &["--over", "--textures"]),
    ] {
        f.refused(&format!("{animate}{options}"), words);
    }
    f.refused(&format!("export-shapes {rig} -o out/s.glb --metres"), &["--metres is for USD"]);
    f.done(&format!("export-shapes {rig} -o shapes.usda --prim-path /char/face --metres"));
    assert!(f.read_text("shapes.usda").contains("</char/face/skeleton>"));
}
