//! Tables of markers as other people write them, against values that are written by hand.
use rhytid_core::{InputErrorKind, RawTake};
use rhytid_takes::raw_take::{Contents, contents, decode};
use std::fmt::Write;

/// Reads a file that must be sound.
#[track_caller]
fn read(bytes: &[u8], name: &str) -> RawTake {
    let take = decode(bytes, name, None).unwrap();
    let tracks = &take.tracks;
    assert_eq!(tracks.positions.len(), tracks.frames() * tracks.labels.len());
    assert!(tracks.confidence.as_ref().is_none_or(|c| c.len() == tracks.positions.len()));
    assert!(tracks.times.windows(2).all(|pair| pair[0] < pair[1]));
    take
}

/// The sentence of a file that cannot be read.
#[track_caller]
fn refused(bytes: &[u8], name: &str) -> String {
    let sentence = decode(bytes, name, None).unwrap_err().to_string();
    assert!(sentence.starts_with(name), "{sentence}");
    sentence
}

fn warns(take: &RawTake, words: &str) -> bool {
    take.warnings.iter().any(|warning| warning.contains(words))
}

/// Two markers in three frames; `b` is not seen in the second.
#[track_caller]
fn is_the_small_take(take: &RawTake) {
    let tracks = &take.tracks;
    assert_eq!(tracks.labels, ["a", "b"]);
    for (found, expected) in tracks.times.iter().zip([0.0, 0.04, 0.08]) {
        assert!((found - expected).abs() < 1e-12, "{:?}", tracks.times);
    }
    let expected =
        [[1.5, 2.0, 3.0], [4.0, 5.0, 6.0], [1.25, 2.0, 3.0], [f64::NAN; 3], [1.0, 2.0, -3.5], [4.0; 3]];
    for (found, expected) in tracks.positions.iter().flatten().zip(expected.iter().flatten()) {
        assert!(found == expected || found.is_nan() && expected.is_nan(), "{:?}", tracks.positions);
    }
    assert!(!take.in_head_space && !take.is_video);
}

#[test]
fn a_row_for_each_frame_and_marker_in_any_order_and_spelling() {
    is_the_small_take(&read(
        b"marker,x,y,z,frame,time\na,1.5,2,3,10,0\nb,4,5,6,10,0\na,1,2,-3.5,12,0.08\nb,4,4,4,12,0.08\na,1.25,2,3,11,0.04\n",
        "long.csv",
    ));
    is_the_small_take(&read(
        b"\xEF\xBB\xBFTime (ms);Label;Pos_X;Pos_Y;Pos_Z\n0;a;1,5;2;3\n0;b;4;5;6\n40;a;1,25;2;3\n40;b;;;\n80;a;1;2;-3,5\n80;b;4;4;4\n",
        "long.csv",
    ));
    let no_times =
        b"frame\tname\tx\ty\tz\n5\ta\t1.5\t2\t3\n5\tb\t4\t5\t6\n6\ta\t1.25\t2\t3\n6\tb\tNaN\tNaN\tNaN\n\
                     7\ta\t1\t2\t-3.5\n7\tb\t4\t4\t4\n";
    let Err(rhytid_core::Error::Input(error)) = decode(no_times, "long.csv", None) else { panic!("no rate") };
    assert_eq!(error.kind(), &InputErrorKind::NoFrameRate, "{error}");
    is_the_small_take(&decode(no_times, "long.csv", Some(25.0)).unwrap());
}

#[test]
fn confidence_and_time_codes_follow_their_rows() {
    let long =
        b"Frame,Timecode,Marker,X,Y,Z,Confidence\n12,10:00:01:01,a,3,2,3,0.25\n10,10:00:00:29,a,1,2,3,1\n\
                 11,10:00:01:00,a,2,2,3,0\n";
    let take = read(long, "long.csv");
    for (time, frame) in take.tracks.times.iter().zip(0..3) {
        assert!((time - f64::from(frame) / 30.0).abs() < 1e-9, "{:?}", take.tracks.times);
    }
    assert_eq!((take.tracks.positions[0], take.tracks.positions[2]), ([1.0, 2.0, 3.0], [3.0, 2.0, 3.0]));
    assert!(take.tracks.positions[1][0].is_nan());
    assert_eq!(take.tracks.confidence, Some(vec![1.0, 1.0, 0.25]));
    let wide = |sure: [&str; 2]| {
        let [a, b] = sure;
        let table = format!("frame,t,a.x,a.y,a.z,a.visibility\n1,0,1,2,3,{a}\n2,0.04,1,2,4,{b}\n");
        read(table.as_bytes(), "wide.csv").tracks
    };
    assert_eq!(wide(["1", "0.5"]).confidence, Some(vec![1.0, 0.5]));
    assert!(wide(["1", "0"]).positions[1][0].is_nan());
    // A visibility that is always 0 says nothing.
    let unused = wide(["0", "0"]);
    assert_eq!((unused.positions[1], unused.confidence), ([1.0, 2.0, 4.0], None));
}

