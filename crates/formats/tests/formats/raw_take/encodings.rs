//! One text in every encoding, and with everything that programs put between cells, is one take.
use super::{is_missing, read, refused};

/// Two markers, one with a gap in the second frame.
const TRC: &str = "PathFileType\t4\t(X/Y/Z)\ta.trc\n\
    DataRate\tNumFrames\tNumMarkers\tUnits\n120.00\t3\t2\tmm\n\
    Frame#\tTime\tjaw00\t\t\tlip\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n\
    1\t0.00000\t1.5\t2.25\t3.125\t4.5\t-5.25\t6.5\n\
    2\t0.00833\t1.75\t2.25\t3.125\t\t\t\n\
    3\t0.01667\t2.5\t2.25\t3.125\t4.5\t-5.25\t6.75\n";

const MOTIVE: &str = "Format Version,1.23,Export Frame Rate,120.000000,Length Units,Millimeters\n\n\
    ,Type,Marker,Marker,Marker,Marker,Marker,Marker\n,Name,jaw00,jaw00,jaw00,lip,lip,lip\n\
    ,,Position,Position,Position,Position,Position,Position\nFrame,Time (Seconds),X,Y,Z,X,Y,Z\n\
    0,0.000000,1.5,2.25,3.125,4.5,-5.25,6.5\n1,0.008333,1.75,2.25,3.125,,,\n2,0.016667,2.5,2.25,3.125,4.5,-5.25,6.75\n";

const QUALISYS: &str = "NO_OF_FRAMES\t3\nNO_OF_MARKERS\t2\nFREQUENCY\t120\nMARKER_NAMES\tjaw00\tlip\n\
    1.5\t2.25\t3.125\t4.5\t-5.25\t6.5\n1.75\t2.25\t3.125\t\t\t\n2.5\t2.25\t3.125\t4.5\t-5.25\t6.75\n";

const VICON: &str = "Trajectories\n120\n,,jaw00,,,lip,,\nFrame,Sub Frame,X,Y,Z,X,Y,Z\n,,mm,mm,mm,mm,mm,mm\n\
    1,0,1.5,2.25,3.125,4.5,-5.25,6.5\n2,0,1.75,2.25,3.125,,,\n3,0,2.5,2.25,3.125,4.5,-5.25,6.75\n";

#[track_caller]
fn check(bytes: &[u8], name: &str) {
    let take = read(bytes, name);
    assert_eq!(take.warnings, [""; 0], "{name}");
    assert_eq!(take.tracks.labels, ["jaw00", "lip"], "{name}");
    assert_eq!(take.metres_per_unit, Some(0.001), "{name}");
    assert_eq!(take.tracks.times, [0.0, 1.0 / 120.0, 2.0 / 120.0], "{name}");
    let p = &take.tracks.positions;
    assert_eq!((p[0], p[1], p[2]), ([1.5, 2.25, 3.125], [4.5, -5.25, 6.5], [1.75, 2.25, 3.125]), "{name}");
    assert!(is_missing(&p[3]), "{name}");
    assert_eq!((p[4], p[5]), ([2.5, 2.25, 3.125], [4.5, -5.25, 6.75]), "{name}");
}

#[test]
fn every_encoding_of_every_text_format() {
    for (text, name) in [(TRC, "a.trc"), (MOTIVE, "a.csv"), (QUALISYS, "a.tsv"), (VICON, "v.csv")] {
        let units = |to: fn(u16) -> [u8; 2]| -> Vec<u8> { text.encode_utf16().flat_map(to).collect() };
        let (little, big) = (units(u16::to_le_bytes), units(u16::to_be_bytes));
        check(text.as_bytes(), name);
        check(&[b"\xEF\xBB\xBF", text.as_bytes()].concat(), name);
        check(&[b"\xFF\xFE", &little[..]].concat(), name);
        check(&[b"\xFE\xFF", &big[..]].concat(), name);
        check(&little, name);
        check(&big, name);
        check(text.replace('\n', "\r\n").as_bytes(), name);
        check(text.replace('\n', "\r").as_bytes(), name);
    }
}

#[test]
fn commas_semicolons_and_decimal_commas() {
    for (text, name, separator) in
        [(TRC, "a.trc", "\t"), (MOTIVE, "a.csv", ","), (QUALISYS, "a.tsv", "\t"), (VICON, "v.csv", ",")]
    {
        for other in [",", ";", "\t"] {
            check(text.replace(separator, other).as_bytes(), name);
        }
        for other in [";", "\t"] {
            check(text.replace(separator, other).replace('.', ",").as_bytes(), name);
        }
    }
}

#[test]
fn blanks_between_cells_leave_no_cell_empty() {
    let blanks = "PathFileType  4  (X/Y/Z)  a.trc\n\
        DataRate  NumFrames  NumMarkers  Units\n120.00  3  2  mm\n\
        Frame#  Time  jaw00      lip\n              X1   Y1   Z1     X2 Y2 Z2\n\n\
        1   0.00000   1.5   2.25 3.125   4.5  -5.25 6.5  \n\
        2   0.00833   1.75  2.25 3.125   NaN NaN NaN\n\
        3   0.01667   2.5   2.25 3.125   4.5  -5.25 6.75\n";
    check(blanks.as_bytes(), "a.trc");
    let short = refused(blanks.replace("NaN NaN NaN", "").as_bytes(), "a.trc");
    assert!(short.contains("line 8: the row has 5 cells, expected 8 for the 2 markers"), "{short}");
    assert!(short.contains("write NaN for it, or put tabs between the cells"), "{short}");
    let label = refused(blanks.replace("jaw00 ", "jaw 00").as_bytes(), "a.trc");
    assert!(label.contains("line 4: the line has 3 labels between blanks, expected 2"), "{label}");
}

#[test]
fn lines_that_a_header_may_lack() {
    check(TRC.split_once('\n').unwrap().1.as_bytes(), "a.trc");
    check(TRC.split_once('\n').unwrap().1.as_bytes(), "a.txt");
    check(TRC.replace("\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n", "").as_bytes(), "a.trc");
    check(TRC.replace('\n', "\t\t\n").as_bytes(), "a.trc");
    // A line feed and a P are how a C3D file could begin.
    check(format!("\n{TRC}").as_bytes(), "a.trc");
}
