//! Takes in the wrong space. Each is noticed, the sentence names the option, and with this option the
//! animation is right.

use crate::common::raw::{rig, truth};
use crate::common::{rhytid, stderr};
use rhytid::Take;
use rhytid::formats::take;
use std::path::Path;
use tempfile::TempDir;

/// The demo's performance with each position changed.
fn changed(change: impl Fn(usize, [f64; 3]) -> [f64; 3]) -> Take {
    let mut take = truth();
    let markers = take.labels.len();
    for (i, x) in take.positions.iter_mut().enumerate() {
        *x = change(i / markers, *x);
    }
    take
}

fn write(folder: &Path, name: &str, take: &Take) -> String {
    let path = folder.join(name);
    take::write(&path, take).unwrap();
    path.display().to_string()
}

#[test]
fn a_take_in_another_space_is_refused_with_the_option_that_reads_it() {
    let folder = TempDir::new().unwrap();
    let right = write(folder.path(), "right.csv", &truth());
    let (rig, usd) = (rig().display().to_string(), folder.path().join("out.usd").display().to_string());
    let animate = |take: &str, options: &str| {
        rhytid(&format!("animate {rig} {take} -o {usd} --device cpu:0 --frames 0..60 {options}"))
            .output()
            .unwrap()
    };
    type Change = fn([f64; 3]) -> [f64; 3];
    let cases: [(&str, Change, &str); 5] = [
        ("millimetres", |x| x.map(|c| 10.0 * c), "--take-unit mm"),
        ("inches", |x| x.map(|c| c / 2.54), "--take-unit in"),
        ("z-up", |[x, y, z]| [x, -z, y], "--take-axes +x+z-y"),
        ("mirrored", |[x, y, z]| [-x, y, z], "--take-axes -x+y+z"),
        ("both", |[x, y, z]| [-10.0 * z, 10.0 * y, 10.0 * x], "--take-unit mm --take-axes +z+y-x"),
    ];
    for (name, change, option) in cases {
        let wrong = write(folder.path(), &format!("{name}.csv"), &changed(|_, x| change(x)));
        let output = animate(&wrong, "");
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{name}: {said}");
        assert!(
            said.contains("no frame is near the rest pose")
                && said.contains("see --take-unit UNIT, --take-axes AXES"),
            "{name}: {said}"
        );
        // The sentence has the values of the options.
        for value in option.split(' ').filter(|word| !word.starts_with("--")) {
            assert!(said.contains(&format!(" {value} ")), "{name}: {value}: {said}");
        }
        assert!(!Path::new(&usd).exists(), "{name}: half a file");
        let output = animate(&wrong, option);
        assert!(
            output.status.success() && !stderr(&output).contains("warning"),
            "{name}: {}",
            stderr(&output)
        );
        // The file states how its take was read, and the result equals that of the right take.
        for (take, options) in [(&wrong, ""), (&right, "--take-unit cm --take-axes +x+y+z")] {
            let verify = format!("verify {usd} --rig {rig} --take {take} --device cpu:0 {options}");
            let output = rhytid(&verify).output().unwrap();
            assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stdout));
        }
        std::fs::remove_file(&usd).unwrap();
    }
    // The option is obeyed, with a warning where it cannot be right.
    let output = animate(&right, "--take-unit mm");
    let said = stderr(&output);
    assert!(
        output.status.success()
            && said.contains("warning")
            && said.contains("no frame is near the rest pose"),
        "{said}"
    );
}