#[test]
fn a_row_for_each_frame_in_many_spellings() {
    for header in [
        "frame,time,a_x,a_y,a_z,b_x,b_y,b_z",
        "Frame,Time,a.X,a.Y,a.Z,b.X,b.Y,b.Z",
        "FRAME,Seconds,X_a,Y_a,Z_a,X_b,Y_b,Z_b",
        "frame,t,a:x,a:y,a:z,b:x,b:y,b:z",
        "frame,timestamp,a (x),a (y),a (z),b (x),b (y),b (z)",
        "frame,time_s,a tx,a ty,a tz,b tx,b ty,b tz",
    ] {
        let header = header.replace("time_s", "time_sec");
        let table = format!("{header}\n1,0,1.5,2,3,4,5,6\n2,0.04,1.25,2,3,0,0,0\n3,0.08,1,2,-3.5,4,4,4\n");
        // A table with the column time and LABEL_x is the take's own.
        if !header.contains(",time,a_x") {
            is_the_small_take(&read(table.as_bytes(), "wide.csv"));
        }
    }
    // Tabs between cells are no sign of Qualisys.
    is_the_small_take(&read(
        b"frame\ttimestamp\ta_x\ta_y\ta_z\tb_x\tb_y\tb_z\n1\t0\t1.5\t2\t3\t4\t5\t6\n\
          2\t0.04\t1.25\t2\t3\t\t\t\n3\t0.08\t1\t2\t-3.5\t4\t4\t4\n",
        "wide.tsv",
    ));
    let take = read(b"frame;note;a_x_mm;a_y_mm;a_z_mm;time\n1;;1,5;2;3;0\n2;;1;2;3;0,04\n", "wide.csv");
    assert_eq!((take.metres_per_unit, take.tracks.positions[0]), (Some(1e-3), [1.5, 2.0, 3.0]));
    assert!(warns(&take, "1 columns are no positions and are left out: \"note\""), "{:?}", take.warnings);
}

#[test]
fn faults_of_tables_are_named() {
    let sentence = refused(b"frame,time,a.x,a.y,a.z\n1,0,1,2,q\n", "wide.csv");
    assert!(sentence.contains("wide.csv, line 2: \"a.z\" is \"q\", expected a coordinate"), "{sentence}");
    let sentence = refused(b"frame,marker,x,y,z\n", "long.csv");
    assert!(sentence.contains("long.csv: has no frames"), "{sentence}");
    let twice = b"frame,time,marker,x,y,z\n1,0,a,1,2,3\n1,0,a,9,9,9\n2,0.1,a,1,2,3\n";
    let take = read(twice, "long.csv");
    assert_eq!(take.tracks.positions[0], [1.0, 2.0, 3.0]);
    assert!(warns(&take, "1 rows repeat the frame and the marker"), "{:?}", take.warnings);
    let still = refused(b"frame,time,a.x,a.y,a.z\n1,5,1,2,3\n2,5,1,2,3\n3,5,1,2,3\n", "wide.csv");
    assert!(still.contains("do not increase from row to row in 2 of 3 rows; give the frame rate"), "{still}");
    let clock = refused(b"frame,time,a.x,a.y,a.z\n1,10:00:00.5,1,2,3\n", "wide.csv");
    assert!(clock.contains("line 2: the time is \"10:00:00.5\", expected a number of seconds"), "{clock}");
    let curves = refused(b"Timecode,BlendShapeCount,JawOpen\n0,1,0.5\n", "curves.csv");
    assert!(curves.contains("holds curves, which are weights of shapes and no places"), "{curves}");
}

