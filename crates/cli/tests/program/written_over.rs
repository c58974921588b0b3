//! No file decides by itself where something is written, and nothing that a command reads, and nothing that
//! somebody has changed, is written over.
#![cfg(unix)]

use crate::common::{Fixture, assert_refused, list};
use rhytid::formats::mesh;
use std::collections::BTreeMap;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

/// All files below a folder with their bytes. A link is not followed.
fn snapshot(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
            let (path, kind) = (entry.path(), entry.file_type().unwrap());
            if kind.is_dir() {
                folders.push(path);
            } else if kind.is_file() {
                found.insert(path.clone(), std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

/// A command with `OUT` where an output's name is, the ending of that name, and the files that it reads.
struct Writer {
    command: &'static str,
    ending: &'static str,
    inputs: &'static [&'static str],
}

const PROJECT: [&str; 5] = ["face.toml", "neutral.obj", "markers.csv", "poses/pinch.obj", "map.png"];
const RIG: [&str; 2] = ["face.safetensors", "take.csv"];
const EDITED: [&str; 5] = ["face.safetensors", "take.csv", "edit.toml", "other.csv", "sculpt.obj"];
const TEXTURED: [&str; 4] = ["face.safetensors", "take.csv", "skin.mtl", "map.png"];

const WRITERS: [Writer; 17] = [
    Writer { command: "solve face.toml -o OUT", ending: "safetensors", inputs: &PROJECT },
    Writer {
        command: "solve face.toml -o out/a.safetensors --pack OUT",
        ending: "safetensors",
        inputs: &PROJECT,
    },
    Writer { command: "pack face.safetensors take.csv -o OUT", ending: "safetensors", inputs: &RIG },
    // The table is the one file of the project that the command makes.
    Writer {
        command: "handles face.toml take.csv -o OUT",
        ending: "csv",
        inputs: &["face.toml", "neutral.obj", "poses/pinch.obj", "map.png"],
    },
    Writer {
        command: "handles face.toml take.csv -o out/new.csv --picture OUT",
        ending: "png",
        inputs: &["face.toml", "neutral.obj", "poses/pinch.obj", "map.png"],
    },
    Writer { command: "animate face.safetensors take.csv -o OUT", ending: "usd", inputs: &RIG },
    Writer {
        command: "animate face.safetensors take.csv --edit edit.toml -o OUT",
        ending: "glb",
        inputs: &EDITED,
    },
    Writer {
        command: "animate face.safetensors take.csv --edit edit.toml -o out/a.pc2 --strain-curves OUT",
        ending: "csv",
        inputs: &EDITED,
    },
    Writer { command: "export-shapes face.safetensors -o OUT", ending: "glb", inputs: &["face.safetensors"] },
    Writer {
        command: "prepare take.csv --rig face.safetensors --setup take.toml -o OUT",
        ending: "csv",
        inputs: &["take.csv", "face.safetensors", "take.toml", "known.csv"],
    },
    Writer {
        command: "prepare take.csv --rig face.safetensors --setup take.toml -o out/a.csv --write-markers OUT",
        ending: "csv",
        inputs: &["take.csv", "face.safetensors", "take.toml", "known.csv"],
    },
    Writer {
        command: "correct face.safetensors take.csv --edit edit.toml --frame 3 -o OUT",
        ending: "obj",
        inputs: &EDITED,
    },
    Writer {
        command: "stitch part-a.usd part-b.usd -o OUT",
        ending: "usd",
        inputs: &["part-a.usd", "part-b.usd"],
    },
    Writer {
        command: "transfer --from face.safetensors --to ben.toml -o OUT",
        ending: "safetensors",
        inputs: &["face.safetensors", "ben.toml", "neutral.obj", "markers.csv"],
    },
    Writer {
        command: "render face.safetensors take.csv --edit edit.toml --frames 0..1 --size 64x64 -o OUT",
        ending: "png",
        inputs: &EDITED,
    },
    Writer {
        command: "render face.safetensors take.csv --show textured --texture skin.mtl --frames 0..1 --size 64x64 -o OUT",
        ending: "png",
        inputs: &TEXTURED,
    },
    Writer { command: "bench face.safetensors --plot OUT", ending: "svg", inputs: &["face.safetensors"] },
];

/// A project with a map and edits with a take and a sculpted mesh; a rig; parts of its animation.
fn prepared() -> Fixture {
    let f = Fixture::new();
    f.replace("neutral.obj", "f ", "mtllib skin.mtl\nusemtl skin\nf ");
    f.write("map.png", grey(16));
    f.write("skin.mtl", "newmtl skin\nmap_Kd map.png\n");
    let map = "mesh = \"poses/pinch.obj\"\ndisplacement = \"map.png\"\nmillimetres = 0.1\n";
    f.replace("face.toml", "mesh = \"poses/pinch.obj\"\n", map);
    f.write("ben.toml", f.read_text("face.toml").split("[[example]]").next().unwrap());
    f.write("edit.toml", "[[add]]\ntake = \"other.csv\"\n[[correction]]\nmesh = \"sculpt.obj\"\nframe = 3\n");
    f.write("other.csv", f.take(20));
    f.write("sculpt.obj", f.obj(0.1));
    f.write("known.csv", "handle,marker\n");
    f.write("take.toml", "markers = \"known.csv\"\n");
    f.done("solve face.toml -o face.safetensors");
    for (frames, part) in [("0..9", "a"), ("9..17", "b")] {
        f.done(&format!(
            "animate face.safetensors take.csv --device cpu:0 --frames {frames} -o part-{part}.usd"
        ));
    }
    f
}

/// A grey PNG.
fn grey(side: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side, side);
    encoder.set_color(png::ColorType::Grayscale);
    let pixels = vec![128; (side * side) as usize];
    encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
    bytes
}

#[test]
fn no_command_writes_over_any_of_its_inputs() {
    let f = prepared();
    for Writer { command, ending, inputs } in WRITERS {
        for input in inputs {
            // Through a link, every input can have every ending.
            let link = format!("link-{}.{ending}", input.replace('/', "-"));
            let _ = std::fs::remove_file(f.path(&link));
            symlink(f.path(input), f.path(&link)).unwrap();
            let before = snapshot(&f.path("."));
            let command = command.replace("OUT", &link);
            let output = f.rhytid(&command).output().unwrap();
            let said = assert_refused(&output, &[]);
            let is_told = said.contains("which this command reads") || said.contains("is a link");
            assert!(is_told, "{command}: {said}");
            let mut after = snapshot(&f.path("."));
            after.retain(|path, _| before.contains_key(path));
            assert!(after == before, "{command}");
            std::fs::remove_file(f.path(&link)).unwrap();
        }
    }
}

/// Files of a report have fixed names, and one of them may be read.
#[test]
fn a_report_writes_over_no_input() {
    let f = prepared();
    f.write("report.json", "handle,marker\n");
    let output = f
        .rhytid("prepare take.csv --rig face.safetensors -o out/a.csv --markers report.json --report .")
        .output();
    assert_refused(&output.unwrap(), &["report.json", "which this command reads"]);
    assert_eq!(f.read_text("report.json"), "handle,marker\n");
}

#[test]
fn a_project_does_not_decide_where_handles_are_written() {
    let f = Fixture::new();
    std::fs::create_dir(f.path("job")).unwrap();
    for file in ["neutral.obj", "take.csv", "poses"] {
        std::fs::rename(f.path(file), f.path("job").join(file)).unwrap();
    }
    symlink("..", f.path("job/up")).unwrap();
    symlink("../dangling.csv", f.path("job/out.csv")).unwrap();
    symlink("../out/picture.png", f.path("job/linked.png")).unwrap();
    symlink("/dev/null", f.path("job/null.csv")).unwrap();
    let project = f.read_text("face.toml");
    for (table, words) in [
        ("../.bash_profile", "not in job or below"),
        ("../markers.csv", "not in job or below"),
        ("up/markers.csv", "not in job or below"),
        (".bash_profile", "ends in .csv"),
        ("run.sh", "ends in .csv"),
        ("out.csv", "a link that leads nowhere"),
        ("null.csv", "not in job or below"),
        // The picture beside it is a link.
        ("linked.csv", "linked.png"),
    ] {
        f.write("job/face.toml", project.replace("markers.csv", table));
        let before = snapshot(&f.path("."));
        let said =
            assert_refused(&f.rhytid("handles job/face.toml job/take.csv").output().unwrap(), &[words]);
        assert!(snapshot(&f.path(".")) == before, "{table}: {said}");
    }
    f.write("job/face.toml", project.replace("markers.csv", "below.csv"));
    f.done("handles job/face.toml job/take.csv");
    assert!(f.read_text("job/below.csv").starts_with("label,vertex,"));
}

/// What a spreadsheet would compute is a text.
#[test]
fn labels_are_data() {
    let f = Fixture::new();
    let formula = "=cmd|' /C calc'!A0";
    f.write("take.csv", f.take(20).replace("left_", &format!("{formula}_")));
    f.done("handles face.toml take.csv -o out/table.csv --picture picture.png");
    let table = f.read_text("out/table.csv");
    assert!(table.contains(&format!("\n\"{formula}\",")), "{table}");
}

#[test]
fn transfer_keeps_scans_that_are_there() {
    let f = prepared();
    let scan = f.read("poses/pinch.obj");
    let command = "transfer --from face.safetensors --to ben.toml -o out/ben.safetensors --examples";
    f.refused(&format!("{command} poses"), &["poses/pinch.obj", "is there already"]);
    assert!(f.read("poses/pinch.obj") == scan);
    f.done(&format!("{command} kept"));
    let kept = mesh::read(&f.path("kept/pinch.obj")).unwrap();
    // Once more, the same examples are there.
    f.done(&format!("{command} kept"));
    assert_eq!(mesh::read(&f.path("kept/pinch.obj")).unwrap(), kept);
}

#[test]
fn the_demo_keeps_what_somebody_changed() {
    let f = Fixture::new();
    let demo = "demo ours --vertices 2000";
    f.done(demo);
    let first = snapshot(&f.path("ours"));
    f.done(demo);
    let again = snapshot(&f.path("ours"));
    for file in ["face.toml", "neutral.obj", "performance.csv", "face.safetensors"] {
        assert!(first[&f.path("ours").join(file)] == again[&f.path("ours").join(file)], "{file}");
    }
    f.replace("ours/face.toml", "[handles]", "[pins]\nauto = false\n[handles]");
    let before = snapshot(&f.path("ours"));
    let said = assert_refused(&f.rhytid(demo).output().unwrap(), &["ours/face.toml", "is there already"]);
    assert!(snapshot(&f.path("ours")) == before, "{said}");
    assert_refused(
        &f.rhytid("demo ours --vertices 3000").output().unwrap(),
        &["is there already", "choose another folder"],
    );
    assert!(snapshot(&f.path("ours")) == before);
}

#[test]
fn new_leaves_all_or_nothing() {
    let f = Fixture::new();
    std::fs::create_dir(f.path("scans")).unwrap();
    std::fs::copy(f.path("neutral.obj"), f.path("scans/neutral.obj")).unwrap();
    std::fs::copy(f.path("poses/pinch.obj"), f.path("scans/pinch.obj")).unwrap();
    f.write("scans/sub/pinch.ply", f.ply());
    std::fs::rename(f.path("scans/sub/pinch.ply"), f.path("scans/pinch.ply")).unwrap();
    std::fs::remove_dir(f.path("scans/sub")).unwrap();
    let before = list(&f.path("scans"));
    f.refused("new scans/neutral.obj --unit cm", &["pinch.obj", "pinch.ply", "rename one of them"]);
    assert_eq!(list(&f.path("scans")), before);
    std::fs::remove_file(f.path("scans/pinch.ply")).unwrap();
    // A table that is no take is passed over, and named.
    f.write("scans/budget.csv", "item,price\ncamera,5\n");
    let output = f.rhytid("new scans/neutral.obj --unit cm").output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && said.contains("budget.csv: is passed over"), "{said}");
    // Nothing lands where a link leads.
    for file in ["face.toml", "markers.csv", "markers.png"] {
        std::fs::create_dir(f.path("linked")).unwrap();
        symlink("../out/x", f.path("linked").join(file)).unwrap();
        f.refused("new scans/neutral.obj --unit cm -o linked", &[file, "is there already"]);
        std::fs::remove_dir_all(f.path("linked")).unwrap();
    }
}

/// A pipe is read once, or refused by its name.
#[test]
fn pipes_do_not_hang() {
    let f = prepared();
    let wait = std::time::Duration::from_secs(60);
    let fill = |name: &str, bytes: Vec<u8>| {
        let path = f.path(name);
        let _ = std::fs::remove_file(&path);
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        std::thread::spawn(move || std::fs::write(path, bytes))
    };
    let _rig = fill("rig.safetensors", f.read("face.safetensors"));
    let output =
        f.rhytid("animate rig.safetensors take.csv --device cpu:0 -o out/a.usd").timeout(wait).output();
    assert_refused(&output.unwrap(), &["rig.safetensors", "is a pipe"]);
    let _take = fill("bad.csv", b"time,a_x\n".to_vec());
    let output =
        f.rhytid("animate face.safetensors bad.csv --device cpu:0 -o out/a.usd").timeout(wait).output();
    assert_refused(&output.unwrap(), &["bad.csv"]);
    f.assert_nothing_written();
}
