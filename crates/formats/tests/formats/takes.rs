//! Takes as CSV: what is read, and what every mistake is called.
use proptest::prelude::*;
use rhytid_core::{Error, InputErrorKind, RawTake, Result, Take};
use rhytid_formats::take::{Missing, decode, read, write};
use std::path::Path;

const HEADER: &str = "time,brow_x,brow_y,brow_z,lip_up_x,lip_up_y,lip_up_z\n";

fn take(text: &str, missing: Missing) -> Result<Take> {
    decode(text.as_bytes(), "take.csv", None, missing)
}

fn wanting(text: &str, wanted: &[&str]) -> Result<Take> {
    let wanted: Vec<String> = wanted.iter().map(|&label| label.to_owned()).collect();
    decode(text.as_bytes(), "take.csv", Some(&wanted), Missing::Error)
}

fn sentence(result: Result<Take>) -> String {
    match result {
        Err(Error::Input(sentence)) => sentence.to_string(),
        other => panic!("expected an input error, found {other:?}"),
    }
}

fn two_frames() -> Take {
    Take {
        labels: vec!["brow".into(), "lip_up".into()],
        times: vec![0.0, 0.5],
        positions: vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [-1.5, 2e-3, 3.25], [0.1, -5.0, 1e3]],
        ..Take::default()
    }
}

#[test]
fn takes_of_every_style_are_the_same() {
    for text in [
        format!("{HEADER}0,1,2,3,4,5,6\n0.5,-1.5,2e-3,3.25,.1,-5,1e3\n"),
        format!("\u{feff}{HEADER}0,1,2,3,4,5,6\n\n0.5,-1.5,+0.002,3.25,0.1,-5.,1000").replace('\n', "\r\n"),
        "brow_z , brow_x,lip_up_y,brow_y,lip_up_x,lip_up_z,time\n\
         3,1,5,2,4,6, 0.0\n 3.25 ,-1.5,-5,\"2e-3\",0.1,1e3,0.5\n"
            .to_owned(),
    ] {
        assert_eq!(take(&text, Missing::Error).unwrap(), two_frames(), "{text:?}");
        assert_eq!(wanting(&text, &["brow", "lip_up"]).unwrap(), two_frames(), "{text:?}");
    }
}

#[test]
fn wanted_labels_give_the_order_and_nothing_else_is_looked_at() {
    let text = "frame,time,b_x,b_y,b_z,odd_x,a_x,a_y,a_z,odd_x\n7,0,1,2,3,?,4,5,6,\n";
    let found = wanting(text, &["a", "b"]).unwrap();
    assert_eq!(found.labels, ["a", "b"]);
    assert_eq!(found.positions, [[4.0, 5.0, 6.0], [1.0, 2.0, 3.0]]);
    assert_eq!(wanting(text, &["b"]).unwrap().positions, [[1.0, 2.0, 3.0]]);
}

#[test]
fn mistakes_in_the_header_are_named() {
    for (text, expected) in [
        ("", "take.csv: the file is empty, expected a header and rows"),
        (
            "Time,a_x,a_y,a_z\n0,1,2,3\n",
            "take.csv, line 1: column 1 of the header is \"Time\", expected time, LABEL_x, LABEL_y or LABEL_z; \
             leave out what is none of them",
        ),
        (
            "a_x,a_y,a_z\n1,2,3\n",
            "take.csv, line 1: the header has no column \"time\", expected time,LABEL_x,LABEL_y,LABEL_z,…",
        ),
        (
            "time,a_x,a_y,a_z,a_x\n0,1,2,3,4\n",
            "take.csv, line 1: the columns 2 and 5 of the header are both \"a_x\"; keep one of them",
        ),
        (
            "time,a_x,a_y,a_z,time\n0,1,2,3,4\n",
            "take.csv, line 1: the columns 1 and 5 of the header are both \"time\"; keep one of them",
        ),
        (
            "time,a_x,a_y,a_z,b_x,b_z\n0,1,2,3,4,5\n",
            "take.csv, line 1: 1 of the 2 labels have columns missing from the header: \"b\" (lacks \"b_y\"); \
             each needs its columns LABEL_x, LABEL_y and LABEL_z",
        ),
        (
            "time,_x,_y,_z\n0,1,2,3\n",
            "take.csv, line 1: column 2 of the header is \"_x\", expected time, LABEL_x, LABEL_y or LABEL_z; \
             leave out what is none of them",
        ),
        (
            "time\n0\n",
            "take.csv, line 1: the header has no markers, expected LABEL_x,LABEL_y,LABEL_z for each",
        ),
        ("time,a_x,a_y,a_z\n", "take.csv: has no frames, expected a row for each under the header"),
    ] {
        assert_eq!(sentence(take(text, Missing::Error)), expected, "{text:?}");
    }
    assert_eq!(
        sentence(wanting("Time,a_x,a_y,a_z\n0,1,2,3\n", &["a"])),
        "take.csv, line 1: the header has no column \"time\" (did you mean \"Time\"?), \
         expected time,LABEL_x,LABEL_y,LABEL_z,…"
    );
}

