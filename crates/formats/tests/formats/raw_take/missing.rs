//! Every way of saying “not seen” gives the same take, in every format that allows it.
use super::c3d_writer::{C3d, trial};
use super::{is_missing, read, warns};
use rhytid_core::RawTake;
use rhytid_formats::raw_take::mark_missing;

const FRAMES: usize = 60;
const MARKERS: usize = 4;

/// A moving marker; missing where [`is_gap`] says so.
fn position(frame: usize, marker: usize) -> [f64; 3] {
    let (i, j) = (frame as f64, marker as f64);
    [-60.0 + 40.0 * j + 0.25 * i, 12.5 * j - 0.5 * i, 1500.0 - 8.0 * j + 0.125 * i]
}

/// Gaps at the beginning, in the middle and at the end, and a marker without any.
fn is_gap(frame: usize, marker: usize) -> bool {
    match marker {
        0 => false,
        1 => frame < 5,
        2 => (20..31).contains(&frame) || frame == 40,
        _ => frame > 50,
    }
}

#[track_caller]
fn check(take: &RawTake, what: &str) {
    assert_eq!(take.tracks.frames(), FRAMES, "{what}");
    for (sample, found) in take.tracks.positions.iter().enumerate() {
        let (frame, marker) = (sample / MARKERS, sample % MARKERS);
        assert_eq!(is_missing(found), is_gap(frame, marker), "{what}: {frame}, {marker}: {found:?}");
        assert!(
            is_missing(found) || *found == position(frame, marker),
            "{what}: {frame}, {marker}: {found:?}"
        );
    }
    assert_eq!(take.tracks.confidence, None, "{what}");
}

/// The cells of a frame, with `none` in place of each coordinate of a marker that was not seen.
fn cells(frame: usize, none: &str) -> Vec<String> {
    let cell = |marker: usize, x: f64| match is_gap(frame, marker) {
        true => none.to_owned(),
        false => format!("{x:.4}"),
    };
    (0..MARKERS).flat_map(|marker| position(frame, marker).map(|x| cell(marker, x))).collect()
}

fn trc(none: &str) -> String {
    let labels: String = (0..MARKERS).map(|j| format!("\ta{j}\t\t")).collect();
    let rows: String = (0..FRAMES)
        .map(|i| format!("{}\t{:.5}\t{}\n", i + 1, i as f64 / 120.0, cells(i, none).join("\t")))
        .collect();
    format!(
        "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n120\t{FRAMES}\t{MARKERS}\tmm\n\
         Frame#\tTime{labels}\n{rows}"
    )
}

fn motive(none: &str) -> String {
    let thrice = |of: &dyn Fn(usize) -> String| -> String {
        (0..MARKERS).map(|j| format!(",{0},{0},{0}", of(j))).collect()
    };
    let rows: String =
        (0..FRAMES).map(|i| format!("{i},{:.6},{}\n", i as f64 / 120.0, cells(i, none).join(","))).collect();
    format!(
        "Format Version,1.24,Export Frame Rate,120,Length Units,Millimeters\n,Type{}\n,Name{}\n,{}\nFrame,Time{}\n{rows}",
        thrice(&|_| "Marker".into()),
        thrice(&|j| format!("a{j}")),
        thrice(&|_| "Position".into()),
        ",X,Y,Z".repeat(MARKERS),
    )
}

fn qualisys(none: &str) -> String {
    let rows: String = (0..FRAMES).map(|i| format!("{}\n", cells(i, none).join("\t"))).collect();
    format!(
        "NO_OF_FRAMES\t{FRAMES}\nNO_OF_MARKERS\t{MARKERS}\nFREQUENCY\t120\nMARKER_NAMES\ta0\ta1\ta2\ta3\n{rows}"
    )
}

fn vicon(none: &str) -> String {
    let labels: String = (0..MARKERS).map(|j| format!(",Anna:a{j},,")).collect();
    let rows: String = (0..FRAMES).map(|i| format!("{},0,{}\n", i + 1, cells(i, none).join(","))).collect();
    format!(
        "Trajectories\n120\n,{labels}\nFrame,Sub Frame{}\n,{}\n{rows}",
        ",X,Y,Z".repeat(MARKERS),
        ",mm,mm,mm".repeat(MARKERS)
    )
}

