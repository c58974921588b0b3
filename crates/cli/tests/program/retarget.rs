//! `rhytid prepare` of another actor's take: markers of other names, poses, repairs by hand.
use crate::common::raw::{Raw, off, truth};
use crate::common::stderr;
use rhytid::Take;

/// The largest error of a marker in any frame, in millimetres, without the markers `but`.
fn worst(found: &Take, but: &[usize]) -> f64 {
    let truth = truth();
    let markers = (0..truth.labels.len()).filter(|m| !but.contains(m));
    markers
        .flat_map(|m| (0..truth.frames()).map(move |f| (m, f)))
        .map(|(m, f)| off(found, &truth, m, f))
        .fold(0.0, f64::max)
}

#[test]
fn markers_of_other_names_are_matched_and_written_as_a_table_that_can_be_edited() {
    let mut raw = Raw::new();
    let names = raw.labels.clone();
    for (i, label) in raw.labels.iter_mut().enumerate() {
        *label = format!("M{i:03}");
    }
    raw.write(&|_, _, x| Some(x));
    let table = raw.path("markers.csv");
    let (_, warned, report) = raw.prepared(&format!("--write-markers {}", table.display()));
    assert!(warned.contains("0 of the rig's 89 handles have a marker of their name; "), "{warned}");
    assert!(warned.contains("(see `rhytid prepare --write-markers TABLE.csv`, "), "{warned}");
    let text = std::fs::read_to_string(&table).unwrap();
    let mut rows: Vec<Vec<String>> =
        text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect();
    let own = |row: &[String]| format!("M{:03}", names.iter().position(|name| *name == row[0]).unwrap());
    let right = rows.iter().filter(|row| row[1] == own(row)).count();
    println!("{right} of {} markers matched by position", rows.len());
    assert!(
        text.starts_with("handle,marker,distance_mm,sure\n") && rows.len() == 89 && right >= 85,
        "{text}"
    );
    assert_eq!(report["setup"]["markers"].as_array().unwrap().len(), 89);
    // With the edited table the result is the truth. The table is given on the command line, or in TAKE.toml
    // with a path relative to it.
    let lost = 7;
    for (i, row) in rows.iter_mut().enumerate() {
        row[1] = if i == lost { String::new() } else { own(row) };
    }
    let edited: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
    std::fs::write(&table, format!("handle,marker,distance_mm,sure\n{}\n", edited.join("\n"))).unwrap();
    let (take, warned, _) = raw.prepared(&format!("--markers {}", table.display()));
    assert!(
        !warned.contains("matched by position") && worst(&take, &[lost]) < 0.5,
        "{} {warned}",
        worst(&take, &[lost])
    );
    std::fs::write(raw.path("anna.toml"), "markers = \"markers.csv\"\n").unwrap();
    let (again, _, _) = raw.prepared(&format!("--setup {}", raw.path("anna.toml").display()));
    assert_eq!(take, again);
    std::fs::write(&table, "handle;marker\n").unwrap();
    let output = raw.prepare(&format!("--markers {}", table.display()));
    assert!(
        output.status.code() == Some(2) && stderr(&output).contains("markers.csv, line 1"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn repairs_and_poses_are_given_on_the_line_and_in_the_setup() {
    let raw = Raw::new();
    let truth = truth();
    raw.write(&|j, f, [x, y, z]| {
        Some(if j == 5 && (60..80).contains(&f) { [x, y, z + 60.0] } else { [x, y, z] })
    });
    let [wrong, right] = ["", "--drop"].map(|drop| {
        let drop = if drop.is_empty() { String::new() } else { format!("--drop {}:60..80", truth.labels[5]) };
        raw.prepared(&format!("--skip slides,outliers {drop}")).0
    });
    let at = |take: &Take| (60..80).map(|f| off(take, &truth, 5, f)).fold(0.0, f64::max);
    assert!(at(&wrong) > 40.0 && at(&right) < 6.0, "{} {}", at(&wrong), at(&right));
    let setup = raw.path("anna.toml");
    std::fs::write(
        &setup,
        format!("drop = [\"{}:60..80\"]\nskip = [\"slides\", \"outliers\"]\n", truth.labels[5]),
    )
    .unwrap();
    let (same, _, report) = raw.prepared(&format!("--setup {}", setup.display()));
    assert_eq!(same, right);
    assert_eq!(report["summary"]["events"]["dropped"], 1);
    for (options, expected) in [
        ("--drop nobody:3..5", "drop names “nobody”, which is neither a handle"),
        ("--hold chin:900..", "hold from frame 900, but the take has frames"),
        ("--pose nothing=3", "a pose is named “nothing”, which is no example of the rig; it has "),
        ("--filter some", "expected none, or a cut-off in Hz"),
        ("--swap a:3..5", "expected A,B:FROM..TO"),
    ] {
        let options = options.replace("chin", &truth.labels[5]);
        let output = raw.prepare(&options);
        assert!(
            output.status.code() == Some(2) && stderr(&output).contains(expected),
            "{options}: {}",
            stderr(&output)
        );
    }
}