#[test]
fn cells_beyond_the_header_are_refused_and_a_cut_row_is_left_out() {
    // Decimal commas between commas would move each cell behind them.
    for (table, name) in [
        (&b"frame,time,a.x,a.y,a.z\n1,0,1,5,2,0,3,0\n"[..], "wide.csv"),
        (b"frame,time,marker,x,y,z\n1,0,a,1,5,2,3\n", "long.csv"),
    ] {
        let sentence = refused(table, name);
        assert!(sentence.contains("line 2: the row has"), "{sentence}");
        assert!(sentence.contains("separate the cells by semicolons or tabs"), "{sentence}");
    }
    for (table, name) in [
        (&b"frame,time,a.x,a.y,a.z\n1,0,1,2,3,,\n2,0.04,1,2"[..], "wide.csv"),
        (b"frame,time,marker,x,y,z\n1,0,a,1,2,3\n2,0.04,a,1,2", "long.csv"),
    ] {
        let take = read(table, name);
        assert_eq!((take.tracks.frames(), take.tracks.positions[0]), (1, [1.0, 2.0, 3.0]));
        assert!(warns(&take, "cut short in its last row"), "{:?}", take.warnings);
    }
    let mut cut = openface();
    cut.truncate(cut.len() - 20);
    assert!(warns(&read(cut.as_bytes(), "openface.csv"), "cut short in its last row"));
}

#[test]
fn each_word_for_not_seen_is_a_gap_in_tables_too() {
    for word in ["", "NaN", "-nan(ind)", "1.#QNAN", "null", "inf", "1.7976931348623157e308"] {
        let table = format!("frame,time,a.x,a.y,a.z\n1,0,1,2,3\n2,0.04,{word},2,3\n");
        let take = read(table.as_bytes(), "wide.csv");
        assert!(take.tracks.positions[1].iter().all(|x| x.is_nan()), "{word}: {:?}", take.tracks.positions);
    }
    assert!(refused(b"frame,time,a.x,a.y,a.z\n1,0,Nancy,2,3\n", "wide.csv").contains("\"Nancy\""));
}

#[test]
fn a_marker_at_the_origin_is_asked_about_in_tables_too() {
    let table = |a: &dyn Fn(usize) -> f64| {
        let rows: String =
            (0..40).map(|i| format!("{i},{:.2},{},0,0,50,{i},7\n", i as f64 / 25.0, a(i))).collect();
        read(format!("frame,time,a.x,a.y,a.z,b.x,b.y,b.z\n{rows}").as_bytes(), "wide.csv")
    };
    let gaps = |take: &RawTake| take.tracks.positions.iter().filter(|p| p[0].is_nan()).count();
    let rests = table(&|i| 20_usize.saturating_sub(i) as f64);
    assert_eq!(gaps(&rests), 0);
    assert!(warns(&rests, "come to rest at exactly 0, 0, 0"), "{:?}", rests.warnings);
    let never = table(&|_| 0.0);
    assert_eq!(gaps(&never), 40);
    assert!(warns(&never, "are at 0, 0, 0 in every frame and count as never seen: \"a\""));
    let jumps = table(&|i| if i == 9 { 0.0 } else { 80.0 });
    assert_eq!(gaps(&jumps), 1);
}

#[test]
fn rounded_times_become_even_and_a_given_rate_counts_frames() {
    // Frame 5 was left out, and the times have milliseconds.
    let frames: Vec<u32> = (0..60).filter(|&i| i != 5).collect();
    let rows: String =
        frames.iter().map(|&i| format!("{},{:.3},{i},2,3\n", 100 + i, f64::from(i) / 120.0)).collect();
    let table = format!("frame,timestamp,a.x,a.y,a.z\n{rows}");
    let check = |take: &RawTake, rate: f64| {
        for (time, &frame) in take.tracks.times.iter().zip(&frames) {
            assert!((time - f64::from(frame) / rate).abs() < 1e-9, "{:?}", take.tracks.times);
        }
    };
    check(&read(table.as_bytes(), "wide.csv"), 120.0);
    check(&decode(table.as_bytes(), "wide.csv", Some(60.0)).unwrap(), 60.0);
}

#[test]
fn times_in_small_units_and_rotations_are_told_apart() {
    let rows: String =
        (0..20).map(|i| format!("{},1,2,3,90,0,{i}\n", 1_700_000_000_000_000_u64 + 40_000 * i)).collect();
    let header = |time: &str| format!("{time},a_pos_x,a_pos_y,a_pos_z,a_rot_x,a_rot_y,a_rot_z\n{rows}");
    for time in ["timestamp_us", "Time (µs)", "timestamp"] {
        let take = read(header(time).as_bytes(), "wide.csv");
        assert_eq!(take.tracks.labels, ["a"]);
        assert!((take.tracks.times[19] - 0.76).abs() < 1e-6, "{:?}", take.tracks.times);
        assert_eq!(warns(&take, "look like microseconds"), time == "timestamp", "{:?}", take.warnings);
        assert!(
            warns(&take, "3 columns are no positions and are left out: \"a_rot_x\""),
            "{:?}",
            take.warnings
        );
    }
}

