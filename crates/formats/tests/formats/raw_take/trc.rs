//! TRC files: as they should be, as programs write them, and wrong.
use super::{has_no_rate, is_missing, read, refused, warns};
use rhytid_formats::raw_take::decode;

const NAME: &str = "trial.trc";

/// A file of a rate, a promise of frames and markers, a unit, a line of labels and rows.
fn file(rate: &str, counts: &str, unit: &str, labels: &str, rows: &str) -> String {
    format!(
        "PathFileType\t4\t(X/Y/Z)\t{NAME}\n\
         DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n\
         {rate}\t{rate}\t{counts}\t{unit}\t{rate}\t1\t3\nFrame#\tTime\t{labels}\n\
         \t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n{rows}"
    )
}

const LABELS: &str = "jaw00\t\t\tActor:lip\t\t";
const ROWS: &str =
    "1\t0.000\t1\t2\t3\t4\t5\t6\n2\t0.017\t1.5\t2\t3\t\t\t\n3\t0.033\tNaN\tNaN\tNaN\t7\t8\t9e0\n";

#[test]
fn a_file_is_read_by_its_keys() {
    let text = file("60", "3\t2", "cm", LABELS, ROWS);
    let take = read(text.as_bytes(), NAME);
    assert_eq!(take.warnings, [""; 0]);
    assert_eq!(take.metres_per_unit, Some(0.01));
    assert!(!take.in_head_space);
    let tracks = &take.tracks;
    assert_eq!(tracks.labels, ["jaw00", "Actor:lip"]);
    // By the frames' numbers, where the rounded times agree.
    assert_eq!(tracks.times, [0.0, 1.0 / 60.0, 2.0 / 60.0]);
    assert_eq!(tracks.positions[0], [1.0, 2.0, 3.0]);
    assert_eq!(tracks.positions[5], [7.0, 8.0, 9.0]);
    let missing: Vec<bool> = tracks.positions.iter().map(is_missing).collect();
    assert_eq!(missing, [false, false, false, true, true, false]);
    assert_eq!(tracks.confidence, None);

    let same =
        |text: &str| assert_eq!(format!("{:?}", read(text.as_bytes(), NAME)), format!("{take:?}"), "{text}");
    same(&text.replace('\n', "\r\n"));
    same(&text.replace('\n', "\t\t\n"));
    same(&text.replace("6\n2", "6\n\n\t\t\n2"));
    same(&text.replace("\t\t\t\n3", "\n3"));
    same(&text.replace("NaN", "-1.#IND"));
    same(&text.replace("Z2\n\n", "Z2\n"));
    same(text.trim_end());
    same(&text.replace("jaw00", "jaw00 ").replace("\t5\t", "\t 5.000 \t"));
    same(&text.replace("\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n", ""));
}

#[test]
fn the_clock_is_the_one_that_the_times_allow() {
    let times = |rows: &str, rate: &str| {
        let take = read(file(rate, "3\t2", "mm", LABELS, rows).as_bytes(), NAME);
        (take.tracks.times.clone(), take.warnings.join("; "))
    };
    let rows = |lead: [&str; 3]| lead.map(|lead| format!("{lead}\t1\t2\t3\t4\t5\t6\n")).concat();
    // A take from the middle of a longer one keeps its place.
    let (found, said) = times(&rows(["121\t2.000", "122\t2.017", "123\t2.033"]), "60");
    assert_eq!((found, said.as_str()), (vec![120.0 / 60.0, 121.0 / 60.0, 122.0 / 60.0], ""));
    // Times that begin anew.
    let (found, said) = times(&rows(["121\t0.000", "122\t0.017", "123\t0.033"]), "60");
    assert_eq!((found, said.as_str()), (vec![0.0, 1.0 / 60.0, 2.0 / 60.0], ""));
    // Frames that were left out.
    let (found, said) = times(&rows(["1\t0.000", "4\t0.050", "5\t0.067"]), "60");
    assert_eq!((found, said.as_str()), (vec![0.0, 3.0 / 60.0, 4.0 / 60.0], ""));
    // Times that say something else than the rate.
    let (found, said) = times(&rows(["1\t0.000", "2\t0.020", "3\t0.040"]), "60");
    assert_eq!(found, [0.0, 0.02, 0.04]);
    assert!(said.contains("the times are used"), "{said}");
    // No times, no rate, numbers that do not increase.
    assert_eq!(times(&rows(["1\t", "2\t", "3\t"]), "60"), (vec![0.0, 1.0 / 60.0, 2.0 / 60.0], String::new()));
    let (found, said) = times(&rows(["1\t0.000", "2\t0.020", "3\t0.040"]), "0");
    assert!(found == [0.0, 0.02, 0.04] && said.contains("no frame rate"), "{said}");
    let (found, said) = times(&rows(["1\t0.000", "1\t0.017", "1\t0.033"]), "60");
    assert!(found == [0.0, 1.0 / 60.0, 2.0 / 60.0] && said.contains("numbers do not increase"), "{said}");
    let (found, said) = times(&rows(["1\t5", "2\t5", "3\t5"]), "60");
    assert!(found == [0.0, 1.0 / 60.0, 2.0 / 60.0] && said.contains("times do not increase"), "{said}");

    let text = file("60", "3\t2", "mm", LABELS, ROWS);
    assert_eq!(decode(text.as_bytes(), NAME, Some(10.0)).unwrap().tracks.times, [0.0, 0.1, 0.2]);
    let none = file("0", "3\t2", "mm", LABELS, &rows(["1\t", "2\t", "3\t"]));
    has_no_rate(none.as_bytes(), NAME);
    assert_eq!(decode(none.as_bytes(), NAME, Some(10.0)).unwrap().tracks.times, [0.0, 0.1, 0.2]);
}

