//! Files that the viewer's page opens: it reads them as the program does.

use super::viewer::{STATUS, distance, evaluate, handles, opened, shown, until};
use super::*;
use rhytid_core::NoProgress;
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
        let take = read_take(file, rig, Missing::Hold, &CleanUp::default(), &NoProgress).unwrap();
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
    let (rig, _) = demo();
    let folder = tempfile::tempdir().unwrap();
    let mut steps = Vec::new();
    let mut expected = Vec::new();
    for (i, (name, bytes)) in [
        ("cut.c3d", &b"\x02\x50 and no more"[..]),
        ("empty.trc", b"PathFileType\t4\t(X/Y/Z)\ta.trc\n"),
        ("other.csv", b"time,nobody_x,nobody_y,nobody_z\n0,1,2,3\n"),
        ("curves.csv", b"time,nobody,noone\n0,0.1,0.2\n0.1,0.2,0.3\n"),
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
