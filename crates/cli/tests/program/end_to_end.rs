//! The way from files to an animated file, and what the commands print.

use crate::common::{Fixture, assert_documented, list, rhytid, stderr};
use serde_json::Value;
use tempfile::TempDir;

fn json(f: &Fixture, args: &str) -> Value {
    serde_json::from_str(&f.done(args)).unwrap()
}

/// Without any input file: demo, then every query about its results.
#[test]
fn demo() {
    let f = Fixture::new();
    let printed = f.done("demo demo --vertices 3000");
    for word in ["solve", "animate on ", "face.usd", "face.glb", "Blender"] {
        assert!(printed.contains(word), "{word}: {printed}");
    }
    let files = list(&f.path("demo"));
    let expected = [
        "face.glb",
        #[cfg(feature = "film")]
        "face.mp4",
        #[cfg(feature = "wgpu")]
        "face.png",
        "face.safetensors",
        "face.toml",
        "face.usd",
        "markers.csv",
        "neutral.obj",
        "performance.csv",
        "poses",
    ];
    assert_eq!(files, expected);
    let poses = list(&f.path("demo/poses"));
    assert_eq!(poses.len(), 6, "{poses:?}");

    let vertices = json(&f, "info demo/neutral.obj --json")["vertices"].as_u64().unwrap();
    assert!((2400..3600).contains(&vertices), "{vertices}");
    for pose in &poses {
        assert_eq!(json(&f, &format!("info demo/poses/{pose} --json"))["vertices"], vertices);
    }
    let frames = json(&f, "info demo/performance.csv --json")["frames"].as_u64().unwrap();
    let rig = json(&f, "info demo/face.safetensors --json");
    assert_eq!(rig["vertices"], vertices);
    assert_eq!(rig["examples"].as_array().unwrap().len(), 6);
    assert_eq!(rig["handles"], json(&f, "info demo/markers.csv --json")["handles"]);
    assert_eq!(rig["handles"], json(&f, "info demo/performance.csv --json")["markers"]);
    assert_eq!(rig["handles"], json(&f, "info demo/face.toml --json")["handles"]);
    assert_eq!(json(&f, "doctor demo/face.toml --json")["solvable"], true);

    for file in ["face.usd", "face.glb"] {
        let args =
            format!("verify demo/{file} --rig demo/face.safetensors --take demo/performance.csv --json");
        let verified = json(&f, &args);
        assert_eq!((&verified["passed"], &verified["frames"]), (&true.into(), &frames.into()), "{file}");
    }
    assert!(f.read("demo/face.usd").starts_with(b"PXR-USDC"));
    let glb = f.read("demo/face.glb");
    assert_eq!(&glb[..4], b"glTF");
    assert_eq!(u32::from_le_bytes(glb[8..12].try_into().unwrap()) as usize, glb.len());

    // Its own files are replaced, by the same bytes.
    let before: Vec<Vec<u8>> =
        expected[..expected.len() - 1].iter().map(|file| f.read(&format!("demo/{file}"))).collect();
    f.done("demo demo --vertices 3000 --quiet");
    for (file, before) in expected.iter().zip(before) {
        assert!(f.read(&format!("demo/{file}")) == before, "{file} changed");
    }
}

#[test]
fn the_same_input_gives_the_same_bytes_with_any_number_of_threads() {
    let f = Fixture::new();
    for (args, ending) in [
        ("solve face.toml", "safetensors"),
        ("animate out/a.safetensors take.csv", "usd"),
        ("animate out/a.safetensors take.csv", "usda"),
        ("animate out/a.safetensors take.csv", "usdz"),
        ("animate out/a.safetensors take.csv", "glb"),
        ("animate out/a.safetensors take.csv --compressed --quantize --meshopt", "glb"),
        ("export-shapes out/a.safetensors", "usd"),
        ("export-shapes out/a.safetensors", "glb"),
    ] {
        for (name, threads) in [("a", "1"), ("b", "3")] {
            // With fewer threads another device may be the fastest one, and give other bits.
            let device = if args.starts_with("solve") { "" } else { "--device cpu:0" };
            let mut command = f.rhytid(&format!("{args} {device} -o out/{name}.{ending}"));
            command.env("RAYON_NUM_THREADS", threads).assert().success();
        }
        assert!(f.read(&format!("out/a.{ending}")) == f.read(&format!("out/b.{ending}")), "{args} {ending}");
        assert!(!f.read(&format!("out/a.{ending}")).is_empty());
    }
}

/// The value of a key in a layer's metadata.
fn usda_number(usda: &str, key: &str) -> f64 {
    let line = usda.lines().find(|line| line.trim_start().starts_with(&format!("{key} = "))).unwrap();
    line.split(" = ").nth(1).unwrap().trim().parse().unwrap()
}

