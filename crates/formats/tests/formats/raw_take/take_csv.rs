//! The take's own CSV as a raw take, and telling it from the other files.
use super::{is_missing, read, refused};
use rhytid_formats::raw_take::is_take_csv;

#[test]
fn gaps_in_a_takes_csv_stay_gaps() {
    let text = "time,a_x,a_y,a_z,b_x,b_y,b_z\n0,1,2,3,,,\n0.5,1,NaN,3,,,\n1,4,5,6,,,\n";
    let take = read(text.as_bytes(), "take.csv");
    assert!(take.in_head_space && take.metres_per_unit.is_none() && take.warnings.is_empty());
    assert_eq!(take.tracks.times, [0.0, 0.5, 1.0]);
    let missing: Vec<bool> = take.tracks.positions.iter().map(is_missing).collect();
    assert_eq!(missing, [false, true, true, true, false, true]);
    assert_eq!(take.tracks.positions[4], [4.0, 5.0, 6.0]);
    assert!(refused(b"time,a_x,a_y,a_z\n0,1,2,three\n", "take.csv").contains("\"three\""));
}

#[test]
fn files_are_told_apart_by_how_they_begin_and_else_by_their_ending() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text, expected) in [
        ("a.csv", "time,a_x,a_y,a_z\n", true),
        ("a.CSV", "\u{feff}Format Version,1.23,Take Name,x\n", false),
        ("b.csv", "Format Version,1.23\n", false),
        ("a.tsv", "", false),
        ("a.TRC", "", false),
        ("a.c3d", "", false),
        ("take.txt", "time,a_x,a_y,a_z\n", true),
        ("trial.txt", "PathFileType\t4\n", false),
        ("qtm.txt", "NO_OF_FRAMES\t4\n", false),
        ("vicon.bin", "\u{2}P\u{1}", false),
        ("empty", "", true),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        assert_eq!(is_take_csv(&path), expected, "{name}");
    }
    assert!(is_take_csv(&folder.path().join("none.csv")));
    assert!(!is_take_csv(&folder.path().join("none.trc")));
}