#[test]
fn every_missing_handle_is_named() {
    let text = format!("{HEADER}0,1,2,3,4,5,6\n").replace("brow_y", "brow_Y");
    assert_eq!(
        sentence(wanting(&text, &["lip_up", "brow", "Lip_Upp", "elbow"])),
        "take.csv, line 1: 3 of the 4 handles are missing from the header: \"brow\" (lacks \"brow_y\"), \
         \"Lip_Upp\" (did you mean \"lip_up\"?), \"elbow\"; each needs its columns LABEL_x, LABEL_y and LABEL_z"
    );
    let many: Vec<String> = (0..50).map(|i| format!("missing-handle-{i:02}")).collect();
    let found = sentence(decode(text.as_bytes(), "take.csv", Some(&many), Missing::Hold));
    assert!(many.iter().all(|label| found.contains(label)), "{found}");
}

#[test]
fn mistakes_in_a_frame_are_named_by_frame_and_line() {
    let good = "0,1,2,3,4,5,6\n";
    for (rows, expected) in [
        (
            "1,1,2,3,4,5\n",
            "take.csv, line 3: the row's number of cells is 6, expected 7 as in the header; the file may be cut short",
        ),
        (
            "1,1,2,3,4,5,6,\n",
            "take.csv, line 3: the row's number of cells is 8, expected 7 as in the header; the file may be cut short",
        ),
        (
            "0,1,2,3,4,5,6\n",
            "take.csv, line 3: frame 1: the time 0 does not come after the 0 of the frame before; \
             times must increase",
        ),
        (
            "\n1,1,2,3,4,5,6\n0.5,1,2,3,4,5,6\n",
            "take.csv, line 5: frame 2: the time 0.5 does not come after the 1 of the frame before; \
             times must increase",
        ),
        (",1,2,3,4,5,6\n", "take.csv, line 3: frame 1: the time is empty, expected a number of seconds"),
        ("inf,1,2,3,4,5,6\n", "take.csv, line 3: frame 1: the time is \"inf\", expected a number of seconds"),
        (
            "0:01,1,2,3,4,5,6\n",
            "take.csv, line 3: frame 1: the time is \"0:01\", expected a number of seconds",
        ),
        (
            "1,1,2,-4e38,4,5,6\n",
            "take.csv, line 3: frame 1: \"brow_z\" of marker \"brow\" is \"-4e38\", \
             expected a number in mesh units, below 3.4e38",
        ),
        (
            "1,1,2,3,4,5 mm,6\n",
            "take.csv, line 3: frame 1: \"lip_up_y\" of marker \"lip_up\" is \"5 mm\", \
             expected a number in mesh units, below 3.4e38",
        ),
    ] {
        for missing in [Missing::Error, Missing::Hold] {
            assert_eq!(sentence(take(&format!("{HEADER}{good}{rows}"), missing)), expected, "{rows:?}");
        }
    }
    for gap in ["", " ", "NaN", "-inf", "1e999"] {
        let shown = if gap.trim().is_empty() { "empty".to_owned() } else { format!("{gap:?}") };
        assert_eq!(
            sentence(take(&format!("{HEADER}{good}1,1,2,3,4,{gap},6\n"), Missing::Error)),
            format!(
                "take.csv, line 3: frame 1: marker \"lip_up\" is missing: \"lip_up_y\" is {shown}, \
                 expected a finite number; it can be held where it was last seen"
            )
        );
    }
}

#[test]
fn gaps_are_held_and_leading_gaps_take_the_first_sighting() {
    // `brow` is missing in frames 0, 1 and 3 to 4; a marker is missing as a whole if one cell is.
    let text = "time,brow_x,brow_y,brow_z,lip_up_x,lip_up_y,lip_up_z\n\
                0,,,,1,1,1\n1,9,NaN,9,2,2,2\n2,5,6,7,,2,2\n3,,8,8,4,4,4\n4,,,,5,5,inf\n5,8,8,8,6,6,6\n";
    let found = take(text, Missing::Hold).unwrap();
    let brow: Vec<[f64; 3]> = found.positions.iter().step_by(2).copied().collect();
    let lip: Vec<[f64; 3]> = found.positions.iter().skip(1).step_by(2).copied().collect();
    let seen = [5.0, 6.0, 7.0];
    assert_eq!(brow, [seen, seen, seen, seen, seen, [8.0; 3]]);
    assert_eq!(lip, [[1.0; 3], [2.0; 3], [2.0; 3], [4.0; 3], [4.0; 3], [6.0; 3]]);
}