#[test]
fn frames_and_rates() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    for (options, start, end, rate) in [
        ("", 0.0, 19.0, 30.0),
        ("--frames 5..8", 5.0, 7.0, 30.0),
        ("--frames 15..", 15.0, 19.0, 30.0),
        ("--frames ..5", 0.0, 4.0, 30.0),
        ("--fps 60", 0.0, 38.0, 60.0),
        ("--fps 15", 0.0, 9.0, 15.0),
        ("--frames 10..14 --fps 60", 20.0, 27.0, 60.0),
    ] {
        let printed = f.done(&format!("animate face.safetensors take.csv -o out/face.usda {options}"));
        let usda = f.read_text("out/face.usda");
        let range = ["startTimeCode", "endTimeCode", "timeCodesPerSecond"].map(|key| usda_number(&usda, key));
        assert_eq!(range, [start, end, rate], "{options}");
        assert!(printed.contains(&format!("{} frames", end - start + 1.0)), "{options}: {printed}");
    }
}

/// A take that begins in the middle of a session begins there in the export, too.
#[test]
fn a_take_keeps_its_place_in_the_session() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    let take = f.read_text("take.csv");
    let mut rows = take.lines();
    let mut later = rows.next().unwrap().to_owned();
    for row in rows {
        let (time, rest) = row.split_once(',').unwrap();
        later += &format!("\n{},{rest}", 40.0 + time.parse::<f64>().unwrap());
    }
    f.write("later.csv", later + "\n");
    for (options, start, end, last) in [
        ("", 1200.0, 1219.0, ""),
        ("--frames 5..8 --fps 60", 2410.0, 2415.0, ""),
        ("--start-frame 1001", 1001.0, 1020.0, ""),
        ("--start-frame 1001 --frames 5..8", 1006.0, 1008.0, ""),
        ("--start-frame 1048570", 1_048_570.0, 1_048_589.0, "1048590"),
    ] {
        let out =
            f.rhytid(&format!("animate face.safetensors later.csv -o out/face.usda {options}")).output();
        let out = out.unwrap();
        let said = String::from_utf8(out.stderr).unwrap();
        assert!(out.status.success(), "{said}");
        assert_eq!(said.contains("Blender's timeline ends at 1048574"), !last.is_empty(), "{said}");
        assert!(said.contains(last), "{said}");
        let usda = f.read_text("out/face.usda");
        let range = ["startTimeCode", "endTimeCode"].map(|key| usda_number(&usda, key));
        assert_eq!(range, [start, end], "{options}");
        f.done("verify out/face.usda --rig face.safetensors --take later.csv");
    }
}

/// The points of each frame, from the time samples of a `.usda`.
fn usda_points(usda: &str) -> Vec<Vec<[f64; 3]>> {
    let samples = usda.split_once("points.timeSamples = {").unwrap().1;
    let samples = samples.split_once('}').unwrap().0;
    let lists = samples.split('[').skip(1).map(|list| list.split_once(']').unwrap().0);
    let points = |list: &str| {
        let triples = list.split('(').skip(1).map(|triple| triple.split_once(')').unwrap().0);
        let numbers = |triple: &str| triple.split(',').map(|x| x.trim().parse::<f64>().unwrap()).collect();
        triples.map(|triple| <Vec<f64> as TryInto<[f64; 3]>>::try_into(numbers(triple)).unwrap()).collect()
    };
    lists.map(points).collect()
}

/// The chosen method is reported. The chapter's method can be given by name at either place, and gives the
/// same rig.
#[test]
fn methods() {
    let f = Fixture::new();
    let said = f.done("solve face.toml -o learned.safetensors -v");
    assert!(said.contains("learned with share 0.2, ridge 0.01, reach 1\n"), "{said}");
    let project = f.read_text("face.toml");
    f.write("above.toml", format!("method = \"chapter\"\n{project}"));
    f.write("below.toml", project.replace("[fine_scale]", "[fine_scale]\nmethod = \"chapter\""));
    for name in ["above", "below"] {
        let said = f.done(&format!("solve {name}.toml -o {name}.safetensors -v"));
        assert!(!said.contains("learned with"), "{said}");
        let info = f.done(&format!("info {name}.safetensors --json"));
        assert!(info.contains("\"method\": \"chapter\""), "{info}");
    }
    let chapter = f.read("above.safetensors");
    assert!(chapter != f.read("learned.safetensors"));
    assert_eq!(chapter.len(), f.read("below.safetensors").len());
}

