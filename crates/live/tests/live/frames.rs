//! Frames that come in several datagrams, in single messages, without numbers, or from other programs. The
//! bytes are made without the library.

use crate::labels;
use crate::packets::{bundle, handle, head, message, text};
use crate::streams::{NONE, accept};
use rhytid_live::{Counts, Stream};

fn stream(markers: usize) -> Stream {
    Stream::new(&labels(markers), &vec![[9.0; 3]; markers])
}

/// A marker's message in a frame: its x tells both.
fn marker(j: usize, frame: i32) -> Vec<u8> {
    handle(&format!("m{j}"), [x(j, frame), 0.5, -2.0])
}

fn x(j: usize, frame: i32) -> f32 {
    frame as f32 + j as f32 / 8.0
}

/// A bundle of a frame at 100 Hz with some of its markers.
fn part(frame: i32, markers: std::ops::Range<usize>) -> Vec<u8> {
    let markers = markers.map(|j| marker(j, frame));
    bundle(&std::iter::once(head(frame, at(frame))).chain(markers).collect::<Vec<_>>())
}

/// The newest frame has all markers of this frame.
fn is_whole(stream: &Stream, frame: i32) {
    let newest = stream.newest().unwrap();
    let found: Vec<f32> = newest.positions.iter().map(|p| p[0]).collect();
    let expected: Vec<f32> = (0..found.len()).map(|j| x(j, frame)).collect();
    assert_eq!(found, expected);
    assert!(newest.confidence.iter().all(|sure| *sure == 1.0), "{:?}", newest.confidence);
}

fn at(frame: i32) -> f64 {
    f64::from(frame) / 100.0
}

#[test]
fn bundles_of_one_number_are_one_frame() {
    let mut stream = stream(4);
    for frame in 0..5 {
        let first = accept(&mut stream, &part(frame, 0..2), 1, at(frame));
        // Until the sender is known, a frame waits for the next one.
        assert_eq!(first, if frame == 1 { vec![0] } else { vec![] });
        let second = accept(&mut stream, &part(frame, 2..4), 1, at(frame) + 0.001);
        assert_eq!(second, if frame == 0 { vec![] } else { vec![i64::from(frame)] });
        if frame > 0 {
            is_whole(&stream, frame);
            // Each frame takes as long as the fastest one.
            assert!(stream.newest().unwrap().latency < 1e-9, "{:?}", stream.newest());
        }
    }
    assert_eq!(stream.counts(), Counts { frames: 5, ..Counts::default() });

    // A part comes after the next frame has begun: late. A part never comes: the frame waits for its pause.
    assert_eq!(accept(&mut stream, &part(5, 0..2), 1, at(5)), NONE);
    assert_eq!(accept(&mut stream, &part(6, 0..2), 1, at(6)), [5]);
    assert_eq!(accept(&mut stream, &part(5, 2..4), 1, at(6) + 0.001), NONE);
    assert_eq!(accept(&mut stream, &part(6, 2..4), 1, at(6) + 0.002), [6]);
    is_whole(&stream, 6);
    // A frame has come with its last datagram, and the half frame before it had no delay.
    assert!((stream.newest().unwrap().latency - 0.002).abs() < 1e-9, "{:?}", stream.newest());
    assert_eq!(accept(&mut stream, &part(8, 2..4), 1, at(8)), NONE);
    assert!(!stream.close(at(8) + 0.099) && stream.close(at(8) + 0.1001));
    let newest = stream.newest().unwrap();
    assert_eq!((newest.positions[0][0], newest.positions[3][0]), (x(0, 6), x(3, 8)));
    assert!(newest.confidence[0] < 1.0 && newest.confidence[3] == 1.0);
    assert_eq!(stream.counts(), Counts { frames: 8, late: 1, lost: 1, bad: 0, other: 0 });

    // The rest comes after the pause, but before anybody looked: the frame is whole.
    assert_eq!(accept(&mut stream, &part(9, 0..2), 1, at(20)), NONE);
    assert_eq!(accept(&mut stream, &part(9, 2..4), 1, at(60)), [9]);
    is_whole(&stream, 9);
    assert_eq!(stream.counts(), Counts { frames: 9, late: 1, lost: 1, bad: 0, other: 0 });

    // The same part twice is one. A part that contradicts is bad.
    assert_eq!(accept(&mut stream, &part(10, 0..2), 1, at(61)), NONE);
    assert_eq!(accept(&mut stream, &part(10, 0..2), 1, at(61)), NONE);
    let other = bundle(&[head(10, 0.1), handle("m0", [77.0; 3]), marker(2, 10)]);
    assert_eq!(accept(&mut stream, &other, 1, at(61)), NONE);
    assert_eq!(accept(&mut stream, &part(10, 2..4), 1, at(61)), [10]);
    is_whole(&stream, 10);
    assert_eq!(stream.counts(), Counts { frames: 10, late: 1, lost: 1, bad: 1, other: 0 });
    assert!(stream.why_bad().unwrap().contains("another position of a marker of the same frame"));
}

