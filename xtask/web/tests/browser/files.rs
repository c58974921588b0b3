//! Files that the viewer's page opens: it reads them as the program does.

use super::viewer::{POSITIONS, STATUS, distance, evaluate, handles, opened, shown, until};
use super::*;
use rhytid_backend_cpu::Cpu;
use rhytid_core::{Animator, Backend, Mesh, NoProgress, Stage, UploadOptions};
use rhytid_formats::export::{Frame, Scene, StatedRecipe};
use rhytid_formats::{animation, mesh};
use rhytid_playback::{CleanUp, read_take};
use rhytid_test_support::shared;

/// Chooses files in the page.
pub(crate) fn choose(paths: &[&Path]) -> Value {
    json!({ "method": "DOM.setFileInputFiles", "params": { "files": paths }, "node": "#files" })
}

/// The demo's take as a capture system writes it: in millimetres, at 30 frames per second, with gaps.
fn trc() -> String {
    let (rig, take) = demo();
    let millimetres = 1e3 * rig.surface().metres_per_unit;
    let labels: String = take.labels.iter().map(|label| format!("\t{label}\t\t")).collect();
    let mut rows = String::new();
    for (frame, places) in take.positions.chunks_exact(take.labels.len()).enumerate() {
        rows += &format!("{}\t{:.5}", frame + 1, take.times[frame]);
        for (marker, place) in places.iter().enumerate() {
            let is_gap = (60..75).contains(&frame) && marker % 9 == 4;
            rows += &match is_gap {
                true => "\t\t\t".to_owned(),
                false => place.map(|x| format!("\t{:.4}", x * millimetres)).concat(),
            };
        }
        rows += "\n";
    }
    format!(
        "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n30\t{}\t{}\tmm\n\
         Frame#\tTime{labels}\n{rows}",
        take.times.len(),
        take.labels.len()
    )
}

/// Weights of the rig's first two examples, of which each rises once.
fn curves() -> String {
    let names = &demo().0.examples().names;
    let mut rows = format!("time,{},{}\n", names[0], names[1]);
    for frame in 0..=20 {
        let part = f64::from(frame) / 20.0;
        rows += &format!("{:.3},{part:.3},{:.3}\n", f64::from(frame) / 30.0, 1.0 - part);
    }
    rows
}

#[test]
fn takes_of_every_kind_are_read_and_cleaned_as_the_program_does() {
    let (rig, _) = demo();
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("raw.trc"), trc()).unwrap();
    std::fs::write(at("curves.csv"), curves()).unwrap();
    let mut files = vec![at("raw.trc"), at("curves.csv")];
    if let Some(file) = shared("data/takes/rom_3_raw.c3d") {
        // Chromium reads no file whose path leads upwards.
        std::fs::copy(file, at("raw.c3d")).unwrap();
        files.push(at("raw.c3d"));
    }
    let mut steps = Vec::new();
    let mut expected = Vec::new();
    for (i, file) in files.iter().enumerate() {
        let take = read_take(file, rig, Missing::Hold, &CleanUp::default(), &NoProgress).unwrap().take;
        steps.extend([
            evaluate(&format!("began {i}"), "performance.now()"),
            choose(&[file]),
            until(&format!("{STATUS}.playing && {STATUS}.frames === {}", take.times.len())),
            evaluate(&format!("ended {i}"), "performance.now()"),
            // The demo's take begins at rest.
            evaluate("_", &format!("rhytid.viewer.seek({})", take.times.len() / 2)),
            shown(),
            evaluate(&i.to_string(), STATUS),
        ]);
        expected.push(take);
    }
    let found = opened("", &steps, json!({}));
    for (i, take) in expected.iter().enumerate() {
        let status = &found[i.to_string()];
        assert_eq!(status["note"], Value::Null, "{:?}", files[i]);
        let frame = status["frame"].as_u64().unwrap() as usize;
        assert_eq!(frame, take.times.len() / 2);
        let count = rig.handles().len();
        let all = take.handle_positions(&rig.handles().labels).unwrap();
        let places = all[3 * count * frame..3 * count * (frame + 1)].as_chunks::<3>().0;
        let off = handles(status).iter().zip(places).map(|(a, b)| distance(*a, *b)).fold(0.0, f32::max);
        let moved = places.iter().zip(&rig.handles().rest).map(|(a, b)| distance(*a, *b)).fold(0.0, f32::max);
        let [began, ended] = ["began", "ended"].map(|when| found[format!("{when} {i}")].as_f64().unwrap());
        let seconds = (ended - began) / 1e3;
        println!("{:?}: {seconds:.1} s, off by {off:e}, moved by {moved}", files[i].file_name());
        assert!(off < 1e-3 && moved > 0.05, "{:?}: {off} {moved}", files[i]);
    }
}

#[test]
fn a_file_that_the_browser_cannot_read_is_a_sentence_and_the_viewer_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let [gone, there] = ["gone.csv", "there.csv"].map(|name| folder.path().join(name));
    for path in [&gone, &there] {
        std::fs::write(path, curves()).unwrap();
    }
    let status = "document.getElementById('status')";
    // The file is away when the page reads it.
    let unreadable = "(File.prototype.arrayBuffer = async () => { throw new Error('it is gone'); }, 0)";
    let readable = "(delete File.prototype.arrayBuffer, 0)";
    let steps = [
        evaluate("_", unreadable),
        choose(&[&gone]),
        until(&format!("{status}.textContent.includes('gone.csv')")),
        evaluate("said", &format!("[{status}.textContent, {status}.hidden, rhytid.state]")),
        evaluate("_", readable),
        choose(&[&there]),
        until(&format!("{STATUS}.frames === 21")),
        evaluate("then", &format!("{status}.hidden")),
    ];
    let found = opened("", &steps, json!({}));
    assert_eq!(found["said"], json!(["gone.csv: the browser cannot read it (it is gone)", false, "open"]));
    assert_eq!(found["then"], true);
}

