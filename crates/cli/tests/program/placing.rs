//! `rhytid handles` and `rhytid new`: on the demo's face, whose handles are known, and on a head that nobody prepared.

use crate::common::raw::Raw;
use crate::common::{demo, rhytid, stderr};
use rhytid::formats::{mesh, tables};
use std::path::Path;

/// The demo's project, its table of handles not there yet.
fn project(folder: &Path) {
    let text = std::fs::read_to_string(demo().join("face.toml")).unwrap();
    let text = text.replace("= \"neutral", &format!("= \"{}/neutral", demo().display()));
    let text = text.replace("= \"examples/", &format!("= \"{}/examples/", demo().display()));
    let text = text.replace("= \"poses/", &format!("= \"{}/poses/", demo().display()));
    std::fs::write(folder.join("face.toml"), text).unwrap();
}

#[test]
fn a_raw_take_finds_its_vertices() {
    let raw = Raw::new();
    raw.write(&|_, _, x| Some(x));
    let folder = raw.folder.path();
    project(folder);
    let [face, take] = ["face.toml", "raw.trc"].map(|name| raw.path(name).display().to_string());
    let output = rhytid(&format!("handles {face} {take} --frame 0")).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("cap0, cap1, cap2, cap3: off the skin") && said.contains("markers.png"), "{said}");
    let picture = std::fs::read(raw.path("markers.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG") && picture.len() > 50_000);
    let written = std::fs::read_to_string(raw.path("markers.csv")).unwrap();
    assert!(written.starts_with("label,vertex,distance_mm\n"), "{written}");
    let found = tables::read_handles(&raw.path("markers.csv")).unwrap();
    let known = tables::read_handles(&demo().join("markers.csv")).unwrap();
    assert_eq!(found.labels, known.labels);
    let rest = mesh::read(&demo().join("neutral.obj")).unwrap().positions;
    let mut off: Vec<f64> = found
        .vertices
        .iter()
        .zip(&known.vertices)
        .map(|(a, b)| {
            let [a, b] = [a, b].map(|v| rest[*v as usize]);
            10.0 * (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
        })
        .collect();
    off.sort_by(f64::total_cmp);
    assert!(off[off.len() / 2] < 3.0 && off[off.len() * 9 / 10] < 6.0, "{off:?}");

    // A table that is there is not touched, and mistakes are named.
    let refused = |command: &str, expected: &str| {
        let output = rhytid(&format!("handles {command}")).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{command}");
        assert!(stderr(&output).contains(expected), "{command}: {}", stderr(&output));
    };
    refused(&format!("{face} {take}"), "markers.csv: is there already; name another table with -o");
    let other = raw.path("other.csv").display().to_string();
    refused(&format!("{face} {take} -o {other} --at nobody=3"), "no marker of the take is called “nobody”");
    refused(&format!("{face} {take} -o {other} --frame 100000"), "the frame 100000 is not in the take");
    refused(&format!("{face} {take} -o {other} --at x=y"), "expected LABEL=VERTEX");
    assert!(!raw.path("other.csv").exists() && !raw.path("other.png").exists());
}

#[test]
fn handles_are_spread_evenly_on_both_sides() {
    let raw = Raw::new();
    project(raw.folder.path());
    let [face, table] = ["face.toml", "spread.csv"].map(|name| raw.path(name).display().to_string());
    let output = rhytid(&format!("handles {face} --count 40 -o {table} --at tip=7")).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let handles = tables::read_handles(Path::new(&table)).unwrap();
    assert!((40..=41).contains(&handles.labels.len()), "{}", handles.labels.len());
    assert_eq!((handles.labels[0].as_str(), handles.vertices[0]), ("tip", 7));
    let sides = |side: &str| handles.labels.iter().filter(|label| label.ends_with(side)).count();
    assert_eq!(sides("_l"), sides("_r"), "as many left as right: {:?}", handles.labels);
    // Evenly: none is nearer to another than a third of what most are, but for two that the mouth is between.
    let rest = mesh::read(&demo().join("neutral.obj")).unwrap().positions;
    let at = |h: usize| rest[handles.vertices[h] as usize];
    let apart = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
    let count = handles.labels.len();
    let mut nearest: Vec<f64> = (0..count)
        .map(|a| (0..count).filter(|b| *b != a).map(|b| apart(at(a), at(b))).fold(f64::INFINITY, f64::min))
        .collect();
    nearest.sort_by(f64::total_cmp);
    assert!(nearest[2] > nearest[count / 2] / 3.0, "{nearest:?}");
}