/// The spellings in text, and whether a warning should name the number.
const IN_TEXT: [(&str, bool); 15] = [
    ("", false),
    ("NaN", false),
    ("-nan(ind)", false),
    ("1.#QNAN", false),
    ("null", false),
    ("0", false),
    ("0.000", false),
    ("-0.0", false),
    ("9999999", true),
    ("999999.00", true),
    ("-9999", true),
    ("99999", true),
    ("1e30", true),
    ("1.7976931348623157e308", false),
    ("7777.25", true),
];

#[test]
fn every_word_for_not_seen_in_a_text_is_a_gap() {
    for (none, is_named) in IN_TEXT {
        let texts = [
            (trc(none), "a.trc"),
            (motive(none), "motive.csv"),
            (qualisys(none), "a.tsv"),
            (vicon(none), "vicon.csv"),
        ];
        for (text, name) in texts {
            let take = read(text.as_bytes(), name);
            check(&take, &format!("{name}, {none:?}"));
            assert_eq!(take.warnings.len(), usize::from(is_named), "{name}, {none:?}: {:?}", take.warnings);
            // 28 of 240 samples, and three of the four markers.
            let number: f64 = none.parse().unwrap_or(0.0);
            let shown = if number < 1e12 { number.to_string() } else { none.to_owned() };
            let words = format!("the coordinate {shown} stands far outside the rest");
            assert!(!is_named || warns(&take, &words), "{:?}", take.warnings);
            assert!(
                !is_named || warns(&take, "3 of 4 markers, 10.83 % of all samples"),
                "{:?}",
                take.warnings
            );
        }
    }
}

#[test]
fn one_coordinate_is_enough() {
    let rows: Vec<String> = trc("9999999").lines().map(str::to_owned).collect();
    let partial = rows.join("\n").replace("9999999\t9999999\t9999999", "12.5\t3.25\t9999999");
    let take = read(format!("{partial}\n").as_bytes(), "a.trc");
    check(&take, "one of three");
}

fn c3d(missing: [f32; 3], fourth: i16) -> C3d {
    let point = |i: usize, j: usize| match is_gap(i, j) {
        true => (missing, fourth),
        false => (position(i, j).map(|x| x as f32), 0x0300),
    };
    C3d::new(120.0, (0..FRAMES).map(|i| (0..MARKERS).map(|j| point(i, j)).collect()).collect())
}

#[test]
fn every_word_for_not_seen_in_a_c3d_file_is_a_gap() {
    for (missing, fourth, warnings) in [
        ([0.0; 3], -1, 0),
        ([7.0, 8.0, 9.0], -1, 0),
        ([0.0; 3], 0, 0),
        ([-0.0; 3], 0x0300, 0),
        ([f32::NAN; 3], 0x0300, 0),
        ([9_999_999.0; 3], 0x0300, 1),
        ([9_999_999.0; 3], 0, 1),
        ([1e30, 1e30, 1e30], 0x0300, 1),
        ([5.0, 6.0, -99_999.0], 0x0300, 1),
        ([f32::MAX; 3], 0x0300, 1),
    ] {
        let take = read(&c3d(missing, fourth).bytes(), "a.c3d");
        check(&take, &format!("{missing:?}, {fourth}"));
        assert_eq!(take.warnings.len(), warnings, "{missing:?}: {:?}", take.warnings);
    }
    // In a float file the fourth number may be the bits of a 16-bit integer without its sign.
    for (missing, word) in
        [([0.0; 3], 65535.0_f32), ([70.0, 80.0, 90.0], 65535.0), ([5.0; 3], 32768.0 + 256.0)]
    {
        let mut bytes = c3d(missing, -1).bytes();
        let from = (-1.0_f32).to_le_bytes();
        let data = bytes.len() - (FRAMES * MARKERS * 16_usize).next_multiple_of(512);
        for point in bytes[data..].chunks_exact_mut(16).filter(|point| point[12..] == from) {
            point[12..].copy_from_slice(&word.to_le_bytes());
        }
        check(&read(&bytes, "a.c3d"), &format!("{word}"));
    }
    // Whole numbers: the largest one, and the origin.
    for missing in [[4095.875; 3], [0.0; 3]] {
        check(
            &read(&c3d(missing, 0x0300).integer(0.125).bytes(), "a.c3d"),
            &format!("{missing:?} in integers"),
        );
    }
}

