//! C3D files that are wrong: each gives a sentence, or a warning and a sound take.
use super::c3d_writer::{C3d, Value, trial};
use super::{has_no_rate, read, refused, warns};
use rhytid_formats::raw_take::decode;

const NAME: &str = "trial.c3d";

#[test]
fn labels_that_are_not_distinct_or_not_there() {
    let mut written = trial(4, 6);
    let texts = |texts: &[&str]| Value::Texts(texts.iter().map(|&t| t.to_owned()).collect());
    written.set("POINT", "LABELS", texts(&["jaw00", "jaw00", "", "jaw00"]));
    let take = read(&written.bytes(), NAME);
    assert_eq!(take.tracks.labels, ["jaw00", "jaw00#2", "#3", "jaw00#3"]);
    assert!(warns(&take, "1 of 4 markers have no label") && warns(&take, "2 of 4 markers repeat the label"));

    written.set("POINT", "LABELS", texts(&["jaw00"]));
    assert_eq!(read(&written.bytes(), NAME).tracks.labels, ["jaw00", "#2", "#3", "#4"]);
    written.remove("POINT", "LABELS");
    let take = read(&written.bytes(), NAME);
    assert_eq!(take.tracks.labels, ["#1", "#2", "#3", "#4"]);
    assert!(warns(&take, "4 of 4 markers have no label"), "{:?}", take.warnings);
}

#[test]
fn units_that_are_missing_or_unknown() {
    let mut written = trial(2, 6);
    for (unit, metres) in [("m", Some(1.0)), ("cm", Some(0.01)), ("inches", Some(0.0254)), ("cubits", None)] {
        written.set("POINT", "UNITS", Value::Texts(vec![unit.into()]));
        let take = read(&written.bytes(), NAME);
        assert_eq!(take.metres_per_unit, metres, "{unit}");
        assert_eq!(take.warnings.len(), usize::from(metres.is_none()));
    }
    written.remove("POINT", "UNITS");
    let take = read(&written.bytes(), NAME);
    assert_eq!(take.metres_per_unit, None);
    assert!(warns(&take, "POINT:UNITS names no unit"), "{:?}", take.warnings);
}

#[test]
fn rates_that_contradict_each_other_or_are_none() {
    let mut written = trial(2, 6);
    let second = |written: &C3d| read(&written.bytes(), NAME).tracks.times[1];
    written.header.rate = Some(60.0);
    assert_eq!(second(&written), 1.0 / 120.0);
    assert!(warns(&read(&written.bytes(), NAME), "120 by POINT:RATE and 60 by the header; 120 is used"));
    written.set("TRIAL", "CAMERA_RATE", Value::Floats(vec![100.0]));
    assert!(warns(&read(&written.bytes(), NAME), "and 60 by the header and 100 by TRIAL:CAMERA_RATE"));

    written.set("POINT", "RATE", Value::Floats(vec![0.0]));
    assert_eq!(second(&written), 1.0 / 60.0);
    assert!(warns(&read(&written.bytes(), NAME), "POINT:RATE is 0"));
    written.header.rate = Some(f32::NAN);
    assert_eq!(second(&written), 1.0 / 100.0);
    written.remove("TRIAL", "CAMERA_RATE");
    has_no_rate(&written.bytes(), NAME);

    let given = decode(&written.bytes(), NAME, Some(50.0)).unwrap();
    assert_eq!(given.tracks.times[1], 1.0 / 50.0);
    assert_eq!(given.warnings, [""; 0]);
    assert!(decode(&written.bytes(), NAME, Some(0.0)).is_err());
    assert!(decode(&written.bytes(), NAME, Some(f64::NAN)).is_err());
}

#[test]
fn no_frames_and_no_markers() {
    let mut written = trial(2, 0);
    written.header.frames = Some((1, 0));
    written.header.points = Some(2);
    written.set("POINT", "USED", Value::Words(vec![2]));
    for tail in [0, 512, 5120] {
        written.tail = Some(tail);
        assert!(refused(&written.bytes(), NAME).contains("has no frames"));
    }
    let written = C3d { analog: 4, ..trial(0, 5) };
    assert!(refused(&written.bytes(), NAME).contains("has no markers"));
    assert!(refused(b"", NAME).contains("cut short"));
    assert!(refused(&[b'x'; 2048], NAME).contains("no C3D file"));
}

