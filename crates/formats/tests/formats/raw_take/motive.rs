//! Motive's CSV.
use super::{has_no_rate, is_missing, read, refused, warns};
use rhytid_formats::raw_take::decode;

const NAME: &str = "take.csv";

const FILE: &str = "\
Format Version,1.23,Take Name,\"Take, one\",Take Notes,,Capture Frame Rate,240.000000,Export Frame Rate,120.000000,\
Capture Start Time,2024-01-01 10.00.00.000 AM,Total Frames in Take,3,Total Exported Frames,3,Rotation Type,Quaternion,\
Length Units,Meters,Coordinate Space,Global

,Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,\
Rigid Body Marker,Rigid Body Marker,Rigid Body Marker,Rigid Body Marker,Rigid Body Marker,Rigid Body Marker,\
Rigid Body Marker,Marker,Marker,Marker,Marker,Marker,Marker
,Name,Cap,Cap,Cap,Cap,Cap,Cap,Cap,Cap,Cap:1,Cap:1,Cap:1,Cap:1,Cap:2,Cap:2,Cap:2,Cap:1,Cap:1,Cap:1,\
Actor:jaw00,Actor:jaw00,Actor:jaw00
,ID,A,A,A,A,A,A,A,A,B,B,B,B,C,C,C,D,D,D,E,E,E
,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker Error,Position,Position,Position,\
Marker Quality,Position,Position,Position,Position,Position,Position,Position,Position,Position
Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,,X,Y,Z,,X,Y,Z,X,Y,Z,X,Y,Z
0,0.000000,0,0,0,1,9,9,9,0.1,8,8,8,1,7,7,7,1,2,3,4,5,6
1,0.008333,0,0,0,1,9,9,9,0.1,8,8,8,1,7,7,7,1.5,2,3,,,
2,0.016667,0,0,0,1,9,9,9,0.1,8,8,8,1,7,7,7,,,,4.5,5,6
";

#[test]
fn markers_are_found_among_bodies() {
    let take = read(FILE.as_bytes(), NAME);
    assert_eq!(take.tracks.labels, ["Cap:2", "Cap:1", "Actor:jaw00"]);
    assert_eq!(
        take.warnings,
        ["1 markers have only the positions that their rigid body or bone gives them: \"Cap:2\""]
    );
    assert_eq!(take.metres_per_unit, Some(1.0));
    assert_eq!(take.tracks.times, [0.0, 1.0 / 120.0, 2.0 / 120.0]);
    let p = &take.tracks.positions;
    assert_eq!(p[..3], [[7.0; 3], [1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert_eq!(p[4], [1.5, 2.0, 3.0]);
    assert!(is_missing(&p[5]) && is_missing(&p[7]) && !is_missing(&p[8]));
    assert_eq!(take.tracks.confidence, None);

    let same = |text: &str| assert_eq!(format!("{:?}", read(text.as_bytes(), NAME)), format!("{take:?}"));
    same(&FILE.replace('\n', "\r\n"));
    same(&format!("\u{feff}{FILE}"));
    // Lines that have no title, and one more of parents.
    same(&FILE.replace(",Type,", ",,").replace(",Name,", ",,").replace(",ID,", ",,"));
    same(&FILE.replace("\n,,Rotation", "\n,Parent,P,P\n,,Rotation"));
}

#[test]
fn keys_that_are_wrong_or_missing() {
    let cm = read(FILE.replace("Meters", "Centimeters").as_bytes(), NAME);
    assert_eq!(cm.metres_per_unit, Some(0.01));
    let comma = read(FILE.replace("\"Take, one\"", "Take, one").as_bytes(), NAME);
    assert_eq!((comma.metres_per_unit, comma.warnings.len()), (Some(1.0), 1), "{:?}", comma.warnings);
    let none = read(FILE.replace("Length Units,Meters", "Length,Meters").as_bytes(), NAME);
    assert!(none.metres_per_unit.is_none() && warns(&none, "Length Units names no unit"));
    assert!(warns(&read(FILE.replace("1.23", "2.0").as_bytes(), NAME), "version is \"2.0\""));
    let promised = read(FILE.replace("Exported Frames,3", "Exported Frames,5").as_bytes(), NAME);
    assert!(warns(&promised, "3 of its 5 frames"));
    // The export's rate is wrong; the times win.
    let rate = read(FILE.replace("120.0", "100.0").as_bytes(), NAME);
    assert!(rate.tracks.times[1] == 0.008333 && warns(&rate, "the times are used"));
    let no_rate = FILE.replace("Frame Rate", "Rate").replace("Time (Seconds)", "Something");
    has_no_rate(no_rate.as_bytes(), NAME);
    assert_eq!(decode(no_rate.as_bytes(), NAME, Some(30.0)).unwrap().tracks.times[1], 1.0 / 30.0);
}

#[test]
fn files_that_are_cut_or_lack_markers() {
    let frames = FILE.find("\n0,0.0").unwrap() + 1;
    for cut in 15..FILE.len() {
        let result = decode(&FILE.as_bytes()[..cut], NAME, None);
        match result {
            Ok(take) => {
                super::check(&take);
                assert!(take.tracks.frames() == 3 || warns(&take, "cut short"), "{cut}");
            }
            Err(_) => assert!(cut < frames + 60, "{cut}"),
        }
    }
    assert!(refused(&FILE.as_bytes()[..frames], NAME).contains("has no frames"));
    let bodies = FILE.replace("Marker,", "Bone,").replace("Marker\n", "Bone\n");
    assert!(refused(bodies.as_bytes(), NAME).contains("no columns of type Marker"));
    assert!(refused(b"Format Version,1.23\n\nFrame,Time\n0,0\n", NAME).contains("lines of types"));
    assert!(refused(b"Format Version,1.23\n", NAME).contains("begins with Frame"));
    assert!(refused(FILE.replace("4.5,5,6", "4.5,five,6").as_bytes(), NAME).contains("\"five\""));
}