#[test]
fn what_is_wrong_with_a_file_is_said_in_the_program_s_words() {
    let (rig, take) = demo();
    let folder = tempfile::tempdir().unwrap();
    let mut steps = Vec::new();
    let mut expected = Vec::new();
    let mut metres = take.clone();
    metres.positions.iter_mut().flatten().for_each(|x| *x *= 0.01);
    let plain = folder.path().join("metres.csv");
    take::write(&plain, &metres).unwrap();
    let metres = std::fs::read(&plain).unwrap();
    for (i, (name, bytes)) in [
        ("cut.c3d", &b"\x02\x50 and no more"[..]),
        ("empty.trc", b"PathFileType\t4\t(X/Y/Z)\ta.trc\n"),
        ("other.csv", b"time,nobody_x,nobody_y,nobody_z\n0,1,2,3\n"),
        ("curves.csv", b"time,nobody,noone\n0,0.1,0.2\n0.1,0.2,0.3\n"),
        ("metres.csv", &metres),
    ]
    .into_iter()
    .enumerate()
    {
        let path = folder.path().join(format!("{i}-{name}"));
        std::fs::write(&path, bytes).unwrap();
        let said = read_take(&path, rig, Missing::Hold, &CleanUp::default(), &NoProgress);
        let said = said.unwrap_err().to_string();
        // The page knows of no folder.
        expected.push(said.replace(&format!("{}/", folder.path().display()), ""));
        steps.extend([
            choose(&[&path]),
            until(&format!("{STATUS}.error && {STATUS}.note.startsWith('{i}-')")),
            evaluate(&i.to_string(), STATUS),
        ]);
    }
    let found = opened("", &steps, json!({}));
    for (i, said) in expected.iter().enumerate() {
        assert_eq!(found[i.to_string()]["note"], *said);
    }
}

/// The positions of frames 0, 40, 80 and so on of the demo's take.
fn frames() -> Vec<Vec<f32>> {
    let (rig, take) = demo();
    let cpu = Cpu::open(&Cpu::devices().unwrap()[0]).unwrap();
    let mut animator = Animator::new(&cpu, rig, UploadOptions::frames(1)).unwrap();
    let all = take.handle_positions(&rig.handles().labels).unwrap();
    let mut frames = Vec::new();
    for handles in all.chunks_exact(3 * rig.handles().len()).step_by(40) {
        let mut positions = Vec::new();
        animator.evaluate(handles).unwrap();
        animator.read(Stage::Positions, &mut positions).unwrap();
        frames.push(positions);
    }
    frames
}

/// Exports frames as an animation.
fn export(path: &Path, frames: &[Vec<f32>]) {
    let surface = demo().0.surface();
    let recipe = StatedRecipe::default();
    let scene = Scene {
        name: "demo",
        rest: &surface.rest,
        rest_normals: None,
        channels: &[],
        faces: &surface.faces,
        triangle_corners: &surface.triangle_corners().unwrap(),
        uvs: None,
        materials: None,
        head: None,
        metres_per_unit: surface.metres_per_unit,
        up_axis: surface.up_axis,
        frames: frames.len(),
        rate: 10.0,
        first_time_code: 0.0,
        recipe: &recipe,
        further: &[],
    };
    let mut exporter = animation::create(path, &scene, &Default::default()).unwrap();
    for positions in frames {
        exporter.frame(&Frame::new(positions)).unwrap();
    }
    exporter.finish(&NoProgress).unwrap();
}

#[test]
fn meshes_and_animations_are_shown_without_a_rig() {
    let surface = demo().0.surface();
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let positions = surface.rest.iter().map(|p| p.map(f64::from)).collect();
    mesh::write_obj(&at("a.obj"), &Mesh { positions, faces: surface.faces.clone(), ..Mesh::default() })
        .unwrap();
    let frames = frames();
    for name in ["a.usd", "a.glb", "a.gltf"] {
        export(&at(name), &frames);
    }
    let files = std::fs::read_dir(folder.path()).unwrap().map(|file| file.unwrap().path());
    let bin = files.into_iter().find(|file| file.extension().unwrap() == "bin").unwrap();
    let mut steps = Vec::new();
    for (name, frame) in [("a.obj", 0), ("a.usd", 4), ("a.glb", 3), ("a.gltf", 2)] {
        let file = at(name);
        // A glTF text has its numbers in another file.
        let both = [&*file, &*bin];
        steps.extend([
            choose(if name == "a.gltf" { &both } else { &both[..1] }),
            until(&format!("{STATUS}.open === '{name}' && {STATUS}.pictures > 0")),
            evaluate("_", &format!("rhytid.viewer.seek({frame})")),
            shown(),
            evaluate(&format!("status {name}"), STATUS),
            evaluate(name, POSITIONS),
        ]);
    }
    let found = opened("", &steps, json!({}));
    let rest = surface.rest.as_flattened().to_vec();
    for (name, expected) in
        [("a.obj", &rest), ("a.usd", &frames[4]), ("a.glb", &frames[3]), ("a.gltf", &frames[2])]
    {
        let status = &found[format!("status {name}")];
        assert!(status["mesh"] == true && status["error"] == false, "{name}: {status}");
        let shown = floats(&found[name]);
        assert_eq!(shown.len(), expected.len(), "{name}");
        let off = shown.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 1e-4, "{name}: {off}");
    }
}
