//! `rhytid handles` and `rhytid new`: on the demo's face, whose handles are known, and on an unprepared head.

use crate::common::raw::Raw;
use crate::common::{demo, rhytid, stderr};
use rhytid::formats::{mesh, tables};
use std::path::Path;

/// The demo's project without its table of handles.
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
    let output = rhytid(&format!("handles {face} {take} --frame 0 --allow-elsewhere")).output().unwrap();
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
        .points
        .iter()
        .zip(&known.points)
        .map(|(a, b)| {
            let [a, b] = [a, b].map(|point| point.at(&rest));
            10.0 * (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
        })
        .collect();
    off.sort_by(f64::total_cmp);
    assert!(off[off.len() / 2] < 3.0 && off[off.len() * 9 / 10] < 6.0, "{off:?}");

    // An existing table is not overwritten, and mistakes are named.
    let refused = |command: &str, expected: &str| {
        let output = rhytid(&format!("handles {command} --allow-elsewhere")).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{command}");
        assert!(stderr(&output).contains(expected), "{command}: {}", stderr(&output));
    };
    refused(&format!("{face} {take}"), "markers.csv: is there already; name another table with -o");
    let other = raw.path("other.csv").display().to_string();
    refused(&format!("{face} {take} -o {other} --at nobody=3"), "no marker of the take is called “nobody”");
    refused(&format!("{face} {take} -o {other} --frame 100000"), "the frame 100000 is not in the take");
    refused(&format!("{face} {take} -o {other} --at x=y"), "expected LABEL=VERTEX");
    // The advice for a file without a rate and times can be followed.
    let text = std::fs::read_to_string(raw.path("raw.trc")).unwrap();
    let (head, frames) = text.split_once("\n\n").unwrap();
    let head = head.replace("\n30\t30\t", "\n0\t0\t");
    let frames = frames.lines().map(|line| {
        let mut cells: Vec<&str> = line.split('\t').collect();
        cells[1] = "";
        cells.join("\t")
    });
    let text = format!("{head}\n\n{}\n", frames.collect::<Vec<_>>().join("\n"));
    std::fs::write(raw.path("raw.trc"), text).unwrap();
    refused(
        &format!("{face} {take} -o {other}"),
        "gives no frame rate; give it with the file, or as `rate` in the take's TOML file (see --take-rate N, or --rate N of `rhytid handles` and `rhytid prepare`)",
    );
    assert!(!raw.path("other.csv").exists() && !raw.path("other.png").exists());
    let output = rhytid(&format!("handles {face} {take} -o {other} --frame 0 --rate 30 --allow-elsewhere"));
    assert!({ output }.output().unwrap().status.success());
    let [first, second] =
        ["markers.csv", "other.csv"].map(|name| tables::read_handles(&raw.path(name)).unwrap());
    assert_eq!(first, second);
}

#[test]
fn a_bad_fit_is_refused_by_new_and_told_by_handles_in_the_same_words() {
    let raw = Raw::new();
    // Each marker is off by 25 mm, all in directions of their own.
    raw.write(&|j, _, x| {
        let (angle, z) = (2.4 * j as f64, (0.7 * j as f64).sin());
        let flat = (1.0 - z * z).sqrt();
        let off = [flat * angle.cos(), flat * angle.sin(), z];
        Some([0, 1, 2].map(|c| x[c] + if j < raw.labels.len() - 4 { 25.0 * off[c] } else { 0.0 }))
    });
    let [take, made] = ["raw.trc", "made"].map(|name| raw.path(name).display().to_string());
    let neutral = demo().join("neutral.obj").display().to_string();
    let new = format!("new {neutral} --examples {}/poses --take {take} -o {made}", demo().display());
    let output = rhytid(&new).output().unwrap();
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    let bad = |text: &str| {
        let start = text.find("the markers fit the mesh badly").unwrap_or_else(|| panic!("{text}"));
        text[start..].split("; look at").next().unwrap().to_owned()
    };
    let words = bad(&said);
    assert!(words.contains("expected at most"), "{words}");
    assert!(said.contains(&format!("rhytid new {neutral} --take {take} -o {made}")), "{said}");
    let at = "--frame N --at LABEL=VERTEX --at LABEL=VERTEX --at LABEL=VERTEX";
    assert!(said.contains(at), "{said}");
    for (name, is_there) in
        [("face.toml", false), ("markers.csv", false), ("markers.png", false), ("misfit.png", true)]
    {
        assert_eq!(Path::new(&made).join(name).exists(), is_there, "{name}");
    }
    // The same words are a warning of the other command.
    project(raw.folder.path());
    let face = raw.path("face.toml").display().to_string();
    let output = rhytid(&format!("handles {face} {take} --allow-elsewhere")).output().unwrap();
    let said = stderr(&output);
    assert!(output.status.success() && said.contains("warning: "), "{said}");
    assert_eq!(bad(&said), words);
    assert!(said.contains(&format!("rhytid handles {face} {take} -o ")) && said.contains(at), "{said}");
    // With three vertices the take is taken as it is.
    let handles = tables::read_handles(&demo().join("markers.csv")).unwrap();
    let known = (0..3).map(|i| {
        let h = i * (handles.labels.len() / 3);
        format!(" --at {}={}", handles.labels[h], handles.points[h].nearest_vertex().0)
    });
    let output = rhytid(&format!("{new}{}", known.collect::<String>())).output().unwrap();
    assert!(output.status.success() && stderr(&output).contains("fit the mesh badly"), "{}", stderr(&output));
    assert!(Path::new(&made).join("face.toml").is_file());
    // Options about a take need one.
    let lone = raw.path("lone");
    std::fs::create_dir(&lone).unwrap();
    std::fs::copy(demo().join("neutral.obj"), lone.join("neutral.obj")).unwrap();
    let output = rhytid(&format!("new {} --frame 3", lone.join("neutral.obj").display())).output().unwrap();
    assert!(output.status.code() == Some(2) && stderr(&output).contains("there is no take beside it"));
    // The command that helps has the other options.
    let again = new.replace(&made, &raw.path("again").display().to_string());
    let said = stderr(&rhytid(&format!("{again} --unit cm --rate 30")).output().unwrap());
    assert!(said.contains(&format!(" --unit cm --rate 30 {at}")), "{said}");
    // A take that does not fit is named where another one fits.
    std::fs::copy(raw.path("raw.trc"), lone.join("bad.trc")).unwrap();
    std::fs::copy(demo().join("performance.csv"), lone.join("good.csv")).unwrap();
    let output = rhytid(&format!("new {}", lone.join("neutral.obj").display())).output().unwrap();
    let said = stderr(&output);
    assert!(output.status.success() && said.contains("bad.trc: is passed over: the markers fit"), "{said}");
}