/// A sender whose first frames are one bundle, and later ones two. One part is late before the rest waits.
#[test]
fn a_sender_that_begins_to_split_its_frames_is_waited_for() {
    let mut stream = stream(4);
    for frame in 0..3 {
        accept(&mut stream, &part(frame, 0..2), 1, at(frame));
    }
    assert_eq!(accept(&mut stream, &part(3, 0..2), 1, at(3)), [3]);
    assert_eq!(accept(&mut stream, &part(3, 2..4), 1, at(3)), NONE);
    for frame in 4..9 {
        assert_eq!(accept(&mut stream, &part(frame, 0..2), 1, at(frame)), NONE);
        assert_eq!(accept(&mut stream, &part(frame, 2..4), 1, at(frame)), [i64::from(frame)]);
        is_whole(&stream, frame);
    }
    assert_eq!(stream.counts(), Counts { frames: 9, late: 1, ..Counts::default() });
}

#[test]
fn messages_without_a_bundle_are_a_frame_from_one_frame_message_to_the_next() {
    let mut stream = stream(3);
    assert_eq!(accept(&mut stream, &marker(0, -1), 1, 0.0), NONE);
    assert!(stream.why_bad().unwrap().contains("no /rhytid/frame, and none came before it"));
    for frame in 0..6 {
        let mut given = accept(&mut stream, &head(frame, at(frame)), 1, at(frame));
        // One marker is hidden for a frame.
        for j in (0..3).filter(|j| (*j, frame) != (1, 3)) {
            given.extend(accept(&mut stream, &marker(j, frame), 1, at(frame)));
        }
        let expected: &[i64] = match frame {
            0 | 3 => &[],
            1 => &[0, 1],
            2 => &[2],
            4 => &[3, 4],
            _ => &[5],
        };
        assert_eq!(given, expected, "frame {frame}");
        if !matches!(frame, 0 | 3) {
            is_whole(&stream, frame);
        }
    }
    assert_eq!(stream.counts(), Counts { frames: 6, bad: 1, ..Counts::default() });
}

#[test]
fn numbers_that_stand_still_are_named_and_frames_counted_as_they_come() {
    for is_bundled in [true, false] {
        let mut stream = stream(3);
        for frame in 0..20 {
            let messages = [head(0, at(frame)), marker(0, frame), marker(1, frame), marker(2, frame)];
            if is_bundled {
                accept(&mut stream, &bundle(&messages), 1, at(frame));
            } else {
                messages.iter().for_each(|message| {
                    accept(&mut stream, message, 1, at(frame));
                });
            }
            if frame > 0 {
                // A frame is whole after a pause, or when the next one begins.
                stream.close(at(frame) + 0.0099);
            }
        }
        stream.close(at(20) + 0.02);
        is_whole(&stream, 19);
        let newest = stream.newest().unwrap();
        assert_eq!((newest.number, newest.time), (19, at(19)));
        assert_eq!(stream.counts(), Counts { frames: 20, ..Counts::default() });
        let [said] = stream.warnings() else { panic!("{:?}", stream.warnings()) };
        assert!(said.contains("the number of the frames stays 0 from one frame to the next"), "{said}");
    }
}