/// The trial as it is when nothing is wrong with it.
fn sound() -> (C3d, rhytid_core::RawTake) {
    let mut written = trial(31, 100);
    written.analog = 3;
    written.set("ANALOG", "USED", Value::Words(vec![3]));
    let take = read(&written.bytes(), NAME);
    (written, take)
}

#[test]
fn header_and_parameters_that_disagree_are_settled_by_the_size() {
    let (written, sound) = sound();
    type Change = fn(&mut C3d);
    let cases: [(&str, Change); 9] = [
        ("the number of points", |c| c.header.points = Some(30)),
        ("the number of points", |c| c.set("POINT", "USED", Value::Words(vec![62]))),
        ("the number of frames", |c| c.header.frames = Some((1, 77))),
        ("the number of frames", |c| c.set("POINT", "FRAMES", Value::Words(vec![12_345]))),
        ("the number of frames", |c| c.set("POINT", "LONG_FRAMES", Value::Floats(vec![1e6]))),
        ("the byte at which", |c| c.header.data_block = Some(20)),
        ("the byte at which", |c| c.set("POINT", "DATA_START", Value::Words(vec![9]))),
        ("the storage of", |c| c.header.scale = Some(0.1)),
        ("the number of analog", |c| c.header.analog = Some(0)),
    ];
    for (what, change) in cases {
        let mut wrong = written.clone();
        change(&mut wrong);
        let take = read(&wrong.bytes(), NAME);
        assert!(warns(&take, what), "{what}: {:?}", take.warnings);
        assert_eq!(format!("{:?}", take.tracks), format!("{:?}", sound.tracks), "{what}");
    }
    // A place that cannot be is no claim.
    for block in [0, 1, 60_000] {
        let mut wrong = written.clone();
        wrong.header.data_block = Some(block);
        assert_eq!(format!("{:?}", read(&wrong.bytes(), NAME).tracks), format!("{:?}", sound.tracks));
    }
}

#[test]
fn a_file_that_is_cut_at_any_block() {
    let (written, sound) = sound();
    let bytes = written.bytes();
    let frame = (31 * 4 + 3) * 4;
    let start = bytes.len() - (100_usize * frame).next_multiple_of(512);
    let m = 31;
    for cut in (0..bytes.len()).step_by(512) {
        let there = cut.saturating_sub(start) / frame;
        if there == 0 {
            let message = refused(&bytes[..cut], NAME);
            assert!(message.contains("cut short"), "{cut}: {message}");
            continue;
        }
        let take = read(&bytes[..cut], NAME);
        assert_eq!(take.tracks.frames(), there.min(100));
        let whole = there >= 100;
        assert!(
            whole || warns(&take, &format!("{there} of its 100 frames are there")),
            "{:?}",
            take.warnings
        );
        let positions = format!("{:?}", &sound.tracks.positions[..there.min(100) * m]);
        assert_eq!(format!("{:?}", take.tracks.positions), positions);
    }
}

#[test]
fn every_cut_and_every_changed_byte_before_the_points_gives_a_sound_take_or_a_sentence() {
    let bytes = trial(3, 20).bytes();
    let section = 1024;
    for cut in 0..bytes.len() {
        let _ = decode(&bytes[..cut], NAME, None).map(|take| super::check(&take));
    }
    for at in 0..section {
        for change in [0x01, 0x80, 0xFF, 0x7F] {
            let mut wrong = bytes.clone();
            wrong[at] ^= change;
            let _ = decode(&wrong, NAME, None).map(|take| super::check(&take));
        }
    }
}

