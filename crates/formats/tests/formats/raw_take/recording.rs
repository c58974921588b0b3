//! The place of a take in its session: first frame, time code, start and events.
use super::c3d_writer::{Value, trial};
use super::read;
use rhytid_core::RawTake;

fn events(take: &RawTake) -> Vec<(&str, f64)> {
    take.recording.events.iter().map(|event| (event.name.as_str(), event.time)).collect()
}

fn texts(texts: &[&str]) -> Value {
    Value::Texts(texts.iter().map(|&text| text.to_owned()).collect())
}

#[test]
fn a_c3d_file_has_a_time_code_and_events() {
    let mut written = trial(2, 8);
    written.header.frames = Some((241, 248));
    for (name, value) in [("HOURS", 1), ("MINUTES", 2), ("SECONDS", 3), ("FRAMES", 4), ("SUBFRAMES", 2)] {
        written.set("TIMECODE", name, Value::Words(vec![value]));
    }
    written.set("TIMECODE", "STANDARD", texts(&["NTSC drop"]));
    written.set("EVENT", "USED", Value::Words(vec![2]));
    written.set("EVENT", "LABELS", texts(&["Foot Strike", "Clap", "unused"]));
    written.set("EVENT", "CONTEXTS", texts(&["Left", "", ""]));
    // Minutes and seconds of each; the last pair is beyond USED.
    written.set("EVENT", "TIMES", Value::FloatPairs(vec![[0.0, 4.5], [1.0, 2.25], [9.0, 9.0]]));
    let take = read(&written.bytes(), "a.c3d");
    let timecode = take.recording.timecode.unwrap();
    assert_eq!(timecode.to_string(), "01:02:03;04.2");
    assert_eq!(timecode.rate, Some(30000.0 / 1001.0));
    assert_eq!(take.recording.first_frame, Some(241));
    // By hand: 30 · 3723 + 4 numbers, of which 2 · 56 are dropped, at 30 / 1.001 a second, and 2 frames of
    // 120 a second. The file's own times begin at 2 s.
    let start = 111_582.0 * 1.001 / 30.0 + 2.0 / 120.0;
    assert!((take.tracks.times[0] - start).abs() < 1e-9, "{}", take.tracks.times[0]);
    let expected = [("Left Foot Strike", start + 2.5), ("Clap", start + 60.25)];
    for (found, expected) in events(&take).into_iter().zip(expected) {
        assert!(found.0 == expected.0 && (found.1 - expected.1).abs() < 1e-9, "{found:?} {expected:?}");
    }
    assert_eq!((events(&take).len(), take.tracks.rate()), (2, 120.0));

    // 75 minutes are no time code.
    written.set("TIMECODE", "MINUTES", Value::Words(vec![75]));
    let take = read(&written.bytes(), "a.c3d");
    assert_eq!((take.recording.timecode, take.tracks.times[0]), (None, 2.0));

    let mut written = trial(2, 8);
    written.set("SMPTE", "TIMECODE", texts(&["23:59:58:24"]));
    written.set("SMPTE", "RATE", Value::Floats(vec![25.0]));
    let take = read(&written.bytes(), "a.c3d");
    let timecode = take.recording.timecode.unwrap();
    assert_eq!((timecode.to_string().as_str(), timecode.rate), ("23:59:58:24", Some(25.0)));
    // The code of a standard is no rate.
    written.set("SMPTE", "RATE", Value::Floats(vec![2.0]));
    let take = read(&written.bytes(), "a.c3d");
    assert_eq!(take.recording.timecode.unwrap().rate, None);
}

#[test]
fn events_of_the_header_count_where_the_group_has_none() {
    let mut bytes = trial(2, 8).bytes();
    let put = |bytes: &mut Vec<u8>, word: usize, value: &[u8]| {
        bytes[2 * word - 2..2 * word - 2 + value.len()].copy_from_slice(value);
    };
    put(&mut bytes, 151, &2_u16.to_le_bytes());
    put(&mut bytes, 153, &1.5_f32.to_le_bytes());
    put(&mut bytes, 155, &4.25_f32.to_le_bytes());
    put(&mut bytes, 199, b"CLAPEND ");
    assert_eq!(events(&read(&bytes, "a.c3d")), []);
    // The key says that the words are events.
    put(&mut bytes, 150, &12345_u16.to_le_bytes());
    assert_eq!(events(&read(&bytes, "a.c3d")), [("CLAP", 1.5), ("END", 4.25)]);
    put(&mut bytes, 151, &60_000_u16.to_le_bytes());
    assert_eq!(events(&read(&bytes, "a.c3d")).len(), 18);
}

#[test]
fn text_formats_have_a_start_or_events() {
    let qualisys = "NO_OF_FRAMES\t2\nNO_OF_MARKERS\t1\nFREQUENCY\t100\nTIME_STAMP\t2024-01-01, 10:00:00.000\t12.5\n\
        EVENT\tclap\t51\t0.50500\nEVENT\tend\t101\nDATA_INCLUDED\t3D\nMARKER_NAMES\tjaw00\n\
        Frame\tTime\tSMPTE\tjaw00 X\tjaw00 Y\tjaw00 Z\n1\t0.00000\t10:00:00:12.3\t1\t2\t3\n2\t0.01\t10:00:00:13.0\t1\t2\t3\n";
    for text in [qualisys.to_owned(), qualisys.replace("Frame\tTime\tSMPTE\tjaw00 X\tjaw00 Y\tjaw00 Z\n", "")]
    {
        let take = read(text.as_bytes(), "a.tsv");
        assert_eq!(take.warnings, [""; 0]);
        assert_eq!(take.tracks.positions[0], [1.0, 2.0, 3.0]);
        assert_eq!(take.recording.started.as_deref(), Some("2024-01-01, 10:00:00.000"));
        assert_eq!(take.recording.timecode.unwrap().to_string(), "10:00:00:12.3");
        // Without a rate of the time code, its frames are the take's: 12 and 3 of 100 a second.
        assert!((take.tracks.times[0] - 36_000.15).abs() < 1e-9);
        for (found, expected) in events(&take).into_iter().zip([("clap", 36_000.655), ("end", 36_001.15)]) {
            assert!(found.0 == expected.0 && (found.1 - expected.1).abs() < 1e-9, "{found:?} {expected:?}");
        }
    }
    let motive = "Format Version,1.23,Capture Start Time,2024-01-01 10.00.00.000 AM,Capture Start Frame,77,\
        Export Frame Rate,100,Length Units,Meters\n,Type,Marker,Marker,Marker\n,Name,a,a,a\n\
        ,,Position,Position,Position\nFrame,Time,X,Y,Z\n0,0,1,2,3\n1,0.01,1,2,3\n";
    let take = read(motive.as_bytes(), "a.csv");
    assert_eq!(take.recording.started.as_deref(), Some("2024-01-01 10.00.00.000 AM"));
    assert_eq!(take.recording.first_frame, Some(77));
    let trc = |orig: &str, number: usize, digits: &str| {
        format!(
            "PathFileType\t4\nDataRate\tUnits\tOrigDataStartFrame\n100\tmm\t{orig}\nFrame#\tTime\ta\t\t\n\
             \t\tX1\tY1\tZ1\n{number}{digits}\t{}\t1\t2\t3\n",
            (number - 1) as f64 / 100.0
        )
    };
    for digits in ["", ".000"] {
        let first = |orig, number| read(trc(orig, number, digits).as_bytes(), "a.trc").recording.first_frame;
        assert_eq!(first("241", 1), Some(241));
        assert_eq!(first("1", 500), Some(500));
    }
}