/// Positions of other programs: the label in the address or as an argument, bundled or not, with no number.
#[test]
fn positions_of_other_programs_are_frames_where_a_marker_comes_again() {
    let number = |x: f32| x.to_be_bytes();
    let in_address = |j: usize, frame: i32| {
        message(&format!("/marker/m{j}"), ",fff", &[&number(x(j, frame)), &number(0.5), &number(-2.0)])
    };
    let as_tracker = |j: usize, frame: i32| {
        let zero = number(0.0);
        let label = text(&format!("m{j}"));
        message(
            "/VMC/Ext/Tra/Pos",
            ",sfffffff",
            &[&label, &number(x(j, frame)), &zero, &zero, &zero, &zero, &zero, &zero],
        )
    };
    type Make<'a> = &'a dyn Fn(usize, i32) -> Vec<u8>;
    for (pattern, make) in [("/marker/{label}", &in_address as Make<'_>), ("/VMC/Ext/Tra/Pos", &as_tracker)] {
        // One bundle a frame, two bundles a frame, and no bundles.
        for size in [4, 2, 1] {
            let mut stream = stream(4).with_pattern(pattern.parse().unwrap());
            let mut given = Vec::new();
            for frame in 0..50 {
                let messages: Vec<Vec<u8>> = (0..4).map(|j| make(j, frame)).collect();
                for part in messages.chunks(size) {
                    let datagram = if size == 1 { part[0].clone() } else { bundle(part) };
                    given.extend(accept(&mut stream, &datagram, 1, 3.0 + at(frame)));
                }
                // Other messages between.
                accept(
                    &mut stream,
                    &message("/VMC/Ext/OK", ",i", &[&1_i32.to_be_bytes()]),
                    1,
                    3.0 + at(frame),
                );
                if frame > 1 {
                    given.extend(
                        stream.close(3.0 + at(frame) + 0.0026).then(|| stream.newest().unwrap().number),
                    );
                    is_whole(&stream, frame);
                    assert!((stream.newest().unwrap().time - 3.0 - at(frame)).abs() < 1e-9);
                }
            }
            assert_eq!(given, (0..50).collect::<Vec<i64>>(), "{pattern}, {size} in a bundle");
            assert_eq!(stream.counts(), Counts { frames: 50, other: 50, ..Counts::default() });
            assert!(stream.warnings().is_empty(), "{:?}", stream.warnings());
        }
    }
}

#[test]
fn the_addresses_that_came_are_named() {
    let mut ours = stream(1);
    assert_eq!(ours.other_messages(), None);
    for _ in 0..3 {
        accept(&mut ours, &message("/foo/bar", ",f", &[&1.0_f32.to_be_bytes()]), 1, 0.0);
    }
    for i in 0..9 {
        accept(&mut ours, &bundle(&[message(&format!("/other/{i}"), ",", &[])]), 1, 0.0);
    }
    let said = ours.other_messages().unwrap();
    assert!(
        said.starts_with("messages came with the address \"/foo/bar\" (3 of them), \"/other/0\" (1 of them)"),
        "{said}"
    );
    assert!(said.ends_with("and others (7), expected /rhytid/frame and /rhytid/handle"), "{said}");
    let mut bridge = stream(1).with_pattern("/marker/{label}".parse().unwrap());
    accept(&mut bridge, &message("/foo/bar", ",", &[]), 1, 0.0);
    assert!(bridge.other_messages().unwrap().ends_with("expected /marker/{label}"));
}

#[test]
fn labels_are_those_of_files() {
    let mut stream = Stream::new(&["Chin".into(), "brow".into()], &[[9.0; 3]; 2]);
    for frame in 0..3 {
        let markers = [
            handle("Anna:chin", [1.0, 0.0, frame as f32]),
            handle("BROW", [2.0; 3]),
            handle("cap", [3.0; 3]),
        ];
        let messages = std::iter::once(head(frame, at(frame))).chain(markers).collect::<Vec<_>>();
        accept(&mut stream, &bundle(&messages), 1, at(frame));
    }
    let newest = stream.newest().unwrap();
    assert_eq!((newest.positions, newest.confidence), (&[[1.0, 0.0, 2.0], [2.0; 3]][..], &[1.0, 1.0][..]));
}

/// A sender whose number and time are always 0 is understood after a few frames.
#[test]
fn numbers_and_times_that_both_stand_still_are_named() {
    for is_bundled in [true, false] {
        let mut stream = stream(2);
        for frame in 0..60 {
            let messages = [head(0, 0.0), marker(0, frame), marker(1, frame)];
            let datagrams = if is_bundled { vec![bundle(&messages)] } else { messages.to_vec() };
            for datagram in datagrams {
                accept(&mut stream, &datagram, 1, at(frame));
            }
        }
        stream.close(at(60) + 0.1);
        is_whole(&stream, 59);
        let counts = stream.counts();
        assert!(counts.frames > 40, "{counts:?}");
        let newest = stream.newest().unwrap();
        assert!((newest.time - at(59)).abs() < 0.02, "{newest:?}");
        let said = stream.warnings().join("; ");
        assert!(said.contains("the number of the frames stays 0 from one frame to the next"), "{said}");
        assert!(said.contains("the time of the frames stays 0 from one frame to the next"), "{said}");
    }
}

/// Markers of no handle neither begin a frame nor hold one back, and are named where there are no others.
#[test]
fn markers_of_no_handle_are_named_and_hold_no_frame_back() {
    let pattern = || "/marker/{label}".parse().unwrap();
    let message = |label: &str, frame: i32| {
        let x = (frame as f32).to_be_bytes();
        message(&format!("/marker/{label}"), ",fff", &[&x, &x, &x])
    };
    let mut others = stream(2).with_pattern(pattern());
    let mut mixed = stream(2).with_pattern(pattern());
    for frame in 0..50 {
        for label in ["hip", "foot"] {
            accept(&mut others, &message(label, frame), 1, at(frame));
        }
        for label in ["hip", "m0", "m1", "foot"] {
            accept(&mut mixed, &message(label, frame), 1, at(frame));
        }
    }
    assert_eq!((others.newest(), others.due()), (None, None));
    assert_eq!(others.counts(), Counts { other: 100, ..Counts::default() });
    let said = others.other_labels().unwrap();
    assert!(said.contains("the labels \"hip\", \"foot\", and none is a handle's"), "{said}");
    assert!(said.ends_with("expected labels such as \"m0\", \"m1\""), "{said}");
    mixed.close(at(50));
    assert_eq!(mixed.counts(), Counts { frames: 50, other: 100, ..Counts::default() });
    assert_eq!((mixed.newest().unwrap().positions[1], mixed.other_labels()), ([49.0; 3], None));
}

/// A message for a marker that no camera sees is no fault.
#[test]
fn a_message_with_nan_is_a_marker_that_is_not_seen() {
    let mut stream = stream(2).with_pattern("/marker/{label}".parse().unwrap());
    for frame in 0..12 {
        for (label, x) in [("m0", frame as f32), ("m1", f32::NAN)] {
            let x = x.to_be_bytes();
            accept(&mut stream, &message(&format!("/marker/{label}"), ",fff", &[&x, &x, &x]), 1, at(frame));
        }
    }
    stream.close(at(12) + 0.1);
    assert_eq!(stream.counts(), Counts { frames: 12, other: 12, ..Counts::default() });
    let newest = stream.newest().unwrap();
    assert_eq!((newest.positions, newest.confidence), (&[[11.0; 3], [9.0; 3]][..], &[1.0, 0.0][..]));
}

/// Who begins to listen in the middle of a frame has the sender's times from the first whole frame on.
#[test]
fn the_rest_of_a_frame_before_the_first_number_is_left_out() {
    let mut stream = stream(2).with_pattern("/marker/{label}".parse().unwrap());
    let marker = |j: usize, frame: i32| {
        let x = x(j, frame).to_be_bytes();
        message(&format!("/marker/m{j}"), ",fff", &[&x, &x, &x])
    };
    accept(&mut stream, &marker(1, 6), 1, 0.0);
    for frame in 7..10 {
        let arrived = at(frame - 6);
        accept(
            &mut stream,
            &bundle(&[head(frame, 50.0 + at(frame)), marker(0, frame), marker(1, frame)]),
            1,
            arrived,
        );
    }
    stream.close(1.0);
    is_whole(&stream, 9);
    let newest = stream.newest().unwrap();
    assert_eq!((newest.number, newest.time), (9, 50.0 + at(9)));
    assert_eq!(stream.counts(), Counts { frames: 3, ..Counts::default() });
}