#[test]
fn a_marker_that_is_never_seen_cannot_be_held() {
    let text = format!("{HEADER}0,1,2,3,4,5,\n1,1,2,3,,5,6\n");
    assert_eq!(
        sentence(take(&text, Missing::Hold)),
        "take.csv: missing from every frame: \"lip_up\"; a marker must be seen at least once to be held"
    );
}

#[test]
fn takes_that_would_not_read_back_are_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.csv");
    let change = |edit: fn(&mut Take)| {
        let mut take = two_frames();
        edit(&mut take);
        take
    };
    for (bad, words) in [
        (change(|t| t.positions[3][1] = f64::NAN), "frame 1: marker \"lip_up\" is at ["),
        (change(|t| t.positions[3][1] = f64::INFINITY), "frame 1: marker \"lip_up\" is at ["),
        (change(|t| t.times[1] = 0.0), "times must increase"),
        (change(|t| t.labels[1] = "brow".into()), "are both \"brow_x\""),
        (change(|t| t.labels[1] = " lip".into()), "begin or end with a blank"),
        (change(|t| t.labels[1] = String::new()), "expected time, LABEL_x"),
        (change(|t| t.positions.truncate(3)), "3 positions, expected 2 frames × 2 labels"),
        (Take::default(), "0 positions, expected 0 frames × 0 labels, at least one of each"),
        (Take { labels: vec!["a".into()], ..Take::default() }, "has no frames"),
    ] {
        let found = sentence(write(&path, &bad).map(|()| bad));
        assert!(found.contains("not written") && found.contains(words), "{found}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

#[test]
fn a_missing_marker_has_empty_cells() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.csv");
    let mut take = two_frames();
    take.positions[3] = RawTake::MISSING;
    write(&path, &take).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.lines().nth(2).unwrap().ends_with(",,,"), "{text}");
    let back = read(&path, None, Missing::Leave).unwrap();
    assert!(back.positions[3].iter().all(|x| x.is_nan()) && back.positions[..3] == take.positions[..3]);
}

#[test]
fn files_that_cannot_be_reached_are_named() {
    let path = Path::new("no/such/take.csv");
    assert!(matches!(read(path, None, Missing::Error), Err(Error::Io { path: p, .. }) if p == path));
    let found = sentence(write(path, &two_frames()).map(|()| two_frames()));
    assert!(found.contains("no/such does not exist"), "{found}");
}

fn finite() -> impl Strategy<Value = f64> {
    use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    let any = NEGATIVE | POSITIVE | NORMAL | SUBNORMAL | ZERO;
    // What fits into the f32 of the runtime.
    let fitting = any.prop_map(|x| if x.abs() > f64::from(f32::MAX) { 1.0 / x } else { x });
    prop_oneof![fitting, -100.0..100.0]
}

fn any_take() -> impl Strategy<Value = Take> {
    let label = "[a-zé\"]([a-z_ ,\"]{0,6}[a-z_\"])?";
    let times = proptest::collection::btree_set(any::<i32>(), 1..6);
    (proptest::collection::btree_set(label, 1..5), times, 1e-9..1e3).prop_flat_map(|(labels, times, step)| {
        let (labels, times): (Vec<String>, Vec<f64>) =
            (labels.into_iter().collect(), times.into_iter().map(|t| f64::from(t) * step).collect());
        let position = [finite(), finite(), finite()];
        proptest::collection::vec(position, labels.len() * times.len()).prop_map(move |positions| Take {
            labels: labels.clone(),
            times: times.clone(),
            positions,
            ..Take::default()
        })
    })
}

fn bits(take: &Take) -> Vec<u64> {
    take.times.iter().chain(take.positions.as_flattened()).map(|x| x.to_bits()).collect()
}

/// CSV of a take with its columns in the order that `keys` sort them into; `None` is an empty cell.
fn to_csv(take: &Take, seen: impl Fn(usize, usize) -> bool, keys: &[u32]) -> String {
    let m = take.labels.len();
    let mut columns = vec![(0, "time".to_owned(), take.times.iter().map(f64::to_string).collect::<Vec<_>>())];
    for (j, label) in take.labels.iter().enumerate() {
        for (axis, suffix) in ["x", "y", "z"].into_iter().enumerate() {
            let cell = |frame: usize| {
                if seen(frame, j) { take.positions[frame * m + j][axis].to_string() } else { String::new() }
            };
            columns.push((0, format!("{label}_{suffix}"), (0..take.frames()).map(cell).collect()));
        }
    }
    for (column, key) in columns.iter_mut().zip(keys.iter().cycle()) {
        column.0 = *key;
    }
    columns.sort();
    let mut csv = csv::Writer::from_writer(Vec::new());
    csv.write_record(columns.iter().map(|(_, name, _)| name)).unwrap();
    for frame in 0..take.frames() {
        csv.write_record(columns.iter().map(|(_, _, cells)| &cells[frame])).unwrap();
    }
    String::from_utf8(csv.into_inner().unwrap()).unwrap()
}

