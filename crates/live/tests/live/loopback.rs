//! Tests through a socket.

use crate::{frame, labels};
use rhytid_core::{Error, NoProgress, Progress, RawTake, Take};
use rhytid_live::{Frame, Receiver, Sender, Stream, record};
use std::net::{SocketAddr, UdpSocket};
use std::thread;
use std::time::{Duration, Instant};

const LONG: Duration = Duration::from_secs(20);

fn any_port() -> SocketAddr {
    ([127, 0, 0, 1], 0).into()
}

fn receiver(markers: usize) -> Receiver {
    Receiver::bind(any_port(), &labels(markers), &vec![[0.0; 3]; markers]).unwrap()
}

/// A take of uneven numbers that `f32` represents exactly.
fn take(frames: usize, markers: usize, rate: f64) -> Take {
    let position =
        |i: usize| [(i as f32).sin(), (i as f32 * 0.7).cos() * 1e-3, i as f32 / 7.0].map(f64::from);
    Take {
        labels: labels(markers),
        times: (0..frames).map(|i| 3.0 + i as f64 / rate).collect(),
        positions: (0..frames * markers).map(position).collect(),
        ..Take::default()
    }
}

#[test]
fn a_take_arrives_whole_with_junk_between() {
    let sent = take(240, 90, 240.0);
    let mut receiver = receiver(90);
    let to = receiver.address();
    let recording = thread::scope(|scope| {
        scope.spawn(|| Sender::new(&sent, None, to).unwrap().send(Some(1), &NoProgress).unwrap());
        scope.spawn(|| {
            let socket = UdpSocket::bind(any_port()).unwrap();
            for i in 0..2_000_usize {
                let junk = vec![i as u8; i % 1_500];
                socket.send_to(&junk, to).unwrap();
                thread::sleep(Duration::from_micros(300));
            }
        });
        record(&mut receiver, 240, LONG, &|| false, &mut |_, _| (), &NoProgress).unwrap()
    });
    assert_eq!(recording.take.positions, sent.positions);
    assert_eq!(recording.take.confidence, None);
    let times = sent.times.iter().zip(&recording.take.times);
    assert!(times.clone().all(|(sent, came)| (sent - 3.0 - came).abs() < 1e-12));
    assert_eq!((recording.latency.len(), recording.unseen.len(), recording.timed_out), (240, 0, false));
    assert!(recording.latency.iter().all(|latency| (0.0..1.0).contains(latency)));
    let counts = receiver.counts();
    assert_eq!((counts.frames, counts.late, counts.lost), (240, 0, 0));
    assert!(counts.bad > 100, "{counts:?}");
}

#[test]
fn what_a_frame_lacks_is_not_sent_and_is_held_by_the_receiver() {
    let mut sent = take(4, 3, 100.0);
    sent.positions[3 + 1] = RawTake::MISSING;
    let mut receiver = receiver(3);
    Sender::new(&sent, Some(200.0), receiver.address()).unwrap().send(Some(2), &NoProgress).unwrap();
    let recording = record(&mut receiver, 8, LONG, &|| false, &mut |_, _| (), &NoProgress).unwrap();
    let came = recording.take;
    assert_eq!(came.positions[4], sent.positions[1]);
    assert_eq!(came.times, [0, 1, 2, 3, 4, 5, 6, 7].map(|i| f64::from(i) / 200.0));
    let confidence = came.confidence.unwrap();
    assert_eq!(confidence.iter().filter(|&&c| c < 1.0).count(), 2);
    assert_eq!(confidence[4], 0.99);
    assert_eq!(came.positions[12..16], sent.positions[..4]);
}