#[test]
fn damaged_parameters_are_read_up_to_the_damage() {
    let mut written = trial(2, 6);
    let places: Vec<usize> = {
        let bytes = written.bytes();
        (0..1024).filter(|&i| bytes[i..].starts_with(b"UNITS")).collect()
    };
    // The offset behind the name leads out of the section.
    let mut bytes = written.bytes();
    bytes[places[0] + 5..places[0] + 7].copy_from_slice(&[0xFF, 0xFF]);
    let take = read(&bytes, NAME);
    assert!(warns(&take, "parameters are damaged"), "{:?}", take.warnings);
    assert_eq!((take.tracks.frames(), take.tracks.labels[0].as_str()), (6, "#1"));

    written.processor = 0;
    assert!(warns(&read(&written.bytes(), NAME), "84 is used"));
}

#[test]
fn a_parameter_section_of_more_than_255_blocks() {
    let mut written = trial(2, 6);
    let long = Value::Texts(vec!["x".repeat(255); 255]);
    for name in ["DESCRIPTIONS", "DESCRIPTIONS2", "DESCRIPTIONS3"] {
        written.parameters.insert(0, ("POINT", name, long.clone()));
    }
    let bytes = written.bytes();
    assert!(bytes.len() / 512 > 256, "{}", bytes.len() / 512);
    let take = read(&bytes, NAME);
    assert_eq!(take.tracks.labels, ["a0", "a1"]);
}

#[test]
fn the_size_of_the_file_decides_where_the_points_begin() {
    let (written, sound) = sound();
    let true_block = {
        let bytes = written.bytes();
        u16::from_le_bytes([bytes[16], bytes[17]])
    };
    let same = |wrong: &C3d, what: &str| {
        let take = read(&wrong.bytes(), NAME);
        assert_eq!(
            format!("{:?}", take.tracks),
            format!("{:?}", sound.tracks),
            "{what}: {:?}",
            take.warnings
        );
        take
    };
    // The section claims more or fewer blocks than it has.
    for blocks in [0, 1, 8, 60] {
        let mut wrong = written.clone();
        wrong.header.parameter_blocks = Some(blocks);
        let take = same(&wrong, &format!("{blocks} blocks"));
        let true_end = u16::from(blocks) + 1 >= true_block;
        assert_eq!(take.warnings.len(), usize::from(true_end), "{blocks}: {:?}", take.warnings);
        assert!(!true_end || warns(&take, "the byte at which the points begin"), "{:?}", take.warnings);
    }
    // More blocks than the file has are no statement of a place.
    let mut wrong = written.clone();
    wrong.header.parameter_blocks = Some(255);
    assert_eq!(same(&wrong, "255 blocks").warnings, [""; 0]);
    // No place is right; header and parameters may agree on a wrong one.
    for (header, parameter, blocks) in [(20, 30, 9), (20, 20, 9), (20, 20, 1), (2, 2, 200), (1, 60_000, 8)] {
        let mut wrong = written.clone();
        wrong.header.data_block = Some(header);
        wrong.set("POINT", "DATA_START", Value::Words(vec![parameter]));
        wrong.header.parameter_blocks = Some(blocks);
        let take = same(&wrong, &format!("{header}, {parameter}, {blocks}"));
        assert!(warns(&take, "which fits"), "{:?}", take.warnings);
    }
    // Blocks behind the last frame move nothing.
    let trailing = C3d { tail: Some(5 * 512), ..written.clone() };
    assert_eq!(same(&trailing, "blocks behind").warnings, [""; 0]);
}

#[test]
fn blocks_behind_the_last_frame_move_nothing_if_no_marker_is_seen_at_first() {
    let mut written = trial(8, 100);
    // Five blocks of zeros, which could as well be spare blocks of the parameters.
    for (position, fourth) in written.frames[..20].iter_mut().flatten() {
        (*position, *fourth) = ([0.0; 3], 0);
    }
    let sound = read(&written.bytes(), NAME);
    let trailing = C3d { tail: Some(5 * 512), ..written };
    let take = read(&trailing.bytes(), NAME);
    assert_eq!(format!("{:?}", take.tracks), format!("{:?}", sound.tracks), "{:?}", take.warnings);
    assert_eq!(take.warnings, [""; 0]);
}