#[test]
fn handles_are_spread_evenly_on_both_sides() {
    let raw = Raw::new();
    project(raw.folder.path());
    let [face, table] = ["face.toml", "spread.csv"].map(|name| raw.path(name).display().to_string());
    let output = rhytid(&format!("handles {face} --count 40 -o {table} --at tip=7 --allow-elsewhere"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let handles = tables::read_handles(Path::new(&table)).unwrap();
    assert!((40..=41).contains(&handles.labels.len()), "{}", handles.labels.len());
    assert_eq!((handles.labels[0].as_str(), handles.points[0].nearest_vertex().0), ("tip", 7));
    let sides = |side: &str| handles.labels.iter().filter(|label| label.ends_with(side)).count();
    assert_eq!(sides("_l"), sides("_r"), "as many left as right: {:?}", handles.labels);
    // The handles are spread evenly: none is nearer to another than a third of the usual distance. Two
    // handles with the mouth between them are an exception.
    let rest = mesh::read(&demo().join("neutral.obj")).unwrap().positions;
    let at = |h: usize| handles.points[h].at(&rest);
    let apart = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
    let count = handles.labels.len();
    let mut nearest: Vec<f64> = (0..count)
        .map(|a| (0..count).filter(|b| *b != a).map(|b| apart(at(a), at(b))).fold(f64::INFINITY, f64::min))
        .collect();
    nearest.sort_by(f64::total_cmp);
    assert!(nearest[2] > nearest[count / 2] / 3.0, "{nearest:?}");
}

/// Runs the command, which must succeed, and returns its standard output.
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
    assert!(said.contains("cm, Y up") && said.contains("other.obj: has 3 vertices, but"), "{said}");
    // Its last lines are the next commands, and they work.
    let next = said.lines().filter_map(|line| line.trim().strip_prefix("rhytid "));
    let next: Vec<&str> = next.filter(|command| !command.starts_with("view ")).collect();
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

/// The largest distance of a vertex from rest, that of a marker, and the largest jump of a vertex between
/// frames, in millimetres.
fn reach(usd: &Path, neutral: &Path, table: &Path) -> [f32; 3] {
    let rest = mesh::read(neutral).unwrap().positions;
    let handles = tables::read_handles(table).unwrap();
    let mut reader = rhytid::formats::animation::open(usd).unwrap();
    let apart = |a: [f32; 3], b: [f32; 3]| 100.0 * (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt();
    let (mut now, mut before): (Vec<f32>, Vec<f32>) = (Vec::new(), Vec::new());
    let (mut farthest, mut marker, mut jump) = (0.0_f32, 0.0_f32, 0.0_f32);
    for frame in 0..reader.summary().frames {
        reader.positions(frame, &mut now).unwrap();
        let points = now.as_chunks::<3>().0;
        let from_rest = |v: usize| apart(points[v], rest[v].map(|c| c as f32));
        farthest = (0..points.len()).map(from_rest).fold(farthest, f32::max);
        marker = handles
            .points
            .iter()
            .map(|point| from_rest(point.nearest_vertex().index()))
            .fold(marker, f32::max);
        for (x, y) in points.iter().zip(before.as_chunks::<3>().0) {
            jump = jump.max(apart(*x, *y));
        }
        std::mem::swap(&mut now, &mut before);
    }
    [farthest, marker, jump]
}

/// The shared capture with `count` markers of its face and its cap.
/// The markers are spread well and have other names. From frame 1500 on the label of the lips' middle slides
/// to the next marker for 0.4 s, and snaps back.
fn fewer_markers(trc: &str, count: usize) -> String {
    let lines: Vec<Vec<&str>> = trc.lines().map(|line| line.trim_end().split('\t').collect()).collect();
    let labels: Vec<&str> = lines[3][2..].iter().copied().filter(|label| !label.is_empty()).collect();
    let first = lines.iter().position(|line| line[0].parse::<usize>().is_ok() && line.len() > 20).unwrap();
    let at = |f: usize, m: usize| -> Option<[f64; 3]> {
        let cell = |c: usize| lines.get(first + f)?.get(2 + 3 * m + c)?.parse::<f64>().ok();
        Some([cell(0)?, cell(1)?, cell(2)?])
    };
    let apart = |a: usize, b: usize| match (at(30, a), at(30, b)) {
        (Some(a), Some(b)) => (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>(),
        _ => 0.0,
    };
    let place = |name: &str| labels.iter().position(|label| *label == name).unwrap();
    let face: Vec<usize> = (0..labels.len()).filter(|&m| !labels[m].starts_with("head")).collect();
    let mut kept = vec![place("mp53")];
    while kept.len() < count {
        let near = |m: usize| kept.iter().map(|&k| apart(m, k)).fold(f64::INFINITY, f64::min);
        kept.push(face.iter().copied().max_by(|&a, &b| near(a).total_cmp(&near(b))).unwrap());
    }
    let to =
        kept[1..].iter().copied().min_by(|&a, &b| apart(kept[0], a).total_cmp(&apart(kept[0], b))).unwrap();
    let columns: Vec<usize> =
        kept.iter().copied().chain((0..4).map(|i| place(&format!("head{i}")))).collect();
    let name = |i: usize| if i < count { format!("M{i:02}") } else { labels[columns[i]].to_owned() };
    let names: Vec<String> = (0..columns.len()).map(name).collect();
    let values = lines[2].join("\t").replace("\t93\t", &format!("\t{}\t", columns.len()));
    let mut out = format!(
        "{}\n{}\n{values}\nFrame#\tTime\t{}\n\n",
        lines[0].join("\t"),
        lines[1].join("\t"),
        names.join("\t\t\t")
    );
    for (f, line) in lines[first..].iter().enumerate() {
        out += &line[..2].join("\t");
        for (i, &m) in columns.iter().enumerate() {
            let slid = match (at(f, m), at(f, to)) {
                (Some(a), Some(b)) if i == 0 && (1500..1548).contains(&f) => {
                    let s = (f - 1499) as f64 / 48.0;
                    Some([0, 1, 2].map(|c| a[c] + s * (b[c] - a[c])))
                }
                (a, _) => a,
            };
            out += &slid.map_or("\t\t\t".into(), |[x, y, z]| format!("\t{x:.5}\t{y:.5}\t{z:.5}"));
        }
        out.push('\n');
    }
    out
}

#[test]
fn another_actors_capture_animates_a_head_that_nobody_prepared() {
    let Some(shared) = rhytid_test_support::shared("data") else { return };
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let neutral = shared.join("makehuman/neutral.obj");
    let whole = std::fs::read_to_string(shared.join("takes/rom_3_raw.trc")).unwrap();
    let c3d = shared.join("takes/rom_3_raw.c3d").display().to_string();
    for (markers, frames) in [(89, ".."), (53, "1450..1650"), (31, "1450..1650")] {
        let take = if markers == 89 { c3d.clone() } else { at(&format!("{markers}.trc")) };
        if markers < 89 {
            std::fs::write(&take, fewer_markers(&whole, markers)).unwrap();
        }
        let face = at(&format!("face{markers}"));
        let said = done(&format!("new {} --take {take} -o {face}", neutral.display()));
        assert!(
            said.contains("0.1, Y up: the head is ")
                && said.contains(" cm wide, ")
                && said.contains(&format!("{markers}, from")),
            "{said}"
        );
        done(&format!("solve {face}/face.toml --allow-elsewhere -o {face}/face.safetensors"));
        let animate = format!("animate {face}/face.safetensors {take} -o {face}/face.usd --device cpu");
        let output = rhytid(&format!("{animate} --frames {frames}")).output().unwrap();
        let warned = stderr(&output);
        assert!(output.status.success(), "{warned}");
        assert_eq!(warned.contains("a label slid off its marker"), markers < 89, "{warned}");
        let face = Path::new(&face);
        let [farthest, marker, jump] = reach(&face.join("face.usd"), &neutral, &face.join("markers.csv"));
        println!(
            "{markers} markers: farthest {farthest:.1} mm, the markers {marker:.1}; jumps by {jump:.1} mm"
        );
        // No spike: no vertex goes more than half as far again as the farthest marker. None jumps between two
        // frames at 120 Hz.
        assert!(farthest < 1.5 * marker && jump < 4.0, "{markers}: {farthest}, {marker}, {jump}");
    }
}