/// Runs the command, which must succeed, and gives its standard output.
fn done(command: &str) -> String {
    let output = rhytid(command).output().unwrap();
    assert!(output.status.success(), "{command}: {}", stderr(&output));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn a_folder_of_scans_becomes_a_project_that_animates() {
    let raw = Raw::new();
    raw.write(&|_, _, x| Some(x));
    let scans = raw.path("scans");
    std::fs::create_dir_all(scans.join("poses")).unwrap();
    std::fs::copy(demo().join("neutral.obj"), scans.join("neutral.obj")).unwrap();
    for pose in std::fs::read_dir(demo().join("poses")).unwrap().flatten() {
        std::fs::copy(pose.path(), scans.join("poses").join(pose.file_name())).unwrap();
    }
    std::fs::write(scans.join("poses/other.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    std::fs::copy(raw.path("raw.trc"), scans.join("session.trc")).unwrap();
    let [neutral, anna] =
        [scans.join("neutral.obj"), raw.path("anna")].map(|path| path.display().to_string());
    let said = done(&format!("new {neutral} -o {anna}"));
    assert!(said.contains("cm, Y up") && said.contains("other.obj: not the neutral's vertices"), "{said}");
    // Its last lines are the commands that follow, and they work.
    let next: Vec<&str> = said.lines().filter_map(|line| line.trim().strip_prefix("rhytid ")).collect();
    assert!(next.len() == 2 && next[0].starts_with("solve ") && next[1].starts_with("animate "), "{said}");
    let text = std::fs::read_to_string(format!("{anna}/face.toml")).unwrap();
    assert!(
        text.contains("neutral = '../scans/neutral.obj'") && text.matches("[[example]]").count() >= 4,
        "{text}"
    );
    done(next[0]);
    done(&format!("{} --device cpu --frames 0..20", next[1]));
    assert!(Path::new(&anna).join("face.usd").is_file() && Path::new(&anna).join("markers.png").is_file());
    let output = rhytid(&format!("new {neutral} -o {anna}")).output().unwrap();
    assert!(
        output.status.code() == Some(2) && stderr(&output).contains("is there already"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn another_actors_capture_animates_a_head_that_nobody_prepared() {
    let Some(shared) = rhytid_test_support::shared("data") else { return };
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let neutral = shared.join("makehuman/neutral.obj").display().to_string();
    let take = shared.join("takes/rom_3_raw.c3d").display().to_string();
    let said = done(&format!("new {neutral} --take {take} -o {}", at("face")));
    assert!(said.contains("0.1, Y up: the neutral is 52 cm across") && said.contains("88, from"), "{said}");
    let [project, rig, usd] = ["face/face.toml", "face/face.safetensors", "face/face.usd"].map(at);
    done(&format!("solve {project} -o {rig}"));
    done(&format!("animate {rig} {take} -o {usd} --device cpu"));
    // No spike: no vertex goes farther than the farthest marker by half, and none jumps between two frames at 120 Hz.
    let rest = mesh::read(Path::new(&neutral)).unwrap().positions;
    let mut reader = rhytid::formats::animation::open(Path::new(&usd)).unwrap();
    let handles = tables::read_handles(&folder.path().join("face/markers.csv")).unwrap().vertices;
    let apart = |a: [f32; 3], b: [f32; 3]| 100.0 * (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt();
    let (mut now, mut before): (Vec<f32>, Vec<f32>) = (Vec::new(), Vec::new());
    let (mut farthest, mut marker, mut jump) = (0.0_f32, 0.0_f32, 0.0_f32);
    for frame in 0..reader.summary().frames {
        reader.positions(frame, &mut now).unwrap();
        let points = now.as_chunks::<3>().0;
        for (v, x) in points.iter().enumerate() {
            farthest = farthest.max(apart(*x, rest[v].map(|c| c as f32)));
        }
        for &v in &handles {
            marker = marker.max(apart(points[v as usize], rest[v as usize].map(|c| c as f32)));
        }
        for (x, y) in points.iter().zip(before.as_chunks::<3>().0) {
            jump = jump.max(apart(*x, *y));
        }
        std::mem::swap(&mut now, &mut before);
    }
    println!(
        "a head that nobody prepared: farthest {farthest:.1} mm, its markers {marker:.1}; jumps by {jump:.1} mm"
    );
    assert!(farthest < 1.5 * marker && jump < 8.0, "{farthest}, {marker}, {jump}");
}