#[test]
fn spare_blocks_of_the_parameters_are_no_points_if_the_file_is_cut() {
    let mut written = trial(8, 100);
    let sound = read(&written.bytes(), NAME);
    let start = written.bytes().len() - (100 * 8 * 16_usize).next_multiple_of(512);
    let block = (start / 512 + 1 + 5) as u16;
    written.header.data_block = Some(block);
    written.set("POINT", "DATA_START", Value::Words(vec![block]));
    let mut bytes = written.bytes();
    bytes.splice(start..start, [0; 5 * 512]);
    assert_eq!(format!("{:?}", read(&bytes, NAME).tracks), format!("{:?}", sound.tracks));
    bytes.truncate(bytes.len() - 2 * 512);
    let take = read(&bytes, NAME);
    assert_eq!(take.tracks.frames(), 92);
    assert_eq!(
        format!("{:?}", take.tracks.positions),
        format!("{:?}", &sound.tracks.positions[..92 * 8]),
        "{:?}",
        take.warnings
    );
    assert!(warns(&take, "92 of its 100 frames are there"), "{:?}", take.warnings);
}

#[test]
fn positions_that_all_count_as_not_seen_are_told() {
    let mut written = trial(3, 6);
    for (_, fourth) in written.frames.iter_mut().flatten() {
        *fourth = -1;
    }
    let take = read(&written.bytes(), NAME);
    assert!(take.tracks.positions.iter().all(|p| p[0].is_nan()));
    // One point of the trial has no position either.
    assert!(warns(&take, "every point has a residual below 0"), "{:?}", take.warnings);
    written.frames[0][0].1 = 0;
    assert!(!warns(&read(&written.bytes(), NAME), "every point has a residual below 0"));
    let gaps = written.frames.iter_mut().flatten();
    gaps.for_each(|point| *point = ([0.0; 3], -1));
    assert!(!warns(&read(&written.bytes(), NAME), "every point has a residual below 0"));
}

#[test]
fn points_that_a_model_computed_are_left_out() {
    let texts = |texts: &[&str]| Value::Texts(texts.iter().map(|&t| t.to_owned()).collect());
    let mut written = trial(6, 10);
    written.set("POINT", "LABELS", texts(&["jaw00", "LKneeAngles", "lip", "COM", "Work", "cap"]));
    let all = read(&written.bytes(), NAME);
    assert_eq!(all.tracks.labels.len(), 6);
    written.set("POINT", "ANGLES", texts(&["LKneeAngles", "RKneeAngles"]));
    written.set("POINT", "MODELED_MARKERS", texts(&["COM"]));
    written.set("POINT", "TYPE_GROUPS", texts(&["ANGLES", "ANGLE_UNITS", "WORK", "WORK_UNITS"]));
    written.set("POINT", "WORK", texts(&["Work"]));
    let take = read(&written.bytes(), NAME);
    assert_eq!(take.tracks.labels, ["jaw00", "lip", "cap"]);
    for frame in 0..10 {
        let [three, six] =
            [&take.tracks.positions[3 * frame..][..3], &all.tracks.positions[6 * frame..][..6]];
        assert_eq!(format!("{three:?}"), format!("{:?}", [six[0], six[2], six[5]]), "{frame}");
    }
    assert!(warns(&take, "3 of 6 points are computed by a model"), "{:?}", take.warnings);
    assert!(
        warns(&take, "1 by POINT:ANGLES, 1 by POINT:MODELED_MARKERS, 1 by POINT:WORK"),
        "{:?}",
        take.warnings
    );
    // A list goes on in parameters with a number.
    written.set("POINT", "ANGLES2", texts(&["cap"]));
    assert_eq!(read(&written.bytes(), NAME).tracks.labels, ["jaw00", "lip"]);
    written.remove("POINT", "ANGLES2");
    // A file of virtual points alone is a take; one of angles alone is none.
    let labels = ["jaw00", "LKneeAngles", "lip", "COM", "Work", "cap"];
    written.set("POINT", "MODELED_MARKERS", texts(&labels));
    written.remove("POINT", "ANGLES");
    written.remove("POINT", "WORK");
    assert_eq!(read(&written.bytes(), NAME).tracks.labels, labels);
    written.remove("POINT", "MODELED_MARKERS");
    written.set("POINT", "ANGLES", texts(&labels));
    assert!(refused(&written.bytes(), NAME).contains("its 6 points are computed by a model"));
}
