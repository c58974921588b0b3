//! Qualisys' TSV.
use super::{has_no_rate, is_missing, read, refused, warns};
use rhytid_formats::raw_take::decode;

const NAME: &str = "take.tsv";

const HEADER: &str = "\
NO_OF_FRAMES\t3\nNO_OF_CAMERAS\t12\nNO_OF_MARKERS\t2\nFREQUENCY\t100\nNO_OF_ANALOG\t0\nANALOG_FREQUENCY\t0\n\
DESCRIPTION\t--\nTIME_STAMP\t2024-01-01, 10:00:00.000\t1234.5\nDATA_INCLUDED\t3D\nMARKER_NAMES\tjaw00\tlip up\n";

const ROWS: [&str; 3] = ["1\t2\t3\t4\t5\t6", "1.5\t2\t3\t0.000\t0.000\t0.000", "\t\t\t4.5\t5\t6"];

/// The rows with something before each, and with a number at its front.
fn rows(lead: impl Fn(usize) -> String, end: &str) -> String {
    ROWS.iter().enumerate().map(|(i, row)| format!("{}{row}{end}\n", lead(i))).collect()
}

#[test]
fn each_way_of_export_gives_the_same_take() {
    let plain = format!("{HEADER}{}", rows(|_| String::new(), ""));
    let take = read(plain.as_bytes(), NAME);
    assert_eq!(take.warnings, [""; 0]);
    assert_eq!(take.tracks.labels, ["jaw00", "lip up"]);
    assert_eq!(take.metres_per_unit, Some(0.001));
    assert_eq!(take.tracks.times, [0.0, 0.01, 0.02]);
    let p = &take.tracks.positions;
    assert_eq!(
        (p[0], p[1], p[2], p[5]),
        ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [1.5, 2.0, 3.0], [4.5, 5.0, 6.0])
    );
    assert!(is_missing(&p[3]) && is_missing(&p[4]));

    let timed = |i: usize| format!("{}\t{:.5}\t", i + 1, i as f64 / 100.0);
    let columns = "jaw00 X\tjaw00 Y\tjaw00 Z\tlip up X\tlip up Y\tlip up Z";
    let same = |text: &str| {
        assert_eq!(format!("{:?}", read(text.as_bytes(), NAME)), format!("{take:?}"), "{text}");
    };
    for end in ["", "\t"] {
        same(&format!("{HEADER}{}", rows(|_| String::new(), end)));
        same(&format!("{HEADER}{}", rows(timed, end)));
        same(&format!("{HEADER}Frame\tTime\t{columns}\n{}", rows(timed, end)));
        same(&format!("{HEADER}{columns}{end}\n{}", rows(|_| String::new(), end)));
        same(
            &format!("{HEADER}TRAJECTORY_TYPES\tMeasured\tMixed\n{}", rows(timed, end)).replace('\n', "\r\n"),
        );
        let nameless = HEADER.replace("MARKER_NAMES", "NAMES");
        same(&format!("{nameless}Frame\tTime\t{columns}\n{}", rows(timed, end)));
    }
    // A frame in which nothing was seen is a frame.
    let lost = format!("{HEADER}1\t2\t3\t4\t5\t6\n\t\t\t\t\t\n1\t2\t3\t4\t5\t6\n");
    let take = read(lost.as_bytes(), NAME);
    assert_eq!(take.tracks.frames(), 3);
    assert!(is_missing(&take.tracks.positions[2]) && is_missing(&take.tracks.positions[3]));
}

#[test]
fn headers_that_are_wrong() {
    let with = |from: &str, to: &str| format!("{}{}", HEADER.replace(from, to), rows(|_| String::new(), ""));
    let said = |from: &str, to: &str| refused(with(from, to).as_bytes(), NAME);
    has_no_rate(with("FREQUENCY\t100\n", "").as_bytes(), NAME);
    has_no_rate(with("FREQUENCY\t100", "FREQUENCY\t0").as_bytes(), NAME);
    assert_eq!(
        decode(with("FREQUENCY\t100\n", "").as_bytes(), NAME, Some(50.0)).unwrap().tracks.times[1],
        0.02
    );
    assert!(said("\t3D", "\t6D").contains("\"6D\", expected 3D"));
    let take = read(with("\tlip up", "\tlip\tup").as_bytes(), NAME);
    assert!(warns(&take, "3 names, and there are 2 markers"), "{:?}", take.warnings);
    let take = read(with("\tjaw00\tlip up", "").as_bytes(), NAME);
    assert_eq!(take.tracks.labels, ["#1", "#2"]);
    let take = read(with("lip up", "jaw00").as_bytes(), NAME);
    assert_eq!(take.tracks.labels, ["jaw00", "jaw00#2"]);
    assert!(warns(&read(with("NO_OF_FRAMES\t3", "NO_OF_FRAMES\t9").as_bytes(), NAME), "3 of its 9 frames"));
    assert!(warns(
        &read(with("NO_OF_MARKERS\t2", "NO_OF_MARKERS\t5").as_bytes(), NAME),
        "promises 5 markers"
    ));
    let wrong = with("\tjaw00\tlip up", "\ta\tb\tc\td").replace("NO_OF_MARKERS\t2", "NO_OF_MARKERS\t4");
    assert!(
        refused(wrong.as_bytes(), NAME).contains("the row has 6 cells, expected 3 for each of 4 markers")
    );
    assert!(refused(HEADER.as_bytes(), NAME).contains("has no frames"));
    assert!(refused(b"", NAME).contains("has no frames"));
    assert!(
        refused(with("", "").replace("\n1\t2\t", "\n1\ttwo\t").as_bytes(), NAME).contains("cell"),
        "a word"
    );
}

#[test]
fn a_file_that_is_cut_anywhere() {
    let text = format!("{HEADER}{}", rows(|i| format!("{}\t{:.5}\t", i + 1, i as f64 / 100.0), ""));
    for cut in 0..text.len() {
        if let Ok(take) = decode(&text.as_bytes()[..cut], NAME, None) {
            super::check(&take);
            assert!(take.tracks.frames() == 3 || warns(&take, "cut short"), "{cut}: {:?}", take.warnings);
        }
    }
}