/// A file of two markers: one that moves, and one that is where `at` says.
fn beside(at: impl Fn(usize) -> [f32; 3]) -> RawTake {
    let moving = |i: usize| [500.0 + i as f32, 20.0, 1000.0];
    let frames = (0..FRAMES).map(|i| vec![(moving(i), 0x0300), (at(i), 0x0300)]).collect();
    read(&C3d::new(120.0, frames).bytes(), "a.c3d")
}

fn gaps(take: &RawTake) -> usize {
    take.tracks.positions.iter().filter(|p| is_missing(p)).count()
}

#[test]
fn a_marker_that_may_be_at_the_origin_is_kept_and_asked_about() {
    // It passes the origin, or stays there.
    let passing = |i: usize| [30.0 - i as f32, 0.0, 0.0];
    let stays = |i: usize| [(30.0 - i as f32).max(0.0), 0.0, 0.0];
    for take in [beside(passing), beside(stays)] {
        assert_eq!(gaps(&take), 0);
        assert!(
            warns(&take, "1 of 2 markers come to rest at exactly 0, 0, 0 or pass it"),
            "{:?}",
            take.warnings
        );
        assert!(warns(&take, "\"a1\"; was such a marker really there?"), "{:?}", take.warnings);
    }
    let jumps = beside(|i| if i == 30 { [0.0; 3] } else { passing(i).map(|x| x + 3.0) });
    assert_eq!((gaps(&jumps), jumps.warnings.len()), (1, 0), "{:?}", jumps.warnings);
}

#[test]
fn a_marker_that_is_nowhere_else_was_never_seen() {
    let take = beside(|_| [0.0; 3]);
    assert_eq!(gaps(&take), FRAMES);
    assert!(warns(&take, "1 of 2 markers are at 0, 0, 0 in every frame and count as never seen: \"a1\""));
}

#[test]
fn wild_positions_and_far_props_are_no_gaps() {
    // A ghost far away, in one frame.
    let ghost = beside(|i| if i == 9 { [8e4, -7e4, 9e4] } else { [3.0, i as f32, 900.0] });
    // A number that programs use for “not seen”, but in two frames alone.
    let rare = beside(|i| if i % 40 == 9 { [99_999.0, 6.0, 7.0] } else { [3.0, i as f32, 900.0] });
    // A prop that lies far from the rest, in whole numbers.
    let prop = beside(|_| [30_000.0, -21_000.0, 14.0]);
    // A prop at equal numbers on two axes, twice as far out as the rest.
    let near = beside(|_| [2_100.0, -2_100.0, 14.0]);
    // Flat data.
    let flat = beside(|i| [i as f32, 2.0, 1000.0]);
    for take in [ghost, rare, prop, near, flat] {
        assert_eq!((gaps(&take), take.warnings.len()), (0, 0), "{:?}", take.warnings);
    }
    let written = trial(7, 40);
    assert_eq!(gaps(&read(&written.bytes(), "a.c3d")), 1);
    // In integers, a coordinate at the end of their range is a position if another one is not.
    let mut edge = c3d([4095.875; 3], 0x0300);
    let points = edge.frames.iter_mut().flatten();
    points.filter(|(position, _)| position[0] == 4095.875).for_each(|(position, _)| position[1] = 700.0);
    assert_eq!(gaps(&read(&edge.integer(0.125).bytes(), "a.c3d")), 0);
}

/// In head space, 0, 0, 0 may be a place, so the reader keeps it.
#[test]
fn the_takes_own_csv_is_marked_where_it_is_in_world_space() {
    let header: String = (0..MARKERS).map(|j| format!(",a{j}_x,a{j}_y,a{j}_z")).collect();
    let rows: String =
        (0..FRAMES).map(|i| format!("{},{}\n", i as f64 / 120.0, cells(i, "0").join(","))).collect();
    let mut take = read(format!("time{header}\n{rows}").as_bytes(), "take.csv");
    assert!(is_gap(2, 1) && take.tracks.positions[2 * MARKERS + 1] == [0.0; 3]);
    mark_missing(&mut take);
    check(&take, "world space");
}