#[test]
fn the_newest_frame_is_there_without_waiting() {
    let mut receiver = receiver(1);
    assert!(receiver.newest().unwrap().is_none());
    let socket = UdpSocket::bind(any_port()).unwrap();
    for number in 0..5 {
        let datagram = frame(number, number as f64, 1).encode().unwrap();
        socket.send_to(&datagram, receiver.address()).unwrap();
    }
    let start = Instant::now();
    while receiver.newest().unwrap().is_none_or(|frame| frame.number < 4) {
        assert!(start.elapsed() < LONG);
    }
    assert_eq!(receiver.counts().frames, 5);
    // The newest frame stays.
    assert_eq!(receiver.newest().unwrap().unwrap().number, 4);
    assert!(receiver.next(Duration::from_millis(5)).unwrap().is_none());
}

#[test]
fn a_recording_ends_where_nothing_comes_and_is_an_error_where_nothing_ever_came() {
    let wait = Duration::from_millis(200);
    let mut receiver = receiver(1);
    let said = |receiver: &mut Receiver| {
        record(receiver, 9, wait, &|| false, &mut |_, _| (), &NoProgress).unwrap_err().to_string()
    };
    assert!(said(&mut receiver).contains("no datagram arrived"));
    let socket = UdpSocket::bind(any_port()).unwrap();
    socket.send_to(b"#bundle\0\0\0\0\0\0\0\0\x01", receiver.address()).unwrap();
    assert!(said(&mut receiver).contains("has no message that is read"));
    socket.send_to(&frame(0, 0.0, 1).encode().unwrap(), receiver.address()).unwrap();
    let recording = record(&mut receiver, 9, wait, &|| false, &mut |_, _| (), &NoProgress).unwrap();
    assert_eq!((recording.take.frames(), recording.timed_out), (1, true));
    let ended = record(&mut receiver, 9, LONG, &|| true, &mut |_, _| (), &NoProgress);
    assert!(matches!(ended, Err(Error::Cancelled)));
}

#[test]
fn addresses_that_cannot_be_listened_at_are_said() {
    let first = receiver(1);
    let said = |address| Receiver::bind(address, &labels(1), &[[0.0; 3]]).unwrap_err().to_string();
    assert!(said(first.address()).contains("another program listens there"));
    assert!(said(([192, 0, 2, 1], 0).into()).contains("no address of this machine"));
}