#[test]
fn a_turning_head_and_times_that_are_no_seconds_are_warned_of() {
    let folder = TempDir::new().unwrap();
    let (rig, usd) = (rig().display().to_string(), folder.path().join("out.usd").display().to_string());
    let animate = |take: &str, options: &str| {
        let output =
            rhytid(&format!("animate {rig} {take} -o {usd} --device cpu:0 {options}")).output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        (stderr(&output), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let turned = changed(|frame, [x, y, z]| {
        let (sin, cos) = (20.0_f64.to_radians() * (frame as f64 / 25.0).sin()).sin_cos();
        [cos * x + sin * z, y, cos * z - sin * x]
    });
    let turned = write(folder.path(), "turned.csv", &turned);
    let (said, _) = animate(&turned, "--frames 0..30");
    assert!(
        said.contains("the markers turn together by up to") && said.contains("--world -o clean.csv"),
        "{said}"
    );
    let clean = folder.path().join("clean.csv").display().to_string();
    let output = rhytid(&format!("prepare {turned} --rig {rig} --world -o {clean}")).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let found = take::read(Path::new(&clean), None, take::Missing::Error).unwrap();
    let right = truth();
    let apart = found
        .positions
        .iter()
        .zip(&right.positions)
        .map(|(a, b)| 10.0 * (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt());
    let squares: f64 = apart.map(|d| d * d).sum::<f64>() / right.positions.len() as f64;
    // Without rigid markers a head's motion is the motion of most of the face. The jaw's share of it is
    // unknown.
    assert!(squares.sqrt() < 1.5, "{} mm", squares.sqrt());

    for (name, factor, what) in
        [("frames", 30.0, "numbers of frames"), ("milliseconds", 1000.0, "milliseconds")]
    {
        let mut take = truth();
        take.times.iter_mut().for_each(|time| *time = (*time * factor).round());
        let path = write(folder.path(), &format!("{name}.csv"), &take);
        let (said, _) = animate(&path, "--frames 0..4");
        assert!(said.contains(&format!("its times look like {what}, expected seconds")), "{name}: {said}");
        let (said, done) = animate(&path, "--frames 0..4 --take-rate 30");
        assert!(!said.contains("warning") && done.contains("at 30 frames per second"), "{said} {done}");
    }
}

#[test]
fn a_slid_label_and_missing_handles_are_warned_of() {
    let folder = TempDir::new().unwrap();
    let (rig, usd) = (rig().display().to_string(), folder.path().join("out.usd").display().to_string());
    let animate = |take: &str| {
        let output = rhytid(&format!("animate {rig} {take} -o {usd} --device cpu:0 --frames 30..60"))
            .output()
            .unwrap();
        (output.status.code(), stderr(&output))
    };
    let right = truth();
    let markers = right.labels.len();
    let column = |label: &str| right.labels.iter().position(|known| known == label).unwrap();
    // The label of a mouth corner slides to a marker of the forehead for a third of a second.
    let mut slid = truth();
    let (from, to) = (column("mouth_corner_L"), column("forehead_L2"));
    for frame in 40..50 {
        slid.positions[frame * markers + from] = slid.positions[frame * markers + to];
    }
    let (code, said) = animate(&write(folder.path(), "slid.csv", &slid));
    let sentence = said.lines().find(|line| line.contains("the skin is stretched by")).unwrap_or_default();
    assert!(
        code == Some(0) && sentence.contains("mouth_corner_L") && sentence.contains("10 frames are like it"),
        "{said}"
    );
    assert!((40..50).any(|frame| sentence.contains(&format!("in frame {frame} "))), "{said}");

    // Two markers are missing entirely.
    let gone = [column("lip_up"), column("brow_L2")];
    let keep: Vec<usize> = (0..markers).filter(|m| !gone.contains(m)).collect();
    let fewer = Take {
        labels: keep.iter().map(|&m| right.labels[m].clone()).collect(),
        positions: right.positions.chunks(markers).flat_map(|frame| keep.iter().map(|&m| frame[m])).collect(),
        ..truth()
    };
    let (code, said) = animate(&write(folder.path(), "fewer.csv", &fewer));
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("their markers are never seen: lip_up, brow_L2"), "{said}");
    let (code, said) = animate(&write(folder.path(), "right.csv", &right));
    assert!(code == Some(0) && !said.contains("stretched") && !said.contains("never seen"), "{said}");
}
