//! What a command says at its end, to people and as JSON.

use crate::common::{Fixture, assert_documented, stderr};
use serde_json::Value;

/// Runs the command, whose standard output must be JSON alone.
fn json(f: &Fixture, command: &str) -> Value {
    let said = f.done(command);
    serde_json::from_str(&said).unwrap_or_else(|error| panic!("{command}: {error}: {said}"))
}

#[test]
fn every_command_that_makes_something_says_it_as_json() {
    let f = Fixture::new();
    let solved = json(&f, "solve face.toml --json");
    assert_documented(&solved, "solve");
    assert_eq!(solved["file"], "face.safetensors");
    assert_eq!(
        (&solved["vertices"], &solved["handles"], &solved["examples"]),
        (&441.into(), &5.into(), &1.into())
    );
    assert_eq!(solved["bytes"], f.read("face.safetensors").len());
    assert_eq!(solved["scans"][1]["example"], "pinch");
    assert_eq!(solved["candidates"][0]["left_out_mm"], Value::Null, "one example is too few");

    let animated = json(&f, "animate face.safetensors take.csv -o out/face.usda --json --device cpu:0");
    assert_documented(&animated, "animate");
    assert_eq!((&animated["frames"], &animated["device"]), (&20.into(), &"cpu:0".into()));
    let few = "animate face.safetensors take.csv -o out/face.glb --json --device cpu:0 --compressed";
    assert!(json(&f, few)["worst_mm"].as_f64().unwrap() <= 0.1);

    for part in ["0..10", "10..20"] {
        f.done(&format!(
            "animate face.safetensors take.csv -o out/{part}.usd --frames {part} --device cpu:0"
        ));
    }
    let stitched = json(&f, "stitch out/0..10.usd out/10..20.usd -o out/whole.usd --json");
    assert_documented(&stitched, "stitch");
    assert_eq!((&stitched["frames"], &stitched["parts"]), (&20.into(), &2.into()));

    let shapes = json(&f, "export-shapes face.safetensors -o out/shapes.usd --json --device cpu:0");
    assert_documented(&shapes, "export-shapes");
    assert_eq!(shapes["shapes"], 1);

    let corrected = json(&f, "correct face.safetensors take.csv --frame 3 -o out/pose.obj --json");
    assert_documented(&corrected, "correct");

    let prepared = json(&f, "prepare take.csv --rig face.safetensors -o out/clean.csv --json");
    assert_documented(&prepared, "prepare");
    assert_eq!(prepared["report"]["labels"][0], "left");

    let sent = json(&f, "send take.csv --to 127.0.0.1:9 --rate 1000 --json");
    assert_documented(&sent, "send");
    assert_eq!((&sent["frames"], &sent["markers"]), (&20.into(), &5.into()));

    let placed = json(&f, "handles face.toml --count 8 -o out/markers.csv --json");
    assert_documented(&placed, "handles that were placed");
    assert_eq!((&placed["handles"], &placed["frame"]), (&8.into(), &Value::Null));

    assert_documented(&json(&f, "man out/man --json"), "man");
    let output = f.rhytid("demo out/demo --vertices 2000 --json --quiet").output().unwrap();
    assert_documented(&serde_json::from_slice(&output.stdout).unwrap(), "demo");
    let said = stderr(&output);
    assert!(said.lines().all(|line| line.starts_with("warning: ")), "{said}");
    let made = json(&f, "new out/demo/neutral.obj -o out/new --json");
    assert_documented(&made, "new");
    assert_eq!(made["examples"].as_array().unwrap().len(), 6);
}

#[test]
#[cfg(feature = "wgpu")]
fn pictures_are_said_as_json() {
    let f = Fixture::new();
    f.done("solve face.toml");
    let drawn = json(&f, "render face.safetensors take.csv -o out/sheet.png --count 2 --size 40x40 --json");
    assert_documented(&drawn, "render");
    assert_eq!(drawn["pictures"], 2);
}

/// `--quiet` leaves requested output.
#[test]
fn json_is_printed_quietly_too() {
    let f = Fixture::new();
    assert_documented(&json(&f, "solve face.toml --json --quiet"), "solve");
}

#[test]
fn a_solve_writes_beside_its_project() {
    let f = Fixture::new();
    std::fs::create_dir_all(f.path("elsewhere")).unwrap();
    let output = f.rhytid("solve ../face.toml").current_dir(f.path("elsewhere")).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(f.path("face.safetensors").is_file());
    assert_eq!(std::fs::read_dir(f.path("elsewhere")).unwrap().count(), 0);
}

/// The commands that a summary proposes run as they are.
#[test]
fn proposed_commands_run() {
    let f = Fixture::new();
    let said = f.done("solve face.toml");
    let proposed = |said: &str| -> Vec<String> {
        let (_, next) = said.split_once("\nNext:\n").unwrap_or_else(|| panic!("{said}"));
        next.lines().filter_map(|line| line.trim().strip_prefix("rhytid ")).map(str::to_owned).collect()
    };
    let mut commands = proposed(&said);
    let animate = commands.iter().find(|command| command.starts_with("animate")).unwrap();
    let said = f.done(&format!("{} --device cpu:0", animate.replace("TAKE.csv", "take.csv")));
    commands.retain(|command| !command.starts_with("animate"));
    commands.extend(proposed(&said));
    let names: Vec<&str> = commands.iter().map(|command| command.split(' ').next().unwrap()).collect();
    assert!(names.contains(&"verify") && names.contains(&"evaluate"), "{names:?}");
    for command in commands.iter().filter(|command| !command.starts_with("view")) {
        f.done(command);
    }
}

#[test]
fn times_and_settings_are_for_those_who_ask() {
    let f = Fixture::new();
    let (short, long) = (f.done("solve face.toml"), f.done("solve face.toml -v"));
    assert!(short.lines().count() <= 8, "{short}");
    for word in ["strain edges", "peak memory", "learned with"] {
        assert!(!short.contains(word) && long.contains(word), "{word}: {long}");
    }
}

#[test]
fn help_lists_the_commands_in_groups() {
    let f = Fixture::new();
    let help = f.done("--help");
    let at = |word: &str| help.find(&format!("\n{word}")).unwrap_or_else(|| panic!("no {word}: {help}"));
    let groups = [
        "Look first:",
        "Make a face and its animation:",
        "Prepare and change:",
        "Judge:",
        "Choose a device:",
    ];
    assert!(groups.windows(2).all(|pair| at(pair[0]) < at(pair[1])), "{help}");
    assert!(
        at("  demo") < at("  solve") && at("  solve") < at("  doctor") && at("  doctor") < at("  devices")
    );
    assert!(help.contains("--quiet") && help.contains("Exit codes:"), "{help}");
    assert_eq!(help, f.done("help"));
}
