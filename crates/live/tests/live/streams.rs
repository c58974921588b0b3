//! Handling of datagrams, on a clock that the test sets.

use crate::{frame, labels};
use rhytid_live::{Counts, FADE, Frame, SILENCE, Stream};
use std::net::SocketAddr;

fn from(port: u16) -> SocketAddr {
    ([127, 0, 0, 1], port).into()
}

fn stream(markers: usize) -> Stream {
    Stream::new(&labels(markers), &vec![[9.0; 3]; markers])
}

/// No frames.
pub(crate) const NONE: [i64; 0] = [];

/// Gives a datagram to the stream. The result has the numbers of the frames that are then there.
pub(crate) fn accept(stream: &mut Stream, datagram: &[u8], port: u16, arrived: f64) -> Vec<i64> {
    let mut numbers = Vec::new();
    let mut is_new = stream.accept(datagram, from(port), arrived);
    while is_new {
        numbers.push(stream.newest().unwrap().number);
        is_new = stream.close(arrived);
    }
    numbers
}

/// Gives a frame to the stream as if from port 1, and waits a little. The result is whether it is there then.
fn give(stream: &mut Stream, frame: &Frame, arrived: f64) -> bool {
    let given = accept(stream, &frame.encode().unwrap(), 1, arrived);
    given.contains(&frame.number) || stream.close(arrived + 0.101)
}

#[test]
fn frames_that_come_late_or_twice_are_dropped_and_gaps_counted() {
    let mut stream = stream(2);
    assert_eq!(stream.due(), None);
    let order = [0, 1, 4, 2, 4, 5, 3, 6];
    let taken: Vec<i64> = order
        .into_iter()
        .enumerate()
        .flat_map(|(i, number)| {
            let datagram = frame(number, number as f64 * 0.01, 2).encode().unwrap();
            accept(&mut stream, &datagram, 1, i as f64 * 0.01)
        })
        .collect();
    assert_eq!(taken, [0, 1, 4, 5, 6]);
    // The number decides, and not the time.
    assert!(!give(&mut stream, &frame(5, 0.07, 2), 0.09));
    assert_eq!(stream.counts(), Counts { frames: 5, late: 4, lost: 2, bad: 0, other: 0 });
    let newest = stream.newest().unwrap();
    assert_eq!((newest.number, newest.time, newest.positions[0][0]), (6, 0.06, 6.1));
}

#[test]
fn a_marker_that_is_lost_is_held_and_fades() {
    let mut stream = stream(3);
    let with = |number: i64, seen: &[usize]| {
        let mut frame = frame(number, number as f64 * FADE / 4.0, 3);
        frame.markers = seen.iter().map(|&j| frame.markers[j].clone()).collect();
        frame
    };
    let mut confidence = |number: i64, seen: &[usize]| {
        assert!(give(&mut stream, &with(number, seen), number as f64 * 0.1));
        let newest = stream.newest().unwrap();
        // Marker 2 is never seen: it is at rest, with confidence 0.
        assert_eq!((newest.positions[2], newest.confidence[2]), ([9.0; 3], 0.0));
        assert_eq!(newest.confidence[0], 1.0);
        (newest.positions[1][0], newest.confidence[1])
    };
    assert_eq!(confidence(0, &[0, 1]), (0.1, 1.0));
    assert_eq!(confidence(1, &[0]), (0.1, 0.75));
    assert_eq!(confidence(2, &[0]), (0.1, 0.5));
    assert_eq!(confidence(3, &[0, 1]), (3.1, 1.0));
    assert_eq!(confidence(5, &[0]), (3.1, 0.5));
    assert_eq!(confidence(9, &[0]), (3.1, 0.0));
    assert_eq!(confidence(10, &[0, 1]), (10.1, 1.0));
}

#[test]
fn junk_and_other_senders_change_nothing() {
    let mut stream = stream(2);
    assert!(give(&mut stream, &frame(0, 0.0, 2), 0.0));
    assert!(give(&mut stream, &frame(1, 0.1, 2), 0.1));
    let before = format!("{:?}", stream.newest());
    let poison = frame(i64::MAX, 1e9, 2).encode().unwrap();
    let old = frame(0, 0.0, 2).encode().unwrap();
    for (bytes, port) in [(&b"junk"[..], 1), (&poison, 2), (&old, 2), (b"", 2), (&poison[..60], 1)] {
        assert!(!stream.accept(bytes, from(port), 0.15));
    }
    // A later number at an earlier time.
    assert!(!give(&mut stream, &frame(2, 0.05, 2), 0.15));
    assert_eq!(format!("{:?}", stream.newest()), before);
    assert!(give(&mut stream, &frame(2, 0.2, 2), 0.2));
    assert_eq!(stream.counts(), Counts { frames: 3, late: 0, lost: 0, bad: 6, other: 0 });
}

#[test]
fn after_a_silence_a_sender_may_begin_anew_and_times_go_on() {
    let mut stream = stream(1);
    assert!(give(&mut stream, &frame(1_000, 50.0, 1), 5.0));
    assert!(!give(&mut stream, &frame(0, 0.0, 1), 5.5));
    let again = 5.0 + SILENCE;
    assert_eq!(accept(&mut stream, &frame(0, 0.0, 1).encode().unwrap(), 2, again), NONE);
    assert_eq!(accept(&mut stream, &frame(2, 0.5, 1).encode().unwrap(), 2, again + 0.5), [0, 2]);
    let newest = stream.newest().unwrap();
    assert_eq!((newest.number, newest.time), (2, 50.0 + SILENCE + 0.5));
    assert_eq!(stream.counts(), Counts { frames: 3, late: 1, lost: 1, bad: 0, other: 0 });
    // A slow sender is not a new one.
    assert_eq!(accept(&mut stream, &frame(4, 5.0, 1).encode().unwrap(), 2, again + 5.0), [4]);
    assert_eq!(stream.counts().lost, 2);
}

#[test]
fn numbers_as_far_apart_as_can_be_are_counted_without_overflow() {
    let mut stream = stream(1);
    assert!(give(&mut stream, &frame(i64::MIN, 0.0, 1), 0.0));
    assert!(give(&mut stream, &frame(i64::MAX, 1.0, 1), 0.1));
    assert_eq!(stream.counts().lost, u64::MAX - 1);
}
