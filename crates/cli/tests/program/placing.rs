//! `rhytid handles`: on the demo's face, whose handles are known.

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