#[test]
fn labels_that_are_not_distinct_or_not_there() {
    let labels = |labels: &str| {
        let take = read(file("60", "3\t2", "mm", labels, ROWS).as_bytes(), NAME);
        (take.tracks.labels.clone(), take.warnings.join("; "))
    };
    assert_eq!(labels("a\t\t\ta\t\t").0, ["a", "a#2"]);
    assert_eq!(labels("").0, ["#1", "#2"]);
    assert_eq!(labels("\t\t\tb").0, ["#1", "b"]);
    assert_eq!(labels("a").0, ["a", "#2"]);
    let (found, said) = labels("a\tb");
    assert!(found == ["a", "b"] && said.contains("used in their order"), "{said}");
    let wrong = file("60", "3\t2", "mm", "a\tb\tc", ROWS);
    assert!(refused(wrong.as_bytes(), NAME).contains("\"b\" stands over column 4"));
}

#[test]
fn units_counts_and_ends_that_are_wrong() {
    let take = read(file("60", "3\t2", "", LABELS, ROWS).as_bytes(), NAME);
    assert!(take.metres_per_unit.is_none() && warns(&take, "Units names no unit"));
    let take = read(file("60", "9\t2", "mm", LABELS, ROWS).as_bytes(), NAME);
    assert!(warns(&take, "3 of its 9 frames"), "{:?}", take.warnings);
    let take = read(file("60", "3\t1", "mm", LABELS, ROWS).as_bytes(), NAME);
    assert!(warns(&take, "promises 1 markers, and 2"), "{:?}", take.warnings);
    let take = read(file("60", "2\t2", "mm", LABELS, ROWS).as_bytes(), NAME);
    assert!(warns(&take, "promises 2 frames, and 3"), "{:?}", take.warnings);

    let text = file("60", "3\t2", "mm", LABELS, ROWS);
    let above = text.len() - ROWS.len();
    for cut in 0..text.len() {
        let result = decode(&text.as_bytes()[..cut], NAME, None);
        // A cut in the last number of the last row is not to be seen.
        if cut < above + 3 {
            assert!(result.is_err(), "{cut}");
        } else if let Ok(take) = result {
            super::check(&take);
            assert!(take.tracks.frames() == 3 || warns(&take, "cut short"), "{cut}: {:?}", take.warnings);
        }
    }
    assert!(refused(&text.as_bytes()[..above], NAME).contains("has no frames"));
    let nobody = "DataRate\tNumFrames\tNumMarkers\n60\t1\t0\nFrame#\tTime\n1\t0.0\n";
    assert!(refused(nobody.as_bytes(), NAME).contains("has no markers"));
    let wide = text.replace("9e0\n", "9e0\t7\n");
    assert!(
        refused(wide.as_bytes(), NAME).contains("behind the 8 cells of the 2 markers"),
        "{}",
        refused(wide.as_bytes(), NAME)
    );
    let word = text.replace("1.5", "1,5");
    assert!(
        refused(word.as_bytes(), NAME).contains("line 8: cell 3 is \"1,5\""),
        "{}",
        refused(word.as_bytes(), NAME)
    );
    assert!(refused(b"hello\nworld\n", NAME).contains("no line that begins with Frame#"));
}

