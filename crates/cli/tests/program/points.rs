//! Handles inside triangles, from the table of handles to a file: every marker is met there.

use crate::common::{demo, rhytid, stderr};
use rhytid::core::{Handles, Take};
use rhytid::formats::{animation, mesh, tables, take};
use rhytid_test_support::points::beside;
use serde_json::Value;
use std::path::Path;

fn done(command: &str, folder: &Path) -> String {
    let output = rhytid(command).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{command}: {}", stderr(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// The demo's project with its markers beside their vertices, and a take of its poses.
fn project(folder: &Path) -> Handles {
    let neutral = mesh::read(&demo().join("neutral.obj")).unwrap();
    let known = tables::read_handles(&demo().join("markers.csv")).unwrap();
    let points = beside(&neutral, &known.points, [0.45, 0.35, 0.2]).into_iter().zip(known.points).enumerate();
    // Every fifth marker stays at its vertex.
    let points = points.map(|(h, (beside, vertex))| if h % 5 == 0 { vertex } else { beside });
    let handles = Handles { labels: known.labels, points: points.collect() };
    let mut frames = Take { labels: handles.labels.clone(), ..Take::default() };
    for (frame, pose) in ["smile", "jaw_open", "brow_raise"].iter().enumerate() {
        let positions = mesh::read(&demo().join(format!("poses/{pose}.obj"))).unwrap().positions;
        frames.times.push(frame as f64 / 30.0);
        frames.positions.extend(handles.at(&positions));
    }
    take::write(&folder.join("take.csv"), &frames).unwrap();
    tables::write_handles(&folder.join("points.csv"), &handles, None).unwrap();
    let text = std::fs::read_to_string(demo().join("face.toml")).unwrap();
    std::fs::write(folder.join("face.toml"), text.replace("markers.csv", "points.csv")).unwrap();
    for part in ["neutral.obj", "poses"] {
        std::os::unix::fs::symlink(demo().join(part), folder.join(part)).unwrap();
    }
    handles
}

#[test]
fn markers_inside_triangles_are_met_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let handles = project(folder);
    let inside = handles.points.iter().filter(|point| point.vertex().is_none()).count();
    let told: Value = serde_json::from_str(&done("info points.csv --json", folder)).unwrap();
    assert_eq!(told["inside_triangles"], inside);
    done("solve face.toml -o face.safetensors --allow-elsewhere", folder);
    let markers = take::read(&folder.join("take.csv"), Some(&handles.labels), take::Missing::Error).unwrap();
    let markers = markers.handle_positions(&handles.labels).unwrap();
    for name in ["out.usdc", "out.glb"] {
        done(&format!("animate face.safetensors take.csv -o {name} --device cpu:0"), folder);
        done(&format!("verify {name} --rig face.safetensors --take take.csv"), folder);
        let mut reader = animation::open(&folder.join(name)).unwrap();
        let mut positions = Vec::new();
        for (frame, markers) in markers.chunks(3 * handles.len()).enumerate() {
            reader.positions(frame, &mut positions).unwrap();
            for (marker, point) in markers.chunks(3).zip(&handles.points) {
                for (x, y) in marker.iter().zip(point.at(positions.as_chunks::<3>().0)) {
                    assert!((x - y).abs() < 2e-5, "{name}, frame {frame}, {point}: {x} and {y}");
                }
            }
        }
    }
}

#[test]
fn what_is_wrong_with_a_point_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    project(folder);
    let table = std::fs::read_to_string(folder.join("points.csv")).unwrap();
    let refused = |from: &str, to: &str, words: &[&str]| {
        assert!(table.contains(from), "{from}: {table}");
        std::fs::write(folder.join("points.csv"), table.replacen(from, to, 1)).unwrap();
        let output = rhytid("solve face.toml -o x.safetensors --allow-elsewhere")
            .current_dir(folder)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2));
        words.iter().for_each(|word| assert!(stderr(&output).contains(word), "{word}: {}", stderr(&output)));
        assert!(!folder.join("x.safetensors").exists());
    };
    refused(",0.45,", ",0.55,", &["points.csv, line", "have the sum 1.1"]);
    refused(",0.45,", ",-0.45,", &["points.csv, line", "-0.45", "a number from 0 to 1"]);
    refused(",0.45,", ",,", &["points.csv, line", "expected a number from 0 to 1"]);
    refused("weight_3", "weight_4", &["points.csv, line 1", "weight_3"]);
}