/// Both stages meet the take's markers; only the full one wrinkles between them.
#[test]
fn stages() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    f.done("animate face.safetensors take.csv -o out/full.usda");
    f.done("animate face.safetensors take.csv -o out/coarse.usda --stage large-scale");
    let full = usda_points(&f.read_text("out/full.usda"));
    let coarse = usda_points(&f.read_text("out/coarse.usda"));
    let take = f.read_text("take.csv");
    let take: Vec<Vec<f64>> =
        take.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    assert_eq!((full.len(), coarse.len(), take.len()), (20, 20, 20));
    for (frame, row) in take.iter().enumerate() {
        for h in 0..5 {
            for c in 0..3 {
                let marker = row[1 + h * 3 + c];
                for points in [&full, &coarse] {
                    let found = points[frame][f.handle(h)][c];
                    assert!(
                        (found - marker).abs() < 1e-4,
                        "frame {frame}, handle {h}: {found}, not {marker}"
                    );
                }
            }
        }
    }
    let difference = |a: &[[f64; 3]], b: &[[f64; 3]]| {
        a.iter().zip(b).flat_map(|(p, q)| (0..3).map(move |c| (p[c] - q[c]).abs())).fold(0.0, f64::max)
    };
    assert!(difference(&full[0], &coarse[0]) < 1e-4, "the rest pose has no detail");
    let at_the_example = difference(&full[16], &coarse[16]);
    // The linear band has taken the smooth part of it.
    assert!(at_the_example > 0.05, "the example has wrinkles: {at_the_example}");
}

/// An uneven take is resampled, with a message.
#[test]
fn an_uneven_take() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    let take: Vec<String> = f.take(20).lines().map(str::to_owned).collect();
    f.write("take.csv", [&take[..8], &take[9..]].concat().join("\n"));
    let output = f.rhytid("animate face.safetensors take.csv -o out/face.usda").output().unwrap();
    assert!(output.status.success());
    let warning = stderr(&output);
    assert!(warning.lines().any(|l| l.starts_with("warning: ") && l.contains("uneven")), "{warning}");
    assert_eq!(usda_points(&f.read_text("out/face.usda")).len(), 20);
    assert_eq!(json(&f, "info take.csv --json")["even"], false);
}

#[test]
fn json_has_the_documented_keys() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    for (file, what) in [
        ("neutral.obj", "mesh"),
        ("face.safetensors", "rig"),
        ("take.csv", "take"),
        ("markers.csv", "handles"),
        ("face.toml", "project"),
    ] {
        let info = json(&f, &format!("info {file} --json"));
        assert_eq!(info["kind"], what);
        assert_eq!(info["file"], file);
        assert_eq!(info["file_bytes"], f.read(file).len());
        assert_documented(&info, what);
    }
    let devices = json(&f, "devices --json");
    assert_documented(&devices, "devices");
    assert_documented(&devices["devices"][0], "a device");
    let ids: Vec<&str> =
        devices["devices"].as_array().unwrap().iter().map(|d| d["id"].as_str().unwrap()).collect();
    assert!(ids.contains(&"cpu:0"), "{ids:?}");

    // A vertex that belongs to no face causes a warning.
    for mesh in ["neutral.obj", "poses/pinch.obj"] {
        f.replace(mesh, "\nvt ", "\nv 1 2 3\nvt ");
    }
    let doctor = json(&f, "doctor face.toml --json");
    assert_documented(&doctor, "doctor");
    assert!(!doctor["findings"].as_array().unwrap().is_empty(), "{doctor}");
    assert_documented(&doctor["findings"][0], "a finding");
}

#[test]
fn info_counts() {
    let f = Fixture::new();
    f.done("solve face.toml -o face.safetensors");
    let rig = json(&f, "info face.safetensors --json");
    assert_eq!(rig["vertices"], 441);
    assert_eq!(rig["faces"], 400);
    assert_eq!(rig["triangles"], 800);
    assert_eq!(rig["faces_by_corners"]["4"], 400);
    // One texture coordinate at each vertex.
    assert_eq!(rig["uvs"], "vertex");
    assert_eq!(rig["metres_per_unit"], 0.01);
    assert_eq!(rig["up"], "y");
    assert_eq!(rig["labels"], serde_json::json!(["left", "right", "top", "bottom", "middle"]));
    assert_eq!(rig["examples"], serde_json::json!(["pinch"]));
    assert_eq!(rig["bending_length"], 3.0);
    assert_eq!(rig["driven_vertices"], 441);
    assert_eq!(rig["bounds"]["min"][0], -5.0);
    assert_eq!(rig["bounds"]["max"][1], 5.0);
    // The basis alone is 441 × 5 numbers of 4 bytes.
    assert!(rig["device_bytes"].as_u64().unwrap() > 441 * 5 * 4);
    // Rounding to eleven bits changes a number by at most 2⁻¹² of the next power of two. The five numbers of
    // a row sum to about 1.
    let f16_error = rig["f16_error"].as_f64().unwrap();
    assert!(f16_error > 1e-5 && f16_error < 2e-3, "{f16_error}");
    let take = json(&f, "info take.csv --json");
    assert_eq!((&take["frames"], &take["rate"], &take["markers"]), (&20.into(), &30.0.into(), &5.into()));
    let text = f.done("info face.safetensors");
    for word in ["441", "left, right, top, bottom, middle", "pinch", "cm, Y up", "basis as fp16"] {
        assert!(text.contains(word), "{word}: {text}");
    }
}

