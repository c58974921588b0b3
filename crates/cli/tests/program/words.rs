//! Mistakes that users make, each answered by one sentence that says what to do. Also small things that must
//! work.

use crate::common::{Fixture, demo, rhytid, stderr};

/// Runs the command, which must be refused as the user's mistake. Returns its last line.
fn refused(command: &str) -> String {
    let output = rhytid(command).output().unwrap();
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{command}: {said}");
    said.lines().last().unwrap_or_default().to_owned()
}

fn path(name: &str) -> String {
    demo().join(name).display().to_string()
}

#[test]
fn files_given_the_wrong_way_round_are_named() {
    let [rig, take, project, mesh] =
        ["face.safetensors", "performance.csv", "face.toml", "neutral.obj"].map(path);
    for (command, expected) in [
        (
            format!("animate {take} {rig} -o x.usd"),
            "performance.csv: is a take, expected a rig; the command is rhytid animate RIG TAKE",
        ),
        (format!("animate {project} {take} -o x.usd"), "face.toml: is a project file, expected a rig"),
        (format!("animate {rig} {mesh} -o x.usd"), "neutral.obj: is a mesh, expected a take"),
        (format!("solve {mesh} -o x.safetensors"), "neutral.obj: is a mesh, expected a project file"),
        (format!("doctor {rig}"), "face.safetensors: is a rig, expected a project file"),
        (format!("prepare {rig} --rig {take} -o x.csv"), "face.safetensors: is a rig, expected a raw take"),
        (format!("coverage {take} {rig}"), "performance.csv: is a take, expected a rig"),
        (format!("handles {take} {project}"), "performance.csv: is a take, expected a project file"),
        (
            format!("prepare {take} --rig {rig} -o x.c3d"),
            "x.c3d: a clean take is written as CSV; name it .csv",
        ),
        (
            format!("prepare {take} --rig {rig} -o x.csv --map chin=M1 --map lip_up=M1"),
            "the label “M1” is given to two handles, “chin” and “lip_up”; give it to one",
        ),
    ] {
        let said = refused(&command);
        assert!(said.contains(expected), "{command}: {said}");
    }
}

#[test]
fn slips_in_files_name_their_remedy() {
    let f = Fixture::new();
    let text = |name: &str| String::from_utf8(f.read(name)).unwrap();
    f.write(
        "one.toml",
        text("face.toml").replace("[[example]]", "[example]") + "\n[example]\nname = \"b\"\n",
    );
    f.write("back.toml", text("face.toml").replace("\"neutral.obj\"", "\"C:\\scans\\neutral.obj\""));
    f.write("tabs.csv", text("markers.csv").replace(',', "\t"));
    f.write("tabs.toml", text("face.toml").replace("markers.csv", "tabs.csv"));
    for (command, expected) in [
        (
            format!("doctor {}", f.path("one.toml").display()),
            "each example begins with [[example]] in double brackets",
        ),
        (format!("doctor {}", f.path("back.toml").display()), "write paths with / or in 'single quotes'"),
        (
            format!("doctor {}", f.path("tabs.toml").display()),
            "tabs.csv, line 1: the columns are separated by tabs",
        ),
    ] {
        let said = refused(&command);
        assert!(said.contains(expected), "{command}: {said}");
    }
}

#[test]
fn rates_as_fractions_and_backends_without_a_number_are_understood() {
    let [rig, take] = ["face.safetensors", "performance.csv"].map(path);
    let folder = tempfile::tempdir().unwrap();
    let usd = folder.path().join("x.usd").display().to_string();
    let output =
        rhytid(&format!("animate {rig} {take} -o {usd} --fps 30000/1001 --device cpu")).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("at 29.97 frames per second, evaluated on cpu:0"), "{said}{}", stderr(&output));
    assert!(refused(&format!("animate {rig} {take} -o {usd} --fps 1/0 --device cpu")).contains("--help"));
    // The written file is recognised.
    let output = rhytid(&format!("info {usd}")).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        said.contains("animation of “demo") && said.contains("has no") && said.contains("velocities"),
        "{said}"
    );
}

#[test]
fn nothing_of_a_driver_looks_like_this_program() {
    let output = rhytid("devices").env_remove("XDG_RUNTIME_DIR").output().unwrap();
    let said = stderr(&output);
    assert!(output.status.success() && !said.contains("XDG_RUNTIME_DIR"), "{said}");
}

#[test]
fn a_solve_ends_with_how_near_it_is_to_its_scans() {
    let f = Fixture::new();
    let said = f.done("solve face.toml -o face.safetensors");
    assert!(said.contains("\nexamples differ from their scans by 0"), "{said}");
    assert!(!said.contains("ridge") && !said.contains("strain edges"), "{said}");
    let said = f.done("solve face.toml -o face.safetensors -v");
    let line = |name: &str| said.lines().find(|line| line.starts_with(name)).unwrap_or_default().to_owned();
    assert!(line("rest").contains("0 mm RMS, 0 mm at most (vertex "), "{said}");
    assert!(line("pinch").contains("0 mm RMS"), "{said}");
    assert!(said.contains("learned with share") && said.contains("strain edges"), "{said}");
}

#[test]
fn info_knows_every_table_and_report() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let demo = demo().display().to_string();
    let done = |command: &str| {
        let output = rhytid(command).output().unwrap();
        assert!(output.status.success(), "{command}: {}", stderr(&output));
        output.stdout
    };
    done(&format!("export-shapes {demo}/face.safetensors -o {}", at("shapes.usd")));
    std::fs::write(at("devices.json"), done("devices --json")).unwrap();
    std::fs::write(at("findings.json"), done(&format!("doctor {demo}/face.toml --json"))).unwrap();
    std::fs::write(at("info.json"), done(&format!("info {demo}/face.toml --json"))).unwrap();
    done(&format!(
        "coverage {demo}/face.safetensors {demo}/performance.csv --plan 1 --report {}",
        at("plan")
    ));
    done(&format!(
        "prepare {demo}/performance.csv --rig {demo}/face.safetensors -o {} --write-markers {} --report {}",
        at("clean.csv"),
        at("markers.csv"),
        at("report")
    ));
    std::fs::write(at("anna.toml"), "rate = 120\n[map]\nchin = \"M1\"\n").unwrap();
    std::fs::remove_file(at("plan/plan.html")).unwrap();
    for (file, expected) in [
        ("shapes.usd", "mesh with shapes, “shapes”"),
        ("devices.json", "report, devices"),
        ("findings.json", "report, findings of the doctor"),
        ("info.json", "report, description of a file"),
        ("plan/plan.json", "plan.html, which is written beside it"),
        ("report/report.json", "report, clean-up"),
        ("markers.csv", "table of markers"),
        ("anna.toml", "setup of a take"),
    ] {
        let said = String::from_utf8(done(&format!("info {}", at(file)))).unwrap();
        assert!(said.contains(expected), "{file}: {said}");
        let json: serde_json::Value =
            serde_json::from_slice(&done(&format!("info {} --json", at(file)))).unwrap();
        assert!(json["kind"].is_string() && json["file_bytes"].as_u64() > Some(0), "{json}");
    }
    std::fs::write(at("odd.json"), "{\"a\": 1}").unwrap();
    std::fs::write(at("odd.toml"), "a = 1").unwrap();
    for (file, expected) in
        [("odd.json", "none of Rhytid's reports; its keys are a"), ("odd.toml", "unknown field `a`")]
    {
        let output = rhytid(&format!("info {}", at(file))).output().unwrap();
        assert!(output.status.code() == Some(2) && stderr(&output).contains(expected), "{}", stderr(&output));
    }
}