#[test]
fn a_sender_stops_when_it_is_told_to_and_refuses_what_it_cannot_send() {
    struct Stop;
    impl Progress for Stop {
        fn report(&self, _: &'static str, _: u64, _: u64) {}
        fn cancelled(&self) -> bool {
            true
        }
    }
    let to = receiver(1).address();
    let slow = take(2, 1, 0.001);
    assert_eq!(Sender::new(&slow, None, to).unwrap().send(None, &Stop).unwrap().frames, 0);
    let said = |take: &Take, rate| Sender::new(take, rate, to).unwrap_err().to_string();
    assert!(said(&Take::default(), None).contains("no frame"));
    assert!(said(&slow, Some(0.0)).contains("above 0"));
    assert!(said(&take(1, 2_000, 30.0), None).contains("at most 65507"));
}

/// Each frame is sent as two bundles with half of the markers each. A busy machine may stop the sender
/// between the two for longer than a frame waits, so there are some tries.
#[test]
fn two_bundles_a_frame_arrive_whole() {
    let (frames, markers) = (480, 90);
    let sent = take(frames, markers, 240.0);
    let mut said = String::new();
    for _ in 0..8 {
        let mut receiver = receiver(markers);
        let to = receiver.address();
        let recording = thread::scope(|scope| {
            scope.spawn(|| send_halves(&sent, to));
            let patience = Duration::from_secs(2);
            record(&mut receiver, frames, patience, &|| false, &mut |_, _| (), &NoProgress).unwrap()
        });
        let counts = receiver.counts();
        if (counts.frames, counts.late, counts.lost, counts.bad) != (frames as u64, 0, 0, 0) {
            said += &format!("{counts:?}; ");
            continue;
        }
        assert!(recording.take.positions == sent.positions, "other positions");
        assert_eq!(recording.take.confidence, None);
        return;
    }
    panic!("no try was whole: {said}");
}

/// Sends each frame of a take at 240 Hz as two bundles.
fn send_halves(sent: &Take, to: SocketAddr) {
    let socket = UdpSocket::bind(any_port()).unwrap();
    let (start, markers) = (Instant::now(), sent.labels.len());
    for (f, positions) in sent.positions.chunks(markers).enumerate() {
        let seconds = f as f64 / 240.0;
        thread::sleep(Duration::from_secs_f64(seconds).saturating_sub(start.elapsed()));
        let marker = |j: usize| (sent.labels[j].clone(), positions[j].map(|x| x as f32));
        for half in [0..markers / 2, markers / 2..markers] {
            let half = Frame { number: f as i64, seconds, markers: half.map(marker).collect() };
            socket.send_to(&half.encode().unwrap(), to).unwrap();
        }
    }
}

/// The sender's clock has its zero anywhere.
#[test]
fn a_recording_begins_at_time_0() {
    let mut receiver = receiver(1);
    let socket = UdpSocket::bind(any_port()).unwrap();
    for number in 0..4 {
        let sent = frame(number, 50.0 + number as f64 / 8.0, 1);
        socket.send_to(&sent.encode().unwrap(), receiver.address()).unwrap();
    }
    let mut seen = Vec::new();
    let came = record(
        &mut receiver,
        4,
        LONG,
        &|| false,
        &mut |frame, labels| seen.push((frame.time, labels.to_vec())),
        &NoProgress,
    );
    assert_eq!(came.unwrap().take.times, [0.0, 0.125, 0.25, 0.375]);
    assert_eq!(seen, [0.0, 0.125, 0.25, 0.375].map(|time| (time, labels(1))));
}

/// The rest of a frame has come while the receiver was stopped for longer than a frame waits.
#[test]
fn a_receiver_that_was_stopped_gives_whole_frames() {
    let mut receiver = receiver(2);
    let (address, socket) = (receiver.address(), UdpSocket::bind(any_port()).unwrap());
    let send = |number: i64, half: usize| {
        let whole = frame(number, number as f64 * 0.01, 2);
        let half = Frame { markers: vec![whole.markers[half].clone()], ..whole };
        socket.send_to(&half.encode().unwrap(), address).unwrap();
    };
    (0..2).for_each(|half| send(0, half));
    send(1, 0);
    assert_eq!(receiver.next(LONG).unwrap().unwrap().number, 0);
    assert!(receiver.next(Duration::from_millis(20)).unwrap().is_none());
    send(1, 1);
    thread::sleep(Duration::from_millis(200));
    let found = receiver.next(LONG).unwrap().unwrap();
    assert_eq!((found.number, found.confidence), (1, &[1.0, 1.0][..]));
    assert_eq!(receiver.counts().late, 0);
}

/// All markers are recorded where they are seen, under their own labels.
#[test]
fn a_stream_of_all_markers_has_those_of_the_cap() {
    let mut receiver = Receiver::listen(any_port(), Stream::of_all_markers()).unwrap();
    let mut sent = take(30, 3, 100.0);
    sent.positions[3 * 4 + 1] = RawTake::MISSING;
    sent.positions[..6].iter_mut().skip(2).step_by(3).for_each(|x| *x = RawTake::MISSING);
    Sender::new(&sent, None, receiver.address()).unwrap().send(Some(1), &NoProgress).unwrap();
    let came = record(&mut receiver, 30, LONG, &|| false, &mut |_, _| (), &NoProgress).unwrap().take;
    assert_eq!((&came.labels, came.confidence), (&sent.labels, None));
    for (a, b) in came.positions.iter().zip(&sent.positions) {
        assert!(a == b || a[0].is_nan() && b[0].is_nan(), "{a:?} {b:?}");
    }
}