/// A doctor's error: no solve, exit code 2, and the report on standard output.
#[test]
fn the_doctor_finds_what_makes_the_solve_impossible() {
    let f = Fixture::new();
    assert!(f.done("doctor face.toml").contains("can be solved"));
    f.replace("markers.csv", &format!("right,{}", f.handle(1)), &format!("right,{}", f.handle(0)));
    let output = f.rhytid("doctor face.toml --json").output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_documented(&report, "doctor");
    assert_eq!(report["solvable"], false, "{report}");
    let output = f.rhytid("doctor face.toml").output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    let report = String::from_utf8(output.stdout).unwrap();
    for words in ["error: ", "left", "right", "the face cannot be solved"] {
        assert!(report.contains(words), "{words}: {report}");
    }
    f.solve_refused(&["right", "left"]);
}

#[test]
fn quiet_prints_nothing() {
    let f = Fixture::new();
    for args in [
        "solve face.toml -o face.safetensors -q",
        "-q animate face.safetensors take.csv -o out/face.usda",
        "man man -q",
    ] {
        let output = f.rhytid(args).output().unwrap();
        assert_eq!((output.status.code(), output.stdout.len()), (Some(0), 0), "{args}");
        let stderr = stderr(&output);
        assert!(stderr.lines().all(|line| line.starts_with("warning: ")), "{args}: {stderr}");
    }
}

#[test]
fn progress_is_plain_lines_where_there_is_no_terminal() {
    let f = Fixture::new();
    let output = f.rhytid("solve face.toml -o face.safetensors").output().unwrap();
    let text = stderr(&output);
    assert!(text.lines().count() > 2, "{text}");
    assert!(!text.contains('\u{1b}') && !text.contains('\r'), "{text:?}");
}

#[test]
fn every_command_has_help_with_an_example() {
    let commands = [
        "new",
        "solve",
        "animate",
        "send",
        #[cfg(feature = "wgpu")]
        "render",
        #[cfg(feature = "view")]
        "view",
        "farm",
        "stitch",
        "export-shapes",
        "verify",
        "handles",
        "prepare",
        "evaluate",
        "coverage",
        "correct",
        "explain",
        "transfer",
        "pack",
        "lod",
        "info",
        "devices",
        "conform",
        "bench",
        "doctor",
        "demo",
        "completions",
        "man",
    ];
    let overview = rhytid("--help").output().unwrap();
    let overview = String::from_utf8(overview.stdout).unwrap();
    for command in commands {
        assert!(overview.contains(&format!("\n  {command}")), "{command}");
        let output = rhytid(&format!("{command} --help")).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success());
        assert!(text.contains(&format!("Examples:\n  rhytid {command}")), "{text}");
    }
    let listed = overview.split("Usage:").nth(1).unwrap().split("Options:").next().unwrap();
    let listed = listed.lines().filter(|line| line.starts_with("  ")).count();
    assert_eq!(listed, commands.len() + 1, "and help: {overview}");
}

#[test]
fn man_pages_and_completions() {
    let dir = TempDir::new().unwrap();
    rhytid("man pages").current_dir(dir.path()).assert().success();
    let pages = list(&dir.path().join("pages"));
    assert_eq!(
        pages.len(),
        26 + usize::from(cfg!(feature = "wgpu")) + usize::from(cfg!(feature = "view")),
        "{pages:?}"
    );
    assert!(pages.contains(&"rhytid.1".to_owned()) && pages.contains(&"rhytid-animate.1".to_owned()));
    let page = std::fs::read_to_string(dir.path().join("pages/rhytid-animate.1")).unwrap();
    assert!(page.contains(".TH") && page.contains("missing") && page.contains("rhytid animate"), "{page}");
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = rhytid(&format!("completions {shell}")).output().unwrap();
        assert!(String::from_utf8(output.stdout).unwrap().contains("missing"), "{shell}");
    }
}