#[test]
fn rows_much_shorter_than_the_header_take_no_memory() {
    let labels: String = (0..20_000).map(|j| format!("m{j}\t\t\t")).collect();
    let rows: String = (1..20_000).map(|i| format!("{i}\t1\n")).collect();
    let text = file("60", "19999\t20000", "mm", &labels, &rows);
    assert!(refused(text.as_bytes(), NAME).contains("far shorter than the header"));
}

/// A file of 600 frames of one marker: its times and its warnings.
fn times_of(
    rate: &str,
    number: impl Fn(usize) -> usize,
    time: impl Fn(usize) -> String,
) -> (Vec<f64>, String) {
    let rows: String =
        (0..600).map(|i| format!("{}\t{}\t{i}\t2\t3\t4\t5\t6\n", number(i), time(i))).collect();
    let take = read(file(rate, "600\t2", "mm", LABELS, &rows).as_bytes(), NAME);
    (take.tracks.times.clone(), take.warnings.join("; "))
}

#[test]
fn numbers_and_rate_win_over_rounded_times() {
    let even =
        |first: usize, rate: f64| -> Vec<f64> { (first..first + 600).map(|i| i as f64 / rate).collect() };
    let seconds = |i: usize, rate: f64| i as f64 / rate;
    for (rate, number) in
        [("120.00", 120.0), ("119.88", 119.88), ("59.94", 59.94), ("119.96", 119.96), ("100", 100.0)]
    {
        // Times with six digits, with three, with three and three zeros, and in single precision.
        let exact = times_of(rate, |i| i + 1, |i| format!("{:.6}", seconds(i, number)));
        let short = times_of(rate, |i| i + 1, |i| format!("{:.3}", seconds(i, number)));
        let zeros = times_of(rate, |i| i + 1, |i| format!("{:.3}000", seconds(i, number)));
        let single = times_of(rate, |i| i + 1, |i| format!("{:.9}", seconds(i, number) as f32));
        for (found, said) in [exact, short, zeros, single] {
            assert!(found == even(0, number) && said.is_empty(), "{rate}: {:?} {said}", &found[..4]);
        }
    }
    // The first frame is 500 at 500/120 or 499/120 s, or 0 at 0 s.
    for (first, from) in [(500, 500), (500, 499), (0, 0), (1, 0)] {
        let (found, said) = times_of("120", |i| first + i, |i| format!("{:.6}", seconds(from + i, 120.0)));
        assert!(found == even(from, 120.0) && said.is_empty(), "{first}, {from}: {:?} {said}", &found[..4]);
    }
    // A clock that trembles by a quarter of a frame.
    let tremble = |i: usize| format!("{:.6}", seconds(i, 120.0) + if i % 3 == 1 { 0.002 } else { 0.0 });
    let (found, said) = times_of("120", |i| i + 1, tremble);
    assert!(found == even(0, 120.0) && said.is_empty(), "{:?} {said}", &found[..4]);
}

#[test]
fn times_that_contradict_the_rate_win() {
    for (rate, true_rate) in [("120", 100.0), ("120", 119.5), ("60", 59.5), ("30", 120.0)] {
        let (found, said) = times_of(rate, |i| i + 1, |i| format!("{:.6}", i as f64 / true_rate));
        let near = found.iter().enumerate().all(|(i, t)| (t - i as f64 / true_rate).abs() < 1e-6);
        assert!(
            near && said.contains(&format!("the times are used, which give {true_rate} frames")),
            "{said}"
        );
    }
    // A step of a second in the middle.
    let (found, said) = times_of("120", |i| i + 1, |i| format!("{:.6}", i as f64 / 120.0 + (i / 300) as f64));
    assert_eq!(
        (found[599], said.contains("as they are; if that is wrong, give the rate")),
        (5.991667, true),
        "{said}"
    );
    // A frame that comes most of a frame late.
    let late = |i: usize| format!("{:.6}", i as f64 / 120.0 + if i == 300 { 0.8 / 120.0 } else { 0.0 });
    let (found, said) = times_of("120", |i| i + 1, late);
    assert!(found[300] == 2.506667 && said.contains("the times are used"), "{} {said}", found[300]);
    // Milliseconds and no rate: 120, and not the 125 of most steps.
    let (found, said) = times_of("0", |i| i + 1, |i| format!("{:.3}", i as f64 / 120.0));
    assert_eq!(found[599], 599.0 / 120.0);
    assert!(said.contains("which give 120 frames per second"), "{said}");
}