#[test]
fn a_hostile_table_takes_no_room() {
    // Each row has a frame and a marker of its own.
    let mut long = "frame,time,marker,x,y,z\n".to_owned();
    for i in 0..30_000 {
        writeln!(long, "{i},{i},m{i},1,1,1").unwrap();
    }
    let sentence = refused(long.as_bytes(), "long.csv");
    assert!(sentence.contains("30000 rows for 30000 markers in 30000 frames"), "{sentence}");
    let mut wide = "frame,time".to_owned();
    for i in 0..2_000 {
        write!(wide, ",m{i}.x,m{i}.y,m{i}.z").unwrap();
    }
    for i in 0..20_000 {
        write!(wide, "\n{i},{i}").unwrap();
    }
    wide.push('\n');
    let sentence = refused(wide.as_bytes(), "wide.csv");
    assert!(sentence.contains("the rows are far shorter than the header"), "{sentence}");
    for bytes in [&b"frame,marker,x,y,z\n\xFF,\xFF"[..], b"frame;a.x;a.y;a.z\n;;;", b"x_0,confidence,success"]
    {
        let _ = decode(bytes, "damaged.csv", Some(30.0));
    }
}

/// A table of OpenFace with two faces. The second has more rows and is found only once.
fn openface() -> String {
    let mut csv = "frame, face_id, timestamp, confidence, success, gaze_0_x, x_0".to_owned();
    for axis in ["X", "Y", "Z"] {
        for i in 0..68 {
            write!(csv, ", {axis}_{i}").unwrap();
        }
    }
    for (frame, face, confidence, success) in [
        (1, 0, 0.98, 1),
        (1, 1, 0.9, 1),
        (2, 0, 0.6, 1),
        (2, 1, 0.0, 0),
        (3, 0, 0.1, 0),
        (3, 1, 0.0, 0),
        (4, 1, 0.0, 0),
    ] {
        let time = f64::from(frame - 1) / 25.0;
        write!(csv, "\n{frame}, {face}, {time:.3}, {confidence}, {success}, 0.1, 300.5").unwrap();
        for axis in 0..3 {
            for i in 0..68 {
                write!(csv, ", {}", 100 * (axis + 1) + i + 1000 * face).unwrap();
            }
        }
    }
    csv + "\n"
}

#[test]
fn openface_is_read_as_landmarks_before_the_camera() {
    let csv = openface();
    let take = read(csv.as_bytes(), "openface.csv");
    assert!(take.is_video);
    assert_eq!(take.metres_per_unit, Some(1e-3));
    let tracks = &take.tracks;
    assert_eq!((tracks.labels.len(), &*tracks.labels[30]), (68, "lm30"));
    assert_eq!(tracks.times, [0.0, 0.04, 0.08]);
    // The camera's y points down and its z away from it.
    assert_eq!(tracks.positions[30], [130.0, -230.0, -330.0]);
    assert!(tracks.positions[2 * 68 + 30][0].is_nan());
    let confidence = tracks.confidence.as_ref().unwrap();
    assert_eq!((confidence[0], confidence[68]), (1.0, 0.6));
    assert!(warns(&take, "there are 2 faces; the face 0 is read"), "{:?}", take.warnings);
    let flat = "frame, face_id, timestamp, confidence, success, x_0, y_0\n1, 0, 0, 1, 1, 5, 5\n";
    let sentence = refused(flat.as_bytes(), "openface.csv");
    assert!(sentence.contains("run OpenFace again with its option -3Dfp"), "{sentence}");
}

/// MediaPipe's face as an ellipsoid of its proportions, in parts of an image of 1920 by 1080.
fn mediapipe(extra_header: &str, extra: &str) -> String {
    let mut csv = format!("frame,timestamp_ms{extra_header}");
    for i in 0..478 {
        write!(csv, ",landmark_{i}_x,landmark_{i}_y,landmark_{i}_z").unwrap();
    }
    for frame in 0..2 {
        write!(csv, "\n{frame},{}{extra}", 40 * frame).unwrap();
        for i in 0..478 {
            let [x, y, z] = place(i);
            write!(csv, ",{},{},{}", x / 1920.0, y / 1080.0, z / 1920.0).unwrap();
        }
    }
    csv + "\n"
}