proptest! {
    #[test]
    fn writing_and_reading_keeps_every_bit(take in any_take()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        write(&path, &take).unwrap();
        let found = read(&path, None, Missing::Error).unwrap();
        prop_assert_eq!(&found.labels, &take.labels);
        prop_assert_eq!(bits(&found), bits(&take));
    }

    #[test]
    fn the_order_of_columns_does_not_matter(
        take in any_take(),
        keys in proptest::collection::vec(any::<u32>(), 16),
    ) {
        let text = to_csv(&take, |_, _| true, &keys);
        let found = decode(text.as_bytes(), "t.csv", Some(&take.labels), Missing::Error).unwrap();
        prop_assert_eq!(&found.labels, &take.labels);
        prop_assert_eq!(bits(&found), bits(&take));
    }

    #[test]
    fn holding_agrees_with_looking_back_then_ahead(
        take in any_take(),
        pattern in proptest::collection::vec(any::<bool>(), 30),
    ) {
        let m = take.labels.len();
        let seen = |frame: usize, j: usize| pattern[frame * m + j];
        let text = to_csv(&take, seen, &[0]);
        let held = decode(text.as_bytes(), "t.csv", Some(&take.labels), Missing::Hold);
        let frames = take.frames();
        let source = |frame: usize, j: usize| {
            (0..=frame).rev().find(|&f| seen(f, j)).or_else(|| (frame..frames).find(|&f| seen(f, j)))
        };
        let all_seen = (0..m).all(|j| source(0, j).is_some());
        prop_assert_eq!(held.is_ok(), all_seen);
        if let Ok(held) = held {
            for frame in 0..frames {
                for j in 0..m {
                    let expected = take.positions[source(frame, j).unwrap() * m + j];
                    prop_assert_eq!(held.positions[frame * m + j], expected, "frame {} label {}", frame, j);
                }
            }
        }
        let no_gaps = (0..frames * m).all(|i| pattern[i]);
        let strict = decode(text.as_bytes(), "t.csv", None, Missing::Error);
        prop_assert_eq!(strict.is_ok(), no_gaps);
    }

    #[test]
    fn any_bytes_give_a_whole_take_or_a_named_error(
        bytes in prop_oneof![
            proptest::collection::vec(any::<u8>(), 0..200),
            proptest::collection::vec(
                proptest::sample::select(vec![
                    "time", "a_x", "a_y", "a_z", "b_x", ",", ",", ",", "\n", "\r\n", "\"", "0", "1", "2.5",
                    "NaN", "inf", "-", "\u{feff}", " ", "time,a_x,a_y,a_z\n", "1,2,3,4\n",
                ]),
                0..60,
            ).prop_map(|pieces| pieces.concat().into_bytes()),
        ],
        hold in any::<bool>(),
        choose in any::<bool>(),
    ) {
        let wanted = ["a".to_owned()];
        let missing = if hold { Missing::Hold } else { Missing::Error };
        match decode(&bytes, "t.csv", choose.then_some(&wanted[..]), missing) {
            Ok(take) => {
                prop_assert!(take.frames() > 0 && !take.labels.is_empty());
                prop_assert_eq!(take.positions.len(), take.frames() * take.labels.len());
                prop_assert!(take.positions.as_flattened().iter().all(|x| x.is_finite()));
                prop_assert!(take.times.windows(2).all(|w| w[0] < w[1]));
            }
            Err(error) => prop_assert!(error.to_string().starts_with("t.csv"), "{}", error),
        }
    }
}

#[test]
fn programs_learn_what_is_wrong_of_a_take() {
    let kind = |text: &str, missing| take(text, missing).unwrap_err().input_kind().unwrap().clone();
    let lacks = wanting("time,brow_x,brow_y,brow_z\n0,1,2,3\n", &["brow", "lip_up"]).unwrap_err();
    let missing = InputErrorKind::MissingMarkers { labels: vec!["lip_up".into()] };
    assert_eq!(lacks.input_kind(), Some(&missing));
    let gap = format!("{HEADER}0,1,2,3,4,5,\n");
    assert_eq!(kind(&gap, Missing::Error), InputErrorKind::MissingSamples);
    assert_eq!(kind(&gap, Missing::Hold), InputErrorKind::MissingSamples);
    assert_eq!(kind(HEADER, Missing::Error), InputErrorKind::Empty);
    let wrong = kind(&format!("{HEADER}0,1,2,3,4,five,6\n"), Missing::Error);
    assert_eq!(wrong, InputErrorKind::Malformed { line: Some(2) });
}
