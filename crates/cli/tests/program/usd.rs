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