/// A landmark in pixels, y down and z away from the camera. The face is 306.6 wide and 353.4 high.
fn place(i: usize) -> [f64; 3] {
    match i {
        10 => [960.0, 540.0 - 176.7, 0.0],
        152 => [960.0, 540.0 + 176.7, 0.0],
        234 => [960.0 - 153.3, 540.0, 60.0],
        454 => [960.0 + 153.3, 540.0, 60.0],
        1 => [960.0, 560.0, -80.0],
        i => {
            let a = i as f64;
            [960.0 + 100.0 * a.sin(), 540.0 + 120.0 * a.cos(), 20.0 * (2.0 * a).sin()]
        }
    }
}

#[test]
fn mediapipe_is_read_with_equal_axes() {
    let said = read(mediapipe(",width,height", ",1920,1080").as_bytes(), "mesh.csv");
    assert!(said.is_video);
    assert_eq!(said.metres_per_unit, Some(1e-3));
    assert_eq!(said.tracks.labels[33], "mesh33");
    assert_eq!(said.tracks.times, [0.0, 0.04]);
    for (i, found) in said.tracks.positions[..478].iter().enumerate() {
        // The face is 353.4 pixels high, and 176.7 mm in MediaPipe's own face.
        let [x, y, z] = place(i).map(|x| x / 2.0);
        let off = [found[0] - x, found[1] + y, found[2] + z];
        assert!(off.iter().all(|x| x.abs() < 1e-6), "{i}: {found:?}");
    }
    assert!(said.warnings.is_empty(), "{:?}", said.warnings);
    // The face's own proportions tell an image of 16 by 9.
    let unsaid = read(mediapipe("", "").as_bytes(), "mesh.csv");
    assert!(warns(&unsaid, "16 by 9 fits the face best"), "{:?}", unsaid.warnings);
    let flat: Vec<String> = mediapipe(",width,height", ",1920,1080")
        .lines()
        .enumerate()
        .map(|(row, line)| {
            let cells = line.split(',').enumerate();
            // The first four columns are the frame, the time and the image.
            let is_z = |column: usize| row > 0 && column >= 4 && column.is_multiple_of(3);
            cells
                .map(|(i, cell)| if is_z(i) { "0," } else { cell }.trim_end_matches(','))
                .collect::<Vec<_>>()
                .join(",")
        })
        .collect();
    let flat = read((flat.join("\n") + "\n").as_bytes(), "mesh.csv");
    assert!(warns(&flat, "the face is flat: its depth is 0.000 of its width"), "{:?}", flat.warnings);
    let ratio = unsaid.tracks.positions[33][0] / said.tracks.positions[33][0];
    for (a, b) in unsaid.tracks.positions.iter().flatten().zip(said.tracks.positions.iter().flatten()) {
        assert!((a - ratio * b).abs() < 1e-9, "{a} {b} {ratio}");
    }
}

#[test]
fn the_face_is_found_among_the_landmarks_of_a_body() {
    let alone = mediapipe("", "");
    let body = ",pose_0_x,pose_0_y,pose_0_z,pose_1_x,pose_1_y,pose_1_z";
    let rows: Vec<String> = alone
        .lines()
        .enumerate()
        .map(|(i, row)| format!("{row}{}\n", if i == 0 { body } else { ",0.5,0.9,0,0.6,0.9,0" }))
        .collect();
    let (alone, take) = (read(alone.as_bytes(), "mesh.csv"), read(rows.concat().as_bytes(), "mesh.csv"));
    assert!(
        take.is_video && warns(&take, "2 markers are none of the face mesh of 478"),
        "{:?}",
        take.warnings
    );
    assert_eq!(take.tracks, alone.tracks);
}

#[test]
fn a_table_is_known_by_its_header_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.csv");
    for (table, expected) in [
        (openface(), Contents::Raw),
        (mediapipe("", ""), Contents::Raw),
        (mediapipe("", "").replace("timestamp_ms", "time"), Contents::Raw),
        ("time,a_x,a_y,a_z\n0,1,2,3\n".into(), Contents::Take),
        ("Timecode,BlendShapeCount,JawOpen\n".into(), Contents::Curves),
    ] {
        std::fs::write(&path, table).unwrap();
        assert_eq!(contents(&path), expected);
    }
}
